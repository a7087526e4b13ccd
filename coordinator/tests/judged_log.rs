//! The judge reads what the recorder wrote, and finds every lie.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

mod story;

use console::{LogError, Verdict, verify_bytes};
use coordinator::Publication;
use coordinator::recorder::Record;
use protocol::v1;

fn judged(twist: impl FnMut(f64, &mut Record)) -> Verdict {
    verify_bytes(&story::recorded_with(twist)).unwrap()
}

fn broken_rules(verdict: &Verdict) -> Vec<&str> {
    let mut rules: Vec<&str> = verdict.violations.iter().map(|violation| violation.rule).collect();
    rules.dedup();
    rules
}

#[test]
fn an_honest_run_is_agreed_with() {
    let verdict = judged(|_, _| {});
    assert_eq!(verdict.violations, []);
    assert_eq!(verdict.exit_code(), 0, "{verdict}");
    assert_eq!(verdict.coverage.claimed_cells, 40);
    assert!(verdict.coverage.truly_swept_percent > 99.0, "{verdict}");
    assert!((verdict.battery.lowest_percent["r1"] - 78.0).abs() < 0.2);
}

#[test]
fn a_claim_without_a_sweep_is_false() {
    let verdict = judged(|at_s, record| {
        if let Record::Truth(truth) = record {
            truth.bodies[1].tool_active = !(3.0..5.0).contains(&at_s);
        }
    });
    assert_eq!(broken_rules(&verdict), ["coverage", "result"], "{verdict}");
    assert!(verdict.coverage.falsely_claimed_m2 > 0.05, "{verdict}");
    assert_eq!(verdict.exit_code(), 1);
}

#[test]
fn a_claim_without_a_trusted_report_is_unproven() {
    let verdict = judged(|_, record| {
        if let Record::State(state) = record {
            for vertex in &mut state.sweep {
                vertex.trusted = !(5..10).contains(&vertex.sequence);
            }
        }
    });
    assert_eq!(broken_rules(&verdict), ["evidence"], "{verdict}");
}

#[test]
fn truth_too_far_apart_gives_no_credit() {
    let verdict = judged(|at_s, record| {
        if let Record::Truth(truth) = record {
            truth.timestamp_ns += if at_s > 6.0 { 2_000_000_000 } else { 0 };
        }
    });
    assert!(verdict.unseen_s > 2.0);
    assert!(!broken_rules(&verdict).contains(&"contact"));
    let verdict = judged(|at_s, record| {
        if let Record::Truth(truth) = record
            && (6.0..7.5).contains(&at_s)
        {
            truth.sequence = 1;
        }
    });
    assert!(verdict.coverage.falsely_claimed_cells > 0, "{verdict}");
    assert!(verdict.truths_lost > 0);
}

#[test]
fn robots_that_pass_through_each_other_between_two_truths_have_touched() {
    let verdict = judged(|at_s, record| {
        if let Record::Truth(truth) = record {
            let jump = if ((at_s * 10.0).round() as u64).is_multiple_of(2) { 0.1 } else { -0.1 };
            truth.bodies[1].pose =
                truth.bodies[0].pose.map(|pose| v1::Pose { y_m: pose.y_m + jump + 0.15, ..pose });
        }
    });
    assert!(verdict.contacts.between_robots > 0, "{verdict}");
    assert!(verdict.contacts.smallest_gap_m.unwrap() < 0.0);
}

#[test]
fn a_body_in_a_wall_is_seen_once() {
    let verdict = judged(|at_s, record| {
        if let Record::Truth(truth) = record
            && (2.0..3.0).contains(&at_s)
            && let Some(pose) = &mut truth.bodies[0].pose
        {
            pose.y_m -= 0.1;
        }
    });
    assert_eq!(verdict.contacts.walls_entered, 1, "{verdict}");
}

#[test]
fn an_obstacle_that_was_there_is_entered_and_one_that_falls_on_a_robot_is_not() {
    let obstacle = |x_m: f64| v1::ObstacleTruth {
        obstacle_id: "crate".to_owned(),
        centre: Some(v1::Point { x_m, y_m: 0.375 }),
        half_x_m: 0.05,
        half_y_m: 0.05,
        ..Default::default()
    };
    let verdict = judged(|_, record| {
        if let Record::Truth(truth) = record {
            truth.obstacles.push(obstacle(2.0));
        }
    });
    assert_eq!(verdict.contacts.obstacles_entered, 1, "{verdict}");
    let verdict = judged(|at_s, record| {
        if let Record::Truth(truth) = record
            && at_s >= 2.0
        {
            truth.obstacles.push(obstacle(1.375));
        }
    });
    assert_eq!(verdict.contacts.obstacles_entered, 0, "{verdict}");
}

#[test]
fn driving_into_a_person_counts_and_being_walked_into_does_not() {
    let with_speed = |speed: f64| {
        judged(move |_, record| {
            if let Record::Truth(truth) = record {
                truth.bodies.iter_mut().for_each(|body| body.speed_m_per_s = speed);
                truth.obstacles.push(v1::ObstacleTruth {
                    obstacle_id: "anna".to_owned(),
                    centre: Some(v1::Point { x_m: 2.0, y_m: 0.25 }),
                    radius_m: 0.1,
                    person: true,
                    ..Default::default()
                });
            }
        })
    };
    assert_eq!(with_speed(0.5).contacts.people_driven_into, 1);
    assert_eq!(with_speed(0.0).contacts.people_driven_into, 0);
}

#[test]
fn a_robot_that_runs_empty_without_notice_is_stranded() {
    let verdict = judged(|at_s, record| match record {
        Record::Truth(truth) if at_s > 5.0 => truth.bodies[0].state_of_charge_percent = 0.0,
        Record::State(state) if at_s > 5.0 && state.header.as_ref().unwrap().serial_number == "r1" => {
            state.state_of_charge_percent = 0.0;
        }
        _ => {}
    });
    assert_eq!(broken_rules(&verdict), ["battery"], "{verdict}");
}

#[test]
fn a_charge_that_is_not_there_is_misreported() {
    let verdict = judged(|_, record| {
        if let Record::State(state) = record {
            state.state_of_charge_percent += 5.0;
        }
    });
    assert_eq!(broken_rules(&verdict), ["battery"], "{verdict}");
    assert!((verdict.battery.report_error_percent - 5.0).abs() < 0.2);
}

#[test]
fn a_mission_called_complete_with_open_cells_is_not() {
    let open = |record: &mut Record| {
        if let Record::Publication(Publication::Coverage(delta)) = record {
            delta.runs.retain(|run| (run.row, run.column) != (2, 5) || run.status == 2);
        }
    };
    let verdict = judged(|_, record| open(record));
    assert!(broken_rules(&verdict).contains(&"result"), "{verdict}");
    let verdict = judged(|_, record| {
        open(record);
        if let Record::Publication(Publication::Result(result)) = record {
            result.mission_state = v1::MissionState::CompletedWithGaps as i32;
            let progress = result.progress.as_mut().unwrap();
            progress.cells_covered -= 1;
            progress.cells_assigned += 1;
        }
    });
    assert_eq!((verdict.exit_code(), verdict.gaps.len()), (3, 1), "{verdict}");
}

#[test]
fn a_delta_that_is_missing_is_noticed() {
    let verdict = judged(|_, record| {
        if let Record::Publication(Publication::Coverage(delta)) = record
            && delta.sequence > 10
        {
            delta.sequence += 1;
        }
    });
    assert_eq!(broken_rules(&verdict), ["ledger"], "{verdict}");
}

#[test]
fn a_log_cut_off_by_a_kill_is_judged_as_far_as_it_goes() {
    let (log, flushed) = story::recorded_until(story::END_S / 2.0);
    let verdict = verify_bytes(&log[..flushed]).unwrap();
    assert!(!verdict.log_is_whole);
    assert_eq!((verdict.violations.as_slice(), verdict.exit_code()), ([].as_slice(), 3), "{verdict}");
    for torn_off in [1, 100, 5000] {
        let verdict = verify_bytes(&log[..flushed - torn_off]).unwrap();
        assert_eq!((verdict.log_is_whole, verdict.exit_code()), (false, 3), "{verdict}");
    }
}

#[test]
fn no_bytes_make_the_judge_panic() {
    let log = story::recorded();
    assert!(matches!(verify_bytes(b"PK\x03\x04 something else altogether"), Err(LogError::NotMcap)));
    assert!(verify_bytes(b"").is_err());
    let mut state = 1_u64;
    let mut draw = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    for _ in 0..60 {
        let mut damaged = log.clone();
        for _ in 0..4 {
            let at = draw(damaged.len());
            damaged[at] ^= 1 << draw(8);
        }
        let _ = verify_bytes(&damaged);
        let _ = verify_bytes(&log[..draw(log.len())]);
    }
}

#[test]
fn lengths_are_limited_before_anything_is_allocated() {
    let magic = b"\x89MCAP0\r\n";
    let record = |opcode: u8, declared: u64, body: &[u8]| {
        [magic.as_slice(), &[opcode], &declared.to_le_bytes(), body].concat()
    };
    let chunk_of_a_terabyte = {
        let mut body = vec![0; 16];
        body.extend((1_u64 << 40).to_le_bytes());
        body.extend([1, 2, 3, 4]);
        body.extend(4_u32.to_le_bytes());
        body.extend(b"zstd");
        body.extend(8_u64.to_le_bytes());
        body.extend([0; 8]);
        record(6, body.len() as u64, &body)
    };
    assert!(matches!(verify_bytes(&chunk_of_a_terabyte), Err(LogError::Damaged(_))));
    assert!(matches!(verify_bytes(&record(12, 1 << 50, b"abc")), Err(LogError::Damaged(_))));
    let name_of_four_gigabytes = record(12, 8, &[0xff; 8]);
    assert!(matches!(verify_bytes(&name_of_four_gigabytes), Err(LogError::Damaged(_))));
}
