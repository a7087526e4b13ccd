use super::Story;
use crate::Input;

#[test]
fn an_answer_to_an_older_request_is_dropped() {
    let mut story = Story::begin();
    let first = story.plans[0].clone();
    let stale = Input::Planned { revision: first.revision + 7, result: first.run(), planning_s: 0.0 };
    story.feed(stale);
    story.run(0.3, &[0, 1]);
    assert!(story.orders.iter().all(|(_, order)| order.nodes.len() < 2), "nobody was sent anywhere");
    story.answer();
    story.run(0.3, &[0, 1]);
    assert!(story.orders.iter().any(|(_, order)| order.nodes.len() > 2));
}

#[test]
fn no_ground_is_released_while_the_planner_works_or_before_the_agent_knows_its_order() {
    let mut story = Story::begin();
    assert!(story.grants.iter().all(|(_, grant)| grant.released_sequence_id <= 1));
    story.answer();
    assert!(story.grants.iter().all(|(_, grant)| grant.released_sequence_id <= 1));
    story.run(0.5, &[0, 1]);
    assert!(story.last_grant("r1").released_sequence_id > 1);
}
