//! One robot's route: what it has passed, what it may drive (base), and what is only planned (horizon).
//!
//! ```text
//!   nodes   1 ── 2 ── 3 ── 4 ── 5 ── 6 ── 7 ── 8
//!                ▲         ▲              ▲
//!              passed   released       sent to the agent
//!                └─ base ──┘└── horizon ──…
//! ```
//!
//! The base never changes; a new plan is stitched on at its end. Only [`Route::restart`] begins a new order
//! elsewhere: after the ground was taken away (lost, blocked) or the agent restarted.

use protocol::v1;
use std::collections::VecDeque;
use terrain::{Cell, Point, Segment};

/// Nodes that are sent ahead of the base; more follow when half of them are driven.
const WINDOW: u64 = 160;

/// A place on a route.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Waypoint {
    /// Where, metres.
    pub(crate) point: Point,
    /// The cell whose centre it is; `None` for a pose or a station.
    pub(crate) cell: Option<Cell>,
    /// Whether the edge that leads here covers.
    pub(crate) tool_active: bool,
}

/// What a robot is to do at the end of its route.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) enum Ending {
    /// Stand.
    #[default]
    Stay,
    /// Charge at this station.
    Charge(String),
}

/// The route of one robot. Sequence numbers count from 1 within an order.
#[derive(Debug, Clone, Default)]
pub(crate) struct Route {
    order_id: u64,
    update_id: u32,
    revision: u64,
    nodes: VecDeque<Waypoint>,
    /// Sequence number of `nodes[0]`.
    first: u64,
    passed: u64,
    released: u64,
    sent: u64,
    ending: Ending,
}

impl Route {
    /// Begins a new order where the robot stands.
    pub(crate) fn restart(&mut self, order_id: u64, at: Point) {
        *self = Self {
            order_id,
            update_id: 0,
            revision: self.revision,
            nodes: VecDeque::from([Waypoint { point: at, cell: None, tool_active: false }]),
            first: 1,
            passed: 1,
            released: 1,
            sent: 0,
            ending: Ending::Stay,
        };
    }

    /// Replaces the horizon by new places behind the end of the base.
    pub(crate) fn stitch(
        &mut self,
        revision: u64,
        places: impl IntoIterator<Item = Waypoint>,
        ending: Ending,
    ) {
        self.cut_horizon();
        self.nodes.extend(places);
        self.revision = revision;
        self.ending = ending;
    }

    /// Drops the horizon.
    pub(crate) fn cut_horizon(&mut self) {
        self.nodes.truncate((self.released + 1 - self.first) as usize);
        self.update_id += 1;
        self.sent = self.released;
        self.ending = Ending::Stay;
    }

    pub(crate) fn order_id(&self) -> u64 {
        self.order_id
    }

    pub(crate) fn update_id(&self) -> u32 {
        self.update_id
    }

    /// Number of the plan that it is from.
    pub(crate) fn revision(&self) -> u64 {
        self.revision
    }

    /// Number of nodes not released.
    pub(crate) fn nodes_ahead(&self) -> u64 {
        (self.first + self.nodes.len() as u64).saturating_sub(self.released + 1)
    }

    /// Number of nodes behind the last one that has at least so much way ahead, metres, within a centimetre.
    pub(crate) fn nodes_in_last_m(&self, ahead_m: f64) -> u64 {
        let mut left_m = ahead_m - 0.01;
        let edges = self.nodes.iter().rev().zip(self.nodes.iter().rev().skip(1));
        let within = edges.take_while(|(to, from)| {
            let is_within = left_m > 0.0;
            left_m -= (to.point - from.point).norm();
            is_within
        });
        within.count() as u64
    }

    pub(crate) fn released(&self) -> u64 {
        self.released
    }

    pub(crate) fn passed(&self) -> u64 {
        self.passed
    }

    pub(crate) fn ending(&self) -> &Ending {
        &self.ending
    }

    fn last(&self) -> u64 {
        self.first + self.nodes.len() as u64 - 1
    }

    /// The place with this sequence number, if it is still or already known.
    pub(crate) fn node(&self, sequence: u64) -> Option<&Waypoint> {
        self.nodes.get(usize::try_from(sequence.checked_sub(self.first)?).ok()?)
    }

    /// The end of the base.
    pub(crate) fn base_end(&self) -> Option<&Waypoint> {
        self.node(self.released)
    }

    /// Whether all of it is driven.
    pub(crate) fn is_done(&self) -> bool {
        self.nodes.is_empty() || self.passed >= self.last()
    }

    /// Takes in how far the robot says it is; returns whether that is news. What lies behind is forgotten.
    pub(crate) fn pass(&mut self, sequence: u64) -> bool {
        let passed = sequence.min(self.released);
        if passed <= self.passed {
            return false;
        }
        self.passed = passed;
        while self.first < self.passed {
            self.nodes.pop_front();
            self.first += 1;
        }
        true
    }

    /// Releases one more node.
    pub(crate) fn release_next(&mut self) {
        assert!(self.released < self.last(), "only a known node is released");
        self.released += 1;
    }

    /// The edge behind the base's end, if there is one.
    pub(crate) fn next_edge(&self) -> Option<(Segment, Waypoint)> {
        let from = self.node(self.released)?;
        let to = self.node(self.released + 1)?;
        Some((Segment::new(from.point, to.point), *to))
    }

    /// Places from the last passed node to the end of the base.
    pub(crate) fn base(&self) -> impl Iterator<Item = &Waypoint> + '_ {
        self.nodes.iter().take((self.released + 1).saturating_sub(self.first) as usize)
    }

    /// Places behind the end of the base.
    pub(crate) fn horizon(&self) -> impl Iterator<Item = &Waypoint> + '_ {
        self.nodes.iter().skip((self.released + 1).saturating_sub(self.first) as usize)
    }

    /// All places still ahead (the last passed one first).
    pub(crate) fn ahead(&self) -> impl Iterator<Item = &Waypoint> + '_ {
        self.nodes.iter()
    }

    /// Whether more nodes should be sent.
    pub(crate) fn wants_window(&self) -> bool {
        self.sent < self.last() && self.sent < self.released + WINDOW / 2
    }

    /// The next message: a window of nodes that begins with the end of the base.
    pub(crate) fn open_window(&mut self) {
        if self.sent != 0 && self.sent > self.released {
            self.update_id += 1;
        }
        self.sent = (self.released + WINDOW).min(self.last());
    }

    /// The order as it is sent; the same again until something changes.
    pub(crate) fn to_order(&self, header_id: u64, term: u64, boot_id: u64) -> v1::Order {
        let stitch = self.released;
        let nodes = (stitch..=self.sent.max(stitch))
            .filter_map(|sequence| {
                self.node(sequence).map(|node| v1::Node {
                    sequence_id: sequence,
                    x_m: node.point.x,
                    y_m: node.point.y,
                    tool_active: node.tool_active,
                })
            })
            .collect();
        let complete = self.sent >= self.last();
        let (end_action, station_id) = match &self.ending {
            Ending::Stay => (v1::EndAction::Stay, String::new()),
            Ending::Charge(station) => (v1::EndAction::StartCharging, station.clone()),
        };
        v1::Order {
            header_id,
            term,
            order_id: self.order_id,
            order_update_id: self.update_id,
            nodes,
            complete,
            end_action: end_action.into(),
            station_id,
            plan_revision: self.revision,
            boot_id,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(columns: std::ops::RangeInclusive<i32>) -> Vec<Waypoint> {
        columns
            .map(|x| Waypoint {
                point: Point::new(f64::from(x), 0.0),
                cell: Some(Cell::new(x, 0)),
                tool_active: true,
            })
            .collect()
    }

    fn route_of(nodes: i32) -> Route {
        let mut route = Route::default();
        route.restart(7, Point::new(0.0, 0.0));
        route.stitch(1, places(1..=nodes), Ending::Stay);
        route
    }

    #[test]
    fn a_new_plan_is_stitched_to_the_end_of_the_base() {
        let mut route = route_of(5);
        route.release_next();
        route.release_next();
        route.stitch(2, places(10..=12), Ending::Stay);
        let xs: Vec<f64> = route.ahead().map(|node| node.point.x).collect();
        assert_eq!(xs, [0.0, 1.0, 2.0, 10.0, 11.0, 12.0]);
        assert_eq!((route.released(), route.update_id()), (3, 2));
    }

    #[test]
    fn what_is_passed_is_forgotten_and_numbers_go_on() {
        let mut route = route_of(5);
        route.release_next();
        route.release_next();
        assert!(route.pass(2));
        assert!(!route.pass(2), "the same again is no news");
        assert!(route.pass(99), "never further than the base");
        assert_eq!(route.passed(), 3);
        assert_eq!(route.base_end().map(|node| node.point.x), Some(2.0));
        assert_eq!(route.node(1), None);
    }

    #[test]
    fn an_order_is_a_window_that_begins_with_the_stitching_node() {
        let mut route = route_of(1000);
        assert!(route.wants_window());
        route.open_window();
        let order = route.to_order(1, 1, 42);
        assert_eq!(order.nodes.first().map(|node| node.sequence_id), Some(1));
        assert_eq!(order.nodes.len() as u64, WINDOW + 1);
        assert!(!order.complete && !route.wants_window());
        for _ in 0..=WINDOW / 2 {
            route.release_next();
        }
        assert!(route.wants_window());
        let before = route.update_id();
        route.open_window();
        assert_eq!(route.update_id(), before + 1, "more nodes are an update");
    }

    #[test]
    fn a_place_is_found_by_the_way_ahead_of_it() {
        let mut route = route_of(5);
        assert_eq!(route.nodes_ahead(), 5);
        for (ahead_m, nodes) in [(0.0, 0), (1.0, 1), (1.4, 2), (3.0, 3), (5.0, 5), (9.0, 5)] {
            assert_eq!(route.nodes_in_last_m(ahead_m), nodes, "{ahead_m}");
        }
        route.release_next();
        route.release_next();
        assert_eq!(route.nodes_ahead(), 3);
        route.pass(3);
        assert_eq!((route.nodes_ahead(), route.nodes_in_last_m(1.0)), (3, 1));
    }

    #[test]
    fn a_short_order_is_complete_at_once() {
        let mut route = route_of(3);
        route.open_window();
        assert!(route.to_order(1, 1, 42).complete);
    }
}
