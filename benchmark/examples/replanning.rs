//! How long the first new order takes after a robot is lost or ground is blocked: user CPU of the repair of lines, next
//! to planning afresh, half-way through a floor plan of ../shared/instances/indoor.
//!
//! `cargo run --release -p benchmark --example replanning -- airport_hall 8 boustrophedon-lanes`

use benchmark::cpu::timed;
use planner::{Instance, Mode, PlanError, PlanOptions, Start, VerifiedPlan, plan};
use std::path::Path;
use terrain::{Floor, MapFile, MotionModel, Point, Segment, SweptRaster};

const BODY_RADIUS_M: f64 = 0.25;
const TOOL_WIDTH_M: f64 = 0.6;
const MOTION: MotionModel = MotionModel {
    speed_m_per_s: 0.7,
    acceleration_m_per_s2: 0.7,
    angular_speed_rad_per_s: 1.0,
    angular_acceleration_rad_per_s2: 2.0,
    brakes: true,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().unwrap_or_else(|| "airport_hall".to_owned());
    let robots: usize = arguments.next().map_or(Ok(8), |text| text.parse())?;
    let planner = arguments.next().unwrap_or_else(|| "boustrophedon-lanes".to_owned());
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/instances/indoor");
    let cell_m = TOOL_WIDTH_M / 1.5;
    let map = MapFile { metres_per_character: 1.0, square_m: cell_m / 8.0 }
        .load(folder.join(format!("{name}.yaml")))?;
    let floor = Floor::new(&map, cell_m, BODY_RADIUS_M + 0.03, TOOL_WIDTH_M)?;
    let text = std::fs::read_to_string(folder.join(format!("{name}.stations.json")))?;
    let starts = starts(&serde_json::from_str(&text)?, &floor, &map, robots);
    let instance = Instance::whole_floor(&floor, starts, MOTION, Mode::Cover);
    let options = PlanOptions { planner, ..PlanOptions::default() };
    let (first, first_s) = timed(|| plan(&instance, &options));
    let first = first?;
    println!(
        "{name}, {} robots, `{}`: first plan {:.0} s, {first_s:.2} s of user CPU",
        instance.starts.len(),
        first.planner(),
        first.figures().makespan_s
    );
    let half = HalfWay::of(&instance, &first);
    for (what, later) in [("a robot is lost", half.lost()), ("ground is blocked", half.blocked())] {
        for warm in [true, false] {
            let options = PlanOptions { warm, ..options.clone() };
            // As the coordinator asks for it.
            let coverage_min = if warm { 0.95 } else { 0.99 };
            let later = Instance { coverage_min, ..later.clone() };
            let (again, cpu_s) = timed(|| plan(&later, &options));
            report(what, warm, &again, cpu_s);
        }
    }
    Ok(())
}

fn report(what: &str, warm: bool, again: &Result<VerifiedPlan, PlanError>, cpu_s: f64) {
    let how = if warm { "first order" } else { "compared with planning afresh" };
    match again {
        Ok(plan) => println!(
            "{what}, {how}: by `{}`, {:.0} s to go, {:.2} % swept, {cpu_s:.3} s of user CPU",
            plan.planner(),
            plan.figures().makespan_s,
            100.0 * plan.figures().coverage_ratio
        ),
        Err(error) => println!("{what}, {how}: {error}; {cpu_s:.3} s of user CPU"),
    }
}

/// Robots on the cells nearest to stations, two to a station where there are more robots than stations.
fn starts(stations: &serde_json::Value, floor: &Floor, map: &terrain::GridMap, robots: usize) -> Vec<Start> {
    let places: Vec<Point> = stations["stations"]
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(|station| Some(Point::new(station["x_m"].as_f64()?, station["y_m"].as_f64()?)))
        .collect();
    places
        .iter()
        .cycle()
        .take(robots)
        .filter_map(|&place| floor.nearest_drivable(map, place))
        .map(Start::at)
        .collect()
}

/// A mission half of which is done: what each robot has ahead, from where it stands.
struct HalfWay<'a> {
    instance: Instance<'a>,
}

impl<'a> HalfWay<'a> {
    fn of(instance: &Instance<'a>, plan: &VerifiedPlan) -> Self {
        let lattice = *instance.floor.lattice();
        let mut raster = SweptRaster::new(lattice);
        let mut half = Self { instance: instance.clone() };
        for (robot, route) in plan.routes().iter().enumerate() {
            let length_m: f64 = route.points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
            let (mut done_m, mut ahead) = (0.0, Vec::new());
            for pair in route.points.windows(2) {
                if done_m < length_m / 2.0 {
                    raster.sweep(Segment::new(pair[0], pair[1]), TOOL_WIDTH_M / 2.0, |_| {});
                    ahead.clear();
                    ahead.push(pair[1]);
                } else {
                    ahead.push(pair[1]);
                }
                done_m += (pair[1] - pair[0]).norm();
            }
            let at = ahead.first().copied().unwrap_or_else(|| instance.place(&instance.starts[robot]));
            if let Some(cell) = lattice.cell_at(at).filter(|&cell| instance.floor.cell_is_drivable(cell)) {
                half.instance.starts[robot] = Start { point: Some(at), ..Start::at(cell) };
            }
            half.instance.incumbent_lines.push(ahead);
        }
        half.instance.swept = (0..lattice.len()).map(|index| raster.samples(index)).collect();
        half.instance.visit = (0..lattice.len())
            .map(|index| instance.visit[index] && half.instance.wanted(index) != 0)
            .collect();
        half
    }

    /// The second robot is gone.
    fn lost(&self) -> Instance<'a> {
        let mut later = self.instance.clone();
        let gone = 1.min(later.starts.len() - 1);
        later.starts.remove(gone);
        later.orphan_lines.push(later.incumbent_lines.remove(gone));
        later
    }

    /// A square of 2 m on the way of the first robot cannot be entered.
    fn blocked(&self) -> Instance<'a> {
        let mut later = self.instance.clone();
        let line = &later.incumbent_lines[0];
        let middle = line[line.len() / 2];
        let lattice = *later.floor.lattice();
        let stands: Vec<Point> = later.starts.iter().map(|start| later.place(start)).collect();
        for cell in lattice.cells() {
            let center = lattice.center(cell);
            let near = (center - middle).amax() < 1.0;
            let stood_on = stands.iter().any(|stand| (stand - center).norm() < 1.0);
            if let Some(index) = lattice.index(cell).filter(|_| near && !stood_on) {
                later.blocked[index] = true;
            }
        }
        let reachable = later.reachable();
        later.visit.iter_mut().zip(reachable).for_each(|(visit, reached)| *visit &= reached);
        later
    }
}
