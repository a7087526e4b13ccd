//! From a cell to back-and-forth lanes, and to the paths along them.
//!
//! ```text
//!   ┌──────────┐  lanes lie on rows that all cells of one direction share, so that lanes do not double at their borders;
//!   │ ◀──────╮ │  where the last strip along a wall would be left out, the cell has lanes of its own, evenly
//!   │ ╭──────╯ │  stretched. A path begins in one of four corners: the lowest lane is driven to the right or to
//!   │ ╰──────▶ │  the left, and the whole path forwards or backwards. Lanes keep the body free: what obstacles
//!   └──────────┘  too small for the decomposition cut out of a lane is driven around.
//! ```

use super::{
    fragments::Fragments,
    msa::Region,
    raster::{NONE, Raster, Run},
};
use crate::transfers::{Transfers, Way};
use terrain::{Point, Segment};

/// A strip along a wall that is thinner than this share of the tool's width may be left out.
const STRIP: f64 = 0.3;
/// Pieces of a lane shorter than this share of the tool's width are no lanes.
const SHORT: f64 = 0.3;
/// Places of the shared rows that are tried.
const PHASES: u32 = 12;

/// A cell with the two ways to drive its lanes.
#[derive(Debug, Clone)]
pub(super) struct CellPath {
    /// The lowest lane to the right first, and to the left first. Both can be driven backwards, too.
    pub(super) paths: [Way; 2],
}

/// Body and tool, in squares.
#[derive(Debug, Clone, Copy)]
pub(super) struct Widths {
    pub(super) tool: f64,
    pub(super) body_radius: f64,
}

impl Widths {
    /// Rows may be torn by a gap of half a tool.
    pub(super) fn tolerance(&self) -> u32 {
        (self.tool / 2.0) as u32
    }
}

/// The paths of all regions; regions that lanes of others sweep have none.
pub(super) fn cell_paths(
    fragments: &Fragments,
    regions: &[Region],
    widths: Widths,
    transfers: &mut Transfers<'_, '_>,
) -> Vec<CellPath> {
    let strips: Vec<Strip> = regions.iter().map(|region| Strip::new(fragments, region, widths)).collect();
    let phases: Vec<f64> =
        (0..fragments.rasters.len()).map(|direction| best_phase(&strips, direction, widths.tool)).collect();
    let mut paths = Vec::new();
    for strip in &strips {
        let frame_raster = &fragments.rasters[strip.direction];
        let lanes: Vec<Vec<Segment>> = strip
            .lane_rows(phases[strip.direction], widths.tool)
            .into_iter()
            .map(|row| strip.lane(frame_raster, row, widths, transfers))
            .filter(|pieces| !pieces.is_empty())
            .collect();
        if let Some(path) = CellPath::new(&lanes, transfers) {
            paths.push(path);
        }
    }
    paths
}

/// A region as rows across its lanes.
struct Strip {
    direction: usize,
    rows: Vec<(u32, Run)>,
    /// What is to be swept, from below to above: beyond the outer rows where there are walls.
    low: f64,
    high: f64,
}

impl Strip {
    fn new(fragments: &Fragments, region: &Region, widths: Widths) -> Self {
        let direction = region.sweep.direction;
        let union = fragments.union(&region.members, direction);
        let (first, last) = (union.rows[0], union.rows[union.rows.len() - 1]);
        let raster = &fragments.rasters[direction];
        let beyond = (widths.body_radius.min(widths.tool / 2.0) - 0.5).max(0.0);
        let reach = |row: i64, run: &Run| if is_wall(raster, row, run) { beyond } else { 0.0 };
        let core = union.core(widths.tolerance());
        let core = if core.is_empty() { &union.rows[..] } else { core };
        Self {
            direction,
            low: f64::from(first.row) - reach(i64::from(first.row) - 1, &first.span),
            high: f64::from(last.row + 1) + reach(i64::from(last.row) + 1, &last.span),
            rows: core.iter().map(|row| (row.row, row.span)).collect(),
        }
    }

    fn bottom(&self) -> f64 {
        f64::from(self.rows[0].0) + 0.5
    }

    fn top(&self) -> f64 {
        f64::from(self.rows[self.rows.len() - 1].0) + 0.5
    }

    /// Where lanes lie: shared rows where these leave no strip out, else rows of its own.
    fn lane_rows(&self, phase: f64, tool: f64) -> Vec<f64> {
        let shared = self.shared_rows(phase, tool);
        let spare = STRIP * tool;
        let fits = match shared[..] {
            [] => {
                self.high - self.low <= tool
                    && self.low >= self.bottom() - 0.5
                    && self.high <= self.top() + 0.5
            }
            [first, ..] => {
                first - tool / 2.0 - self.low <= spare
                    && self.high - shared[shared.len() - 1] - tool / 2.0 <= spare
            }
        };
        if fits { shared } else { self.own_rows(tool) }
    }

    fn shared_rows(&self, phase: f64, tool: f64) -> Vec<f64> {
        let first = ((self.bottom() - phase) / tool - 1e-9).ceil();
        let last = ((self.top() - phase) / tool + 1e-9).floor();
        (first as i64..=last as i64).map(|number| phase + number as f64 * tool).collect()
    }

    fn own_rows(&self, tool: f64) -> Vec<f64> {
        let height = self.high - self.low;
        let count = (height / tool - STRIP).ceil().max(1.0);
        let row = |number: u32| self.low + (f64::from(number) + 0.5) * height / count;
        let rows: Vec<f64> =
            (0..count as u32).map(|number| row(number).clamp(self.bottom(), self.top())).collect();
        let (Some(&first), Some(&last)) = (rows.first(), rows.last()) else { return rows };
        if rows.len() < 2 {
            return vec![f64::midpoint(self.bottom(), self.top())];
        }
        // Pushed inwards by walls, lanes share what is between the outer ones.
        let step = (last - first) / (rows.len() - 1) as f64;
        (0..rows.len()).map(|number| first + number as f64 * step).collect()
    }

    /// Length of the lanes that a phase gives, and of what it leaves out.
    fn price(&self, phase: f64, tool: f64) -> f64 {
        let lanes = self.lane_rows(phase, tool);
        lanes.iter().map(|&row| f64::from(self.run_at(row).length())).sum()
    }

    fn run_at(&self, row: f64) -> Run {
        let number = self.rows.partition_point(|&(at, _)| f64::from(at) + 1.0 <= row);
        self.rows[number.min(self.rows.len() - 1)].1
    }

    /// The free pieces of the lane on a row, left to right.
    fn lane(&self, raster: &Raster, row: f64, widths: Widths, transfers: &Transfers<'_, '_>) -> Vec<Segment> {
        let run = self.run_at(row);
        let at = row.floor() as i64;
        // Up to a wall, the free part of the line says where a lane ends, to the millimetre.
        let spare = |column: i64| if raster.label(column, at) == NONE { 1.0 } else { 0.0 };
        let (left, right) = (
            f64::from(run.from) - spare(i64::from(run.from) - 1),
            f64::from(run.to) + spare(i64::from(run.to)),
        );
        let line = Segment::new(raster.frame().point(left, row), raster.frame().point(right, row));
        let length_m = line.length();
        let place = |way_m: f64| line.from + (line.to - line.from) * (way_m / length_m);
        let space = transfers.space();
        let mut parts = space.slice(line);
        parts.retain(|part| {
            space.nearest_place(place(part.0)).is_some() && space.nearest_place(place(part.1)).is_some()
        });
        let short_m = SHORT * widths.tool * raster.frame().step_m();
        let longest_m = parts.iter().map(|part| part.1 - part.0).fold(0.0, f64::max);
        parts.retain(|part| part.1 - part.0 >= short_m.min(longest_m));
        parts.into_iter().map(|part| Segment::new(place(part.0), place(part.1))).collect()
    }
}

/// Whether more than half of what lies beside a run is not to be swept.
fn is_wall(raster: &Raster, row: i64, run: &Run) -> bool {
    let walls = (run.from..run.to).filter(|&column| raster.label(i64::from(column), row) == NONE).count();
    2 * walls > run.length() as usize
}

/// The place of the shared rows with the least length of lanes.
fn best_phase(strips: &[Strip], direction: usize, tool: f64) -> f64 {
    let own: Vec<&Strip> = strips.iter().filter(|strip| strip.direction == direction).collect();
    let price = |phase: f64| own.iter().map(|strip| strip.price(phase, tool)).sum::<f64>();
    let phases = (0..PHASES).map(|number| f64::from(number) * tool / f64::from(PHASES));
    phases.map(|phase| (price(phase), phase)).min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |best| best.1)
}

impl CellPath {
    fn new(lanes: &[Vec<Segment>], transfers: &mut Transfers<'_, '_>) -> Option<Self> {
        let right = back_and_forth(lanes, 0, transfers)?;
        let left = back_and_forth(lanes, 1, transfers)?;
        Some(Self { paths: [right, left] })
    }
}

/// Along all lanes, the lowest first; every second one, from `odd` on, to the left.
fn back_and_forth(lanes: &[Vec<Segment>], odd: usize, transfers: &mut Transfers<'_, '_>) -> Option<Way> {
    let mut points: Vec<Point> = Vec::new();
    for (number, lane) in lanes.iter().enumerate() {
        let to_the_left = number % 2 != odd % 2;
        let mut pieces: Vec<(Point, Point)> = lane.iter().map(|piece| (piece.from, piece.to)).collect();
        if to_the_left {
            pieces.reverse();
            for (from, to) in &mut pieces {
                std::mem::swap(from, to);
            }
        }
        for (from, to) in pieces {
            if let Some(&last) = points.last() {
                points.extend(transfers.way(last, from)?.points);
            }
            points.extend([from, to]);
        }
    }
    (!points.is_empty()).then(|| Way::new(transfers.space().instance(), points))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strip(rows: std::ops::Range<u32>, low: f64, high: f64) -> Strip {
        let run = Run { from: 0, to: 10, label: 0 };
        Strip { direction: 0, rows: rows.map(|row| (row, run)).collect(), low, high }
    }

    #[test]
    fn lanes_of_its_own_are_evenly_spaced_and_reach_both_walls() {
        // 20 rows for the centre, walls 2 squares beyond; a tool of 5 squares: 24 / 5 are five lanes.
        let rows = strip(10..30, 8.0, 32.0).own_rows(5.0);
        assert_eq!(rows.len(), 5);
        assert!((rows[0] - 10.5).abs() < 0.5 && (rows[4] - 29.5).abs() < 0.5, "{rows:?}");
        let gaps: Vec<f64> = rows.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(gaps.iter().all(|gap| (gap - gaps[0]).abs() < 1e-9 && *gap <= 5.0), "{gaps:?}");
    }

    #[test]
    fn rows_are_shared_where_no_strip_is_left_out() {
        let open = strip(10..30, 10.0, 30.0);
        assert_eq!(open.lane_rows(2.5, 5.0), [12.5, 17.5, 22.5, 27.5]);
        assert_eq!(open.lane_rows(1.0, 5.0), [11.0, 16.0, 21.0, 26.0], "a thin strip may be left out");
        let walled = strip(10..30, 8.0, 32.0);
        assert_eq!(walled.lane_rows(2.5, 5.0), walled.own_rows(5.0));
    }

    #[test]
    fn a_thin_cell_between_others_needs_no_lane() {
        assert!(strip(11..13, 11.0, 13.0).lane_rows(0.0, 5.0).is_empty());
        assert_eq!(strip(11..13, 9.0, 15.0).lane_rows(0.0, 5.0), [12.0], "between two walls it does");
    }
}
