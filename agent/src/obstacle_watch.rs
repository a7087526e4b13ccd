//! Sees what stands on the granted ground: hits of the range finder in the corridor ahead.
//!
//! Walls of the map and other robots are never there: the ground was planned clear of the first and granted clear
//! of the second. So whatever is hit there is an obstacle.

use crate::{localisation::Place, order_book::OrderBook};
use protocol::v1;
use terrain::{Point, Segment};

/// The corridor is wider than the body by this on each side, metres.
const SIDE_MARGIN_M: f64 = 0.02;
/// The robot stops this far before an obstacle, metres.
const GAP_M: f64 = 0.15;
/// Obstacles are looked for this far ahead of what stopping needs, metres.
const AHEAD_M: f64 = 0.4;
/// The way to the next node comes nearer to what is in the way by at least this, metres.
const AWAY_M: f64 = 0.002;
/// Points in a report.
const POINTS_MAX: usize = 32;

/// What the last scan showed.
#[derive(Debug, Clone, Default)]
pub(crate) struct ObstacleWatch {
    hits: Vec<Point>,
}

impl ObstacleWatch {
    /// Takes in a scan taken at `place`.
    pub(crate) fn take(
        &mut self,
        scan: &v1::RangeScan,
        place: Place,
        order: &OrderBook,
        body_radius_m: f64,
        stopping_m: f64,
    ) {
        self.hits.clear();
        let reach_m = stopping_m + body_radius_m + GAP_M + AHEAD_M;
        let corridor = corridor(place, order, reach_m);
        if corridor.is_empty() {
            return;
        }
        for (beam, &range) in scan.ranges_m.iter().enumerate() {
            let range = f64::from(range);
            if range >= scan.range_max_m - 1e-3 || range > reach_m + body_radius_m {
                continue;
            }
            let bearing = place.theta + scan.angle_min_rad + scan.angle_increment_rad * beam as f64;
            let hit = Point::new(place.x + range * bearing.cos(), place.y + range * bearing.sin());
            let here_m = (hit - place.point()).norm();
            let in_the_way = corridor.iter().enumerate().any(|(number, piece)| {
                let apart_m = piece.distance_to_point(hit);
                // What it stands beside is not in its way when it leads away from there.
                apart_m < body_radius_m + SIDE_MARGIN_M && (number > 0 || apart_m < here_m - AWAY_M)
            });
            if in_the_way && self.hits.len() < POINTS_MAX {
                self.hits.push(hit);
            }
        }
    }

    /// There is nothing to be hit any more.
    pub(crate) fn clear(&mut self) {
        self.hits.clear();
    }

    /// Whether something stands in the way.
    pub(crate) fn sees_something(&self) -> bool {
        !self.hits.is_empty()
    }

    /// What was hit, for the report.
    pub(crate) fn points(&self) -> Vec<v1::Point> {
        self.hits.iter().map(|hit| v1::Point { x_m: hit.x, y_m: hit.y }).collect()
    }
}

/// The base ahead of the robot, as far as `reach_m`.
fn corridor(place: Place, order: &OrderBook, reach_m: f64) -> Vec<Segment> {
    let mut pieces = Vec::new();
    let mut at = place.point();
    let mut left_m = reach_m;
    for node in order.base().skip(1) {
        let piece = Segment::new(at, node.point);
        let length_m = piece.length();
        if length_m >= left_m {
            let end = at + (node.point - at) * (left_m / length_m);
            pieces.push(Segment::new(at, end));
            break;
        }
        pieces.push(piece);
        left_m -= length_m;
        at = node.point;
    }
    pieces
}
