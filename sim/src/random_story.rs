//! Random stories: a small floor, a few robots, and faults, all drawn from one number. Swarm style: each story
//! leaves out a random half of the kinds, so that the others come in thicker.

use crate::{
    faults::{Fault, FaultEntry},
    random_streams::stream,
    scenario::{FleetTable, Scenario, ScenarioFile, StationEntry},
};
use rand::{RngExt, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeSet;
use std::sync::Arc;
use terrain::{Cell, GridMap};

/// Size of the floors, characters of 1 m: 2 × 2 cells each.
const COLUMNS: usize = 10;
const ROWS: usize = 7;
/// Faults come in the first part of the story; then they stop, and the area must be finished.
const FAULTS_UNTIL_S: f64 = 60.0;

/// The story of this number.
pub fn random_story(seed: u64) -> Arc<Scenario> {
    let mut scenario = floor_and_fleet(seed);
    scenario.file.faults = random_faults(seed, &scenario);
    Arc::new(scenario)
}

/// Two to six faults for a scenario, drawn from `seed`; each from a stream of its own, so that leaving one out
/// does not change the others.
pub fn random_faults(seed: u64, scenario: &Scenario) -> Vec<FaultEntry> {
    let mut rng = stream(seed, "story", "faults");
    let mut kinds: Vec<&str> = Fault::KINDS.to_vec();
    kinds.retain(|&kind| kind != "station_out_of_order" || !scenario.file.stations.is_empty());
    kinds.shuffle(&mut rng);
    kinds.truncate(kinds.len().div_ceil(2));
    let count = rng.random_range(2..=6);
    (0..count).map(|number| random_fault(seed, number, &kinds, scenario)).collect()
}

fn random_fault(seed: u64, number: u32, kinds: &[&str], scenario: &Scenario) -> FaultEntry {
    let mut rng = stream(seed, "fault", &number.to_string());
    let kind = kinds[rng.random_range(0..kinds.len())];
    let at_s = (rng.random_range(0.0..FAULTS_UNTIL_S) * 10.0).round() / 10.0;
    let fault = Fault::random(kind, &mut rng, scenario);
    FaultEntry { at_s: Some(at_s), when_covered_percent: None, fault }
}

fn floor_and_fleet(seed: u64) -> Scenario {
    let mut rng = stream(seed, "story", "fleet");
    let text = format!("[mission]\nid = \"story-{seed}\"\nmap = \"none.map\"\nseed = {seed}\n");
    let mut file: ScenarioFile = toml::from_str(&text).expect("the least scenario is one");
    let count = rng.random_range(4..=6);
    file.fleet = Some(FleetTable { count, spread: true, near_x_m: None, near_y_m: None });
    let mut half_the_time = |most: f64, least: f64| {
        if rng.random_bool(0.5) { least } else { rng.random_range(0.0..most) }
    };
    file.network.loss = half_the_time(0.2, 0.0);
    file.network.duplicate = half_the_time(0.3, 0.0);
    file.network.jitter_ms = half_the_time(200.0, 1.0);
    let mut floors = (0_u32..).map(|draw| random_floor(&mut stream(seed, "floor", &draw.to_string())));
    let mut scenario = floors
        .find_map(|map| Scenario::on_map(file.clone(), map).ok())
        .expect("some floor has room for everybody");
    scenario.file.stations = stations(&scenario, &mut rng);
    scenario
}

/// Walls here and there; what they cut off is wall, too.
fn random_floor(rng: &mut ChaCha8Rng) -> GridMap {
    let walls = rng.random_range(0.0..0.25);
    let free: Vec<bool> = (0..COLUMNS * ROWS).map(|_| rng.random::<f64>() >= walls).collect();
    let parts = (0..free.len()).map(|from| part_of(&free, from));
    let largest = parts.max_by_key(BTreeSet::len).unwrap_or_default();
    let free = (0..free.len()).map(|square| largest.contains(&square)).collect();
    GridMap::new(COLUMNS as u32, ROWS as u32, 1.0, terrain::Point::origin(), free).expect("a small sound map")
}

fn part_of(free: &[bool], from: usize) -> BTreeSet<usize> {
    let mut part = BTreeSet::new();
    let mut stack = vec![from];
    while let Some(at) = stack.pop() {
        if !free[at] || !part.insert(at) {
            continue;
        }
        let (x, y) = (at % COLUMNS, at / COLUMNS);
        stack.extend((x > 0).then(|| at - 1));
        stack.extend((x + 1 < COLUMNS).then_some(at + 1));
        stack.extend((y > 0).then(|| at - COLUMNS));
        stack.extend((y + 1 < ROWS).then_some(at + COLUMNS));
    }
    part
}

/// One station or two, on cells where no robot starts.
fn stations(scenario: &Scenario, rng: &mut ChaCha8Rng) -> Vec<StationEntry> {
    let floor = &scenario.floor;
    let lattice = floor.lattice();
    let is_start = |cell: &Cell| {
        let at = lattice.center(*cell);
        scenario.file.robots.iter().any(|robot| (robot.x_m - at.x).hypot(robot.y_m - at.y) < 0.6)
    };
    let free = lattice.cells().filter(|&cell| floor.cell_is_drivable(cell));
    let mut cells: Vec<Cell> = free.filter(|cell| !is_start(cell)).collect();
    cells.shuffle(rng);
    cells.truncate(rng.random_range(1..=2));
    let station = |(number, cell): (usize, Cell)| {
        let at = lattice.center(cell);
        StationEntry { id: format!("s{}", number + 1), x_m: at.x, y_m: at.y }
    };
    cells.into_iter().enumerate().map(station).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_number_tells_the_same_story() {
        let (once, again) = (random_story(5), random_story(5));
        assert_eq!((&once.file, &once.map), (&again.file, &again.map));
        assert_ne!(once.map, random_story(6).map);
    }

    #[test]
    fn stories_have_two_to_six_faults_of_all_kinds_between_them() {
        let mut kinds = BTreeSet::new();
        for seed in 0..60 {
            let story = random_story(seed);
            assert!((2..=6).contains(&story.file.faults.len()));
            kinds.extend(story.file.faults.iter().map(|entry| entry.fault.kind()));
            for entry in &story.file.faults {
                assert_eq!(entry.check(&story), Ok(()), "{entry:?}");
            }
        }
        assert_eq!(kinds.len(), Fault::KINDS.len(), "{kinds:?}");
    }
}
