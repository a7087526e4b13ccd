//! Which pieces of a plan do work: those that sweep, or along the lattice enter, what is wanted and was not yet.
//!
//! All others may be left out without a loss.

use crate::{Instance, Plan, Route, verify::lattice_move};
use terrain::{Point, Segment, SweptRaster};

/// What has been worked so far, route by route and piece by piece.
pub(crate) struct Work<'a> {
    instance: &'a Instance<'a>,
    along_lattice: bool,
    entered: Vec<bool>,
    swept: SweptRaster,
}

impl<'a> Work<'a> {
    pub(crate) fn new(instance: &'a Instance<'a>, plan: &Plan) -> Self {
        let lattice = *instance.floor.lattice();
        let along_lattice = plan.routes.iter().all(|route| is_along_lattice(instance, route));
        let mut entered = vec![false; lattice.len()];
        // Who has no route is not counted on where it stands.
        let driven = instance.starts.iter().zip(&plan.routes).filter(|(_, route)| !route.points.is_empty());
        for (start, _) in driven {
            if let Some(index) = lattice.index(start.cell) {
                entered[index] = true;
            }
        }
        Self { instance, along_lattice, entered, swept: SweptRaster::new(lattice) }
    }

    /// Whether all routes go from cell to cell.
    pub(crate) fn is_along_lattice(&self) -> bool {
        self.along_lattice
    }

    /// Drives along points: for each piece, whether it does work.
    pub(crate) fn drive(&mut self, points: &[Point]) -> Vec<bool> {
        points.windows(2).map(|pair| self.drive_piece(pair[0], pair[1])).collect()
    }

    fn drive_piece(&mut self, from: Point, to: Point) -> bool {
        let (instance, mut works) = (self.instance, false);
        if self.along_lattice {
            let entered = instance.floor.lattice().cell_at(to);
            let Some(index) = entered.and_then(|cell| instance.floor.lattice().index(cell)) else {
                return false;
            };
            let is_new = !std::mem::replace(&mut self.entered[index], true);
            return is_new && instance.visit[index];
        }
        let mut before: Vec<(usize, u64)> = Vec::new();
        let radius_m = instance.floor.tool_width_m() / 2.0;
        let segment = Segment::new(from, to);
        let margin = terrain::Vector::repeat(radius_m);
        let low = Point::from(from.coords.inf(&to.coords) - margin);
        let high = Point::from(from.coords.sup(&to.coords) + margin);
        for cell in instance.floor.lattice().cells_in_box(low, high) {
            let index = instance.floor.lattice().index(cell).filter(|&index| instance.visit[index]);
            before.extend(index.map(|index| (index, self.swept.samples(index))));
        }
        self.swept.sweep(segment, radius_m, |_| {});
        for (index, samples) in before {
            works |= instance.wanted(index) & self.swept.samples(index) & !samples != 0;
        }
        works
    }
}

fn is_along_lattice(instance: &Instance<'_>, route: &Route) -> bool {
    let on_centre = |pair: &[Point]| lattice_move(instance, pair[0], pair[1]).is_some();
    let in_a_cell = |pair: &[Point]| {
        let cell = |point: Point| instance.floor.lattice().cell_at(point);
        cell(pair[0]) == cell(pair[1])
    };
    let last = route.points.len().saturating_sub(2);
    let mut pieces = route.points.windows(2).enumerate();
    pieces.all(|(piece, pair)| on_centre(pair) || (piece == 0 || piece == last) && in_a_cell(pair))
}
