//! DARP: divide areas, then cover each by one robot.
//!
//! **Problem.** As `tmstc-star`: the slowest robot should be done as early as possible.
//! **Idea.** Give each robot a connected area around its start, all of one size: every block goes to the robot that is nearest
//! when distances are multiplied by a weight per robot; robots with too large an area get a larger weight, again and
//! again (`darp/areas.rs`). Then grow a tree in each area, the best of four kinds by time, and drive around it.
//! **Guarantee.** Areas are connected and hold everything. Equal sizes are a goal, not a promise: where a passage is shared,
//! there may be no equal areas at all.
//! **Complexity.** O(k n) for each of at most 2,000 rounds.
//! **Paper.** A. Kapoutsis, S. Chatzichristofis, E. Kosmatopoulos: DARP: divide areas algorithm for optimal multi-robot
//! coverage path planning. Journal of Intelligent & Robotic Systems 86, 2017.
//! **Departures.** Distances are ways on the ground, not straight lines. Parts that are cut off from their robot go to the area beside them, instead of a
//! second weight that grows with the distance from the connected part. A block weighs as much as it has cells to
//! visit. Robots in one block are refused, as by the authors' program.

mod areas;

use crate::{
    Instance, Plan, PlanError, PlanOptions,
    block_trees::{Block, Blocks, Forest, Pricing, Region, Tree, roots, routes},
    spanning_graph::Node,
};
use terrain::Direction;

const ALONG_ROWS: [Direction; 2] = [Direction::East, Direction::West];
const ALONG_COLUMNS: [Direction; 2] = [Direction::North, Direction::South];

/// Plans.
pub(super) fn plan(instance: &Instance<'_>, _options: &PlanOptions) -> Result<Plan, PlanError> {
    let blocks = Blocks::new(instance);
    let pricing = Pricing::new(instance, &blocks);
    let roots = roots(instance, &blocks)?;
    refuse_shared_blocks(&roots)?;
    let areas = areas::divide(instance, &blocks, &roots);
    let delays_s: Vec<f64> = instance.starts.iter().map(|start| start.available_in_s).collect();
    let mut forest = Forest::new(&blocks, &pricing, &roots, &delays_s);
    let mut number_of = vec![Node::MAX; blocks.len()];
    for (tree, area) in areas.iter().enumerate() {
        for (number, &block) in area.iter().enumerate() {
            number_of[block as usize] = number as Node;
        }
        let region = Region { blocks: &blocks, pricing: &pricing, members: area, number_of: &number_of };
        forest.plant(&pricing, area, &region.rooted(tree as Tree, &best_tree(&region)));
        for &block in area {
            number_of[block as usize] = Node::MAX;
        }
    }
    Ok(routes(instance, &blocks, &forest, &roots))
}

/// The best of four trees, by time.
fn best_tree(region: &Region<'_>) -> Vec<u8> {
    let trees = [
        region.kruskal(ALONG_ROWS),
        region.kruskal(ALONG_COLUMNS),
        region.depth_first(ALONG_ROWS),
        region.depth_first(ALONG_COLUMNS),
    ];
    let best = trees.into_iter().min_by(|a, b| region.seconds(a).total_cmp(&region.seconds(b)));
    best.expect("there are four")
}

fn refuse_shared_blocks(roots: &[Block]) -> Result<(), PlanError> {
    for (robot, root) in roots.iter().enumerate() {
        if let Some(other) = roots[..robot].iter().position(|other| other == root) {
            let reason = format!(
                "robots {other} and {robot} start in one block of 2 × 2 cells, and areas cannot share one; `mfc` and \
                 `forest-search` can"
            );
            return Err(PlanError::Unsupported { planner: "darp", reason });
        }
    }
    Ok(())
}
