//! A flag that is set when the process is asked to end (Ctrl-C, SIGTERM).

use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

/// The flag; a thread of its own waits for the signal.
pub fn flag() -> anyhow::Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    let set = Arc::clone(&stop);
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
        runtime.block_on(async {
            asked().await;
            set.store(true, Ordering::Relaxed);
        });
    })?;
    Ok(stop)
}

/// Waits until the process is asked to end.
pub async fn asked() {
    use tokio::signal::unix::{SignalKind, signal};
    let Ok(mut terminate) = signal(SignalKind::terminate()) else { return std::future::pending().await };
    tokio::select! {
        _ = tokio::signal::ctrl_c() => {}
        _ = terminate.recv() => {}
    }
}
