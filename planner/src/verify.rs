//! Checks any plan, knowing nothing of how it was made: complete, connected, on free ground.
//!
//! Routes are lines of points. One that goes from cell centre to cell centre by the moves of the floor passes cells,
//! and every cell to visit must be passed. Any other line must be free for the body's disc all along and keep out of
//! blocked cells; it is judged by what the tool's disc sweeps. Where robots have a battery, no stretch between two
//! charges may take longer than it lasts, and the time that robots wait for each other at chargers counts.

mod charging;

use crate::{Instance, Mode, Plan, Route};
use terrain::{Cell, Direction, Point, Segment, SweptRaster, angle_between};
use thiserror::Error;

/// Places nearer than this are the same, metres.
const TOLERANCE_M: f64 = 1e-6;

/// What a plan costs, measured from its points alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Figures {
    /// Time until the last robot is done (its delay before the start included), seconds.
    pub makespan_s: f64,
    /// Per robot: time, seconds. Charging, and waiting for a charger, is part of it.
    pub cost_s: Vec<f64>,
    /// Per robot: of this, waiting at chargers, seconds.
    pub waiting_s: Vec<f64>,
    /// Per robot: charges on the way.
    pub charges: Vec<usize>,
    /// Per robot: way, metres.
    pub length_m: Vec<f64>,
    /// Per robot: turns in place of more than 1°.
    pub turns: Vec<u32>,
    /// Area swept at least once, as a share of the area to be swept, by footprint.
    pub coverage_ratio: f64,
    /// Area swept more than once, as a share of the area swept: cells entered again ÷ cells entered. For plans that
    /// leave the lattice: way × width of the tool beyond the area swept, as a share of it.
    pub overlap_ratio: f64,
}

/// Why a plan does not hold.
#[derive(Debug, Clone, Error, PartialEq)]
pub enum VerifyError {
    /// Not one route per robot.
    #[error("{found} routes for {expected} robots")]
    RouteCount {
        /// Routes in the plan.
        found: usize,
        /// Robots in the instance.
        expected: usize,
    },
    /// A route does not begin where its robot stands.
    #[error("the route of robot {robot} does not begin where it stands, in cell {start}")]
    WrongStart {
        /// Number of the robot.
        robot: usize,
        /// Its start.
        start: Cell,
    },
    /// A cell to visit that no route passes.
    #[error("cell {0} is left out")]
    Gap(Cell),
    /// A plan that leaves the lattice sweeps too little.
    #[error(
        "{swept} of the area to be swept is swept, at least {least} was asked for; cell {cell} is not swept whole"
    )]
    NotSwept {
        /// Share swept.
        swept: f64,
        /// Share asked for.
        least: f64,
        /// A cell that lacks some.
        cell: Cell,
    },
    /// A line that leaves the ground on which the body fits, or enters a blocked cell.
    #[error("robot {robot} would drive off free ground between point {from} and {to} of its route")]
    OffGround {
        /// Number of the robot.
        robot: usize,
        /// Number of the point before.
        from: usize,
        /// Number of the point after.
        to: usize,
    },
    /// A place that is not a number.
    #[error("point {point} of robot {robot} is not finite")]
    NotFinite {
        /// Number of the robot.
        robot: usize,
        /// Number of the point.
        point: usize,
    },
    /// A charge where there is no station, or out of order.
    #[error("robot {robot} would charge at point {point} of its route, where no station is")]
    NoStation {
        /// Number of the robot.
        robot: usize,
        /// Number of the point.
        point: usize,
    },
    /// A stretch from a charge (or the start) to the next one (or the end) that the battery does not last.
    #[error("stretch {stretch} of robot {robot} takes {takes_s} s, its battery lasts {lasts_s} s")]
    BatteryEmpty {
        /// Number of the robot.
        robot: usize,
        /// Charges before it.
        stretch: usize,
        /// How long it takes.
        takes_s: f64,
        /// How long the battery lasts, the reserve left out.
        lasts_s: f64,
    },
    /// The mode asks to return, and a route ends elsewhere.
    #[error("robot {0} does not return to its start")]
    NoReturn(usize),
}

/// Checks a plan against its instance and measures it.
///
/// # Errors
///
/// [`VerifyError`]: the first thing found wrong.
pub fn verify(instance: &Instance<'_>, plan: &Plan) -> Result<Figures, VerifyError> {
    let expected = instance.starts.len();
    if plan.routes.len() != expected {
        return Err(VerifyError::RouteCount { found: plan.routes.len(), expected });
    }
    let lattice = *instance.floor.lattice();
    let mut entered = vec![0_u32; lattice.len()];
    let mut raster = SweptRaster::new(lattice);
    let mut along_lattice = true;
    for (robot, route) in plan.routes.iter().enumerate() {
        along_lattice &= check_route(instance, robot, route, &mut entered)?;
        charging::check(instance, robot, route)?;
        sweep(instance, route, &mut raster);
    }
    let figures = measure(instance, plan, &entered, &raster, along_lattice);
    let missing = |index: &usize| {
        let (index, wanted) = (*index, instance.wanted(*index));
        instance.visit[index]
            && if along_lattice { entered[index] == 0 } else { wanted & !raster.samples(index) != 0 }
    };
    match (0..lattice.len()).find(missing).map(|index| lattice.cell(index)) {
        Some(cell) if along_lattice => Err(VerifyError::Gap(cell)),
        Some(cell) if figures.coverage_ratio < instance.coverage_min => {
            Err(VerifyError::NotSwept { swept: figures.coverage_ratio, least: instance.coverage_min, cell })
        }
        _ => Ok(figures),
    }
}

/// Checks one route and counts the cells it enters; whether it goes along the lattice all the way.
fn check_route(
    instance: &Instance<'_>,
    robot: usize,
    route: &Route,
    entered: &mut [u32],
) -> Result<bool, VerifyError> {
    let start = &instance.starts[robot];
    let Some(&first) = route.points.first() else { return Ok(true) };
    if let Some(point) = route.points.iter().position(|point| !(point.x.is_finite() && point.y.is_finite())) {
        return Err(VerifyError::NotFinite { robot, point });
    }
    if (first - instance.place(start)).norm() > TOLERANCE_M {
        return Err(VerifyError::WrongStart { robot, start: start.cell });
    }
    enter(instance, entered, start.cell);
    let mut along_lattice = true;
    for (from, pair) in route.points.windows(2).enumerate() {
        let off_ground = VerifyError::OffGround { robot, from, to: from + 1 };
        if let Some(cell) = lattice_move(instance, pair[0], pair[1]) {
            enter(instance, entered, cell);
        } else {
            let way = free_way(instance, Segment::new(pair[0], pair[1])).ok_or(off_ground)?;
            // To the centre of the cell with the start or a charger and back: where the lattice begins.
            let docks = |cell| cell == start.cell || instance.stations.iter().any(|dock| dock.cell == cell);
            along_lattice &= way.iter().all(|&cell| cell == way[0] && docks(cell));
            way.into_iter().skip(1).for_each(|cell| enter(instance, entered, cell));
        }
    }
    let back = route.points.last().is_some_and(|&last| (last - first).norm() <= TOLERANCE_M);
    if instance.mode == Mode::CoverAndReturn && !back {
        return Err(VerifyError::NoReturn(robot));
    }
    Ok(along_lattice)
}

/// The cell that a move from the centre of a cell to that of its neighbour, or to itself, ends in.
pub(crate) fn lattice_move(instance: &Instance<'_>, from: Point, to: Point) -> Option<Cell> {
    let lattice = instance.floor.lattice();
    let center = |point: Point| {
        lattice.cell_at(point).filter(|&cell| (point - lattice.center(cell)).norm() <= TOLERANCE_M)
    };
    let (from, to) = (center(from)?, center(to)?);
    let moves =
        from == to || Direction::between(from, to).is_some_and(|way| instance.floor.can_move(from, way));
    (moves && instance.is_open(to)).then_some(to)
}

/// The cells that a free straight line leads through; `None` when the body does not fit or a cell is blocked.
fn free_way(instance: &Instance<'_>, segment: Segment) -> Option<Vec<Cell>> {
    let lattice = instance.floor.lattice();
    let cells = lattice.cells_along(segment);
    let ends_are_on_it = lattice.cell_at(segment.from).is_some() && lattice.cell_at(segment.to).is_some();
    let open = cells.iter().all(|&cell| lattice.index(cell).is_some_and(|index| !instance.blocked[index]));
    (ends_are_on_it && open && instance.floor.segment_is_free(segment)).then_some(cells)
}

fn enter(instance: &Instance<'_>, entered: &mut [u32], cell: Cell) {
    if let Some(index) = instance.floor.lattice().index(cell) {
        entered[index] += 1;
    }
}

fn sweep(instance: &Instance<'_>, route: &Route, raster: &mut SweptRaster) {
    let radius_m = instance.floor.tool_width_m() / 2.0;
    for pair in route.points.windows(2) {
        raster.sweep(Segment::new(pair[0], pair[1]), radius_m, |_| {});
    }
    if let [only] = route.points[..] {
        raster.sweep(Segment::new(only, only), radius_m, |_| {});
    }
}

/// Per robot: time, seconds.
pub(crate) fn costs_s(instance: &Instance<'_>, plan: &Plan) -> Vec<f64> {
    charging::play(instance, plan).iter().map(|shift| shift.cost_s).collect()
}

fn measure(
    instance: &Instance<'_>,
    plan: &Plan,
    entered: &[u32],
    raster: &SweptRaster,
    along_lattice: bool,
) -> Figures {
    let shifts = charging::play(instance, plan);
    let cost_s: Vec<f64> = shifts.iter().map(|shift| shift.cost_s).collect();
    let (mut wanted, mut swept) = (0_u64, 0_u64);
    for index in (0..entered.len()).filter(|&index| instance.visit[index]) {
        let here = instance.wanted(index);
        wanted += u64::from(here.count_ones());
        swept += u64::from((here & raster.samples(index)).count_ones());
    }
    let overlap = if along_lattice { entered_again(entered) } else { swept_again(instance, plan, raster) };
    Figures {
        makespan_s: cost_s.iter().copied().fold(0.0, f64::max),
        cost_s,
        waiting_s: shifts.iter().map(|shift| shift.waiting_s).collect(),
        charges: plan.routes.iter().map(|route| route.charges.len()).collect(),
        length_m: plan.routes.iter().map(length_m).collect(),
        turns: plan.routes.iter().map(turns).collect(),
        coverage_ratio: if wanted == 0 { 1.0 } else { swept as f64 / wanted as f64 },
        overlap_ratio: overlap,
    }
}

fn entered_again(entered: &[u32]) -> f64 {
    let entries: u64 = entered.iter().map(|&times| u64::from(times)).sum();
    let again: u64 = entered.iter().map(|&times| u64::from(times.saturating_sub(1))).sum();
    if entries == 0 { 0.0 } else { again as f64 / entries as f64 }
}

fn swept_again(instance: &Instance<'_>, plan: &Plan, raster: &SweptRaster) -> f64 {
    let lattice = instance.floor.lattice();
    let samples: u64 = (0..lattice.len()).map(|index| u64::from(raster.samples(index).count_ones())).sum();
    let swept_m2 = SweptRaster::area_m2(lattice, samples);
    let way_m: f64 = plan.routes.iter().map(length_m).sum();
    if swept_m2 == 0.0 { 0.0 } else { (way_m * instance.floor.tool_width_m() / swept_m2 - 1.0).max(0.0) }
}

fn length_m(route: &Route) -> f64 {
    route.points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

fn turns(route: &Route) -> u32 {
    let mut heading: Option<f64> = None;
    let mut turns = 0;
    for pair in route.points.windows(2) {
        let step = pair[1] - pair[0];
        if step.norm() < 1e-9 {
            continue;
        }
        let towards = step.y.atan2(step.x);
        let turned = heading.is_some_and(|from| angle_between(from, towards).abs() > 1.0_f64.to_radians());
        turns += u32::from(turned);
        heading = Some(towards);
    }
    turns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Start;
    use terrain::{Floor, GridMap, Lattice, MotionModel};

    const MOTION: MotionModel = MotionModel {
        speed_m_per_s: 0.5,
        acceleration_m_per_s2: 0.5,
        angular_speed_rad_per_s: 0.8,
        angular_acceleration_rad_per_s2: f64::INFINITY,
        brakes: true,
    };

    /// Three columns, two rows; the middle of the upper row is a wall.
    fn floor() -> Floor {
        let lattice = Lattice { origin: Point::origin(), cell_m: 0.5, columns: 3, rows: 2 };
        Floor::from_cells(lattice, &[true, true, true, true, false, true], 0.177, 0.75)
    }

    const ALL: [(i32, i32); 7] = [(0, 1), (0, 0), (1, 0), (2, 0), (2, 1), (2, 0), (1, 0)];

    fn route(cells: &[(i32, i32)]) -> Route {
        let lattice = *floor().lattice();
        Route::new(cells.iter().map(|&(x, y)| lattice.center(Cell::new(x, y))).collect())
    }

    fn judge(routes: Vec<Route>, change: impl FnOnce(&mut Instance<'_>)) -> Result<Figures, VerifyError> {
        let floor = floor();
        let starts = vec![Start::at(Cell::new(0, 1))];
        let mut instance = Instance::whole_floor(&floor, starts, MOTION, Mode::Cover);
        change(&mut instance);
        verify(&instance, &Plan { routes })
    }

    #[test]
    fn a_good_plan_is_measured() {
        let figures =
            judge(vec![route(&ALL[..5])], |instance| instance.starts[0].available_in_s = 7.0).unwrap();
        assert_eq!(figures.turns, [2]);
        assert!((figures.length_m[0] - 2.0).abs() < 1e-9);
        assert!((figures.coverage_ratio - 1.0).abs() < 1e-9);
        assert!(figures.overlap_ratio.abs() < 1e-9);
        let quarter_turn_s = std::f64::consts::FRAC_PI_2 / 0.8;
        let runs_s = 2.0 * MOTION.run_s(0.5) + MOTION.run_s(1.0);
        assert!((figures.makespan_s - (7.0 + runs_s + 2.0 * quarter_turn_s)).abs() < 1e-9);
    }

    #[test]
    fn cells_entered_again_are_overlap() {
        let figures = judge(vec![route(&ALL)], |_| {}).unwrap();
        assert!((figures.overlap_ratio - 2.0 / 7.0).abs() < 1e-9);
    }

    #[test]
    fn a_cell_left_out_is_a_gap() {
        assert_eq!(judge(vec![route(&ALL[..4])], |_| {}), Err(VerifyError::Gap(Cell::new(2, 1))));
        assert_eq!(judge(vec![Route::default()], |_| {}), Err(VerifyError::Gap(Cell::new(0, 0))));
    }

    #[test]
    fn a_line_through_a_wall_a_corner_or_a_cell_between_is_off_ground() {
        let off_ground = Err(VerifyError::OffGround { robot: 0, from: 0, to: 1 });
        for next in [(1, 1), (1, 0), (2, 1), (0, 2)] {
            assert_eq!(judge(vec![route(&[(0, 1), next])], |_| {}), off_ground, "{next:?}");
        }
    }

    #[test]
    fn a_blocked_cell_may_not_be_entered() {
        let found = judge(vec![route(&ALL[..5])], |instance| instance.blocked[1] = true);
        assert_eq!(found, Err(VerifyError::OffGround { robot: 0, from: 1, to: 2 }));
    }

    #[test]
    fn a_route_begins_at_its_start() {
        let start = Cell::new(0, 1);
        assert_eq!(judge(vec![route(&ALL[1..])], |_| {}), Err(VerifyError::WrongStart { robot: 0, start }));
    }

    #[test]
    fn every_robot_has_a_route() {
        assert_eq!(judge(Vec::new(), |_| {}), Err(VerifyError::RouteCount { found: 0, expected: 1 }));
    }

    #[test]
    fn a_place_is_a_number() {
        let mut broken = route(&ALL[..5]);
        broken.points[3].y = f64::NAN;
        assert_eq!(judge(vec![broken], |_| {}), Err(VerifyError::NotFinite { robot: 0, point: 3 }));
    }

    #[test]
    fn who_has_to_return_returns() {
        let comes_back = |instance: &mut Instance<'_>| instance.mode = Mode::CoverAndReturn;
        assert_eq!(judge(vec![route(&ALL)], comes_back), Err(VerifyError::NoReturn(0)));
        let home = [&ALL[..], &[(0, 0), (0, 1)]].concat();
        assert!(judge(vec![route(&home)], comes_back).is_ok());
    }

    /// Four metres by one, without inner walls: the body (radius 0.2 m) has 0.6 m to either side of the middle.
    fn judge_line(points: &[(f64, f64)], coverage_min: f64) -> Result<Figures, VerifyError> {
        let map = GridMap::from_drawing("........\n........", 0.5).unwrap();
        let floor = Floor::new(&map, 0.5, 0.2, 1.1).unwrap();
        let points: Vec<Point> = points.iter().map(|&(x, y)| Point::new(x, y)).collect();
        let start = Start { point: Some(points[0]), ..Start::at(Cell::new(0, 0)) };
        let mut instance = Instance::whole_floor(&floor, vec![start], MOTION, Mode::Cover);
        instance.coverage_min = coverage_min;
        instance.blocked[15] = coverage_min < 0.1;
        verify(&instance, &Plan { routes: vec![Route::new(points)] })
    }

    #[test]
    fn a_line_off_the_lattice_is_judged_by_what_it_sweeps() {
        let figures = judge_line(&[(0.25, 0.499), (3.75, 0.499)], 0.95).unwrap();
        assert!(figures.coverage_ratio > 0.95, "{figures:?}");
        let short = judge_line(&[(0.25, 0.499), (2.0, 0.499)], 0.95);
        assert!(matches!(short, Err(VerifyError::NotSwept { cell: Cell { x: 4, y: 0 }, .. })), "{short:?}");
        assert!(judge_line(&[(0.25, 0.499), (2.0, 0.499)], 0.5).is_ok());
    }

    #[test]
    fn a_line_off_the_lattice_keeps_the_body_from_walls_and_blocked_cells() {
        let off_ground = Err(VerifyError::OffGround { robot: 0, from: 0, to: 1 });
        assert_eq!(judge_line(&[(0.25, 0.21), (3.75, 0.19)], 0.5), off_ground);
        assert_eq!(judge_line(&[(0.25, 0.21), (4.5, 0.21)], 0.5), off_ground);
        assert_eq!(judge_line(&[(0.25, 0.21), (3.75, 0.79)], 0.01), off_ground, "cell 15 is blocked");
        assert!(judge_line(&[(0.25, 0.21), (3.2, 0.79)], 0.01).is_ok());
    }
}
