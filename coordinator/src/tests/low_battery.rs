use super::Story;
use crate::{ChosenBreak, Input};
use protocol::v1::{self, EndAction};
use terrain::{Cell, Point};

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
    let plan = story.plans.last().unwrap();
    let later: Vec<bool> = plan.starts.iter().map(|start| start.available_in_s > 100.0).collect();
    assert_eq!(later, [false, true], "who charges is back later");
    assert!(plan.run().unwrap().routes()[1].points.is_empty(), "all is done before that");
}

/// It is granted no ground behind the break, goes to the station, and keeps the rest; others may have it when it is lost.
#[test]
fn a_route_is_broken_off_where_it_was_chosen_and_the_rest_waits_for_its_robot() {
    let mut story = Story::begin();
    story.answer();
    let (revision, robot) = (story.plans.last().unwrap().revision, 1);
    let line = story.coordinator.line_ahead(robot);
    let ahead_m = line[2..].windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    story.feed(Input::BrokenOff { revision, breaks: vec![ChosenBreak { robot, station: 0, ahead_m }] });
    story.run(0.5, &[0, 1]);
    let charging = |(robot, order): &&(String, v1::Order)| {
        robot == "r2" && order.end_action() == EndAction::StartCharging
    };
    assert!(story.orders.iter().any(|sent| charging(&sent)), "{:?}", story.events);
    let kept: Vec<Point> = story.coordinator.places_ahead(robot).iter().map(|place| place.point).collect();
    assert_eq!(kept, line[2..]);
    assert!(story.coordinator.will_resume(robot));
    story.run(5.0, &[0]);
    story.answer();
    story.run(1.0, &[0]);
    assert!(!story.coordinator.will_resume(robot) && story.coordinator.places_ahead(robot).is_empty());
    let plan = story.plans.last().unwrap();
    let rest = |cells: &Vec<Cell>| {
        kept[1..].iter().all(|&place| cells.contains(&plan.floor.lattice().cell_at(place).unwrap()))
    };
    assert!(plan.starts.len() == 1 && plan.orphans.iter().any(rest), "{:?}", plan.orphans);
}

/// A choice for an older plan is not kept.
#[test]
fn a_break_for_an_older_plan_is_dropped() {
    let mut story = Story::begin();
    story.answer();
    let revision = story.plans.last().unwrap().revision;
    let breaks = vec![ChosenBreak { robot: 1, station: 0, ahead_m: 1.0 }];
    story.feed(Input::BrokenOff { revision: revision + 1, breaks });
    assert!(story.coordinator.robots[1].break_off.is_none());
}

#[test]
fn breaks_are_chosen_when_a_charge_does_not_last() {
    let drains = |drive_w_per_m_per_s: f64| v1::EnergyModel {
        capacity_wh: 1.0,
        drive_w_per_m_per_s,
        ..v1::EnergyModel::default()
    };
    let asked = |model: &v1::EnergyModel| {
        let mut story = Story::begin_with(model);
        story.answer();
        story.break_offs.pop().map(|request| request.run())
    };
    assert_eq!(asked(&drains(1.0)), None);
    let breaks = asked(&drains(36.0 * 12.0)).expect("12 percent a metre");
    assert!(breaks.iter().any(|chosen| chosen.station == 0 && chosen.ahead_m > 0.0), "{breaks:?}");
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

/// Metres along the order's places up to a node, and home from there over the lattice.
fn there_and_home_m(order: &v1::Order, last: u64) -> f64 {
    let places: Vec<&v1::Node> = order.nodes.iter().filter(|node| node.sequence_id <= last).collect();
    let length_m = |a: &v1::Node, b: &v1::Node| (a.x_m - b.x_m).hypot(a.y_m - b.y_m);
    let there_m: f64 = places.windows(2).map(|pair| length_m(pair[0], pair[1])).sum();
    places.last().map_or(0.0, |end| there_m + (end.x_m - 0.25).abs() + (end.y_m - 1.75).abs())
}

/// One percent a metre: what is granted can be driven and left for home with the reserve to spare, and one node more
/// could not. The robot reports no progress, so its first grants are all there are.
#[test]
fn ground_is_granted_exactly_as_far_as_the_battery_lasts_there_and_home() {
    let mut broke_off = 0;
    for tenths in (105..180).step_by(5) {
        let charge = f64::from(tenths) / 10.0;
        let mut story = Story::begin_with(&v1::EnergyModel {
            capacity_wh: 1.0,
            drive_w_per_m_per_s: 36.0,
            ..v1::EnergyModel::default()
        });
        story.states[1].state_of_charge_percent = charge;
        story.answer();
        story.run(0.1, &[1]);
        let Some((_, order)) = story.orders.iter().find(|(robot, order)| robot == "r2" && order.complete)
        else {
            continue;
        };
        let order = order.clone();
        let released = story.grants_of("r2", order.order_id);
        let spare = charge - 10.0;
        assert!(released == order.nodes[0].sequence_id || there_and_home_m(&order, released) <= spare + 1e-9);
        if story.says("QUEUED")
            || story.orders.iter().any(|(_, order)| order.end_action() == EndAction::StartCharging)
        {
            broke_off += 1;
            let next = there_and_home_m(&order, released + 1);
            assert!(next > spare, "at {charge} % it could have gone on to {next} m");
        }
    }
    assert!(broke_off > 3, "{broke_off}");
}

#[test]
fn ground_that_no_battery_reaches_is_named_before_the_start() {
    let story = Story::begin_with(&v1::EnergyModel {
        capacity_wh: 1.0,
        drive_w_per_m_per_s: 36.0 * 20.0, // 20 percent a metre: 70 percent last for 3.5 m, there and back
        ..v1::EnergyModel::default()
    });
    let said = story.events.iter().find(|event| event.event == "OUT OF RANGE").expect("it is said");
    assert!(said.text.contains("cells") && said.text.contains("put a station nearer"), "{}", said.text);
    assert!(story.plans[0].visit.iter().filter(|&&visit| visit).count() < 20, "they are not planned for");
}
