//! The ground that is still to be covered, and what of it lines of points sweep: samples in a raster that is fine for the tool.
//!
//! Each place is one sample, or four where places are coarse: walls and rims are as thin as a place, and half of one counts.

use crate::{Instance, configuration_space::ConfigurationSpace};
use terrain::{CellClass, Lattice, Point, Segment};

/// Samples across a tool, at least, where places are split.
const SAMPLES_ACROSS: f64 = 14.0;

/// Wanted samples and how often each has been swept.
#[derive(Debug, Clone)]
pub(crate) struct Ground {
    samples: Lattice,
    radius_m: f64,
    wanted: Vec<bool>,
    swept: Vec<u16>,
    wanted_count: usize,
    left_count: usize,
}

impl Ground {
    /// All that can be covered in cells to visit, and in the rims beside them where no cell's centre can be stood on, but for
    /// what is swept already.
    pub(crate) fn new(space: &ConfigurationSpace<'_>) -> Self {
        let (floor, places) = (space.instance().floor, *space.places());
        let half_tool_m = floor.tool_width_m() / 2.0;
        let cells = cells_to_cover(space);
        // A tool that is as wide as the body sweeps up to the walls; else their rims stay.
        let rim_m = if half_tool_m + 1e-9 >= floor.body_radius_m() { 1e-6 } else { -1e-6 };
        let mut wanted = space.coverable(half_tool_m + rim_m);
        for (place, wanted) in wanted.iter_mut().enumerate().filter(|(_, wanted)| **wanted) {
            *wanted = cells[space.cell_index(place)];
        }
        let split = if places.cell_m * SAMPLES_ACROSS > floor.tool_width_m() { 2 } else { 1 };
        let mut wanted = if split == 1 { wanted } else { doubled(&wanted, places.columns as usize) };
        let samples = Lattice {
            cell_m: places.cell_m / f64::from(split),
            columns: places.columns * split,
            rows: places.rows * split,
            ..places
        };
        leave_out_swept(space.instance(), &samples, &mut wanted);
        let count = wanted.iter().filter(|&&wanted| wanted).count();
        Self {
            samples,
            radius_m: half_tool_m + 1e-9,
            swept: vec![0; wanted.len()],
            wanted,
            wanted_count: count,
            left_count: count,
        }
    }

    /// The raster of samples.
    pub(crate) fn samples(&self) -> &Lattice {
        &self.samples
    }

    /// Where a sample is.
    pub(crate) fn point(&self, sample: usize) -> Point {
        self.samples.center(self.samples.cell(sample))
    }

    /// The radius within which samples count as swept, metres.
    pub(crate) fn radius_m(&self) -> f64 {
        self.radius_m
    }

    /// Whether a sample is wanted and has not been swept.
    pub(crate) fn is_left(&self, place: usize) -> bool {
        self.wanted[place] && self.swept[place] == 0
    }

    /// Columns and rows, first and last, between which all samples lie that are left.
    pub(crate) fn left_box(&self) -> Option<[(usize, usize); 2]> {
        let columns = self.samples.columns as usize;
        let mut found: Option<[(usize, usize); 2]> = None;
        for row in 0..self.samples.rows as usize {
            let is_left = |column: &usize| self.is_left(row * columns + column);
            let Some(first) = (0..columns).find(is_left) else { continue };
            let last = (first..columns).rev().find(is_left).unwrap_or(first);
            let [(low_x, high_x), (low_y, _)] = found.unwrap_or([(first, last), (row, row)]);
            found = Some([(low_x.min(first), high_x.max(last)), (low_y, row)]);
        }
        found
    }

    /// Share of the wanted samples that have been swept.
    pub(crate) fn coverage(&self) -> f64 {
        1.0 - self.left_count as f64 / self.wanted_count.max(1) as f64
    }

    /// How many samples more have to be swept for this share.
    pub(crate) fn missing(&self, share: f64) -> f64 {
        ((share - self.coverage()) * self.wanted_count as f64).max(0.0)
    }

    /// Samples that are wanted and not swept.
    pub(crate) fn left_count(&self) -> usize {
        self.left_count
    }

    /// Forgets what has been swept.
    pub(crate) fn clear(&mut self) {
        self.swept.fill(0);
        self.left_count = self.wanted_count;
    }

    /// Sweeps along a line of points.
    pub(crate) fn sweep(&mut self, points: &[Point]) {
        self.each_sample_of(points, |ground, place| {
            if ground.swept[place] == 0 && ground.wanted[place] {
                ground.left_count -= 1;
            }
            ground.swept[place] = ground.swept[place].saturating_add(1);
        });
    }

    /// Takes a sweep along these very points back.
    #[allow(dead_code, reason = "for planners that change a tour step by step")]
    pub(crate) fn unsweep(&mut self, points: &[Point]) {
        self.each_sample_of(points, |ground, place| {
            ground.swept[place] = ground.swept[place].saturating_sub(1);
            if ground.swept[place] == 0 && ground.wanted[place] {
                ground.left_count += 1;
            }
        });
    }

    fn each_sample_of(&mut self, points: &[Point], mut act: impl FnMut(&mut Self, usize)) {
        let (places, radius_m) = (self.samples, self.radius_m);
        let only = points.first().map(|&point| Segment::new(point, point)).filter(|_| points.len() == 1);
        for segment in points.windows(2).map(|pair| Segment::new(pair[0], pair[1])).chain(only) {
            for_each_within(&places, segment, radius_m, |begin, end| {
                (begin..end).for_each(|place| act(self, place));
            });
        }
    }

    /// Calls `act` with each sample that a segment sweeps and that is left.
    pub(crate) fn each_left_along(&self, segment: Segment, mut act: impl FnMut(usize)) {
        for_each_within(&self.samples, segment, self.radius_m, |begin, end| {
            (begin..end).filter(|&place| self.is_left(place)).for_each(&mut act);
        });
    }

    /// How many wanted samples are swept along a line of points, and only once.
    pub(crate) fn alone(&self, points: &[Point]) -> usize {
        let mut alone = 0;
        for pair in points.windows(2) {
            for_each_within(&self.samples, Segment::new(pair[0], pair[1]), self.radius_m, |begin, end| {
                alone += (begin..end).filter(|&place| self.wanted[place] && self.swept[place] == 1).count();
            });
        }
        alone
    }

    /// How many samples a segment would sweep that are left.
    pub(crate) fn gain(&self, segment: Segment) -> usize {
        let mut gain = 0;
        self.each_left_along(segment, |_| gain += 1);
        gain
    }
}

/// What is swept is not wanted again: of the instance's samples of a cell, the one that a sample of ours lies in counts.
fn leave_out_swept(instance: &Instance<'_>, samples: &Lattice, wanted: &mut [bool]) {
    let lattice = instance.floor.lattice();
    let across = (samples.columns / lattice.columns) as usize;
    let bit = |sample: usize| (2 * (sample % across) + 1) * 8 / (2 * across);
    let columns = samples.columns as usize;
    for (index, &swept) in instance.swept.iter().enumerate().filter(|(_, swept)| **swept != 0) {
        let cell = lattice.cell(index);
        let first = [cell.x, cell.y].map(|number| number as usize * across);
        for row in first[1]..first[1] + across {
            for column in first[0]..first[0] + across {
                wanted[row * columns + column] &= swept >> (bit(row) * 8 + bit(column)) & 1 == 0;
            }
        }
    }
}

/// Each mark as two by two.
fn doubled(marks: &[bool], columns: usize) -> Vec<bool> {
    let row = |row: &[bool]| row.iter().flat_map(|&mark| [mark, mark]).collect::<Vec<bool>>();
    marks.chunks(columns).flat_map(|marks| [row(marks), row(marks)].concat()).collect()
}

/// Row-major by cell: cells to visit, and those that cannot be stood on within half a tool of one.
fn cells_to_cover(space: &ConfigurationSpace<'_>) -> Vec<bool> {
    let (instance, floor) = (space.instance(), space.instance().floor);
    let lattice = floor.lattice();
    let mut cells = instance.visit.clone();
    let reach = (floor.tool_width_m() / 2.0 / lattice.cell_m).ceil() as i32;
    for (index, cell) in lattice.cells().enumerate() {
        if floor.is_drivable(index) || floor.class(index) == CellClass::Obstacle || instance.blocked[index] {
            continue;
        }
        let mut around = (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy)));
        cells[index] = around.any(|(dx, dy)| {
            lattice
                .index(terrain::Cell::new(cell.x + dx, cell.y + dy))
                .is_some_and(|near| instance.visit[near])
        });
    }
    cells
}

/// Calls `act(begin, end)` with the runs of samples (row-major numbers) within `radius_m` of a segment, row by row.
pub(crate) fn for_each_within(
    places: &Lattice,
    segment: Segment,
    radius_m: f64,
    mut act: impl FnMut(usize, usize),
) {
    let step_m = places.cell_m;
    let Segment { from, to } = segment;
    let row = |y_m: f64| (y_m - places.origin.y) / step_m - 0.5;
    let column = |x_m: f64| (x_m - places.origin.x) / step_m - 0.5;
    let first = row(from.y.min(to.y) - radius_m).ceil().max(0.0);
    let last = row(from.y.max(to.y) + radius_m).floor().min(f64::from(places.rows) - 1.0);
    let mut number = first;
    while number <= last {
        let y_m = places.origin.y + (number + 0.5) * step_m;
        if let Some((low_m, high_m)) = segment.within_at(radius_m, y_m) {
            let begin = (column(low_m) - 1e-9).ceil().max(0.0);
            let end = (column(high_m) + 1e-9).floor().min(f64::from(places.columns) - 1.0);
            if begin <= end {
                let start = number as usize * places.columns as usize;
                act(start + begin as usize, start + end as usize + 1);
            }
        }
        number += 1.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Mode, PlanOptions, Start, plan, test_motion::MOTION};
    use proptest::prelude::*;
    use terrain::{Cell, Floor};

    fn time_s(instance: &Instance<'_>) -> f64 {
        let options = PlanOptions { planner: "boustrophedon-lanes".to_owned(), ..PlanOptions::default() };
        plan(instance, &options).expect("it can be planned").figures().makespan_s
    }

    #[test]
    fn what_is_swept_is_not_planned_again() {
        let lattice = Lattice { origin: Point::origin(), cell_m: 0.5, columns: 24, rows: 12 };
        let floor = Floor::from_cells(lattice, &vec![true; lattice.len()], 0.177, 0.75);
        let starts = vec![Start::at(Cell::new(0, 0))];
        let whole = Instance::whole_floor(&floor, starts, MOTION, Mode::Cover);
        let left_half = |cell: Cell| if cell.x < 12 { u64::MAX } else { 0 };
        let later = Instance { swept: lattice.cells().map(left_half).collect(), ..whole.clone() };
        let [all, half] = [&whole, &later].map(|of| Ground::new(&ConfigurationSpace::new(of)));
        assert_eq!(2 * half.left_count(), all.left_count());
        let lower_rows = Instance { swept: vec![u64::from(u32::MAX); lattice.len()], ..whole.clone() };
        let upper = Ground::new(&ConfigurationSpace::new(&lower_rows));
        assert_eq!(2 * upper.left_count(), all.left_count());
        let is_upper = |sample| (upper.point(sample).y / lattice.cell_m).fract() > 0.5;
        assert!((0..upper.samples().len()).filter(|&sample| upper.is_left(sample)).all(is_upper));
        assert!(time_s(&later) < 0.7 * time_s(&whole), "{} s, {} s", time_s(&later), time_s(&whole));
    }

    proptest! {
        #[test]
        fn runs_are_just_the_samples_within_the_distance(
            ends in prop::array::uniform4(-1.0_f64..4.0), radius_m in 0.05_f64..1.0, flat in any::<bool>()
        ) {
            let places = Lattice { origin: Point::new(-0.3, 0.2), cell_m: 0.1, columns: 30, rows: 25 };
            let to_y = if flat { ends[1] } else { ends[3] };
            let segment = Segment::new(Point::new(ends[0], ends[1]), Point::new(ends[2], to_y));
            let mut within = vec![false; places.len()];
            for_each_within(&places, segment, radius_m, |begin, end| within[begin..end].fill(true));
            for cell in places.cells() {
                let distance_m = segment.distance_to_point(places.center(cell));
                if (distance_m - radius_m).abs() > 1e-6 {
                    prop_assert_eq!(within[places.index(cell).unwrap()], distance_m < radius_m, "{}", cell);
                }
            }
        }
    }
}
