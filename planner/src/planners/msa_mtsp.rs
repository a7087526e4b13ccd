//! Coverage lines and a multi-robot tour over them.
//!
//! **Problem.** As `tmstc-star`.
//! **Idea.** Cover the floor by straight lines of single cells, as few as possible: the fewest bricks of width one
//! (`bricks.rs`, on cells). Join the lines to one tour: nearest line first, then 2-opt and moves of single lines, each line to
//! be driven either way. Divide the tour among the robots by time (`division.rs`).
//! **Guarantee.** Every cell lies on exactly one line; the lines are as few as they can be. None on the tour.
//! **Complexity.** O(n √n) for the lines, O(l n) for the ways between l lines, O(l²) for each pass over the tour.
//! **Paper.** I. Vandermeulen, R. Groß, A. Kolling: Turn-minimizing multirobot coverage. IEEE International Conference on Robotics and
//! Automation (ICRA), 2019; a baseline of the TMSTC* paper. Minimum sum of altitudes: W. H. Huang: Optimal
//! line-sweep-based decompositions for coverage algorithms. ICRA, 2001.
//! **Departures.** The lines are a minimum, where the paper has a heuristic; the tour of all robots is one tour, divided, where the paper
//! has a genetic algorithm for several tours.

mod lines;
mod tour;

use crate::{Instance, Plan, PlanError, PlanOptions, division::divide};

/// Plans.
pub(super) fn plan(instance: &Instance<'_>, _options: &PlanOptions) -> Result<Plan, PlanError> {
    let component = instance.components();
    let lines = lines::lines(instance);
    let piece = |line: &lines::Line| {
        let index = instance.floor.lattice().index(line[0]).expect("lines lie on the lattice");
        component[index]
    };
    let mut numbers: Vec<u32> = lines.iter().map(piece).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let tours = numbers.into_iter().map(|number| {
        let own: Vec<lines::Line> = lines.iter().filter(|line| piece(line) == number).cloned().collect();
        tour::tour(instance, &own)
    });
    divide(instance, tours.collect())
}
