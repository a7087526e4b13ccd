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
