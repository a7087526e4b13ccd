//! Makes lines shorter and smoother where the ground stays swept: joints become slants, corners bends.
//!
//! A stretch between two points of a line is replaced by the straight way, or by the one corner where the headings
//! before and after meet, when way + turning + ground no longer swept, all in metres of way, becomes less. Stretches
//! next to each other give way to each other in turn, so that the jogs of neighbouring arms become parallel slants:
//! a spiral.

use super::joint::turn_rad;
use super::swept_counts::SweptCounts;
use super::walls::Walls;
use terrain::Point;

/// Numbers of points between the ends of the stretches that are tried.
const STRETCHES: [usize; 8] = [1, 2, 3, 4, 6, 8, 11, LONGEST];
pub(super) const LONGEST: usize = 15;
/// The least gain that counts, in widths of the tool.
const LEAST_GAIN: f64 = 1e-3;
/// Share of the area cut off that is surely lost.
const LIKELY_LOSS: f64 = 0.2;
/// Turns beyond this are sharp, and each radian beyond counts for so many more.
const SHARP_RAD: f64 = 2.2;
const SHARPNESS: f64 = 4.0;
const SWEEPS: usize = 3;

pub(super) struct Smoothing<'a> {
    pub(super) swept: &'a mut SweptCounts,
    pub(super) walls: &'a Walls,
    pub(super) width_m: f64,
    /// How much more ground is worth than the way that sweeps it.
    pub(super) ground_worth: f64,
    /// Way that one radian of turning is worth, as a share of the tool's width.
    pub(super) turn_worth: f64,
    /// No ground is given up below this share.
    pub(super) least_coverage: f64,
}

impl Smoothing<'_> {
    /// Smooths lines at the points that are not quiet; first and last points stay.
    pub(super) fn smooth(&mut self, lines: &mut [Vec<Point>], mut quiet: Vec<Vec<bool>>) {
        for _ in 0..SWEEPS {
            let mut changed = false;
            for (line, quiet) in lines.iter_mut().zip(&mut quiet) {
                changed |= self.sweep(line, quiet);
            }
            if !changed {
                break;
            }
        }
    }

    /// Tries every point that is not quiet: those at which nothing pays are, until the line changes near them.
    fn sweep(&mut self, line: &mut Vec<Point>, quiet: &mut Vec<bool>) -> bool {
        let mut changed = false;
        let mut at = 0;
        // What the turns at the points count for: each is asked for from all points before it.
        let mut turns: Vec<f64> = (0..line.len()).map(|at| turn_at(line, at)).collect();
        while at + 2 < line.len() {
            if !quiet[at] {
                let shortcuts = self.shortcuts(line, &turns, at);
                let best = shortcuts.into_iter().find(|shortcut| self.try_out(line, shortcut));
                quiet[at] = best.is_none();
                if let Some(best) = best {
                    turns.splice(best.from + 1..best.to, best.corner.map(|_| 0.0));
                    let end = (best.from + 2 + usize::from(best.corner.is_some())).min(line.len());
                    (best.from..end).for_each(|at| turns[at] = turn_at(line, at));
                    quiet.splice(best.from + 1..best.to, best.corner.map(|_| false));
                    let last = (at + STRETCHES[0] + 1).min(quiet.len() - 1);
                    quiet[at.saturating_sub(LONGEST)..=last].fill(false);
                    changed = true;
                }
            }
            at += 1;
        }
        changed
    }

    /// What may stand in for the points after one, nothing or one corner: the most way and turning saved first.
    fn shortcuts(&self, line: &[Point], turns: &[f64], from: usize) -> Vec<Shortcut> {
        let turn_m = self.turn_worth * self.width_m;
        let mut shortcuts = Vec::new();
        // Way and turning of the points so far, up to and with the turn at the last of them.
        let mut old_m = turns[from] * turn_m;
        let mut tried = STRETCHES.iter().peekable();
        for to in from + 1..line.len() {
            old_m += (line[to] - line[to - 1]).norm() + turns[to] * turn_m;
            let Some(&&count) = tried.peek() else { break };
            if to != from + count + 1 {
                continue;
            }
            tried.next();
            if old_m - self.least_cost_m(line, from, to) <= LEAST_GAIN * self.width_m {
                continue;
            }
            let straight = Shortcut { from, to, corner: None, way_gain_m: 0.0, promise_m: 0.0 };
            let bend = corner(line, from, to, 4.0 * self.width_m)
                .map(|corner| Shortcut { corner: Some(corner), ..straight });
            for shortcut in std::iter::once(straight).chain(bend) {
                let way_gain_m = old_m - Self::new_cost_m(line, &shortcut, turn_m);
                let promise_m = way_gain_m - self.likely_loss_m(line, &shortcut);
                if promise_m > LEAST_GAIN * self.width_m {
                    shortcuts.push(Shortcut { way_gain_m, promise_m, ..shortcut });
                }
            }
        }
        shortcuts.sort_by(|a, b| b.promise_m.total_cmp(&a.promise_m));
        shortcuts
    }

    /// No way from one point to another costs less: it is no shorter than the straight one, and turns as much in all.
    fn least_cost_m(&self, line: &[Point], from: usize, to: usize) -> f64 {
        let way_m = (line[to] - line[from]).norm();
        match (from.checked_sub(1), line.get(to + 1)) {
            (Some(before), Some(&after)) => {
                let turn = turn_rad(line[from] - line[before], after - line[to]);
                way_m + self.turn_worth * self.width_m * turn
            }
            _ => way_m,
        }
    }

    /// A cautious guess at the ground that a shortcut loses, in metres of way: part of the area it cuts off.
    fn likely_loss_m(&self, line: &[Point], shortcut: &Shortcut) -> f64 {
        let old =
            line[shortcut.from..=shortcut.to].windows(2).map(|pair| pair[0].coords.perp(&pair[1].coords));
        let (a, b) = (line[shortcut.from].coords, line[shortcut.to].coords);
        let new = match shortcut.corner {
            Some(corner) => b.perp(&corner.coords) + corner.coords.perp(&a),
            None => b.perp(&a),
        };
        let cut_off_m2 = 0.5 * (old.sum::<f64>() + new).abs();
        LIKELY_LOSS * self.ground_worth * cut_off_m2 / self.width_m
    }

    fn new_cost_m(line: &[Point], shortcut: &Shortcut, turn_m: f64) -> f64 {
        let (a, b) = (line[shortcut.from], line[shortcut.to]);
        let (first, last) = (shortcut.corner.unwrap_or(b), shortcut.corner.unwrap_or(a));
        let before = shortcut.from.checked_sub(1).map(|at| a - line[at]);
        let after = line.get(shortcut.to + 1).map(|next| next - b);
        let turn = |from: Option<terrain::Vector>, to: Option<terrain::Vector>| match (from, to) {
            (Some(from), Some(to)) => worth_rad(turn_rad(from, to)),
            _ => 0.0,
        };
        let mut turns = turn(before, Some(first - a)) + turn(Some(b - last), after);
        let mut way_m = (first - a).norm();
        if let Some(corner) = shortcut.corner {
            turns += worth_rad(turn_rad(corner - a, b - corner));
            way_m += (b - corner).norm();
        }
        way_m + turns * turn_m
    }

    /// Puts a shortcut in, and takes it out again when too much ground is lost.
    fn try_out(&mut self, line: &mut Vec<Point>, shortcut: &Shortcut) -> bool {
        let Shortcut { from, to, .. } = *shortcut;
        let new: Vec<Point> = [line[from]].into_iter().chain(shortcut.corner).chain([line[to]]).collect();
        if !new.windows(2).all(|pair| self.walls.is_clear(pair[0], pair[1])) {
            return false;
        }
        let most_m2 = (shortcut.way_gain_m - LEAST_GAIN * self.width_m) * self.width_m / self.ground_worth;
        if self.exchange(&line[from..=to], &new, most_m2) {
            line.splice(from + 1..to, shortcut.corner);
            return true;
        }
        false
    }

    /// Sweeps one way in place of another, unless that loses `most_m2` of ground or more.
    fn exchange(&mut self, old: &[Point], new: &[Point], most_m2: f64) -> bool {
        let before_m2 = self.swept.unswept_m2();
        new.windows(2).for_each(|pair| self.swept.put_in(pair[0], pair[1]));
        for (out, pair) in old.windows(2).enumerate() {
            self.swept.take_out(pair[0], pair[1]);
            let lost_m2 = self.swept.unswept_m2() - before_m2;
            let is_too_much = lost_m2 > 0.0 && self.swept.coverage() < self.least_coverage;
            if lost_m2 >= most_m2 || is_too_much {
                old[..out + 2].windows(2).for_each(|pair| self.swept.put_in(pair[0], pair[1]));
                new.windows(2).for_each(|pair| self.swept.take_out(pair[0], pair[1]));
                return false;
            }
        }
        true
    }
}

/// A stretch of a line and what stands in for it.
#[derive(Debug, Clone, Copy)]
struct Shortcut {
    from: usize,
    to: usize,
    corner: Option<Point>,
    way_gain_m: f64,
    promise_m: f64,
}

/// Where the heading before `from` meets the one after `to`, if that is ahead and near.
fn corner(line: &[Point], from: usize, to: usize, reach_m: f64) -> Option<Point> {
    let (before, after) = (from.checked_sub(1)?, line.get(to + 1)?);
    let (heading, leaving) = (line[from] - line[before], *after - line[to]);
    let cross = heading.perp(&leaving);
    if cross.abs() < 0.1 * heading.norm() * leaving.norm() {
        return None;
    }
    let apart = line[to] - line[from];
    let (ahead, behind) = (apart.perp(&leaving) / cross, heading.perp(&apart) / cross);
    let fits =
        ahead > 0.0 && behind > 0.0 && ahead * heading.norm() < reach_m && behind * leaving.norm() < reach_m;
    fits.then(|| line[from] + heading * ahead)
}

/// What a turn counts for: a sharp one is a stop, and counts for more than several that are not.
fn worth_rad(turn_rad: f64) -> f64 {
    turn_rad + SHARPNESS * (turn_rad - SHARP_RAD).max(0.0)
}

/// What the turn at a point of a line counts for; none at its ends.
fn turn_at(line: &[Point], at: usize) -> f64 {
    if at == 0 || at + 1 >= line.len() {
        0.0
    } else {
        worth_rad(turn_rad(line[at] - line[at - 1], line[at + 1] - line[at]))
    }
}
