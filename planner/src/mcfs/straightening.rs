//! Straight walls from the stairs of a picture: slanted walls of a grid map are flights of squares, and lines that
//! follow them would turn at each.
//!
//! ```text
//!    ground                        ground
//!  ----+                         -----__          notches that are at most `depth_m` deep are given to the wall:
//!      +---+           ──▶             ‾‾--__     no disc wider than they are gets into them
//!  wall    +----                   wall      ‾--
//! ```
//!
//! The ground only shrinks, so what keeps its distance from the new walls keeps it from the old ones. Corners at which
//! the ground is convex are taken out one by one while every corner taken out between two that stay lies at most
//! `depth_m` from their chord, and no other corner lies in the triangle that is cut off.

use super::near::Near;
use geo::{CoordsIter, LineString, Orient, Polygon, orient::Direction};
use terrain::{Point, Segment};

/// The ground without its notches of at most `depth_m`, metres.
pub(crate) fn straightened(ground: &Polygon<f64>, depth_m: f64) -> Polygon<f64> {
    // Ground on the left of every ring.
    let ground = ground.orient(Direction::Default);
    let corners: Vec<Point> = ground.coords_iter().map(|corner| Point::new(corner.x, corner.y)).collect();
    let mut near = Near::new(corners.iter().copied(), 8.0 * depth_m);
    for (number, &corner) in corners.iter().enumerate() {
        near.insert_box(corner, corner, number as u32);
    }
    let mut stays = vec![true; corners.len()];
    let mut first = 0;
    for ring in std::iter::once(ground.exterior()).chain(ground.interiors()) {
        let count = ring.0.len();
        // The last corner repeats the first.
        stays[first + count - 1] = false;
        Ring { corners: &corners, near: &near, depth_m, first, count: count - 1 }.straighten(&mut stays);
        first += count;
    }
    rebuilt(&ground, &corners, &stays)
}

fn rebuilt(ground: &Polygon<f64>, corners: &[Point], stays: &[bool]) -> Polygon<f64> {
    let mut first = 0;
    let mut ring = |old: &LineString<f64>| -> LineString<f64> {
        let numbers = first..first + old.0.len();
        first += old.0.len();
        numbers.filter(|&number| stays[number]).map(|n| (corners[n].x, corners[n].y)).collect()
    };
    let exterior = ring(ground.exterior());
    Polygon::new(exterior, ground.interiors().iter().map(&mut ring).collect())
}

/// One ring among all corners.
struct Ring<'a> {
    corners: &'a [Point],
    near: &'a Near,
    depth_m: f64,
    first: usize,
    count: usize,
}

impl Ring<'_> {
    fn straighten(&self, stays: &mut [bool]) {
        let mut left = self.count;
        loop {
            let before = left;
            for number in self.first..self.first + self.count {
                if left > 3 && stays[number] && self.can_go(number, stays) {
                    stays[number] = false;
                    left -= 1;
                }
            }
            if left == before {
                return;
            }
        }
    }

    /// The nearest corner that stays, in steps of one forward or of `count - 1`, which is back.
    fn next(&self, mut number: usize, step: usize, stays: &[bool]) -> usize {
        loop {
            number = self.first + (number - self.first + step) % self.count;
            if stays[number] {
                return number;
            }
        }
    }

    fn can_go(&self, number: usize, stays: &[bool]) -> bool {
        let (before, after) = (self.next(number, self.count - 1, stays), self.next(number, 1, stays));
        let [a, b, c] = [before, number, after].map(|corner| self.corners[corner]);
        let turn = (b - a).perp(&(c - b));
        turn >= 0.0 && self.is_shallow(before, after) && (turn == 0.0 || self.is_empty([a, b, c], stays))
    }

    /// Whether all corners between two lie near their chord.
    fn is_shallow(&self, before: usize, after: usize) -> bool {
        let chord = Segment::new(self.corners[before], self.corners[after]);
        let between = (1..self.count).map(|step| self.first + (before - self.first + step) % self.count);
        between
            .take_while(|&corner| corner != after)
            .all(|corner| chord.distance_to_point(self.corners[corner]) <= self.depth_m)
    }

    /// Whether no other corner that stays lies in a triangle.
    fn is_empty(&self, [a, b, c]: [Point; 3], stays: &[bool]) -> bool {
        let (low, high) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
        let is_in = |point: Point| {
            let left_of = |from: Point, to: Point| (to - from).perp(&(point - from)) >= 0.0;
            left_of(a, b) && left_of(b, c) && left_of(c, a)
        };
        !self.near.in_box(low, high).any(|number| {
            let point = self.corners[number as usize];
            stays[number as usize] && ![a, b, c].contains(&point) && is_in(point)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geo::{Area, BooleanOps, Validation};
    use proptest::prelude::*;

    /// Squares of side 1 below a slanted line, ground above it.
    fn stairs(columns: i32, rise: f64) -> Polygon<f64> {
        let mut ring = vec![(f64::from(columns), 40.0), (0.0, 40.0)];
        for x in 0..columns {
            let y = (f64::from(x) * rise).floor();
            ring.extend([(f64::from(x), y), (f64::from(x + 1), y)]);
        }
        Polygon::new(ring.into_iter().collect(), Vec::new())
    }

    #[test]
    fn a_slanted_wall_becomes_straight() {
        let straight = straightened(&stairs(30, 0.5), 1.0);
        assert!(straight.exterior().0.len() <= 8, "{:?}", straight.exterior());
    }

    #[test]
    fn corners_of_rooms_stay() {
        let room = geo::Rect::new((0.0, 0.0), (8.0, 5.0)).to_polygon();
        assert!((straightened(&room, 1.0).unsigned_area() - 40.0).abs() < 1e-9);
    }

    proptest! {
        #[test]
        fn the_ground_only_shrinks_and_stays_sound(
            rise in -1.3_f64..1.3,
            holes in prop::collection::vec((3_i32..27, 3_i32..37), 0..6),
        ) {
            let mut ground = geo::MultiPolygon::new(vec![stairs(30, rise.abs())]);
            for (x, y) in holes {
                let (x, y) = (f64::from(x), f64::from(y));
                ground = ground.difference(&geo::Rect::new((x, y), (x + 2.0, y + 1.0)).to_polygon());
            }
            for part in ground {
                let straight = straightened(&part, 1.0);
                prop_assert!(straight.is_valid());
                prop_assert!(straight.difference(&part).unsigned_area() < 1e-9);
            }
        }
    }
}
