//! Scratch.
#![allow(clippy::all, clippy::pedantic, clippy::unwrap_used, clippy::disallowed_methods)]
use agent::{Agent, Input as AIn, Output as AOut};
use coordinator::{Coordinator, Input, Output, Publication};
use protocol::Timestamp;
use std::{collections::VecDeque, sync::Arc, time::Duration};

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let scenario = Arc::new(sim::Scenario::load(&args[1]).unwrap());
    let kills: Vec<(f64, usize)> = args[2..]
        .iter()
        .filter_map(|a| {
            let (t, r) = a.split_once(':')?;
            Some((t.parse().ok()?, r.parse().ok()?))
        })
        .collect();
    let t0 = std::time::Instant::now();
    let mut world = sim::World::new(&scenario, 1);
    let mut coordinator = Coordinator::new(scenario.coordinator_config(1)).unwrap();
    let n = world.robot_count();
    let mut agents: Vec<Option<Agent>> =
        (0..n).map(|i| Some(Agent::new(world.robot_id(i), 100 + i as u64, 1))).collect();
    for i in 0..n {
        coordinator.handle(
            Timestamp::ZERO,
            Input::Alive { robot: world.robot_id(i).to_owned(), boot_id: 100 + i as u64 },
        );
    }
    let mut to_c: VecDeque<(Timestamp, Input)> = VecDeque::new();
    let mut to_a: VecDeque<(Timestamp, usize, AIn)> = VecDeque::new();
    let (mut tw, mut ta, mut tc) = (0.0, 0.0, 0.0);
    let mut contacts = 0;
    'run: for _ in 0..(50 * 20000) {
        let s = std::time::Instant::now();
        world.step();
        tw += s.elapsed().as_secs_f64();
        let now = world.now();
        for &(t, r) in &kills {
            if now.as_secs_f64() >= t && agents[r].is_some() {
                agents[r] = None;
                println!("{now} KILL r{}", r + 1);
                to_c.push_back((
                    now + Duration::from_millis(20),
                    Input::Gone { robot: world.robot_id(r).to_owned(), boot_id: 100 + r as u64 },
                ));
            }
        }
        let s = std::time::Instant::now();
        for i in 0..n {
            let base = world.base_state(i);
            let Some(agent) = &mut agents[i] else { continue };
            let mut inputs = vec![AIn::Base(Box::new(base))];
            while to_a.front().is_some_and(|(t, _, _)| *t <= now) && to_a.front().unwrap().1 == i {
                inputs.push(to_a.pop_front().unwrap().2);
            }
            for input in inputs {
                for o in agent.handle(now, input) {
                    let at = now + Duration::from_millis(20);
                    match o {
                        AOut::Setpoint(s) => world.setpoint(i, &s),
                        AOut::State(s) => to_c.push_back((at, Input::State(s))),
                        AOut::Factsheet(s) => to_c.push_back((at, Input::Factsheet(s))),
                        AOut::Connection(s) => to_c.push_back((at, Input::Connection(s))),
                    }
                }
            }
        }
        let due: Vec<_> = {
            let mut v = vec![];
            while to_a.front().is_some_and(|(t, _, _)| *t <= now) {
                v.push(to_a.pop_front().unwrap());
            }
            v
        };
        for (_, i, input) in due {
            if let Some(agent) = &mut agents[i] {
                for o in agent.handle(now, input) {
                    if let AOut::State(s) = o {
                        to_c.push_back((now, Input::State(s)))
                    }
                }
            }
        }
        ta += s.elapsed().as_secs_f64();
        for c in world.take_contacts() {
            contacts += 1;
            println!("{now} CONTACT {c:?}");
        }
        let s = std::time::Instant::now();
        let mut inputs: Vec<Input> = vec![];
        while to_c.front().is_some_and(|(t, _)| *t <= now) {
            inputs.push(to_c.pop_front().unwrap().1);
        }
        if coordinator.next_wakeup().is_some_and(|(t, _)| t <= now) {
            inputs.push(Input::Woken);
        }
        for input in inputs {
            for o in coordinator.handle(now, input) {
                let at = now + Duration::from_millis(20);
                let find = |id: &str| (0..n).find(|&i| world.robot_id(i) == id).unwrap();
                match o {
                    Output::Order { robot, order } => {
                        to_a.push_back((at, find(&robot), AIn::Order(Box::new(order))))
                    }
                    Output::Grant { robot, grant } => to_a.push_back((at, find(&robot), AIn::Grant(grant))),
                    Output::InstantActions { robot, actions } => {
                        to_a.push_back((at, find(&robot), AIn::InstantActions(actions)))
                    }
                    Output::Plan(p) => {
                        let r = p.run();
                        to_c.push_back((
                            now + Duration::from_millis(50),
                            Input::Planned { revision: p.revision, result: r, planning_s: 0.0 },
                        ));
                    }
                    Output::Publish(Publication::Event(e)) => println!(
                        "{}  {}  {}  {}",
                        Timestamp::from_nanos(e.timestamp_ns),
                        e.serial_number,
                        e.event,
                        e.text
                    ),
                    Output::Publish(Publication::Result(r)) => {
                        println!("{:?}", r.gaps);
                        break 'run;
                    }
                    Output::Publish(Publication::Status(st)) => {
                        if (st.timestamp_ns / 1_000_000_000) % 20 == 0 {
                            let p = st.progress.unwrap();
                            println!(
                                "   {:.1}% rem {:.0}s  {}",
                                p.covered_percent,
                                p.remaining_s,
                                st.robots
                                    .iter()
                                    .map(|r| format!(
                                        "{}:{}{}",
                                        r.serial_number,
                                        r.role().as_str_name().trim_start_matches("ROLE_"),
                                        if r.waits_for.is_empty() {
                                            String::new()
                                        } else {
                                            format!("({})", r.waits_for)
                                        }
                                    ))
                                    .collect::<Vec<_>>()
                                    .join(" ")
                            );
                        }
                    }
                    _ => {}
                }
            }
        }
        tc += s.elapsed().as_secs_f64();
    }
    let wall = t0.elapsed().as_secs_f64();
    println!(
        "contacts {contacts} wall {wall:.2} s, {:.0} x; world {tw:.2} agents {ta:.2} coordinator {tc:.2}",
        world.now().as_secs_f64() / wall
    );
}
