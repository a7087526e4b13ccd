//! One closed tour over lines, each driven from either end.

use super::lines::Line;
use crate::{Instance, shortest_way::moves_from};
use terrain::Cell;

/// Beyond so many lines ways are estimated as on an empty lattice.
const EXACT_LINES: usize = 600;
/// Beyond so many lines the tour is not improved.
const IMPROVED_LINES: usize = 4_000;
/// Passes over the tour, at most.
const PASSES: usize = 30;

/// The cells of the lines in the order of the tour.
pub(super) fn tour(instance: &Instance<'_>, lines: &[Line]) -> Vec<Cell> {
    let ways = Ways::new(instance, lines);
    let mut order = nearest_first(&ways);
    if lines.len() <= IMPROVED_LINES {
        for _ in 0..PASSES {
            let better = two_opt(&ways, &mut order) | move_lines(&ways, &mut order);
            if !better {
                break;
            }
        }
    }
    let mut cells = Vec::new();
    for stop in order {
        let line = &lines[stop.line()];
        if stop.is_backwards() {
            cells.extend(line.iter().rev());
        } else {
            cells.extend(line);
        }
    }
    cells
}

/// A line and the end it is entered by: 2 × number + 1 when by its last cell.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stop(usize);

impl Stop {
    fn line(self) -> usize {
        self.0 / 2
    }

    fn is_backwards(self) -> bool {
        self.0 % 2 == 1
    }

    /// The end at which it is left; ends are numbered as stops.
    fn exit(self) -> usize {
        self.0 ^ 1
    }

    fn turned(self) -> Self {
        Self(self.0 ^ 1)
    }
}

/// Moves between ends of lines.
struct Ways {
    ends: Vec<Cell>,
    /// End by end; empty when they are estimated.
    moves: Vec<u32>,
}

impl Ways {
    fn new(instance: &Instance<'_>, lines: &[Line]) -> Self {
        let ends: Vec<Cell> = lines.iter().flat_map(|line| [line[0], line[line.len() - 1]]).collect();
        let lattice = instance.floor.lattice();
        let mut moves = Vec::new();
        if lines.len() <= EXACT_LINES {
            for &end in &ends {
                let from_end = moves_from(instance, end);
                let index = |cell: &Cell| lattice.index(*cell).expect("ends are on the lattice");
                moves.extend(ends.iter().map(|cell| from_end[index(cell)]));
            }
        }
        Self { ends, moves }
    }

    fn lines(&self) -> usize {
        self.ends.len() / 2
    }

    /// Moves from the exit of one stop to the entry of the next one.
    fn between(&self, from: Stop, to: Stop) -> i64 {
        let (from, to) = (from.exit(), to.0);
        if self.moves.is_empty() {
            i64::from(self.ends[from].manhattan(self.ends[to]))
        } else {
            i64::from(self.moves[from * self.ends.len() + to])
        }
    }
}

fn nearest_first(ways: &Ways) -> Vec<Stop> {
    let mut left: Vec<usize> = (1..ways.lines()).collect();
    let mut order = vec![Stop(0)];
    while !left.is_empty() {
        let last = order[order.len() - 1];
        let (place, stop) = left
            .iter()
            .enumerate()
            .flat_map(|(place, &line)| [(place, Stop(2 * line)), (place, Stop(2 * line + 1))])
            .min_by_key(|&(_, stop)| (ways.between(last, stop), stop.0))
            .expect("some line is left");
        left.swap_remove(place);
        order.push(stop);
    }
    order
}

/// Turns stretches of the tour round where that is shorter; whether anything was.
fn two_opt(ways: &Ways, order: &mut [Stop]) -> bool {
    let count = order.len();
    let mut better = false;
    for first in 1..count {
        for last in first..count {
            let (before, after) = (order[first - 1], order[(last + 1) % count]);
            let closed = last + 1 == count && first == 1;
            if closed {
                continue;
            }
            let now = ways.between(before, order[first]) + ways.between(order[last], after);
            let then =
                ways.between(before, order[last].turned()) + ways.between(order[first].turned(), after);
            if then < now {
                order[first..=last].reverse();
                for stop in &mut order[first..=last] {
                    *stop = stop.turned();
                }
                better = true;
            }
        }
    }
    better
}

/// Puts single lines elsewhere where that is shorter, either way round; whether anything was.
fn move_lines(ways: &Ways, order: &mut Vec<Stop>) -> bool {
    let count = order.len();
    let mut better = false;
    for place in 1..count.saturating_sub(1) {
        let stop = order[place];
        let (before, after) = (order[place - 1], order[place + 1]);
        let saved = ways.between(before, stop) + ways.between(stop, after) - ways.between(before, after);
        let added = |gap: usize, stop: Stop| {
            let (one, other) = (order[gap], order[(gap + 1) % count]);
            ways.between(one, stop) + ways.between(stop, other) - ways.between(one, other)
        };
        let found = (0..count)
            .filter(|&gap| gap != place && gap + 1 != place)
            .flat_map(|gap| [(added(gap, stop), gap, stop), (added(gap, stop.turned()), gap, stop.turned())])
            .min_by_key(|&(added, gap, stop)| (added, gap, stop.0));
        if let Some((added, gap, stop)) = found.filter(|&(added, ..)| added < saved) {
            debug_assert!(added < saved, "the tour gets shorter");
            order.remove(place);
            let gap = if gap > place { gap - 1 } else { gap };
            order.insert(gap + 1, stop);
            better = true;
        }
    }
    better
}
