//! Makes lines shorter and smoother where the ground stays swept: joints become slants, corners bends.
//!
//! A stretch between two points of a line is replaced by the straight way, or by the one corner where the headings
//! before and after meet, when way + turning + ground no longer swept, all in metres of way, becomes less. Stretches
//! next to each other give way to each other in turn, so that the jogs of neighbouring arms become parallel slants:
//! a spiral.

use super::joint::{TURN_WORTH, turn_rad};
use super::swept_counts::SweptCounts;
use super::walls::Walls;
use terrain::Point;

/// Numbers of points between the ends of the stretches that are tried.
const STRETCHES: [usize; 8] = [1, 2, 3, 4, 6, 8, 11, 15];
/// Ground no longer swept is worth so much more than the way that sweeps it.
const GROUND_WORTH: f64 = 2.0;
/// The least gain that counts, in widths of the tool.
const LEAST_GAIN: f64 = 1e-3;
const SWEEPS: usize = 4;

pub(super) struct Smoothing<'a> {
    pub(super) swept: &'a mut SweptCounts,
    pub(super) walls: &'a Walls,
    pub(super) width_m: f64,
}

impl Smoothing<'_> {
    /// Smooths all lines; first and last points stay.
    pub(super) fn smooth(&mut self, lines: &mut [Vec<Point>]) {
        for _ in 0..SWEEPS {
            let mut changed = false;
            for line in lines.iter_mut() {
                changed |= self.sweep(line);
            }
            if !changed {
                break;
            }
        }
    }

    fn sweep(&mut self, line: &mut Vec<Point>) -> bool {
        let mut changed = false;
        let mut at = 0;
        while at + 2 < line.len() {
            let best = STRETCHES
                .iter()
                .filter(|&&count| at + count + 1 < line.len())
                .flat_map(|&count| self.candidates(line, at, at + count + 1))
                .min_by(|a, b| a.way_gain_m.total_cmp(&b.way_gain_m).reverse());
            let taken = best.is_some_and(|best| self.try_out(line, &best));
            changed |= taken;
            at += 1;
        }
        changed
    }

    /// What may stand in for the points between two: nothing, or one corner.
    fn candidates(&self, line: &[Point], from: usize, to: usize) -> Vec<Shortcut> {
        let straight = Shortcut { from, to, corner: None, way_gain_m: 0.0 };
        let corner = corner(line, from, to, 4.0 * self.width_m);
        let bend = corner.map(|corner| Shortcut { corner: Some(corner), ..straight });
        let mut found = Vec::new();
        for mut shortcut in std::iter::once(straight).chain(bend) {
            shortcut.way_gain_m = self.cost_m(line, from, to, &line[from + 1..to])
                - self.cost_m(line, from, to, shortcut.corner.as_slice());
            if shortcut.way_gain_m > LEAST_GAIN * self.width_m {
                found.push(shortcut);
            }
        }
        found
    }

    /// Way and turning from the point before `from` to the point after `to`, by way of `between`.
    fn cost_m(&self, line: &[Point], from: usize, to: usize, between: &[Point]) -> f64 {
        let before = from.checked_sub(1).map(|at| line[at]);
        let after = line.get(to + 1).copied();
        let points = before
            .into_iter()
            .chain([line[from]])
            .chain(between.iter().copied())
            .chain([line[to]])
            .chain(after);
        let (mut cost_m, mut last, mut heading) = (0.0, None::<Point>, None::<terrain::Vector>);
        for point in points {
            if let Some(last) = last {
                let step = point - last;
                if step.norm() < 1e-9 {
                    continue;
                }
                let turn = heading.map_or(0.0, |heading| turn_rad(heading, step));
                cost_m += step.norm() + TURN_WORTH * self.width_m * turn;
                heading = Some(step);
            }
            last = Some(point);
        }
        cost_m
    }

    /// Puts a shortcut in, and takes it out again when too much ground is lost.
    fn try_out(&mut self, line: &mut Vec<Point>, shortcut: &Shortcut) -> bool {
        let Shortcut { from, to, .. } = *shortcut;
        let new: Vec<Point> = [line[from]].into_iter().chain(shortcut.corner).chain([line[to]]).collect();
        if !new.windows(2).all(|pair| self.walls.is_clear(pair[0], pair[1])) {
            return false;
        }
        let before_m2 = self.swept.unswept_m2();
        self.exchange(&line[from..=to], &new);
        let lost_m = (self.swept.unswept_m2() - before_m2) / self.width_m * GROUND_WORTH;
        if lost_m < shortcut.way_gain_m - LEAST_GAIN * self.width_m {
            line.splice(from + 1..to, shortcut.corner);
            return true;
        }
        self.exchange(&new, &line[from..=to]);
        false
    }

    fn exchange(&mut self, old: &[Point], new: &[Point]) {
        new.windows(2).for_each(|pair| self.swept.put_in(pair[0], pair[1]));
        old.windows(2).for_each(|pair| self.swept.take_out(pair[0], pair[1]));
    }
}

/// A stretch of a line and what stands in for it.
#[derive(Debug, Clone, Copy)]
struct Shortcut {
    from: usize,
    to: usize,
    corner: Option<Point>,
    way_gain_m: f64,
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
