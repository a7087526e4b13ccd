//! The tracks as places a short way apart, with links between those that follow each other.
//!
//! The links always form closed lines. Taking two links out and putting two others in joins two closed lines or parts
//! one: all that planning does is choosing such pairs.

use super::joint::{Cost, End, joint, turn_rad};
use super::near::Near;
use super::tracks::Track;
use super::walls::Walls;
use terrain::{Point, Vector};

/// Places are at most so many tool widths apart.
pub(super) const SPACING: f64 = 0.5;
/// Headings are taken over about so many tool widths.
const HEADING_OVER: f64 = 0.9;
/// Links up to so many tool widths are stretches of a track.
const SHORT: f64 = 0.55;

/// Corners with a sharper turn have a tip.
const SHARP_RAD: f64 = 2.0;
/// Tips are cut off by so many tool widths.
const BLUNT: f64 = 0.02;

/// Places and links.
#[derive(Clone)]
pub(super) struct Web {
    pub(super) at: Vec<Point>,
    pub(super) track: Vec<u32>,
    /// The two places before and after each; no matter which is which.
    pub(super) links: Vec<[u32; 2]>,
    pub(super) width_m: f64,
    /// Way along the track up to each place, metres.
    along_m: Vec<f64>,
    track_m: Vec<f64>,
    near: Near,
}

/// Two links to take out, and two to put in: `one.0`–`other.0` and `one.1`–`other.1`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Exchange {
    pub(super) one: (u32, u32),
    pub(super) other: (u32, u32),
}

impl Exchange {
    /// The exchange that takes this one back.
    pub(super) fn undone(self) -> Self {
        Self { one: (self.one.0, self.other.0), other: (self.one.1, self.other.1) }
    }
}

impl Web {
    pub(super) fn new(tracks: &[Track], width_m: f64) -> Self {
        let corners = tracks.iter().flat_map(|track| track.corners.iter().copied());
        let mut web = Self {
            at: Vec::new(),
            track: Vec::new(),
            links: Vec::new(),
            width_m,
            along_m: Vec::new(),
            track_m: Vec::new(),
            near: Near::new(corners, width_m),
        };
        for (number, track) in tracks.iter().enumerate() {
            web.add_track(number as u32, track);
        }
        web
    }

    fn add_track(&mut self, number: u32, track: &Track) {
        let first = self.at.len() as u32;
        let mut along_m = 0.0;
        let corners = blunted(&track.corners, BLUNT * self.width_m);
        for (corner, from) in corners.iter().enumerate() {
            let step = corners[(corner + 1) % corners.len()] - from;
            let pieces = (step.norm() / (SPACING * self.width_m)).ceil().max(1.0);
            for piece in 0..pieces as usize {
                let place = from + step * (piece as f64 / pieces);
                self.near.insert(place, self.at.len() as u32);
                self.at.push(place);
                self.track.push(number);
                self.along_m.push(along_m + step.norm() * (piece as f64 / pieces));
            }
            along_m += step.norm();
        }
        self.track_m.push(along_m);
        let end = self.at.len() as u32;
        for place in first..end {
            let before = if place == first { end - 1 } else { place - 1 };
            let after = if place + 1 == end { first } else { place + 1 };
            self.links.push([before, after]);
        }
    }

    pub(super) fn len(&self) -> usize {
        self.at.len()
    }

    pub(super) fn distance_m(&self, a: u32, b: u32) -> f64 {
        (self.at[b as usize] - self.at[a as usize]).norm()
    }

    /// Places within reach of one that are not just before or after it on its track.
    pub(super) fn beside(&self, place: u32, reach_m: f64) -> impl Iterator<Item = u32> + '_ {
        self.near.around(self.at[place as usize], reach_m).filter(move |&other| {
            other != place
                && self.distance_m(place, other) <= reach_m
                && self.way_between_m(place, other) > 2.5 * reach_m
        })
    }

    /// Places within reach of a point.
    pub(super) fn around(&self, point: Point, reach_m: f64) -> impl Iterator<Item = u32> + '_ {
        let near = self.near.around(point, reach_m);
        near.filter(move |&place| (self.at[place as usize] - point).norm() <= reach_m)
    }

    /// The shorter way along the track between two places, if it is the same one.
    fn way_between_m(&self, a: u32, b: u32) -> f64 {
        let track = self.track[a as usize];
        if track != self.track[b as usize] {
            return f64::INFINITY;
        }
        let way_m = (self.along_m[a as usize] - self.along_m[b as usize]).abs();
        way_m.min(self.track_m[track as usize] - way_m)
    }

    pub(super) fn linked(&self, a: u32, b: u32) -> bool {
        self.links[a as usize].contains(&b)
    }

    /// The place that follows `place` when one comes from `before`.
    pub(super) fn beyond(&self, before: u32, place: u32) -> u32 {
        let [one, other] = self.links[place as usize];
        if one == before { other } else { one }
    }

    /// Place and heading when one arrives at `place` and would go on to `ahead`.
    pub(super) fn arriving(&self, place: u32, ahead: u32) -> End {
        let at = self.at[place as usize];
        let (mut back, mut seen) = (place, ahead);
        for _ in 0..6 {
            let next = self.beyond(seen, back);
            (seen, back) = (back, next);
            if (at - self.at[back as usize]).norm() >= HEADING_OVER * self.width_m || back == ahead {
                break;
            }
        }
        let heading = (at - self.at[back as usize]).try_normalize(1e-9).unwrap_or_else(Vector::x);
        End { at, heading }
    }

    /// What way and turning an exchange adds.
    pub(super) fn cost(&self, exchange: Exchange) -> Cost {
        let Exchange { one: (a, a2), other: (b, b2) } = exchange;
        let [a_end, a2_end] = [self.arriving(a, a2), self.arriving(a2, a)];
        let [b_end, b2_end] = [self.arriving(b, b2), self.arriving(b2, b)];
        let leave = |end: End| End { at: end.at, heading: -end.heading };
        let joint = |from: End, to: End| joint(from, leave(to), self.width_m);
        let put_in = [joint(a_end, b_end), joint(a2_end, b2_end)];
        let taken_out = [self.standing(a_end, a2_end), self.standing(b_end, b2_end)];
        let sum = |costs: &[Cost; 2], of: fn(&Cost) -> f64| costs.iter().map(of).sum::<f64>();
        Cost {
            length_m: sum(&put_in, |cost| cost.length_m) - sum(&taken_out, |cost| cost.length_m),
            turn_rad: sum(&put_in, |cost| cost.turn_rad) - sum(&taken_out, |cost| cost.turn_rad),
        }
    }

    /// What a link that is there costs.
    fn standing(&self, from: End, to: End) -> Cost {
        let length_m = (to.at - from.at).norm();
        if length_m > SHORT * self.width_m {
            return joint(from, End { at: to.at, heading: -to.heading }, self.width_m);
        }
        Cost { length_m, turn_rad: turn_rad(from.heading, -to.heading) }
    }

    /// Whether the two new links keep clear of walls and do not cross each other.
    pub(super) fn allows(&self, exchange: Exchange, walls: &Walls) -> bool {
        let Exchange { one: (a, a2), other: (b, b2) } = exchange;
        let at = |place: u32| self.at[place as usize];
        self.is_plain(exchange) && walls.is_clear(at(a), at(b)) && walls.is_clear(at(a2), at(b2))
    }

    /// Whether a new link of an exchange crosses a link that stays.
    pub(super) fn crosses(&self, exchange: Exchange) -> bool {
        let Exchange { one: (a, a2), other: (b, b2) } = exchange;
        let ends = [a, a2, b, b2];
        let stays = |from: u32, to: u32| !(ends.contains(&from) && ends.contains(&to));
        [(a, b), (a2, b2)].into_iter().any(|(from, to)| {
            let (start, end) = (self.at[from as usize], self.at[to as usize]);
            let reach_m = 0.5 * (end - start).norm() + 0.5 * self.width_m;
            self.around(start + (end - start) * 0.5, reach_m).any(|place| {
                self.links[place as usize].into_iter().any(|next| {
                    stays(place, next)
                        && ![from, to].contains(&place)
                        && ![from, to].contains(&next)
                        && cross(start, end, self.at[place as usize], self.at[next as usize])
                })
            })
        })
    }

    /// Whether the four places differ and the new links neither cross nor reach too far.
    pub(super) fn is_plain(&self, exchange: Exchange) -> bool {
        let Exchange { one: (a, a2), other: (b, b2) } = exchange;
        let at = |place: u32| self.at[place as usize];
        b != a2 && b2 != a && a != b && a2 != b2 && !cross(at(a), at(b), at(a2), at(b2))
    }

    /// Whether a link is a stretch of a track.
    pub(super) fn is_short(&self, a: u32, b: u32) -> bool {
        self.distance_m(a, b) <= SHORT * self.width_m
    }

    /// Whether a place follows another one on their track.
    pub(super) fn is_stretch(&self, a: u32, b: u32) -> bool {
        self.way_between_m(a, b) <= (1.0 + 1e-6) * SPACING * self.width_m
    }

    pub(super) fn apply(&mut self, exchange: Exchange) {
        let Exchange { one: (a, a2), other: (b, b2) } = exchange;
        for (place, old, new) in [(a, a2, b), (a2, a, b2), (b, b2, a), (b2, b, a2)] {
            let links = &mut self.links[place as usize];
            let slot = links.iter().position(|&link| link == old).expect("the link is there");
            links[slot] = new;
        }
    }

    /// The closed line through a place, from there on.
    pub(super) fn closed_line(&self, start: u32) -> Vec<u32> {
        let mut line = vec![start];
        let (mut before, mut place) = (start, self.links[start as usize][1]);
        while place != start {
            line.push(place);
            let next = self.beyond(before, place);
            (before, place) = (place, next);
        }
        line
    }

    /// All closed lines.
    pub(super) fn closed_lines(&self) -> Vec<Vec<u32>> {
        let mut seen = vec![false; self.len()];
        let mut lines = Vec::new();
        for start in 0..self.len() as u32 {
            if !seen[start as usize] {
                let line = self.closed_line(start);
                for &place in &line {
                    seen[place as usize] = true;
                }
                lines.push(line);
            }
        }
        lines
    }
}

/// The corners of a closed line, each sharp one as two: there is a link to take out at every tip.
fn blunted(corners: &[Point], back_m: f64) -> Vec<Point> {
    let count = corners.len();
    let blunt = |at: usize| {
        let [before, here, after] = [count - 1, 0, 1].map(|step| corners[(at + step) % count]);
        let (to, on) = (here - before, after - here);
        if turn_rad(to, on) < SHARP_RAD {
            return vec![here];
        }
        let back = |way: Vector| way * (back_m / way.norm()).min(0.3);
        vec![here - back(to), here + back(on)]
    };
    (0..count).flat_map(blunt).collect()
}

fn cross(a: Point, b: Point, c: Point, d: Point) -> bool {
    let side = |a: Point, b: Point, c: Point| (b - a).perp(&(c - a));
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}
