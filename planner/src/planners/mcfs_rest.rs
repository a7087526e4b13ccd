//! Visits what smooth lines leave: from the nearest route along the lattice, and back the same way.

use crate::{Instance, Route};
use std::collections::VecDeque;
use terrain::{Cell, Lattice, Point, Segment, SweptRaster};

/// How much more than asked for is swept.
const SPARE: f64 = 1e-3;

/// Adds detours until enough is swept, or every cell that lacks something was visited.
pub(super) fn visit_rest(instance: &Instance<'_>, routes: &mut [Route]) {
    let mut rest = Rest::new(instance, routes);
    let asked = (instance.coverage_min + SPARE).min(1.0);
    let mut cells = rest.lacking();
    cells.sort_by_key(|&(cell, lacks)| (std::cmp::Reverse(lacks), cell));
    for (cell, _) in cells {
        if rest.coverage() >= asked {
            break;
        }
        if rest.lacks(cell) > 0
            && let Some(detour) = rest.detour(routes, cell)
        {
            rest.insert(routes, &detour);
        }
    }
}

struct Rest<'a> {
    instance: &'a Instance<'a>,
    lattice: Lattice,
    raster: SweptRaster,
}

/// Out from a point of a route and back.
struct Detour {
    robot: usize,
    after: usize,
    way: Vec<Cell>,
}

impl<'a> Rest<'a> {
    fn new(instance: &'a Instance<'a>, routes: &[Route]) -> Self {
        let lattice = *instance.floor.lattice();
        let mut rest = Self { instance, lattice, raster: SweptRaster::new(lattice) };
        for route in routes {
            rest.sweep(&route.points);
        }
        rest
    }

    fn sweep(&mut self, points: &[Point]) {
        let radius_m = self.instance.floor.tool_width_m() / 2.0;
        for pair in points.windows(2) {
            self.raster.sweep(Segment::new(pair[0], pair[1]), radius_m, |_| {});
        }
        if let [only] = points {
            self.raster.sweep(Segment::new(*only, *only), radius_m, |_| {});
        }
    }

    fn lacking(&self) -> Vec<(Cell, u32)> {
        let cells = self.lattice.cells().map(|cell| (cell, self.lacks(cell)));
        cells.filter(|&(_, lacks)| lacks > 0).collect()
    }

    /// Samples of a cell still to be swept.
    fn lacks(&self, cell: Cell) -> u32 {
        let Some(index) = self.lattice.index(cell).filter(|&index| self.instance.visit[index]) else {
            return 0;
        };
        (self.instance.floor.required(index) & !self.raster.samples(index)).count_ones()
    }

    fn coverage(&self) -> f64 {
        let visit = (0..self.lattice.len()).filter(|&index| self.instance.visit[index]);
        let wanted: u32 = visit.map(|index| self.instance.floor.required(index).count_ones()).sum();
        let lacking: u32 = self.lacking().iter().map(|&(_, lacks)| lacks).sum();
        1.0 - f64::from(lacking) / f64::from(wanted.max(1))
    }

    /// The shortest way along the lattice from a cell to one in which a route has a point.
    fn detour(&self, routes: &[Route], target: Cell) -> Option<Detour> {
        let joins = self.joins(routes);
        let mut towards: Vec<Option<Cell>> = vec![None; self.lattice.len()];
        let start = self.lattice.index(target)?;
        towards[start] = Some(target);
        let mut queue = VecDeque::from([target]);
        while let Some(cell) = queue.pop_front() {
            if let Some((robot, after)) = joins[self.lattice.index(cell)?] {
                return Some(Detour { robot, after, way: self.way_back(&towards, cell, target) });
            }
            for next in self.instance.neighbours(cell) {
                let index = self.lattice.index(next)?;
                if towards[index].is_none() {
                    towards[index] = Some(cell);
                    queue.push_back(next);
                }
            }
        }
        None
    }

    /// By cell: robot and number of a point from which one can drive straight to the cell's centre.
    fn joins(&self, routes: &[Route]) -> Vec<Option<(usize, usize)>> {
        let mut joins = vec![None; self.lattice.len()];
        for (robot, route) in routes.iter().enumerate() {
            for (after, &point) in route.points.iter().enumerate() {
                let Some(cell) = self.lattice.cell_at(point) else { continue };
                let Some(index) = self.lattice.index(cell) else { continue };
                let straight = Segment::new(point, self.lattice.center(cell));
                if joins[index].is_none()
                    && self.instance.is_open(cell)
                    && self.instance.floor.segment_is_free(straight)
                {
                    joins[index] = Some((robot, after));
                }
            }
        }
        joins
    }

    fn way_back(&self, towards: &[Option<Cell>], from: Cell, target: Cell) -> Vec<Cell> {
        let mut way = vec![from];
        let mut cell = from;
        while cell != target {
            let next = self.lattice.index(cell).and_then(|index| towards[index]);
            cell = next.expect("the search came this way");
            way.push(cell);
        }
        way
    }

    fn insert(&mut self, routes: &mut [Route], detour: &Detour) {
        let points = &mut routes[detour.robot].points;
        let out = detour.way.iter().map(|&cell| self.lattice.center(cell));
        let back = detour.way.iter().rev().skip(1).map(|&cell| self.lattice.center(cell));
        let mut new: Vec<Point> = out.chain(back).collect();
        new.push(points[detour.after]);
        let swept = [&points[detour.after..=detour.after], &new[..]].concat();
        let behind = points.split_off(detour.after + 1);
        points.extend(new);
        points.extend(behind);
        self.sweep(&swept);
    }
}
