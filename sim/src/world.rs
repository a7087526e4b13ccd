//! The world: a floor, robots on it, and what gets in their way, in fixed steps of 20 ms.
//!
//! ```text
//!   step: people walk ─▶ wheels turn ─▶ solid things stop bodies ─▶ bodies move ─▶ batteries, stations
//!                                                                └▶ every 100 ms: fixes, scans, truth
//! ```
//!
//! Robots are numbered as in the scenario. Nothing here has a clock or a thread: whoever runs the world calls
//! [`World::step`] fifty times a second, hands each robot its [`World::base_state`], and brings back setpoints.

use crate::{
    body::Body,
    clearance::Clearance,
    contact::Touches,
    drive::WATCHDOG,
    faults::{Delivery, FaultEntry, ProcessAction},
    obstacle::Obstacle,
    people::{Person, SeenRobot, Surroundings},
    range_finder::RangeFinder,
    scenario::Scenario,
    station::Charger,
};
use protocol::{Timestamp, v1};
use std::sync::Arc;
use std::time::Duration;
use terrain::{Point, SweptRaster};

/// One step of the world.
pub const STEP: Duration = Duration::from_millis(20);
const STEP_S: f64 = 0.02;
/// Steps between two fixes, two scans, two truths.
const STEPS_PER_FIX: u64 = 5;
/// Steps between two descriptions of a robot, and two rounds of the floor crew.
const STEPS_PER_SECOND: u64 = 50;

/// The world.
#[derive(Debug, Clone)]
pub struct World {
    pub(crate) scenario: Arc<Scenario>,
    pub(crate) seed: u64,
    pub(crate) now: Timestamp,
    pub(crate) bodies: Vec<Body>,
    pub(crate) obstacles: Vec<Obstacle>,
    pub(crate) people: Vec<Person>,
    pub(crate) chargers: Vec<Charger>,
    pub(crate) walls: Clearance,
    pub(crate) touches: Touches,
    pub(crate) contacts: Vec<v1::Contact>,
    pub(crate) told: Vec<v1::FaultInjected>,
    /// Faults that wait for their time.
    pub(crate) plot: Vec<FaultEntry>,
    /// What is to be done to processes, and when.
    pub(crate) agenda: Vec<(Timestamp, ProcessAction)>,
    /// What waits to be put on the floor.
    pub(crate) deliveries: Vec<Delivery>,
    pub(crate) covered_percent: f64,
    pub(crate) obstacle_count: u32,
    pub(crate) person_count: u32,
    /// Robots whose battery ran empty away from a station.
    stranded: Vec<bool>,
    finder: RangeFinder,
    description: v1::Factsheet,
    swept: SweptRaster,
    ticks: u64,
    truths: u64,
    tool_changed: bool,
    time_factor: f64,
    watchdog: Duration,
}

impl World {
    /// The world of a scenario at its start. All noise is drawn from `seed`.
    pub fn new(scenario: &Arc<Scenario>, seed: u64) -> Self {
        let file = &scenario.file;
        let charger = |entry: &crate::StationEntry| Charger {
            id: entry.id.clone(),
            position: Point::new(entry.x_m, entry.y_m),
            outage: None,
        };
        Self {
            seed,
            now: Timestamp::ZERO,
            bodies: file.robots.iter().map(|entry| Body::new(scenario, entry, seed)).collect(),
            obstacles: Vec::new(),
            people: Vec::new(),
            chargers: file.stations.iter().map(charger).collect(),
            walls: Clearance::new(&scenario.map),
            touches: Touches::default(),
            contacts: Vec::new(),
            told: Vec::new(),
            plot: file.faults.clone(),
            agenda: Vec::new(),
            deliveries: Vec::new(),
            covered_percent: 0.0,
            obstacle_count: 0,
            person_count: 0,
            stranded: vec![false; file.robots.len()],
            finder: RangeFinder::new(file.robot.range_finder_m, file.robot.beams),
            description: file.robot.factsheet(),
            swept: SweptRaster::new(*scenario.floor.lattice()),
            ticks: 0,
            truths: 0,
            tool_changed: false,
            time_factor: 1.0,
            watchdog: WATCHDOG,
            scenario: Arc::clone(scenario),
        }
    }

    /// The world is run this many times faster than the machine's clock; the drives' watchdogs are stretched so
    /// that they stay 200 ms on that clock.
    pub fn set_time_factor(&mut self, factor: f64) {
        assert!(factor > 0.0 && factor.is_finite(), "a time factor is a number above 0");
        self.time_factor = factor;
        self.watchdog = WATCHDOG.mul_f64(factor.max(1.0));
    }

    /// Lets 20 ms pass.
    pub fn step(&mut self) {
        self.ticks += 1;
        self.now = self.now + STEP;
        self.follow_plot();
        self.deliver();
        self.step_people();
        self.tool_changed = false;
        for body in &mut self.bodies {
            let tool_was = body.tool_active;
            body.bumper = false;
            body.recover(self.now);
            body.turn_wheels(self.now, STEP_S, self.watchdog);
            self.tool_changed |= body.tool_active != tool_was;
        }
        self.stop_at_solid_things();
        self.move_bodies();
        self.dock();
        self.charge(STEP_S);
        for (body, stranded) in self.bodies.iter().zip(&mut self.stranded) {
            *stranded |= body.on_floor && body.docked.is_none() && body.battery.is_empty();
        }
        self.look_around();
        if self.ticks.is_multiple_of(STEPS_PER_SECOND) {
            self.let_the_crew_work();
        }
        self.remove_obstacles();
    }

    /// Time since the start of the world.
    pub fn now(&self) -> Timestamp {
        self.now
    }

    /// Number of robots.
    pub fn robot_count(&self) -> usize {
        self.bodies.len()
    }

    /// Id of a robot.
    pub fn robot_id(&self, robot: usize) -> &str {
        &self.bodies[robot].id
    }

    /// Number of a robot.
    pub fn robot_index(&self, id: &str) -> Option<usize> {
        self.bodies.iter().position(|body| body.id == id)
    }

    /// What a robot's base measures now; to be asked for once a step, since a scan is handed out once.
    pub fn base_state(&mut self, robot: usize) -> v1::BaseState {
        let describes = (self.ticks + robot as u64) % STEPS_PER_SECOND == 1;
        let body = &mut self.bodies[robot];
        let (fix_sequence, fix) = body.localisation.fix();
        let station = body.docked.map(|station| self.chargers[station].id.clone());
        v1::BaseState {
            sequence: self.ticks,
            time_ns: self.now.as_nanos(),
            odometry: Some(body.localisation.odometry()),
            fix_sequence,
            fix: Some(fix),
            fix_deviation_m: body.localisation.deviation_m(),
            speed_m_per_s: body.speed_m_per_s,
            angular_speed_rad_per_s: body.angular_speed_rad_per_s,
            state_of_charge_percent: body.battery.percent(),
            charging: station.is_some(),
            station_id: station.unwrap_or_default(),
            bumper: body.bumper,
            scan: body.fresh_scan.take(),
            drive_refuses: body.drive.refusal().is_some(),
            refusal: body.drive.refusal().map_or_else(String::new, |refusal| refusal.text().to_owned()),
            radio_jammed: body.is_radio_jammed(),
            description: (describes || self.ticks == 1).then(|| self.description.clone()),
            tool_active: body.tool_active,
            time_factor: self.time_factor,
        }
    }

    /// An agent's setpoint reaches its robot's drive.
    pub fn setpoint(&mut self, robot: usize, setpoint: &v1::Setpoint) {
        let body = &mut self.bodies[robot];
        body.heard = self.now;
        body.drive.take(self.now, setpoint);
    }

    /// A robot's agent is alive, though it may send no setpoints.
    pub fn agent_seen(&mut self, robot: usize) {
        self.bodies[robot].heard = self.now;
    }

    /// Whether the link between a robot and the coordinator is cut, both ways.
    pub fn is_radio_jammed(&self, robot: usize) -> bool {
        self.bodies[robot].is_radio_jammed()
    }

    /// The truth, each 100 ms and whenever a tool was switched.
    pub fn take_truth(&mut self) -> Option<v1::GroundTruth> {
        (self.tool_changed || self.ticks.is_multiple_of(STEPS_PER_FIX)).then(|| {
            self.truths += 1;
            v1::GroundTruth {
                sequence: self.truths,
                timestamp_ns: self.now.as_nanos(),
                bodies: self.bodies.iter().map(Body::truth).collect(),
                obstacles: self
                    .obstacles
                    .iter()
                    .map(Obstacle::truth)
                    .chain(self.people.iter().map(Person::truth))
                    .collect(),
            }
        })
    }

    /// The contacts since the last call.
    pub fn take_contacts(&mut self) -> Vec<v1::Contact> {
        std::mem::take(&mut self.contacts)
    }

    /// The faults that were carried out since the last call.
    pub fn take_faults(&mut self) -> Vec<v1::FaultInjected> {
        std::mem::take(&mut self.told)
    }

    /// Ids of the robots whose battery ran empty on the floor, away from a working station.
    pub(crate) fn take_stranded(&mut self) -> Vec<String> {
        let stranded = std::mem::take(&mut self.stranded);
        self.bodies
            .iter()
            .zip(stranded)
            .filter(|(_, empty)| *empty)
            .map(|(body, _)| body.id.clone())
            .collect()
    }

    /// What the tools have truly swept so far, on the mission's lattice.
    pub(crate) fn swept(&mut self) -> &SweptRaster {
        for robot in 0..self.bodies.len() {
            self.sweep(robot, true);
        }
        &self.swept
    }

    /// Whether a robot stands on the floor, its wheels grip, and its battery is not low.
    pub(crate) fn can_drive(&self, robot: usize) -> bool {
        let body = &self.bodies[robot];
        let low = self.scenario.file.robot.charging.minimum_desired_percent;
        body.on_floor && body.ailments.slip.is_none() && body.battery.percent() > low
    }

    pub(crate) fn body_radius_m(&self) -> f64 {
        self.scenario.file.robot.body_radius_m
    }

    pub(crate) fn tell(&mut self, kind: &str, target: &str, text: &str) {
        self.told.push(v1::FaultInjected {
            timestamp_ns: self.now.as_nanos(),
            kind: kind.to_owned(),
            target: target.to_owned(),
            text: text.to_owned(),
        });
    }

    fn step_people(&mut self) {
        if self.people.is_empty() {
            return;
        }
        let now = self.now;
        self.people.retain(|person| person.until.is_none_or(|until| now < until));
        let robots = self.seen_robots();
        let mut people: Vec<Point> = self.people.iter().map(|person| person.position).collect();
        let map = Arc::clone(&self.scenario.map);
        for own in 0..self.people.len() {
            let around = Surroundings {
                map: &map,
                walls: &self.walls,
                obstacles: &self.obstacles,
                people: &people,
                own,
                robots: &robots,
            };
            let touched = self.people[own].step(now, STEP_S, &around);
            people[own] = self.people[own].position;
            if let Some(robot) = touched {
                self.person_touches(own, robot);
            }
        }
    }

    /// The robots on the floor, as people see them.
    fn seen_robots(&self) -> Vec<(usize, SeenRobot)> {
        let body_radius_m = self.body_radius_m();
        let seen = |body: &Body| SeenRobot {
            position: body.position(),
            room_m: 0.3 + body.stopping_m() + 0.5 * body.speed_m_per_s.abs(),
            body_radius_m,
            ahead: body.direction_of_motion(),
        };
        let on_floor = self.bodies.iter().enumerate().filter(|(_, body)| body.on_floor);
        on_floor.map(|(robot, body)| (robot, seen(body))).collect()
    }

    fn move_bodies(&mut self) {
        for robot in 0..self.bodies.len() {
            if self.bodies[robot].on_floor {
                self.bodies[robot].move_on(STEP_S);
                self.sweep(robot, false);
            }
        }
    }

    fn sweep(&mut self, robot: usize, now_or_never: bool) {
        if let Some(way) = self.bodies[robot].take_sweep(now_or_never) {
            let radius_m = self.scenario.file.robot.tool_width_m / 2.0;
            self.swept.sweep(way, radius_m, |_| {});
        }
    }

    /// Fixes and scans, spread over the steps so that not all robots are busy at once.
    fn look_around(&mut self) {
        for robot in 0..self.bodies.len() {
            if !(self.ticks + robot as u64).is_multiple_of(STEPS_PER_FIX) {
                continue;
            }
            let pose = self.bodies[robot].pose;
            self.bodies[robot].localisation.take_fix(pose);
            if self.bodies[robot].on_floor && self.finder.reach_m() > 0.0 {
                self.bodies[robot].fresh_scan = Some(self.scan(robot));
            }
        }
    }

    fn scan(&self, robot: usize) -> v1::RangeScan {
        let radius_m = self.body_radius_m();
        let eye = &self.bodies[robot].pose;
        let others = self.bodies.iter().enumerate();
        let bodies = others
            .filter(|&(other, body)| other != robot && body.on_floor)
            .map(|(_, body)| (body.position(), radius_m));
        let people = self.people.iter().map(|person| (person.position, crate::people::PERSON_RADIUS_M));
        let shapes = self.obstacles.iter().map(|obstacle| obstacle.shape);
        self.finder.scan(&self.walls, eye, bodies.chain(people), shapes)
    }

    fn remove_obstacles(&mut self) {
        let now = self.now;
        self.obstacles.retain(|obstacle| obstacle.until.is_none_or(|until| now < until));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{drive, world};

    #[test]
    fn a_robot_speeds_up_drives_and_stops_within_its_limits() {
        let mut world = world("..........\n..........\n..........", &[(1.25, 1.25)]);
        drive(&mut world, 0, 0.5, 0.0, 2.0);
        // 0.5 m/s at 0.8 m/s²: 0.625 s to get there.
        let expected = 1.25 + 0.5 * 2.0 - 0.5 * 0.625 / 2.0;
        assert!((world.bodies[0].position().x - expected).abs() < 0.011, "{}", world.bodies[0].position());
        drive(&mut world, 0, 0.0, 0.0, 1.0);
        assert!(world.bodies[0].speed_m_per_s.abs() < 1e-12);
    }

    #[test]
    fn a_silent_agent_means_a_stop_by_the_watchdog() {
        let mut world = world("..........\n..........\n..........", &[(1.25, 1.25)]);
        drive(&mut world, 0, 0.5, 0.0, 1.0);
        for _ in 0..50 {
            world.step();
        }
        assert!(world.bodies[0].speed_m_per_s.abs() < 1e-12);
    }

    #[test]
    fn the_drive_stops_at_the_end_of_the_run_even_when_its_agent_falls_silent() {
        let mut world = world("..........\n..........\n..........", &[(1.25, 1.25)]);
        drive(&mut world, 0, 1.0, 0.0, 2.0);
        let from = world.bodies[0].position().x;
        let last = v1::Setpoint {
            speed_m_per_s: 1.0,
            term: 1,
            epoch: 1,
            boot_id: 7,
            valid_until_ns: u64::MAX,
            run_m: 0.65,
            ..v1::Setpoint::default()
        };
        world.setpoint(0, &last);
        world.set_time_factor(10.0);
        for _ in 0..100 {
            world.step();
        }
        let driven_m = world.bodies[0].position().x - from;
        assert!((0.6..0.67).contains(&driven_m), "{driven_m}");
    }

    #[test]
    fn a_wall_stops_a_body_and_is_reported_once() {
        let mut world = world("....\n....\n....", &[(1.25, 1.25)]);
        drive(&mut world, 0, 1.0, 0.0, 5.0);
        let contacts = world.take_contacts();
        assert_eq!(contacts.len(), 1, "{contacts:?}");
        assert_eq!((contacts[0].serial_number.as_str(), contacts[0].other.as_str()), ("r1", "wall"));
        let radius_m = world.body_radius_m();
        assert!(world.scenario.map.disc_is_free(world.bodies[0].position(), radius_m - 1e-5));
    }

    #[test]
    fn two_bodies_never_overlap() {
        let mut world = world("..........\n..........\n..........", &[(1.25, 1.25), (4.25, 1.25)]);
        drive(&mut world, 0, 1.0, 0.0, 6.0);
        let contacts = world.take_contacts();
        assert_eq!((contacts.len(), contacts[0].other.as_str()), (1, "r2"));
        let apart_m = (world.bodies[0].position() - world.bodies[1].position()).norm();
        assert!(apart_m >= 2.0 * world.body_radius_m() && apart_m < 2.0 * world.body_radius_m() + 0.03);
    }

    #[test]
    fn the_tool_sweeps_truly_where_it_is_on() {
        let mut world = world("..........\n..........\n..........", &[(1.25, 1.25)]);
        drive(&mut world, 0, 0.5, 0.0, 5.0);
        let lattice = *world.swept.lattice();
        let samples = |world: &mut World, x: f64, y: f64| {
            let cell = lattice.index(lattice.cell_at(Point::new(x, y)).unwrap()).unwrap();
            world.swept().samples(cell).count_ones()
        };
        assert_eq!((samples(&mut world, 2.25, 1.25), samples(&mut world, 2.25, 2.25)), (64, 0));
    }

    #[test]
    fn a_tool_that_is_on_for_a_moment_sweeps_where_it_stands() {
        let mut world = world("..........\n..........\n..........", &[(1.25, 1.25)]);
        drive(&mut world, 0, 0.0, 0.5, 0.1);
        for _ in 0..50 {
            world.step(); // the watchdog turns the tool off
        }
        assert!(!world.bodies[0].tool_active);
        let cell = world.swept.lattice().index(terrain::Cell::new(2, 2)).unwrap();
        assert_eq!(world.swept().samples(cell), u64::MAX);
    }

    #[test]
    fn a_docked_robot_is_charged_and_an_empty_one_does_not_move() {
        let mut world = world("..........\n..........\n..........", &[(1.25, 1.25), (3.25, 1.25)]);
        for body in &mut world.bodies {
            body.battery.drop_to(0.0);
        }
        drive(&mut world, 1, 0.5, 0.0, 1.0);
        assert!((world.bodies[1].position().x - 3.25).abs() < 1e-12);
        assert!(world.bodies[0].battery.percent() > 0.1, "station s1 is at the first robot's start");
        let state = world.base_state(0);
        assert!(state.charging && state.station_id == "s1");
    }

    #[test]
    fn a_silent_machine_is_carried_off_and_put_back_when_its_agent_is_heard() {
        let mut world = world("..........\n..........\n..........", &[(1.25, 1.25)]);
        drive(&mut world, 0, 0.5, 0.0, 2.0);
        for _ in 0..62 * 50 {
            world.step();
        }
        assert!(!world.bodies[0].on_floor);
        drive(&mut world, 0, 0.0, 0.0, 2.0);
        assert!(world.bodies[0].on_floor);
        assert_eq!(world.bodies[0].position(), Point::new(1.25, 1.25));
        let told: Vec<String> = world.take_faults().into_iter().map(|fault| fault.kind).collect();
        assert_eq!(told, ["carried_off", "put_back"]);
    }

    #[test]
    fn base_states_count_without_gaps_and_a_scan_comes_ten_times_a_second() {
        let mut world = world("..........\n..........\n..........", &[(1.25, 1.25), (3.25, 1.25)]);
        let mut scans = 0;
        for tick in 1..=100 {
            world.step();
            let state = world.base_state(1);
            assert_eq!(state.sequence, tick);
            scans += u32::from(state.scan.is_some());
        }
        assert_eq!(scans, 20);
    }

    #[test]
    fn the_truth_comes_ten_times_a_second_and_when_a_tool_is_switched() {
        let mut world = world("..........\n..........\n..........", &[(1.25, 1.25)]);
        let truths = (0..50).filter(|_| {
            world.step();
            world.take_truth().is_some()
        });
        assert_eq!(truths.count(), 10);
        drive(&mut world, 0, 0.5, 0.0, 0.02);
        assert!(world.take_truth().is_some_and(|truth| truth.bodies[0].tool_active));
    }
}
