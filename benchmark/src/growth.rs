//! How planning time grows with the floor: larger and larger squares with scattered obstacles, 64 robots.

use crate::{
    BenchmarkError, Options, Progress, Table, content,
    cpu::peak_memory_mb,
    tables::{ratio, tenths},
    task::Task,
    tmstc_instances::MOTION,
};
use planner::{Mode, PLANNERS, PlanError, Start};
use std::path::Path;
use terrain::{Cell, Floor, Lattice, Point};

/// Sides of the squares, cells.
const SIDES: [u32; 4] = [128, 256, 512, 1000];
const ROBOTS: usize = 64;
/// One mega cell in so many is blocked.
const ONE_IN: u64 = 11;

pub(crate) fn run(options: &Options, progress: Progress<'_>) -> Result<Vec<Table>, BenchmarkError> {
    let sides = if options.quick { &SIDES[..2] } else { &SIDES[..] };
    let mut times = Table::new(
        "growth",
        "Planning time by size of the floor",
        "Squares with one mega cell in 11 blocked at random, 64 robots spread evenly, equation 8. Memory: the largest \
         that this process had so far, all planners together.",
        &["planner", "side", "cells", "CPU s", "µs a cell", "÷ bound", "peak MB"],
    );
    let mut exponents = Table::new(
        "growth_exponents",
        "Growth exponents",
        "Slope of log CPU time over log cells, least squares. 1 is linear.",
        &["planner", "exponent"],
    );
    for planner in PLANNERS.iter().filter(|planner| !planner.is_slow) {
        let mut points = Vec::new();
        for &side in sides {
            progress(&format!("{} on {side} × {side}", planner.name));
            let task = square(side);
            let cells = task.instance().visit.iter().filter(|&&visit| visit).count();
            let made = match task.plan(planner.name, options.effort) {
                Ok(made) => made,
                Err(PlanError::Unsupported { .. }) => continue,
                Err(error) => return Err(content(Path::new(&task.name), error.to_string())),
            };
            points.push(((cells as f64).ln(), made.cpu_s.max(1e-4).ln()));
            times.push(vec![
                planner.name.to_owned(),
                side.to_string(),
                cells.to_string(),
                ratio(made.cpu_s),
                tenths(1e6 * made.cpu_s / cells as f64),
                ratio(made.makespan_s() / task.lower_bound_s()),
                peak_memory_mb().to_string(),
            ]);
        }
        exponents.push(vec![planner.name.to_owned(), ratio(slope(&points))]);
    }
    Ok(vec![exponents, times])
}

fn square(side: u32) -> Task {
    let lattice = Lattice { origin: Point::origin(), cell_m: 0.5, columns: side, rows: side };
    // A fixed scatter: the bits of a multiplicative hash.
    let blocked = |x: i32, y: i32| {
        let number = (x / 2) as u64 * 1_000_003 + (y / 2) as u64;
        (number.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 33).is_multiple_of(ONE_IN)
    };
    let free: Vec<bool> = lattice.cells().map(|cell| !blocked(cell.x, cell.y)).collect();
    let floor = Floor::from_cells(lattice, &free, 0.177, 0.5);
    let spread = side / 8;
    let places =
        (0..ROBOTS as u32).map(|robot| Cell::new((robot % 8 * spread) as i32, (robot / 8 * spread) as i32));
    let starts: Vec<Start> = places.map(|place| Start::at(nearest_free(&floor, place))).collect();
    Task {
        name: format!("{side} × {side}"), floor, starts, motion: MOTION, mode: Mode::Cover, weights: None
    }
}

/// The next drivable cell to the right, row by row.
fn nearest_free(floor: &Floor, place: Cell) -> Cell {
    let first = floor.lattice().index(place).expect("places are on the lattice");
    let index = (first..floor.lattice().len()).find(|&index| floor.is_drivable(index));
    floor.lattice().cell(index.expect("nine cells in ten are free"))
}

fn slope(points: &[(f64, f64)]) -> f64 {
    let count = points.len() as f64;
    let (mean_x, mean_y) =
        (points.iter().map(|p| p.0).sum::<f64>() / count, points.iter().map(|p| p.1).sum::<f64>() / count);
    let both: f64 = points.iter().map(|p| (p.0 - mean_x) * (p.1 - mean_y)).sum();
    both / points.iter().map(|p| (p.0 - mean_x).powi(2)).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadratic_has_slope_two() {
        let points: Vec<(f64, f64)> =
            [1.0_f64, 2.0, 5.0].iter().map(|n| (n.ln(), (3.0 * n * n).ln())).collect();
        assert!((slope(&points) - 2.0).abs() < 1e-9);
    }
}
