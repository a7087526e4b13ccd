//! What a person may ask: pause, resume, cancel.

use crate::{Coordinator, Output, replan::Cause};
use protocol::{
    Timestamp,
    v1::{self, EventLevel, MissionState, ReplanCause, Verb},
};

impl Coordinator {
    /// A person asked for something.
    pub(crate) fn on_operator(
        &mut self,
        now: Timestamp,
        command: &v1::OperatorCommand,
        out: &mut Vec<Output>,
    ) {
        if !command.serial_number.is_empty() {
            let reason = "only the whole fleet can be paused, resumed and cancelled so far";
            return Self::reply(out, command, false, reason);
        }
        let (accepted, reason) = match (command.verb(), self.state) {
            (_, _) if self.ended() => (false, format!("the mission has ended: {}", self.state.as_str_name())),
            (Verb::Pause, MissionState::Paused) => (true, "it is paused already".to_owned()),
            (Verb::Pause, _) => {
                self.state = MissionState::Paused;
                (true, "robots stop; `oxplow resume` goes on".to_owned())
            }
            (Verb::Resume, MissionState::Paused) => {
                self.state =
                    if self.mission_began.is_some() { MissionState::Active } else { MissionState::Created };
                if self.mission_began.is_some() {
                    self.need_plan(now, Cause::fleet(ReplanCause::CauseOperator, "resumed"));
                }
                (true, "robots go on".to_owned())
            }
            (Verb::Resume, _) => (true, "it is not paused".to_owned()),
            (Verb::Cancel, _) => {
                self.state = MissionState::Cancelled;
                self.conclude(now, &format!("cancelled by {}", command.who));
                (true, "robots stop; the mission ends".to_owned())
            }
            (Verb::Unspecified, _) => (false, "no such command".to_owned()),
        };
        if accepted {
            self.announcer.event(now, EventLevel::EventInfo, "", command.verb().as_str_name(), &reason);
        }
        Self::reply(out, command, accepted, &reason);
    }
}
