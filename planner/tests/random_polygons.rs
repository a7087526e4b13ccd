//! No planner's way crosses a hole or a wall of a random polygon: judged by the polygon itself, not by the map that it
//! was laid out on.

use geo::{Coord, LineString, LinesIter, MultiPolygon, Polygon};
use planner::{Instance, Mode, PLANNERS, PlanError, PlanOptions, Start, VerifiedPlan, plan};
use proptest::prelude::*;
use terrain::{Floor, MotionModel, Point, Polygons, Segment};

const TOOL_M: f64 = 0.5;
const BODY_M: f64 = 0.2;
const CELL_M: f64 = 0.35;
const SQUARE_M: f64 = 0.05;
/// As much as verify leaves to rounding, metres.
const ROUNDING_M: f64 = 1e-5;
const MOTION: MotionModel = MotionModel {
    speed_m_per_s: 0.5,
    acceleration_m_per_s2: 0.5,
    angular_speed_rad_per_s: 1.0,
    angular_acceleration_rad_per_s2: 2.0,
    brakes: true,
};

fn ring(corners: usize, [x, y]: [f64; 2], radius_m: impl Fn(usize) -> f64, turn_rad: f64) -> LineString<f64> {
    let corner = |number: usize| {
        let angle = turn_rad + std::f64::consts::TAU * number as f64 / corners as f64;
        Coord { x: x + radius_m(number) * angle.cos(), y: y + radius_m(number) * angle.sin() }
    };
    (0..corners).map(corner).collect()
}

/// A star-shaped room with those of the holes that fit into it.
fn room(radii_m: &[f64], holes: &[([f64; 2], f64, f64, usize)]) -> Option<Polygons> {
    let checked = |polygon: &Polygon<f64>| Polygons::new(MultiPolygon::new(vec![polygon.clone()])).ok();
    let mut polygon =
        Polygon::new(ring(radii_m.len(), [0.0, 0.0], |number| radii_m[number], 0.1), Vec::new());
    let mut room = checked(&polygon)?;
    for &(at, radius_m, turn_rad, corners) in holes {
        let mut more = polygon.clone();
        more.interiors_push(ring(corners, at, |_| radius_m, turn_rad));
        if let Some(sound) = checked(&more) {
            (polygon, room) = (more, sound);
        }
    }
    Some(room)
}

/// The first piece of a line that comes nearer to a wall than the body's radius.
fn first_too_near(room: &Polygons, points: &[Point]) -> Option<(Segment, f64)> {
    let point = |at: Coord<f64>| Point::new(at.x, at.y);
    let walls: Vec<Segment> =
        room.geometry().lines_iter().map(|edge| Segment::new(point(edge.start), point(edge.end))).collect();
    let pieces = points.windows(2).map(|pair| Segment::new(pair[0], pair[1]));
    pieces
        .map(|piece| {
            let nearest_m = walls.iter().map(|wall| wall.distance(&piece)).fold(f64::INFINITY, f64::min);
            (piece, nearest_m)
        })
        .find(|(_, nearest_m)| *nearest_m < BODY_M - ROUNDING_M)
}

fn random_polygons() -> ProptestConfig {
    let asked = std::env::var("RANDOM_POLYGONS").ok().and_then(|count| count.parse().ok());
    ProptestConfig { cases: asked.unwrap_or(6), max_shrink_iters: 200, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(random_polygons())]
    /// `RANDOM_POLYGONS=2000 cargo test --release -p planner --test random_polygons` for a long run.
    #[test]
    fn no_way_crosses_a_hole_or_a_wall(
        radii_m in prop::collection::vec(1.2_f64..5.0, 5..14),
        holes in prop::collection::vec(
            (prop::array::uniform2(-3.0_f64..3.0), 0.1_f64..0.9, 0.0_f64..1.5, 3_usize..7), 0..5),
        robots in prop::collection::vec(any::<prop::sample::Index>(), 1..4),
        comes_back in any::<bool>(),
    ) {
        let Some(room) = room(&radii_m, &holes) else { return Err(TestCaseError::reject("no sound ring")) };
        let map = room.rasterise(SQUARE_M).unwrap();
        let Ok(floor) = Floor::new(&map, CELL_M, BODY_M, TOOL_M) else {
            return Err(TestCaseError::reject("no room for the body"));
        };
        let cells: Vec<_> = floor.lattice().cells().filter(|&cell| floor.cell_is_drivable(cell)).collect();
        let starts = robots.iter().map(|index| Start::at(*index.get(&cells))).collect();
        let mode = if comes_back { Mode::CoverAndReturn } else { Mode::Cover };
        let instance = Instance::whole_floor(&floor, starts, MOTION, mode);
        for planner in PLANNERS {
            let options = PlanOptions { planner: planner.name.to_owned(), ..PlanOptions::default() };
            let planned = match plan(&instance, &options) {
                Err(PlanError::Unsupported { .. }) if ["darp", "mcfs"].contains(&planner.name) => continue,
                planned => planned,
            };
            prop_assert!(planned.is_ok(), "{}: {:?}", planner.name, planned);
            for route in planned.iter().flat_map(VerifiedPlan::routes) {
                let near = first_too_near(&room, &route.points);
                prop_assert!(near.is_none(), "{}: {near:?}", planner.name);
            }
        }
    }
}

#[test]
fn a_way_through_a_hole_is_seen() {
    let room = room(&[4.0; 8], &[([0.0, 0.0], 0.5, 0.0, 4)]).unwrap();
    let through = [Point::new(-2.0, 0.1), Point::new(2.0, 0.1)];
    assert!(first_too_near(&room, &through).is_some());
    let beside = [Point::new(-2.0, 0.75), Point::new(2.0, 0.75)];
    assert!(first_too_near(&room, &beside).is_none());
}
