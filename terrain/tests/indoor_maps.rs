//! Floors as robots map them: the ROS maps of the instances, tilted, ragged and speckled, are read as they are.

use std::path::{Path, PathBuf};
use terrain::{Floor, GridMap, MapFile};

fn load(name: &str) -> Option<GridMap> {
    let path: PathBuf =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/instances/indoor").join(name);
    if !path.is_file() {
        println!("skipped: {} is not here", path.display());
        return None;
    }
    let how = MapFile { metres_per_character: 1.0, square_m: 0.1 };
    Some(how.load(&path).unwrap_or_else(|error| panic!("{error}")))
}

fn free_m2(map: &GridMap) -> f64 {
    let squares = (0..map.rows()).flat_map(|y| (0..map.columns()).map(move |x| (x, y)));
    let free = squares.filter(|&(x, y)| map.is_free(i64::from(x), i64::from(y))).count();
    free as f64 * map.resolution_m() * map.resolution_m()
}

/// Free areas as in the instances' README; from the centres of a lattice the tool reaches no more than from anywhere,
/// and what it does not reach is told apart.
#[test]
fn the_indoor_maps_have_the_areas_of_their_readme() {
    let maps = [
        ("airport_hall.yaml", 2616.0, 2612.0, 0.25, 0.6),
        ("willow.yaml", 1156.0, 988.0, 0.2, 0.5),
        ("depot.yaml", 426.0, 421.0, 0.25, 0.5),
        ("basement.yaml", 301.0, 289.0, 0.22, 0.5),
        ("small_house.yaml", 158.0, 149.0, 0.17, 0.3),
    ];
    for (name, free, coverable, body_radius_m, tool_width_m) in maps {
        let Some(map) = load(name) else { return };
        assert!((free_m2(&map) - free).abs() < 1.0, "{name}: {} m² free", free_m2(&map));
        let cell_m = tool_width_m / 1.5;
        let floor = Floor::new(&map, cell_m, body_radius_m, tool_width_m).unwrap();
        let (swept, left) = (floor.coverable_m2(), floor.untouchable_m2());
        println!("{name}: {swept:.0} m² from cell centres of {coverable} m², {left:.0} m² left");
        assert!(((swept + left) / free - 1.0).abs() < 0.03, "{name}: {swept} + {left} m²");
        assert!(swept / coverable < 1.02, "{name}: {swept} m²");
    }
}
