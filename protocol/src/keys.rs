//! Every key expression, in one place. Fixed depth, the id at a fixed place, the noun last.
//!
//! `fleet/v1/<fleet>/robots/<robot>/<noun>` for what concerns one robot,
//! `fleet/v1/<fleet>/{coordinator,sim}/<noun>` for the rest.
//! MCAP topic `/robots/r1/state` is key `…/robots/r1/state`.

/// Root of all keys: product and major version.
pub const ROOT: &str = "fleet/v1";

/// Nouns an agent puts.
pub const UP: &[&str] = &["factsheet", "connection", "state"];
/// Nouns the coordinator puts for one robot.
pub const DOWN: &[&str] = &["order", "grant", "instantActions"];

/// Key of a robot's message.
pub fn robot(fleet: &str, robot: &str, noun: &str) -> String {
    format!("{ROOT}/{fleet}/robots/{robot}/{noun}")
}

/// Selects one noun of all robots.
pub fn all_robots(fleet: &str, noun: &str) -> String {
    format!("{ROOT}/{fleet}/robots/*/{noun}")
}

/// Liveliness token of an agent; the boot id tells a restart from a blink.
pub fn alive(fleet: &str, robot: &str, boot_id: u64) -> String {
    format!("{ROOT}/{fleet}/robots/{robot}/alive/{boot_id:016x}")
}

/// Selects the liveliness tokens of all agents.
pub fn all_alive(fleet: &str) -> String {
    format!("{ROOT}/{fleet}/robots/*/alive/*")
}

/// Robot and boot id of a liveliness key.
pub fn parse_alive(key: &str) -> Option<(&str, u64)> {
    let mut chunks = key.rsplit('/');
    let boot_id = u64::from_str_radix(chunks.next()?, 16).ok()?;
    (chunks.next()? == "alive").then_some(())?;
    Some((chunks.next()?, boot_id))
}

/// Robot of a key `…/robots/<robot>/<noun>`.
pub fn parse_robot(key: &str) -> Option<(&str, &str)> {
    let mut chunks = key.rsplit('/');
    let noun = chunks.next()?;
    let robot = chunks.next()?;
    (chunks.next()? == "robots").then_some((robot, noun))
}

/// Key of something the coordinator publishes: `status`, `decisions`, `events`, `coverage`, …
pub fn coordinator(fleet: &str, noun: &str) -> String {
    format!("{ROOT}/{fleet}/coordinator/{noun}")
}

/// Liveliness token of the coordinator.
pub fn coordinator_alive(fleet: &str, term: u64) -> String {
    format!("{ROOT}/{fleet}/coordinator/alive/{term}")
}

/// Queryable of the coordinator for operator commands.
pub fn operator(fleet: &str) -> String {
    format!("{ROOT}/{fleet}/coordinator/cmd")
}

/// Queryable of the coordinator for reading: `status`.
pub fn query(fleet: &str, what: &str) -> String {
    format!("{ROOT}/{fleet}/coordinator/query/{what}")
}

/// Key of something the sim publishes or answers: `truth`, `contacts`, `faults` (injected), `fault` (queryable).
pub fn sim(fleet: &str, noun: &str) -> String {
    format!("{ROOT}/{fleet}/sim/{noun}")
}
