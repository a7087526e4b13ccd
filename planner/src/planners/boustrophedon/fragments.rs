//! The small cells from which a decomposition is put together: the cuts of two sweeps, one square to the other, laid
//! over each other, and what of the fragments touches.

use super::{
    directions::neighbours,
    line_sweep::{Least, cell_raster},
    raster::{NONE, Raster, Run},
};
use std::{
    collections::{BTreeMap, VecDeque},
    f64::consts::FRAC_PI_2,
};

/// Which fragments touch, and along how many squares.
#[derive(Debug, Clone, Default)]
pub(super) struct Adjacency {
    /// Per fragment its neighbours, in order, with the length of the common border.
    pub(super) of: Vec<Vec<(u32, u32)>>,
}

/// Fragments as seen in some directions.
#[derive(Debug)]
pub(super) struct Fragments {
    pub(super) adjacency: Adjacency,
    /// Directions of lanes that are tried, radians.
    pub(super) angles_rad: Vec<f64>,
    /// Per direction: the fragments' numbers in rows along it.
    pub(super) rasters: Vec<Raster>,
    /// Per direction and fragment: row and run of it, in order.
    runs: Vec<Vec<Vec<(u32, Run)>>>,
}

impl Fragments {
    /// Lays the cuts of lanes along the rows of `ground` and across them over each other. What is less than `least`
    /// makes no cell of its own. The first of `angles_rad` is that of the rows.
    pub(super) fn of_two_sweeps(ground: &Raster, angles_rad: &[f64], least: Least) -> Self {
        let along = cell_raster(ground, least);
        let across = cell_raster(&ground.turned(angles_rad[0] + FRAC_PI_2), least);
        Self::seen_along(angles_rad, &overlay(&along, &across, least.area))
    }

    /// The cells of one sweep, along the rows of `ground`.
    pub(super) fn of_one_sweep(ground: &Raster, angles_rad: &[f64], least: Least) -> Self {
        Self::seen_along(angles_rad, &renumbered(cell_raster(ground, least), least.area))
    }

    fn seen_along(angles_rad: &[f64], raster: &Raster) -> Self {
        let labels = raster.labels().iter().filter(|&&label| label != NONE);
        let count = labels.max().map_or(0, |&most| most as usize + 1);
        let rasters: Vec<Raster> = angles_rad.iter().map(|&angle| raster.turned(angle)).collect();
        let runs = rasters.iter().map(|raster| runs_of(raster, count)).collect();
        Self { adjacency: Adjacency::new(raster, count), angles_rad: angles_rad.to_vec(), rasters, runs }
    }

    pub(super) fn len(&self) -> usize {
        self.adjacency.of.len()
    }

    /// Some fragments together as rows, torn or not.
    pub(super) fn union(&self, members: &[u32], direction: usize) -> Union {
        Union { rows: self.rows(members, direction) }
    }

    fn rows(&self, members: &[u32], direction: usize) -> Vec<Row> {
        let of = &self.runs[direction];
        let mut all: Vec<(u32, Run)> =
            members.iter().flat_map(|&member| of[member as usize].iter().copied()).collect();
        all.sort_unstable_by_key(|(row, run)| (*row, run.from));
        let mut rows: Vec<Row> = Vec::new();
        for (row, run) in all {
            match rows.last_mut() {
                Some(last) if last.row == row => {
                    last.torn = last.torn.max(run.from - last.span.to.min(run.from));
                    last.span.to = last.span.to.max(run.to);
                }
                _ => rows.push(Row { row, span: run, torn: 0 }),
            }
        }
        rows
    }
}

/// What some fragments take of a row.
#[allow(clippy::struct_field_names, reason = "a row has a number, and that is called its row")]
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    pub(super) row: u32,
    /// From the leftmost to the rightmost square.
    pub(super) span: Run,
    /// The widest gap, squares.
    torn: u32,
}

/// Fragments together, row by row.
#[derive(Debug, Clone)]
pub(super) struct Union {
    pub(super) rows: Vec<Row>,
}

impl Union {
    /// Extent across the lanes, squares.
    pub(super) fn altitude(&self) -> u32 {
        self.rows.first().zip(self.rows.last()).map_or(0, |(first, last)| last.row - first.row + 1)
    }

    /// Whether lanes along the rows cross nothing else: no row is torn by more than `tolerance` squares, and each overlaps the
    /// one before. The outer `tolerance` rows on either side, along ragged walls, may be torn.
    pub(super) fn is_monotone(&self, tolerance: u32) -> bool {
        let rows = self.core(tolerance);
        let whole = rows.iter().all(|row| row.torn <= tolerance);
        let linked = rows
            .windows(2)
            .all(|pair| pair[1].row - pair[0].row <= 1 + tolerance && pair[0].span.touches(&pair[1].span));
        whole && linked && !rows.is_empty()
    }

    /// Without torn outer rows, of which at most `most` are left out on either side.
    pub(super) fn core(&self, most: u32) -> &[Row] {
        let torn = |row: &Row| row.torn > most;
        let (Some(first), Some(last)) = (self.rows.first(), self.rows.last()) else { return &[] };
        let inner = |row: &Row| !torn(row) || row.row - first.row >= most && last.row - row.row >= most;
        let from = self.rows.iter().position(inner).unwrap_or(0);
        let to = self.rows.iter().rposition(inner).map_or(self.rows.len(), |at| at + 1);
        &self.rows[from..to]
    }
}

impl Adjacency {
    fn new(raster: &Raster, count: usize) -> Self {
        let mut shared: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        let (columns, labels) = (raster.columns(), raster.labels());
        for at in 0..labels.len() {
            let right = ((at + 1) % columns > 0).then_some(at + 1);
            let above = (at + columns < labels.len()).then_some(at + columns);
            for next in [right, above].into_iter().flatten() {
                let (one, other) = (labels[at].min(labels[next]), labels[at].max(labels[next]));
                if one != other && other != NONE {
                    *shared.entry((one, other)).or_default() += 1;
                }
            }
        }
        let mut of = vec![Vec::new(); count];
        for ((one, other), length) in shared {
            of[one as usize].push((other, length));
            of[other as usize].push((one, length));
        }
        for list in &mut of {
            list.sort_unstable();
        }
        Self { of }
    }
}

fn runs_of(raster: &Raster, count: usize) -> Vec<Vec<(u32, Run)>> {
    let mut runs = vec![Vec::new(); count];
    for (row, slice) in raster.slices().into_iter().enumerate() {
        for run in slice {
            runs[run.label as usize].push((row as u32, run));
        }
    }
    runs
}

/// Connected pieces of squares that share both their cells. Small pieces go to what is beside them.
fn overlay(along: &Raster, across: &Raster, least_area: u32) -> Raster {
    let mut pairs: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    let across = Raster::new(*along.frame(), |point| across.label_at(point));
    let mut both = along.clone();
    for (one, &other) in both.labels_mut().iter_mut().zip(across.labels()) {
        if *one != NONE && other != NONE {
            let next = pairs.len() as u32;
            *one = *pairs.entry((*one, other)).or_insert(next);
        } else {
            *one = NONE;
        }
    }
    renumbered(both, least_area)
}

/// Connected pieces of one label, numbered in the order of their first squares. Small pieces take the label of what is
/// beside them; small ones with nothing beside them are left out.
fn renumbered(mut raster: Raster, least_area: u32) -> Raster {
    let (columns, squares) = (raster.columns(), raster.labels().len());
    let old = raster.labels().to_vec();
    let labels = raster.labels_mut();
    labels.fill(NONE);
    let mut seen = vec![false; squares];
    let mut count = 0;
    for first in 0..squares {
        if old[first] == NONE || seen[first] {
            continue;
        }
        let piece = connected(first, &old, &mut seen, columns);
        if piece.len() >= least_area as usize {
            for &square in &piece {
                labels[square] = count;
            }
            count += 1;
        }
    }
    grow(labels, &old, columns);
    raster
}

fn connected(first: usize, labels: &[u32], seen: &mut [bool], columns: usize) -> Vec<usize> {
    let mut piece = vec![first];
    seen[first] = true;
    let mut next = 0;
    while next < piece.len() {
        for square in neighbours(piece[next], columns, labels.len()) {
            if labels[square] == labels[first] && !seen[square] {
                seen[square] = true;
                piece.push(square);
            }
        }
        next += 1;
    }
    piece
}

/// Spreads labels evenly over the ground that has none.
fn grow(labels: &mut [u32], ground: &[u32], columns: usize) {
    let mut queue: VecDeque<usize> = (0..labels.len()).filter(|&square| labels[square] != NONE).collect();
    while let Some(at) = queue.pop_front() {
        for next in neighbours(at, columns, ground.len()) {
            if ground[next] != NONE && labels[next] == NONE {
                labels[next] = labels[at];
                queue.push_back(next);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planners::boustrophedon::raster::tests::drawn;

    const HALL: &str = "000000\n000000\n00..00\n00..00\n000000";

    #[test]
    fn cuts_both_ways_make_a_fragment_of_each_corner() {
        let fragments = Fragments::of_two_sweeps(&drawn(HALL), &[0.0], Least::default());
        assert_eq!(fragments.len(), 8, "four corners and four sides");
        assert!(fragments.adjacency.of.iter().all(|beside| beside.len() == 2));
    }

    #[test]
    fn a_union_is_monotone_in_one_direction_and_not_in_the_other() {
        // Fragments of one sweep: below, left, right, above.
        let fragments = Fragments::of_one_sweep(&drawn(HALL), &[0.0], Least::default());
        assert_eq!(fragments.len(), 4);
        let is_monotone = |members: &[u32], tolerance| fragments.union(members, 0).is_monotone(tolerance);
        assert!(is_monotone(&[0, 1], 0), "a row below, then the left one");
        assert!(!is_monotone(&[1, 2], 0), "the pillar tears these rows");
        assert!(is_monotone(&[1, 2], 2), "unless it is small enough");
        assert!(!is_monotone(&[0, 3], 0), "rows are missing between them");
        assert_eq!(fragments.union(&[0, 1, 3], 0).altitude(), 5);
    }

    #[test]
    fn small_fragments_go_to_their_neighbours() {
        let fragments = Fragments::of_two_sweeps(&drawn(HALL), &[0.0], Least { area: 3, rows: 0 });
        let area = |label| fragments.rasters[0].labels().iter().filter(|&&found| found == label).count();
        let areas: Vec<usize> = (0..fragments.len() as u32).map(area).collect();
        assert_eq!(areas.iter().sum::<usize>(), 24, "two squares below the pillar are no cell across");
        assert!(areas.iter().all(|&area| area >= 3), "{areas:?}");
    }
}
