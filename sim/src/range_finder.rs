//! The range finder: distances all around, to walls, obstacles, people and other robots. Exact, as a good scanner
//! is on this scale; it looks from the middle of the robot and does not see the robot itself.

use crate::{
    clearance::Clearance,
    obstacle::{Shape, ray_to_disc_m},
};
use protocol::v1;
use std::f64::consts::{PI, TAU};
use terrain::{Point, Pose};

/// The beams of one type of robot.
#[derive(Debug, Clone)]
pub(crate) struct RangeFinder {
    reach_m: f64,
    step_rad: f64,
    beams: Vec<(f64, f64)>,
}

impl RangeFinder {
    pub(crate) fn new(reach_m: f64, beams: u32) -> Self {
        let step_rad = TAU / f64::from(beams.max(1));
        let beam = |number| {
            let (sin, cos) = (f64::from(number) * step_rad - PI).sin_cos();
            (cos, sin)
        };
        Self { reach_m, step_rad, beams: (0..beams).map(beam).collect() }
    }

    pub(crate) fn reach_m(&self) -> f64 {
        self.reach_m
    }

    /// What is seen from `eye`: the walls, and of `discs` and `shapes` what is near.
    pub(crate) fn scan(
        &self,
        walls: &Clearance,
        eye: &Pose,
        discs: impl Iterator<Item = (Point, f64)>,
        shapes: impl Iterator<Item = Shape>,
    ) -> v1::RangeScan {
        let at = Point::from(eye.translation.vector);
        let mut ranges_m = self.walls(walls, at, eye);
        for (centre, radius_m) in discs {
            self.lower_near(&mut ranges_m, at, eye, (centre, radius_m), |direction| {
                ray_to_disc_m(at, direction, centre, radius_m)
            });
        }
        for shape in shapes {
            self.lower_near(&mut ranges_m, at, eye, (shape.centre(), shape.reach_m()), |direction| {
                shape.ray_m(at, direction)
            });
        }
        v1::RangeScan {
            range_max_m: self.reach_m,
            angle_min_rad: -PI,
            angle_increment_rad: self.step_rad,
            ranges_m,
        }
    }

    fn walls(&self, walls: &Clearance, at: Point, eye: &Pose) -> Vec<f32> {
        if walls.at_least_m(at) >= self.reach_m {
            return vec![self.reach_m as f32; self.beams.len()];
        }
        self.beams.iter().map(|&beam| walls.ray_m(at, turned(beam, eye), self.reach_m) as f32).collect()
    }

    /// Lowers the beams that point towards something round of this middle and reach, by its own ray test.
    fn lower_near(
        &self,
        ranges_m: &mut [f32],
        at: Point,
        eye: &Pose,
        (centre, radius_m): (Point, f64),
        ray_m: impl Fn((f64, f64)) -> f64,
    ) {
        let to = centre - at;
        let distance_m = to.norm();
        if distance_m - radius_m >= self.reach_m || self.beams.is_empty() {
            return;
        }
        let (first, count) =
            self.beams_towards(to.y.atan2(to.x) - eye.rotation.angle(), distance_m, radius_m);
        for number in 0..count {
            let beam = (first + number).rem_euclid(self.beams.len() as i64) as usize;
            let seen_m = ray_m(turned(self.beams[beam], eye)) as f32;
            ranges_m[beam] = ranges_m[beam].min(seen_m);
        }
    }

    /// Number of the first beam, and how many, that can meet a disc.
    fn beams_towards(&self, bearing_rad: f64, distance_m: f64, radius_m: f64) -> (i64, i64) {
        let all = self.beams.len() as i64;
        if distance_m <= radius_m {
            return (0, all);
        }
        let half_rad = (radius_m / distance_m).asin();
        let first = ((bearing_rad - half_rad + PI) / self.step_rad).ceil();
        let last = ((bearing_rad + half_rad + PI) / self.step_rad).floor();
        (first as i64, (last - first + 1.0).clamp(0.0, all as f64) as i64)
    }
}

fn turned(beam: (f64, f64), eye: &Pose) -> (f64, f64) {
    let (cos, sin) = (eye.rotation.re, eye.rotation.im);
    (cos * beam.0 - sin * beam.1, sin * beam.0 + cos * beam.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain::{GridMap, Vector};

    fn walls() -> Clearance {
        Clearance::new(&GridMap::from_drawing(&[".........."; 10].join("\n"), 1.0).unwrap())
    }

    fn pose(x: f64, y: f64, theta: f64) -> Pose {
        Pose::new(Vector::new(x, y), theta)
    }

    /// The beam that points along `angle` of the map.
    fn seen(scan: &v1::RangeScan, eye: &Pose, angle: f64) -> f64 {
        let beam =
            (angle - eye.rotation.angle() - scan.angle_min_rad).rem_euclid(TAU) / scan.angle_increment_rad;
        f64::from(scan.ranges_m[beam.round() as usize % scan.ranges_m.len()])
    }

    #[test]
    fn a_wall_a_disc_and_a_box_are_seen_where_they_are() {
        let finder = RangeFinder::new(3.0, 48);
        let eye = pose(2.0, 5.0, PI / 4.0);
        let shape = Shape::Rectangle { x_m: 2.0, y_m: 3.0, width_m: 2.0, height_m: 1.0 };
        let disc = (Point::new(4.0, 5.0), 0.5);
        let scan = finder.scan(&walls(), &eye, [disc].into_iter(), [shape].into_iter());
        assert!((seen(&scan, &eye, 0.0) - 1.5).abs() < 1e-6, "disc");
        assert!((seen(&scan, &eye, -PI / 2.0) - 1.5).abs() < 1e-6, "box");
        assert!((seen(&scan, &eye, PI) - 2.0).abs() < 1e-5, "wall");
        assert!((seen(&scan, &eye, PI / 2.0) - 3.0).abs() < 1e-6, "nothing");
    }

    #[test]
    fn only_beams_near_the_bearing_are_touched() {
        let finder = RangeFinder::new(3.0, 48);
        let eye = pose(5.0, 5.0, 3.0);
        let scan = finder.scan(&walls(), &eye, [(Point::new(5.0, 7.0), 0.3)].into_iter(), std::iter::empty());
        let lowered = scan.ranges_m.iter().filter(|&&range| range < 2.9).count();
        assert_eq!(lowered, 3, "{:?}", scan.ranges_m);
    }
}
