//! What must hold of any plan on isolines.

use super::*;
use geo::{Coord, LineString, Polygon};
use proptest::prelude::*;

const TOOL_M: f64 = 0.1;

fn ring(corners: &[[f64; 2]]) -> LineString<f64> {
    LineString::from(corners.to_vec())
}

fn instance(exterior: &[[f64; 2]], holes: &[&[[f64; 2]]], starts: &[[f64; 2]]) -> PolygonInstance {
    PolygonInstance {
        ground: Polygon::new(ring(exterior), holes.iter().map(|hole| ring(hole)).collect()),
        tool_width_m: TOOL_M,
        body_radius_m: TOOL_M / 2.0,
        starts: starts.iter().map(|&start| Point::from(start)).collect(),
    }
}

fn room_with_pillar() -> PolygonInstance {
    instance(
        &[[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]],
        &[&[[1.5, 1.0], [2.1, 1.0], [2.1, 1.8], [1.5, 1.8]]],
        &[[0.2, 0.2], [3.8, 2.8], [0.3, 2.7]],
    )
}

/// Two rooms and a door that is wide enough for the tool, but not for an isoline a tool off the walls.
fn rooms_with_narrow_door() -> PolygonInstance {
    instance(
        &[
            [0.0, 0.0],
            [2.0, 0.0],
            [2.0, 0.93],
            [2.1, 0.93],
            [2.1, 0.0],
            [4.0, 0.0],
            [4.0, 2.0],
            [2.1, 2.0],
            [2.1, 1.07],
            [2.0, 1.07],
            [2.0, 2.0],
            [0.0, 2.0],
        ],
        &[],
        &[[0.2, 0.2], [0.4, 1.0]],
    )
}

fn length_m(path: &[Point]) -> f64 {
    path.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

fn makespan_m(spirals: &Spirals) -> f64 {
    spirals.paths.iter().map(|path| length_m(path)).fold(0.0, f64::max)
}

/// Each station of each isoline lies on some path; no path comes nearer to a wall than it may.
fn stands(instance: &PolygonInstance, options: &SpiralOptions, spirals: &Spirals) -> Result<(), String> {
    let walls = Walls::new(&rings(instance));
    let lines = isolines_of(instance, &walls, options.isolines);
    let mut reached: Vec<[i64; 2]> = spirals.paths.iter().flatten().map(|&point| rounded(point)).collect();
    reached.sort_unstable();
    let stations = lines.iter().flat_map(|line| &line.stations);
    let missed = stations.filter(|station| reached.binary_search(&rounded(station.point)).is_err()).count();
    if missed > 0 && spirals.left_out_m <= 0.0 {
        return Err(format!("{missed} stations are missed"));
    }
    for trip in spirals.round_trips() {
        for pair in trip.windows(2) {
            if !walls.keeps_clear(Segment::new(pair[0], pair[1]), 0.98 * instance.clearance_m()) {
                return Err(format!("{pair:?} comes too near to a wall"));
            }
        }
    }
    Ok(())
}

/// Micrometres, to find equal points by.
fn rounded(point: Point) -> [i64; 2] {
    [point.x, point.y].map(|x| (x * 1e6).round() as i64)
}

fn options(isolines: Isolines, hops_max: u32, refine: bool) -> SpiralOptions {
    SpiralOptions { isolines, hops_max, refine, tree_cover: TreeCover::Exact, ..SpiralOptions::default() }
}

#[test]
fn every_variant_covers_every_isoline_and_keeps_off_the_walls() {
    for isolines in [Isolines::MarchingSquares, Isolines::Exact] {
        for (hops_max, refine) in [(1, false), (1, true), (3, false), (3, true)] {
            let options = options(isolines, hops_max, refine);
            let spirals = plan_spirals(&room_with_pillar(), &options).unwrap();
            assert!(spirals.left_out_m <= 0.0);
            stands(&room_with_pillar(), &options, &spirals).unwrap();
        }
    }
}

#[test]
fn augmentation_and_refinement_shorten_the_longest_path() {
    let by = |hops_max, refine| {
        makespan_m(
            &plan_spirals(&room_with_pillar(), &options(Isolines::MarchingSquares, hops_max, refine))
                .unwrap(),
        )
    };
    let (none, augmented, refined, both) = (by(1, false), by(3, false), by(1, true), by(3, true));
    assert!(augmented <= none + 1e-6 && refined <= none + 1e-6, "{none} {augmented} {refined}");
    assert!(both <= augmented + 1e-6 && both < 0.8 * none, "{none} {augmented} {both}");
}

#[test]
fn rooms_behind_a_narrow_door_are_reached_by_a_bridge() {
    for isolines in [Isolines::MarchingSquares, Isolines::Exact] {
        let options = options(isolines, 2, true);
        let spirals = plan_spirals(&rooms_with_narrow_door(), &options).unwrap();
        assert!(spirals.left_out_m <= 0.0);
        stands(&rooms_with_narrow_door(), &options, &spirals).unwrap();
    }
}

#[test]
fn the_exact_cover_is_a_lower_bound_of_the_search() {
    let exact = plan_spirals(&room_with_pillar(), &options(Isolines::MarchingSquares, 3, false)).unwrap();
    let searched =
        SpiralOptions { tree_cover: TreeCover::Search, ..options(Isolines::MarchingSquares, 3, false) };
    let searched = plan_spirals(&room_with_pillar(), &searched).unwrap();
    assert!(exact.size[0] <= tree_exact::VERTICES_MAX, "{:?}", exact.size);
    assert!((exact.trees_m - exact.trees_bound_m).abs() < 1e-9);
    assert!(searched.trees_m >= exact.trees_m - 1e-9);
}

#[test]
fn same_seed_same_paths() {
    let chosen = SpiralOptions { selector: Selector::Random, ..SpiralOptions::default() };
    assert_eq!(plan_spirals(&room_with_pillar(), &chosen), plan_spirals(&room_with_pillar(), &chosen));
}

#[test]
fn what_cannot_be_planned_is_said() {
    let narrow = instance(&[[0.0, 0.0], [3.0, 0.0], [3.0, 0.15], [0.0, 0.15]], &[], &[[0.1, 0.075]]);
    let refused = plan_spirals(&narrow, &SpiralOptions::default()).unwrap_err();
    assert!(refused.to_string().contains("take a narrower tool"), "{refused}");
    let outside = instance(&[[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]], &[], &[[5.0, 1.0]]);
    assert!(matches!(
        plan_spirals(&outside, &SpiralOptions::default()),
        Err(SpiralError::Polygon(PolygonError::StartOutside { robot: 0, .. }))
    ));
}

/// A star with up to two square holes.
fn star(radii: &[f64], holes: &[(f64, f64)]) -> PolygonInstance {
    let corner = |(index, &radius): (usize, &f64)| {
        let angle = index as f64 / radii.len() as f64 * std::f64::consts::TAU;
        Coord { x: radius * angle.cos(), y: radius * angle.sin() }
    };
    let hole = |&(x, y): &(f64, f64)| ring(&[[x, y], [x, y + 0.2], [x + 0.2, y + 0.2], [x + 0.2, y]]);
    PolygonInstance {
        ground: Polygon::new(
            radii.iter().enumerate().map(corner).collect(),
            holes.iter().map(hole).collect(),
        ),
        tool_width_m: TOOL_M,
        body_radius_m: TOOL_M / 2.0,
        starts: vec![Point::new(0.0, 0.0), Point::new(0.15, 0.0), Point::new(-0.1, 0.1)],
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]
    #[test]
    fn any_star_with_holes_is_covered(
        radii in prop::collection::vec(0.7_f64..2.0, 5..14),
        holes in prop::collection::vec((0.25_f64..0.35, -0.35_f64..0.1), 0..2),
        hops_max in 1_u32..4,
        refine in any::<bool>(),
        is_exact in any::<bool>(),
        robots in 1_usize..4,
    ) {
        let mut instance = star(&radii, &holes);
        instance.starts.truncate(robots);
        prop_assume!(instance.check().is_ok());
        let isolines = if is_exact { Isolines::Exact } else { Isolines::MarchingSquares };
        let options = options(isolines, hops_max, refine);
        match plan_spirals(&instance, &options) {
            Ok(spirals) => prop_assert_eq!(stands(&instance, &options, &spirals), Ok(())),
            Err(error) => prop_assert!(matches!(error, SpiralError::CutOff { .. }), "{}", error),
        }
    }
}
