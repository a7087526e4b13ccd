//! What walking around a block takes, for each set of joints used.

use super::blocks::{Block, Blocks};
use crate::Instance;
use std::{collections::BTreeMap, f64::consts::FRAC_PI_2};
use terrain::{Cell, Direction};

/// Time of corners, seconds.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Corners {
    /// A quarter turn and the ramps of the runs that it separates.
    pub(crate) quarter_s: f64,
    /// The same for a half turn.
    pub(crate) half_s: f64,
}

impl Corners {
    pub(crate) fn new(instance: &Instance<'_>) -> Self {
        let motion = &instance.motion;
        let ramps = if motion.brakes { 1.0 } else { 0.5 };
        let ramps_s = ramps * motion.speed_m_per_s / motion.acceleration_m_per_s2;
        Self {
            quarter_s: motion.turn_s(FRAC_PI_2) + ramps_s,
            half_s: motion.turn_s(2.0 * FRAC_PI_2) + ramps_s,
        }
    }

    /// Between a move that leaves towards `one` and another that leaves towards `other`.
    pub(crate) fn between_s(self, one: Direction, other: Direction) -> f64 {
        if one == other {
            self.half_s
        } else if one == other.opposite() {
            0.0
        } else {
            self.quarter_s
        }
    }
}

/// Seconds by block and set of joints. A crossing counts half at either end.
#[derive(Debug)]
pub(crate) struct Pricing {
    begins: Vec<u32>,
    seconds: Vec<f64>,
}

impl Pricing {
    pub(crate) fn new(instance: &Instance<'_>, blocks: &Blocks) -> Self {
        let corners = Corners::new(instance);
        let mut pairing = Pairing { corners, known: BTreeMap::new() };
        let mut pricing = Self { begins: Vec::with_capacity(blocks.len()), seconds: Vec::new() };
        for block in 0..blocks.len() as Block {
            pricing.begins.push(pricing.seconds.len() as u32);
            for used in 0..1_u32 << blocks.joints[block as usize].len() {
                let stubs = stubs(blocks, block, used as u8);
                let moves_s: f64 = stubs
                    .iter()
                    .flat_map(|(cell, ways)| {
                        Direction::ALL.into_iter().map(move |way| (*cell, way, ways[way as usize]))
                    })
                    .map(|(cell, way, times)| f64::from(times) / 2.0 * instance.move_s(cell, cell.step(way)))
                    .sum();
                let corners_s: f64 = stubs.iter().map(|(_, ways)| pairing.least_s(*ways)).sum();
                pricing.seconds.push(moves_s + corners_s);
            }
        }
        pricing
    }

    /// Seconds of a block with a set of joints.
    pub(crate) fn seconds(&self, block: Block, used: u8) -> f64 {
        self.seconds[self.begins[block as usize] as usize + used as usize]
    }
}

/// Moves that leave a cell, by direction.
pub(crate) type Ways = [u8; 4];

/// The moves of the walk around a block with a set of joints, per cell.
pub(crate) fn stubs(blocks: &Blocks, block: Block, used: u8) -> Vec<(Cell, Ways)> {
    let own = blocks.cells[block as usize];
    let inner = blocks.inner[block as usize];
    let mut stubs: Vec<(Cell, Ways)> = own.iter().flatten().map(|&cell| (cell, [0; 4])).collect();
    let mut change = |cell: Cell, way: Direction, by: i8| {
        let stub =
            stubs.iter_mut().find(|(other, _)| *other == cell).expect("joints are at cells of the block");
        let ways = &mut stub.1[way as usize];
        *ways = ways.checked_add_signed(by).expect("a parallel joint replaces a move that is there");
    };
    // Around a whole block once; along a part there and back.
    let times = if inner == [true; 4] { 1 } else { 2 };
    for from in (0..4).filter(|&from| inner[from]) {
        let ends = own[from].zip(own[(from + 1) % 4]);
        let (one, other) = ends.expect("inner moves are between cells of the block");
        let along = Direction::between(one, other).expect("inner moves are between neighbours");
        change(one, along, times);
        change(other, along.opposite(), times);
    }
    for (number, joint) in blocks.joints[block as usize].iter().enumerate() {
        if used >> number & 1 == 0 {
            continue;
        }
        match joint.own {
            (cell, None) => change(cell, joint.side, 2),
            (one, Some(other)) => {
                change(one, joint.side, 1);
                change(other, joint.side, 1);
                let along = Direction::between(one, other).expect("cells of a parallel joint touch");
                change(one, along, -1);
                change(other, along.opposite(), -1);
            }
        }
    }
    stubs
}

/// The cheapest way to pair the moves at a cell: how the walk goes through it.
struct Pairing {
    corners: Corners,
    known: BTreeMap<Ways, f64>,
}

impl Pairing {
    fn least_s(&mut self, ways: Ways) -> f64 {
        if let Some(&known) = self.known.get(&ways) {
            return known;
        }
        let Some(first) = Direction::ALL.into_iter().find(|&way| ways[way as usize] > 0) else { return 0.0 };
        let mut rest = ways;
        rest[first as usize] -= 1;
        let mut least_s = f64::INFINITY;
        for second in Direction::ALL {
            if rest[second as usize] > 0 {
                let mut others = rest;
                others[second as usize] -= 1;
                least_s = least_s.min(self.corners.between_s(first, second) + self.least_s(others));
            }
        }
        assert!(least_s.is_finite(), "every cell has an even number of moves");
        self.known.insert(ways, least_s);
        least_s
    }
}
