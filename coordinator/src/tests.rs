//! Inputs in, outputs out: one file per cause of replanning, on a floor of 6 × 4 cells with two robots.

mod low_battery;
mod operator;
mod robot_lost;
mod stale_plan;

use crate::{
    BreakOffRequest, Config, Coordinator, Input, Mission, Output, PlanRequest, Publication, Station, Timing,
};
use protocol::{Timestamp, v1};
use std::{sync::Arc, time::Duration};
use terrain::{GridMap, Point};

/// A coordinator, and somebody who answers for its robots.
pub(crate) struct Story {
    pub(crate) coordinator: Coordinator,
    pub(crate) now: Timestamp,
    headers: u64,
    pub(crate) orders: Vec<(String, v1::Order)>,
    pub(crate) grants: Vec<(String, v1::Grant)>,
    pub(crate) plans: Vec<PlanRequest>,
    pub(crate) break_offs: Vec<BreakOffRequest>,
    pub(crate) events: Vec<v1::Event>,
    pub(crate) result: Option<v1::MissionResult>,
    /// Per robot: what it says next.
    pub(crate) states: Vec<v1::State>,
}

fn config() -> Config {
    let map = GridMap::from_drawing(&"......\n".repeat(4), 0.5).unwrap();
    Config {
        mission: Mission {
            id: "test".to_owned(),
            map: Arc::new(map),
            cell_m: 0.5,
            body_radius_m: 0.177,
            tool_width_m: 0.75,
            stations: vec![Station { id: "s1".to_owned(), position: Point::new(0.25, 1.75) }],
            planner: "tmstc-star".to_owned(),
            return_to_start: false,
            robots: vec!["r1".to_owned(), "r2".to_owned()],
        },
        timing: Timing::default(),
        term: 1,
        seed: 1,
    }
}

impl Story {
    /// Two robots in opposite corners that have joined; the first plan was asked for and is not answered.
    pub(crate) fn begin() -> Self {
        let model = v1::EnergyModel { capacity_wh: 100.0, ..v1::EnergyModel::default() };
        Self::begin_with(&model)
    }

    /// The same, with robots that need so much energy, and go to charge only when they must.
    pub(crate) fn begin_with(model: &v1::EnergyModel) -> Self {
        let mut story = Self {
            coordinator: Coordinator::new(config()).unwrap(),
            now: Timestamp::ZERO,
            headers: 0,
            orders: Vec::new(),
            grants: Vec::new(),
            plans: Vec::new(),
            break_offs: Vec::new(),
            events: Vec::new(),
            result: None,
            states: vec![state("r1", 0.25, 0.25), state("r2", 2.75, 1.75)],
        };
        for (robot, boot_id) in [("r1", 101), ("r2", 102)] {
            story.feed(Input::Alive { robot: robot.to_owned(), boot_id });
            let mut sheet = factsheet(robot, boot_id);
            sheet.energy_model = Some(*model);
            if model.drive_w_per_m_per_s > 0.0
                && let Some(levels) = &mut sheet.battery_charging
            {
                levels.critical_low_charging_level = 0.0;
                levels.minimum_desired_charging_level = 0.0;
            }
            story.feed(Input::Factsheet(Box::new(sheet)));
        }
        story.run(0.5, &[0, 1]);
        story
    }

    /// The same, with the first plan driven.
    pub(crate) fn under_way() -> Self {
        let mut story = Self::begin();
        story.answer();
        story.run(0.5, &[0, 1]);
        story
    }

    /// Lets time pass; these robots speak every 100 ms, acknowledge what they were ordered, and do not move.
    pub(crate) fn run(&mut self, seconds: f64, speaking: &[usize]) {
        for _ in 0..(seconds * 10.0).round() as u32 {
            self.now = self.now + Duration::from_millis(100);
            for &robot in speaking {
                self.headers += 1;
                let mut state = self.states[robot].clone();
                state.header.as_mut().unwrap().header_id = self.headers;
                self.feed(Input::State(Box::new(state)));
            }
            self.feed(Input::Woken);
        }
    }

    /// Answers the last request of the planner.
    pub(crate) fn answer(&mut self) {
        let request = self.plans.last().expect("a plan was asked for").clone();
        self.feed(Input::Planned { revision: request.revision, result: request.run(), planning_s: 0.01 });
    }

    pub(crate) fn feed(&mut self, input: Input) {
        for output in self.coordinator.handle(self.now, input) {
            match output {
                Output::Order { robot, order } => {
                    let state = &mut self.states[usize::from(robot == "r2")];
                    if order.order_id != state.order_id {
                        state.last_node_sequence_id = order.nodes[0].sequence_id;
                    }
                    (state.order_id, state.order_update_id) = (order.order_id, order.order_update_id);
                    self.orders.push((robot, order));
                }
                Output::Grant { robot, grant } => self.grants.push((robot, grant)),
                Output::Plan(request) => self.plans.push(*request),
                Output::BreakOffs(request) => self.break_offs.push(*request),
                Output::Publish(Publication::Event(event)) => self.events.push(event),
                Output::Publish(Publication::Result(result)) => self.result = Some(result),
                Output::InstantActions { .. } | Output::Publish(_) | Output::Reply(_) => {}
            }
        }
    }

    pub(crate) fn says(&self, event: &str) -> bool {
        self.events.iter().any(|said| said.event == event)
    }

    /// The last node of an order that a robot was granted; the first one when none was.
    pub(crate) fn grants_of(&self, robot: &str, order_id: u64) -> u64 {
        let of_order = self.grants.iter().filter(|(to, grant)| to == robot && grant.order_id == order_id);
        of_order.map(|(_, grant)| grant.released_sequence_id).max().unwrap_or(1)
    }

    pub(crate) fn last_grant(&self, robot: &str) -> &v1::Grant {
        &self.grants.iter().rev().find(|(to, _)| to == robot).expect("a grant").1
    }
}

fn state(robot: &str, x_m: f64, y_m: f64) -> v1::State {
    let boot_id = if robot == "r1" { 101 } else { 102 };
    v1::State {
        header: Some(v1::Header { serial_number: robot.to_owned(), boot_id, ..v1::Header::default() }),
        pose: Some(v1::Pose { x_m, y_m, theta_rad: 0.0 }),
        state_of_charge_percent: 90.0,
        ..v1::State::default()
    }
}

fn factsheet(robot: &str, boot_id: u64) -> v1::Factsheet {
    v1::Factsheet {
        header: Some(v1::Header { serial_number: robot.to_owned(), boot_id, ..v1::Header::default() }),
        body_radius_m: 0.177,
        tool_width_m: 0.75,
        speed_max_m_per_s: 0.5,
        acceleration_max_m_per_s2: 0.6,
        angular_speed_max_rad_per_s: 0.8,
        angular_acceleration_max_rad_per_s2: 2.0,
        state_interval_ms: 100,
        battery_charging: Some(v1::BatteryCharging {
            critical_low_charging_level: 5.0,
            minimum_desired_charging_level: 20.0,
            sufficient_charging_level: 80.0,
            maximum_desired_charging_level: 95.0,
        }),
        ..v1::Factsheet::default()
    }
}
