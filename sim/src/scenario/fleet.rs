//! `[fleet]` and `[[robots]]`: who there is, and where everybody starts.

use super::error::Refused;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use terrain::{Cell, Floor, Point};

/// Robots that are only counted: `r1`, `r2`, … with starts found on the map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FleetTable {
    /// How many.
    pub count: u32,
    /// Evenly over the floor (`true`), or side by side near one place (`false`).
    #[serde(default)]
    pub spread: bool,
    /// The place near which they start, metres; left out: the lower left of the floor.
    #[serde(default)]
    pub near_x_m: Option<f64>,
    /// The place near which they start, metres.
    #[serde(default)]
    pub near_y_m: Option<f64>,
}

/// One robot and its start.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotEntry {
    /// Its id, `[A-Za-z0-9_.-]{1,64}`.
    pub id: String,
    /// Where it starts, metres.
    pub x_m: f64,
    /// Where it starts, metres.
    pub y_m: f64,
    /// Its first heading, degrees anticlockwise from x.
    #[serde(default)]
    pub theta_deg: f64,
}

/// Starts on distinct drivable cells that are connected with each other, so far apart that no two bodies touch.
pub(crate) fn find_starts(table: &FleetTable, floor: &Floor) -> Result<Vec<RobotEntry>, Refused> {
    let home = home_cell(table, floor);
    let order = breadth_first(floor, home);
    let cells = if table.spread {
        evenly(table.count as usize, floor, &order)
    } else {
        side_by_side(table.count as usize, floor, &order)
    };
    if cells.len() < table.count as usize {
        let what = format!("only {} robots find a start here; lower `count`", cells.len());
        return Err(Refused::new("fleet.count", what));
    }
    let entry = |(number, cell): (usize, Cell)| {
        let at = floor.lattice().center(cell);
        RobotEntry { id: format!("r{}", number + 1), x_m: at.x, y_m: at.y, theta_deg: 0.0 }
    };
    Ok(cells.into_iter().enumerate().map(entry).collect())
}

/// The drivable cell nearest to the wanted place, in the largest connected part of the floor.
fn home_cell(table: &FleetTable, floor: &Floor) -> Cell {
    let lattice = floor.lattice();
    let wanted =
        Point::new(table.near_x_m.unwrap_or(lattice.origin.x), table.near_y_m.unwrap_or(lattice.origin.y));
    let largest = largest_part(floor);
    let distance = |cell: &Cell| (lattice.center(*cell) - wanted).norm();
    largest
        .into_iter()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)).then(a.cmp(b)))
        .expect("a floor has drivable cells")
}

fn largest_part(floor: &Floor) -> Vec<Cell> {
    let lattice = floor.lattice();
    let mut seen = vec![false; lattice.len()];
    let mut largest = Vec::new();
    for index in 0..lattice.len() {
        if seen[index] || !floor.is_drivable(index) {
            continue;
        }
        let part = breadth_first(floor, lattice.cell(index));
        for &cell in &part {
            seen[lattice.index(cell).expect("on the lattice")] = true;
        }
        if part.len() > largest.len() {
            largest = part;
        }
    }
    largest
}

fn breadth_first(floor: &Floor, from: Cell) -> Vec<Cell> {
    let lattice = floor.lattice();
    let mut seen = vec![false; lattice.len()];
    let mut order: Vec<Cell> = Vec::new();
    let mut reach = |cell: Cell, order: &mut Vec<Cell>| {
        let index = lattice.index(cell).expect("on the lattice");
        if !seen[index] {
            seen[index] = true;
            order.push(cell);
        }
    };
    reach(from, &mut order);
    let mut next = 0;
    while let Some(&cell) = order.get(next) {
        next += 1;
        floor.neighbours(cell).for_each(|near| reach(near, &mut order));
    }
    order
}

/// Two robots this far apart can both turn and pass the coordinator's separation.
fn apart_m(floor: &Floor) -> f64 {
    2.0 * floor.body_radius_m() + 0.2
}

fn side_by_side(count: usize, floor: &Floor, order: &[Cell]) -> Vec<Cell> {
    let lattice = floor.lattice();
    let mut chosen: Vec<Cell> = Vec::new();
    for &cell in order {
        let center = lattice.center(cell);
        let free = chosen.iter().all(|&other| (lattice.center(other) - center).norm() >= apart_m(floor));
        if free {
            chosen.push(cell);
            if chosen.len() == count {
                break;
            }
        }
    }
    chosen
}

/// Each next robot as far as possible from those before it.
fn evenly(count: usize, floor: &Floor, order: &[Cell]) -> Vec<Cell> {
    let lattice = floor.lattice();
    let mut chosen: Vec<Cell> = order.first().copied().into_iter().collect();
    let mut gap: Vec<f64> = vec![f64::INFINITY; order.len()];
    while chosen.len() < count {
        let last = lattice.center(chosen[chosen.len() - 1]);
        for (gap, &cell) in gap.iter_mut().zip(order) {
            *gap = gap.min((lattice.center(cell) - last).norm());
        }
        let best = (0..order.len()).max_by(|&a, &b| gap[a].total_cmp(&gap[b]).then(b.cmp(&a)));
        match best.filter(|&best| gap[best] >= apart_m(floor)) {
            Some(best) => chosen.push(order[best]),
            None => break,
        }
    }
    chosen
}
