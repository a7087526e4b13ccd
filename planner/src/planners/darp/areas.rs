//! Connected areas of equal size, one around each robot.

use crate::{
    Instance,
    block_trees::{Block, Blocks},
};
use std::collections::VecDeque;

const ROUNDS: u32 = 2_000;
/// How far weights move in the first round and in the last one.
const STEPS: [f64; 2] = [0.2, 0.002];

const NOBODY: u32 = u32::MAX;

/// Per robot the blocks of its area, its own first; blocks behind which nothing is to be visited are left out.
pub(super) fn divide(instance: &Instance<'_>, blocks: &Blocks, roots: &[Block]) -> Vec<Vec<Block>> {
    let distances: Vec<Vec<f64>> = roots.iter().map(|&root| steps_from(blocks, root)).collect();
    let work = work(instance, blocks);
    let target = targets(&distances, &work, roots);
    let mut weights = vec![0.0_f64; roots.len()];
    let mut best: (f64, Vec<u32>) = (f64::INFINITY, Vec::new());
    for round in 0..ROUNDS {
        let owners = connected(blocks, roots, &nearest(&distances, &weights));
        let sizes = sizes(&owners, &work, roots.len());
        let excess = |robot: usize| (sizes[robot] - target[robot]) / target[robot].max(1.0);
        let worst = (0..roots.len()).map(excess).fold(0.0, f64::max);
        if worst < best.0 {
            best = (worst, owners);
        }
        // Sizes are whole blocks: one block more than the others is as equal as can be.
        if (0..roots.len()).all(|robot| sizes[robot] - target[robot] < 4.0) {
            break;
        }
        let progress = f64::from(round) / f64::from(ROUNDS);
        let step = STEPS[0] * (STEPS[1] / STEPS[0]).powf(progress);
        for (robot, weight) in weights.iter_mut().enumerate() {
            *weight += step * excess(robot).clamp(-1.0, 1.0);
        }
    }
    (0..roots.len()).map(|robot| area(blocks, &work, &best.1, roots[robot], robot as u32)).collect()
}

/// Per block: cells to visit in it.
fn work(instance: &Instance<'_>, blocks: &Blocks) -> Vec<f64> {
    let lattice = instance.floor.lattice();
    let visited = |cell| lattice.index(cell).is_some_and(|index| instance.visit[index]);
    let count =
        |cells: &[Option<terrain::Cell>; 4]| cells.iter().flatten().filter(|&&cell| visited(cell)).count();
    blocks.cells.iter().map(|cells| count(cells) as f64).collect()
}

/// Per robot: the work on its connected ground by the number of robots there.
fn targets(distances: &[Vec<f64>], work: &[f64], roots: &[Block]) -> Vec<f64> {
    let target = |distance: &Vec<f64>| {
        let own: f64 =
            (0..work.len()).filter(|&block| distance[block].is_finite()).map(|block| work[block]).sum();
        let mates = roots.iter().filter(|&&root| distance[root as usize].is_finite()).count();
        own / mates as f64
    };
    distances.iter().map(target).collect()
}

/// Per block: joints from a block to it; infinite where there is no way.
fn steps_from(blocks: &Blocks, root: Block) -> Vec<f64> {
    let mut steps = vec![f64::INFINITY; blocks.len()];
    steps[root as usize] = 0.0;
    let mut queue = VecDeque::from([root]);
    while let Some(at) = queue.pop_front() {
        for joint in &blocks.joints[at as usize] {
            if steps[joint.other as usize].is_infinite() {
                steps[joint.other as usize] = steps[at as usize] + 1.0;
                queue.push_back(joint.other);
            }
        }
    }
    steps
}

/// Per block: the robot with the least weighted distance.
fn nearest(distances: &[Vec<f64>], weights: &[f64]) -> Vec<u32> {
    let factors: Vec<f64> = weights.iter().map(|weight| weight.exp()).collect();
    let mut owners = vec![NOBODY; distances.first().map_or(0, Vec::len)];
    let mut least = vec![f64::INFINITY; owners.len()];
    for (robot, (own, factor)) in distances.iter().zip(&factors).enumerate() {
        for (block, steps) in own.iter().enumerate() {
            if steps * factor < least[block] {
                least[block] = steps * factor;
                owners[block] = robot as u32;
            }
        }
    }
    owners
}

/// Gives what is cut off from its robot to the areas around it.
fn connected(blocks: &Blocks, roots: &[Block], owners: &[u32]) -> Vec<u32> {
    let mut attached = vec![NOBODY; owners.len()];
    let mut order: Vec<Block> = Vec::with_capacity(owners.len());
    for (robot, &root) in roots.iter().enumerate() {
        attached[root as usize] = robot as u32;
        order.push(root);
    }
    // First what hangs together by itself, then everything else, each from where it is reached.
    for own_only in [true, false] {
        let mut next = 0;
        while let Some(&at) = order.get(next) {
            next += 1;
            for joint in &blocks.joints[at as usize] {
                let other = joint.other as usize;
                let free = attached[other] == NOBODY;
                if free && (!own_only || owners[other] == attached[at as usize]) {
                    attached[other] = attached[at as usize];
                    order.push(joint.other);
                }
            }
        }
    }
    attached
}

fn sizes(owners: &[u32], work: &[f64], robots: usize) -> Vec<f64> {
    let mut sizes = vec![0.0; robots];
    for (&owner, work) in owners.iter().zip(work) {
        if owner != NOBODY {
            sizes[owner as usize] += work;
        }
    }
    sizes
}

/// The blocks of one robot, breadth first, without branches that hold no work.
fn area(blocks: &Blocks, work: &[f64], owners: &[u32], root: Block, robot: u32) -> Vec<Block> {
    let mut order = vec![(root, root)];
    let mut seen = vec![false; blocks.len()];
    seen[root as usize] = true;
    let mut next = 0;
    while let Some(&(at, _)) = order.get(next) {
        next += 1;
        for joint in &blocks.joints[at as usize] {
            if owners[joint.other as usize] == robot
                && !std::mem::replace(&mut seen[joint.other as usize], true)
            {
                order.push((joint.other, at));
            }
        }
    }
    let mut leads_on = vec![false; blocks.len()];
    let mut kept: Vec<Block> = Vec::new();
    for &(block, parent) in order.iter().rev() {
        if work[block as usize] > 0.0 || leads_on[block as usize] || block == root {
            leads_on[parent as usize] = true;
            kept.push(block);
        }
    }
    kept.reverse();
    kept
}
