//! Workers that claim points, press them and make their surfaces.

use super::record::item;
use super::shelf::Presses;
use super::{RandomNumbers, Rejected, State, Sweep};
use crate::mechanics::path::PathError;
use crate::mechanics::press::{PressError, Pressed};
use crate::output::{Claimed, Item, OutputError, Records};
use crate::pipeline::{Order, PipelineError, Prepared, Session, Shelf};
use crate::progress::Observer;
use crate::scene::{LoadedScene, sha256};
use crate::streams::Sharing;
use crate::trace::{Devices, Precision};
use crate::vary::{Point, Scalar};
use std::collections::{HashSet, VecDeque};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// A point ready to be traced, or its end.
pub(super) struct Ready {
    pub row: usize,
    pub scene_sha256: Option<String>,
    pub values: Vec<Scalar>,
    pub press_seconds: f64,
    pub what: Result<Scene, (State, String)>,
}

/// A scene that is pressed, with its surfaces; without images where nothing asks for light.
pub(super) struct Scene {
    pub pressed: Option<Arc<Pressed>>,
    pub image: Option<Box<Prepared>>,
    pub baseline: Option<Box<Prepared>>,
}

/// What a worker says of a point.
pub(super) enum Sent {
    Ready(Box<Ready>),
    /// It was there already.
    There,
    /// Another worker has it.
    Taken(usize),
    /// The caller stopped it.
    Stopped,
    Failed(OutputError),
}

/// What workers work on.
#[derive(Clone, Copy)]
pub(super) struct Task<'a> {
    pub sweep: &'a Sweep,
    pub records: &'a Records,
    /// Rows that share their press with another one.
    pub shared: &'a HashSet<usize>,
    /// Those presses.
    pub presses: &'a Presses<'a>,
}

/// Makes one point after the other ready, until none is left or the caller stops.
pub(super) fn work(task: Task, queue: &Mutex<VecDeque<usize>>, stop: &AtomicBool, sender: SyncSender<Sent>) {
    let mut session = Session::from(Devices::cpu(Precision::F32));
    loop {
        let next = queue.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
        let (Some(row), false) = (next, stop.load(Ordering::Relaxed)) else { return };
        let sent = claimed(task, row, &mut session, &mut |_| !stop.load(Ordering::Relaxed));
        if sender.send(sent).is_err() {
            // Nobody is there to finish it any more.
            task.records.let_go(&item(row));
            return;
        }
    }
}

/// Makes a point ready that nobody else has.
fn claimed(task: Task, row: usize, session: &mut Session, observe: &mut Observer) -> Sent {
    let Task { sweep, records, .. } = task;
    let name = item(row);
    let is_there = || matches!(sweep.item(records, row), Item::There(_));
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
            let what = ready(task, row, &point, session, observe);
            (point.values, what)
        }
        Err(reason) => (sweep.plan.values(row), Err(Some((State::Rejected, reason)))),
    };
    let scene_sha256 = sweep.scene_text(row).ok().map(|text| sha256(text.as_bytes()));
    // No reason: the caller stopped it.
    let what = match what {
        Ok(scene) => Ok(scene),
        Err(Some(end)) => Err(end),
        Err(None) => {
            records.let_go(&name);
            return Sent::Stopped;
        }
    };
    Sent::Ready(Box::new(Ready { row, scene_sha256, values, press_seconds: start.elapsed().as_secs_f64(), what }))
}

/// Presses a point and makes its surfaces; no reason where the caller stopped it.
fn ready(
    Task { sweep, shared, presses, .. }: Task,
    row: usize,
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
        Rejected::Sweep(broken) => Some((State::Rejected, broken.to_string())),
    })?;
    let order = order(sweep, row, &loaded);
    let shelf: &dyn Shelf = if shared.contains(&row) { presses } else { &() };
    if !sweep.needs_light() {
        let pressed = session.press_by(shelf, &loaded, &order, observe).map_err(failed)?;
        return Ok(Scene { pressed: Some(pressed), image: None, baseline: None });
    }
    if loaded.scene.press.is_some() {
        // The session has it then.
        session.press_by(shelf, &loaded, &order, observe).map_err(failed)?;
    }
    let image = session.prepare(loaded, &order, observe).map_err(failed)?;
    let baseline = match sweep.needs_baseline() {
        true => Some(Box::new(session.baseline_by(shelf, &image, observe).map_err(failed)?)),
        false => None,
    };
    let pressed = image.press.as_ref().map(|(pressed, _)| pressed.clone());
    Ok(Scene { pressed, image: Some(Box::new(image)), baseline })
}

/// How a point is traced.
fn order(sweep: &Sweep, row: usize, loaded: &LoadedScene) -> Order {
    let mut order = Order { sharing: Sharing::Own, ..Order::of(&loaded.scene) };
    let asked = &sweep.file.sweep;
    order.settings.seed = asked.seed.unwrap_or(order.settings.seed);
    order.settings.target_error = asked.target_error.or(order.settings.target_error);
    // Common to all points, or to those of one trajectory or base point, and still other ones for the image without
    // inclusions.
    order.known_as = (asked.random_numbers == RandomNumbers::Common).then(|| {
        let block = asked.design.block(sweep.plan.free().len()).map(|length| format!(" block {}", row / length));
        (sweep.base.identity() + &block.unwrap_or_default()).into()
    });
    order
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn points_have_numbers_in_common_as_far_as_their_differences_are_taken() {
        let known_as = |design: &str, random_numbers: &str| -> Vec<_> {
            let vary = |k: usize| format!("[[vary]]\nkey = \"stack.layer[{k}].n\"\nuniform = [1.40, 1.41]\n");
            let text = format!(
                "[sweep]\nscene = \"preset:contact-disc\"\ndesign = {design}\nrandom_numbers = \"{random_numbers}\"\n\
                 {}{}[[measure]]\nkind = \"mean_radiance\"\n",
                vary(0),
                vary(1)
            );
            let sweep = Sweep::parse(&text, Path::new("sweep.toml")).unwrap();
            (0..8).map(|row| order(&sweep, row, &sweep.base).known_as).collect()
        };
        let blocks = |design: &str| -> Vec<usize> {
            let names = known_as(design, "common");
            names.iter().map(|name| names.iter().position(|other| other == name && name.is_some()).unwrap()).collect()
        };
        let [sobol, morris, saltelli] = [
            "{ kind = \"sobol\", points = 8 }",
            "{ kind = \"morris\", trajectories = 6 }",
            "{ kind = \"saltelli\", points = 64 }",
        ];
        assert_eq!(blocks(sobol), [0; 8]);
        assert_eq!(blocks(morris), [0, 0, 0, 3, 3, 3, 6, 6]);
        assert_eq!(blocks(saltelli), [0, 0, 0, 0, 4, 4, 4, 4]);
        // By their own scenes, then.
        assert_eq!(known_as(morris, "own"), vec![None; 8]);
    }
}
