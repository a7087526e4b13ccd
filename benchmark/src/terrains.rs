//! The terrains of the MFC paper's Fig. 6: 49 × 49 mega cells, empty, outdoor-like and indoor-like.

use planner::Start;
use rand::{RngExt as _, SeedableRng as _, seq::SliceRandom as _};
use rand_chacha::ChaCha8Rng;
use terrain::{Cell, Floor, Lattice, Point};

/// Mega cells on a side.
const SIDE: usize = 49;
/// Blocked mega cells of the outdoor terrain: a tenth.
const OUTDOOR_BLOCKED: usize = 240;

/// Which terrain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Terrain {
    Empty,
    Outdoor,
    Indoor,
}

/// Free mega cells, row by row.
type Megas = Vec<[bool; SIDE]>;

impl Terrain {
    pub(crate) fn named(name: &str) -> Option<Self> {
        match name {
            "empty" => Some(Self::Empty),
            "outdoor" => Some(Self::Outdoor),
            "indoor" => Some(Self::Indoor),
            _ => None,
        }
    }

    /// A random floor of this kind; cells of 1 m.
    pub(crate) fn floor(self, rng: &mut ChaCha8Rng) -> Floor {
        let megas = match self {
            Self::Empty => vec![[true; SIDE]; SIDE],
            Self::Outdoor => outdoor(rng),
            Self::Indoor => indoor(rng),
        };
        let side = 2 * SIDE as u32;
        let lattice = Lattice { origin: Point::origin(), cell_m: 1.0, columns: side, rows: side };
        let free: Vec<bool> =
            lattice.cells().map(|cell| megas[cell.y as usize / 2][cell.x as usize / 2]).collect();
        Floor::from_cells(lattice, &free, 0.35, 1.0)
    }
}

pub(crate) fn generator(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// Walls taken at random from a random depth first maze until a tenth is blocked.
fn outdoor(rng: &mut ChaCha8Rng) -> Megas {
    let mut free = maze(rng);
    let mut walls: Vec<(usize, usize)> =
        (0..SIDE * SIDE).map(|number| (number / SIDE, number % SIDE)).filter(|&(y, x)| !free[y][x]).collect();
    walls.shuffle(rng);
    let mut left = walls.len();
    while left > OUTDOOR_BLOCKED {
        // Only walls beside free ground, so that no mega cell stands alone.
        let next = walls.iter().rposition(|&(y, x)| sides(y, x).any(|(y, x)| free[y][x]));
        let (y, x) = walls.swap_remove(next.expect("a maze has walls beside its ways"));
        free[y][x] = true;
        left -= 1;
    }
    free
}

fn sides(y: usize, x: usize) -> impl Iterator<Item = (usize, usize)> {
    [(0, 1), (1, 0), (0, usize::MAX), (usize::MAX, 0)]
        .into_iter()
        .map(move |(dy, dx)| (y.wrapping_add(dy), x.wrapping_add(dx)))
        .filter(|&(y, x)| y < SIDE && x < SIDE)
}

/// Rooms on even rows and columns, joined depth first.
fn maze(rng: &mut ChaCha8Rng) -> Megas {
    let mut free = vec![[false; SIDE]; SIDE];
    let rooms = SIDE.div_ceil(2);
    let first = (2 * rng.random_range(0..rooms), 2 * rng.random_range(0..rooms));
    free[first.0][first.1] = true;
    let mut stack = vec![first];
    while let Some(&(y, x)) = stack.last() {
        let mut next: Vec<(usize, usize)> =
            [(0, 2), (2, 0), (0, 2_usize.wrapping_neg()), (2_usize.wrapping_neg(), 0)]
                .into_iter()
                .map(|(dy, dx)| (y.wrapping_add(dy), x.wrapping_add(dx)))
                .filter(|&(y, x)| y < SIDE && x < SIDE && !free[y][x])
                .collect();
        next.shuffle(rng);
        let Some(&(to_y, to_x)) = next.first() else {
            stack.pop();
            continue;
        };
        free[usize::midpoint(y, to_y)][usize::midpoint(x, to_x)] = true;
        free[to_y][to_x] = true;
        stack.push((to_y, to_x));
    }
    free
}

/// Walls at rows and columns 8, 16, …, 40; between two neighbouring rooms a door in the middle of the wall, two mega cells
/// wide, three in the central walls; each closed with probability 0.2, drawn again until all free ground is connected. The
/// layout is a guess: the paper shows a picture.
fn indoor(rng: &mut ChaCha8Rng) -> Megas {
    loop {
        let mut free = vec![[true; SIDE]; SIDE];
        for wall in (8..=40).step_by(8) {
            free[wall] = [false; SIDE];
            for row in &mut free {
                row[wall] = false;
            }
        }
        for wall in (8..=40).step_by(8) {
            for room in 0..6 {
                let width = if wall == 24 { 3 } else { 2 };
                let middle = room * 8 + 4;
                for across in [false, true] {
                    if rng.random::<f64>() < 0.2 {
                        continue;
                    }
                    for along in middle..middle + width {
                        let (y, x) = if across { (wall, along) } else { (along, wall) };
                        free[y][x] = true;
                    }
                }
            }
        }
        if is_connected(&free) {
            return free;
        }
    }
}

fn is_connected(free: &Megas) -> bool {
    let mut seen = vec![[false; SIDE]; SIDE];
    let mut stack = vec![(0, 0)];
    seen[0][0] = true;
    while let Some((y, x)) = stack.pop() {
        for (y, x) in sides(y, x) {
            if free[y][x] && !std::mem::replace(&mut seen[y][x], true) {
                stack.push((y, x));
            }
        }
    }
    seen == *free
}

/// Robots in cells of their own: the first anywhere, the others within a square around it, `percent` of the floor wide;
/// anywhere when `None`.
pub(crate) fn robots(floor: &Floor, count: usize, percent: Option<f64>, rng: &mut ChaCha8Rng) -> Vec<Start> {
    let lattice = floor.lattice();
    let free: Vec<Cell> = lattice.cells().filter(|&cell| floor.cell_is_drivable(cell)).collect();
    let first = free[rng.random_range(0..free.len())];
    let half = percent.map_or(f64::INFINITY, |percent| percent / 100.0 * f64::from(lattice.columns) / 2.0);
    let near = |cell: &Cell| {
        f64::from((cell.x - first.x).abs()) <= half && f64::from((cell.y - first.y).abs()) <= half
    };
    let mut others: Vec<Cell> = free.into_iter().filter(near).filter(|&cell| cell != first).collect();
    others.shuffle(rng);
    std::iter::once(first).chain(others).take(count).map(Start::at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terrains_have_the_papers_sizes() {
        for (terrain, least, most) in
            [(Terrain::Empty, 9604, 9604), (Terrain::Outdoor, 8644, 8644), (Terrain::Indoor, 8000, 8350)]
        {
            let floor = terrain.floor(&mut generator(3));
            let cells = (0..floor.lattice().len()).filter(|&index| floor.is_drivable(index)).count();
            assert!((least..=most).contains(&cells), "{terrain:?}: {cells}");
        }
    }

    #[test]
    fn robots_keep_together() {
        let mut rng = generator(1);
        let floor = Terrain::Empty.floor(&mut rng);
        let starts = robots(&floor, 20, Some(30.0), &mut rng);
        let first = starts[0].cell;
        assert_eq!(starts.len(), 20);
        assert!(starts.iter().all(|start| (start.cell.x - first.x).abs() <= 15));
    }
}
