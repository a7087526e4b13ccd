//! The order an agent holds: what it has passed, its base, its horizon.
//!
//! Orders are idempotent: the same again is ignored, an older one is refused. An update begins with the stitching
//! node and replaces what is behind it; the base itself never changes within one order.

use protocol::v1;
use std::collections::VecDeque;
use terrain::Point;

/// A place of the order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Node {
    pub(crate) sequence: u64,
    pub(crate) point: Point,
    pub(crate) tool_active: bool,
}

/// What became of an order that came in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Answer {
    /// It is driven from now on.
    Accepted,
    /// It is known already.
    Known,
    /// It is older than what is known.
    Outdated,
    /// It does not join on to what is known.
    DoesNotFit,
}

/// The order, from the last node passed on.
#[derive(Debug, Clone, Default)]
pub(crate) struct OrderBook {
    pub(crate) term: u64,
    pub(crate) order_id: u64,
    pub(crate) update_id: u32,
    nodes: VecDeque<Node>,
    released: u64,
    passed: u64,
}

impl OrderBook {
    /// Takes in an order or an update.
    pub(crate) fn take(&mut self, order: &v1::Order) -> Answer {
        if order.term < self.term {
            return Answer::Outdated;
        }
        let Some(first) = order.nodes.first() else { return Answer::DoesNotFit };
        let newer_term = order.term > self.term;
        if newer_term || order.order_id > self.order_id {
            self.begin(order, first.sequence_id);
            return Answer::Accepted;
        }
        if order.order_id < self.order_id || order.order_update_id < self.update_id {
            return Answer::Outdated;
        }
        if order.order_update_id == self.update_id {
            return Answer::Known;
        }
        self.stitch(order, first.sequence_id)
    }

    fn begin(&mut self, order: &v1::Order, first: u64) {
        self.term = order.term;
        self.order_id = order.order_id;
        self.update_id = order.order_update_id;
        self.nodes = order.nodes.iter().map(node).collect();
        self.passed = first;
        self.released = first;
    }

    fn stitch(&mut self, order: &v1::Order, first: u64) -> Answer {
        let known = self.nodes.iter().any(|node| node.sequence == first);
        if first < self.released || !known {
            return Answer::DoesNotFit;
        }
        self.nodes.retain(|node| node.sequence <= first);
        self.nodes.extend(order.nodes.iter().skip(1).map(node));
        self.update_id = order.order_update_id;
        Answer::Accepted
    }

    /// Extends the base; a base never shrinks.
    pub(crate) fn release(&mut self, order_id: u64, update_id: u32, sequence: u64) {
        if order_id == self.order_id && update_id == self.update_id {
            let last = self.nodes.back().map_or(0, |node| node.sequence);
            self.released = self.released.max(sequence.min(last));
        }
    }

    /// Forgets the order; its number stays known.
    pub(crate) fn cancel(&mut self) {
        self.nodes.truncate(1);
        self.released = self.passed;
    }

    /// The next node counts as reached.
    pub(crate) fn pass_next(&mut self) {
        if self.nodes.len() > 1 {
            self.nodes.pop_front();
            self.passed = self.nodes[0].sequence;
        }
    }

    /// The last node passed, and those behind it up to the end of the base.
    pub(crate) fn base(&self) -> impl Iterator<Item = &Node> + '_ {
        self.nodes.iter().take_while(|node| node.sequence <= self.released)
    }

    pub(crate) fn passed(&self) -> u64 {
        self.passed
    }

    pub(crate) fn released(&self) -> u64 {
        self.released
    }

    /// Whether there is base left to drive.
    pub(crate) fn has_base(&self) -> bool {
        self.passed < self.released
    }

    /// Whether there is anything behind the base.
    pub(crate) fn has_horizon(&self) -> bool {
        self.nodes.back().is_some_and(|node| node.sequence > self.released)
    }
}

fn node(node: &v1::Node) -> Node {
    Node { sequence: node.sequence_id, point: Point::new(node.x_m, node.y_m), tool_active: node.tool_active }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(order_id: u64, update: u32, nodes: std::ops::RangeInclusive<u64>) -> v1::Order {
        v1::Order {
            term: 1,
            order_id,
            order_update_id: update,
            nodes: nodes
                .map(|sequence_id| v1::Node {
                    sequence_id,
                    x_m: sequence_id as f64,
                    y_m: 0.0,
                    tool_active: true,
                })
                .collect(),
            ..v1::Order::default()
        }
    }

    fn sequences(book: &OrderBook) -> Vec<u64> {
        book.nodes.iter().map(|node| node.sequence).collect()
    }

    #[test]
    fn the_same_order_again_is_ignored_and_an_older_one_refused() {
        let mut book = OrderBook::default();
        assert_eq!(book.take(&order(2, 1, 1..=4)), Answer::Accepted);
        assert_eq!(book.take(&order(2, 1, 1..=4)), Answer::Known);
        assert_eq!(book.take(&order(2, 0, 1..=9)), Answer::Outdated);
        assert_eq!(book.take(&order(1, 7, 1..=9)), Answer::Outdated);
        assert_eq!(sequences(&book), [1, 2, 3, 4]);
    }

    #[test]
    fn an_update_replaces_the_horizon_and_keeps_the_base() {
        let mut book = OrderBook::default();
        book.take(&order(2, 1, 1..=6));
        book.release(2, 1, 3);
        assert_eq!(book.take(&order(2, 2, 3..=4)), Answer::Accepted);
        assert_eq!(sequences(&book), [1, 2, 3, 4]);
        assert_eq!(book.take(&order(2, 3, 2..=5)), Answer::DoesNotFit, "it would change the base");
        assert_eq!(book.take(&order(2, 3, 9..=12)), Answer::DoesNotFit, "it leaves a gap");
    }

    #[test]
    fn a_release_for_an_update_that_is_not_known_does_not_count() {
        let mut book = OrderBook::default();
        book.take(&order(2, 1, 1..=6));
        book.release(2, 2, 5);
        assert_eq!(book.released(), 1);
        book.release(2, 1, 99);
        assert_eq!(book.released(), 6);
        book.release(2, 1, 3);
        assert_eq!(book.released(), 6, "a base never shrinks");
    }

    #[test]
    fn an_older_term_is_refused() {
        let mut book = OrderBook::default();
        book.take(&v1::Order { term: 3, ..order(2, 1, 1..=4) });
        assert_eq!(book.take(&order(9, 9, 1..=2)), Answer::Outdated);
        assert_eq!(book.take(&v1::Order { term: 4, ..order(1, 0, 1..=2) }), Answer::Accepted);
    }
}
