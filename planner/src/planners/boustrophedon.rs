//! Boustrophedon coverage with a choice of entry and exit.
//!
//! **Problem.** One robot with a disc for a body and a disc for a tool sweeps a floor with obstacles of any shape and is back
//! as early as possible. Lanes need not follow the lattice.
//! **Idea.** Cut the ground into cells that can be swept by parallel lanes without crossing an obstacle, each in its own direction, so
//! that the sum of their altitudes (hence about the number of lanes and turns) is least. Each cell can be driven from any of
//! four corners. A tour chooses the order of the cells and their corners together, so that the ways between them
//! are short; ways are shortest ones for the body. What lanes leave out is swept on side trips.
//! **Guarantee.** The decomposition is optimal for up to ten fragments, heuristic above. The choice of corners is optimal
//! for the order that is found; for up to eight cells all 2ⁿ choices are searched. Nothing is promised for the order.
//! **Complexity.** O(p) for p places of the raster, for each direction; O(3^10) for each ten fragments; one bounded search per cell corner;
//! O(n²) for a round of 2-opt over n cells.
//! **Paper.** *An Efficient Solution to Boustrophedon Coverage of Unstructured Environments with Finite Resources* (the
//! paper of issue 4), after W. Huang: Optimal line-sweep-based decompositions for coverage algorithms. ICRA 2001.
//! **Departures.** Cells are cut on the raster of places where the centre of the body may be, not on polygons; fragments are
//! the cuts of two sweeps at right angles laid over each other. A row may be torn by a gap of half a tool, an altitude below one tool
//! counts as one. Corners are chosen by a shortest path through layers instead of 2ⁿ enumerated problems; with an even
//! number of lanes the paper's two paths are each other's reverse, here the other pair is looked at, too. Neighbouring
//! cells share rows of lanes. Several robots: the tour is cut at cells.
//! **Symbols.** w: tool width; K = 10: most fragments solved exactly at once; cᵢ: `CellPath`; Boustᵢⱼ: `CellPath::paths`;
//! start, end: the ends of a path; dist: `Distances`.

mod cell_path;
mod cell_tour;
mod christofides;
mod directions;
mod distances;
mod fragments;
mod line_sweep;
mod merging;
mod msa;
mod raster;
pub(super) mod residual;
mod robots;
mod segmentation;

pub(super) use segmentation::Segmentation;

use crate::{
    Instance, Mode, Plan, PlanError, PlanOptions, Route,
    configuration_space::ConfigurationSpace,
    transfers::{Transfers, Way},
};
use cell_path::{CellPath, Widths, cell_paths};
use cell_tour::{Costs, Stop, tour};
use christofides::christofides;
use distances::Distances;
use terrain::Point;

/// How cells get their order and their corners.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Order {
    /// Order and corners together, by the ways between the cells.
    Alternatives,
    /// Christofides' tour over the lower left corners, each cell entered there.
    Christofides,
}

/// Plans as the paper.
pub(super) fn plan(instance: &Instance<'_>, _options: &PlanOptions) -> Result<Plan, PlanError> {
    cover(instance, Segmentation::MinimumSumOfAltitudes, Order::Alternatives)
}

/// Cells, an order, routes, and what is left.
pub(super) fn cover(
    instance: &Instance<'_>,
    segmentation: Segmentation,
    order: Order,
) -> Result<Plan, PlanError> {
    let space = ConfigurationSpace::new(instance);
    let mut transfers = Transfers::new(&space);
    let step_m = space.places().cell_m;
    let widths = Widths {
        tool: instance.floor.tool_width_m() / step_m,
        body_radius: instance.floor.body_radius_m() / step_m,
    };
    let (fragments, regions) = segmentation::segment(&space, widths, segmentation);
    let cells = cell_paths(&fragments, &regions, widths, &mut transfers);
    let stations: Vec<Point> = instance.starts.iter().map(|start| instance.center(start.cell)).collect();
    let corners = cells.iter().flat_map(CellPath::ends);
    let distances = Distances::new(&mut transfers, &corners.chain(stations).collect::<Vec<_>>());
    let inner_m: Vec<[f64; 2]> =
        cells.iter().map(|cell| cell.paths.each_ref().map(|path| path.length_m)).collect();
    let mut routes: Vec<Route> =
        instance.starts.iter().map(|start| Route::new(vec![instance.place(start)])).collect();
    for group in robots::groups(&distances, cells.len(), instance.starts.len()) {
        let Some(&first) = group.robots.first() else { continue };
        let costs = |robot: usize| Costs {
            distances: &distances,
            station: 4 * cells.len() + robot,
            inner_m: &inner_m,
            returns: instance.mode == Mode::CoverAndReturn,
        };
        let stops = match order {
            Order::Alternatives => tour(&costs(first), &group.cells),
            Order::Christofides => bc_sweep(&costs(first), &cells, &group.cells),
        };
        for (robot, stops) in robots::divide(instance, &group.robots, &stops, costs) {
            drive(&mut transfers, &cells, &stops, &mut routes[robot])?;
        }
    }
    residual::sweep_the_rest(&mut transfers, &mut routes, instance.coverage_min);
    for (robot, route) in routes.iter_mut().enumerate() {
        finish(&mut transfers, robot, route)?;
    }
    let mut plan = Plan { routes };
    residual::drop_idle(instance, &mut plan);
    residual::visit_gaps(&mut transfers, &mut plan);
    Ok(plan)
}

/// Christofides' order over the station and the lower left corners.
fn bc_sweep(costs: &Costs<'_>, cells: &[CellPath], group: &[usize]) -> Vec<Stop> {
    let stops: Vec<Stop> =
        group.iter().map(|&cell| Stop { cell, variant: cells[cell].lower_left() }).collect();
    let end = |node: usize| node.checked_sub(1).map_or(costs.station, |at| stops[at].entry());
    let order = christofides(stops.len() + 1, |one, other| costs.distances.between(end(one), end(other)));
    order.into_iter().skip(1).map(|node| stops[node - 1]).collect()
}

/// Drives from stop to stop.
fn drive(
    transfers: &mut Transfers<'_, '_>,
    cells: &[CellPath],
    stops: &[Stop],
    route: &mut Route,
) -> Result<(), PlanError> {
    for stop in stops {
        let path = cells[stop.cell].variant(stop.variant);
        go(transfers, &mut route.points, path.points[0])?;
        route.points.extend(path.points);
    }
    Ok(())
}

/// Goes on along the shortest way.
fn go(transfers: &mut Transfers<'_, '_>, points: &mut Vec<Point>, to: Point) -> Result<(), PlanError> {
    let from = *points.last().expect("a route begins where its robot stands");
    let instance = transfers.space().instance();
    let unreachable = || {
        let cell = instance.floor.lattice().cell_at(to);
        PlanError::Unreachable(cell.unwrap_or(terrain::Cell::new(0, 0)))
    };
    points.extend(transfers.way(from, to).ok_or_else(unreachable)?.points);
    Ok(())
}

/// Back to the start where that is asked for.
fn finish(transfers: &mut Transfers<'_, '_>, robot: usize, route: &mut Route) -> Result<(), PlanError> {
    let instance = transfers.space().instance();
    route.points.dedup_by(|a, b| (*a - *b).norm() < 1e-9);
    if route.points.len() > 1 && instance.mode == Mode::CoverAndReturn {
        go(transfers, &mut route.points, instance.place(&instance.starts[robot]))?;
        route.points.dedup_by(|a, b| (*a - *b).norm() < 1e-9);
    }
    Ok(())
}

impl CellPath {
    /// Both ends of both paths.
    fn ends(&self) -> [Point; 4] {
        let ends = |path: &Way| [path.points[0], path.points[path.points.len() - 1]];
        let ([a, b], [c, d]) = (ends(&self.paths[0]), ends(&self.paths[1]));
        [a, b, c, d]
    }

    /// One of the four ways to drive it.
    fn variant(&self, variant: usize) -> Way {
        let path = &self.paths[variant / 2];
        if variant.is_multiple_of(2) { path.clone() } else { path.reversed() }
    }

    /// The variant that begins in the lower left corner.
    fn lower_left(&self) -> usize {
        let ends = self.ends();
        let height = |variant: usize| ends[variant].x + ends[variant].y;
        (0..4).min_by(|&a, &b| height(a).total_cmp(&height(b))).expect("there are four")
    }
}

#[cfg(test)]
mod tests {
    use crate::{Instance, Mode, PlanOptions, Start, plan, test_motion::MOTION};
    use terrain::{Cell, Direction, Floor, Lattice, Point};

    /// Two pieces of ground that touch at a thin wall, each with its robot.
    #[test]
    fn a_wall_between_two_cells_parts_them() {
        let lattice = Lattice { origin: Point::origin(), cell_m: 0.5, columns: 2, rows: 4 };
        let free = [true, true, true, false, true, true, true, false];
        let mut floor = Floor::from_cells(lattice, &free, 0.177, 0.75);
        floor.close_move(Cell::new(0, 1), Direction::North);
        let starts = [Cell::new(0, 0), Cell::new(0, 2)].map(Start::at).to_vec();
        let mut instance = Instance::whole_floor(&floor, starts, MOTION, Mode::Cover);
        instance.visit = (0..8).map(|cell| cell % 2 == 0).collect();
        for planner in ["boustrophedon", "bc-sweep-horizontal", "bc-sweep-vertical", "bc-sweep-hybrid"] {
            let options = PlanOptions { planner: planner.to_owned(), ..PlanOptions::default() };
            let planned = plan(&instance, &options);
            assert!(planned.is_ok(), "{planner}: {planned:?}");
        }
    }
}
