//! The log's own thread: records wait in a bounded queue, the file is flushed by time. Nothing here ever makes the
//! coordinator wait: when the disk is slow, records are dropped and counted; when it fails, the mission goes on
//! without a log, and says so once.
#![expect(clippy::disallowed_methods, reason = "a driver has clocks and waits")]

use crate::recorder::{Record, Recorder, RunInfo};
use anyhow::{Context, Result, anyhow};
use protocol::Timestamp;
use std::{
    fs::File,
    io::{BufWriter, Write},
    path::Path,
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
        mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel},
    },
    thread::JoinHandle,
    time::{Duration, Instant},
};

/// Records that wait for the disk.
const QUEUE: usize = 16_384;
/// What is lost at most when the process is killed.
const FLUSH_EVERY: Duration = Duration::from_millis(200);
/// What is lost at most when the machine fails.
const SYNC_EVERY: Duration = Duration::from_secs(1);

/// The thread, seen from the coordinator's loop.
pub(super) struct LogThread {
    records: SyncSender<(Timestamp, Record)>,
    dropped: Arc<AtomicU64>,
    thread: JoinHandle<Result<()>>,
}

impl LogThread {
    /// Creates the file and starts the thread. A file of that name must not exist yet.
    pub(super) fn start(path: &Path, run: &RunInfo) -> Result<Self> {
        let file = File::create_new(path)
            .with_context(|| format!("cannot write the log {}: choose another --out", path.display()))?;
        let for_sync = file.try_clone()?;
        let mut recorder = Recorder::new(BufWriter::new(file), run)?;
        recorder.flush()?;
        let (records, queue) = sync_channel(QUEUE);
        let thread = std::thread::Builder::new()
            .name("log".to_owned())
            .spawn(move || write(recorder, &for_sync, &queue))
            .context("no thread for the log")?;
        Ok(Self { records, dropped: Arc::default(), thread })
    }

    /// Hands a record over; never waits.
    pub(super) fn record(&self, now: Timestamp, record: Record) {
        if self.records.try_send((now, record)).is_err() {
            self.dropped.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// How many records did not fit.
    pub(super) fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    /// Writes what is left and closes the file.
    pub(super) fn finish(self) -> Result<()> {
        drop(self.records);
        self.thread.join().map_err(|_| anyhow!("the log's thread panicked"))?
    }
}

fn write<W: Write>(
    mut recorder: Recorder<W>,
    file: &File,
    queue: &Receiver<(Timestamp, Record)>,
) -> Result<()> {
    let (mut flushed, mut synced) = (Instant::now(), Instant::now());
    loop {
        match queue.recv_timeout(Duration::from_millis(50)) {
            Ok((now, record)) => recorder.record(now, &record).context("the log cannot be written")?,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        if flushed.elapsed() >= FLUSH_EVERY {
            recorder.flush().context("the log cannot be written")?;
            flushed = Instant::now();
            if synced.elapsed() >= SYNC_EVERY {
                file.sync_data().context("the log cannot be written")?;
                synced = Instant::now();
            }
        }
    }
    recorder.finish().context("the log cannot be finished")?;
    file.sync_data().context("the log cannot be written")?;
    Ok(())
}
