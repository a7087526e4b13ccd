//! Boustrophedon cells by a line sweep: a line runs over the ground, and a cell lasts as long as its slice stays one.
//!
//! ```text
//!     ┌───────────┐
//!     │     3     │     IN  (split):  0 ends where an obstacle begins, 1 and 2 begin
//!     │   ┌───┐   │     OUT (merge):  1 and 2 end where it ends, 3 begins
//!     │ 1 │   │ 2 │
//!     │   └───┘   │     An event is a row in which "overlaps the run before" stops being one to one.
//!     │     0     │
//!     └───────────┘
//! ```

use super::raster::{NONE, Raster, Run};

/// A piece of ground that each row meets in one run: rows `first_row..` one after another.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SweptCell {
    first_row: u32,
    runs: Vec<Run>,
    /// Runs that its first row touches below it, and its last row above it.
    touches: [usize; 2],
}

/// What is less is no cell.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Least {
    /// Number of squares.
    pub(super) area: u32,
    /// Number of rows, of pockets.
    pub(super) rows: u32,
}

impl SweptCell {
    fn is_less_than(&self, least: Least) -> bool {
        let is_pocket = matches!(self.touches, [0, 1] | [1, 0]);
        self.area() < least.area || is_pocket && self.runs.len() < least.rows as usize
    }

    /// Number of squares.
    fn area(&self) -> u32 {
        self.runs.iter().map(Run::length).sum()
    }
}

/// The cells of all ground that is labelled, whatever the label; `label` of a run is the number of its cell.
pub(super) fn cells(ground: &Raster) -> Vec<SweptCell> {
    let mut cells: Vec<SweptCell> = Vec::new();
    let mut before: Vec<Run> = Vec::new();
    for (row, slice) in ground.slices().into_iter().enumerate() {
        let mut here = joined(&slice);
        let (ups, downs) = overlaps(&before, &here);
        for (run, ups) in before.iter().zip(&ups) {
            cells[run.label as usize].touches[1] = ups.len();
        }
        for (number, run) in here.iter_mut().enumerate() {
            let goes_on = match downs[number][..] {
                [below] if ups[below].len() == 1 => Some(before[below].label),
                _ => None,
            };
            run.label = goes_on.unwrap_or(cells.len() as u32);
            if goes_on.is_none() {
                cells.push(SweptCell {
                    first_row: row as u32,
                    runs: Vec::new(),
                    touches: [downs[number].len(), 0],
                });
            }
            cells[run.label as usize].runs.push(*run);
        }
        before = here;
    }
    cells
}

/// The ground with the numbers of its cells as labels, after cells that are too small have been taken out, again and
/// again: with them go the events that they cause.
pub(super) fn cell_raster(ground: &Raster, least: Least) -> Raster {
    let mut raster = ground.clone();
    loop {
        let cells = cells(&raster);
        let (small, large): (Vec<_>, Vec<_>) = cells.iter().partition(|cell| cell.is_less_than(least));
        for cell in &small {
            paint(&mut raster, cell, Some(NONE));
        }
        if small.is_empty() {
            for cell in &large {
                paint(&mut raster, cell, None);
            }
            return raster;
        }
    }
}

fn paint(raster: &mut Raster, cell: &SweptCell, label: Option<u32>) {
    let columns = raster.columns();
    for (row, run) in (cell.first_row as usize..).zip(&cell.runs) {
        let squares = row * columns + run.from as usize..row * columns + run.to as usize;
        raster.labels_mut()[squares].fill(label.unwrap_or(run.label));
    }
}

/// Runs of different labels that touch, as one.
fn joined(slice: &[Run]) -> Vec<Run> {
    let mut whole: Vec<Run> = Vec::new();
    for run in slice {
        match whole.last_mut() {
            Some(last) if last.to == run.from => last.to = run.to,
            _ => whole.push(*run),
        }
    }
    whole
}

/// Per run of the row below the runs above it that it overlaps, and the other way round.
fn overlaps(below: &[Run], above: &[Run]) -> (Vec<Vec<usize>>, Vec<Vec<usize>>) {
    let (mut ups, mut downs) = (vec![Vec::new(); below.len()], vec![Vec::new(); above.len()]);
    let (mut low, mut high) = (0, 0);
    while low < below.len() && high < above.len() {
        if below[low].touches(&above[high]) {
            ups[low].push(high);
            downs[high].push(low);
        }
        if below[low].to <= above[high].to { low += 1 } else { high += 1 }
    }
    (ups, downs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planners::boustrophedon::raster::tests::drawn;

    fn text(raster: &Raster) -> String {
        let character = |label: &u32| if *label == NONE { '.' } else { char::from(b'0' + *label as u8) };
        let lines = raster.labels().chunks(raster.columns()).rev();
        lines.map(|row| row.iter().map(character).collect::<String>() + "\n").collect()
    }

    #[test]
    fn an_obstacle_opens_and_closes_cells() {
        let ground = drawn("000000\n000000\n00.000\n00..00\n000000");
        assert_eq!(text(&cell_raster(&ground, Least::default())), "333333\n333333\n11.222\n11..22\n000000\n");
    }

    #[test]
    fn a_pocket_is_a_cell_until_it_is_too_small() {
        let ground = drawn("000000\n00.0.0\n00.0.0");
        assert_eq!(text(&cell_raster(&ground, Least::default())), "333333\n00.1.2\n00.1.2\n");
        assert_eq!(text(&cell_raster(&ground, Least { area: 3, rows: 0 })), "000000\n00....\n00....\n");
    }

    #[test]
    fn a_flat_pocket_is_no_cell_but_a_flat_passage_is() {
        let ground = drawn("00...00\n00...00\n0000000\n00...00");
        let least = Least { area: 0, rows: 2 };
        assert_eq!(
            text(&cell_raster(&ground, least)),
            "22...33\n22...33\n1111111\n.......\n".replace('1', "0").replace('2', "1").replace('3', "2")
        );
    }

    #[test]
    fn slanted_walls_are_no_event() {
        let ground = drawn("..0000\n.0000.\n0000..\n.00...");
        assert_eq!(cells(&ground).len(), 1);
    }
}
