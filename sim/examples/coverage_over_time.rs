//! Coverage over time among people, as in Fig. 7 of the paper on boustrophedon coverage: the airport hall of
//! `scenarios/airport_hall.toml` with 10, 20 and 30 walkers, with and without batteries, mean of some days.
//!
//! `cargo run -p sim --no-default-features --example coverage_over_time -- FOLDER [DAYS] [PLANNER]` writes
//! `coverage_over_time.csv` and `.svg` into the folder, and prints a table.

#![expect(clippy::print_stdout, reason = "an example says what it found")]

use sim::{Fault, Options, Outcome, Rehearsal, Scenario};
use std::{env, fmt::Write, fs, path::Path, sync::Arc};

const PEOPLE: [u32; 3] = [10, 20, 30];
/// Far more than a day takes.
const ENDLESS_WH: f64 = 1e5;
const STEP_S: f64 = 10.0;
const COLOURS: [&str; 3] = ["#2f6f9f", "#c8811c", "#a23b3b"];

/// The days of one number of people and one battery.
struct Series {
    people: u32,
    endless: bool,
    days: Vec<Outcome>,
}

impl Series {
    fn play(hall: &Scenario, people: u32, endless: bool, days: u64) -> Self {
        let mut scenario = hall.clone();
        for entry in &mut scenario.file.faults {
            if let Fault::People(walkers) = &mut entry.fault {
                walkers.count = people;
            }
        }
        if endless {
            scenario.file.robot.battery.capacity_wh = ENDLESS_WH;
        }
        let scenario = Arc::new(scenario);
        let play =
            |day| Rehearsal::run(&scenario, day, Options::default(), None).expect("the floor is sound");
        Self { people, endless, days: (0..days).map(play).collect() }
    }

    fn name(&self) -> String {
        let battery = if self.endless { ", endless battery" } else { "" };
        format!("{} people{battery}", self.people)
    }

    fn mean(&self, figure: impl Fn(&Outcome) -> f64) -> f64 {
        self.days.iter().map(figure).sum::<f64>() / self.days.len() as f64
    }

    /// Mean covered share at a time, percent.
    fn covered_at(&self, at_s: f64) -> f64 {
        self.mean(|day| {
            day.progress.iter().take_while(|(s, _)| *s <= at_s).last().map_or(0.0, |&(_, percent)| percent)
        })
    }

    fn longest_s(&self) -> f64 {
        self.days.iter().map(|day| day.virtual_s).fold(0.0, f64::max)
    }

    fn row(&self) -> String {
        let events = |day: &Outcome, word: &str| day.transcript.text().matches(word).count() as f64;
        let result = |day: &Outcome| day.result.clone().unwrap_or_default();
        format!(
            "| {} | {} | {:.2} | {:.0} | {:.1} | {:.1} | {:.1} | {:.0} |",
            self.people,
            if self.endless { "∞" } else { "2,100 s" },
            self.mean(|day| result(day).progress.unwrap_or_default().covered_percent),
            self.mean(|day| result(day).duration_s),
            self.mean(|day| events(day, "CHARGING")),
            self.mean(|day| events(day, "BLOCKED")),
            self.mean(|day| f64::from(result(day).replans)),
            self.days.iter().map(|day| f64::from(day.contacts)).sum::<f64>(),
        )
    }
}

fn main() {
    let words: Vec<String> = env::args().skip(1).collect();
    let folder = Path::new(words.first().map_or(".", String::as_str)).to_owned();
    let days = words.get(1).map_or(5, |word| word.parse().expect("DAYS is a number"));
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/airport_hall.toml");
    let mut hall = Scenario::load(file).unwrap_or_else(|error| panic!("{error}"));
    if let Some(planner) = words.get(2) {
        hall.file.mission.planner.clone_from(planner);
    }
    println!("| People | λ | Covered % | Time s | Charges | Blockages | Replans | Contacts |");
    println!("|---|---|---|---|---|---|---|---|");
    let mut series = Vec::new();
    for endless in [true, false] {
        for people in PEOPLE {
            let one = Series::play(&hall, people, endless, days);
            println!("{}", one.row());
            series.push(one);
        }
    }
    fs::write(folder.join("coverage_over_time.csv"), csv(&series)).expect("the folder can be written");
    fs::write(folder.join("coverage_over_time.svg"), svg(&series)).expect("the folder can be written");
}

fn csv(series: &[Series]) -> String {
    let mut text = "time_s".to_owned();
    for one in series {
        write!(text, ",{}", one.name().replace(',', "")).expect("a String takes everything");
    }
    text.push('\n');
    for at_s in times(series) {
        write!(text, "{at_s:.0}").expect("a String takes everything");
        for one in series {
            write!(text, ",{:.2}", one.covered_at(at_s)).expect("a String takes everything");
        }
        text.push('\n');
    }
    text
}

fn times(series: &[Series]) -> impl Iterator<Item = f64> + use<> {
    let longest_s = series.iter().map(Series::longest_s).fold(0.0, f64::max);
    (0..=(longest_s / STEP_S) as u32).map(|step| f64::from(step) * STEP_S)
}

/// Time to the right, covered share upwards; endless batteries dashed.
fn svg(series: &[Series]) -> String {
    let (width, height, left, bottom) = (720.0, 400.0, 50.0, 360.0);
    let longest_s = times(series).last().unwrap_or(1.0).max(1.0);
    let x = |at_s: f64| left + at_s / longest_s * (width - left - 20.0);
    let y = |percent: f64| bottom - percent / 100.0 * (bottom - 20.0);
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" font-family=\"sans-serif\" \
         font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    let mut add = |line: String| text.push_str(&(line + "\n"));
    for percent in [0.0, 25.0, 50.0, 75.0, 100.0] {
        let at = y(percent);
        add(format!("<path d=\"M{left} {at:.1}H{:.1}\" stroke=\"#ddd\"/>", width - 20.0));
        add(format!(
            "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{percent} %</text>",
            left - 6.0,
            at + 4.0
        ));
    }
    for at_s in (0..=(longest_s / 1000.0) as u32).map(|k| f64::from(k) * 1000.0) {
        add(format!(
            "<text x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">{at_s} s</text>",
            x(at_s),
            bottom + 18.0
        ));
    }
    for (number, one) in series.iter().enumerate() {
        let colour = COLOURS[number % COLOURS.len()];
        let dash = if one.endless { " stroke-dasharray=\"5 3\"" } else { "" };
        let ends = times(series).take_while(|&at_s| at_s <= one.longest_s());
        let line: Vec<String> =
            ends.map(|at_s| format!("{:.1},{:.1}", x(at_s), y(one.covered_at(at_s)))).collect();
        let points = line.join(" ");
        add(format!(
            "<polyline points=\"{points}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\"{dash}/>"
        ));
        let (at_x, at_y) = (width - 250.0, bottom - 110.0 + 16.0 * number as f64);
        add(format!("<path d=\"M{at_x} {at_y}h24\" stroke=\"{colour}\" stroke-width=\"1.5\"{dash}/>"));
        add(format!("<text x=\"{}\" y=\"{}\">{}</text>", at_x + 30.0, at_y + 4.0, one.name()));
    }
    text + "</svg>\n"
}
