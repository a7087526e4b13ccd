//! What agents are sent again until they have taken it in: orders, pauses, cancellations. Nothing on the wire is
//! reliable by itself; everything is idempotent and repeated.

use crate::{
    Coordinator, Output,
    robot::{Phase, Robot},
};
use protocol::{
    Timestamp,
    v1::{self, InstantActionType, MissionState},
};
use std::time::Duration;

impl Coordinator {
    /// Repeats what an agent has not taken in: orders until acknowledged, pause and cancel until obeyed.
    pub(crate) fn resend(&mut self, now: Timestamp, out: &mut Vec<Output>) {
        let term = self.config.term;
        let paused = self.state == MissionState::Paused;
        let cancelled = self.state == MissionState::Cancelled;
        for robot in self.robots.iter_mut().filter(|robot| robot.phase == Phase::Ready) {
            let actions = wanted_actions(robot, paused, cancelled);
            if !actions.is_empty() {
                let header_id = robot.next_header();
                out.push(Output::InstantActions {
                    robot: robot.id.clone(),
                    actions: v1::InstantActions {
                        header_id,
                        term,
                        boot_id: robot.boot_id,
                        actions: actions.into_iter().map(Into::into).collect(),
                    },
                });
            }
            send_order(now, robot, term, out);
        }
    }
}

fn wanted_actions(robot: &Robot, paused: bool, cancelled: bool) -> Vec<InstantActionType> {
    let Some(state) = robot.state.as_ref() else { return Vec::new() };
    let mut actions = Vec::new();
    if paused != state.paused {
        actions.push(if paused { InstantActionType::StartPause } else { InstantActionType::StopPause });
    }
    if cancelled && state.order_id != 0 && state.order_id == robot.route.order_id() {
        actions.push(InstantActionType::CancelOrder);
    }
    if robot.factsheet.is_none() {
        actions.push(InstantActionType::FactsheetRequest);
    }
    actions
}

fn send_order(now: Timestamp, robot: &mut Robot, term: u64, out: &mut Vec<Output>) {
    const SEND_AGAIN: Duration = Duration::from_millis(300);
    if robot.route.order_id() == 0 {
        return;
    }
    if robot.route.wants_window() {
        robot.route.open_window();
        robot.order_sent = Timestamp::ZERO;
    }
    let again = robot.order_sent == Timestamp::ZERO || now.since(robot.order_sent) >= SEND_AGAIN;
    if robot.has_acknowledged() || !again {
        return;
    }
    robot.order_sent = now;
    let header_id = robot.next_header();
    let order = robot.route.to_order(header_id, term, robot.boot_id);
    out.push(Output::Order { robot: robot.id.clone(), order });
}
