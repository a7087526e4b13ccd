//! Draws the floors in `maps/`: `cargo run -p terrain --example generate_maps` writes them anew, byte for byte the
//! same; with `--check` it only compares.
//!
//! Every floor starts as solid wall, or as one open hall; rooms are carved out of it and racks are put into it. One
//! character is meant as 0.5 m.

#![expect(clippy::print_stdout, reason = "an example says what it did")]

use std::path::Path;

/// A floor being drawn; rows from the top, as in the file.
struct Drawing {
    rows: Vec<Vec<u8>>,
}

impl Drawing {
    fn filled(width: usize, height: usize, with: u8) -> Self {
        Self { rows: vec![vec![with; width]; height] }
    }

    fn fill(&mut self, [x, y, width, height]: [usize; 4], with: u8) {
        for row in &mut self.rows[y..y + height] {
            row[x..x + width].fill(with);
        }
    }

    fn carve(&mut self, place: [usize; 4]) {
        self.fill(place, b'.');
    }

    fn block(&mut self, place: [usize; 4]) {
        self.fill(place, b'@');
    }

    fn to_movingai(&self) -> String {
        let rows: Vec<&str> =
            self.rows.iter().map(|row| std::str::from_utf8(row).expect("only ASCII is drawn")).collect();
        let (height, width) = (rows.len(), rows[0].len());
        format!("type octile\nheight {height}\nwidth {width}\nmap\n{}\n", rows.join("\n"))
    }
}

/// Four rooms around a crossing, 14 x 10 m, and a block that can be passed on either side: any one door may close.
fn demo() -> Drawing {
    let mut floor = Drawing::filled(28, 20, b'.');
    floor.block([12, 0, 2, 20]);
    floor.block([0, 9, 12, 2]);
    floor.carve([12, 4, 2, 2]);
    floor.carve([12, 14, 2, 2]);
    floor.carve([4, 9, 2, 2]);
    floor.block([18, 8, 6, 4]);
    floor
}

/// Two rows of rooms along a corridor, 40 x 22 m; each room has a door to the corridor, every second wall one to the
/// next room.
fn office() -> Drawing {
    let mut floor = Drawing::filled(80, 44, b'@');
    floor.carve([2, 19, 76, 6]);
    for room in 0..6 {
        let x = 2 + 13 * room;
        let width = if room == 5 { 11 } else { 12 };
        floor.carve([x, 2, width, 16]);
        floor.carve([x, 26, width, 16]);
        floor.carve([x + 5, 18, 2, 1]);
        floor.carve([x + 3, 25, 2, 1]);
        floor.block([x + 4, 8, 4, 3]);
        floor.block([x + 2, 33, 3, 4]);
        if room % 2 == 1 {
            floor.carve([x - 1, 4, 1, 2]);
            floor.carve([x - 1, 38, 1, 2]);
        }
    }
    floor
}

/// A hall of 50 x 30 m with racks in rows, a cross aisle in the middle, columns and a packing area.
fn warehouse() -> Drawing {
    let mut floor = Drawing::filled(100, 60, b'@');
    floor.carve([1, 1, 98, 58]);
    for row in 0..9 {
        let y = 5 + 5 * row;
        floor.block([6, y, 32, 2]);
        floor.block([44, y, 32, 2]);
    }
    for column in 0..4 {
        floor.block([82 + 4 * column, 12, 1, 1]);
        floor.block([82 + 4 * column, 40, 1, 1]);
    }
    floor.block([84, 20, 8, 12]);
    floor.block([20, 53, 4, 3]);
    floor.block([60, 53, 4, 3]);
    floor
}

/// A street block of 48 x 48 m: four streets around houses with a yard, an alley, and parked cars.
fn street() -> Drawing {
    let mut floor = Drawing::filled(96, 96, b'.');
    floor.block([14, 14, 68, 68]);
    floor.carve([34, 34, 28, 28]);
    floor.carve([46, 14, 4, 20]);
    floor.carve([14, 46, 20, 4]);
    floor.carve([62, 50, 20, 4]);
    floor.block([40, 40, 6, 6]);
    floor.block([52, 52, 4, 4]);
    for (x, y) in [(20, 10), (32, 10), (58, 10), (24, 83), (44, 83), (70, 83)] {
        floor.block([x, y, 8, 3]);
    }
    for (x, y) in [(10, 22), (10, 60), (83, 30), (83, 66)] {
        floor.block([x, y, 3, 8]);
    }
    for corner in [[0, 0, 3, 3], [93, 0, 3, 3], [0, 93, 3, 3], [93, 93, 3, 3]] {
        floor.block(corner);
    }
    floor
}

fn main() -> std::io::Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../maps");
    let only_check = std::env::args().any(|argument| argument == "--check");
    for (name, floor) in
        [("demo", demo()), ("office", office()), ("warehouse", warehouse()), ("street", street())]
    {
        let path = folder.join(format!("{name}.map"));
        if only_check {
            let found = std::fs::read_to_string(&path)?;
            assert_eq!(found, floor.to_movingai(), "{name}.map: write it anew with this example");
        } else {
            std::fs::write(path, floor.to_movingai())?;
        }
        println!("{name}.map");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain::{Floor, parse_movingai};

    fn floors() -> [(&'static str, Drawing); 4] {
        [("demo", demo()), ("office", office()), ("warehouse", warehouse()), ("street", street())]
    }

    #[test]
    fn the_maps_are_what_the_generator_draws() {
        for (name, floor) in floors() {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../maps/{name}.map"));
            assert_eq!(std::fs::read_to_string(path).unwrap(), floor.to_movingai(), "{name}.map");
        }
    }

    #[test]
    fn every_free_cell_can_be_driven_to_from_every_other() {
        for (name, drawing) in floors() {
            let text = drawing.to_movingai();
            let map = parse_movingai(&text, 0.5).unwrap();
            let floor = Floor::new(&map, 0.5, 0.177, 0.75).unwrap();
            let free = text.lines().skip(4).collect::<String>().matches('.').count();
            let first = floor.lattice().cells().find(|&cell| floor.cell_is_drivable(cell)).unwrap();
            let mut reached = std::collections::BTreeSet::from([first]);
            let mut stack = vec![first];
            while let Some(cell) = stack.pop() {
                stack.extend(floor.neighbours(cell).filter(|&next| reached.insert(next)));
            }
            assert_eq!(reached.len(), free, "{name}");
        }
    }
}
