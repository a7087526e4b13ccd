//! `mcfs` on a floor with a map: its free ground as polygons, covered by smooth lines.
//!
//! The polygons are those of [`crate::mcfs`]. What the lines leave (passages narrower than the tool, corners) gets lanes,
//! dealt out among the robots. Where part of the ground is swept or left out, lanes are all of the plan: closed lines
//! over ground that is all rims take longer.

use super::boustrophedon_lanes;
use super::mcfs_rest::with_rest;
use crate::isograph::{SpiralError, SpiralOptions, plan_spirals};
use crate::mcfs::{PolygonInstance, cover_ground, straightened};
use crate::{Instance, Mode, Plan, PlanError, PlanOptions, Route};
use geo::{BooleanOps, Contains, Coord, MultiPolygon, Polygon, Rect};
use terrain::{GridMap, Point};

/// Depth of the stairs that are taken for a slanted wall, squares of the map.
const STAIRS_SQUARES: f64 = 1.0;

pub(crate) fn plan(instance: &Instance<'_>, options: &PlanOptions) -> Result<Plan, PlanError> {
    let refused = |reason: &str| PlanError::Unsupported { planner: "mcfs", reason: reason.to_owned() };
    let map =
        instance.floor.map().ok_or_else(|| refused("the floor has no map whose walls can be followed"))?;
    if instance.weights.is_some() {
        return Err(refused("ground of different speeds is not known to smooth lines"));
    }
    if !is_whole(instance) {
        if options.mcfs.paper.is_some() {
            return Err(refused("the paper's pipeline covers whole floors only; leave its options out"));
        }
        return boustrophedon_lanes::plan(instance, options);
    }
    let places: Vec<Point> = instance.starts.iter().map(|start| instance.place(start)).collect();
    let mut routes: Vec<Route> = places.iter().map(|&place| Route::new(vec![place])).collect();
    for part in open_ground(instance, map) {
        let part = with_straight_walls(part, map, &places);
        cover_part(instance, part, &places, options, &mut routes)?;
    }
    if instance.mode == Mode::Cover {
        // No need to come back: what this leaves gets lanes below.
        routes.iter_mut().filter(|route| route.points.len() > 2).for_each(|route| {
            route.points.pop();
        });
    }
    with_rest(instance, options, routes)
}

/// Whether all that robots can reach is to be swept.
fn is_whole(instance: &Instance<'_>) -> bool {
    instance.visit == instance.reachable() && instance.swept.iter().all(|&samples| samples == 0)
}

/// The stairs of slanted walls cost turns; they stay where a robot stands among them.
fn with_straight_walls(part: Polygon<f64>, map: &GridMap, places: &[Point]) -> Polygon<f64> {
    let straight = straightened(&part, STAIRS_SQUARES * map.resolution_m());
    let stands_in = |ground: &Polygon<f64>, place: &Point| ground.contains(&Coord { x: place.x, y: place.y });
    let loses_nobody = places.iter().all(|place| stands_in(&straight, place) || !stands_in(&part, place));
    if loses_nobody { straight } else { part }
}

fn cover_part(
    instance: &Instance<'_>,
    part: Polygon<f64>,
    places: &[Point],
    options: &PlanOptions,
    routes: &mut [Route],
) -> Result<(), PlanError> {
    let stands = |&robot: &usize| part.contains(&Coord { x: places[robot].x, y: places[robot].y });
    let robots: Vec<usize> = (0..places.len()).filter(stands).collect();
    let polygon = PolygonInstance {
        ground: part,
        tool_width_m: instance.floor.tool_width_m(),
        body_radius_m: instance.floor.body_radius_m(),
        starts: robots.iter().map(|&robot| places[robot]).collect(),
    };
    if robots.is_empty() {
        return Ok(());
    }
    for (robot, line) in robots.into_iter().zip(lines(&polygon, options)?) {
        routes[robot].points = line;
    }
    Ok(())
}

/// One closed line per robot: by our pipeline, or by the paper's where that was asked for.
fn lines(polygon: &PolygonInstance, options: &PlanOptions) -> Result<Vec<Vec<Point>>, PlanError> {
    let Some(paper) = &options.mcfs.paper else { return Ok(cover_ground(polygon, &options.mcfs)) };
    let chosen = SpiralOptions { effort: options.effort, seed: options.seed, ..paper.clone() };
    let spirals = plan_spirals(polygon, &chosen);
    let refused = |error: SpiralError| PlanError::Unsupported { planner: "mcfs", reason: error.to_string() };
    spirals.map(|spirals| spirals.round_trips()).map_err(refused)
}

/// The free squares of the map that lie in no blocked cell, as polygons.
fn open_ground(instance: &Instance<'_>, map: &GridMap) -> MultiPolygon<f64> {
    let square_m = map.resolution_m();
    let rows = (0..i64::from(map.rows())).flat_map(|y| runs(map, y).into_iter().map(move |run| (y, run)));
    let corner = |x: i64, y: i64| Coord {
        x: map.origin().x + x as f64 * square_m,
        y: map.origin().y + y as f64 * square_m,
    };
    let free: Vec<Polygon<f64>> =
        rows.map(|(y, (from, to))| Rect::new(corner(from, y), corner(to, y + 1)).to_polygon()).collect();
    let lattice = instance.floor.lattice();
    let half = lattice.cell_m / 2.0;
    let blocked = (0..lattice.len()).filter(|&index| instance.blocked[index]).map(|index| {
        let center = lattice.center(lattice.cell(index));
        let at = |x: f64, y: f64| Coord { x: center.x + x * half, y: center.y + y * half };
        Rect::new(at(-1.0, -1.0), at(1.0, 1.0)).to_polygon()
    });
    let blocked: Vec<Polygon<f64>> = blocked.collect();
    let open = geo::unary_union(&free);
    if blocked.is_empty() { open } else { open.difference(&geo::unary_union(&blocked)) }
}

/// The runs of free squares in a row: from the first one up to the one after the last.
fn runs(map: &GridMap, y: i64) -> Vec<(i64, i64)> {
    let mut runs: Vec<(i64, i64)> = Vec::new();
    for x in (0..i64::from(map.columns())).filter(|&x| map.is_free(x, y)) {
        match runs.last_mut() {
            Some((_, to)) if *to == x => *to += 1,
            _ => runs.push((x, x + 1)),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_motion::MOTION;
    use crate::{EdgeWeights, PlanError, Start, plan as planned};
    use proptest::prelude::*;
    use terrain::{Cell, Floor, Segment, SweptRaster};

    /// Two rooms with a pillar, a door, and a corridor that only the body fits into.
    const ROOMS: &str = "\
        ....................\n\
        ....................\n\
        ..........#.........\n\
        ....##....#.........\n\
        ....##....#.........\n\
        ..........#.........\n\
        ..........#########.\n\
        ..........#########.\n\
        ....................";

    fn floor(body_radius_m: f64) -> Floor {
        let map = GridMap::from_drawing(ROOMS, 0.5).unwrap();
        Floor::new(&map, 0.5, body_radius_m, 0.75).unwrap()
    }

    fn options() -> PlanOptions {
        PlanOptions { planner: "mcfs".to_owned(), ..PlanOptions::default() }
    }

    fn instance(floor: &Floor, mode: Mode) -> Instance<'_> {
        let cells: Vec<Cell> = floor.lattice().cells().filter(|&cell| floor.cell_is_drivable(cell)).collect();
        let starts = [cells[0], cells[cells.len() / 2]].map(Start::at).to_vec();
        Instance::whole_floor(floor, starts, MOTION, mode)
    }

    #[test]
    fn a_floor_with_narrow_ways_is_swept_whole() {
        for body_radius_m in [0.2, 0.24] {
            let floor = floor(body_radius_m);
            for mode in [Mode::Cover, Mode::CoverAndReturn] {
                let made = planned(&instance(&floor, mode), &options()).unwrap();
                assert!(made.figures().coverage_ratio >= 0.99, "{:?}", made.figures());
            }
        }
    }

    #[test]
    fn blocked_cells_are_driven_around() {
        let floor = floor(0.2);
        let mut instance = instance(&floor, Mode::CoverAndReturn);
        let index = floor.lattice().index(Cell::new(2, 5)).unwrap();
        instance.blocked[index] = true;
        instance.visit = instance.reachable();
        let made = planned(&instance, &options()).unwrap();
        assert!(made.figures().coverage_ratio >= 0.99, "{:?}", made.figures());
    }

    /// What a disc of the tool's width sweeps along a line of points.
    fn swept(floor: &Floor, line: &[(f64, f64)]) -> Vec<u64> {
        let mut raster = SweptRaster::new(*floor.lattice());
        for pair in line.windows(2) {
            let [from, to] = [pair[0], pair[1]].map(|(x, y)| Point::new(x, y));
            raster.sweep(Segment::new(from, to), floor.tool_width_m() / 2.0, |_| {});
        }
        (0..floor.lattice().len()).map(|index| raster.samples(index)).collect()
    }

    /// The cells to visit are those that lack something.
    fn with_swept<'a>(instance: &Instance<'a>, swept: Vec<u64>) -> Instance<'a> {
        let mut left = Instance { swept, ..instance.clone() };
        left.visit =
            (0..left.visit.len()).map(|index| left.visit[index] && left.wanted(index) != 0).collect();
        left
    }

    #[test]
    fn what_is_left_is_swept_from_where_robots_stand() {
        let floor = floor(0.2);
        let done = [(0.4, 0.4), (4.0, 0.4), (4.0, 1.0), (0.4, 1.0), (0.4, 1.6), (1.6, 1.6), (1.6, 3.0)];
        for mode in [Mode::Cover, Mode::CoverAndReturn] {
            let mut left = with_swept(&instance(&floor, mode), swept(&floor, &done));
            left.starts[0].point = Some(Point::new(0.33, 0.21));
            let made = planned(&left, &options()).unwrap();
            assert_eq!(made.planner(), "mcfs");
            assert!(made.figures().coverage_ratio >= 0.99, "{:?}", made.figures());
            let whole = planned(&instance(&floor, mode), &options()).unwrap();
            assert!(made.figures().makespan_s < whole.figures().makespan_s, "{:?}", made.figures());
        }
    }

    #[test]
    fn some_of_the_ground_may_be_left_out() {
        let floor = floor(0.2);
        let mut instance = instance(&floor, Mode::Cover);
        let lattice = floor.lattice();
        for cell in lattice.cells().filter(|cell| (cell.x + 2 * cell.y) % 5 != 0) {
            instance.visit[lattice.index(cell).unwrap()] = false;
        }
        let made = planned(&instance, &options()).unwrap();
        assert!(made.planner() == "mcfs" && made.figures().coverage_ratio >= 0.99, "{:?}", made.figures());
    }

    #[test]
    fn what_it_cannot_do_is_said() {
        let floor = floor(0.2);
        let mut weighted = instance(&floor, Mode::Cover);
        let ones = vec![1.0; floor.lattice().len()];
        weighted.weights = Some(EdgeWeights { right: ones.clone(), up: ones });
        let drawn = Floor::from_cells(*floor.lattice(), &vec![true; floor.lattice().len()], 0.2, 0.75);
        for instance in [weighted, instance(&drawn, Mode::Cover)] {
            let refused = planned(&instance, &options());
            assert!(matches!(refused, Err(PlanError::Unsupported { planner: "mcfs", .. })), "{refused:?}");
        }
        let mut in_part = instance(&floor, Mode::Cover);
        let first = in_part.visit.iter().position(|&visit| visit).unwrap();
        in_part.visit[first] = false;
        let paper = crate::mcfs::McfsOptions { paper: Some(SpiralOptions::default()), ..Default::default() };
        let refused = planned(&in_part, &PlanOptions { mcfs: paper, ..options() });
        assert!(matches!(refused, Err(PlanError::Unsupported { planner: "mcfs", .. })), "{refused:?}");
    }

    fn random_remainders() -> ProptestConfig {
        let asked = std::env::var("RANDOM_REMAINDERS").ok().and_then(|count| count.parse().ok());
        ProptestConfig { cases: asked.unwrap_or(40), max_shrink_iters: 300, ..ProptestConfig::default() }
    }

    proptest! {
        #![proptest_config(random_remainders())]
        /// `RANDOM_REMAINDERS=1000 cargo test --release -p planner left_of_random_floors` for a long run.
        #[test]
        fn what_is_left_of_random_floors_is_swept(
            free in prop::collection::vec(prop::bool::weighted(0.93), 16 * 12),
            done in prop::collection::vec((0.0_f64..8.0, 0.0_f64..6.0), 0..12),
            wanted in prop::collection::vec(prop::bool::weighted(0.9), 16 * 12),
            blocked in prop::collection::vec(prop::bool::weighted(0.03), 16 * 12),
            starts in prop::collection::vec((0..16 * 12_usize, -0.1_f64..0.1, -0.1_f64..0.1), 1..5),
            body_radius_m in 0.15_f64..0.33,
            is_whole in any::<bool>(),
            comes_back in any::<bool>(),
        ) {
            let rows: Vec<String> =
                free.chunks(16).map(|row| row.iter().map(|&free| if free { '.' } else { '#' }).collect()).collect();
            let floor = Floor::new(&GridMap::from_drawing(&rows.join("\n"), 0.5).unwrap(), 0.5, body_radius_m, 0.6);
            prop_assume!(floor.is_ok());
            let floor = floor.unwrap();
            let lattice = *floor.lattice();
            let stands: Vec<Cell> = lattice.cells().filter(|&cell| floor.cell_is_drivable(cell)).collect();
            let start = |&(number, dx, dy): &(usize, f64, f64)| {
                let cell = stands[number % stands.len()];
                let centre = lattice.center(cell);
                let point = centre + terrain::Vector::new(dx, dy);
                let fits = floor.segment_is_free(Segment::new(point, centre));
                Start { point: fits.then_some(point), ..Start::at(cell) }
            };
            let starts: Vec<Start> = starts.iter().take(stands.len()).map(start).collect();
            let mode = if comes_back { Mode::CoverAndReturn } else { Mode::Cover };
            let mut instance = Instance::whole_floor(&floor, starts, MOTION, mode);
            instance.blocked = blocked;
            let open = instance.with_open_starts().reachable();
            instance.visit = (0..open.len()).map(|index| open[index] && (is_whole || wanted[index])).collect();
            let left = if is_whole { instance } else { with_swept(&instance, swept(&floor, &done)) };
            prop_assume!(left.visit.contains(&true));
            let made = planned(&left, &options());
            prop_assert!(made.as_ref().is_ok_and(|made| made.figures().coverage_ratio >= 0.99), "{made:?}");
        }
    }
}
