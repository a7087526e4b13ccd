//! Shortest ways over the lattice and its passages, for everything that is not coverage: to a station, aside, home.

use crate::zones::Zones;
use std::collections::{BTreeMap, VecDeque};
use terrain::{Cell, Floor, Passage, Passages};

const UNSEEN: u32 = u32::MAX;

/// What ways lead over: the moves of the lattice, and the passages between its pieces.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Roads<'a> {
    pub(crate) floor: &'a Floor,
    pub(crate) passages: &'a Passages,
    /// Passages through these are closed; the cells of a way are asked for one by one.
    pub(crate) zones: Option<&'a Zones>,
}

impl<'a> Roads<'a> {
    /// The open passages that begin in a cell.
    fn passages_from(self, cell: Cell) -> impl Iterator<Item = &'a Passage> {
        let index = self.floor.lattice().index(cell);
        let all = index.into_iter().flat_map(move |index| self.passages.from(index));
        all.filter(move |passage| self.is_open(passage))
    }

    fn is_open(self, passage: &Passage) -> bool {
        let lattice = self.floor.lattice();
        let is_held =
            |cell| lattice.index(cell).is_some_and(|at| self.zones.is_some_and(|zones| zones.holds(at)));
        !passage.cells(lattice).into_iter().any(is_held)
    }

    /// So many moves are as long as a passage.
    fn moves(self, passage: &Passage) -> u32 {
        (passage.length_m() / self.floor.lattice().cell_m).ceil().max(1.0) as u32
    }
}

/// The shortest way (in moves, straight on where there is a choice; a passage counts as one) from `from` to the nearest
/// cell that is a `goal`, over cells that are `open`. The first cell is `from`, which need not be open.
pub(crate) fn nearest(
    roads: Roads<'_>,
    from: Cell,
    goal: impl Fn(Cell) -> bool,
    open: impl Fn(Cell) -> bool,
) -> Option<Vec<Cell>> {
    let (floor, lattice) = (roads.floor, roads.floor.lattice());
    let mut came_from = vec![UNSEEN; lattice.len()];
    let start = lattice.index(from)?;
    came_from[start] = start as u32;
    let mut queue = VecDeque::from([from]);
    while let Some(cell) = queue.pop_front() {
        if goal(cell) {
            return Some(trace(floor, &came_from, cell));
        }
        let at = lattice.index(cell)?;
        let straight_first = straight_on(floor, &came_from, at)
            .filter(|next| floor.neighbours(cell).any(|near| near == *next));
        let beyond = roads.passages_from(cell).map(|passage| passage.to);
        for next in straight_first.into_iter().chain(floor.neighbours(cell)).chain(beyond) {
            let Some(index) = lattice.index(next) else { continue };
            if came_from[index] == UNSEEN && open(next) {
                came_from[index] = at as u32;
                queue.push_back(next);
            }
        }
    }
    None
}

/// The way from a cell to the target of [`moves_to`]: always to a cell that is one move nearer, straight on where
/// there is a choice. `None` where there is no way.
pub(crate) fn down(roads: Roads<'_>, moves: &[u32], from: Cell) -> Option<Vec<Cell>> {
    let (floor, lattice) = (roads.floor, roads.floor.lattice());
    let mut at = lattice.index(from).filter(|&at| moves[at] != UNSEEN)?;
    let mut way = vec![from];
    while moves[at] > 0 {
        let here = lattice.cell(at);
        let nearer = |next: &Cell| lattice.index(*next).is_some_and(|next| moves[next] == moves[at] - 1);
        let ahead = way.len().checked_sub(2).map(|before| {
            let before = way[before];
            Cell::new(2 * here.x - before.x, 2 * here.y - before.y)
        });
        let leads_down = |passage: &&Passage| {
            let beyond = lattice.index(passage.to).filter(|&beyond| moves[beyond] != UNSEEN);
            beyond.is_some_and(|beyond| moves[beyond] + roads.moves(passage) == moves[at])
        };
        let beyond = roads.passages_from(here).filter(leads_down).map(|passage| passage.to);
        let mut next = floor.neighbours(here).filter(nearer).chain(beyond).peekable();
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

/// Moves from each cell to the nearest of `targets` over `open` cells; `u32::MAX` where there is no way. A passage counts
/// as so many moves as are as long.
pub(crate) fn moves_to(roads: Roads<'_>, targets: &[Cell], open: impl Fn(Cell) -> bool) -> Vec<u32> {
    let (floor, lattice) = (roads.floor, roads.floor.lattice());
    let mut moves = vec![UNSEEN; lattice.len()];
    let mut due: BTreeMap<u32, Vec<Cell>> = BTreeMap::from([(0, targets.to_vec())]);
    while let Some((so_far, cells)) = due.pop_first() {
        for cell in cells {
            let Some(index) = lattice.index(cell).filter(|&index| moves[index] == UNSEEN) else { continue };
            moves[index] = so_far;
            let is_new =
                |next: &Cell| lattice.index(*next).is_some_and(|index| moves[index] == UNSEEN) && open(*next);
            let near = due.entry(so_far + 1).or_default();
            near.extend(floor.neighbours(cell).filter(is_new));
            for passage in roads.passages_from(cell).filter(|passage| is_new(&passage.to)) {
                due.entry(so_far + roads.moves(passage)).or_default().push(passage.to);
            }
        }
    }
    moves
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::{Timestamp, v1::ZoneType};
    use terrain::GridMap;

    fn roads<'a>(floor: &'a Floor, passages: &'a Passages) -> Roads<'a> {
        Roads { floor, passages, zones: None }
    }

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
        let way = nearest(
            roads(&floor, &Passages::default()),
            Cell::new(0, 0),
            |cell| cell == Cell::new(0, 2),
            |_| true,
        )
        .unwrap();
        assert_eq!(way.len(), 9);
        assert_eq!(
            nearest(
                roads(&floor, &Passages::default()),
                Cell::new(0, 0),
                |cell| cell.y == 2,
                |cell| cell.x != 3 && cell.x != 4
            ),
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
        let moves = moves_to(roads(&floor, &Passages::default()), &[Cell::new(4, 0)], |_| true);
        let way = down(roads(&floor, &Passages::default()), &moves, Cell::new(0, 2)).unwrap();
        assert_eq!((way.len(), way[way.len() - 1]), (7, Cell::new(4, 0)));
        let turns = way.windows(3).filter(|at| at[0].x != at[2].x && at[0].y != at[2].y).count();
        assert_eq!(turns, 1, "{way:?}");
        assert_eq!(down(roads(&floor, &Passages::default()), &moves, Cell::new(0, 0)), None);
    }

    #[test]
    fn moves_count_from_the_nearest_target() {
        let floor = floor("......");
        assert_eq!(
            moves_to(roads(&floor, &Passages::default()), &[Cell::new(0, 0), Cell::new(5, 0)], |_| true),
            [0, 1, 2, 2, 1, 0]
        );
        assert_eq!(
            moves_to(roads(&floor, &Passages::default()), &[Cell::new(0, 0)], |cell| cell.x != 2)[3],
            u32::MAX
        );
    }

    /// Two rooms, and a corridor at a slant that only a passage leads through.
    fn slanted() -> Floor {
        let is_free = |x: i32, y: i32| !(30..90).contains(&x) || (y * 100 - x * 37 - 900).abs() < 15 * 53;
        let squares = (0..60).flat_map(|y| (0..120).map(move |x| is_free(x, y))).collect();
        let map = GridMap::new(120, 60, 0.05, terrain::Point::origin(), squares).unwrap();
        Floor::new(&map, 0.4, 0.3, 0.52).unwrap()
    }

    #[test]
    fn a_way_leads_through_a_passage_unless_a_zone_shuts_it() {
        let floor = slanted();
        let passages = Passages::new(&floor);
        let (here, there) = (Cell::new(1, 3), Cell::new(13, 4));
        let open = roads(&floor, &passages);
        let way = nearest(open, here, |cell| cell == there, |_| true).expect("there is a passage");
        let moves = moves_to(open, &[there], |_| true);
        let down = down(open, &moves, here).expect("there is a passage");
        assert_eq!((down[0], down[down.len() - 1]), (here, there));
        assert!(moves[floor.lattice().index(here).unwrap()] as usize > way.len(), "a passage is long");

        let end = passages.iter().next().unwrap().to;
        let mut zones = Zones::new(floor.lattice().len());
        let cells = floor.lattice().index(end);
        zones.add(ZoneType::ZoneBlocked, cells, "r1", Timestamp::ZERO, Timestamp::ZERO);
        let shut = Roads { zones: Some(&zones), ..open };
        assert_eq!(nearest(shut, here, |cell| cell == there, |_| true), None);
        assert_eq!(moves_to(shut, &[there], |_| true)[floor.lattice().index(here).unwrap()], u32::MAX);
    }
}
