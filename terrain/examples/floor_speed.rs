//! How long laying out a floor of 1,000 x 1,000 cells takes: `cargo run --release -p terrain --example floor_speed`.

#![expect(clippy::print_stdout, clippy::disallowed_methods, reason = "an example that measures")]

use std::time::Instant;
use terrain::{Floor, GridMap, Point};

fn main() {
    let squares = (0..1000_u32 * 1000).map(|at| at % 1000 % 50 != 7 || at / 1000 % 20 == 3).collect();
    let map = GridMap::new(1000, 1000, 0.5, Point::origin(), squares).expect("the map is sound");
    let begun = Instant::now();
    let floor = Floor::new(&map, 0.5, 0.177, 0.75).expect("a body fits");
    println!("{} cells in {:.3} s", floor.lattice().len(), begun.elapsed().as_secs_f64());
}
