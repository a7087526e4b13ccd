//! Shortest ways over the lattice, for everything that is not coverage: to a station, aside, home.

use std::collections::VecDeque;
use terrain::{Cell, Floor};

const UNSEEN: u32 = u32::MAX;

/// The shortest way (in moves, straight on where there is a choice) from `from` to the nearest cell that is a
/// `goal`, over cells that are `open`. The first cell is `from`, which need not be open.
pub(crate) fn nearest(
    floor: &Floor,
    from: Cell,
    goal: impl Fn(Cell) -> bool,
    open: impl Fn(Cell) -> bool,
) -> Option<Vec<Cell>> {
    let lattice = floor.lattice();
    let mut came_from = vec![UNSEEN; lattice.len()];
    let start = lattice.index(from)?;
    came_from[start] = start as u32;
    let mut queue = VecDeque::from([from]);
    while let Some(cell) = queue.pop_front() {
        if goal(cell) {
            return Some(trace(floor, &came_from, cell));
        }
        let at = lattice.index(cell)?;
        let straight_first = straight_on(floor, &came_from, at);
        for next in straight_first.into_iter().chain(floor.neighbours(cell)) {
            let Some(index) = lattice.index(next) else { continue };
            if came_from[index] == UNSEEN && floor.neighbours(cell).any(|near| near == next) && open(next) {
                came_from[index] = at as u32;
                queue.push_back(next);
            }
        }
    }
    None
}

/// The way from a cell to the target of [`moves_to`]: always to a cell that is one move nearer, straight on where
/// there is a choice. `None` where there is no way.
pub(crate) fn down(floor: &Floor, moves: &[u32], from: Cell) -> Option<Vec<Cell>> {
    let lattice = floor.lattice();
    let mut at = lattice.index(from).filter(|&at| moves[at] != UNSEEN)?;
    let mut way = vec![from];
    while moves[at] > 0 {
        let here = lattice.cell(at);
        let nearer = |next: &Cell| lattice.index(*next).is_some_and(|next| moves[next] == moves[at] - 1);
        let ahead = way.len().checked_sub(2).map(|before| {
            let before = way[before];
            Cell::new(2 * here.x - before.x, 2 * here.y - before.y)
        });
        let mut next = floor.neighbours(here).filter(nearer).peekable();
        let first = next.peek().copied()?;
        let chosen = next.find(|&next| Some(next) == ahead).unwrap_or(first);
        way.push(chosen);
        at = lattice.index(chosen)?;
    }
    Some(way)
}

fn straight_on(floor: &Floor, came_from: &[u32], at: usize) -> Option<Cell> {
    let lattice = floor.lattice();
    let before = came_from[at] as usize;
    let (from, here) = (lattice.cell(before), lattice.cell(at));
    (before != at).then(|| Cell::new(2 * here.x - from.x, 2 * here.y - from.y))
}

fn trace(floor: &Floor, came_from: &[u32], goal: Cell) -> Vec<Cell> {
    let lattice = floor.lattice();
    let mut way = vec![goal];
    let mut at = lattice.index(goal).expect("a goal is on the lattice");
    while came_from[at] as usize != at {
        at = came_from[at] as usize;
        way.push(lattice.cell(at));
    }
    way.reverse();
    way
}

/// Moves from each cell to the nearest of `targets` over `open` cells; `u32::MAX` where there is no way.
pub(crate) fn moves_to(floor: &Floor, targets: &[Cell], open: impl Fn(Cell) -> bool) -> Vec<u32> {
    let lattice = floor.lattice();
    let mut moves = vec![UNSEEN; lattice.len()];
    let mut queue = VecDeque::new();
    for &target in targets {
        if let Some(index) = lattice.index(target) {
            moves[index] = 0;
            queue.push_back(target);
        }
    }
    while let Some(cell) = queue.pop_front() {
        let so_far = moves[lattice.index(cell).expect("queued cells are on the lattice")];
        for next in floor.neighbours(cell) {
            let index = lattice.index(next).expect("a neighbour is on the lattice");
            if moves[index] == UNSEEN && open(next) {
                moves[index] = so_far + 1;
                queue.push_back(next);
            }
        }
    }
    moves
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain::GridMap;

    fn floor(drawing: &str) -> Floor {
        let map = GridMap::from_drawing(drawing, 0.5).unwrap();
        Floor::new(&map, 0.5, 0.17, 0.75).unwrap()
    }

    #[test]
    fn the_way_goes_around_a_wall() {
        let floor = floor(
            "
            .....
            ###..
            .....",
        );
        let way = nearest(&floor, Cell::new(0, 0), |cell| cell == Cell::new(0, 2), |_| true).unwrap();
        assert_eq!(way.len(), 9);
        assert_eq!(
            nearest(&floor, Cell::new(0, 0), |cell| cell.y == 2, |cell| cell.x != 3 && cell.x != 4),
            None
        );
    }

    #[test]
    fn the_way_down_is_as_long_as_the_moves_and_has_few_turns() {
        let floor = floor(
            "
            .....
            .....
            ###..",
        );
        let moves = moves_to(&floor, &[Cell::new(4, 0)], |_| true);
        let way = down(&floor, &moves, Cell::new(0, 2)).unwrap();
        assert_eq!((way.len(), way[way.len() - 1]), (7, Cell::new(4, 0)));
        let turns = way.windows(3).filter(|at| at[0].x != at[2].x && at[0].y != at[2].y).count();
        assert_eq!(turns, 1, "{way:?}");
        assert_eq!(down(&floor, &moves, Cell::new(0, 0)), None);
    }

    #[test]
    fn moves_count_from_the_nearest_target() {
        let floor = floor("......");
        assert_eq!(moves_to(&floor, &[Cell::new(0, 0), Cell::new(5, 0)], |_| true), [0, 1, 2, 2, 1, 0]);
        assert_eq!(moves_to(&floor, &[Cell::new(0, 0)], |cell| cell.x != 2)[3], u32::MAX);
    }
}
