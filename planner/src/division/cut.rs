//! A division that is driven: true times, and small changes that make them smaller.

use super::{Run, Sequence, Team, route_s};
use crate::{Instance, Mode, PlanError, Route, shortest_way::WayFinder};
use terrain::Cell;

/// Changes tried, at most.
const TRIALS: usize = 120;
/// Beyond so many cells a trial takes too long.
const CELLS_MAX: usize = 40_000;

/// Runs and the routes over them.
pub(super) struct Cut {
    /// Per member of the team.
    pub(super) driven: Vec<(f64, Route)>,
    runs: Vec<Option<Run>>,
}

impl Cut {
    pub(super) fn drive(
        team: &Team<'_>,
        sequence: &Sequence,
        runs: Vec<Option<Run>>,
        finder: &mut WayFinder,
    ) -> Result<Self, PlanError> {
        let driven = (0..runs.len())
            .map(|member| timed_route(team, member, sequence, runs[member].as_ref(), finder))
            .collect::<Result<_, _>>()?;
        Ok(Self { driven, runs })
    }

    pub(super) fn makespan_s(&self) -> f64 {
        self.driven.iter().map(|&(seconds, _)| seconds).fold(0.0, f64::max)
    }

    /// Moves cuts beside the slowest robot's run, or changes it for another robot's, as long as that helps.
    pub(super) fn improve(
        &mut self,
        team: &Team<'_>,
        sequence: &Sequence,
        finder: &mut WayFinder,
    ) -> Result<(), PlanError> {
        let mut trials = if sequence.cells.len() > CELLS_MAX { 0 } else { TRIALS };
        'better: loop {
            let slowest = (0..self.driven.len())
                .max_by(|&a, &b| self.driven[a].0.total_cmp(&self.driven[b].0))
                .expect("a team has members");
            for (other, runs) in self.changes(slowest, sequence.cells.len()) {
                if trials == 0 {
                    return Ok(());
                }
                trials -= 1;
                let one = timed_route(team, slowest, sequence, Some(&runs[0]), finder)?;
                let another = timed_route(team, other, sequence, Some(&runs[1]), finder)?;
                if one.0.max(another.0) < self.driven[slowest].0 - 1e-6 {
                    for (member, run, driven) in [(slowest, &runs[0], one), (other, &runs[1], another)] {
                        self.runs[member] = Some(run.clone());
                        self.driven[member] = driven;
                    }
                    continue 'better;
                }
            }
            return Ok(());
        }
    }

    /// Other runs for a robot and one more: a piece of its run to the neighbour before or behind, or the whole runs
    /// changed.
    fn changes(&self, member: usize, count: usize) -> Vec<(usize, [Run; 2])> {
        let Some(own) = self.runs[member].clone() else { return Vec::new() };
        let mut changes = Vec::new();
        for (other, run) in self.runs.iter().enumerate().filter(|&(other, _)| other != member) {
            let Some(run) = run.clone() else { continue };
            for piece in [64, 16, 4, 1] {
                if piece >= own.len() {
                    continue;
                }
                if own.end % count == run.start % count {
                    let taken = run.start.wrapping_add(count) - piece;
                    let longer = taken..taken + piece + run.len();
                    changes.push((other, [own.start..own.end - piece, longer]));
                } else if run.end % count == own.start % count {
                    changes.push((other, [own.start + piece..own.end, run.start..run.end + piece]));
                }
            }
            changes.push((other, [run, own.clone()]));
        }
        changes
    }
}

fn timed_route(
    team: &Team<'_>,
    member: usize,
    sequence: &Sequence,
    run: Option<&Run>,
    finder: &mut WayFinder,
) -> Result<(f64, Route), PlanError> {
    let Some(run) = run else { return Ok((0.0, Route::default())) };
    let robot = team.robots[member];
    let count = sequence.cells.len();
    let forwards: Vec<Cell> = run.clone().map(|number| sequence.cells[number % count]).collect();
    let backwards: Vec<Cell> = forwards.iter().rev().copied().collect();
    let there = drive(team.instance, robot, &forwards, finder)?;
    let back = drive(team.instance, robot, &backwards, finder)?;
    let start = &team.instance.starts[robot];
    let seconds = |route: &Route| route_s(team.instance, start, route);
    let times_s = [seconds(&there), seconds(&back)];
    Ok(if times_s[1] < times_s[0] { (times_s[1], back) } else { (times_s[0], there) })
}

fn drive(
    instance: &Instance<'_>,
    robot: usize,
    cells: &[Cell],
    finder: &mut WayFinder,
) -> Result<Route, PlanError> {
    let start = instance.starts[robot].cell;
    let mut way = vec![start];
    for &cell in cells {
        let from = *way.last().expect("it begins with the start");
        finder.go(instance, from, cell, &mut way)?;
    }
    if instance.mode == Mode::CoverAndReturn {
        let from = *way.last().expect("it begins with the start");
        finder.go(instance, from, start, &mut way)?;
    }
    Ok(Route::new(way.into_iter().map(|cell| instance.center(cell)).collect()))
}
