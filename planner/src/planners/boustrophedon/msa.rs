//! Minimum sum of altitudes: which fragments make a cell, and in which direction it is swept.
//!
//! S(G) = min( C(G), min over splits of G in two connected parts of S(G1) + S(G2) ), where C(G) is the least altitude of
//! all directions in which G is monotone (Huang 2001). Exact for a few fragments: all connected subsets are looked at,
//! O(3^K). The paper's heuristic for many: parts of the graph of at most K fragments, each solved exactly, then
//! neighbouring cells are merged while that lowers the sum (`merging.rs`).
//!
//! Our departure: an altitude below one tool width counts as one, since a cell has at least one lane, and each cell
//! adds half a tool width, for the way to it. Lanes that are slanted to the main walls count a quarter more: they leave
//! triangles at both ends.

use super::fragments::{Adjacency, Fragments, Union};
use std::collections::BTreeSet;

/// What an altitude counts for in directions other than the two main ones.
const SLANT: f64 = 1.25;
/// What a cell costs beside its altitude, in tool widths.
const CELL: f64 = 0.5;

/// Fragments swept together in one direction.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Region {
    /// Numbers of fragments, in order.
    pub(super) members: Vec<u32>,
    pub(super) sweep: Sweep,
}

/// A way to sweep a region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sweep {
    pub(super) direction: usize,
    /// Extent across the lanes, squares.
    pub(super) altitude: f64,
}

/// What altitudes are worth.
#[derive(Debug, Clone, Copy)]
pub(super) struct Altitudes<'a> {
    pub(super) fragments: &'a Fragments,
    /// As of [`Union::is_monotone`], squares.
    pub(super) tolerance: u32,
    /// Width of the tool, squares.
    pub(super) tool: f64,
}

impl Altitudes<'_> {
    /// The least altitude of all directions in which the union is monotone.
    pub(super) fn least(&self, members: &[u32]) -> Option<Sweep> {
        self.least_of(members, |union| union.is_monotone(self.tolerance))
    }

    /// The same for a fragment alone, which has to be swept somehow.
    pub(super) fn alone(&self, fragment: u32) -> Sweep {
        let any = self.least(&[fragment]).or_else(|| self.least_of(&[fragment], |_| true));
        any.expect("there is a direction")
    }

    fn least_of(&self, members: &[u32], allowed: impl Fn(&Union) -> bool) -> Option<Sweep> {
        let sweep = |direction| {
            let union = self.fragments.union(members, direction);
            let slant = if direction < 2 { 1.0 } else { SLANT };
            let altitude = slant * f64::from(union.altitude()).max(self.tool) + CELL * self.tool;
            allowed(&union).then_some(Sweep { direction, altitude })
        };
        (0..self.fragments.angles_rad.len())
            .filter_map(sweep)
            .min_by(|a, b| a.altitude.total_cmp(&b.altitude))
    }
}

/// Splits the graph into connected parts of at most `most` fragments, each grown along its longest borders.
pub(super) fn parts(adjacency: &Adjacency, most: usize) -> Vec<Vec<u32>> {
    let mut free: BTreeSet<u32> = (0..adjacency.of.len() as u32).collect();
    let mut parts = Vec::new();
    while let Some(first) = free.pop_first() {
        let mut part = vec![first];
        while part.len() < most {
            let beside = part.iter().flat_map(|&member| &adjacency.of[member as usize]);
            let next = beside
                .filter(|(other, _)| free.contains(other))
                .max_by_key(|&&(other, length)| (length, other));
            let Some(&(next, _)) = next else { break };
            free.remove(&next);
            part.push(next);
        }
        part.sort_unstable();
        parts.push(part);
    }
    parts
}

/// The exact programme over one part: regions with the minimum sum of altitudes.
pub(super) fn exact(
    adjacency: &Adjacency,
    part: &[u32],
    cost: &mut dyn FnMut(&[u32]) -> Option<Sweep>,
) -> Vec<Region> {
    assert!(part.len() <= 16, "the programme is exponential in the number of fragments");
    let linked: Vec<u32> = part.iter().map(|&member| links(adjacency, part, member)).collect();
    let members = |set: u32| -> Vec<u32> {
        (0..part.len()).filter(|&bit| set >> bit & 1 == 1).map(|bit| part[bit]).collect()
    };
    let mut best: Vec<Option<Choice>> = vec![None; 1 << part.len()];
    for set in 1..1_u32 << part.len() {
        if !is_connected(set, &linked) {
            continue;
        }
        let whole = cost(&members(set)).map(|sweep| Choice { sum: sweep.altitude, how: How::Whole(sweep) });
        best[set as usize] = better(whole, best_split(set, &best));
    }
    let mut regions = Vec::new();
    let mut open = pieces((1 << part.len()) - 1, &linked);
    while let Some(set) = open.pop() {
        match best[set as usize].expect("each fragment alone can be swept").how {
            How::Whole(sweep) => regions.push(Region { members: members(set), sweep }),
            How::Split(one) => open.extend([one, set & !one]),
        }
    }
    regions
}

#[derive(Debug, Clone, Copy)]
struct Choice {
    sum: f64,
    how: How,
}

#[derive(Debug, Clone, Copy)]
enum How {
    Whole(Sweep),
    /// This set, and the rest.
    Split(u32),
}

fn better(one: Option<Choice>, other: Option<Choice>) -> Option<Choice> {
    match (one, other) {
        (Some(one), Some(other)) => Some(if other.sum < one.sum { other } else { one }),
        (one, other) => one.or(other),
    }
}

/// The best split in two connected parts; the first holds the lowest fragment.
fn best_split(set: u32, best: &[Option<Choice>]) -> Option<Choice> {
    let lowest = set & set.wrapping_neg();
    let rest = set & !lowest;
    let mut found: Option<Choice> = None;
    let mut other = rest;
    while other != 0 {
        let one = set & !other;
        if let (Some(first), Some(second)) = (best[one as usize], best[other as usize]) {
            found = better(found, Some(Choice { sum: first.sum + second.sum, how: How::Split(one) }));
        }
        other = (other - 1) & rest;
    }
    found
}

/// Which others of a part a fragment touches, one bit each.
fn links(adjacency: &Adjacency, part: &[u32], member: u32) -> u32 {
    let bit = |&(other, _): &(u32, u32)| part.binary_search(&other).ok();
    adjacency.of[member as usize].iter().filter_map(bit).fold(0, |bits, bit| bits | 1 << bit)
}

fn reached(from: u32, set: u32, linked: &[u32]) -> u32 {
    let mut reached = from;
    loop {
        let next = (0..linked.len())
            .filter(|&bit| reached >> bit & 1 == 1)
            .fold(reached, |bits, bit| bits | linked[bit] & set);
        if next == reached {
            return reached;
        }
        reached = next;
    }
}

fn is_connected(set: u32, linked: &[u32]) -> bool {
    reached(set & set.wrapping_neg(), set, linked) == set
}

/// The connected pieces of a set.
fn pieces(set: u32, linked: &[u32]) -> Vec<u32> {
    let mut open = set;
    let mut pieces = Vec::new();
    while open != 0 {
        let piece = reached(open & open.wrapping_neg(), set, linked);
        pieces.push(piece);
        open &= !piece;
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A price that looks random, the same for the same set; none for some.
    fn price(members: &[u32], salt: u64) -> Option<Sweep> {
        let mixed = members.iter().fold(salt, |mixed, &member| {
            (mixed ^ u64::from(member + 1)).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(23)
        });
        let altitude = (mixed % 97) as f64 + 20.0 * members.len() as f64;
        (members.len() == 1 || mixed % 3 > 0).then_some(Sweep { direction: 0, altitude })
    }

    /// The least sum over all ways to deal fragments out to connected regions.
    fn least_by_trying(adjacency: &Adjacency, left: &[u32], regions: &mut Vec<Vec<u32>>, salt: u64) -> f64 {
        let Some((&next, rest)) = left.split_first() else {
            let connected = |region: &Vec<u32>| {
                let linked: Vec<u32> =
                    region.iter().map(|&member| links(adjacency, region, member)).collect();
                is_connected((1 << region.len()) - 1, &linked)
            };
            let price = |region: &Vec<u32>| price(region, salt).map_or(f64::INFINITY, |sweep| sweep.altitude);
            return if regions.iter().all(connected) {
                regions.iter().map(price).sum()
            } else {
                f64::INFINITY
            };
        };
        let mut least = f64::INFINITY;
        for region in 0..=regions.len() {
            if region == regions.len() {
                regions.push(Vec::new());
            }
            regions[region].push(next);
            least = least.min(least_by_trying(adjacency, rest, regions, salt));
            regions[region].pop();
            if regions[region].is_empty() {
                regions.pop();
            }
        }
        least
    }

    proptest! {
        #[test]
        fn the_programme_finds_what_trying_everything_finds(
            edges in prop::collection::vec((0_u32..6, 0_u32..6), 3..12),
            salt in any::<u64>(),
        ) {
            let mut of: Vec<BTreeSet<(u32, u32)>> = vec![BTreeSet::new(); 6];
            for (one, other) in edges.into_iter().filter(|(one, other)| one != other) {
                of[one as usize].insert((other, 1));
                of[other as usize].insert((one, 1));
            }
            let adjacency = Adjacency { of: of.into_iter().map(|list| list.into_iter().collect()).collect() };
            let part: Vec<u32> = (0..6).collect();
            let regions = exact(&adjacency, &part, &mut |members| price(members, salt));
            let sum: f64 = regions.iter().map(|region| region.sweep.altitude).sum();
            let least = least_by_trying(&adjacency, &part, &mut Vec::new(), salt);
            prop_assert!((sum - least).abs() < 1e-9, "{} {}", sum, least);
            let mut all: Vec<u32> = regions.into_iter().flat_map(|region| region.members).collect();
            all.sort_unstable();
            prop_assert_eq!(all, part);
        }
    }

    #[test]
    fn parts_are_connected_and_hold_everything() {
        let of = (0..9_u32).map(|at| [at.checked_sub(1), Some(at + 1).filter(|&next| next < 9)]);
        let adjacency =
            Adjacency { of: of.map(|near| near.into_iter().flatten().map(|n| (n, 1)).collect()).collect() };
        assert_eq!(parts(&adjacency, 4), [vec![0, 1, 2, 3], vec![4, 5, 6, 7], vec![8]]);
    }
}
