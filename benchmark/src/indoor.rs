//! Floor plans: planners judged as the programs of others were on the same maps.

pub(crate) mod charging;
mod evaluator;
mod floor_plan;
mod stations;

use crate::{
    BenchmarkError, Options, Progress, Table, content, csv_rows, read,
    tables::{ratio, tenths},
};
use evaluator::Judged;
use floor_plan::FloorPlan;
use planner::PlanError;
use serde::Deserialize;

/// Maps in the order of their size; `airport_terminal` has no reference.
pub(crate) const MAPS: [&str; 6] =
    ["small_house", "basement", "depot", "willow", "airport_hall", "airport_terminal"];
/// Planners that are compared, and the share of the ground to be swept that they are asked for.
const PLANNERS: [&str; 1] = ["boustrophedon-lanes"];
/// The planner whose row of the reference is the target.
const TARGET: &str = "reference, lanes";
/// Share of the ground that a plan with the residual tour sweeps; on maps with ragged walls less can be swept.
const WHOLE: f64 = 0.997;

/// The evaluator counts ground that the body gets to only by touching walls: more has to be asked for than it shall find.
/// So many plans are tried; the fastest of those that sweep enough counts (else the one that sweeps the most), and the CPU it
/// took alone.
const TRIES: u32 = 4;
/// So much more than wanted is no reason to plan again.
const NEAR_ENOUGH: f64 = 0.001;
/// The most that is asked for.
const MOST: f64 = 0.9995;

/// A row of `reference.csv`.
#[derive(Debug, Clone, Deserialize)]
struct Reference {
    map: String,
    planner: String,
    length_m: String,
    length_over_bound: String,
    turns: String,
    coverage_of_coverable: String,
    overlap: String,
    time_s: String,
    user_cpu_s: String,
}

pub(crate) fn run(options: &Options, progress: Progress<'_>) -> Result<Vec<Table>, BenchmarkError> {
    let folder = options.instances.join("indoor");
    let path = folder.join("reference.csv");
    let references: Vec<Reference> = csv_rows(&path, &read(&path)?)?;
    let mut table = Table::new(
        "indoor",
        "One robot from station 0 and back, no battery limit",
        "Length ÷ bound: bound = coverable area ÷ tool width. Coverage: of what a round tool can touch. Time: length ÷ speed \
         + all turning at 1 rad/s. Judged by one evaluator that knows no planner; rows of other programs and of the \
         reference were judged by the same rules before (`reference.csv`): clearance between the centres of pixels, for one. \
         Ours twice: at the coverage of the reference, and with what is left toured as well.",
        &[
            "map",
            "planner",
            "length m",
            "÷ bound",
            "turns",
            "coverage",
            "overlap",
            "time s",
            "÷ reference",
            "CPU s",
        ],
    );
    let maps = if options.quick { &MAPS[..1] } else { &MAPS[..] };
    for &map in maps {
        let floor_plan = FloorPlan::load(&folder, map)?;
        let of_map = || references.iter().filter(|row| row.map == map);
        let target = of_map().find(|row| row.planner == TARGET);
        for row in of_map() {
            let head =
                [map.to_owned(), row.planner.clone(), row.length_m.clone(), row.length_over_bound.clone()];
            let tail = [row.turns.clone(), row.coverage_of_coverable.clone(), row.overlap.clone()];
            let end = [row.time_s.clone(), String::new(), row.user_cpu_s.clone()];
            table.push([&head[..], &tail, &end].concat());
        }
        let target_s = target.and_then(|row| row.time_s.parse().ok());
        let at_reference = target.and_then(|row| percent(&row.coverage_of_coverable)).unwrap_or(0.98);
        // Where there is no reference there is no second target to reach for.
        let targets = [("", at_reference), (", with the rest", WHOLE)];
        let targets = if target.is_some() { &targets[..] } else { &targets[..1] };
        for planner in PLANNERS {
            for &(what, coverage) in targets {
                progress(&format!("{map}: {planner}{what}"));
                let name = format!("{planner}{what}");
                let made = measure(&floor_plan, planner, coverage, options.effort)
                    .map_err(|error| content(&path, error.to_string()))?;
                let row = row_of(map, &name, &floor_plan, target_s, made);
                progress(&row.join(" "));
                table.push(row);
            }
        }
    }
    let mut tables = vec![table];
    tables.extend(stations::run(options, &folder, progress)?);
    Ok(tables)
}

fn measure(
    floor_plan: &FloorPlan,
    planner: &str,
    coverage: f64,
    effort: u32,
) -> Result<(Judged, f64), PlanError> {
    let evaluator = floor_plan.evaluator();
    // What was asked for and found: the nearest below what is wanted, and the nearest that sweeps enough.
    let (mut below, mut enough): (Option<[f64; 2]>, Option<[f64; 2]>) = (None, None);
    let mut asked = coverage;
    let mut best: Option<(Judged, f64)> = None;
    for _ in 0..TRIES {
        let made = floor_plan.plan(planner, 0, asked, effort)?;
        let judged = evaluator.judge(&made.plan.routes()[0].points);
        if best.is_none_or(|(before, _)| is_better(&judged, &before, coverage)) {
            best = Some((judged, made.cpu_s));
        }
        let point = Some([asked, judged.coverage]);
        let missing = coverage - judged.coverage;
        if missing <= 0.0 {
            enough = point;
        } else {
            below = point;
        }
        asked = match (below, enough) {
            // More than wanted: it may well take less time to sweep less.
            (None, Some([asked, _])) if missing < -NEAR_ENOUGH => asked + 1.2 * missing,
            (None, _) => break,
            (Some([asked, _]), None) if asked >= MOST => break,
            (Some([asked, _]), None) => (asked + 1.2 * missing + 0.0005).min(MOST),
            (Some([low, found]), Some([high, more])) => {
                let share = (coverage - found) / (more - found);
                low + (high - low) * share.clamp(0.25, 0.9)
            }
        };
    }
    Ok(best.expect("there is a try"))
}

/// Sweeping enough comes first, then time; where neither sweeps enough, the one that sweeps more.
fn is_better(one: &Judged, other: &Judged, coverage: f64) -> bool {
    match (one.coverage >= coverage, other.coverage >= coverage) {
        (true, true) => one.time_s < other.time_s,
        (false, false) => one.coverage > other.coverage,
        (enough, _) => enough,
    }
}

fn row_of(
    map: &str,
    name: &str,
    floor_plan: &FloorPlan,
    target_s: Option<f64>,
    (judged, cpu_s): (Judged, f64),
) -> Vec<String> {
    vec![
        map.to_owned(),
        name.to_owned(),
        tenths(judged.length_m),
        ratio(judged.length_m * floor_plan.robot.tool_width_m / floor_plan.evaluator().coverable_m2()),
        judged.turns.to_string(),
        format!("{:.2} %", 100.0 * judged.coverage),
        ratio(judged.overlap),
        tenths(judged.time_s),
        target_s.map(|target_s| ratio(judged.time_s / target_s)).unwrap_or_default(),
        ratio(cpu_s),
    ]
}

/// `97.8 %` as a share.
fn percent(text: &str) -> Option<f64> {
    text.trim_end_matches(['%', ' ']).parse::<f64>().ok().map(|percent| percent / 100.0)
}
