//! Passages: ways of the body between pieces of the lattice that no straight move joins.
//!
//! ```text
//!   ###..o..        The centres `o` are free and no straight move leads from one to another: the corridor runs at a
//!   ##..┘..#        slant, and is hardly wider than the body. A bent line through it is a passage. Passages join
//!   ..o...##        pieces to a forest: what the body gets to over moves and passages is all that it gets to, as far
//!   .....###        as a raster of places tells, nine or so to a cell's side.
//! ```
//!
//! **Idea.** Each piece but the largest, one after another: a shortest way over free places from its centres to a
//! centre of any other piece, then pulled straight. Who found one belongs to the other piece from then on, and goes on
//! until the largest is met or no way is left. Ground deep inside pieces is not searched: moves join it anyway.
//! **Complexity.** O(s log s) a search for the s places along the rims of its group; a piece that is joined to j others before the
//! largest is searched j times.

use crate::{Cell, Direction, Floor, Lattice, Point, Segment};
use std::{
    cmp::Reverse,
    collections::{BTreeMap, BinaryHeap},
};

/// Places in the body's radius, at least.
const PLACES_IN_RADIUS: f64 = 6.0;
/// Closed ground, in [`Floor::pieces`].
const NO_PIECE: u32 = u32::MAX;

/// A way off the lattice between the centres of two of its cells, free for the body all along.
#[derive(Debug, Clone, PartialEq)]
pub struct Passage {
    /// Where it begins.
    pub from: Cell,
    /// Where it ends: in another piece of the lattice.
    pub to: Cell,
    /// Both centres, and the bends between them, metres.
    pub points: Vec<Point>,
}

impl Passage {
    /// Its length, metres.
    pub fn length_m(&self) -> f64 {
        self.points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
    }

    /// The cells that it leads through, its ends included.
    pub fn cells(&self, lattice: &Lattice) -> Vec<Cell> {
        let pieces = self.points.windows(2).map(|pair| Segment::new(pair[0], pair[1]));
        pieces.flat_map(|piece| lattice.cells_along(piece)).collect()
    }

    fn reversed(&self) -> Self {
        let points = self.points.iter().rev().copied().collect();
        Self { from: self.to, to: self.from, points }
    }
}

/// The passages of a floor, each in both directions.
#[derive(Debug, Clone, Default)]
pub struct Passages {
    /// By number of the cell in which they begin.
    from: BTreeMap<usize, Vec<Passage>>,
}

impl Passages {
    /// Finds the passages of a floor; a floor without a map has none.
    pub fn new(floor: &Floor) -> Self {
        let mut found = Self::default();
        if floor.map().is_none() {
            return found;
        }
        let mut pieces = Pieces::new(floor);
        let search = Search::new(floor);
        for piece in 0..pieces.count() {
            while let Some(passage) = pieces.is_apart(piece).then(|| search.way_out(&pieces, piece)).flatten()
            {
                pieces.join(passage.from, passage.to);
                found.put(floor, passage.reversed());
                found.put(floor, passage);
            }
            pieces.close(piece);
        }
        found
    }

    fn put(&mut self, floor: &Floor, passage: Passage) {
        if let Some(index) = floor.lattice().index(passage.from) {
            self.from.entry(index).or_default().push(passage);
        }
    }

    /// The passages that begin in the cell with this number.
    pub fn from(&self, index: usize) -> impl Iterator<Item = &Passage> + '_ {
        self.from.get(&index).into_iter().flatten()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.from.is_empty()
    }

    /// All of them; each is met twice, once in each direction.
    pub fn iter(&self) -> impl Iterator<Item = &Passage> + '_ {
        self.from.values().flatten()
    }

    /// Row-major: the cells that a body gets to from some cells, over moves and passages and cells that are open.
    pub fn reached(
        &self,
        floor: &Floor,
        from: impl IntoIterator<Item = Cell>,
        is_open: impl Fn(Cell) -> bool,
    ) -> Vec<bool> {
        let lattice = floor.lattice();
        let mut reached = vec![false; lattice.len()];
        let mut stack: Vec<Cell> = from.into_iter().collect();
        while let Some(cell) = stack.pop() {
            let index = lattice.index(cell).filter(|&index| floor.is_drivable(index) && is_open(cell));
            let Some(index) = index.filter(|&index| !reached[index]) else { continue };
            reached[index] = true;
            stack.extend(floor.neighbours(cell).chain(self.from(index).map(|passage| passage.to)));
        }
        reached
    }
}

/// Pieces of the lattice, gathered to groups as passages join them.
struct Pieces<'a> {
    floor: &'a Floor,
    piece_of: Vec<u32>,
    cells_of: Vec<Vec<Cell>>,
    /// Per piece, its group.
    group_of: Vec<u32>,
    /// Per group, its pieces.
    members: Vec<Vec<u32>>,
    /// Per group: whether its search came to nothing.
    closed: Vec<bool>,
    largest: u32,
}

impl<'a> Pieces<'a> {
    fn new(floor: &'a Floor) -> Self {
        let piece_of = floor.pieces();
        let count = piece_of.iter().filter(|&&piece| piece != NO_PIECE).max().map_or(0, |&last| last + 1);
        let mut cells_of = vec![Vec::new(); count as usize];
        for (cell, &piece) in floor.lattice().cells().zip(&piece_of).filter(|(_, piece)| **piece != NO_PIECE)
        {
            cells_of[piece as usize].push(cell);
        }
        let size = |piece: u32| cells_of[piece as usize].len();
        let largest = (0..count).max_by_key(|&piece| (size(piece), Reverse(piece))).unwrap_or(0);
        let closed = vec![false; count as usize];
        let members = (0..count).map(|piece| vec![piece]).collect();
        Self { floor, piece_of, cells_of, group_of: (0..count).collect(), members, closed, largest }
    }

    fn count(&self) -> u32 {
        self.group_of.len() as u32
    }

    /// Whether a piece is not joined to the largest one yet, and still may be.
    fn is_apart(&self, piece: u32) -> bool {
        let group = self.group_of[piece as usize];
        group != self.group_of[self.largest as usize] && !self.closed[group as usize]
    }

    fn close(&mut self, piece: u32) {
        let group = self.group_of[piece as usize];
        self.closed[group as usize] = true;
    }

    /// The group of a cell; `None` where no body can stand.
    fn group(&self, cell: Cell) -> Option<u32> {
        let piece = self.piece_of[self.floor.lattice().index(cell)?];
        (piece != NO_PIECE).then(|| self.group_of[piece as usize])
    }

    fn join(&mut self, one: Cell, other: Cell) {
        let (Some(one), Some(other)) = (self.group(one), self.group(other)) else { return };
        let joined = std::mem::take(&mut self.members[one as usize]);
        for &piece in &joined {
            self.group_of[piece as usize] = other;
        }
        self.members[other as usize].extend(joined);
    }

    /// The cells of a group.
    fn cells(&self, group: u32) -> impl Iterator<Item = Cell> + '_ {
        self.members[group as usize].iter().flat_map(|&piece| &self.cells_of[piece as usize]).copied()
    }
}

/// The raster of places over a floor, and which of them are searched.
struct Search<'a> {
    floor: &'a Floor,
    places: Lattice,
    /// Odd number of places across a cell: its centre is one.
    fineness: i32,
    /// By cell: joined by moves all around.
    inside: Vec<bool>,
}

impl<'a> Search<'a> {
    fn new(floor: &'a Floor) -> Self {
        let lattice = *floor.lattice();
        let across =
            (lattice.cell_m * PLACES_IN_RADIUS / floor.body_radius_m()).ceil().clamp(1.0, 99.0) as u32;
        let fineness = across | 1;
        let places = Lattice {
            cell_m: lattice.cell_m / f64::from(fineness),
            columns: lattice.columns * fineness,
            rows: lattice.rows * fineness,
            ..lattice
        };
        let inside = lattice.cells().map(|cell| is_inside(floor, cell)).collect();
        Self { floor, places, fineness: fineness as i32, inside }
    }

    /// The shortest way from the centres of a piece's group to a centre of another group.
    fn way_out(&self, pieces: &Pieces<'_>, piece: u32) -> Option<Passage> {
        let group = pieces.group_of[piece as usize];
        let mut came_from: BTreeMap<Cell, (u64, Cell)> = BTreeMap::new();
        let mut queue = BinaryHeap::new();
        for cell in pieces.cells(group) {
            let place = self.centre(cell);
            came_from.insert(place, (0, place));
            queue.push(Reverse((0, place)));
        }
        while let Some(Reverse((length, place))) = queue.pop() {
            if came_from.get(&place).is_some_and(|&(least, _)| least < length) {
                continue;
            }
            let other = |cell: &Cell| pieces.group(*cell).is_some_and(|other| other != group);
            if let Some(to) = self.cell_centred_at(place).filter(other) {
                return Some(self.passage(&came_from, place, to));
            }
            for (step, next) in self.steps(place, length == 0) {
                let length = length + step;
                if came_from.get(&next).is_none_or(|&(least, _)| length < least) {
                    came_from.insert(next, (length, place));
                    queue.push(Reverse((length, next)));
                }
            }
        }
        None
    }

    /// The open steps from a place, with their lengths in thousandths of a step.
    fn steps(&self, place: Cell, from_centre: bool) -> impl Iterator<Item = (u64, Cell)> + '_ {
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))).filter(|&way| way != (0, 0));
        let goes_on = from_centre || !self.is_inside(place);
        around.filter(move |_| goes_on).filter_map(move |(dx, dy)| {
            let next = Cell::new(place.x + dx, place.y + dy);
            let step = Segment::new(self.places.center(place), self.places.center(next));
            let open =
                self.places.contains(next) && !self.is_inside(next) && self.floor.segment_is_free(step);
            open.then_some((if dx != 0 && dy != 0 { 1414 } else { 1000 }, next))
        })
    }

    fn passage(&self, came_from: &BTreeMap<Cell, (u64, Cell)>, end: Cell, to: Cell) -> Passage {
        let mut points = vec![self.floor.lattice().center(to)];
        let mut at = end;
        while came_from[&at].1 != at {
            at = came_from[&at].1;
            points.push(self.places.center(at));
        }
        points.reverse();
        let from = self.cell_of(at);
        points[0] = self.floor.lattice().center(from);
        Passage { from, to, points: pulled_straight(self.floor, &points) }
    }

    fn centre(&self, cell: Cell) -> Cell {
        let middle = self.fineness / 2;
        Cell::new(cell.x * self.fineness + middle, cell.y * self.fineness + middle)
    }

    fn cell_of(&self, place: Cell) -> Cell {
        Cell::new(place.x.div_euclid(self.fineness), place.y.div_euclid(self.fineness))
    }

    fn cell_centred_at(&self, place: Cell) -> Option<Cell> {
        let cell = self.cell_of(place);
        (self.centre(cell) == place).then_some(cell)
    }

    fn is_inside(&self, place: Cell) -> bool {
        self.floor.lattice().index(self.cell_of(place)).is_some_and(|index| self.inside[index])
    }
}

/// Whether a cell is joined to all of its neighbours, and these to each other around it.
fn is_inside(floor: &Floor, cell: Cell) -> bool {
    let is_open = |cell: Cell| Direction::ALL.into_iter().all(|way| floor.can_move(cell, way));
    is_open(cell) && Direction::ALL.into_iter().all(|way| is_open(cell.step(way)))
}

/// The line with all points left out that it can do without.
fn pulled_straight(floor: &Floor, points: &[Point]) -> Vec<Point> {
    let mut kept = vec![points[0]];
    let mut at = 0;
    while at + 1 < points.len() {
        let is_free = |&to: &usize| floor.segment_is_free(Segment::new(points[at], points[to]));
        at = (at + 2..points.len()).rev().find(is_free).unwrap_or(at + 1);
        kept.push(points[at]);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::GridMap;

    /// A corridor at a slant between two rooms, wide enough for the body just between the centres of cells.
    fn slanted(width: i32) -> Floor {
        let (columns, rows) = (120, 60);
        let squares = (0..rows)
            .flat_map(|y| (0..columns).map(move |x| (x, y)))
            .map(|(x, y): (i32, i32)| !(30..90).contains(&x) || (y * 100 - x * 37 - 900).abs() < width * 53)
            .collect();
        let map = GridMap::new(columns as u32, rows as u32, 0.05, Point::origin(), squares).unwrap();
        Floor::new(&map, 0.4, 0.3, 0.52).unwrap()
    }

    fn far_apart() -> [Cell; 2] {
        [Cell::new(1, 3), Cell::new(13, 4)]
    }

    #[test]
    fn a_slanted_corridor_that_the_lattice_misses_is_a_passage() {
        let floor = slanted(15);
        let [here, there] = far_apart().map(|cell| floor.lattice().index(cell).unwrap());
        let pieces = floor.pieces();
        assert_ne!(pieces[here], pieces[there]);
        let passages = Passages::new(&floor);
        assert!(passages.reached(&floor, [far_apart()[0]], |_| true)[there]);
        for passage in passages.iter() {
            assert_eq!(passage.points[0], floor.lattice().center(passage.from));
            assert_eq!(passage.points.last(), Some(&floor.lattice().center(passage.to)));
            let mut steps = passage.points.windows(2);
            assert!(steps.all(|pair| floor.segment_is_free(Segment::new(pair[0], pair[1]))), "{passage:?}");
            let back = |other: &Passage| *other == passage.reversed();
            assert!(passages.from(floor.lattice().index(passage.to).unwrap()).any(back), "{passage:?}");
        }
    }

    #[test]
    fn a_corridor_narrower_than_the_body_is_none() {
        let floor = slanted(13);
        let passages = Passages::new(&floor);
        let there = floor.lattice().index(far_apart()[1]).unwrap();
        assert!(!passages.reached(&floor, [far_apart()[0]], |_| true)[there]);
    }

    #[test]
    fn passages_are_a_forest() {
        let floor = slanted(16);
        let count = floor.pieces().into_iter().filter(|&piece| piece != NO_PIECE).max().unwrap() as usize + 1;
        assert!(count > 2, "{floor}");
        assert_eq!(Passages::new(&floor).iter().count(), 2 * (count - 1));
    }
}
