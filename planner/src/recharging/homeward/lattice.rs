//! Ways along the lattice: one tree of shortest ways for each station.

use super::{Homeward, corner_s};
use crate::{Instance, Station};
use std::{cmp::Reverse, collections::BinaryHeap};
use terrain::{Cell, Direction, Point, Segment};

/// The trees of all stations.
#[derive(Debug)]
pub(crate) struct AlongLattice<'a> {
    instance: &'a Instance<'a>,
    trees: Vec<Vec<Node>>,
}

/// How a cell is left towards the station.
#[derive(Debug, Clone, Copy)]
struct Node {
    /// Seconds from standstill in this cell to standstill at the station.
    home_s: f64,
    towards: Option<Direction>,
}

impl<'a> AlongLattice<'a> {
    pub(crate) fn new(instance: &'a Instance<'a>) -> Self {
        let trees = instance.stations.iter().map(|station| tree(instance, station)).collect();
        Self { instance, trees }
    }
}

impl Homeward for AlongLattice<'_> {
    fn way(&mut self, place: Point, station: usize) -> Option<Vec<Point>> {
        let cell = self.cell_for(place, station)?;
        let lattice = self.instance.floor.lattice();
        let tree = &self.trees[station];
        let node = |cell: Cell| tree[lattice.index(cell).expect("a tree stays on the lattice")];
        let cells = std::iter::successors(Some(cell), |&at| node(at).towards.map(|way| at.step(way)));
        let dock = self.instance.dock(&self.instance.stations[station]);
        let mut points = vec![place];
        for point in cells.map(|cell| lattice.center(cell)).chain([dock]) {
            if points.last().is_some_and(|last| (last - point).norm() > 1e-9) {
                points.push(point);
            }
        }
        Some(points)
    }
}

impl AlongLattice<'_> {
    /// The cell at whose centre the lattice is entered.
    fn cell_for(&self, place: Point, station: usize) -> Option<Cell> {
        let (instance, lattice) = (self.instance, self.instance.floor.lattice());
        let own = lattice.cell_at(place)?;
        let is_linked = |cell: Cell| {
            let known =
                lattice.index(cell).is_some_and(|index| self.trees[station][index].home_s.is_finite());
            let segment = Segment::new(place, lattice.center(cell));
            let is_open = |cell: &Cell| lattice.index(*cell).is_some_and(|index| !instance.blocked[index]);
            known
                && ((segment.length() < 1e-9)
                    || lattice.cells_along(segment).iter().all(is_open)
                        && instance.floor.segment_is_free(segment))
        };
        if is_linked(own) {
            return Some(own);
        }
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| Cell::new(own.x + dx, own.y + dy)));
        let distance = |cell: &Cell| (lattice.center(*cell) - place).norm();
        around.filter(|&cell| is_linked(cell)).min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }
}

/// Shortest ways to a station from every cell; a turn costs what it takes, along the tree.
fn tree(instance: &Instance<'_>, station: &Station) -> Vec<Node> {
    let lattice = instance.floor.lattice();
    let unknown = Node { home_s: f64::INFINITY, towards: None };
    let mut tree = vec![unknown; lattice.len()];
    let first = lattice.index(station.cell).expect("a station is on the lattice");
    let mut queue = BinaryHeap::from([(Reverse(Seconds(0.0)), first, None)]);
    while let Some((Reverse(Seconds(home_s)), index, towards)) = queue.pop() {
        if tree[index].home_s <= home_s {
            continue;
        }
        tree[index] = Node { home_s, towards };
        let cell = lattice.cell(index);
        for way in Direction::ALL {
            let next = cell.step(way);
            if instance.floor.can_move(cell, way) && instance.is_open(next) {
                let turned = towards.is_some_and(|before| before != way.opposite());
                let corner_s =
                    if turned { corner_s(&instance.motion, std::f64::consts::FRAC_PI_2) } else { 0.0 };
                let index = lattice.index(next).expect("an open cell is on the lattice");
                let home_s = home_s + corner_s + instance.move_s(next, cell);
                queue.push((Reverse(Seconds(home_s)), index, Some(way.opposite())));
            }
        }
    }
    tree
}

/// A time in order of size.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Seconds(f64);

impl Eq for Seconds {}

impl PartialOrd for Seconds {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Seconds {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}
