//! What goes wrong: one file per kind, one name in [`faults!`].
//!
//! A fault is the same table everywhere: in a scenario file (`[[fault]]`, with `at_s` or `when_covered_percent`),
//! on a running fleet (`oxplow fault KIND …`), and in a rehearsal's random stories. What befalls the world happens
//! at once; what befalls a process ([`ProcessAction`]) is left to whoever runs the processes.

use crate::{scenario::Scenario, world::World};
use protocol::Timestamp;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, de::Error};
use std::time::Duration;

/// One kind of fault.
pub(crate) trait FaultKind {
    /// Whom or what it befalls.
    fn target(&self) -> String;

    /// Whether it makes sense in this scenario: `Err` says which key is wrong, and what to do.
    fn check(&self, scenario: &Scenario) -> Result<(), String>;

    /// Lets it happen. `Some` is what is told about it; `None` when it is told later.
    fn inject(&self, world: &mut World) -> Option<String>;

    /// Draws one.
    fn random(rng: &mut ChaCha8Rng, scenario: &Scenario) -> Self
    where
        Self: Sized;
}

macro_rules! faults {
    ($($kind:ident: $Kind:ident),* $(,)?) => {
        $(mod $kind; pub use $kind::$Kind;)*

        /// What goes wrong.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(tag = "kind", rename_all = "snake_case")]
        pub enum Fault {
            $(#[allow(missing_docs, reason = "documented at its type")] $Kind($Kind),)*
        }

        impl Fault {
            /// The names of all kinds.
            pub const KINDS: &'static [&'static str] = &[$(stringify!($kind)),*];

            /// The name of its kind.
            pub fn kind(&self) -> &'static str {
                match self { $(Self::$Kind(_) => stringify!($kind),)* }
            }

            fn as_kind(&self) -> &dyn FaultKind {
                match self { $(Self::$Kind(fault) => fault,)* }
            }

            /// Draws a fault of the kind with this name.
            pub(crate) fn random(kind: &str, rng: &mut ChaCha8Rng, scenario: &Scenario) -> Self {
                $(if kind == stringify!($kind) { return Self::$Kind($Kind::random(rng, scenario)); })*
                unreachable!("`{kind}` is one of KINDS")
            }
        }
    };
}

faults![
    kill: Kill,
    hang: Hang,
    thaw: Thaw,
    restart: Restart,
    cut_link: CutLink,
    block: Block,
    people: People,
    queue: Queue,
    battery_drop: BatteryDrop,
    battery_drain: BatteryDrain,
    wheel_stuck: WheelStuck,
    wheel_slip: WheelSlip,
    slow: Slow,
    station_out_of_order: StationOutOfOrder,
];

pub(crate) use block::Delivery;
pub use people::WalkKind;

/// What is to be done to a process.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ProcessAction {
    /// SIGKILL the agent of this robot.
    Kill(String),
    /// SIGSTOP it.
    Hang(String),
    /// SIGCONT it.
    Thaw(String),
    /// Start it anew.
    Restart(String),
}

/// One `[[fault]]`: what, and when.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct FaultEntry {
    /// When, seconds after the start.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_s: Option<f64>,
    /// When so much is covered, percent of what can be covered.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub when_covered_percent: Option<f64>,
    /// What.
    #[serde(flatten)]
    pub fault: Fault,
}

/// By hand, since neither unknown keys nor good messages survive `flatten`.
impl<'de> Deserialize<'de> for FaultEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut table = toml::Table::deserialize(deserializer)?;
        let mut number = |key: &str| match table.remove(key) {
            None => Ok(None),
            Some(toml::Value::Float(value)) => Ok(Some(value)),
            Some(toml::Value::Integer(value)) => Ok(Some(value as f64)),
            Some(other) => Err(D::Error::custom(format!("`{key}` is {other}; expected a number"))),
        };
        let (at_s, when_covered_percent) = (number("at_s")?, number("when_covered_percent")?);
        let known = table.get("kind").and_then(toml::Value::as_str);
        if !known.is_some_and(|kind| Fault::KINDS.contains(&kind)) {
            let kinds = Fault::KINDS.join(", ");
            let said = known.map_or("none given".to_owned(), |kind| format!("`{kind}`"));
            return Err(D::Error::custom(format!("unknown `kind` of fault ({said}); there are: {kinds}")));
        }
        let fault = Fault::deserialize(table).map_err(|error| D::Error::custom(error.message()))?;
        Ok(Self { at_s, when_covered_percent, fault })
    }
}

impl FaultEntry {
    /// Whether it makes sense in this scenario.
    pub(crate) fn check(&self, scenario: &Scenario) -> Result<(), String> {
        match (self.at_s, self.when_covered_percent) {
            (Some(_), Some(_)) => return Err("`at_s` or `when_covered_percent`, not both".to_owned()),
            (Some(at_s), None) => number("at_s", at_s, 0.0, 1e6)?,
            (None, Some(percent)) => number("when_covered_percent", percent, 0.0, 100.0)?,
            (None, None) => return Err("say when: `at_s` or `when_covered_percent`".to_owned()),
        }
        self.fault.check(scenario)
    }
}

impl Fault {
    /// Whom or what it befalls.
    pub fn target(&self) -> String {
        self.as_kind().target()
    }

    pub(crate) fn check(&self, scenario: &Scenario) -> Result<(), String> {
        self.as_kind().check(scenario)
    }
}

impl World {
    /// Lets a fault happen now.
    ///
    /// # Errors
    ///
    /// Why it makes no sense in this world, and what to do.
    pub fn inject(&mut self, fault: &Fault) -> Result<(), String> {
        fault.check(&self.scenario.clone())?;
        if let Some(text) = fault.as_kind().inject(self) {
            self.tell(fault.kind(), &fault.target(), &text);
        }
        Ok(())
    }

    /// A fault by command: the TOML of one `[[fault]]` table; without a time it happens now.
    ///
    /// # Errors
    ///
    /// Why it is refused, and what to do.
    pub fn command(&mut self, text: &str) -> Result<(), String> {
        let entry: FaultEntry = toml::from_str(text).map_err(|error| error.message().to_owned())?;
        if entry.at_s.is_none() && entry.when_covered_percent.is_none() {
            return self.inject(&entry.fault);
        }
        entry.check(&self.scenario.clone())?;
        self.plot.push(entry);
        Ok(())
    }

    /// How much is covered by now, for faults that wait for it.
    pub fn tell_covered(&mut self, percent: f64) {
        self.covered_percent = percent;
    }

    /// What is to be done to processes now.
    pub fn take_process_actions(&mut self) -> Vec<ProcessAction> {
        let now = self.now;
        let (due, later) = std::mem::take(&mut self.agenda).into_iter().partition(|&(at, _)| at <= now);
        self.agenda = later;
        due.into_iter().map(|(_, action)| action).collect()
    }

    /// Lets everything happen whose time has come.
    pub(crate) fn follow_plot(&mut self) {
        if self.plot.is_empty() {
            return;
        }
        let (now_s, covered) = (self.now.as_secs_f64(), self.covered_percent);
        let is_due = |entry: &FaultEntry| {
            entry.at_s.is_some_and(|at_s| now_s >= at_s)
                || entry.when_covered_percent.is_some_and(|percent| covered >= percent)
        };
        let (due, later) = std::mem::take(&mut self.plot).into_iter().partition(is_due);
        self.plot = later;
        for entry in due {
            self.inject(&entry.fault).expect("faults of a scenario were checked when it was read");
        }
    }

    pub(crate) fn ask(&mut self, after_s: f64, action: ProcessAction) {
        self.agenda.push((self.now + Duration::from_secs_f64(after_s), action));
    }

    pub(crate) fn body_of(&mut self, robot: &str) -> &mut crate::body::Body {
        let index = self.robot_index(robot).expect("the fault was checked");
        &mut self.bodies[index]
    }

    pub(crate) fn after(&self, for_s: Option<f64>) -> Option<Timestamp> {
        for_s.map(|seconds| self.now + Duration::from_secs_f64(seconds))
    }
}

fn robot(scenario: &Scenario, id: &str) -> Result<(), String> {
    let ids = || scenario.file.robots.iter().map(|robot| robot.id.as_str());
    if ids().any(|other| other == id) {
        return Ok(());
    }
    Err(format!("`robot` is `{id}`; there are: {}", ids().collect::<Vec<_>>().join(", ")))
}

fn number(key: &str, value: f64, min: f64, max: f64) -> Result<(), String> {
    if value >= min && value <= max {
        Ok(())
    } else {
        Err(format!("`{key}` is {value}; expected a number from {min} to {max}"))
    }
}

fn for_a_while(for_s: Option<f64>) -> Result<(), String> {
    for_s.map_or(Ok(()), |seconds| number("for_s", seconds, 0.0, 1e6))
}

fn how_long(for_s: Option<f64>) -> String {
    for_s.map_or_else(|| "from now on".to_owned(), |seconds| format!("for {seconds:.0} s"))
}

fn any_robot(rng: &mut ChaCha8Rng, scenario: &Scenario) -> String {
    let robots = &scenario.file.robots;
    robots[rng.random_range(0..robots.len())].id.clone()
}

/// A number between two, to one tenth.
fn between(rng: &mut ChaCha8Rng, min: f64, max: f64) -> f64 {
    ((min + (max - min) * rng.random::<f64>()) * 10.0).round() / 10.0
}

fn now_and_then(rng: &mut ChaCha8Rng, min: f64, max: f64) -> Option<f64> {
    let seconds = between(rng, min, max);
    rng.random_bool(0.75).then_some(seconds)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{random_streams::stream, testing};
    use protocol::v1;

    const HALL: &str = "..........\n..........\n..........";

    fn world() -> World {
        testing::world(HALL, &[(1.25, 1.25), (5.25, 1.25)])
    }

    fn wait(world: &mut World, seconds: f64) {
        for _ in 0..(seconds * 50.0) as usize {
            world.step();
        }
    }

    #[test]
    fn every_kind_survives_a_round_through_toml() {
        let scenario = testing::scenario(HALL, &[(1.25, 1.25)]);
        for kind in Fault::KINDS {
            for draw in 0..20 {
                let fault = Fault::random(kind, &mut stream(draw, "test", kind), &scenario);
                assert_eq!(fault.check(&scenario), Ok(()), "{fault:?}");
                let entry = FaultEntry { at_s: Some(2.0), when_covered_percent: None, fault };
                let text = toml::to_string(&entry).unwrap();
                assert_eq!(toml::from_str::<FaultEntry>(&text).unwrap(), entry, "{text}");
            }
        }
    }

    #[test]
    fn unknown_kinds_keys_and_robots_are_refused_with_what_there_is() {
        let refusal = |text: &str| world().command(text).unwrap_err();
        assert!(refusal("kind = \"flood\"").contains("there are: kill, hang"));
        assert!(refusal("kind = \"kill\"\nrobot = \"r1\"\nsped = 1").contains("sped"));
        assert!(refusal("kind = \"kill\"\nrobot = \"r9\"").contains("there are: r1, r2"));
        assert!(refusal("kind = \"slow\"\nrobot = \"r1\"\nfactor = nan").contains("factor"));
        assert!(refusal("kind = \"block\"\nx_m = 1\ny_m = 1").contains("radius_m"));
    }

    #[test]
    fn process_faults_are_left_to_whoever_runs_the_processes() {
        let mut world = world();
        world.command("kind = \"hang\"\nrobot = \"r2\"\nfor_s = 1.0").unwrap();
        assert_eq!(world.take_process_actions(), [ProcessAction::Hang("r2".to_owned())]);
        wait(&mut world, 0.5);
        assert_eq!(world.take_process_actions(), []);
        wait(&mut world, 0.5);
        assert_eq!(world.take_process_actions(), [ProcessAction::Thaw("r2".to_owned())]);
    }

    #[test]
    fn a_fault_waits_for_its_time_or_for_coverage() {
        let mut world = world();
        world.command("kind = \"kill\"\nrobot = \"r1\"\nat_s = 2").unwrap();
        world.command("kind = \"kill\"\nrobot = \"r2\"\nwhen_covered_percent = 50").unwrap();
        wait(&mut world, 1.9);
        assert_eq!(world.take_process_actions(), []);
        wait(&mut world, 0.2);
        assert_eq!(world.take_process_actions(), [ProcessAction::Kill("r1".to_owned())]);
        world.tell_covered(51.0);
        wait(&mut world, 0.02);
        assert_eq!(world.take_process_actions(), [ProcessAction::Kill("r2".to_owned())]);
    }

    #[test]
    fn a_blockage_waits_until_no_robot_is_in_its_place_and_goes_again() {
        let mut world = world();
        world.command("kind = \"block\"\nx_m = 1.25\ny_m = 1.25\nradius_m = 0.3\nfor_s = 5").unwrap();
        wait(&mut world, 1.0);
        assert!(world.obstacles.is_empty());
        testing::drive(&mut world, 0, 0.0, 1.0, 2.0);
        testing::drive(&mut world, 0, 0.5, 0.0, 4.0);
        wait(&mut world, 1.0);
        assert_eq!(world.obstacles.len(), 1);
        wait(&mut world, 5.1);
        assert!(world.obstacles.is_empty());
    }

    #[test]
    fn a_robot_is_stopped_by_a_blockage() {
        let mut world = world();
        world.command("kind = \"block\"\nx_m = 3.25\ny_m = 1.25\nwidth_m = 0.5\nheight_m = 2.0").unwrap();
        testing::drive(&mut world, 0, 1.0, 0.0, 4.0);
        let contacts = world.take_contacts();
        assert_eq!((contacts.len(), contacts[0].other.as_str()), (1, "blockage-1"));
        assert!(world.bodies[0].position().x < 3.0 - world.body_radius_m());
    }

    #[test]
    fn a_queue_stands_where_it_is_told_then_moves_and_goes() {
        let mut world = world();
        let text = "kind = \"queue\"\nx_m = 8.5\ny_m = 0.5\ntheta_deg = 90\ncount = 3\nmoves_after_s = 5\nfor_s = 20";
        world.command(text).unwrap();
        let places = |world: &World| -> Vec<(f64, f64)> {
            let round = |value: f64| (value * 100.0).round() / 100.0;
            world.people.iter().map(|person| (round(person.position.x), round(person.position.y))).collect()
        };
        wait(&mut world, 4.0);
        let queue = [(8.5, 0.5), (8.5, 1.3), (8.5, 2.1)];
        assert_eq!(places(&world), queue);
        wait(&mut world, 4.0);
        assert!(places(&world).iter().zip(&queue).all(|(now, before)| now != before), "{:?}", places(&world));
        wait(&mut world, 13.0);
        assert!(world.people.is_empty());
        let refusal = world.command(&text.replace("count = 3", "count = 4")).unwrap_err();
        assert!(refusal.contains("person 4 of the queue would stand in a wall"), "{refusal}");
    }

    fn driven_m(fault: &str) -> (f64, f64, v1::BaseState) {
        let mut world = world();
        world.command(fault).unwrap();
        testing::drive(&mut world, 0, 0.5, 0.0, 4.0);
        let state = world.base_state(0);
        (world.bodies[0].position().x - 1.25, state.odometry.unwrap().x_m - 1.25, state)
    }

    #[test]
    fn stuck_and_slipping_wheels_fool_the_odometry_and_a_slow_robot_does_not() {
        let (truth, odometry, _) = driven_m("kind = \"wheel_stuck\"\nrobot = \"r1\"");
        assert!(truth == 0.0 && odometry > 1.5);
        let (truth, odometry, _) = driven_m("kind = \"wheel_slip\"\nrobot = \"r1\"\nfactor = 0.5");
        assert!((truth / odometry - 0.5).abs() < 0.01);
        let (truth, odometry, _) = driven_m("kind = \"slow\"\nrobot = \"r1\"\nfactor = 0.2");
        assert!((truth - odometry).abs() < 0.01 && (0.7..0.81).contains(&truth), "{truth}");
    }

    #[test]
    fn batteries_drop_and_drain_and_links_are_cut() {
        let (_, _, state) = driven_m("kind = \"battery_drop\"\nrobot = \"r1\"\nto_percent = 20");
        assert!((19.0..20.0).contains(&state.state_of_charge_percent));
        let (_, _, state) = driven_m("kind = \"battery_drain\"\nrobot = \"r1\"\nfactor = 100");
        assert!(state.state_of_charge_percent < 95.0);
        let (_, _, state) = driven_m("kind = \"cut_link\"\nrobot = \"r1\"");
        assert!(state.radio_jammed);
        let (_, _, state) = driven_m("kind = \"cut_link\"\nrobot = \"r1\"\nfor_s = 2");
        assert!(!state.radio_jammed);
    }

    #[test]
    fn a_station_out_of_order_gives_nothing() {
        let mut world = world();
        world.command("kind = \"station_out_of_order\"\nstation = \"s1\"\nfor_s = 2").unwrap();
        wait(&mut world, 1.0);
        assert!(!world.base_state(0).charging);
        wait(&mut world, 1.1);
        assert!(world.base_state(0).charging);
    }

    #[test]
    fn people_come_and_go() {
        let mut world = world();
        world.command("kind = \"people\"\ncount = 2\nfor_s = 3").unwrap();
        wait(&mut world, 1.0);
        assert_eq!(world.people.len(), 2);
        wait(&mut world, 3.0);
        assert!(world.people.is_empty());
    }
}
