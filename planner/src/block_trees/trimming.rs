//! What of the walks need not be driven.

use crate::{Instance, Mode};
use terrain::Cell;

/// Leaves out walks that cover nothing that is not covered by others, and where nobody returns, the ends behind the
/// last cell that is. Each walk is driven in the direction that takes less time. The slowest robots come first.
pub(crate) fn trim(instance: &Instance<'_>, walks: Vec<Vec<Cell>>) -> Vec<Vec<Cell>> {
    let mut passed = Passed::new(instance, &walks);
    let time_s = |robot: usize, walk: &[Cell]| {
        let points: Vec<_> = walk.iter().map(|&cell| instance.center(cell)).collect();
        instance.path_s(&points, instance.starts[robot].heading_rad)
    };
    let mut order: Vec<(f64, usize)> =
        walks.iter().enumerate().map(|(robot, walk)| (time_s(robot, walk), robot)).collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut walks = walks;
    for (_, robot) in order {
        let there = std::mem::take(&mut walks[robot]);
        let back: Vec<Cell> = there.iter().rev().copied().collect();
        let keep = [passed.keep(&there), passed.keep(&back)];
        let times_s = [time_s(robot, &there[..keep[0]]), time_s(robot, &back[..keep[1]])];
        let (mut walk, keep) = if times_s[1] < times_s[0] { (back, keep[1]) } else { (there, keep[0]) };
        walk[keep..].iter().for_each(|&cell| passed.forget(cell));
        walk.truncate(keep);
        walks[robot] = walk;
    }
    walks
}

/// Row-major: how often all walks pass a cell.
struct Passed<'a> {
    instance: &'a Instance<'a>,
    times: Vec<u32>,
}

impl<'a> Passed<'a> {
    fn new(instance: &'a Instance<'a>, walks: &[Vec<Cell>]) -> Self {
        let mut passed = Self { instance, times: vec![0; instance.floor.lattice().len()] };
        for &cell in walks.iter().flatten() {
            let index = passed.index(cell);
            passed.times[index] += 1;
        }
        passed
    }

    fn index(&self, cell: Cell) -> usize {
        self.instance.floor.lattice().index(cell).expect("walks stay on the lattice")
    }

    fn forget(&mut self, cell: Cell) {
        let index = self.index(cell);
        self.times[index] -= 1;
    }

    /// How many cells from the front are to be driven.
    fn keep(&mut self, walk: &[Cell]) -> usize {
        let mut keep = walk.len();
        // Forgets the end cell by cell, and remembers it again.
        while keep > 0 {
            let index = self.index(walk[keep - 1]);
            if self.instance.visit[index] && self.times[index] == 1 {
                break;
            }
            self.times[index] -= 1;
            keep -= 1;
        }
        for &cell in &walk[keep..] {
            let index = self.index(cell);
            self.times[index] += 1;
        }
        if self.instance.mode == Mode::CoverAndReturn && keep > 0 { walk.len() } else { keep }
    }
}
