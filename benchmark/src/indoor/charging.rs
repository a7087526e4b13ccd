//! Batteries and several robots on floor plans: what charging costs, where to break off, and who shares a floor.

use super::{MAPS, floor_plan::FloorPlan};
use crate::{
    BenchmarkError, Options, Progress, Table, content,
    tables::{mean, ratio, tenths},
};
use planner::{
    Battery, BreakOff, Instance, Mode, PlanError, PlanOptions, Station, VerifiedPlan, plan, recharge,
};
use std::{cmp::Reverse, collections::BinaryHeap, path::Path};
use terrain::Cell;

const PLANNER: &str = "boustrophedon-lanes";
const COVERAGE_MIN: f64 = 0.98;
/// A way over eight directions is at most this much longer than the shortest.
const EIGHT_DIRECTIONS: f64 = 1.0824;
/// Seconds at a charger in the table of several robots.
const CHARGE_S: f64 = 60.0;

pub(crate) fn run(options: &Options, progress: Progress<'_>) -> Result<Vec<Table>, BenchmarkError> {
    let folder = options.instances.join("indoor");
    let failed = |error: PlanError| content(&folder, error.to_string());
    let mut overhead = overhead_table();
    let maps = if options.quick { &MAPS[..1] } else { &MAPS[..5] };
    for &map in maps {
        let floor_plan = FloorPlan::load(&folder, map)?;
        let stations = if options.quick { 0..2 } else { 0..floor_plan.stations.len() };
        progress(&format!("{map}: {} stations", stations.len()));
        let runs: Result<Vec<Runs>, PlanError> =
            stations.map(|station| Runs::at(&floor_plan, station)).collect();
        push_overheads(&mut overhead, &floor_plan, &runs.map_err(failed)?);
    }
    push_mean(&mut overhead);
    let sharing = sharing_table(options, &folder, progress)?;
    Ok(vec![overhead, sharing])
}

fn overhead_table() -> Table {
    Table::new(
        "indoor_charging",
        "Breaking off to charge: as late as possible, or where it costs least",
        "Means over the stations, one robot, one charger where it starts, charging itself free as in the paper. λ: seconds \
         of operation. Latest: the paper's rule, on if and only if the battery then still lasts home. Optimal: the break \
         points of the dynamic programme on the very same tour. Overhead: time beyond λ = ∞; lower by: (latest − optimal) ÷ \
         latest, of the overheads. Trips, at least: a bound from area and distance, whatever the tour; charges are trips − 1. \
         Planned without effort.",
        &[
            "map",
            "λ s",
            "λ = ∞ s",
            "latest s",
            "charges",
            "optimal s",
            "charges ",
            "overhead lower by %",
            "worst station %",
            "trips, at least",
        ],
    )
}

/// Times and charges from one station.
struct Runs {
    free_s: f64,
    /// Per capacity: latest and optimal, each with seconds and charges.
    limited: Vec<[(f64, usize); 2]>,
    trips_min: Vec<u32>,
}

impl Runs {
    fn at(floor_plan: &FloorPlan, station: usize) -> Result<Self, PlanError> {
        let free = planned(floor_plan, &[station], None, 0)?;
        let mut runs = Self { free_s: free.figures().makespan_s, limited: Vec::new(), trips_min: Vec::new() };
        let depths_m = depths_m(floor_plan, station);
        for capacity_s in floor_plan.capacities_s.iter().copied().flatten() {
            let by = |break_off| -> Result<(f64, usize), PlanError> {
                let battery = Battery { break_off, ..Battery::lasting_s(capacity_s) };
                let plan = recharge(&instance(floor_plan, &[station], Some(battery)), &free)?;
                Ok((plan.figures().makespan_s, plan.figures().charges[0]))
            };
            runs.limited.push([by(BreakOff::Latest)?, by(BreakOff::Optimal)?]);
            runs.trips_min.push(trips_min(floor_plan, &depths_m, capacity_s));
        }
        Ok(runs)
    }

    /// Share by which the overhead of the latest breaks is cut.
    fn lower_by(&self, capacity: usize) -> f64 {
        let [latest, optimal] = self.limited[capacity];
        (latest.0 - optimal.0) / (latest.0 - self.free_s)
    }
}

fn push_overheads(table: &mut Table, floor_plan: &FloorPlan, runs: &[Runs]) {
    let of = |value: &dyn Fn(&Runs) -> f64| mean(&runs.iter().map(value).collect::<Vec<f64>>());
    for (number, capacity_s) in floor_plan.capacities_s.iter().copied().flatten().enumerate() {
        let free_s = of(&|run| run.free_s);
        let [latest_s, optimal_s] = [0, 1].map(|rule| of(&|run| run.limited[number][rule].0));
        let charges = [0, 1].map(|rule| of(&|run| run.limited[number][rule].1 as f64));
        let worst = runs.iter().map(|run| run.lower_by(number)).fold(f64::INFINITY, f64::min);
        table.push(vec![
            floor_plan.name.clone(),
            format!("{capacity_s:.0}"),
            tenths(free_s),
            tenths(latest_s),
            tenths(charges[0]),
            tenths(optimal_s),
            tenths(charges[1]),
            tenths(100.0 * (latest_s - optimal_s) / (latest_s - free_s)),
            tenths(100.0 * worst),
            tenths(of(&|run| f64::from(run.trips_min[number]))),
        ]);
    }
}

fn push_mean(table: &mut Table) {
    let lower: Vec<f64> = table.rows.iter().filter_map(|row| row[7].parse().ok()).collect();
    let mut row = vec![String::new(); table.columns.len()];
    (row[0], row[7]) = ("mean of rows".to_owned(), tenths(mean(&lower)));
    table.push(row);
}

/// Robots on the stations given, back there in the end; with a battery, all stations are for all.
fn instance<'a>(floor_plan: &'a FloorPlan, stations: &[usize], battery: Option<Battery>) -> Instance<'a> {
    let starts = stations.iter().map(|&station| floor_plan.start(station)).collect();
    let mut instance =
        Instance::whole_floor(&floor_plan.floor, starts, floor_plan.motion(), Mode::CoverAndReturn);
    instance.coverage_min = COVERAGE_MIN;
    instance.battery = battery;
    let charger = |start: &planner::Start| Station { point: start.point, ..Station::at(start.cell) };
    instance.stations = instance.starts.iter().map(charger).collect();
    instance
}

fn planned(
    floor_plan: &FloorPlan,
    stations: &[usize],
    battery: Option<Battery>,
    effort: u32,
) -> Result<VerifiedPlan, PlanError> {
    let instance = instance(floor_plan, stations, battery);
    let options = PlanOptions { planner: PLANNER.to_owned(), effort, ..PlanOptions::default() };
    plan(&instance, &options)
}

fn sharing_table(options: &Options, folder: &Path, progress: Progress<'_>) -> Result<Table, BenchmarkError> {
    let mut table = Table::new(
        "indoor_sharing",
        "Four robots share a floor",
        "Robots on stations 0 to 3 and back; each may charge at any of the four, one at a time, 60 s a charge; waiting counts. \
         Ratio: makespan ÷ (time of one robot from station 0 without limit ÷ 4).",
        &["map", "robots", "λ s", "makespan s", "ratio", "charges", "waiting s", "coverage %"],
    );
    let maps = if options.quick { &MAPS[..1] } else { &MAPS[2..5] };
    for &map in maps {
        let floor_plan = FloorPlan::load(folder, map)?;
        let failed = |error: PlanError| content(folder, error.to_string());
        let mut alone_s = None;
        for (robots, capacity_s) in sharing_rows(&floor_plan) {
            progress(&format!("{map}: {robots} robots"));
            let battery =
                capacity_s.map(|capacity_s| Battery { charge_s: CHARGE_S, ..Battery::lasting_s(capacity_s) });
            let stations: Vec<usize> = (0..robots).collect();
            let plan = planned(&floor_plan, &stations, battery, options.effort).map_err(failed)?;
            let figures = plan.figures();
            let alone_s = *alone_s.get_or_insert(figures.makespan_s);
            table.push(vec![
                map.to_owned(),
                robots.to_string(),
                capacity_s.map_or("∞".to_owned(), |capacity_s| format!("{capacity_s:.0}")),
                tenths(figures.makespan_s),
                ratio(figures.makespan_s / (alone_s / robots as f64)),
                figures.charges.iter().sum::<usize>().to_string(),
                tenths(figures.waiting_s.iter().sum()),
                tenths(100.0 * figures.coverage_ratio),
            ]);
        }
    }
    Ok(table)
}

fn sharing_rows(floor_plan: &FloorPlan) -> Vec<(usize, Option<f64>)> {
    let limited = floor_plan.capacities_s.iter().filter(|capacity_s| capacity_s.is_some());
    let limited = limited.map(|&capacity_s| (4, capacity_s));
    [(1, None), (4, None)].into_iter().chain(limited).collect()
}

/// Least trips: what lies deeper than some distance must be swept by trips that spend twice that distance on the way.
fn trips_min(floor_plan: &FloorPlan, depths_m: &[f64], capacity_s: f64) -> u32 {
    let (robot, cell_m) = (&floor_plan.robot, floor_plan.floor.lattice().cell_m);
    let (reach_m, width_m) = (capacity_s * robot.speed_m_per_s, robot.tool_width_m);
    let bound = |rank: usize| {
        let area_m2 = (depths_m.len() - rank) as f64 * cell_m * cell_m;
        // A place is swept from half a tool away.
        let left_m = reach_m - 2.0 * (depths_m[rank] - width_m / 2.0).max(0.0);
        let swept_m2 = width_m * left_m + std::f64::consts::PI * width_m * width_m / 4.0;
        if left_m > 0.0 { (area_m2 / swept_m2).ceil() as u32 } else { 1 }
    };
    (0..depths_m.len()).step_by(64).map(bound).max().unwrap_or(1)
}

/// How far places for the body are from a station, at least; ascending. Metres.
fn depths_m(floor_plan: &FloorPlan, station: usize) -> Vec<f64> {
    let lattice = floor_plan.floor.lattice();
    let first = lattice.cell_at(floor_plan.stations[station]).expect("stations lie on the map");
    let mut steps = vec![u32::MAX; lattice.len()];
    let mut queue = BinaryHeap::from([(Reverse(0_u32), first)]);
    while let Some((Reverse(cost), cell)) = queue.pop() {
        let Some(index) = lattice.index(cell).filter(|&index| floor_plan.floor.is_drivable(index)) else {
            continue;
        };
        if steps[index] <= cost {
            continue;
        }
        steps[index] = cost;
        for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))) {
            let step = if dx != 0 && dy != 0 { 1414 } else { 1000 };
            queue.push((Reverse(cost + step), Cell::new(cell.x + dx, cell.y + dy)));
        }
    }
    let reached = steps.into_iter().filter(|&cost| cost != u32::MAX);
    let mut depths_m: Vec<f64> =
        reached.map(|cost| f64::from(cost) / 1000.0 * lattice.cell_m / EIGHT_DIRECTIONS).collect();
    depths_m.sort_by(f64::total_cmp);
    depths_m
}
