//! Drives from a robot's start to the tracks: shortest ways over places and links between neighbours.

use super::walls::Walls;
use super::web::Web;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use terrain::Point;

/// How far a place may be from its neighbour, in tool widths.
const REACH: f64 = 1.6;
/// How far from its start a robot looks for places, in tool widths: then twice as far, and so on.
const FIRST_LOOK: f64 = 1.6;
const LOOKS: usize = 8;

/// Distances of all places from one start.
pub(super) struct Drives {
    pub(super) distance_m: Vec<f64>,
    before: Vec<u32>,
}

/// Which places follow each other or lie beside each other with a clear way between.
pub(super) struct Neighbours(Vec<Vec<u32>>);

impl Neighbours {
    pub(super) fn new(web: &Web, walls: &Walls) -> Self {
        let reach_m = REACH * web.width_m;
        let of = |place: u32| {
            let beside = web.beside(place, reach_m);
            let clear =
                beside.filter(|&other| walls.is_clear(web.at[place as usize], web.at[other as usize]));
            clear.chain(web.links[place as usize]).collect()
        };
        Self((0..web.len() as u32).map(of).collect())
    }

    pub(super) fn of(&self, place: u32) -> &[u32] {
        &self.0[place as usize]
    }
}

impl Drives {
    /// `None` when no place can be reached straight from the start.
    pub(super) fn new(web: &Web, neighbours: &Neighbours, walls: &Walls, start: Point) -> Option<Self> {
        let mut drives =
            Self { distance_m: vec![f64::INFINITY; web.len()], before: vec![u32::MAX; web.len()] };
        let mut queue = BinaryHeap::new();
        for place in first_places(web, walls, start)? {
            let distance_m = (web.at[place as usize] - start).norm();
            drives.distance_m[place as usize] = distance_m;
            queue.push(Reverse((Metres(distance_m), place)));
        }
        while let Some(Reverse((Metres(so_far_m), place))) = queue.pop() {
            if so_far_m > drives.distance_m[place as usize] {
                continue;
            }
            for &next in neighbours.of(place) {
                let distance_m = so_far_m + web.distance_m(place, next);
                if distance_m < drives.distance_m[next as usize] {
                    drives.distance_m[next as usize] = distance_m;
                    drives.before[next as usize] = place;
                    queue.push(Reverse((Metres(distance_m), next)));
                }
            }
        }
        Some(drives)
    }

    /// The way from the start to a place: its points, start and place included, with no needless corner.
    pub(super) fn way(&self, web: &Web, walls: &Walls, start: Point, to: u32) -> Vec<Point> {
        let mut points = vec![web.at[to as usize]];
        let mut place = to;
        while self.before[place as usize] != u32::MAX {
            place = self.before[place as usize];
            points.push(web.at[place as usize]);
        }
        points.push(start);
        points.reverse();
        straightened(&points, walls)
    }
}

fn first_places(web: &Web, walls: &Walls, start: Point) -> Option<Vec<u32>> {
    (0..LOOKS).map(|look| FIRST_LOOK * web.width_m * f64::from(1_u32 << look)).find_map(|reach_m| {
        let seen = web.around(start, reach_m).filter(|&place| walls.is_clear(start, web.at[place as usize]));
        let seen: Vec<u32> = seen.collect();
        (!seen.is_empty()).then_some(seen)
    })
}

/// Leaves out every corner that can be left out.
fn straightened(points: &[Point], walls: &Walls) -> Vec<Point> {
    let mut kept = vec![points[0]];
    let mut at = 0;
    while at + 1 < points.len() {
        let is_clear = |&next: &usize| walls.is_clear(points[at], points[next]);
        at = (at + 2..points.len()).rev().find(is_clear).unwrap_or(at + 1);
        kept.push(points[at]);
    }
    kept
}

#[derive(PartialEq, PartialOrd)]
struct Metres(f64);

impl Eq for Metres {}

#[expect(clippy::derive_ord_xor_partial_ord, reason = "distances are finite: both orders are one")]
impl Ord for Metres {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}
