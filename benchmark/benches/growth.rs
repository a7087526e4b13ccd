//! `cargo bench`: growth exponents of planning time in cells.
#![expect(clippy::print_stdout, reason = "a benchmark prints")]

use benchmark::{BENCHMARKS, Options};

fn main() {
    let growth = BENCHMARKS.iter().find(|benchmark| benchmark.name == "growth").expect("it is in the table");
    let quick = std::env::args().any(|argument| argument == "--test");
    let options = Options { instances: std::path::PathBuf::new(), quick, effort: 1 };
    match (growth.run)(&options, &mut |what| println!("{what}")) {
        Ok(tables) => tables.iter().for_each(|table| println!("\n{}", table.markdown())),
        Err(error) => println!("error: {error}"),
    }
}
