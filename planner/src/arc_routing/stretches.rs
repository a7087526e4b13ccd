//! Stretches: what has to be driven, taken from routes that cover everything.

use crate::Instance;
use terrain::{Point, Segment, SweptRaster, Vector};

/// Pieces shorter than this many tool widths are left to those beside them where these sweep all that is wanted.
const SHORT_TOOLS: f64 = 1.5;

/// A line to be driven in one direction or the other.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stretch {
    /// At least one.
    pub(crate) points: Vec<Point>,
    /// Time from end to end, seconds.
    pub(crate) inner_s: f64,
}

impl Stretch {
    pub(crate) fn new(instance: &Instance<'_>, points: Vec<Point>) -> Self {
        let inner_s = instance.path_s(&points, None);
        Self { points, inner_s }
    }

    /// Its points from one of its ends on; even ends are first points.
    pub(crate) fn entered_at(&self, end: u32) -> Vec<Point> {
        let mut points = self.points.clone();
        if end % 2 == 1 {
            points.reverse();
        }
        points
    }

    /// Where an end is, and the heading with which it is left there.
    pub(crate) fn leaves_at(&self, end: u32) -> (Point, Option<f64>) {
        let points = self.entered_at(end ^ 1);
        let last = points.len() - 1;
        let step = (last > 0).then(|| points[last] - points[last - 1]);
        (points[last], step.map(|step| step.y.atan2(step.x)))
    }
}

/// Straight pieces of a line that together sweep what the line sweeps of the wanted ground, in their order; none longer
/// than `most_m`. Longer pieces come first in what they sweep: short ones between them are kept only where they add.
pub(super) fn stretches_of(instance: &Instance<'_>, line: &[Point], most_m: f64) -> Vec<Stretch> {
    let pieces = straight_pieces(line);
    let length_m = |piece: usize| (pieces[piece].1 - pieces[piece].0).norm();
    let mut order: Vec<usize> = (0..pieces.len()).collect();
    let short_m = SHORT_TOOLS * instance.floor.tool_width_m();
    order.sort_by(|&a, &b| {
        let short = |piece: usize| if length_m(piece) < short_m { length_m(piece) } else { f64::INFINITY };
        short(b).total_cmp(&short(a)).then(a.cmp(&b))
    });
    let mut swept = SweptRaster::new(*instance.floor.lattice());
    let mut kept = vec![false; pieces.len()];
    for piece in order {
        kept[piece] = sweeps_new(instance, &mut swept, pieces[piece].0, pieces[piece].1);
    }
    let pieces = pieces.into_iter().zip(kept).filter(|(_, kept)| *kept);
    pieces.flat_map(|((from, to), _)| cut(instance, from, to, most_m)).collect()
}

/// The line without its points that lie straight between others.
fn straight_pieces(line: &[Point]) -> Vec<(Point, Point)> {
    let mut pieces: Vec<(Point, Point)> = Vec::new();
    for pair in line.windows(2).filter(|pair| (pair[1] - pair[0]).norm() > 1e-9) {
        match pieces.last_mut() {
            Some((from, to)) if is_straight(*from, *to, pair[1]) => *to = pair[1],
            _ => pieces.push((pair[0], pair[1])),
        }
    }
    pieces
}

fn is_straight(from: Point, over: Point, to: Point) -> bool {
    let (one, other) = (over - from, to - over);
    one.dot(&other) > 0.0 && one.perp(&other).abs() <= 1e-6 * one.norm() * other.norm()
}

fn cut(instance: &Instance<'_>, from: Point, to: Point, most_m: f64) -> Vec<Stretch> {
    let step: Vector = to - from;
    let parts = (step.norm() / most_m).ceil().max(1.0) as u32;
    let at = |part: u32| from + step * (f64::from(part) / f64::from(parts));
    (0..parts).map(|part| Stretch::new(instance, vec![at(part), at(part + 1)])).collect()
}

/// Sweeps a piece: whether that gains wanted ground.
fn sweeps_new(instance: &Instance<'_>, swept: &mut SweptRaster, from: Point, to: Point) -> bool {
    let (floor, lattice) = (instance.floor, instance.floor.lattice());
    let radius_m = floor.tool_width_m() / 2.0;
    let margin = Vector::repeat(radius_m);
    let low = Point::from(from.coords.inf(&to.coords) - margin);
    let high = Point::from(from.coords.sup(&to.coords) + margin);
    let cells = lattice.cells_in_box(low, high).filter_map(|cell| lattice.index(cell));
    let wanted = cells.filter(|&index| instance.visit[index]);
    let before: Vec<(usize, u64)> = wanted.map(|index| (index, swept.samples(index))).collect();
    swept.sweep(Segment::new(from, to), radius_m, |_| {});
    before.into_iter().any(|(index, samples)| floor.required(index) & swept.samples(index) & !samples != 0)
}
