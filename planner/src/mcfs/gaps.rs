//! Visits the gaps that smooth lines leave: each by the cheapest detour from a line beside it.
//!
//! ```text
//!           q               q: so far into the gap that the tool sweeps its far end
//!          ╱ ╲              a, b: where the line is left and joined again
//!   ─────▶a   b─────▶
//! ```

use super::joint::turning_rad;
use super::swept_counts::SweptCounts;
use super::walls::Walls;
use terrain::{Point, Vector};

/// Gaps of less than this many squares of tool width are left.
const LEAST_AREA: f64 = 0.12;
/// A detour ends this far before the far end of a gap, in tool widths: the less the better, but for walls.
const INSETS: [f64; 3] = [0.42, 0.6, 0.8];
/// Half the stretch of a line that gives way to a detour, in tool widths: each is tried.
const BASES: [f64; 3] = [0.15, 0.5, 1.0];
/// So many lines beside a gap are tried.
const SIDES: usize = 4;
/// Lines farther away than this are not tried, in tool widths.
const REACH: f64 = 2.5;
/// Gaps longer than this are followed from end to end, in tool widths.
const LONG: f64 = 1.0;
/// Way that one radian of turning is worth, as a share of the tool's width.
const TURN_WORTH: f64 = 0.2;

pub(super) struct Gaps<'a> {
    pub(super) swept: &'a mut SweptCounts,
    pub(super) walls: &'a Walls,
    pub(super) width_m: f64,
    /// How much more ground is worth than the way that sweeps it.
    pub(super) ground_worth: f64,
}

/// A detour and what it gains, metres of way.
struct Detour {
    line: usize,
    after: usize,
    points: Vec<Point>,
    gain_m: f64,
}

impl Gaps<'_> {
    /// Adds a detour for each gap that is worth it.
    pub(super) fn visit(&mut self, lines: &mut [Vec<Point>]) {
        for gap in self.swept.gaps(LEAST_AREA * self.width_m * self.width_m) {
            let mut best: Option<Detour> = None;
            for (line, after) in self.sides(lines, &gap) {
                for base in BASES {
                    let detour = self.detour(lines, (line, after), &gap, base * self.width_m);
                    if let Some(detour) = detour
                        && best.as_ref().is_none_or(|best| detour.gain_m > best.gain_m)
                    {
                        best = Some(detour);
                    }
                }
            }
            if let Some(Detour { line, after, points, .. }) = best.filter(|best| best.gain_m > 0.0) {
                self.exchange(&lines[line], after, &points);
                lines[line].splice(after + 1..=after, points);
            }
        }
    }

    /// The stretches of lines nearest to a gap: line and number of the first point.
    fn sides(&self, lines: &[Vec<Point>], gap: &[Point]) -> Vec<(usize, usize)> {
        let middle = middle(gap);
        let reach_m = REACH * self.width_m;
        let mut sides: Vec<(f64, usize, usize)> = Vec::new();
        for (line, points) in lines.iter().enumerate() {
            for (after, pair) in points.windows(2).enumerate() {
                let distance_m = (foot(pair[0], pair[1], middle) - middle).norm();
                if distance_m < reach_m {
                    sides.push((distance_m, line, after));
                }
            }
        }
        sides.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        sides.into_iter().take(SIDES).map(|(_, line, after)| (line, after)).collect()
    }

    /// A detour from the stretch after a point, measured by trial.
    fn detour(
        &mut self,
        lines: &[Vec<Point>],
        (line, after): (usize, usize),
        gap: &[Point],
        base_m: f64,
    ) -> Option<Detour> {
        let (from, to) = (lines[line][after], lines[line][after + 1]);
        let along = (to - from).try_normalize(1e-9)?;
        let points = INSETS.into_iter().find_map(|inset| {
            let into = self.course(from, to, gap, inset * self.width_m);
            let foot = foot(from, to, *into.first()?);
            let leave = foot - along * base_m.min((foot - from).norm());
            let join = foot + along * base_m.min((to - foot).norm());
            let points: Vec<Point> = [leave].into_iter().chain(into).chain([join]).collect();
            self.is_clear(from, &points, to).then_some(points)
        })?;
        let way: Vec<Point> = [from].into_iter().chain(points.iter().copied()).chain([to]).collect();
        let before_m2 = self.swept.unswept_m2();
        self.exchange(&lines[line], after, &points);
        let ground_m = (before_m2 - self.swept.unswept_m2()) / self.width_m;
        self.take_back(&lines[line], after, &points);
        let cost_m = length_m(&way) - (to - from).norm() + TURN_WORTH * self.width_m * turning_rad(&way);
        Some(Detour { line, after, points, gain_m: self.ground_worth * ground_m - cost_m })
    }

    /// Where a detour from a stretch goes: to the far end of a gap, or along a long one.
    fn course(&self, from: Point, to: Point, gap: &[Point], inset_m: f64) -> Vec<Point> {
        let near = foot(from, to, middle(gap));
        let far = farthest(gap, near);
        let other = farthest(gap, far);
        let inset = |end: Point, towards: Point| {
            let way = towards - end;
            end + way * (inset_m / way.norm().max(1e-9)).min(1.0)
        };
        if (far - other).norm() > LONG * self.width_m {
            vec![inset(other, far), inset(far, other)]
        } else {
            vec![inset(far, near)]
        }
    }

    fn is_clear(&self, from: Point, points: &[Point], to: Point) -> bool {
        let mut clear = true;
        each_step(from, points, to, |a, b| clear &= self.walls.is_clear(a, b));
        clear
    }

    fn exchange(&mut self, line: &[Point], after: usize, points: &[Point]) {
        let (from, to) = (line[after], line[after + 1]);
        each_step(from, points, to, |a, b| self.swept.put_in(a, b));
        self.swept.take_out(from, to);
    }

    fn take_back(&mut self, line: &[Point], after: usize, points: &[Point]) {
        let (from, to) = (line[after], line[after + 1]);
        self.swept.put_in(from, to);
        each_step(from, points, to, |a, b| self.swept.take_out(a, b));
    }
}

fn each_step(from: Point, points: &[Point], to: Point, mut each: impl FnMut(Point, Point)) {
    let mut before = from;
    for &point in points.iter().chain([&to]) {
        each(before, point);
        before = point;
    }
}

fn middle(gap: &[Point]) -> Point {
    let sum = gap.iter().fold(Vector::zeros(), |sum, point| sum + point.coords);
    Point::from(sum / gap.len().max(1) as f64)
}

fn farthest(gap: &[Point], from: Point) -> Point {
    let far = gap.iter().max_by(|a, b| (*a - from).norm().total_cmp(&(*b - from).norm()));
    far.copied().unwrap_or(from)
}

/// The place of a stretch that is nearest to a point.
fn foot(from: Point, to: Point, point: Point) -> Point {
    let along = to - from;
    let share = (point - from).dot(&along) / along.norm_squared().max(1e-18);
    from + along * share.clamp(0.0, 1.0)
}

fn length_m(way: &[Point]) -> f64 {
    way.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mcfs::PolygonInstance;
    use geo::Rect;

    /// Two passes that leave a strip of six tenths of the tool between them.
    #[test]
    fn a_gap_beside_a_line_is_visited_when_its_ground_is_worth_it() {
        let corners = [geo::coord! { x: 0.0, y: 0.0 }, geo::coord! { x: 1.0, y: 0.26 }];
        let instance = PolygonInstance {
            ground: Rect::new(corners[0], corners[1]).to_polygon(),
            tool_width_m: 0.1,
            body_radius_m: 0.05,
            starts: Vec::new(),
        };
        let walls = Walls::new(&instance);
        let visited = |ground_worth: f64| {
            let ways = [[(0.05, 0.05), (0.95, 0.05)], [(0.05, 0.21), (0.95, 0.21)]];
            let mut lines = ways.map(|way| way.map(|(x, y)| Point::new(x, y)).to_vec());
            let mut swept = SweptCounts::new(&instance.ground, instance.tool_width_m);
            for line in &lines {
                swept.put_in(line[0], line[1]);
            }
            let before = swept.coverage();
            Gaps { swept: &mut swept, walls: &walls, width_m: 0.1, ground_worth }.visit(&mut lines);
            let points: usize = lines.iter().map(Vec::len).sum();
            (before, swept.coverage(), points)
        };
        let (before, after, points) = visited(10.0);
        assert!(before < 0.8 && after > 0.94 && points > 4, "{before} {after} {points}");
        let (before, after, points) = visited(0.1);
        assert!((after - before).abs() < 1e-9 && points == 4, "{before} {after} {points}");
    }
}
