//! Batteries: never below empty, no robot stranded without a word, and what is reported is what is there.

use protocol::v1;
use std::collections::{BTreeMap, VecDeque};

/// A robot says that its battery is low at least this long before it is empty.
const NOTICE_S: f64 = 30.0;
/// An agent that was silent for so long is dead: nobody could have driven it to a station.
const SILENT_S: f64 = 2.0;
/// A report is compared with the truths of this long before and after it, seconds.
const DELAY_S: f64 = 0.5;
/// How far a report may be off, percentage points.
const ERROR_PERCENT_MAX: f64 = 2.0;

/// What is known of one battery.
#[derive(Debug, Default)]
struct Battery {
    recent: VecDeque<(f64, f64)>,
    /// Reports that wait for the truths around them.
    reports: VecDeque<(f64, f64)>,
    lowest_percent: Option<f64>,
    warned_at_s: Option<f64>,
    heard_at_s: Option<f64>,
    stranded: bool,
    below_empty: bool,
    misreported: bool,
}

/// The batteries of the fleet.
#[derive(Debug, Default)]
pub(crate) struct Batteries {
    robots: BTreeMap<String, Battery>,
    pub(crate) report_error_percent: f64,
}

impl Batteries {
    /// Takes in the truth about one body; returns what is wrong with it.
    pub(crate) fn take_truth(&mut self, at_s: f64, body: &v1::BodyTruth) -> Option<String> {
        let percent = body.state_of_charge_percent;
        let battery = self.of(&body.serial_number);
        battery.recent.push_back((at_s, percent));
        while battery.recent.front().is_some_and(|&(then_s, _)| then_s < at_s - 2.0 * DELAY_S) {
            battery.recent.pop_front();
        }
        battery.lowest_percent = Some(battery.lowest_percent.map_or(percent, |lowest| lowest.min(percent)));
        let impossible = percent.is_nan() || percent < 0.0;
        if impossible && !std::mem::replace(&mut battery.below_empty, true) {
            return Some(format!("{} has {percent} % in its battery", body.serial_number));
        }
        let empty = percent <= 0.0 && body.on_floor && !body.charging;
        if empty && !std::mem::replace(&mut battery.stranded, true) && battery.is_silent_strand(at_s) {
            return Some(format!("{} ran empty away from a station without notice", body.serial_number));
        }
        None
    }

    /// Takes in what a robot reports; returns what is wrong with it.
    pub(crate) fn take_state(&mut self, at_s: f64, state: &v1::State) -> Option<String> {
        let robot = &state.header.as_ref()?.serial_number;
        let low = v1::ErrorType::BatteryLow as i32;
        let battery = self.of(robot);
        battery.heard_at_s = Some(at_s);
        if state.errors.iter().any(|error| error.error_type == low) {
            battery.warned_at_s = battery.warned_at_s.or(Some(at_s));
        } else {
            battery.warned_at_s = None;
        }
        battery.reports.push_back((at_s, state.state_of_charge_percent));
        let due = battery.reports.front().is_some_and(|&(then_s, _)| at_s - then_s >= DELAY_S);
        let (_, reported) = battery.reports.front().copied().filter(|_| due)?;
        battery.reports.pop_front();
        let error = battery.report_error(reported)?;
        let told = error > ERROR_PERCENT_MAX && !std::mem::replace(&mut battery.misreported, true);
        self.report_error_percent = self.report_error_percent.max(error);
        told.then(|| format!("{robot} reports {reported:.1} % charge, off by {error:.1} points"))
    }

    /// The lowest charge that each robot had.
    pub(crate) fn lowest_percent(&self) -> impl Iterator<Item = (&str, f64)> {
        self.robots.iter().filter_map(|(robot, battery)| Some((robot.as_str(), battery.lowest_percent?)))
    }

    fn of(&mut self, robot: &str) -> &mut Battery {
        if !self.robots.contains_key(robot) {
            self.robots.insert(robot.to_owned(), Battery::default());
        }
        self.robots.get_mut(robot).expect("it was put there")
    }
}

impl Battery {
    fn is_silent_strand(&self, at_s: f64) -> bool {
        let alive = self.heard_at_s.is_some_and(|heard_s| at_s - heard_s <= SILENT_S);
        let warned = self.warned_at_s.is_some_and(|warned_s| at_s - warned_s >= NOTICE_S);
        alive && !warned
    }

    /// How far a report lies outside what was true around its time.
    fn report_error(&self, reported: f64) -> Option<f64> {
        let charges = self.recent.iter().map(|&(_, percent)| percent);
        let (low, high) =
            charges.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        (low <= high).then(|| (low - reported).max(reported - high).max(0.0))
    }
}
