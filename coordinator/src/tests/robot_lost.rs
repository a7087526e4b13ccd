use super::Story;
use crate::Input;

#[test]
fn a_silent_robot_gives_its_horizon_away_and_keeps_its_ground_until_the_lease_is_over() {
    let mut story = Story::under_way();
    let plans = story.plans.len();
    story.run(0.8, &[0]);
    assert!(story.says("SUSPECT"));
    assert_eq!(story.plans.len(), plans + 1);
    let request = story.plans.last().unwrap();
    assert_eq!(request.starts.len(), 1, "only r1 is planned for");
    assert!(request.blocked.iter().any(|&blocked| blocked), "r2's ground is closed");
    assert_eq!(request.orphans.len(), 1, "r2's route is there to be cut up");
    story.answer();
    story.run(1.5, &[0]);
    assert!(story.says("LOCKED") && !story.says("QUARANTINE"));
    story.run(3.0, &[0]);
    assert!(story.says("QUARANTINE"));
}

#[test]
fn a_dropped_token_is_noticed_sooner_than_silence() {
    let mut story = Story::under_way();
    story.feed(Input::Gone { robot: "r2".to_owned(), boot_id: 102 });
    story.run(0.3, &[0]);
    assert!(story.says("SUSPECT"));
}

#[test]
fn a_robot_that_comes_back_after_its_ground_was_taken_begins_a_new_order_and_epoch() {
    let mut story = Story::under_way();
    let (order, epoch) = (story.states[1].order_id, story.last_grant("r2").epoch);
    story.run(6.0, &[0]);
    assert!(story.says("QUARANTINE"));
    story.run(0.5, &[0, 1]);
    assert!(story.states[1].order_id > order);
    assert!(story.last_grant("r2").epoch > epoch);
}

#[test]
fn no_ground_is_ever_held_by_two() {
    let story = Story::under_way();
    let robots = &story.coordinator.robots;
    let separation = story.coordinator.separation_m();
    for a in &robots[0].held {
        for b in &robots[1].held {
            assert!(a.distance(b) >= separation, "{a:?} {b:?}");
        }
    }
}

#[test]
fn a_robot_that_falls_silent_before_it_could_join_stands_there_until_somebody_sees_its_ground_free() {
    let mut story = Story::begin();
    story.feed(Input::Alive { robot: "r3".to_owned(), boot_id: 102 });
    let mut state = super::state("r3", 1.25, 1.25);
    state.header.as_mut().unwrap().header_id = 1;
    story.feed(Input::State(Box::new(state)));
    story.run(0.3, &[0, 1]);
    assert!(!story.says("SUSPECT"));
    story.run(3.0, &[0, 1]);
    assert!(story.says("SUSPECT") && story.says("QUARANTINE"));
    assert!(story.coordinator.robots[2].held.is_empty());
}
