//! Joins closed lines until one is left on each piece of ground: a spanning tree of the cheapest exchanges.
//!
//! An exchange next to an earlier one costs little: the line passes on into the next track but one, and the tracks
//! become the two arms of a Fermat spiral. Where tracks turn anyway, at a corner or at the end of a pocket, it costs
//! least. So spirals need not be drawn: they are what is cheapest.

use super::walls::Walls;
use super::web::{Exchange, Web};
use crate::disjoint_sets::DisjointSets;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// How far apart places may be that are linked, in tool widths: one round after the other.
const REACHES: [f64; 3] = [1.6, 2.3, 4.0];
/// Costs are compared in these steps, metres.
const STEP_M: f64 = 1e-6;

/// Joins all closed lines that lie beside each other.
pub(super) fn join(web: &mut Web, walls: &Walls) {
    let mut lines = DisjointSets::new(web.len());
    for line in web.closed_lines() {
        for &place in &line {
            lines.unite(line[0], place);
        }
    }
    for reach in REACHES {
        let reach_m = reach * web.width_m;
        let mut queue = BinaryHeap::new();
        // An exchange is offered from one of its sides: the largest line need not look for others.
        let is_largest = in_the_largest(web, &mut lines);
        for place in (0..web.len() as u32).filter(|&place| !is_largest[place as usize]) {
            let is_asked = |beside: u32| beside > place || is_largest[beside as usize];
            offer(web, &mut lines, place, reach_m, &mut queue, is_asked);
        }
        while let Some(Reverse((cost, exchange))) = queue.pop() {
            if !is_open(web, &mut lines, exchange) {
                continue;
            }
            let now = steps(web, exchange);
            if now > cost {
                queue.push(Reverse((now, exchange)));
            } else if web.allows(exchange, walls) && (reach > REACHES[0] || !web.crosses(exchange)) {
                web.apply(exchange);
                lines.unite(exchange.one.0, exchange.other.0);
                for place in [exchange.one.0, exchange.one.1, exchange.other.0, exchange.other.1] {
                    offer(web, &mut lines, place, reach_m, &mut queue, |_| true);
                }
            }
        }
    }
}

/// Which places belong to the line that has the most.
fn in_the_largest(web: &Web, lines: &mut DisjointSets) -> Vec<bool> {
    let roots: Vec<u32> = (0..web.len() as u32).map(|place| lines.find(place)).collect();
    let mut places = vec![0_u32; web.len()];
    for &root in &roots {
        places[root as usize] += 1;
    }
    let largest = (0..web.len() as u32).max_by_key(|&root| places[root as usize]);
    roots.into_iter().map(|root| Some(root) == largest).collect()
}

type Queue = BinaryHeap<Reverse<(i64, Exchange)>>;

/// Adds every exchange at a place to the queue.
fn offer(
    web: &Web,
    lines: &mut DisjointSets,
    place: u32,
    reach_m: f64,
    queue: &mut Queue,
    is_asked: impl Fn(u32) -> bool,
) {
    let root = lines.find(place);
    for beside in web.beside(place, reach_m).filter(|&beside| is_asked(beside)) {
        if lines.find(beside) == root {
            continue;
        }
        for exchange in exchanges(web, place, beside) {
            if !is_twin(web, exchange) && may_pay(web, exchange, reach_m) {
                let Exchange { one, other } = exchange;
                let exchange = Exchange { one: one.min(other), other: one.max(other) };
                queue.push(Reverse((steps(web, exchange), exchange)));
            }
        }
    }
}

/// Whether an exchange of two short links is offered from its other two places, too.
fn is_twin(web: &Web, exchange: Exchange) -> bool {
    let Exchange { one: (a, a2), other: (b, b2) } = exchange;
    a.min(b) < a2.min(b2) && web.is_short(a, a2) && web.is_short(b, b2)
}

/// Whether an exchange is worth a closer look: its second link may be longer than the first only at an earlier joint.
pub(super) fn may_pay(web: &Web, exchange: Exchange, reach_m: f64) -> bool {
    let Exchange { one: (a, a2), other: (b, b2) } = exchange;
    let both_short = web.is_short(a, a2) && web.is_short(b, b2);
    let most_m = if both_short { 0.75 * reach_m } else { 1.5 * reach_m };
    let first_m = web.distance_m(a, b);
    let second_m = web.distance_m(a2, b2);
    second_m <= most_m && (!both_short || first_m <= most_m) && web.is_plain(exchange)
}

/// The four exchanges that link two places.
pub(super) fn exchanges(web: &Web, one: u32, other: u32) -> impl Iterator<Item = Exchange> {
    let (links, others) = (web.links[one as usize], web.links[other as usize]);
    links.into_iter().flat_map(move |link| {
        others.into_iter().map(move |far| Exchange { one: (one, link), other: (other, far) })
    })
}

fn steps(web: &Web, exchange: Exchange) -> i64 {
    (web.cost(exchange).value_m(web.width_m) / STEP_M) as i64
}

fn is_open(web: &Web, lines: &mut DisjointSets, exchange: Exchange) -> bool {
    let Exchange { one: (a, a2), other: (b, b2) } = exchange;
    web.linked(a, a2) && web.linked(b, b2) && lines.find(a) != lines.find(b)
}
