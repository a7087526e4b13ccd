use super::Story;
use protocol::v1::EndAction;

#[test]
fn a_robot_with_a_low_battery_goes_to_the_station_and_its_work_to_the_other() {
    let mut story = Story::under_way();
    story.states[1].state_of_charge_percent = 18.0;
    story.run(1.0, &[0, 1]);
    story.answer();
    story.run(0.5, &[0, 1]);
    assert!(story.says("LOW BATTERY"));
    let order = &story.orders.iter().rev().find(|(robot, _)| robot == "r2").unwrap().1;
    assert_eq!((order.end_action(), order.station_id.as_str()), (EndAction::StartCharging, "s1"));
    assert_eq!(story.plans.last().unwrap().starts.len(), 1);
}

#[test]
fn a_second_robot_queues_for_the_only_station() {
    let mut story = Story::under_way();
    for state in &mut story.states {
        state.state_of_charge_percent = 18.0;
    }
    story.run(1.0, &[0, 1]);
    assert!(story.says("QUEUED"));
}
