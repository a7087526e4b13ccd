//! The merge pass after the minimum sum of altitudes was found part by part: neighbouring cells become one while their
//! union is monotone and its altitude is at most the sum of theirs, the largest saving first.

use super::{
    fragments::Adjacency,
    msa::{Region, Sweep},
};
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

/// Merges as long as it helps. `cost` as for [`super::msa::exact`].
pub(super) fn merged(
    adjacency: &Adjacency,
    regions: Vec<Region>,
    cost: &mut dyn FnMut(&[u32]) -> Option<Sweep>,
) -> Vec<Region> {
    let mut pass = Pass::new(adjacency, regions);
    for region in 0..pass.regions.len() {
        pass.consider(region, cost);
    }
    while let Some(offer) = pass.offers.pop() {
        if pass.is_open(offer.pair.0) && pass.is_open(offer.pair.1) {
            let region = pass.merge(&offer);
            pass.consider(region, cost);
        }
    }
    pass.regions.into_iter().flatten().collect()
}

/// A pair of regions that could be one.
#[derive(Debug, PartialEq)]
struct Offer {
    saving: f64,
    pair: (usize, usize),
    sweep: Sweep,
}

impl Eq for Offer {}

impl Ord for Offer {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        // Of equal savings the pair with the lower numbers comes first.
        self.saving.total_cmp(&other.saving).then_with(|| other.pair.cmp(&self.pair))
    }
}

impl PartialOrd for Offer {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

struct Pass {
    /// A merged region gets a new number; `None` for those that went into it.
    regions: Vec<Option<Region>>,
    beside: Vec<BTreeSet<usize>>,
    offers: BinaryHeap<Offer>,
}

impl Pass {
    fn new(adjacency: &Adjacency, regions: Vec<Region>) -> Self {
        let owner: BTreeMap<u32, usize> = (0..regions.len())
            .flat_map(|number| regions[number].members.iter().map(move |&member| (member, number)))
            .collect();
        let mut beside = vec![BTreeSet::new(); regions.len()];
        for (&member, &number) in &owner {
            let others = adjacency.of[member as usize].iter().filter_map(|(other, _)| owner.get(other));
            beside[number].extend(others.copied().filter(|&other| other != number));
        }
        Self { regions: regions.into_iter().map(Some).collect(), beside, offers: BinaryHeap::new() }
    }

    fn is_open(&self, number: usize) -> bool {
        self.regions[number].is_some()
    }

    /// Looks at what a region could be merged with.
    fn consider(&mut self, number: usize, cost: &mut dyn FnMut(&[u32]) -> Option<Sweep>) {
        let Some(own) = &self.regions[number] else { return };
        for &other in &self.beside[number] {
            let Some(theirs) = &self.regions[other] else { continue };
            let union = union(&own.members, &theirs.members);
            let Some(sweep) = cost(&union) else { continue };
            let saving = own.sweep.altitude + theirs.sweep.altitude - sweep.altitude;
            if saving >= 0.0 {
                self.offers.push(Offer { saving, pair: (number.min(other), number.max(other)), sweep });
            }
        }
    }

    fn merge(&mut self, offer: &Offer) -> usize {
        let (one, other) = offer.pair;
        let take = |slot: &mut Option<Region>| slot.take().expect("both are open").members;
        let members = union(&take(&mut self.regions[one]), &take(&mut self.regions[other]));
        let number = self.regions.len();
        self.regions.push(Some(Region { members, sweep: offer.sweep }));
        let mut beside = std::mem::take(&mut self.beside[one]);
        beside.append(&mut std::mem::take(&mut self.beside[other]));
        beside.retain(|&near| self.regions[near].is_some());
        for &near in &beside {
            self.beside[near].insert(number);
        }
        self.beside.push(beside);
        number
    }
}

fn union(one: &[u32], other: &[u32]) -> Vec<u32> {
    let mut members = [one, other].concat();
    members.sort_unstable();
    members
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_saving_comes_first() {
        // A row of four; 1 and 2 save most together, 0 and 1 a little; more than two never fit.
        let of = vec![vec![(1, 1)], vec![(0, 1), (2, 1)], vec![(1, 1), (3, 1)], vec![(2, 1)]];
        let sweep = |altitude| Sweep { direction: 0, altitude };
        let alone = |member| Region { members: vec![member], sweep: sweep(10.0) };
        let mut cost = |members: &[u32]| match members {
            [1, 2] => Some(sweep(11.0)),
            [0, 1] => Some(sweep(12.0)),
            _ => None,
        };
        let regions = merged(&Adjacency { of }, (0..4).map(alone).collect(), &mut cost);
        let members: Vec<&[u32]> = regions.iter().map(|region| &region.members[..]).collect();
        assert_eq!(members, [&[0][..], &[3], &[1, 2]]);
    }
}
