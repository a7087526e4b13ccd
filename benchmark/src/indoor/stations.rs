//! The paper's Fig. 5 on our floors: total coverage time from ten stations, planner by planner and battery by battery, with a
//! paired test. Each planner plans once from each station, without a battery; the same tour is then broken off to charge for
//! each capacity, where that costs least. Whoever sweeps more takes longer, so lanes are planned twice: for what all are asked
//! for, and for no less than what the baseline has swept.

use super::{MAPS, evaluator::Evaluator, floor_plan::FloorPlan};
use crate::{
    BenchmarkError, Options, Picture, Progress, Table, content,
    plot::{Bar, BarPanel, BarPlot},
    tables::{mean, ratio, tenths},
    task::Outcome,
};
use planner::{Battery, Instance, PlanError, Station, recharge};
use std::path::Path;

/// The baseline, ours, the paper's, and what it compares with.
const ROWS: [Row; 6] = [
    Row { name: "bc-sweep-hybrid", planner: "bc-sweep-hybrid", asked: Asked::Share },
    Row { name: "boustrophedon-lanes", planner: "boustrophedon-lanes", asked: Asked::Share },
    Row {
        name: "boustrophedon-lanes, as much ground",
        planner: "boustrophedon-lanes",
        asked: Asked::AsBaseline,
    },
    Row { name: "boustrophedon", planner: "boustrophedon", asked: Asked::Share },
    Row { name: "bc-sweep-vertical", planner: "bc-sweep-vertical", asked: Asked::Share },
    Row { name: "bc-sweep-horizontal", planner: "bc-sweep-horizontal", asked: Asked::Share },
];
/// All others are compared with this row, station by station.
const BASELINE: usize = 0;
/// Share of the ground that each plan is asked for, by the measure of verify.
const COVERAGE: f64 = 0.98;
/// So many plans are tried until one sweeps, by the evaluator's measure, what the baseline has swept.
const TRIES: u32 = 4;
/// The floors on which ten stations take minutes, not hours.
const FLOORS: usize = 5;

/// Lanes are planned without effort: it is many stations that count here, not the last per cent.
const EFFORT: u32 = 0;

/// A planner, and what it is asked for.
#[derive(Debug, Clone, Copy)]
struct Row {
    name: &'static str,
    planner: &'static str,
    asked: Asked,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Asked {
    Share,
    /// What the baseline has swept from the same station, or hardly more.
    AsBaseline,
}

/// What came of one row on one map with one capacity.
#[derive(Debug, Default)]
struct Sample {
    time_s: Vec<f64>,
    length_m: Vec<f64>,
    turns: Vec<f64>,
    coverage: Vec<f64>,
    cpu_s: Vec<f64>,
}

pub(super) fn run(
    options: &Options,
    folder: &Path,
    progress: Progress<'_>,
) -> Result<Vec<Table>, BenchmarkError> {
    let mut table = Table::new(
        "indoor_stations",
        "Total coverage time from ten stations (Fig. 5)",
        "One robot from a station and back, every plan asked for 98 % of the ground by the measure of verify (what lanes leave \
         out is swept on side trips); *as much ground*: asked for just what `bc-sweep-hybrid` has swept from the same station, \
         or hardly more. Mean and deviation over the stations. λ: seconds of operation, a charger at the station, charging \
         itself free as in the paper; break points by dynamic programming on the tour of λ = ∞, for all planners alike. \
         ÷ hybrid: mean of the ratios to `bc-sweep-hybrid` from the same station. p: two-sided paired t-test against it. \
         Coverage: by the evaluator. Planned without effort; CPU of planning for λ = ∞, or of breaking off.",
        &[
            "map",
            "λ s",
            "planner",
            "time s",
            "± s",
            "÷ hybrid",
            "p",
            "length m",
            "turns",
            "coverage",
            "CPU s",
        ],
    );
    let mut panels = Vec::new();
    let (maps, stations) = if options.quick { (1, 2) } else { (FLOORS, usize::MAX) };
    for &map in &MAPS[..maps] {
        let floor_plan = FloorPlan::load(folder, map)?;
        let samples = measure(&floor_plan, stations, progress)
            .map_err(|what| content(folder, format!("{map}: {what}")))?;
        let mut groups = Vec::new();
        for (number, &capacity_s) in floor_plan.capacities_s.iter().enumerate() {
            let of_capacity: Vec<&Sample> = samples.iter().map(|of_planner| &of_planner[number]).collect();
            let word = capacity_s.map_or("∞".to_owned(), |capacity_s| format!("{capacity_s:.0}"));
            for (row, sample) in ROWS.iter().zip(&of_capacity) {
                table.push(cells([map, &word, row.name], sample, of_capacity[BASELINE]));
            }
            let bar =
                |sample: &&Sample| Bar { mean: mean(&sample.time_s), deviation: deviation(&sample.time_s) };
            groups
                .push((format!("λ = {word}"), of_capacity.iter().map(|sample| Some(bar(sample))).collect()));
        }
        panels.push(BarPanel { title: map.to_owned(), groups });
    }
    let plot = BarPlot {
        title: "Total coverage time, s: mean and deviation over the stations".to_owned(),
        unit: "s".to_owned(),
        series: ROWS.map(|row| row.name.to_owned()).to_vec(),
        panels,
    };
    table.pictures.push(Picture::new(
        "indoor_stations",
        "Total coverage time of six rows on five floors",
        plot.svg(),
    ));
    Ok(vec![table])
}

/// By row, and by capacity in the order of the floor plan.
fn measure(floor_plan: &FloorPlan, most: usize, progress: Progress<'_>) -> Result<Vec<Vec<Sample>>, String> {
    let evaluator = floor_plan.evaluator();
    let stations = floor_plan.stations.len().min(most);
    let mut of_baseline = vec![0.0; stations];
    let mut all = Vec::new();
    for (number, row) in ROWS.iter().enumerate() {
        let mut samples: Vec<Sample> = floor_plan.capacities_s.iter().map(|_| Sample::default()).collect();
        for (station, of_baseline) in of_baseline.iter_mut().enumerate() {
            progress(&format!("{}: {} from station {station}", floor_plan.name, row.name));
            let failed = |error| format!("{} from station {station}: {error}", row.name);
            let (made, coverage) =
                planned(floor_plan, &evaluator, row, station, *of_baseline).map_err(failed)?;
            if number == BASELINE {
                *of_baseline = coverage;
            }
            for_each_capacity(floor_plan, &evaluator, station, &made, &mut samples).map_err(failed)?;
        }
        all.push(samples);
    }
    Ok(all)
}

/// A plan without a battery, and what it sweeps by the evaluator's measure.
fn planned(
    floor_plan: &FloorPlan,
    evaluator: &Evaluator<'_>,
    row: &Row,
    station: usize,
    of_baseline: f64,
) -> Result<(Outcome, f64), PlanError> {
    let swept = |made: &Outcome| evaluator.judge(&made.plan.routes()[0].points).coverage;
    let mut asked = if row.asked == Asked::Share { COVERAGE } else { of_baseline };
    let mut made = floor_plan.plan(row.planner, station, asked, EFFORT)?;
    let mut coverage = swept(&made);
    for _ in 1..TRIES {
        if row.asked == Asked::Share || coverage >= of_baseline {
            break;
        }
        asked = (asked + 1.2 * (of_baseline - coverage) + 0.0005).min(1.0);
        made = floor_plan.plan(row.planner, station, asked, EFFORT)?;
        coverage = swept(&made);
    }
    Ok((made, coverage))
}

/// Breaks a plan off for each capacity.
fn for_each_capacity(
    floor_plan: &FloorPlan,
    evaluator: &Evaluator<'_>,
    station: usize,
    made: &Outcome,
    samples: &mut [Sample],
) -> Result<(), PlanError> {
    for (sample, &capacity_s) in samples.iter_mut().zip(&floor_plan.capacities_s) {
        let (plan, cpu_s) = match capacity_s {
            None => (Ok(made.plan.clone()), made.cpu_s),
            Some(capacity_s) => {
                let share = made.plan.figures().coverage_ratio.min(COVERAGE) - 1e-6;
                let instance = with_charger(floor_plan, station, capacity_s, share);
                crate::cpu::timed(|| recharge(&instance, &made.plan))
            }
        };
        let judged = evaluator.judge(&plan?.routes()[0].points);
        sample.time_s.push(judged.time_s);
        sample.length_m.push(judged.length_m);
        sample.turns.push(f64::from(judged.turns));
        sample.coverage.push(judged.coverage);
        sample.cpu_s.push(cpu_s);
    }
    Ok(())
}

/// As [`FloorPlan::plan`] has it, with a battery and a charger where the robot starts; `share` is what the plan sweeps at least.
fn with_charger(floor_plan: &FloorPlan, station: usize, capacity_s: f64, share: f64) -> Instance<'_> {
    let mut instance = floor_plan.instance(station, share);
    let start = &instance.starts[0];
    instance.stations = vec![Station { point: start.point, ..Station::at(start.cell) }];
    instance.battery = Some(Battery::lasting_s(capacity_s));
    instance
}

fn cells(head: [&str; 3], sample: &Sample, baseline: &Sample) -> Vec<String> {
    let pairs = || sample.time_s.iter().zip(&baseline.time_s);
    let ratios: Vec<f64> = pairs().map(|(own, other)| own / other).collect();
    let differences: Vec<f64> = pairs().map(|(own, other)| own - other).collect();
    let p = if head[2] == ROWS[BASELINE].name {
        String::new()
    } else {
        format!("{:.1e}", paired_p(&differences))
    };
    let tail = vec![
        tenths(mean(&sample.time_s)),
        tenths(deviation(&sample.time_s)),
        ratio(mean(&ratios)),
        p,
        tenths(mean(&sample.length_m)),
        tenths(mean(&sample.turns)),
        format!("{:.2} %", 100.0 * mean(&sample.coverage)),
        ratio(mean(&sample.cpu_s)),
    ];
    [head.map(str::to_owned).to_vec(), tail].concat()
}

/// Standard deviation of a sample; 0 of fewer than two values.
fn deviation(values: &[f64]) -> f64 {
    if values.len() < 2 {
        return 0.0;
    }
    let middle = mean(values);
    let squares: f64 = values.iter().map(|value| (value - middle).powi(2)).sum();
    (squares / (values.len() - 1) as f64).sqrt()
}

/// How likely differences as large as these are in the mean when there is none (Student, two-sided).
fn paired_p(differences: &[f64]) -> f64 {
    let spread = deviation(differences);
    if spread == 0.0 {
        return if mean(differences) == 0.0 { 1.0 } else { 0.0 };
    }
    let freedom = (differences.len() - 1) as f64;
    let t = mean(differences).abs() / (spread / (differences.len() as f64).sqrt());
    // With t = √ν tan θ the density is cos^(ν − 1) θ, up to a factor.
    let from = (t / freedom.sqrt()).atan();
    let tail = integral(from, std::f64::consts::FRAC_PI_2, |angle| angle.cos().powf(freedom - 1.0));
    tail / integral(0.0, std::f64::consts::FRAC_PI_2, |angle| angle.cos().powf(freedom - 1.0))
}

/// Simpson's rule.
fn integral(from: f64, to: f64, of: impl Fn(f64) -> f64) -> f64 {
    let pieces = 2000_u32;
    let step = (to - from) / f64::from(pieces);
    let weight = |number: u32| match number {
        0 => 1.0,
        last if last == pieces => 1.0,
        odd if odd % 2 == 1 => 4.0,
        _ => 2.0,
    };
    (0..=pieces).map(|number| weight(number) * of(from + step * f64::from(number))).sum::<f64>() * step / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_test_agrees_with_the_tables_of_student() {
        // Nine degrees of freedom: 2.262 is the two-sided 5 % point, 4.781 the 0.1 % point.
        for (t, p) in [(2.262_f64, 0.05), (4.781, 0.001), (0.0, 1.0)] {
            let base: Vec<f64> = (0..10).map(|number| f64::from(number) - 4.5).collect();
            let shift = t * deviation(&base) / 10_f64.sqrt();
            let differences: Vec<f64> = base.iter().map(|value| value + shift).collect();
            assert!((paired_p(&differences) / p - 1.0).abs() < 0.01, "{t}: {}", paired_p(&differences));
        }
        assert!(paired_p(&[2.0, 2.0]).abs() < 1e-12);
    }
}
