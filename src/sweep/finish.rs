//! Tracing a point, measuring it and keeping its record.

use super::measure::Found;
use super::ready::{Ready, Scene};
use super::record::item;
use super::tally::{SweepError, Tally};
use super::{Loads, Record, Seconds, State, Sweep, Traced};
use crate::mechanics::press::{PressStep, Pressed};
use crate::output::{OutputError, Records};
use crate::pipeline::{PipelineError, Session};
use crate::progress::{Observer, Stage};
use crate::trace::TraceError;
use std::time::Instant;

/// Traces a point, measures it and keeps its record.
pub(super) fn finish(
    sweep: &Sweep,
    records: &Records,
    session: &Session,
    ready: Ready,
    tally: &Tally,
    observe: &mut Observer,
) -> Result<(), SweepError> {
    let Ready { row, scene_sha256, values, press_seconds, what } = ready;
    let mut record = Record {
        row,
        status: State::Done,
        reason: None,
        scene_sha256,
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

/// Whether no other point can be traced either. A device that has no room now may have it later; what is more than it
/// ever allows is the point's own.
fn ends_all(error: &TraceError) -> bool {
    match error {
        TraceError::Stopped | TraceError::NoAdapter | TraceError::DeviceLost(_) | TraceError::Driver(_) => true,
        TraceError::Memory { allowed, .. } => *allowed == 0,
        _ => false,
    }
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
        PipelineError::Trace(error) if ends_all(&error) => End::Sweep(match error {
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
                images.keep_masks(records, record, shot).map_err(kept)?;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_that_no_device_allows_stops_no_other() {
        let memory = |allowed| TraceError::Memory { what: "film", needed: 1 << 30, allowed };
        assert!(ends_all(&memory(0)) && !ends_all(&memory(1 << 27)));
        assert!(ends_all(&TraceError::Stopped) && ends_all(&TraceError::NoAdapter));
    }
}
