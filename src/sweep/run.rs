//! Computing the points of a sweep: the next one is pressed while this one is traced.

use super::finish::finish;
use super::ready::{Sent, Task, work};
use super::record::item;
use super::shard::Shard;
use super::shelf::Presses;
use super::tally::{SweepError, Tally};
use super::{State, Sweep};
use crate::mechanics::from_scene::press_setup;
use crate::output::{OutputError, Records};
use crate::pipeline::Session;
use crate::progress::{Observer, Stage};
use std::collections::{HashMap, HashSet, VecDeque};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::Duration;

/// Points whose presses are told apart before the work: beyond, points are taken in their order.
const MOST_GROUPED: usize = 5_000;
/// Between two looks whether to stop, or whether another worker has come to an end.
const LOOK: Duration = Duration::from_millis(200);

/// How points are computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// Threads that press; one traces beside them.
    pub workers: usize,
    /// Only this part of the points.
    pub shard: Option<Shard>,
    /// Whether points that failed are computed again.
    pub retry: bool,
}

impl Default for Options {
    /// All points, half of the cores.
    fn default() -> Self {
        let cores = std::thread::available_parallelism().map_or(2, usize::from);
        Self { workers: cores.div_ceil(2), shard: None, retry: false }
    }
}

/// Computes the points that have no record yet; gives how many of them this run computed itself.
///
/// # Errors
/// A record that cannot be written, a device that fails; `Stopped` where `observe` says so. All points that were done
/// before stay.
pub fn run(
    sweep: &Sweep,
    records: &Records,
    session: &Session,
    options: Options,
    observe: &mut Observer,
) -> Result<usize, SweepError> {
    let (rows, shared) = ordered(sweep);
    let mut rows = match options.shard {
        Some(shard) => shard.of(&rows),
        None => rows,
    };
    if options.retry {
        forget_failures(sweep, records, &rows)?;
    }
    let task = Task { sweep, records, shared: &shared, presses: &Presses::of(records) };
    let mut tally = Tally { done: 0, computed: 0, of: rows.len() };
    loop {
        rows = pass(task, session, options, rows, &mut tally, observe)?;
        if rows.is_empty() {
            return Ok(tally.computed);
        }
        // Other workers have the rest: when they end, it is there, or free.
        std::thread::sleep(LOOK);
        let what = format!("{} points of other workers", rows.len());
        if !observe(Stage { done: tally.share(), what: &what }) {
            return Err(SweepError::Stopped);
        }
    }
}

/// Takes back the records of points that failed: from then on they are like any that nobody has computed.
fn forget_failures(sweep: &Sweep, records: &Records, rows: &[usize]) -> Result<(), OutputError> {
    let has_failed = |row: usize| sweep.record(records, row).is_some_and(|record| record.status == State::Failed);
    rows.iter().filter(|row| has_failed(**row)).try_for_each(|row| records.forget_item(&item(*row)))
}

/// All rows, those that share a press after each other; and these.
fn ordered(sweep: &Sweep) -> (Vec<usize>, HashSet<usize>) {
    let mut rows: Vec<usize> = (0..sweep.plan.count()).collect();
    let mut shared = HashSet::new();
    if sweep.base.scene.press.is_some() && rows.len() <= MOST_GROUPED {
        let mut groups = HashMap::new();
        let group: Vec<usize> = rows
            .iter()
            .map(|&row| {
                let count = groups.len();
                *groups.entry(press_of(sweep, row)).or_insert(count)
            })
            .collect();
        rows.sort_by_key(|&row| group[row]);
        shared.extend(rows.windows(2).filter(|pair| group[pair[0]] == group[pair[1]]).flatten());
    }
    (rows, shared)
}

/// What a point's press depends on; none where it makes no scene.
fn press_of(sweep: &Sweep, row: usize) -> Option<String> {
    let loaded = sweep.scene(&sweep.plan.point(row).ok()?).ok()?;
    Some(format!("{:?}", press_setup(&loaded).ok()?))
}

/// Does work by as many threads of its own as cores are left to each of so many workers. Where presses share threads
/// they wait for each other: on 16 cores a press took 33 s beside 13 others.
fn on_its_share(workers: usize, work: impl FnOnce() + Send) {
    let threads = rayon::current_num_threads().div_ceil(workers);
    match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(work),
        Err(_) => work(),
    }
}

/// Computes what is free of these rows; the others remain.
fn pass(
    task: Task,
    session: &Session,
    options: Options,
    rows: Vec<usize>,
    tally: &mut Tally,
    observe: &mut Observer,
) -> Result<Vec<usize>, SweepError> {
    let queue = Mutex::new(VecDeque::from(rows));
    let stop = AtomicBool::new(false);
    let workers = options.workers.max(1);
    let (sender, receiver) = sync_channel(workers);
    std::thread::scope(|scope| {
        for _ in 0..workers {
            let sender = sender.clone();
            scope.spawn(|| on_its_share(workers, || work(task, &queue, &stop, sender)));
        }
        drop(sender);
        let mut left = Vec::new();
        let mut trace = || loop {
            let sent = match receiver.recv_timeout(LOOK) {
                Ok(sent) => sent,
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
                Err(RecvTimeoutError::Timeout) => match observe(Stage { done: tally.share(), what: "pressing" }) {
                    true => continue,
                    false => return Err(SweepError::Stopped),
                },
            };
            match sent {
                Sent::Ready(ready) => {
                    finish(task.sweep, task.records, session, *ready, tally, observe)?;
                    tally.done += 1;
                    tally.computed += 1;
                }
                Sent::There => tally.done += 1,
                Sent::Taken(row) => left.push(row),
                Sent::Stopped => return Err(SweepError::Stopped),
                Sent::Failed(error) => return Err(error.into()),
            }
        };
        let ended = trace();
        stop.store(true, Ordering::Relaxed);
        // Whoever waits to send finds nobody.
        drop(receiver);
        ended.map(|()| left)
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::output::Item;
    use crate::sweep::Record;
    use serde_json::json;
    use std::path::Path;

    /// From then on they are like any that are missing, which workers share by their claims.
    #[test]
    fn failures_alone_are_taken_back() {
        let place = tempfile::tempdir().unwrap();
        let text = "[sweep]\nscene = \"preset:contact-disc\"\ndesign = { kind = \"grid\" }\n[[vary]]\n\
                    key = \"stack.layer[0].n\"\nvalues = [1.40, 1.41, 1.42, 1.43]\n\
                    [[measure]]\nkind = \"mean_radiance\"\n";
        let sweep = Sweep::parse(text, Path::new("sweep.toml")).unwrap();
        let records = sweep.enter(&place.path().join("out"), false, false).unwrap();
        for (row, status) in ["done", "failed", "rejected", "failed"].into_iter().enumerate() {
            let record = json!({"row": row, "status": status, "values": [], "figures": [], "version": "",
                                "seconds": {"press": 0.0, "light": 0.0, "figures": 0.0}});
            records.keep_item(&item(row), &record).unwrap();
        }
        let there = || (0..4).map(|row| matches!(sweep.item(&records, row), Item::<Record>::There(_)));
        assert!(there().all(|there| there));
        forget_failures(&sweep, &records, &[0, 1, 2]).unwrap();
        assert_eq!(there().collect::<Vec<_>>(), [true, false, true, true], "row 3 is of another part");
        forget_failures(&sweep, &records, &[0, 1, 2, 3]).unwrap();
        assert_eq!(there().collect::<Vec<_>>(), [true, false, true, false]);
    }
}
