//! Coverage over time among people, as in Fig. 7 of the paper on boustrophedon coverage: a rehearsed airport hall with
//! more and more walkers, with the batteries of the scenario and with endless ones.

use benchmark::{Benchmark, BenchmarkError, Options, Picture, Progress, Table, plot::LinePlot};
use sim::{Fault, Outcome, Rehearsal, Scenario};
use std::{path::Path, sync::Arc};

/// The row of the table of benchmarks.
pub(super) const PEOPLE: Benchmark = Benchmark {
    name: "people",
    about: "a rehearsed hall with walkers and queues (Fig. 7 of the boustrophedon paper)",
    run,
};

const SCENARIO: &str = "scenarios/airport_hall.toml";
const WALKERS: [u32; 3] = [10, 20, 30];
const DAYS: u64 = 3;
/// A quick run sees the begin of a day.
const QUICK_S: f64 = 900.0;
/// Far more than a day takes.
const ENDLESS_WH: f64 = 1e5;
/// Steps of the lines, seconds.
const STEP_S: f64 = 60.0;

/// The days with one number of people and one battery.
struct Series {
    walkers: u32,
    is_endless: bool,
    days: Vec<Outcome>,
}

fn run(options: &Options, progress: Progress<'_>) -> Result<Vec<Table>, BenchmarkError> {
    let cannot = |what: String| BenchmarkError::Content { path: SCENARIO.into(), what };
    let hall = Scenario::load(Path::new(SCENARIO))
        .map_err(|error| cannot(format!("{error}; run this in the folder of the repository")))?;
    let (walkers, batteries, days) = if options.quick {
        (&WALKERS[..1], &[false][..], 1)
    } else {
        (&WALKERS[..], &[false, true][..], DAYS)
    };
    let mut rules = sim::Options::default();
    if options.quick {
        rules.virtual_max_s = QUICK_S;
    }
    let mut table = empty_table(days);
    for &is_endless in batteries {
        let mut all = Vec::new();
        for &walkers in walkers {
            let series =
                Series::play(&hall, (walkers, is_endless), (days, &rules), progress).map_err(&cannot)?;
            table.push(series.row());
            all.push(series);
        }
        table.pictures.push(picture(&all, is_endless));
    }
    Ok(vec![table])
}

fn empty_table(days: u64) -> Table {
    Table::new(
        "people",
        "Coverage over time among people (Fig. 7)",
        &format!(
            "`{SCENARIO}`: three robots, two chargers, walkers who go straight on until they meet something, two queues that \
             stand and two that walk off late. Means of {days} days (seeds). Covered: of what the coordinator's lattice can reach, under the \
             judge's eyes. Completed: days without a gap; the ground under a queue that stands for ever is one."
        ),
        &[
            "walkers",
            "battery",
            "covered %",
            "least %",
            "time s",
            "charges",
            "blockages",
            "replans",
            "contacts",
            "violations",
            "stranded",
            "completed",
        ],
    )
}

impl Series {
    fn play(
        hall: &Scenario,
        (walkers, is_endless): (u32, bool),
        (days, rules): (u64, &sim::Options),
        progress: Progress<'_>,
    ) -> Result<Self, String> {
        let mut scenario = hall.clone();
        scenario.file.faults.iter_mut().for_each(|entry| {
            if let Fault::People(people) = &mut entry.fault {
                people.count = walkers;
            }
        });
        if is_endless {
            scenario.file.robot.battery.capacity_wh = ENDLESS_WH;
        }
        let scenario = Arc::new(scenario);
        let mut play = |day| {
            progress(&format!("{walkers} walkers, {} battery, day {day}", battery(is_endless)));
            Rehearsal::run(&scenario, day, rules.clone(), None).map_err(|error| error.to_string())
        };
        Ok(Self { walkers, is_endless, days: (0..days).map(&mut play).collect::<Result<_, _>>()? })
    }

    fn mean(&self, figure: impl Fn(&Outcome) -> f64) -> f64 {
        self.days.iter().map(figure).sum::<f64>() / self.days.len() as f64
    }

    fn row(&self) -> Vec<String> {
        let events = |word: &str| self.mean(|day| day.transcript.text().matches(word).count() as f64);
        let result = |day: &Outcome| day.result.clone().unwrap_or_default();
        let last = |day: &Outcome| day.progress.last().map_or(0.0, |&(_, percent)| percent);
        let covered = |day: &Outcome| result(day).progress.map_or(last(day), |end| end.covered_percent);
        let ended_well = self
            .days
            .iter()
            .filter(|day| result(day).mission_state() == protocol::v1::MissionState::Completed);
        vec![
            self.walkers.to_string(),
            battery(self.is_endless).to_owned(),
            format!("{:.2}", self.mean(covered)),
            format!("{:.2}", self.days.iter().map(covered).fold(f64::INFINITY, f64::min)),
            format!("{:.0}", self.mean(|day| day.virtual_s)),
            format!("{:.1}", events("CHARGING")),
            format!("{:.1}", events("BLOCKED")),
            format!("{:.1}", self.mean(|day| f64::from(result(day).replans))),
            self.days.iter().map(|day| day.contacts).sum::<u32>().to_string(),
            self.days.iter().map(|day| day.violations.len()).sum::<usize>().to_string(),
            self.days.iter().map(|day| day.stranded.len()).sum::<usize>().to_string(),
            format!("{} of {}", ended_well.count(), self.days.len()),
        ]
    }

    /// Mean covered share over time, percent.
    fn line(&self) -> Vec<(f64, f64)> {
        let longest_s = self.days.iter().map(|day| day.virtual_s).fold(0.0, f64::max);
        let covered_at = |at_s: f64| {
            self.mean(|day| {
                let before = day.progress.iter().take_while(|(s, _)| *s <= at_s);
                before.last().map_or(0.0, |&(_, percent)| percent)
            })
        };
        (0..=(longest_s / STEP_S) as u32)
            .map(|step| f64::from(step) * STEP_S)
            .map(|at_s| (at_s, covered_at(at_s)))
            .collect()
    }
}

const fn battery(is_endless: bool) -> &'static str {
    if is_endless { "endless" } else { "60 Wh" }
}

fn picture(all: &[Series], is_endless: bool) -> Picture {
    let name = if is_endless { "people_endless" } else { "people_battery" };
    let caption = format!("Covered share over time, {} battery", battery(is_endless));
    let plot = LinePlot {
        title: caption.clone(),
        across: "time, s".to_owned(),
        up: "covered, %".to_owned(),
        series: all.iter().map(|series| (format!("{} walkers", series.walkers), series.line())).collect(),
    };
    Picture::new(name, &caption, plot.svg())
}
