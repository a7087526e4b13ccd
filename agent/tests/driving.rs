//! Stories on a stand-in base: a kinematic differential drive with noisy fixes.

use agent::{Agent, Input, Output};
use protocol::{Timestamp, v1};
use std::time::Duration;
use terrain::{MotionModel, Point};

const TICK: Duration = Duration::from_millis(20);
const BOOT: u64 = 77;

/// A robot that does what it is told within its limits.
struct StandIn {
    x: f64,
    y: f64,
    theta: f64,
    speed: f64,
    turning: f64,
    grip: f64,
    odometry: (f64, f64, f64),
    ticks: u64,
    noise: u64,
    wall_at_x: Option<f64>,
    motion: MotionModel,
}

impl StandIn {
    fn at(x: f64, y: f64, theta: f64) -> Self {
        Self {
            x,
            y,
            theta,
            speed: 0.0,
            turning: 0.0,
            grip: 1.0,
            odometry: (0.0, 0.0, 0.0),
            ticks: 0,
            noise: 1,
            wall_at_x: None,
            motion: motion(),
        }
    }

    /// Between -1 and 1, the same at each run.
    fn draw(&mut self) -> f64 {
        self.noise =
            self.noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.noise >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
    }

    fn step(&mut self, setpoint: &v1::Setpoint) {
        let dt = TICK.as_secs_f64();
        let towards = |from: f64, to: f64, by: f64| from + (to - from).clamp(-by, by);
        let (speed, turning) = (self.speed, self.turning);
        let (top, top_turn) = (self.motion.speed_m_per_s, self.motion.angular_speed_rad_per_s);
        let asked_turn = setpoint.angular_speed_rad_per_s.clamp(-top_turn, top_turn);
        self.speed =
            towards(speed, setpoint.speed_m_per_s.clamp(-top, top), self.motion.acceleration_m_per_s2 * dt);
        self.turning = towards(turning, asked_turn, self.motion.angular_acceleration_rad_per_s2 * dt);
        let way = f64::midpoint(speed, self.speed) * dt;
        let turn = f64::midpoint(turning, self.turning) * dt;
        let (odo_x, odo_y, odo_theta) = &mut self.odometry;
        *odo_x += way * (*odo_theta + turn / 2.0).cos();
        *odo_y += way * (*odo_theta + turn / 2.0).sin();
        *odo_theta += turn;
        let way = way * self.grip;
        self.x += way * (self.theta + turn / 2.0).cos();
        self.y += way * (self.theta + turn / 2.0).sin();
        self.theta += turn;
        self.ticks += 1;
    }

    fn measure(&mut self) -> v1::BaseState {
        let with_fix = self.ticks.is_multiple_of(5);
        let noise = [self.draw() * 0.005, self.draw() * 0.005, self.draw() * 0.003];
        let (odo_x, odo_y, odo_theta) = self.odometry;
        let pose = |x_m, y_m, theta_rad| Some(v1::Pose { x_m, y_m, theta_rad });
        v1::BaseState {
            sequence: self.ticks,
            time_ns: self.ticks * TICK.as_nanos() as u64,
            odometry: pose(odo_x, odo_y, odo_theta),
            fix_sequence: 1 + self.ticks / 5,
            fix: pose(self.x + noise[0], self.y + noise[1], self.theta + noise[2]),
            fix_deviation_m: 0.008,
            speed_m_per_s: self.speed,
            angular_speed_rad_per_s: self.turning,
            state_of_charge_percent: 80.0,
            description: self.ticks.is_multiple_of(50).then(|| description(&self.motion)),
            scan: with_fix.then(|| self.scan()),
            time_factor: 1.0,
            ..v1::BaseState::default()
        }
    }

    fn scan(&self) -> v1::RangeScan {
        let beams = 48;
        let increment = std::f64::consts::TAU / f64::from(beams);
        let ranges_m = (0..beams)
            .map(|beam| {
                let bearing = self.theta + increment * f64::from(beam);
                let to_wall = self.wall_at_x.map_or(f64::INFINITY, |wall| (wall - self.x) / bearing.cos());
                if to_wall > 0.0 { to_wall.min(3.0) as f32 } else { 3.0 }
            })
            .collect();
        v1::RangeScan { range_max_m: 3.0, angle_min_rad: 0.0, angle_increment_rad: increment, ranges_m }
    }
}

fn description(motion: &MotionModel) -> v1::Factsheet {
    v1::Factsheet {
        series_name: "stand-in".to_owned(),
        body_radius_m: 0.177,
        tool_width_m: 0.75,
        speed_max_m_per_s: motion.speed_m_per_s,
        acceleration_max_m_per_s2: motion.acceleration_m_per_s2,
        angular_speed_max_rad_per_s: motion.angular_speed_rad_per_s,
        angular_acceleration_max_rad_per_s2: motion.angular_acceleration_rad_per_s2,
        state_interval_ms: 100,
        range_finder_m: 3.0,
        battery_charging: Some(v1::BatteryCharging {
            critical_low_charging_level: 5.0,
            minimum_desired_charging_level: 20.0,
            sufficient_charging_level: 80.0,
            maximum_desired_charging_level: 95.0,
        }),
        energy_model: Some(v1::EnergyModel { capacity_wh: 100.0, ..v1::EnergyModel::default() }),
        ..v1::Factsheet::default()
    }
}

fn motion() -> MotionModel {
    MotionModel {
        speed_m_per_s: 0.5,
        acceleration_m_per_s2: 0.6,
        angular_speed_rad_per_s: 0.8,
        angular_acceleration_rad_per_s2: 2.0,
        brakes: true,
    }
}

/// An agent on its stand-in, with somebody who grants.
struct Story {
    agent: Agent,
    body: StandIn,
    now: Timestamp,
    granting: bool,
    released: u64,
    order: v1::Order,
    last: v1::State,
    reached_at: Vec<(u64, f64)>,
    farthest_off_m: f64,
    path: Vec<Point>,
}

impl Story {
    fn along(points: &[(f64, f64)]) -> Self {
        let path: Vec<Point> = points.iter().map(|&(x, y)| Point::new(x, y)).collect();
        let nodes = path
            .iter()
            .enumerate()
            .map(|(at, point)| v1::Node {
                sequence_id: at as u64 + 1,
                x_m: point.x,
                y_m: point.y,
                tool_active: true,
            })
            .collect();
        let order = v1::Order {
            term: 1,
            order_id: 5,
            order_update_id: 1,
            nodes,
            boot_id: BOOT,
            ..v1::Order::default()
        };
        Self {
            agent: Agent::new("r1", BOOT, 1),
            body: StandIn::at(points[0].0, points[0].1, 0.0),
            now: Timestamp::ZERO,
            granting: true,
            released: points.len() as u64,
            order,
            last: v1::State::default(),
            reached_at: Vec::new(),
            farthest_off_m: 0.0,
            path,
        }
    }

    fn run_for(&mut self, seconds: f64) {
        for _ in 0..(seconds / TICK.as_secs_f64()) as u64 {
            self.tick();
        }
    }

    fn tick(&mut self) {
        self.now = self.now + TICK;
        let measured = self.body.measure();
        let outputs = self.agent.handle(self.now, Input::Base(Box::new(measured)));
        for output in outputs {
            match output {
                Output::Setpoint(setpoint) => self.body.step(&setpoint),
                Output::State(state) => self.answer(*state),
                Output::Factsheet(_) | Output::Connection(_) => {}
            }
        }
        let off_m = self
            .path
            .windows(2)
            .map(|pair| {
                terrain::Segment::new(pair[0], pair[1])
                    .distance_to_point(Point::new(self.body.x, self.body.y))
            })
            .fold(f64::INFINITY, f64::min);
        self.farthest_off_m = self.farthest_off_m.max(off_m);
    }

    fn answer(&mut self, state: v1::State) {
        if state.order_id == 0 {
            self.agent.handle(self.now, Input::Order(Box::new(self.order.clone())));
        }
        if self.granting {
            let grant = v1::Grant {
                term: 1,
                epoch: 1,
                boot_id: BOOT,
                order_id: 5,
                order_update_id: 1,
                released_sequence_id: self.released,
                request_ns: state.request_ns,
                lease_ms: 3000,
                ..v1::Grant::default()
            };
            self.agent.handle(self.now, Input::Grant(grant));
        }
        if state.last_node_sequence_id > self.last.last_node_sequence_id {
            self.reached_at.push((state.last_node_sequence_id, self.now.as_secs_f64()));
        }
        self.last = state;
    }

    fn has(&self, kind: v1::ErrorType) -> bool {
        self.last.errors.iter().any(|error| error.error_type() == kind)
    }
}

#[test]
fn it_drives_around_corners_within_two_centimetres_and_in_the_planned_time() {
    let corners = [(0.0, 0.0), (4.0, 0.0), (4.0, 1.0), (0.0, 1.0), (0.0, 2.0), (4.0, 2.0)];
    let mut story = Story::along(&corners);
    let planned_s = motion().path_s(&story.path, Some(0.0));
    story.run_for(planned_s + 15.0);
    assert_eq!(story.last.last_node_sequence_id, 6);
    assert!(story.farthest_off_m < 0.02, "{} m off its path", story.farthest_off_m);
    let driven_s = story.reached_at.last().expect("it got somewhere").1 - 0.1;
    let ratio = driven_s / planned_s;
    assert!((0.99..1.02).contains(&ratio), "driven {driven_s:.2} s, planned {planned_s:.2} s");
}

#[test]
fn collinear_nodes_are_driven_through_without_stopping() {
    let places: Vec<(f64, f64)> = (0..13).map(|step| (0.5 * f64::from(step), 0.0)).collect();
    let mut story = Story::along(&places);
    story.run_for(20.0);
    let driven_s = story.reached_at.last().expect("it got somewhere").1 - 0.1;
    let planned_s = motion().run_s(6.0);
    assert!((driven_s / planned_s - 1.0).abs() < 0.02, "driven {driven_s:.2} s, planned {planned_s:.2} s");
}

#[test]
fn it_goes_no_further_than_its_base() {
    let places: Vec<(f64, f64)> = (0..13).map(|step| (0.5 * f64::from(step), 0.0)).collect();
    let mut story = Story::along(&places);
    story.released = 5;
    story.run_for(20.0);
    assert!((story.body.x - 2.0).abs() < 0.02, "stands at {} m", story.body.x);
    assert!(story.last.new_base_request);
    story.released = 9;
    story.run_for(20.0);
    assert!((story.body.x - 4.0).abs() < 0.02, "stands at {} m", story.body.x);
}

#[test]
fn without_a_lease_it_stops_and_goes_on_when_it_gets_one() {
    let mut story = Story::along(&[(0.0, 0.0), (20.0, 0.0)]);
    story.run_for(5.0);
    story.granting = false;
    story.run_for(5.0);
    assert!(story.body.speed == 0.0);
    assert!(story.has(v1::ErrorType::ReleaseLost));
    let stands_at = story.body.x;
    story.run_for(2.0);
    assert!((story.body.x - stands_at).abs() < 1e-9);
    story.granting = true;
    story.run_for(40.0);
    assert!((story.body.x - 20.0).abs() < 0.02);
}

#[test]
fn it_stops_before_an_obstacle_on_its_base_and_says_where() {
    let mut story = Story::along(&[(0.0, 0.0), (10.0, 0.0)]);
    story.body.wall_at_x = Some(3.0);
    story.run_for(20.0);
    assert!(story.body.x > 2.0 && story.body.x < 3.0 - 0.177, "stands at {}", story.body.x);
    assert!(story.has(v1::ErrorType::NodeUnreachable));
    let hit = &story.last.errors[0].points[0];
    assert!((hit.x_m - 3.0).abs() < 0.1, "{hit:?}");
    story.body.wall_at_x = None;
    story.run_for(25.0);
    assert!((story.body.x - 10.0).abs() < 0.02);
}

#[test]
fn slip_makes_the_sweep_untrusted() {
    let mut story = Story::along(&[(0.0, 0.0), (10.0, 0.0)]);
    story.granting = true;
    story.run_for(4.0);
    let before = story.last.sweep.iter().filter(|vertex| !vertex.trusted).count();
    assert_eq!(before, 0);
    story.body.grip = 0.4;
    story.run_for(3.0);
    assert!(story.has(v1::ErrorType::LocalizationError));
    assert!(story.last.sweep.iter().any(|vertex| !vertex.trusted));
}

#[test]
fn wheels_that_do_not_move_the_robot_are_reported_as_stuck() {
    let mut story = Story::along(&[(0.0, 0.0), (10.0, 0.0)]);
    story.body.grip = 0.0;
    story.run_for(6.0);
    assert!(story.has(v1::ErrorType::Stuck));
}

/// The default robot of a scenario: faster than the stand-in of the other stories.
const FAST: MotionModel = MotionModel {
    speed_m_per_s: 1.0,
    acceleration_m_per_s2: 0.8,
    angular_speed_rad_per_s: 1.5,
    angular_acceleration_rad_per_s2: 3.0,
    brakes: true,
};

/// Drives a line to its end by granting piece by piece, and tells how long it took, as a share of the plan.
fn drive_all(name: &str, points: &[(f64, f64)], motion: MotionModel) -> Story {
    let mut story = Story::along(points);
    story.body.motion = motion;
    let (from, to) = (story.path[0], story.path[1]);
    story.body.theta = (to.y - from.y).atan2(to.x - from.x);
    let planned_s = motion.path_s(&story.path, Some(story.body.theta));
    let mut ahead_m: Vec<f64> = vec![0.0];
    for pair in story.path.windows(2) {
        ahead_m.push(ahead_m[ahead_m.len() - 1] + (pair[1] - pair[0]).norm());
    }
    story.released = 1;
    while story.last.last_node_sequence_id < points.len() as u64 && story.now.as_secs_f64() < 2.0 * planned_s
    {
        let passed_m = ahead_m[(story.last.last_node_sequence_id.max(1) - 1) as usize];
        let granted = ahead_m.partition_point(|&way_m| way_m <= passed_m + 2.5) as u64;
        story.released = story.released.max(granted);
        story.run_for(0.1);
    }
    let driven_s = story.reached_at.last().expect("it got somewhere").1 - 0.1;
    let ratio = driven_s / planned_s;
    println!(
        "{name}: planned {planned_s:.2} s, driven {driven_s:.2} s, ratio {ratio:.4}, at most {:.4} m off",
        story.farthest_off_m
    );
    assert_eq!(story.last.last_node_sequence_id, points.len() as u64, "{name}: did not come to the end");
    assert!(story.farthest_off_m < 0.02, "{name}: {} m off its path", story.farthest_off_m);
    assert!((0.97..1.03).contains(&ratio), "{name}: driven {driven_s:.2} s, planned {planned_s:.2} s");
    story
}

fn sampled(count: u32, place: impl Fn(f64) -> (f64, f64)) -> Vec<(f64, f64)> {
    (0..=count).map(|at| place(f64::from(at) / f64::from(count))).collect()
}

#[test]
fn circles_are_driven_without_stopping_and_within_two_centimetres() {
    use std::f64::consts::TAU;
    for radius in [0.3, 0.6, 2.0] {
        for spacing in [0.06, 0.2_f64] {
            let count = (2.0 * TAU * radius / spacing.min(0.4 * radius)) as u32;
            let circle = sampled(count, |share| {
                let at = 2.0 * TAU * share;
                (radius * at.sin(), radius * (1.0 - at.cos()))
            });
            for motion in [motion(), FAST] {
                drive_all(&format!("circle of {radius} m, a point each {spacing} m"), &circle, motion);
            }
        }
    }
}

#[test]
fn a_spiral_is_driven_to_its_middle() {
    use std::f64::consts::TAU;
    let spiral = sampled(700, |share| {
        let (at, radius) = (5.0 * TAU * share, 2.4 - 2.1 * share);
        (radius * at.cos(), radius * at.sin())
    });
    for motion in [motion(), FAST] {
        drive_all("spiral", &spiral, motion);
    }
}

#[test]
fn an_s_curve_with_straight_ends_is_driven_through() {
    let mut curve: Vec<(f64, f64)> = (-6..0).map(|at| (0.5 * f64::from(at), 0.0)).collect();
    curve.extend(sampled(160, |share| {
        (8.0 * share, 0.5 * (1.0 - (4.0 * std::f64::consts::PI * share).cos()))
    }));
    curve.extend((1..7).map(|at| (8.0 + 0.5 * f64::from(at), 0.0)));
    for motion in [motion(), FAST] {
        drive_all("s-curve", &curve, motion);
    }
}

#[test]
fn a_line_and_an_arc_meet_without_a_stop() {
    use std::f64::consts::FRAC_PI_2;
    let mut curve: Vec<(f64, f64)> = (0..20).map(|at| (0.25 * f64::from(at), 0.0)).collect();
    curve.extend(sampled(24, |share| {
        let at = 2.0 * FRAC_PI_2 * share;
        (5.0 + 0.35 * at.sin(), 0.35 * (1.0 - at.cos()))
    }));
    curve.extend((1..20).map(|at| (5.0 - 0.25 * f64::from(at), 0.7)));
    for motion in [motion(), FAST] {
        drive_all("u-turn", &curve, motion);
    }
}

#[test]
fn a_long_zig_zag_of_gentle_bends_and_sharp_corners_is_driven_as_planned() {
    let gentle: Vec<(f64, f64)> = (0..30).map(|at| (f64::from(at), 0.2 * f64::from(at % 2))).collect();
    let sharp: Vec<(f64, f64)> = (0..12).map(|at| (0.35 * f64::from(at), 2.0 * f64::from(at % 2))).collect();
    for motion in [motion(), FAST] {
        drive_all("gentle zig-zag", &gentle, motion);
        drive_all("sharp zig-zag", &sharp, motion);
    }
}

#[test]
fn a_corner_shortly_before_a_bend_is_not_cut() {
    use std::f64::consts::FRAC_PI_2;
    let mut curve = vec![(-0.063, -0.083), (0.0, 0.0), (0.0, 0.5), (0.0, 0.75)];
    curve.extend(sampled(8, |share| {
        let at = FRAC_PI_2 * share;
        (0.25 * (1.0 - at.cos()), 0.75 + 0.25 * at.sin())
    }));
    curve.extend((1..9).map(|at| (0.5 * f64::from(at), 1.0)));
    for motion in [motion(), FAST] {
        drive_all("corner and bend", &curve, motion);
    }
}

#[test]
fn a_spur_to_the_side_is_driven_to_its_tip() {
    let spur = [(0.0, 0.0), (2.0, 0.0), (2.0, 0.05), (2.0, 0.09), (2.0, 0.0), (3.0, 0.0)];
    let mut story = Story::along(&spur);
    let mut highest_m = 0.0_f64;
    while story.last.last_node_sequence_id < 5 && story.now.as_secs_f64() < 60.0 {
        story.tick();
        highest_m = highest_m.max(story.body.y);
    }
    assert!((0.07..0.11).contains(&highest_m), "{highest_m} m");
}

#[test]
fn in_a_bend_it_stops_on_the_line_and_goes_on() {
    use std::f64::consts::TAU;
    let circle = sampled(120, |share| (1.0 * (TAU * share).sin(), 1.0 - (TAU * share).cos()));
    let mut story = Story::along(&circle);
    story.body.motion = FAST;
    story.run_for(4.0);
    assert!(story.body.speed > 0.8);
    story.granting = false;
    story.run_for(5.0);
    assert!(story.body.speed == 0.0 && story.farthest_off_m < 0.02, "{} m off", story.farthest_off_m);
    story.granting = true;
    story.run_for(10.0);
    assert_eq!(story.last.last_node_sequence_id, 121);
    assert!(story.farthest_off_m < 0.02, "{} m off", story.farthest_off_m);
}

#[test]
fn in_a_bend_it_goes_no_further_than_its_base() {
    use std::f64::consts::TAU;
    let circle = sampled(120, |share| (1.0 * (TAU * share).sin(), 1.0 - (TAU * share).cos()));
    let mut story = Story::along(&circle);
    story.body.motion = FAST;
    story.released = 31;
    story.run_for(8.0);
    let end = story.path[30];
    assert!((Point::new(story.body.x, story.body.y) - end).norm() < 0.02);
    assert!(story.farthest_off_m < 0.02);
}
