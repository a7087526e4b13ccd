//! Smooth coverage of polygons by many robots: connected Fermat spirals, cut at any length.
//!
//! ```text
//!   PolygonInstance ──▶ tracks ──▶ one closed line ──▶ smoothed ──▶ k closed lines ──▶ smoothed ──▶ Plan
//!                      offsets     exchanges of links   ground       chords            near cuts    from each start
//!                                                       stays swept                                and back
//! ```
//!
//! **Problem.** A polygon with holes of area A, k robots at given starts, a round tool of width l. Sweep the ground
//! with one closed line per robot so that the longest one, with the drive from the start and back, is short, lines
//! turn little, and neither tool nor body leaves the ground.
//!
//! **Idea.** Closed *tracks* lie at (i − ½)·l from the walls, each offset from the polygon itself, and thin ones fill
//! what the innermost tracks leave. Two links between places side by side are *exchanged* against two others: that
//! joins two closed lines, and where it costs least way and turning (at corners, at ends of pockets, beside an earlier
//! joint) it turns tracks into the two arms of a Fermat spiral. The line is smoothed: stretches give way to straight
//! ones and bends while way + turning + ground lost becomes less, so that jogs of neighbouring arms become slants. Gaps
//! that are left are visited by detours that are worth it; where plenty is swept, what costs most way and turning for
//! its ground is given up again. An exchange within one line, a *chord*, cuts it at any length into two; k − 1 chords
//! share the line out, and pairs of neighbours are joined and cut again, or hand a part over, until line and drives are
//! even. The shares are smoothed near the cuts, tips are rounded, and shares are evened out anew by the lengths that
//! came of it.
//!
//! **Guarantee.** Lines keep the body's radius from every wall (each link, chord, drive and shortcut is tested against
//! the walls themselves). One line per piece of ground that some robot reaches. None on makespan; the bound is
//! c·A ÷ (k·l) − π·l/4 for a swept share c.
//!
//! **Complexity.** n places (about 2·A/l²): O(n log n) to join, O(n) for each pair that is evened out, O(n) squares of
//! the raster a sweep of smoothing. Offsets: O(corners · log) each, A/(l · perimeter) of them.
//!
//! **Paper.** J. Tang and H. Ma, *Multi-Robot Connected Fermat Spiral Coverage*, ICAPS 2024.
//!
//! **Departures.** First track at half a tool from the wall instead of a whole one: that is the 7 to 13 % the paper's
//! lines leave. Offsets are exact, no distance field. No graph of isolines and no tree cover: lines are cut at any
//! length, so shares are even without a mixed-integer model. Drives are charged. `coverage_target` sweeps a share.
//!
//! **Symbols.** l: `tool_width_m`; k: number of `starts`; A: `area_m2()`; isoline: track; stitching tuple: exchange.

mod drive;
mod gaps;
mod joining;
mod joint;
mod line;
mod near;
mod polygon_instance;
mod sharing;
mod smoothing;
mod straightening;
mod swept_counts;
mod target;
mod tips;
mod tracks;
mod walls;
mod web;

pub use polygon_instance::{PolygonError, PolygonInstance};
pub(crate) use straightening::straightened;

use crate::{Plan, Route};
use drive::{Drives, Neighbours};
use gaps::Gaps;
use line::Line;
use sharing::{Share, Sharing};
use smoothing::Smoothing;
use swept_counts::SweptCounts;
use terrain::Point;
use tracks::Track;
use walls::Walls;
use web::Web;

/// Strips narrower than this share of the tool's width get no track of their own: the smoothing sweeps them.
const LEAST_STRIP: f64 = 0.6;
/// The same for the last attempt on small ground: with a track on narrower strips, lines are longer and turn less.
const NARROW_STRIP: f64 = 0.5;
/// What ground is worth when all is to be swept. The last half percent costs most turning for its ground.
const FULL_GROUND: GroundWorth = GroundWorth {
    before: 10.0,
    scanty: 0.97,
    plenty: 0.9955,
    beyond: [5.0, 3.0],
    turn_beyond: 2.0 * TURN_WORTH,
};

/// Lines of which the longest is beyond the mean by no more than this share are even.
const EVEN: f64 = 1e-3;
/// Way that it is worth to leave as much way with its robot, once lines are smoothed.
const STAY_WORTH: f64 = 0.1;
/// Way that one radian of turning is worth when lines are smoothed, as a share of the tool's width.
const TURN_WORTH: f64 = 0.5;
/// By how much less the ground of a gap is worth that takes a detour.
const GAP_DISCOUNT: f64 = 3.7;

/// The most places × robots in all attempts beyond the first.
const ATTEMPTS_WORK: usize = 60_000;

/// How to cover polygons.
#[derive(Debug, Clone, PartialEq)]
pub struct McfsOptions {
    /// Share of the ground to be swept, in (0, 1]; `None`: all that can be.
    pub coverage_target: Option<f64>,
    /// Bound on the rounds in which shares are evened out.
    pub rounds: usize,
    /// How often shares are evened out anew by the lengths of the smoothed lines.
    pub corrections: usize,
    /// On small ground so many plans are made, and the best is taken: the first share is cut off at one place after the
    /// other, and the last plan has tracks on narrower strips.
    pub attempts: usize,
    /// The paper's own pipeline in place of ours, on floors with a map; it knows no coverage target.
    pub paper: Option<crate::isograph::SpiralOptions>,
}

impl Default for McfsOptions {
    fn default() -> Self {
        Self { coverage_target: None, rounds: 12, corrections: 3, attempts: 3, paper: None }
    }
}

/// One closed line per robot, from its start and back.
///
/// # Errors
///
/// [`PolygonError`], when the polygon or a start is not sound.
pub fn cover(instance: &PolygonInstance, options: &McfsOptions) -> Result<Plan, PolygonError> {
    instance.check()?;
    let cover = match options.coverage_target {
        None => whole(instance, options),
        Some(target) => target::cover_share(instance, options, target),
    };
    let lines = cover.ok_or(PolygonError::TooWide { width_m: 2.0 * instance.clearance_m() })?.lines;
    Ok(Plan { routes: lines.into_iter().map(Route::new).collect() })
}

/// As [`cover`], for ground that was traced from a map: robots that fit nowhere on the tracks stay where they are.
pub(crate) fn cover_ground(instance: &PolygonInstance, options: &McfsOptions) -> Vec<Vec<Point>> {
    whole(instance, options).map_or_else(Vec::new, |cover| cover.lines)
}

/// How much more ground is worth than the way that sweeps it.
#[derive(Debug, Clone, Copy)]
struct GroundWorth {
    before: f64,
    /// While less than this share of the ground is swept, gaps are worth that much, too, and no less.
    scanty: f64,
    /// When more than this share of the ground is swept, what is beyond may be given up again,
    plenty: f64,
    /// at these worths, one after the other,
    beyond: [f64; 2],
    /// where one radian of turning is worth this share of the tool's width in way.
    turn_beyond: f64,
}

/// Lines, and what they sweep.
#[derive(Clone)]
struct Cover {
    lines: Vec<Vec<Point>>,
    coverage: f64,
    /// Ground that several of them sweep.
    shared_m2: f64,
}

impl Cover {
    fn lengths_m(&self) -> Vec<f64> {
        self.lines.iter().map(|line| length_m(line)).collect()
    }

    fn makespan_m(&self) -> f64 {
        self.lengths_m().into_iter().fold(0.0, f64::max)
    }

    fn is_even(&self) -> bool {
        let mean_m = self.lengths_m().iter().sum::<f64>() / self.lines.len() as f64;
        self.makespan_m() < (1.0 + EVEN) * mean_m
    }

    /// The makespan, and what each robot's part of the turning, of the ground left and of the ground swept by several
    /// is worth.
    fn cost_m(&self, instance: &PolygonInstance, worth: &GroundWorth) -> f64 {
        let (robots, width_m) = (self.lines.len() as f64, instance.tool_width_m);
        let left = 1.0 - self.coverage.min(worth.plenty);
        let left_m = worth.before / GAP_DISCOUNT * left * instance.area_m2() / width_m;
        let turns_m =
            TURN_WORTH * width_m * self.lines.iter().map(|line| joint::turning_rad(line)).sum::<f64>();
        self.makespan_m() + (left_m + turns_m + self.shared_m2 / width_m) / robots
    }
}

/// Sweeps all that can be swept; `None` when there is no track.
fn whole(instance: &PolygonInstance, options: &McfsOptions) -> Option<Cover> {
    let tracks = tracks::tracks(instance, tracks::first_distance_m(instance));
    let with_strips = |least: f64| [tracks.clone(), tracks::strips(instance, &tracks, least)].concat();
    let first = with_strips(LEAST_STRIP);
    let joined = Joined::new(instance, &first, &FULL_GROUND)?;
    let attempts = joined.attempts(options);
    if attempts == 1 {
        return joined.best_cover(options, 1);
    }
    let narrow = with_strips(NARROW_STRIP);
    let is_new = narrow != first;
    let other = is_new.then(|| Joined::new(instance, &narrow, &FULL_GROUND)?.best_cover(options, 1));
    let covers =
        joined.best_cover(options, attempts - usize::from(is_new)).into_iter().chain(other.flatten());
    covers.min_by(|a, b| joined.compare(a, b))
}

/// Joins tracks, shares them out and smooths them.
fn lines_along(
    instance: &PolygonInstance,
    options: &McfsOptions,
    tracks: &[Track],
    worth: &GroundWorth,
) -> Option<Cover> {
    let joined = Joined::new(instance, tracks, worth)?;
    joined.best_cover(options, joined.attempts(options))
}

/// Tracks that were joined and smoothed, with the drives of all robots to them.
struct Joined<'a> {
    instance: &'a PolygonInstance,
    worth: &'a GroundWorth,
    walls: Walls,
    web: Web,
    neighbours: Neighbours,
    drives: Vec<Option<Drives>>,
}

impl<'a> Joined<'a> {
    /// `None` when there is no track.
    fn new(instance: &'a PolygonInstance, tracks: &[Track], worth: &'a GroundWorth) -> Option<Self> {
        if tracks.is_empty() {
            return None;
        }
        let walls = Walls::new(instance);
        let mut web = Web::new(tracks, instance.tool_width_m);
        joining::join(&mut web, &walls);
        let web = Web::new(&smooth_tours(instance, &web, &walls, worth), instance.tool_width_m);
        let neighbours = Neighbours::new(&web, &walls);
        let drives =
            instance.starts.iter().map(|&start| Drives::new(&web, &neighbours, &walls, start)).collect();
        Some(Self { instance, worth, walls, web, neighbours, drives })
    }

    /// How many plans the ground is small enough for.
    fn attempts(&self, options: &McfsOptions) -> usize {
        (ATTEMPTS_WORK / (self.web.len() * self.drives.len()).max(1)).clamp(1, options.attempts.max(1))
    }

    /// The best of so many covers.
    fn best_cover(&self, options: &McfsOptions, attempts: usize) -> Option<Cover> {
        let covers = (0..attempts).map(|rank| {
            let mut web = self.web.clone();
            let mut sharing = Sharing {
                web: &mut web,
                walls: &self.walls,
                neighbours: &self.neighbours,
                drives: &self.drives,
                corrections_m: vec![0.0; self.drives.len()],
            };
            let shares = peeled(&mut sharing, rank);
            evened_out(self.instance, options, &mut sharing, shares, self.worth)
        });
        covers.min_by(|a, b| self.compare(a, b))
    }

    fn compare(&self, one: &Cover, other: &Cover) -> std::cmp::Ordering {
        one.cost_m(self.instance, self.worth).total_cmp(&other.cost_m(self.instance, self.worth))
    }
}

/// First shares of every closed line, among the robots that reach it.
fn peeled(sharing: &mut Sharing<'_>, rank: usize) -> Vec<Share> {
    let mut shares = Vec::new();
    for line in sharing.web.closed_lines() {
        let reaches = |&robot: &usize| sharing.drive_m(robot, &line[..1]).is_finite();
        let robots: Vec<usize> = (0..sharing.drives.len()).filter(reaches).collect();
        if !robots.is_empty() {
            shares.extend(sharing.peel(line, robots, rank));
        }
    }
    shares
}

/// Evens shares out and smooths them, then again by the lengths that came of it: the best of these covers.
fn evened_out(
    instance: &PolygonInstance,
    options: &McfsOptions,
    sharing: &mut Sharing<'_>,
    mut shares: Vec<Share>,
    worth: &GroundWorth,
) -> Cover {
    sharing.settle(&mut shares, options.rounds, 0.0);
    let mut last = smoothed(instance, sharing, &shares, worth, None);
    let mut best = last.clone();
    for _ in 0..options.corrections {
        if last.is_even() {
            break;
        }
        let before = shares.clone();
        let lengths_m = last.lengths_m();
        for share in &shares {
            let raw_m = sharing.cost_m(share) - sharing.corrections_m[share.robot];
            sharing.corrections_m[share.robot] = lengths_m[share.robot] - raw_m;
        }
        sharing.settle(&mut shares, options.rounds, STAY_WORTH);
        if shares == before {
            break;
        }
        last = smoothed(instance, sharing, &shares, worth, Some((&before, &last)));
        if last.cost_m(instance, worth) < best.cost_m(instance, worth) {
            best = last.clone();
        }
    }
    best
}

/// The closed lines of a web, smoothed.
fn smooth_tours(instance: &PolygonInstance, web: &Web, walls: &Walls, worth: &GroundWorth) -> Vec<Track> {
    let closed = |line: Vec<u32>| {
        let mut points: Vec<Point> = line.iter().map(|&place| web.at[place as usize]).collect();
        points.push(points[0]);
        Line::all_new(points)
    };
    let tours = web.closed_lines().into_iter().map(closed).collect();
    let open = |mut corners: Vec<Point>| {
        corners.pop();
        Track { depth: 0, corners }
    };
    polished(instance, walls, worth, tours).lines.into_iter().map(open).collect()
}

/// The shares as lines from the starts and back, smoothed; shares that are as before keep their lines.
fn smoothed(
    instance: &PolygonInstance,
    sharing: &Sharing<'_>,
    shares: &[Share],
    worth: &GroundWorth,
    before: Option<(&[Share], &Cover)>,
) -> Cover {
    let own = |shares: &'_ [Share], robot: usize| -> Vec<Share> {
        shares.iter().filter(|share| share.robot == robot).cloned().collect()
    };
    let line = |(robot, &start): (usize, &Point)| {
        let trips = own(shares, robot);
        if let Some((_, cover)) = before.filter(|(before, _)| own(before, robot) == trips) {
            return Line::as_before(cover.lines[robot].clone());
        }
        let mut line = Line::as_before(vec![start]);
        // Lines that could not be joined: one trip each.
        for trip in &trips {
            if let Some(drives) = &sharing.drives[robot] {
                round_trip(sharing.web, sharing.walls, drives, trip, &mut line);
            }
        }
        line
    };
    let lines = instance.starts.iter().enumerate().map(line).collect();
    polished(instance, sharing.walls, worth, lines)
}

/// Smooths lines, visits the gaps they leave, and gives up ground that is not worth its way.
fn polished(instance: &PolygonInstance, walls: &Walls, worth: &GroundWorth, lines: Vec<Line>) -> Cover {
    let mut swept = SweptCounts::new(&instance.ground, instance.tool_width_m);
    for pair in lines.iter().flat_map(|line| line.points.windows(2)) {
        swept.put_in(pair[0], pair[1]);
    }
    let width_m = instance.tool_width_m;
    let (ground_worth, turn_worth) = (worth.before, TURN_WORTH);
    let quiet = lines.iter().map(Line::quiet).collect();
    let mut lines: Vec<Vec<Point>> = lines.into_iter().map(|line| line.points).collect();
    Smoothing { swept: &mut swept, walls, width_m, ground_worth, turn_worth, least_coverage: 0.0 }
        .smooth(&mut lines, quiet);
    for (below, ground_worth) in [(worth.plenty, worth.before / GAP_DISCOUNT), (worth.scanty, worth.before)] {
        if swept.coverage() < below {
            Gaps { swept: &mut swept, walls, width_m, ground_worth }.visit(&mut lines);
        }
    }
    for ground_worth in worth.beyond {
        let (turn_worth, least_coverage) = (worth.turn_beyond, worth.plenty);
        if swept.coverage() > least_coverage {
            let quiet = lines.iter().map(|line| vec![false; line.len()]).collect();
            Smoothing { swept: &mut swept, walls, width_m, ground_worth, turn_worth, least_coverage }
                .smooth(&mut lines, quiet);
        }
    }
    for line in &mut lines {
        tips::round_tips(line, walls, width_m);
    }
    let shared_m2 = SweptCounts::shared_m2(&instance.ground, width_m, &lines);
    Cover { coverage: swept.coverage(), shared_m2, lines }
}

fn length_m(line: &[Point]) -> f64 {
    line.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

/// Goes on from the start into a closed line where that is shortest, along it, and back.
fn round_trip(web: &Web, walls: &Walls, drives: &Drives, share: &Share, line: &mut Line) {
    let places = &share.line;
    let start = line.points[0];
    let after = |at: usize| places[(at + 1) % places.len()];
    let detour_m = |at: usize| {
        let (place, next) = (places[at], after(at));
        drives.distance_m[place as usize] + drives.distance_m[next as usize] - web.distance_m(place, next)
    };
    let leaves = (0..places.len()).min_by(|&a, &b| detour_m(a).total_cmp(&detour_m(b))).unwrap_or(0);
    line.drive(drives.way(web, walls, start, after(leaves)));
    for step in 1..places.len() {
        let (from, to) = (after(leaves + step - 1), after(leaves + step));
        line.go(web.at[to as usize], !web.is_stretch(from, to));
    }
    line.drive(drives.way(web, walls, start, places[leaves]).into_iter().rev().collect());
}

/// The tracks of full coverage with their numbers from the walls inwards, ground on the left: isolines for the paper's
/// own pipeline.
pub(crate) fn numbered_tracks(instance: &PolygonInstance) -> Vec<(u32, Vec<Point>)> {
    let tracks = tracks::tracks(instance, tracks::first_distance_m(instance));
    tracks.into_iter().map(|track| (track.depth as u32, track.corners)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use geo::{Area, Buffer, Coord, LineString, Polygon};
    use proptest::prelude::*;
    use terrain::Segment;

    const WIDTH_M: f64 = 0.1;

    fn ring(corners: &[(f64, f64)]) -> LineString<f64> {
        corners.iter().map(|&(x, y)| Coord { x, y }).collect()
    }

    fn instance(exterior: &[(f64, f64)], holes: &[&[(f64, f64)]], starts: &[(f64, f64)]) -> PolygonInstance {
        PolygonInstance {
            ground: Polygon::new(ring(exterior), holes.iter().map(|hole| ring(hole)).collect()),
            tool_width_m: WIDTH_M,
            body_radius_m: WIDTH_M / 2.0,
            starts: starts.iter().map(|&(x, y)| Point::new(x, y)).collect(),
        }
    }

    const SQUARE: [(f64, f64); 4] = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)];

    fn made(instance: &PolygonInstance) -> Vec<Vec<Point>> {
        let plan = cover(instance, &McfsOptions::default()).unwrap();
        plan.routes.into_iter().map(|route| route.points).collect()
    }

    fn coverage(instance: &PolygonInstance, lines: &[Vec<Point>]) -> f64 {
        let mut swept = SweptCounts::new(&instance.ground, instance.tool_width_m);
        for pair in lines.iter().flat_map(|line| line.windows(2)) {
            swept.put_in(pair[0], pair[1]);
        }
        swept.coverage()
    }

    /// Every line begins and ends at its start and keeps its distance from all walls.
    fn check_lines(instance: &PolygonInstance, lines: &[Vec<Point>]) {
        let walls: Vec<Segment> = instance
            .rings()
            .flat_map(|(_, ring)| ring.lines())
            .map(|edge| {
                Segment::new(Point::new(edge.start.x, edge.start.y), Point::new(edge.end.x, edge.end.y))
            })
            .collect();
        for (line, start) in lines.iter().zip(&instance.starts) {
            assert!(line.first() == Some(start) && line.last() == Some(start));
            for pair in line.windows(2) {
                let way = Segment::new(pair[0], pair[1]);
                let least_m = walls.iter().map(|wall| wall.distance(&way)).fold(f64::MAX, f64::min);
                assert!(least_m >= instance.body_radius_m - 2e-6, "{least_m} at {way:?}");
            }
        }
    }

    #[test]
    fn a_square_is_swept_in_equal_shares() {
        let square = instance(&SQUARE, &[], &[(0.2, 0.2), (1.8, 1.8), (1.0, 1.0)]);
        let lines = made(&square);
        check_lines(&square, &lines);
        assert!(coverage(&square, &lines) > 0.98, "{}", coverage(&square, &lines));
        let lengths_m: Vec<f64> = lines.iter().map(|line| length_m(line)).collect();
        let mean_m = lengths_m.iter().sum::<f64>() / 3.0;
        assert!(lengths_m.iter().all(|length_m| *length_m < 1.03 * mean_m), "{lengths_m:?}");
        assert!(mean_m < 1.1 * 4.0 / (3.0 * WIDTH_M), "{mean_m}");
    }

    #[test]
    fn same_instance_same_plan() {
        let square = instance(&SQUARE, &[&[(0.8, 0.8), (0.8, 1.2), (1.2, 1.2)]], &[(0.2, 0.2), (1.8, 0.3)]);
        assert_eq!(made(&square), made(&square));
    }

    #[test]
    fn each_robot_more_makes_the_longest_line_shorter() {
        let hole: &[(f64, f64)] = &[(0.8, 0.8), (0.8, 1.2), (1.2, 1.2), (1.2, 0.8)];
        let starts = [(0.2, 0.2), (1.8, 1.8), (0.2, 1.8), (1.8, 0.2), (1.0, 0.2), (1.0, 1.8)];
        let longest_m = |robots: usize| {
            let lines = made(&instance(&SQUARE, &[hole], &starts[..robots]));
            lines.iter().map(|line| length_m(line)).fold(0.0, f64::max)
        };
        let longest_m: Vec<f64> = (1..=6).map(longest_m).collect();
        assert!(longest_m.windows(2).all(|pair| pair[1] < pair[0]), "{longest_m:?}");
        assert!(longest_m[5] < 0.2 * longest_m[0], "{longest_m:?}");
    }

    #[test]
    fn no_line_turns_back_on_the_spot() {
        let square = instance(&SQUARE, &[], &[(0.2, 0.2), (1.8, 1.8), (1.0, 1.0)]);
        for line in made(&square) {
            let steps: Vec<terrain::Vector> =
                line.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| step.norm() > 1e-9).collect();
            let turns = steps.windows(2).map(|pair| joint::turn_rad(pair[0], pair[1]).to_degrees());
            assert!(turns.into_iter().all(|turn| turn < 150.0), "{line:?}");
        }
    }

    /// Two rooms and a door of one and a half tool widths.
    #[test]
    fn a_narrow_door_is_passed() {
        let rooms = [
            (0.0, 0.0),
            (1.0, 0.0),
            (1.0, 0.45),
            (1.1, 0.45),
            (1.1, 0.0),
            (2.0, 0.0),
            (2.0, 1.0),
            (1.1, 1.0),
            (1.1, 0.6),
            (1.0, 0.6),
            (1.0, 1.0),
            (0.0, 1.0),
        ];
        let rooms = instance(&rooms, &[], &[(0.2, 0.2)]);
        let lines = made(&rooms);
        check_lines(&rooms, &lines);
        assert!(coverage(&rooms, &lines) > 0.97, "{}", coverage(&rooms, &lines));
    }

    #[test]
    fn less_ground_takes_less_way() {
        let square = instance(&SQUARE, &[], &[(0.2, 0.2), (1.8, 1.8)]);
        let options = McfsOptions { coverage_target: Some(0.9), ..McfsOptions::default() };
        let plan = cover(&square, &options).unwrap();
        let lines: Vec<Vec<Point>> = plan.routes.into_iter().map(|route| route.points).collect();
        check_lines(&square, &lines);
        let share = coverage(&square, &lines);
        assert!((0.9..0.96).contains(&share), "{share}");
    }

    #[test]
    fn bad_input_is_refused_by_ring_and_corner() {
        let start: &[(f64, f64)] = &[(0.2, 0.2)];
        let inner = [(0.5, 0.5), (0.5, 1.5), (1.5, 1.5), (1.5, 0.5)];
        let with_tool =
            |width_m: f64| PolygonInstance { tool_width_m: width_m, ..instance(&SQUARE, &[], start) };
        let refused = [
            (
                instance(&[(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)], &[], start),
                "the exterior ring meets itself: its edge from corner 0",
            ),
            (
                instance(&SQUARE, &[&[(8.0, 8.0), (9.0, 8.0), (9.0, 9.0)]], start),
                "corner 0 of hole 0 is not inside",
            ),
            (
                instance(&SQUARE, &[&[(0.0, 1.0), (1.0, 1.5), (1.0, 0.5)]], start),
                "hole 0 touches the exterior ring at its edge from corner 0",
            ),
            (
                instance(&SQUARE, &[&inner, &[(0.8, 0.8), (0.8, 1.0), (1.0, 1.0)]], start),
                "hole 1 lies in hole 0",
            ),
            (instance(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)], &[], start), "the exterior ring"),
            (
                instance(&[(0.0, 0.0), (f64::NAN, 0.0), (2.0, 2.0)], &[], start),
                "corner 1 of the exterior ring is not finite",
            ),
            (
                instance(&SQUARE, &[], &[(3.0, 1.0)]),
                "robot 0 starts outside the polygon, beside the exterior ring near corner 1",
            ),
            (
                instance(&SQUARE, &[], &[(1.0, 0.02)]),
                "robot 0 starts 0.020 m from the exterior ring near corner 0",
            ),
            (instance(&SQUARE, &[], &[]), "there is no robot"),
            (with_tool(f64::NAN), "`tool_width_m` is NaN"),
            (
                PolygonInstance { starts: vec![Point::new(1.0, 1.0)], ..with_tool(2.2) },
                "robot 0 starts 1.000 m from",
            ),
        ];
        for (instance, words) in refused {
            let said = cover(&instance, &McfsOptions::default()).unwrap_err().to_string();
            assert!(said.starts_with(words), "{said}");
        }
    }

    fn random_polygons() -> u32 {
        std::env::var("RANDOM_POLYGONS").ok().and_then(|count| count.parse().ok()).unwrap_or(60)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(random_polygons()))]
        /// `RANDOM_POLYGONS=2000 cargo test -p planner random_polygons` for a long run.
        #[test]
        fn random_polygons_are_swept_within_their_walls(
            radii in prop::collection::vec(0.4_f64..1.6, 5..14),
            holes in prop::collection::vec((-0.7_f64..0.7, -0.7_f64..0.7, 0.03_f64..0.25, 0.0_f64..1.5), 0..4),
            starts in prop::collection::vec((-1.0_f64..1.0, -1.0_f64..1.0), 1..6),
        ) {
            let around = |count: usize, at: (f64, f64), radius: &dyn Fn(usize) -> f64, turn: f64| {
                (0..count).map(|number| {
                    let angle = turn + std::f64::consts::TAU * number as f64 / count as f64;
                    (at.0 + radius(number) * angle.cos(), at.1 + radius(number) * angle.sin())
                }).collect::<Vec<_>>()
            };
            let exterior = around(radii.len(), (0.0, 0.0), &|number| radii[number], 0.1);
            let mut polygon = instance(&exterior, &[], &[(0.0, 0.0)]);
            for &(x, y, radius, turn) in &holes {
                let mut more = polygon.clone();
                more.ground.interiors_push(ring(&around(4, (x, y), &|_| radius, turn)));
                more.starts = vec![tracks::tracks(&polygon, WIDTH_M)[0].corners[0]];
                if more.check().is_ok() {
                    polygon = more;
                }
            }
            let fits = |&(x, y): &(f64, f64)| {
                PolygonInstance { starts: vec![Point::new(x, y)], ..polygon.clone() }.check().is_ok()
            };
            let starts: Vec<Point> = starts.iter().filter(|start| fits(start)).map(|&(x, y)| Point::new(x, y)).collect();
            prop_assume!(!starts.is_empty());
            polygon.starts = starts;
            let lines = made(&polygon);
            check_lines(&polygon, &lines);
            let reached = tracks::shrunk(&polygon, WIDTH_M / 2.0, 1e-4);
            if reached.0.len() == 1 {
                let reachable = reached.buffer(WIDTH_M / 2.0).unsigned_area() / polygon.area_m2();
                let share = coverage(&polygon, &lines);
                prop_assert!(share > 0.94 * reachable, "{share} of {reachable}");
            }
        }
    }
}
