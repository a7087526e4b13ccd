//! The floor as one kind of robot sees it: where its body can stand and move on the lattice, and what of each
//! cell its tool can reach.
//!
//! ```text
//!   ######        a cell is drivable when a disc of the body's radius fits at its centre;
//!   #....#        a move to the next cell is open when the disc fits all along the way;
//!   #.##.#        a sample is required when it is free and within the tool's radius of a
//!   ######        drivable cell's centre: only that can ever be covered, and all of that must be.
//! ```

use crate::{
    Cell, Direction, GridMap, Lattice, Point, Segment,
    footprint::{SAMPLES_PER_CELL, sample_point, samples_within},
};
use std::sync::Arc;
use thiserror::Error;

/// Who is so near to the line between two cells is on it, metres.
const ON_LINE_M: f64 = 1e-6;

/// The most cells a lattice may have.
pub const CELLS_MAX: u64 = 16 << 20;

/// What a cell is, before any robot moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CellClass {
    /// Some of it can be swept.
    Coverable,
    /// It has free ground, but no place from which the tool reaches it.
    TooNarrow,
    /// It has no free ground.
    Obstacle,
}

/// Why a floor cannot be laid out.
#[derive(Debug, Clone, Error, PartialEq)]
pub enum FloorError {
    /// A length that is not a finite number above 0.
    #[error("`{key}` is {value}: expected a finite length above 0 m")]
    Length {
        /// The key in the scenario or option.
        key: &'static str,
        /// What it said.
        value: f64,
    },
    /// More cells than we take.
    #[error("cells of {cell_m} m give {cells} cells; at most {CELLS_MAX} are taken: choose larger cells")]
    TooManyCells {
        /// Side of a cell.
        cell_m: f64,
        /// How many there would be.
        cells: u64,
    },
    /// The body fits nowhere.
    #[error(
        "a body of radius {body_radius_m} m fits nowhere on this map (cells of {cell_m} m): every passage is too narrow"
    )]
    NothingDrivable {
        /// Radius of the body.
        body_radius_m: f64,
        /// Side of a cell.
        cell_m: f64,
    },
}

/// The lattice with what one kind of robot can do on it. Row-major `Vec`s by cell.
#[derive(Debug, Clone)]
pub struct Floor {
    lattice: Lattice,
    body_radius_m: f64,
    tool_width_m: f64,
    drivable: Vec<bool>,
    moves: Vec<u8>,
    required: Vec<u64>,
    free_samples: u64,
    classes: Vec<CellClass>,
    map: Option<Arc<GridMap>>,
}

impl Floor {
    /// Lays cells of side `cell_m` over a map for a disc-shaped body and a tool of diameter `tool_width_m`.
    ///
    /// # Errors
    ///
    /// [`FloorError`] when a length is not one, there are too many cells, or the body fits nowhere.
    pub fn new(
        map: &GridMap,
        cell_m: f64,
        body_radius_m: f64,
        tool_width_m: f64,
    ) -> Result<Self, FloorError> {
        for (key, value) in
            [("cell_m", cell_m), ("body_radius_m", body_radius_m), ("tool_width_m", tool_width_m)]
        {
            if !(value.is_finite() && value > 0.0) {
                return Err(FloorError::Length { key, value });
            }
        }
        let lattice = lattice_over(map, cell_m)?;
        let drivable: Vec<bool> =
            lattice.cells().map(|cell| map.disc_is_free(lattice.center(cell), body_radius_m)).collect();
        if !drivable.contains(&true) {
            return Err(FloorError::NothingDrivable { body_radius_m, cell_m });
        }
        let moves = open_moves(map, &lattice, &drivable, body_radius_m);
        let free: Vec<u64> = lattice.cells().map(|cell| free_samples(map, &lattice, cell)).collect();
        let (required, classes) = required_samples(&lattice, &drivable, &free, tool_width_m / 2.0);
        let free_samples = count(&free);
        let map = Some(Arc::new(map.clone()));
        Ok(Self {
            lattice,
            body_radius_m,
            tool_width_m,
            drivable,
            moves,
            required,
            free_samples,
            classes,
            map,
        })
    }

    /// A floor straight from cells, where each free cell can be driven and is required whole: the grid of the
    /// papers. `free` is row-major from the bottom.
    pub fn from_cells(lattice: Lattice, free: &[bool], body_radius_m: f64, tool_width_m: f64) -> Self {
        assert_eq!(free.len(), lattice.len(), "one value per cell");
        let open = |cell: Cell| lattice.index(cell).is_some_and(|index| free[index]);
        let moves = lattice
            .cells()
            .map(|cell| {
                Direction::ALL
                    .into_iter()
                    .filter(|&direction| open(cell) && open(cell.step(direction)))
                    .fold(0, |bits, direction| bits | 1 << direction as u8)
            })
            .collect();
        let required: Vec<u64> = free.iter().map(|&free| if free { u64::MAX } else { 0 }).collect();
        let classes =
            free.iter().map(|&free| if free { CellClass::Coverable } else { CellClass::Obstacle }).collect();
        let drivable = free.to_vec();
        let free_samples = count(&required);
        Self {
            lattice,
            body_radius_m,
            tool_width_m,
            drivable,
            moves,
            required,
            free_samples,
            classes,
            map: None,
        }
    }

    /// Closes a move, and the way back: a wall that is thinner than a cell.
    pub fn close_move(&mut self, cell: Cell, direction: Direction) {
        for (from, way) in [(cell, direction), (cell.step(direction), direction.opposite())] {
            if let Some(index) = self.lattice.index(from) {
                self.moves[index] &= !(1 << way as u8);
            }
        }
    }

    /// The lattice.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Radius of the body, metres.
    pub fn body_radius_m(&self) -> f64 {
        self.body_radius_m
    }

    /// Diameter of the tool's disc, metres.
    pub fn tool_width_m(&self) -> f64 {
        self.tool_width_m
    }

    /// The map it was laid over; `None` when it was made straight from cells.
    pub fn map(&self) -> Option<&GridMap> {
        self.map.as_deref()
    }

    /// Whether the body can drive straight along a segment: with a map, free for the body's disc all along; straight
    /// from cells, from each cell to the next one by open moves.
    pub fn segment_is_free(&self, segment: Segment) -> bool {
        // A tangent wall is no obstacle: the same slack as of rounding.
        let map_is_free =
            self.map().is_none_or(|map| map.capsule_is_free(segment, self.body_radius_m - 1e-6));
        map_is_free && (self.map.is_some() || self.cells_are_joined(segment))
    }

    /// Who is on the line between two cells is in both: where the move between them is closed, that line is a wall, and nobody
    /// gets through it by going to it on one side and off it on the other.
    fn cells_are_joined(&self, segment: Segment) -> bool {
        let cells = self.lattice.cells_along(segment);
        cells.iter().all(|&cell| self.cell_is_drivable(cell) && self.keeps_off_closed_sides(cell, &segment))
            && cells.windows(2).all(|pair| {
                Direction::between(pair[0], pair[1]).is_some_and(|way| self.can_move(pair[0], way))
            })
    }

    fn keeps_off_closed_sides(&self, cell: Cell, segment: &Segment) -> bool {
        let mut closed = Direction::ALL.into_iter().filter(|&way| !self.can_move(cell, way));
        closed.all(|way| self.lattice.side(cell, way).distance(segment) >= ON_LINE_M)
    }

    /// Whether the body can stand at the centre of the cell with this number.
    pub fn is_drivable(&self, index: usize) -> bool {
        self.drivable[index]
    }

    /// Whether the body can stand at the centre of a cell.
    pub fn cell_is_drivable(&self, cell: Cell) -> bool {
        self.lattice.index(cell).is_some_and(|index| self.drivable[index])
    }

    /// Whether the body can drive straight from a cell to the next one.
    pub fn can_move(&self, cell: Cell, direction: Direction) -> bool {
        self.lattice.index(cell).is_some_and(|index| self.moves[index] >> (direction as u8) & 1 == 1)
    }

    /// The cells that can be reached from a cell with one straight move, anticlockwise from east.
    pub fn neighbours(&self, cell: Cell) -> impl Iterator<Item = Cell> + '_ {
        Direction::ALL.into_iter().filter(move |&way| self.can_move(cell, way)).map(move |way| cell.step(way))
    }

    /// The samples of a cell that can be swept and must be.
    pub fn required(&self, index: usize) -> u64 {
        self.required[index]
    }

    /// What a cell is before any robot moves.
    pub fn class(&self, index: usize) -> CellClass {
        self.classes[index]
    }

    /// Row-major: the required samples that can be swept from the cells marked in `reachable` (row-major) alone.
    pub fn required_from(&self, reachable: &[bool]) -> Vec<u64> {
        assert_eq!(reachable.len(), self.lattice.len(), "one value per cell");
        let reached = reach_of(&self.lattice, reachable, self.tool_width_m / 2.0);
        reached.iter().zip(&self.required).map(|(reached, required)| reached & required).collect()
    }

    fn character(&self, index: usize) -> char {
        match self.classes[index] {
            CellClass::Coverable if self.drivable[index] => '.',
            CellClass::Coverable => 'o',
            CellClass::TooNarrow => '-',
            CellClass::Obstacle => '#',
        }
    }

    /// Area that can be swept, square metres.
    pub fn coverable_m2(&self) -> f64 {
        crate::SweptRaster::area_m2(&self.lattice, count(&self.required))
    }

    /// Area that can be swept from the cells marked in `reachable` (row-major) alone, square metres.
    pub fn coverable_from_m2(&self, reachable: &[bool]) -> f64 {
        crate::SweptRaster::area_m2(&self.lattice, count(&self.required_from(reachable)))
    }

    /// Free ground that the tool touches from no cell's centre, square metres: corners, niches, passages too narrow for
    /// the body, strips beside the lattice.
    pub fn untouchable_m2(&self) -> f64 {
        crate::SweptRaster::area_m2(&self.lattice, self.free_samples - count(&self.required))
    }

    /// Whether a tool of this width, metres, fits between the walls at some place where the body can stand.
    pub fn tool_fits(&self, map: &GridMap, tool_width_m: f64) -> bool {
        self.lattice
            .cells()
            .filter(|&cell| self.cell_is_drivable(cell))
            .any(|cell| map.disc_is_free(self.lattice.center(cell), tool_width_m / 2.0))
    }

    /// The drivable cell nearest to a point whose straight way from there is free for the body, if any is
    /// within 1.5 cells.
    pub fn nearest_drivable(&self, map: &GridMap, point: Point) -> Option<Cell> {
        let reach = 1.5 * self.lattice.cell_m;
        let low = Point::new(point.x - reach, point.y - reach);
        let high = Point::new(point.x + reach, point.y + reach);
        let distance = |cell: Cell| (self.lattice.center(cell) - point).norm();
        let mut candidates: Vec<Cell> = self
            .lattice
            .cells_in_box(low, high)
            .filter(|&cell| self.cell_is_drivable(cell) && distance(cell) <= reach)
            .collect();
        candidates.sort_by(|&a, &b| distance(a).total_cmp(&distance(b)).then(a.cmp(&b)));
        candidates.into_iter().find(|&cell| {
            map.capsule_is_free(Segment::new(point, self.lattice.center(cell)), self.body_radius_m - 0.005)
        })
    }
}

fn lattice_over(map: &GridMap, cell_m: f64) -> Result<Lattice, FloorError> {
    let size = map.corner() - map.origin();
    let count = |length: f64| ((length / cell_m) - 1e-6).ceil().max(1.0);
    let (columns, rows) = (count(size.x), count(size.y));
    if columns * rows > CELLS_MAX as f64 {
        return Err(FloorError::TooManyCells { cell_m, cells: (columns * rows) as u64 });
    }
    Ok(Lattice { origin: map.origin(), cell_m, columns: columns as u32, rows: rows as u32 })
}

fn open_moves(map: &GridMap, lattice: &Lattice, drivable: &[bool], body_radius_m: f64) -> Vec<u8> {
    let mut moves = vec![0_u8; lattice.len()];
    for cell in lattice.cells() {
        for direction in [Direction::East, Direction::North] {
            let next = cell.step(direction);
            let (Some(from), Some(to)) = (lattice.index(cell), lattice.index(next)) else { continue };
            let way = Segment::new(lattice.center(cell), lattice.center(next));
            if drivable[from] && drivable[to] && map.capsule_is_free(way, body_radius_m) {
                moves[from] |= 1 << direction as u8;
                moves[to] |= 1 << direction.opposite() as u8;
            }
        }
    }
    moves
}

fn count(samples: &[u64]) -> u64 {
    samples.iter().map(|samples| u64::from(samples.count_ones())).sum()
}

fn required_samples(
    lattice: &Lattice,
    drivable: &[bool],
    free: &[u64],
    tool_radius_m: f64,
) -> (Vec<u64>, Vec<CellClass>) {
    let reachable = reach_of(lattice, drivable, tool_radius_m);
    let mut required = vec![0_u64; lattice.len()];
    let mut classes = vec![CellClass::Obstacle; lattice.len()];
    for (index, &free) in free.iter().enumerate() {
        required[index] = free & reachable[index];
        classes[index] = match (free, required[index]) {
            (0, _) => CellClass::Obstacle,
            (_, 0) => CellClass::TooNarrow,
            _ => CellClass::Coverable,
        };
    }
    (required, classes)
}

/// Per cell, the samples within the tool's radius of the centre of some cell in `stands`. The lattice is regular: what
/// one stand reaches is worked out once, and shifted.
fn reach_of(lattice: &Lattice, stands: &[bool], tool_radius_m: f64) -> Vec<u64> {
    let mut reached = vec![0_u64; lattice.len()];
    let stencil = stencil(lattice, tool_radius_m);
    for cell in lattice.cells().filter(|&cell| lattice.index(cell).is_some_and(|index| stands[index])) {
        for &(dx, dy, samples) in &stencil {
            if let Some(index) = lattice.index(Cell::new(cell.x + dx, cell.y + dy)) {
                reached[index] |= samples;
            }
        }
    }
    reached
}

/// What a tool over the centre of a cell reaches: column and row difference, and samples. Rounding is left to the
/// safe side: a sample just at the rim is not asked for.
fn stencil(lattice: &Lattice, tool_radius_m: f64) -> Vec<(i32, i32, u64)> {
    let around = Lattice { origin: Point::origin(), ..*lattice };
    let stand = around.center(Cell::new(0, 0));
    let stand = Segment::new(stand, stand);
    let longest = lattice.columns.max(lattice.rows);
    let reach = (tool_radius_m / lattice.cell_m + 0.5).ceil().min(f64::from(longest)) as i32;
    (-reach..=reach)
        .flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy)))
        .map(|(dx, dy)| (dx, dy, samples_within(&around, Cell::new(dx, dy), stand, tool_radius_m - 1e-9)))
        .filter(|&(_, _, samples)| samples != 0)
        .collect()
}

fn free_samples(map: &GridMap, lattice: &Lattice, cell: Cell) -> u64 {
    let half = 0.5 * lattice.cell_m;
    let center = lattice.center(cell);
    let (x0, y0) = map.square_at(Point::new(center.x - half, center.y - half));
    let (x1, y1) = map.square_at(Point::new(center.x + half, center.y + half));
    let mut squares = (y0..=y1).flat_map(|y| (x0..=x1).map(move |x| (x, y)));
    if squares.all(|(x, y)| map.is_free(x, y)) {
        return u64::MAX;
    }
    (0..SAMPLES_PER_CELL)
        .filter(|&bit| map.point_is_free(sample_point(lattice, cell, bit)))
        .fold(0, |samples, bit| samples | 1 << bit)
}

/// Drawn as text, top row first: `.` drivable, `o` swept from next door only, `-` free but out of reach, `#` obstacle.
impl std::fmt::Display for Floor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for y in (0..self.lattice.rows as usize).rev() {
            let start = y * self.lattice.columns as usize;
            let row = start..start + self.lattice.columns as usize;
            let line: String = row.map(|index| self.character(index)).collect();
            writeln!(f, "{line}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SweptRaster;
    use proptest::prelude::*;

    fn floor(drawing: &str, cell_m: f64, body_radius_m: f64, tool_width_m: f64) -> Floor {
        let map = GridMap::from_drawing(drawing, 0.5).unwrap();
        Floor::new(&map, cell_m, body_radius_m, tool_width_m).unwrap()
    }

    #[test]
    fn a_slit_between_cell_centres_is_swept_from_next_door() {
        // Cells of two squares: the lower right ones are half wall, so that no body stands at their centres.
        let seen = floor("........\n........\n......#.\n........", 1.0, 0.4, 1.4);
        assert_eq!(seen.to_string(), "....\n...o\n");
    }

    #[test]
    fn ground_that_no_tool_reaches_is_too_narrow() {
        let seen = floor(&"......#.\n".repeat(5), 0.5, 0.26, 0.6);
        assert!(seen.to_string().lines().all(|line| line.ends_with("#-")), "{seen}");
    }

    #[test]
    fn a_body_as_wide_as_the_door_goes_through_and_a_wider_one_does_not() {
        let drawing = "...\n#.#\n...";
        let (door, above) = (Cell::new(1, 1), Direction::North);
        assert!(floor(drawing, 0.5, 0.25, 0.75).can_move(door, above));
        let map = GridMap::from_drawing(drawing, 0.5).unwrap();
        let wide = Floor::new(&map, 0.5, 0.26, 0.75);
        assert!(wide.is_err_and(|error| matches!(error, FloorError::NothingDrivable { .. })));
    }

    #[test]
    fn nobody_gets_through_a_thin_wall_by_way_of_a_point_on_it() {
        let lattice = Lattice { origin: Point::origin(), cell_m: 0.5, columns: 1, rows: 2 };
        let mut floor = Floor::from_cells(lattice, &[true; 2], 0.1, 0.5);
        let [below, above] = [0.25, 0.75].map(|y| Point::new(0.25, y));
        assert!(floor.segment_is_free(Segment::new(below, above)));
        floor.close_move(Cell::new(0, 0), Direction::North);
        let is_free = |from, to| floor.segment_is_free(Segment::new(from, to));
        for y in [0.5, 0.5 - 1e-12, 0.5 + 1e-12] {
            let on_wall = Point::new(0.25, y);
            assert!(!is_free(below, on_wall) && !is_free(on_wall, above), "{y}");
            assert!(!is_free(on_wall, Point::new(0.3, y)), "{y}");
        }
        assert!(is_free(below, Point::new(0.25, 0.49)));
    }

    #[test]
    fn what_lies_behind_a_wall_is_not_required_from_this_side() {
        let seen = floor("...#...", 0.5, 0.2, 0.75);
        let this_side: Vec<bool> = (0..7).map(|x| x < 3).collect();
        let required = seen.required_from(&this_side);
        assert!(required[..3].iter().all(|&samples| samples == u64::MAX));
        assert!(required[3..].iter().all(|&samples| samples == 0));
    }

    proptest! {
        #[test]
        fn standing_on_every_drivable_cell_sweeps_all_that_is_required(
            squares in prop::collection::vec(prop::bool::weighted(0.8), 12 * 9),
            cell_m in 0.3_f64..1.1,
            body in 0.1_f64..0.5,
            tool in 0.3_f64..2.0,
        ) {
            let map = GridMap::new(12, 9, 0.5, Point::new(-1.0, 2.0), squares).unwrap();
            if let Ok(floor) = Floor::new(&map, cell_m, body, tool) {
                let mut raster = SweptRaster::new(*floor.lattice());
                for cell in floor.lattice().cells().filter(|&cell| floor.cell_is_drivable(cell)) {
                    let stand = floor.lattice().center(cell);
                    raster.sweep(Segment::new(stand, stand), tool / 2.0, |_| {});
                }
                for index in 0..floor.lattice().len() {
                    let required = floor.required(index);
                    prop_assert_eq!(required & !raster.samples(index), 0);
                    for bit in (0..SAMPLES_PER_CELL).filter(|bit| required >> bit & 1 == 1) {
                        let sample = sample_point(floor.lattice(), floor.lattice().cell(index), bit);
                        prop_assert!(map.point_is_free(sample));
                    }
                }
                let all: Vec<bool> = (0..floor.lattice().len()).map(|i| floor.is_drivable(i)).collect();
                prop_assert_eq!(floor.required_from(&all), floor.required);
            }
        }
    }
}
