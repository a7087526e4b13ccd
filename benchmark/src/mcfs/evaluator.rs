//! Measures paths over a polygon exactly, knowing nothing of how they were made.
//!
//! Every figure is independent of how densely the lines are sampled. The area that a disc sweeps along a line is built
//! as a polygon (pieces of at most [`PIECE_POINTS`] points: a closed line would be taken for a ring and filled), and
//! areas come from exact unions and intersections of polygons. With A the polygon's area, l the tool's width, k
//! robots, L the lengths and c the coverage:
//!
//! | Figure | Definition |
//! |---|---|
//! | makespan | the longest closed line: the way back to its first point counts |
//! | coverage c | area swept within the polygon ÷ A |
//! | overlap | area swept by two or more robots ÷ A |
//! | redundancy | (l·ΣL − c·A) ÷ A |
//! | turning | Σ of the sizes of all turns ÷ ΣL, rad/m |
//! | swept outside | area swept outside the polygon ÷ A |
//! | η | c·A ÷ (k·l·makespan) |

use geo::algorithm::buffer::{BufferStyle, LineCap, LineJoin};
use geo::{
    Area, BooleanOps, Buffer, Coord, Euclidean, Length, LineString, MultiLineString, MultiPolygon, Polygon,
};
use terrain::{Point, angle_between};

/// The most points of a line that are swept at once.
const PIECE_POINTS: usize = 60;
/// Arcs are drawn with chords over this angle: the disc's area is 0.04 % too small.
const ARC_RAD: f64 = 0.05;
/// A turn sharper than this is a reversal.
const REVERSAL_RAD: f64 = 150.0 * std::f64::consts::PI / 180.0;

/// What paths cost, and what they reach.
#[derive(Debug, Clone, PartialEq)]
pub struct PathFigures {
    /// Longest line, closed, metres.
    pub makespan_m: f64,
    /// Sum of the closed lines, metres.
    pub total_m: f64,
    /// Share of the polygon that is swept.
    pub coverage: f64,
    /// Share of the polygon that two or more robots sweep.
    pub overlap: f64,
    /// Way times width beyond the area swept, as a share of the polygon's.
    pub redundancy: f64,
    /// Turning per way, rad/m.
    pub turning_rad_per_m: f64,
    /// Turns of more than 150°.
    pub reversals: usize,
    /// Way outside the polygon, metres.
    pub outside_m: f64,
    /// Area swept outside the polygon, as a share of the polygon's.
    pub swept_outside: f64,
    /// Efficiency η.
    pub efficiency: f64,
}

/// Measures one line per robot.
pub fn evaluate(ground: &Polygon<f64>, tool_width_m: f64, paths: &[Vec<Point>]) -> PathFigures {
    let area_m2 = ground.unsigned_area();
    let (once, twice) = swept_once_and_twice(paths, tool_width_m);
    let covered_m2 = once.intersection(ground).unsigned_area();
    let lengths: Vec<f64> = paths.iter().map(|path| closed_length_m(path)).collect();
    let (makespan_m, total_m) = (lengths.iter().copied().fold(0.0, f64::max), lengths.iter().sum::<f64>());
    let turns: Vec<f64> = paths.iter().flat_map(|path| turns_rad(path)).collect();
    let open_m: f64 = paths.iter().map(|path| length_m(path)).sum();
    let lines = MultiLineString::new(paths.iter().map(|path| line(path)).collect());
    let all = MultiPolygon::new(vec![ground.clone()]);
    PathFigures {
        makespan_m,
        total_m,
        coverage: covered_m2 / area_m2,
        overlap: twice.intersection(ground).unsigned_area() / area_m2,
        redundancy: (tool_width_m * total_m - covered_m2) / area_m2,
        turning_rad_per_m: turns.iter().sum::<f64>() / open_m,
        reversals: turns.iter().filter(|&&turn| turn > REVERSAL_RAD).count(),
        outside_m: Euclidean.length(&all.clip(&lines, true)),
        swept_outside: once.difference(ground).unsigned_area() / area_m2,
        efficiency: covered_m2 / (paths.len() as f64 * tool_width_m * makespan_m),
    }
}

fn swept_once_and_twice(paths: &[Vec<Point>], tool_width_m: f64) -> (MultiPolygon<f64>, MultiPolygon<f64>) {
    let (mut once, mut twice) = (MultiPolygon::new(Vec::new()), MultiPolygon::new(Vec::new()));
    for path in paths {
        let swept = swept(path, tool_width_m);
        twice = twice.union(&once.intersection(&swept));
        once = once.union(&swept);
    }
    (once, twice)
}

/// What the tool's disc sweeps along a line.
fn swept(path: &[Point], tool_width_m: f64) -> MultiPolygon<f64> {
    let style = BufferStyle::new(tool_width_m / 2.0)
        .line_cap(LineCap::Round(ARC_RAD))
        .line_join(LineJoin::Round(ARC_RAD));
    let pieces = path.chunks(PIECE_POINTS - 1).enumerate().map(|(number, piece)| {
        let next = path.get((number + 1) * (PIECE_POINTS - 1));
        line(&[piece, next.map(std::slice::from_ref).unwrap_or_default()].concat())
    });
    let strokes: Vec<_> = pieces.map(|piece| piece.buffer_with_style(style.clone())).collect();
    geo::unary_union(&strokes)
}

fn line(path: &[Point]) -> LineString<f64> {
    path.iter().map(|point| Coord { x: point.x, y: point.y }).collect()
}

fn length_m(path: &[Point]) -> f64 {
    path.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

fn closed_length_m(path: &[Point]) -> f64 {
    let back_m = path.first().zip(path.last()).map_or(0.0, |(first, last)| (first - last).norm());
    length_m(path) + back_m
}

/// The sizes of the turns along a line.
fn turns_rad(path: &[Point]) -> Vec<f64> {
    let steps = path.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| step.norm() > 1e-9);
    let headings: Vec<f64> = steps.map(|step| step.y.atan2(step.x)).collect();
    headings.windows(2).map(|pair| angle_between(pair[0], pair[1]).abs()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mcfs::polygon_instances::{NAMES, load, stored_paths};
    use geo::Contains;
    use serde::Deserialize;
    use std::path::PathBuf;

    #[derive(Deserialize)]
    struct Measured {
        instance: String,
        method: String,
        makespan_closed: f64,
        coverage_exact: f64,
        overlap_two_robots_exact: f64,
        turning_per_length: f64,
        turns_over_150deg: usize,
        path_outside_length: f64,
        swept_outside_area: f64,
    }

    fn instances() -> Option<PathBuf> {
        let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/instances");
        folder.join("mcfs").is_dir().then_some(folder)
    }

    #[test]
    fn a_straight_line_sweeps_a_rectangle_with_round_ends() {
        let corners = vec![(0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (0.0, 2.0)];
        let ground = Polygon::new(LineString::from(corners), Vec::new());
        let path = vec![Point::new(1.0, 1.0), Point::new(3.0, 1.0)];
        let seen = evaluate(&ground, 1.0, &[path.clone(), path]);
        let swept_m2 = 2.0 + std::f64::consts::PI / 4.0;
        assert!((seen.coverage - swept_m2 / 8.0).abs() < 1e-4, "{seen:?}");
        assert!((seen.overlap - seen.coverage).abs() < 1e-6, "{seen:?}");
        assert!((seen.makespan_m - 4.0).abs() < 1e-9 && seen.swept_outside < 1e-9, "{seen:?}");
    }

    /// The paths that the authors stored, against an independent program.
    #[test]
    fn stored_paths_measure_as_published() {
        let Some(folder) = instances() else {
            println!("skipped: ../shared/instances is not there");
            return;
        };
        let path = folder.join("mcfs/measured.csv");
        let text = std::fs::read_to_string(path).unwrap();
        let text: String = text.lines().filter(|line| !line.starts_with('#')).collect::<Vec<_>>().join("\n");
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let measured: Vec<Measured> = reader.deserialize().map(Result::unwrap).collect();
        let stored: Vec<_> = measured.iter().filter(|row| row.method == "MCFS-BOTH (stored)").collect();
        assert_eq!(stored.len(), NAMES.len());
        for row in stored {
            let ground = load(&folder, &row.instance).unwrap();
            let paths = stored_paths(&folder, &row.instance).unwrap();
            let seen = evaluate(&ground.ground, ground.tool_width_m, &paths);
            let near = |seen: f64, expected: f64, tolerance: f64| (seen - expected).abs() <= tolerance;
            // The office path that does not return is closed straight across in one and not in the other.
            let makespan = near(seen.makespan_m, row.makespan_closed, 0.01) || row.instance == "office";
            assert!(makespan, "{} {seen:?}", row.instance);
            assert!(near(seen.coverage, row.coverage_exact, 2e-3), "{} {seen:?}", row.instance);
            assert!(near(seen.overlap, row.overlap_two_robots_exact, 2e-3), "{} {seen:?}", row.instance);
            assert!(near(seen.turning_rad_per_m, row.turning_per_length, 2e-3), "{} {seen:?}", row.instance);
            assert!(near(seen.outside_m, row.path_outside_length, 1e-2), "{} {seen:?}", row.instance);
            assert!(near(seen.swept_outside, row.swept_outside_area, 1e-3), "{} {seen:?}", row.instance);
            assert_eq!(seen.reversals, row.turns_over_150deg, "{} {seen:?}", row.instance);
        }
    }

    /// The exact area against a count of 5 mm pixels.
    #[test]
    fn exact_coverage_agrees_with_a_pixel_count() {
        let Some(folder) = instances() else {
            println!("skipped: ../shared/instances is not there");
            return;
        };
        let instance = load(&folder, "P").unwrap();
        let paths = stored_paths(&folder, "P").unwrap();
        let (mut inside, mut swept) = (0_u32, 0_u32);
        let segments: Vec<terrain::Segment> = paths
            .iter()
            .flat_map(|path| path.windows(2).map(|pair| terrain::Segment::new(pair[0], pair[1])))
            .collect();
        for (x, y) in (-300..300).flat_map(|x| (-500..500).map(move |y| (x, y))) {
            let point = Point::new(f64::from(x) * 0.01, f64::from(y) * 0.01);
            if instance.ground.contains(&Coord { x: point.x, y: point.y }) {
                inside += 1;
                let near = |segment: &terrain::Segment| segment.distance_to_point(point) <= 0.05;
                swept += u32::from(segments.iter().any(near));
            }
        }
        let counted = f64::from(swept) / f64::from(inside);
        let exact = evaluate(&instance.ground, instance.tool_width_m, &paths).coverage;
        assert!((counted - exact).abs() < 2e-3, "{counted} counted, {exact} exact");
        assert!((f64::from(inside) * 1e-4 / instance.area_m2() - 1.0).abs() < 2e-3);
    }
}
