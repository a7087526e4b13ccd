//! User CPU time.

use nix::sys::resource::{UsageWho, getrusage};

/// User CPU seconds that `work` takes in this process, and its result.
pub fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let before_s = user_s();
    let result = work();
    (result, user_s() - before_s)
}

fn user_s() -> f64 {
    let usage = getrusage(UsageWho::RUSAGE_SELF).expect("a process may ask for its own usage");
    let time = usage.user_time();
    time.tv_sec() as f64 + time.tv_usec() as f64 / 1e6
}

/// The most memory that this process has had, MB.
pub(crate) fn peak_memory_mb() -> i64 {
    let usage = getrusage(UsageWho::RUSAGE_SELF).expect("a process may ask for its own usage");
    // Kilobytes on Linux, bytes on macOS.
    usage.max_rss() / if cfg!(target_os = "macos") { 1_000_000 } else { 1_000 }
}
