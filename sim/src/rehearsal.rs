//! The whole fleet in one thread on a virtual clock: world, agents and coordinator, with a network between them
//! that is as good or bad as the scenario says. The cores are the very same that run as processes.
//!
//! ```text
//!   each 20 ms:  world.step ─▶ processes (kill, hang, …) ─▶ network ─┬▶ agents ─▶ setpoints ─▶ world
//!                                                                    └▶ coordinator ─▶ orders, grants ─▶ network
//!                checkers look at contacts, at what the coordinator says, and at the end
//! ```
//!
//! Same scenario and seed: same transcript and same records, byte by byte. Planning takes no virtual time of its
//! own; it is charged with [`Options::planning`].

use crate::{
    checkers::{Checkers, Seen, Violation},
    faults::ProcessAction,
    network::{self, Network},
    random_streams::stream,
    scenario::Scenario,
    session::Process,
    transcript::Transcript,
    world::World,
};
use agent::Agent;
use coordinator::{Coordinator, PlanRequest, Publication, recorder::Record};
use planner::{PlanError, VerifiedPlan};
use protocol::{Timestamp, v1};
use rand::RngExt;
use std::sync::Arc;
use std::time::Duration;
use terrain::FloorError;

/// After the mission's end the world goes on for this long, so that the last truth is on record.
const EPILOGUE: Duration = Duration::from_millis(300);

/// Between two notes of the covered share.
const PROGRESS_EVERY_S: f64 = 10.0;

/// Break-offs come when so many times a plan's virtual time has passed.
const BREAK_OFFS_TAKE: u32 = 4;

/// How to rehearse.
#[derive(Debug, Clone)]
pub struct Options {
    /// Virtual time that each plan takes.
    pub planning: Duration,
    /// Answers the coordinator's requests.
    pub planner: fn(&PlanRequest) -> Result<VerifiedPlan, PlanError>,
    /// The run is given up after this much virtual time, seconds.
    pub virtual_max_s: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { planning: Duration::from_millis(50), planner: PlanRequest::run, virtual_max_s: 6.0 * 3600.0 }
    }
}

/// What came of a rehearsal.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The seed it was run with.
    pub seed: u64,
    /// How the mission ended; `None` when it did not.
    pub result: Option<v1::MissionResult>,
    /// The story.
    pub transcript: Transcript,
    /// What must not be.
    pub violations: Vec<Violation>,
    /// Virtual time that passed, seconds.
    pub virtual_s: f64,
    /// Contacts that the world saw.
    pub contacts: u32,
    /// Faults that were carried out.
    pub faults: u32,
    /// Robots that stood on the floor with an empty battery at some time.
    pub stranded: Vec<String>,
    /// Covered share over time: seconds and percent, in steps of ten seconds.
    pub progress: Vec<(f64, f64)>,
}

/// Takes what is to be logged, in the order of time.
pub type Sink<'a> = &'a mut dyn FnMut(Timestamp, &Record);

/// What goes over the network.
#[derive(Debug, Clone)]
enum Letter {
    Up(Upward),
    Down(agent::Input),
}

#[derive(Debug, Clone)]
enum Upward {
    State(Box<v1::State>),
    Factsheet(Box<v1::Factsheet>),
    Connection(v1::Connection),
}

/// One agent's process.
struct AgentProcess {
    agent: Option<Agent>,
    frozen: bool,
    /// What waits in its socket while it hangs.
    mailbox: Vec<agent::Input>,
    boots: u64,
    boot_id: u64,
    /// Its clock began to run this much before the world's.
    clock_ahead: Duration,
}

/// A rehearsal under way.
pub struct Rehearsal<'a> {
    world: World,
    coordinator: Coordinator,
    agents: Vec<AgentProcess>,
    network: Network<Letter>,
    planned: Vec<(Timestamp, coordinator::Input)>,
    checkers: Checkers,
    transcript: Transcript,
    sink: Option<Sink<'a>>,
    options: Options,
    seed: u64,
    result: Option<v1::MissionResult>,
    contacts: u32,
    faults: u32,
    progress: Vec<(f64, f64)>,
}

impl<'a> Rehearsal<'a> {
    /// Plays a scenario to its end.
    ///
    /// # Errors
    ///
    /// [`FloorError`] when the coordinator cannot lay out its floor.
    pub fn run(
        scenario: &Arc<Scenario>,
        seed: u64,
        options: Options,
        sink: Option<Sink<'a>>,
    ) -> Result<Outcome, FloorError> {
        let mut rehearsal = Self::new(scenario, seed, options, sink)?;
        let end = Timestamp::from_secs_f64(rehearsal.options.virtual_max_s);
        while rehearsal.result.is_none() && rehearsal.world.now() < end {
            rehearsal.step();
        }
        let epilogue = rehearsal.world.now() + EPILOGUE;
        while rehearsal.world.now() < epilogue {
            rehearsal.step();
        }
        Ok(rehearsal.finish())
    }

    fn new(
        scenario: &Arc<Scenario>,
        seed: u64,
        options: Options,
        sink: Option<Sink<'a>>,
    ) -> Result<Self, FloorError> {
        let mut config = scenario.coordinator_config(1);
        config.seed = seed;
        let ids = config.mission.robots.clone();
        let process = |id: &String| AgentProcess {
            agent: None,
            frozen: false,
            mailbox: Vec::new(),
            boots: 0,
            boot_id: 0,
            clock_ahead: Duration::from_secs(stream(seed, "clock", id).random_range(0..1_000_000)),
        };
        let mut rehearsal = Self {
            world: World::new(scenario, seed),
            coordinator: Coordinator::new(config)?,
            agents: ids.iter().map(process).collect(),
            network: Network::new(scenario.file.network.clone(), seed, &ids),
            planned: Vec::new(),
            checkers: Checkers::new(),
            transcript: Transcript::default(),
            sink,
            options,
            seed,
            result: None,
            contacts: 0,
            faults: 0,
            progress: Vec::new(),
        };
        for robot in 0..ids.len() {
            rehearsal.start(robot);
        }
        Ok(rehearsal)
    }

    fn step(&mut self) {
        self.world.step();
        self.run_processes();
        self.carry_letters();
        self.drive_agents();
        self.let_coordinator_work();
        self.listen_to_world();
    }

    fn now(&self) -> Timestamp {
        self.world.now()
    }

    fn start(&mut self, robot: usize) {
        let process = &mut self.agents[robot];
        process.boots += 1;
        let id = self.world.robot_id(robot);
        process.boot_id = stream(self.seed, "boot", &format!("{id}/{}", process.boots)).random::<u64>() | 1;
        process.agent = Some(Agent::new(id, process.boot_id, 1000 + robot as u32));
        process.frozen = false;
        process.mailbox.clear();
        self.set_process(robot, Process::Running);
    }

    fn set_process(&mut self, robot: usize, process: Process) {
        self.network.handle(self.world.now(), network::Input::Process { robot, process });
    }

    fn run_processes(&mut self) {
        for action in self.world.take_process_actions() {
            self.act(&action);
        }
        for robot in 0..self.agents.len() {
            let cut = self.world.is_radio_jammed(robot);
            self.network.handle(self.world.now(), network::Input::Cut { robot, cut });
        }
    }

    fn act(&mut self, action: &ProcessAction) {
        let (ProcessAction::Kill(id)
        | ProcessAction::Hang(id)
        | ProcessAction::Thaw(id)
        | ProcessAction::Restart(id)) = action;
        let robot = self.world.robot_index(id).expect("faults name robots that exist");
        let runs = self.agents[robot].agent.is_some();
        match action {
            ProcessAction::Kill(_) => {
                self.agents[robot].agent = None;
                self.set_process(robot, Process::Dead);
            }
            ProcessAction::Hang(_) if runs => {
                self.agents[robot].frozen = true;
                self.set_process(robot, Process::Frozen);
            }
            ProcessAction::Thaw(_) if runs && self.agents[robot].frozen => self.thaw(robot),
            ProcessAction::Restart(_) if !runs => self.start(robot),
            ProcessAction::Hang(_) | ProcessAction::Thaw(_) | ProcessAction::Restart(_) => {}
        }
    }

    /// A thawed agent first reads what waited in its socket, however old.
    fn thaw(&mut self, robot: usize) {
        self.agents[robot].frozen = false;
        self.set_process(robot, Process::Running);
        for input in std::mem::take(&mut self.agents[robot].mailbox) {
            self.tell_agent(robot, input);
        }
    }

    fn carry_letters(&mut self) {
        for output in self.network.handle(self.now(), network::Input::Woken) {
            match output {
                network::Output::Session { robot, open } => self.session_changed(robot, open),
                network::Output::Deliver { robot, letter: Letter::Down(input) } => {
                    if self.agents[robot].frozen {
                        self.agents[robot].mailbox.push(input);
                    } else {
                        self.tell_agent(robot, input);
                    }
                }
                network::Output::Deliver { letter: Letter::Up(letter), .. } => self.tell_coordinator(letter),
            }
        }
    }

    fn session_changed(&mut self, robot: usize, open: bool) {
        let id = self.world.robot_id(robot).to_owned();
        let boot_id = self.agents[robot].boot_id;
        let input = if open {
            coordinator::Input::Alive { robot: id, boot_id }
        } else {
            coordinator::Input::Gone { robot: id, boot_id }
        };
        self.handle_coordinator(input);
        self.tell_agent(robot, agent::Input::Link(open));
    }

    fn tell_coordinator(&mut self, letter: Upward) {
        let input = match letter {
            Upward::State(state) => {
                self.record(|| Record::State(state.clone()));
                coordinator::Input::State(state)
            }
            Upward::Factsheet(sheet) => {
                self.record(|| Record::Factsheet(sheet.clone()));
                coordinator::Input::Factsheet(sheet)
            }
            Upward::Connection(connection) => {
                self.record(|| Record::Connection(connection.clone()));
                coordinator::Input::Connection(connection)
            }
        };
        self.handle_coordinator(input);
    }

    fn drive_agents(&mut self) {
        for robot in 0..self.agents.len() {
            let base = self.world.base_state(robot);
            if self.agents[robot].agent.is_some() && !self.agents[robot].frozen {
                self.tell_agent(robot, agent::Input::Base(Box::new(base)));
            }
        }
    }

    fn tell_agent(&mut self, robot: usize, input: agent::Input) {
        let now = self.now();
        let process = &mut self.agents[robot];
        if process.frozen {
            return;
        }
        let Some(agent) = &mut process.agent else { return };
        for output in agent.handle(now + process.clock_ahead, input) {
            let letter = match output {
                agent::Output::Setpoint(setpoint) => {
                    self.world.setpoint(robot, &setpoint);
                    continue;
                }
                agent::Output::State(state) => Upward::State(state),
                agent::Output::Factsheet(sheet) => Upward::Factsheet(sheet),
                agent::Output::Connection(connection) => Upward::Connection(connection),
            };
            self.network.handle(now, network::Input::Send { robot, letter: Letter::Up(letter) });
        }
    }

    fn let_coordinator_work(&mut self) {
        let now = self.now();
        while let Some(at) = self.planned.iter().position(|&(at, _)| at <= now) {
            let (_, input) = self.planned.remove(at);
            self.handle_coordinator(input);
        }
        if self.coordinator.next_wakeup().is_some_and(|(at, _)| at <= now) {
            self.handle_coordinator(coordinator::Input::Woken);
        }
    }

    fn handle_coordinator(&mut self, input: coordinator::Input) {
        for output in self.coordinator.handle(self.now(), input) {
            match output {
                coordinator::Output::Order { robot, order } => {
                    self.record(|| Record::Order { robot: robot.clone(), order: order.clone() });
                    self.send_down(&robot, agent::Input::Order(Box::new(order)));
                }
                coordinator::Output::Grant { robot, grant } => {
                    self.record(|| Record::Grant { robot: robot.clone(), grant });
                    self.send_down(&robot, agent::Input::Grant(grant));
                }
                coordinator::Output::InstantActions { robot, actions } => {
                    self.record(|| Record::InstantActions { robot: robot.clone(), actions: actions.clone() });
                    self.send_down(&robot, agent::Input::InstantActions(actions));
                }
                coordinator::Output::Plan(request) => {
                    let planning_s = self.options.planning.as_secs_f64();
                    let answer = coordinator::Input::Planned {
                        revision: request.revision,
                        result: (self.options.planner)(&request),
                        planning_s,
                    };
                    self.planned.push((self.now() + self.options.planning, answer));
                }
                coordinator::Output::BreakOffs(request) => {
                    let answer =
                        coordinator::Input::BrokenOff { revision: request.revision, breaks: request.run() };
                    self.planned.push((self.now() + self.options.planning * BREAK_OFFS_TAKE, answer));
                }
                coordinator::Output::Publish(publication) => self.publish(publication),
                coordinator::Output::Reply(_) => {}
            }
        }
    }

    fn send_down(&mut self, id: &str, input: agent::Input) {
        let Some(robot) = self.world.robot_index(id) else { return };
        let letter = Letter::Down(input);
        self.network.handle(self.world.now(), network::Input::Send { robot, letter });
    }

    fn publish(&mut self, publication: Publication) {
        let now = self.now();
        self.transcript.publication(now, &publication);
        self.checkers.look(&mut self.world, &Seen::Publication(&publication));
        if let Publication::Status(status) = &publication {
            let covered = status.progress.as_ref().map_or(0.0, |progress| progress.covered_percent);
            self.world.tell_covered(covered);
            self.note_progress(now, covered);
        }
        if let Publication::Result(result) = &publication {
            self.result.get_or_insert_with(|| result.clone());
        }
        self.record(|| Record::Publication(publication));
    }

    fn note_progress(&mut self, now: Timestamp, covered_percent: f64) {
        let due_s = self.progress.last().map_or(0.0, |&(at_s, _)| at_s + PROGRESS_EVERY_S);
        if now.as_secs_f64() >= due_s {
            self.progress.push((now.as_secs_f64(), covered_percent));
        }
    }

    fn listen_to_world(&mut self) {
        let now = self.now();
        for contact in self.world.take_contacts() {
            self.contacts += 1;
            self.transcript.contact(now, &contact);
            self.checkers.look(&mut self.world, &Seen::Contact(&contact));
            self.record(|| Record::Contact(contact));
        }
        for fault in self.world.take_faults() {
            self.faults += 1;
            self.transcript.fault(now, &fault);
            self.record(|| Record::Fault(fault));
        }
        if self.sink.is_some()
            && let Some(truth) = self.world.take_truth()
        {
            self.record(|| Record::Truth(Box::new(truth)));
        }
    }

    fn record(&mut self, record: impl FnOnce() -> Record) {
        let now = self.world.now();
        if let Some(sink) = &mut self.sink {
            sink(now, &record());
        }
    }

    fn finish(mut self) -> Outcome {
        let healthy: Vec<bool> = (0..self.agents.len()).map(|robot| self.is_healthy(robot)).collect();
        let result = self.result.take();
        self.checkers.look(&mut self.world, &Seen::End { result: result.as_ref(), healthy: &healthy });
        Outcome {
            seed: self.seed,
            result,
            transcript: self.transcript,
            violations: self.checkers.into_violations(),
            virtual_s: self.world.now().as_secs_f64(),
            contacts: self.contacts,
            faults: self.faults,
            stranded: self.world.take_stranded(),
            progress: self.progress,
        }
    }

    /// Alive, connected, on its wheels, and with charge to spare.
    fn is_healthy(&self, robot: usize) -> bool {
        let process = &self.agents[robot];
        process.agent.is_some()
            && !process.frozen
            && self.network.has_session(robot)
            && self.world.can_drive(robot)
    }
}
