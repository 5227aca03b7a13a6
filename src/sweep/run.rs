//! Computing the points of a sweep: the next one is pressed while this one is traced.

use super::measure::Found;
use super::{Kept, Loads, RandomNumbers, Rejected, Sweep, Told};
use crate::mechanics::from_scene::press_setup;
use crate::mechanics::path::PathError;
use crate::mechanics::press::{PressError, PressStep, Pressed};
use crate::output::{Claimed, Item, OutputError, Records};
use crate::pipeline::{Order, PipelineError, Prepared, Session};
use crate::progress::{Observer, Stage};
use crate::scene::LoadedScene;
use crate::streams::Sharing;
use crate::trace::{Devices, Precision, TraceError};
use crate::vary::{Point, Scalar};
use serde::{Deserialize, Serialize};
use std::collections::{HashMap, VecDeque};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Points whose presses are told apart before the work: beyond, points are taken in their order.
const MOST_GROUPED: usize = 5_000;
/// Between two looks whether to stop, or whether another worker has come to an end.
const LOOK: Duration = Duration::from_millis(200);

/// How points are computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// Threads that press; one traces beside them.
    pub workers: usize,
    /// Only the part k of n of the points, k from 1.
    pub shard: Option<(u32, u32)>,
    /// Whether points that failed are computed again.
    pub retry: bool,
}

/// How a point ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// Its figures are there.
    Done,
    /// It breaks a constraint, or a rule of scenes.
    Rejected,
    /// It could not be computed.
    Failed,
}

/// What is kept of a point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Its row, from 0.
    pub row: usize,
    /// How it ended.
    pub status: State,
    /// Why, where it has no figures.
    pub reason: Option<String>,
    /// A value for each variable; none where not all of them have one.
    pub values: Vec<Scalar>,
    /// Figures, in the order of the measures and their columns.
    pub figures: Vec<Told>,
    /// Of its image.
    pub traced: Option<Traced>,
    /// Its images that were kept.
    #[serde(default)]
    pub images: Vec<Kept>,
    /// What computed it.
    pub version: String,
    /// Where its time went.
    pub seconds: Seconds,
}

/// How an image was traced.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Traced {
    /// The light's random stream, and the sensor's.
    pub streams: [u32; 2],
    /// Camera paths a pixel.
    pub spp: u64,
    /// Photons.
    pub photons: u64,
    /// Relative error of a lit pixel.
    pub relative_error: Option<f64>,
    /// What traced it.
    pub adapter: String,
}

/// Where a point's time went, seconds.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Seconds {
    /// Scene, press and surfaces.
    pub press: f64,
    /// Tracing, and compiling where that had to be.
    pub light: f64,
    /// Figures.
    pub figures: f64,
}

/// Why a sweep came to no end.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// A record could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The device, not a point, is to blame.
    #[error("point {row}: {error}")]
    Device {
        /// The point that was traced.
        row: usize,
        /// What the tracer says.
        error: TraceError,
    },
    /// The caller stopped it.
    #[error("stopped")]
    Stopped,
}

/// A point ready to be traced, or its end.
struct Ready {
    row: usize,
    values: Vec<Scalar>,
    press_seconds: f64,
    what: Result<Scene, (State, String)>,
}

struct Scene {
    pressed: Option<Arc<Pressed>>,
    image: Option<Box<Prepared>>,
    baseline: Option<Box<Prepared>>,
}

enum Sent {
    Ready(Box<Ready>),
    /// It was there already.
    There,
    /// Another worker has it.
    Taken(usize),
    /// The caller stopped it.
    Stopped,
    Failed(OutputError),
}

/// Name of a point's record.
pub(super) fn item(row: usize) -> String {
    format!("{row:07}")
}

/// Computes the points that have no record yet.
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
) -> Result<(), SweepError> {
    let mut rows = shard(ordered(sweep), options.shard);
    let mut tally = Tally { done: 0, of: rows.len() };
    loop {
        rows = pass(sweep, records, session, options, rows, &mut tally, observe)?;
        if rows.is_empty() {
            return Ok(());
        }
        // Other workers have the rest: when they end, it is there, or free.
        std::thread::sleep(LOOK);
        let what = format!("{} points of other workers", rows.len());
        if !observe(Stage { done: tally.share(), what: &what }) {
            return Err(SweepError::Stopped);
        }
    }
}

struct Tally {
    done: usize,
    of: usize,
}

impl Tally {
    fn share(&self) -> f64 {
        self.done as f64 / self.of.max(1) as f64
    }
}

/// All rows, those that share a press after each other.
fn ordered(sweep: &Sweep) -> Vec<usize> {
    let mut rows: Vec<usize> = (0..sweep.plan.count()).collect();
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
    }
    rows
}

/// What a point's press depends on; none where it makes no scene.
fn press_of(sweep: &Sweep, row: usize) -> Option<String> {
    let loaded = sweep.scene(&sweep.plan.point(row).ok()?).ok()?;
    Some(format!("{:?}", press_setup(&loaded).ok()?))
}

/// A part of the rows: neighbours stay together.
fn shard(rows: Vec<usize>, shard: Option<(u32, u32)>) -> Vec<usize> {
    let Some((k, n)) = shard else { return rows };
    let end = |k: u32| (rows.len() as u64 * u64::from(k) / u64::from(n.max(1))) as usize;
    rows.get(end(k.saturating_sub(1))..end(k)).unwrap_or_default().to_vec()
}

/// Computes what is free of these rows; the others remain.
fn pass(
    sweep: &Sweep,
    records: &Records,
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
            scope.spawn(|| work(sweep, records, &queue, &stop, options.retry, sender));
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
                    finish(sweep, records, session, *ready, tally, observe)?;
                    tally.done += 1;
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

/// Makes one point after the other ready, until none is left or the caller stops.
fn work(
    sweep: &Sweep,
    records: &Records,
    queue: &Mutex<VecDeque<usize>>,
    stop: &AtomicBool,
    retry: bool,
    sender: SyncSender<Sent>,
) {
    let mut session = Session::from(Devices::cpu(Precision::F32));
    loop {
        let next = queue.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
        let (Some(row), false) = (next, stop.load(Ordering::Relaxed)) else { return };
        let sent = claimed(sweep, records, row, retry, &mut session, &mut |_| !stop.load(Ordering::Relaxed));
        if sender.send(sent).is_err() {
            records.let_go(&item(row));
            return;
        }
    }
}

/// Makes a point ready that nobody else has.
fn claimed(
    sweep: &Sweep,
    records: &Records,
    row: usize,
    retry: bool,
    session: &mut Session,
    observe: &mut Observer,
) -> Sent {
    let name = item(row);
    let is_kept = |record: &Record| !(retry && record.status == State::Failed);
    let is_there = || matches!(records.item::<Record>(&name), Item::There(record) if is_kept(&record));
    if is_there() {
        return Sent::There;
    }
    match records.claim(&name) {
        Ok(Claimed::Ours) => {}
        Ok(Claimed::Taken) => return Sent::Taken(row),
        Err(error) => return Sent::Failed(error),
    }
    // Whoever had it may have kept it in between.
    if is_there() {
        records.let_go(&name);
        return Sent::There;
    }
    let start = Instant::now();
    let (values, what) = match sweep.plan.point(row) {
        Ok(point) => {
            let what = ready(sweep, &point, session, observe);
            (point.values, what)
        }
        Err(reason) => (Vec::new(), Err(Some((State::Rejected, reason)))),
    };
    match what {
        Ok(scene) => {
            Sent::Ready(Box::new(Ready { row, values, press_seconds: start.elapsed().as_secs_f64(), what: Ok(scene) }))
        }
        Err(Some(end)) => {
            Sent::Ready(Box::new(Ready { row, values, press_seconds: start.elapsed().as_secs_f64(), what: Err(end) }))
        }
        Err(None) => {
            records.let_go(&name);
            Sent::Stopped
        }
    }
}

/// Presses a point and makes its surfaces; no reason where the caller stopped it.
fn ready(
    sweep: &Sweep,
    point: &Point,
    session: &mut Session,
    observe: &mut Observer,
) -> Result<Scene, Option<(State, String)>> {
    let failed = |error: PipelineError| match error {
        PipelineError::Press(PressError::Stopped { cause: PathError::Stopped, .. }) => None,
        error => Some((State::Failed, error.to_string())),
    };
    let loaded = sweep.scene(point).map_err(|rejected| match rejected {
        Rejected::Point(reason) => Some((State::Rejected, reason)),
        Rejected::Sweep(broken) => Some((State::Failed, broken.to_string())),
    })?;
    let order = order(sweep, &loaded);
    if !sweep.needs_light() {
        let pressed = session.press(&loaded, &order, observe).map_err(failed)?;
        return Ok(Scene { pressed: Some(pressed), image: None, baseline: None });
    }
    let image = session.prepare(loaded, &order, observe).map_err(failed)?;
    let baseline = match sweep.needs_baseline() {
        true => Some(Box::new(session.baseline(&image, observe).map_err(failed)?)),
        false => None,
    };
    let pressed = image.press.as_ref().map(|(pressed, _)| pressed.clone());
    Ok(Scene { pressed, image: Some(Box::new(image)), baseline })
}

/// How a point is traced.
fn order(sweep: &Sweep, loaded: &LoadedScene) -> Order {
    let mut order = Order { sharing: Sharing::Own, ..Order::of(&loaded.scene) };
    let asked = &sweep.file.sweep;
    order.settings.seed = asked.seed.unwrap_or(order.settings.seed);
    order.settings.target_error = asked.target_error.or(order.settings.target_error);
    // Common to all points, and still other ones for the image without inclusions.
    order.known_as = (asked.random_numbers == RandomNumbers::Common).then(|| sweep.base.identity().into());
    order
}

/// Traces a point, measures it and keeps its record.
fn finish(
    sweep: &Sweep,
    records: &Records,
    session: &Session,
    ready: Ready,
    tally: &Tally,
    observe: &mut Observer,
) -> Result<(), SweepError> {
    let Ready { row, values, press_seconds, what } = ready;
    let mut record = Record {
        row,
        status: State::Done,
        reason: None,
        values,
        figures: Vec::new(),
        traced: None,
        images: Vec::new(),
        version: env!("CARGO_PKG_VERSION").into(),
        seconds: Seconds { press: press_seconds, ..Seconds::default() },
    };
    let what_is_traced = format!("point {} of {}", tally.done + 1, tally.of);
    let mut watch = |stage: Stage| {
        observe(Stage { done: (tally.done as f64 + stage.done) / tally.of.max(1) as f64, what: &what_is_traced })
    };
    let end = match what {
        Ok(scene) => measure(sweep, records, session, &scene, &mut record, &mut watch),
        Err((status, reason)) => Err(End::Point(status, reason)),
    };
    match end {
        Ok(()) => {}
        Err(End::Point(status, reason)) => (record.status, record.reason) = (status, Some(reason)),
        Err(End::Sweep(error)) => {
            records.let_go(&item(row));
            return Err(error);
        }
    }
    records.keep_item(&item(row), &record)?;
    records.let_go(&item(row));
    Ok(())
}

/// What ends a point, or all of them.
enum End {
    Point(State, String),
    Sweep(SweepError),
}

/// Traces, measures and keeps images.
fn measure(
    sweep: &Sweep,
    records: &Records,
    session: &Session,
    scene: &Scene,
    record: &mut Record,
    observe: &mut Observer,
) -> Result<(), End> {
    let row = record.row;
    let failed = |error: PipelineError| match error {
        PipelineError::Trace(
            error @ (TraceError::Stopped
            | TraceError::NoAdapter
            | TraceError::DeviceLost(_)
            | TraceError::Memory { .. }
            | TraceError::Driver(_)),
        ) => End::Sweep(match error {
            TraceError::Stopped => SweepError::Stopped,
            error => SweepError::Device { row, error },
        }),
        error => End::Point(State::Failed, error.to_string()),
    };
    let start = Instant::now();
    let baseline = match &scene.baseline {
        Some(prepared) => {
            let watch = &mut |stage: Stage| observe(Stage { done: 0.5 * stage.done, ..stage });
            Some(session.shoot(prepared, watch).map_err(failed)?)
        }
        None => None,
    };
    let before = if baseline.is_some() { 0.5 } else { 0.0 };
    let shot = match &scene.image {
        Some(prepared) => {
            let watch = &mut |stage: Stage| observe(Stage { done: before + (1.0 - before) * stage.done, ..stage });
            Some(session.shoot(prepared, watch).map_err(failed)?)
        }
        None => None,
    };
    if let Some(images) = &sweep.file.sweep.images {
        let kept = |error: OutputError| End::Sweep(error.into());
        if let (Some(prepared), Loads::All) = (&scene.image, images.loads) {
            let last = prepared.press.as_ref().map_or(0, |(_, load)| *load);
            for load in 0..last {
                let earlier = prepared.at_load(load).map_err(failed)?;
                let shot = session.shoot(&earlier, &mut |stage| observe(stage)).map_err(failed)?;
                record.images.push(images.keep(records, row, &shot, Some(load)).map_err(kept)?);
            }
        }
        if let Some(shot) = &shot {
            let load = shot.prepared.press.as_ref().map(|(_, load)| *load);
            record.images.push(images.keep(records, row, shot, load).map_err(kept)?);
            if images.masks {
                images.keep_mask(records, row, shot).map_err(kept)?;
            }
        }
        if let (Some(shot), true) = (&baseline, images.baseline) {
            images.keep_baseline(records, row, shot).map_err(kept)?;
        }
    }
    record.seconds.light = start.elapsed().as_secs_f64();
    record.traced = shot.as_ref().map(|shot| Traced {
        streams: [shot.prepared.streams.light(), shot.prepared.streams.sensor()],
        spp: shot.outcome.spp,
        photons: shot.outcome.photons,
        relative_error: shot.outcome.relative_error,
        adapter: shot.outcome.adapter.clone(),
    });
    let start = Instant::now();
    let last = |pressed: &'_ Pressed| pressed.steps.len().checked_sub(1);
    let pressed: Option<(&Pressed, &PressStep)> = match (&shot, &scene.pressed) {
        (Some(shot), _) => shot.prepared.pressed(),
        (None, Some(pressed)) => last(pressed).and_then(|k| Some((&**pressed, pressed.steps.get(k)?))),
        (None, None) => None,
    };
    let found = Found { pressed, shot: shot.as_ref(), baseline: baseline.as_ref() };
    record.figures = sweep.file.measure.iter().flat_map(|measure| measure.of(&found)).collect();
    record.seconds.figures = start.elapsed().as_secs_f64();
    Ok(())
}
