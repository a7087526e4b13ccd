//! The least number of straight lanes along two directions on a lattice of tool-wide squares.
//!
//! ```text
//!   each square is driven along or across:   ═══╗      a lane begins at an along-square whose left neighbour is not one,
//!                                            ═══║      and at an across-square whose upper neighbour is not one
//! ```
//!
//! With x = 1 for along, these are the terms `x (1 − x_left)` and `(1 − x) x_up`: submodular, so the labelling with the fewest
//! lanes is a minimum cut, and its capacity is the number of lanes: a certificate that no labelling of this lattice has
//! fewer. Squares are neighbours where
//! wanted ground goes on from one to the other. O(E √V) for V squares and at most 2 V edges.

use crate::{configuration_space::ConfigurationSpace, ground::Ground, maximum_flow::Network};
use terrain::{Point, Vector};

/// A square belongs to the lattice with this share of it wanted, at least.
const SHARE_MIN: f64 = 0.06;

/// Tool-wide squares over the ground, turned by an angle.
#[derive(Debug, Clone)]
pub(crate) struct ToolLattice {
    /// Lower left corner of square 0.
    pub(crate) origin: Point,
    /// Direction of the rows.
    pub(crate) along: Vector,
    /// Side of a square, metres.
    pub(crate) side_m: f64,
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    /// Row-major: whether enough of a square is wanted.
    pub(crate) is_in: Vec<bool>,
    /// Row-major: whether the body gets to the right neighbour, and to the upper one.
    pub(crate) joined: Vec<[bool; 2]>,
}

/// Which squares are driven along the rows, and the lanes that makes.
#[derive(Debug, Clone)]
pub(crate) struct Orientation {
    pub(crate) lattice: ToolLattice,
    /// Row-major: along the rows, or across.
    pub(crate) is_along: Vec<bool>,
    /// The number of lanes, which is the capacity of the cut: none has fewer.
    pub(crate) lanes: u64,
}

/// A maximal run of squares of one direction.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Run {
    pub(crate) is_along: bool,
    /// Numbers of the squares, in the lattice's direction.
    pub(crate) squares: Vec<usize>,
}

impl ToolLattice {
    /// Over the wanted ground, with rows in the direction `angle_rad` and moved by `shift` (shares of a square).
    pub(crate) fn new(
        space: &ConfigurationSpace<'_>,
        ground: &Ground,
        angle_rad: f64,
        shift: [f64; 2],
    ) -> Self {
        let side_m = space.instance().floor.tool_width_m();
        let along = Vector::new(angle_rad.cos(), angle_rad.sin());
        let across = Vector::new(-along.y, along.x);
        let wanted: Vec<usize> = (0..ground.samples().len()).filter(|&place| ground.is_left(place)).collect();
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for &place in &wanted {
            let at = ground.point(place).coords;
            for (axis, place) in [along.dot(&at), across.dot(&at)].into_iter().enumerate() {
                low[axis] = low[axis].min(place);
                high[axis] = high[axis].max(place);
            }
        }
        let half_m = ground.samples().cell_m / 2.0;
        let corner = [0, 1].map(|axis| low[axis] - half_m - shift[axis] * side_m);
        let count =
            |axis: usize| ((high[axis] + half_m - corner[axis]) / side_m - 1e-6).ceil().max(1.0) as usize;
        let origin = Point::from(along * corner[0] + across * corner[1]);
        let (columns, rows) = if wanted.is_empty() { (0, 0) } else { (count(0), count(1)) };
        let mut lattice = Self {
            origin,
            along,
            side_m,
            columns,
            rows,
            is_in: Vec::new(),
            joined: vec![[false; 2]; columns * rows],
        };
        lattice.mark(ground, &wanted);
        lattice
    }

    fn mark(&mut self, ground: &Ground, wanted: &[usize]) {
        let mut samples = vec![0_u32; self.columns * self.rows];
        for &place in wanted {
            if let Some(square) = self.square_at(ground.point(place)) {
                samples[square] += 1;
            }
        }
        let whole = (self.side_m / ground.samples().cell_m).powi(2);
        self.is_in = samples.iter().map(|&count| f64::from(count) >= (SHARE_MIN * whole).max(1.0)).collect();
        for &place in wanted {
            self.join_at(ground, place);
        }
    }

    /// Joins neighbouring squares where wanted ground goes on from one to the other.
    fn join_at(&mut self, ground: &Ground, place: usize) {
        let Some(one) = self.square_at(ground.point(place)) else { return };
        let columns = ground.samples().columns as usize;
        let around = [place + 1, place + columns, place.wrapping_sub(1), place.wrapping_sub(columns)];
        for beyond in around.into_iter().filter(|&beyond| beyond < ground.samples().len()) {
            if !ground.is_left(beyond) {
                continue;
            }
            match self.square_at(ground.point(beyond)) {
                Some(other) if other == one + 1 => self.joined[one][0] = true,
                Some(other) if other == one + self.columns => self.joined[one][1] = true,
                _ => {}
            }
        }
    }

    pub(crate) fn across(&self) -> Vector {
        Vector::new(-self.along.y, self.along.x)
    }

    /// Distances of a point from the origin along the rows and across them.
    pub(crate) fn position(&self, point: Point) -> [f64; 2] {
        let from_origin = point - self.origin;
        [self.along.dot(&from_origin), self.across().dot(&from_origin)]
    }

    /// The point at these distances.
    pub(crate) fn point(&self, [along_m, across_m]: [f64; 2]) -> Point {
        self.origin + self.along * along_m + self.across() * across_m
    }

    /// Row-major number of the square that holds a point.
    pub(crate) fn square_at(&self, point: Point) -> Option<usize> {
        let [x, y] = self.position(point).map(|metres| (metres / self.side_m).floor());
        let inside = x >= 0.0 && y >= 0.0 && x < self.columns as f64 && y < self.rows as f64;
        inside.then_some(y as usize * self.columns + x as usize)
    }

    fn left(&self, square: usize) -> Option<usize> {
        (!square.is_multiple_of(self.columns) && self.is_in[square - 1] && self.joined[square - 1][0])
            .then(|| square - 1)
    }

    fn up(&self, square: usize) -> Option<usize> {
        let above = square + self.columns;
        (above < self.is_in.len() && self.is_in[above] && self.joined[square][1]).then_some(above)
    }

    fn down(&self, square: usize) -> Option<usize> {
        let below = square.checked_sub(self.columns)?;
        (self.is_in[below] && self.joined[below][1]).then_some(below)
    }

    fn squares(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.is_in.len()).filter(|&square| self.is_in[square])
    }
}

impl Orientation {
    /// The fewest lanes.
    pub(crate) fn minimum(lattice: ToolLattice) -> Self {
        let squares = lattice.is_in.len();
        let (along, across) = (squares, squares + 1);
        let mut network = Network::new(squares + 2);
        for square in lattice.squares() {
            network.add(square, lattice.left(square).unwrap_or(across), 1);
            network.add(lattice.up(square).unwrap_or(along), square, 1);
        }
        let (lanes, is_along) = network.minimum_cut(along, across);
        let found = Self { is_along: is_along[..squares].to_vec(), lattice, lanes };
        assert_eq!(found.runs().len() as u64, found.lanes, "the cut is the number of lanes");
        found
    }

    /// The lanes as runs of squares.
    pub(crate) fn runs(&self) -> Vec<Run> {
        let mut runs = Vec::new();
        for first in self.lattice.squares() {
            let is_along = self.is_along[first];
            let same = |square: &usize| self.is_along[*square] == is_along;
            let before = if is_along { self.lattice.left(first) } else { self.lattice.up(first) };
            if before.as_ref().is_some_and(same) {
                continue;
            }
            let next = |&square: &usize| {
                let next = if is_along {
                    Some(square + 1).filter(|&next| {
                        next < self.lattice.is_in.len() && self.lattice.left(next) == Some(square)
                    })
                } else {
                    self.lattice.down(square)
                };
                next.filter(|next| self.lattice.is_in[*next]).filter(same)
            };
            let mut squares: Vec<usize> = std::iter::successors(Some(first), next).collect();
            if !is_along {
                squares.reverse();
            }
            runs.push(Run { is_along, squares });
        }
        runs
    }
}
