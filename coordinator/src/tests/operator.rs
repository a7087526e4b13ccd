use super::Story;
use crate::Input;
use protocol::v1::{MissionState, OperatorCommand, Verb};

fn ask(story: &mut Story, verb: Verb) {
    story.feed(Input::Operator(OperatorCommand { verb: verb.into(), ..OperatorCommand::default() }));
}

#[test]
fn a_pause_takes_the_lease_away_and_a_resume_gives_it_back() {
    let mut story = Story::under_way();
    assert!(story.last_grant("r1").lease_ms > 0);
    ask(&mut story, Verb::Pause);
    story.run(0.2, &[0, 1]);
    assert_eq!(story.last_grant("r1").lease_ms, 0);
    ask(&mut story, Verb::Resume);
    story.run(0.2, &[0, 1]);
    assert!(story.last_grant("r1").lease_ms > 0);
}

#[test]
fn a_cancel_holds_even_while_a_plan_is_due_or_on_its_way() {
    let mut story = Story::under_way();
    ask(&mut story, Verb::Pause);
    ask(&mut story, Verb::Resume);
    story.run(0.1, &[0, 1]);
    ask(&mut story, Verb::Cancel);
    story.run(1.0, &[0, 1]);
    story.answer();
    story.run(1.0, &[0, 1]);
    assert_eq!(story.coordinator.mission_state(), MissionState::Cancelled);
    assert_eq!(story.result.map(|result| result.mission_state()), Some(MissionState::Cancelled));
}
