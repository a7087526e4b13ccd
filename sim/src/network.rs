//! The link between robots and coordinator in a rehearsal: a state machine that delays, loses, doubles and
//! reorders what is sent, and cuts robots off.

use crate::{
    random_streams::stream,
    scenario::NetworkTable,
    session::{Process, Session},
};
use protocol::Timestamp;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;
use std::time::Duration;

/// What can happen to the network. `L` is what it carries.
#[derive(Debug, Clone)]
pub(crate) enum Input<L> {
    /// Somebody sends something to or from this robot.
    Send { robot: usize, letter: L },
    /// A robot's process came, hangs, goes on, or died.
    Process { robot: usize, process: Process },
    /// A robot's link is cut (`true`) or whole.
    Cut { robot: usize, cut: bool },
    /// Time has passed.
    Woken,
}

/// What the network does.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Output<L> {
    /// Hands over what was sent.
    Deliver { robot: usize, letter: L },
    /// A robot's session opened (`true`) or was given up.
    Session { robot: usize, open: bool },
}

/// The network.
#[derive(Debug)]
pub(crate) struct Network<L> {
    table: NetworkTable,
    rngs: Vec<ChaCha8Rng>,
    sessions: Vec<Session>,
    under_way: BTreeMap<(Timestamp, u64), (usize, L)>,
    sent: u64,
}

impl<L: Clone> Network<L> {
    pub(crate) fn new(table: NetworkTable, seed: u64, robots: &[String]) -> Self {
        Self {
            table,
            rngs: robots.iter().map(|robot| stream(seed, "network", robot)).collect(),
            sessions: robots.iter().map(|_| Session::new()).collect(),
            under_way: BTreeMap::new(),
            sent: 0,
        }
    }

    /// Takes in one input at time `now` and returns what comes of it.
    pub(crate) fn handle(&mut self, now: Timestamp, input: Input<L>) -> Vec<Output<L>> {
        match input {
            Input::Send { robot, letter } => self.send(now, robot, letter),
            Input::Process { robot, process } => self.sessions[robot].set_process(now, process),
            Input::Cut { robot, cut } => self.sessions[robot].set_cut(now, cut),
            Input::Woken => return self.hand_out(now),
        }
        Vec::new()
    }

    /// Whether a robot has a session.
    pub(crate) fn has_session(&self, robot: usize) -> bool {
        self.sessions[robot].is_open()
    }

    fn send(&mut self, now: Timestamp, robot: usize, letter: L) {
        if !self.sessions[robot].carries() || self.draws(robot, self.table.loss) {
            return;
        }
        if self.draws(robot, self.table.duplicate) {
            self.post(now, robot, letter.clone());
        }
        self.post(now, robot, letter);
    }

    fn draws(&mut self, robot: usize, share: f64) -> bool {
        share > 0.0 && self.rngs[robot].random::<f64>() < share
    }

    fn post(&mut self, now: Timestamp, robot: usize, letter: L) {
        let mut delay_ms = self.table.delay_ms;
        if self.table.jitter_ms > 0.0 {
            delay_ms += self.table.jitter_ms * self.rngs[robot].random::<f64>();
        }
        self.sent += 1;
        let arrives = now + Duration::from_secs_f64(delay_ms / 1e3);
        self.under_way.insert((arrives, self.sent), (robot, letter));
    }

    fn hand_out(&mut self, now: Timestamp) -> Vec<Output<L>> {
        let mut out = Vec::new();
        for robot in 0..self.sessions.len() {
            if let Some(open) = self.sessions[robot].take_change(now) {
                out.push(Output::Session { robot, open });
            }
        }
        while let Some(first) = self.under_way.first_entry() {
            if first.key().0 > now {
                break;
            }
            let (robot, letter) = first.remove();
            if self.sessions[robot].carries() {
                out.push(Output::Deliver { robot, letter });
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(milliseconds: u64) -> Timestamp {
        Timestamp::from_nanos(milliseconds * 1_000_000)
    }

    fn network(table: NetworkTable) -> Network<u32> {
        let mut network = Network::new(table, 1, &["r1".to_owned()]);
        network.handle(at(0), Input::Process { robot: 0, process: Process::Running });
        network.handle(at(300), Input::Woken);
        network
    }

    fn delivered(network: &mut Network<u32>, until: u64) -> Vec<u32> {
        let letter = |out| match out {
            Output::Deliver { letter, .. } => Some(letter),
            Output::Session { .. } => None,
        };
        network.handle(at(until), Input::Woken).into_iter().filter_map(letter).collect()
    }

    #[test]
    fn what_is_sent_arrives_after_the_delay() {
        let mut network = network(NetworkTable { delay_ms: 30.0, jitter_ms: 0.0, ..NetworkTable::default() });
        network.handle(at(1000), Input::Send { robot: 0, letter: 7 });
        assert_eq!((delivered(&mut network, 1020), delivered(&mut network, 1030)), (vec![], vec![7]));
    }

    #[test]
    fn a_share_is_lost_and_a_share_comes_twice() {
        let mut network = network(NetworkTable { loss: 0.2, duplicate: 0.5, ..NetworkTable::default() });
        for letter in 0..1000 {
            network.handle(at(1000), Input::Send { robot: 0, letter });
        }
        let letters = delivered(&mut network, 2000);
        let distinct: std::collections::BTreeSet<u32> = letters.iter().copied().collect();
        assert!((750..850).contains(&distinct.len()), "{}", distinct.len());
        assert!((1150..1250).contains(&letters.len()), "{}", letters.len());
    }

    #[test]
    fn nothing_passes_a_cut_link_not_even_what_was_under_way() {
        let mut network = network(NetworkTable::default());
        network.handle(at(1000), Input::Send { robot: 0, letter: 1 });
        network.handle(at(1001), Input::Cut { robot: 0, cut: true });
        network.handle(at(1002), Input::Send { robot: 0, letter: 2 });
        assert!(delivered(&mut network, 1500).is_empty());
    }
}
