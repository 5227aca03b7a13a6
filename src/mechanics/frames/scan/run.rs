//! All positions of a scan.

use super::compliance::Compliance;
use super::press::{Pressed, press, press_linear, press_to_force};
use super::sample::frame;
use super::{FrameError, ScanError, ScanSetup, Shown};
use crate::mechanics::frames::{Frame, Frames};
use crate::mechanics::mesh::Mesh;
use crate::mechanics::path::PathError;
use crate::mechanics::press::contact_points;
use crate::progress::Stage;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// What a scan computes beside its frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanSettings {
    /// The position whose whole state is kept, mm: the nearest one is.
    pub shown_mm: f64,
    /// A second press of that position on elements of twice the size estimates the error.
    pub estimate_error: bool,
}

/// A scan with all of its frames.
#[derive(Debug, Clone)]
pub struct Scanned {
    /// Frames of the tissue as it is.
    pub frames: Frames,
    /// Frames at the same positions without the inclusions.
    pub without: Frames,
    /// Force on the indenter at each position, N per mm of its length.
    pub force_n_per_mm: Vec<f64>,
    /// The position that was asked for, whole.
    pub shown: Shown,
    /// Error of that frame, where it was estimated.
    pub error: Option<FrameError>,
    /// Displacement unknowns.
    pub unknowns: usize,
    /// Whether linear tissue let one factorisation serve all positions.
    pub one_factorisation: bool,
    /// Newton iterations, all positions, with and without inclusions.
    pub iterations: usize,
    /// Seconds, without the error estimate.
    pub seconds: f64,
    /// Seconds of the error estimate.
    pub error_seconds: f64,
}

/// Error of the finer mesh as a share of the difference of the two: 1 / (2^q - 1) with q = 1, because the edge of the
/// contact, where the pressure's slope is infinite, is met to a share of an element.
const SHARE: f64 = 1.0;

/// Shares of the work after the factorisations and after the last position: measured on the preset.
const FACTORISED: f64 = 0.5;
const PRESSED: f64 = 0.98;

/// What is left of a position.
struct Done {
    frame: Frame,
    force_n_per_mm: f64,
    iterations: usize,
    unknowns: usize,
    shown: Option<Shown>,
}

/// Presses at every position. `observe` hears how far it is, from any thread, and may stop it.
///
/// # Errors
/// [`ScanError`]; a position that does not converge is named.
pub fn scan(
    setup: &ScanSetup,
    settings: ScanSettings,
    observe: &(dyn Fn(Stage) -> bool + Sync),
) -> Result<Scanned, ScanError> {
    let started = Instant::now();
    let mesh = setup.tissue.build_2d()?;
    let tissues = [(setup.clone(), "with its inclusions"), (setup.without_inclusions(), "without inclusions")];
    let compliances = compliances(&tissues, &mesh, observe)?;
    let first = if compliances.is_some() { FACTORISED } else { 0.0 };
    let shown = nearest(&setup.positions_mm, settings.shown_mm);
    let (finished, all) = (AtomicUsize::new(0), 2 * setup.positions_mm.len());
    let stage = || {
        let share = finished.load(Ordering::Relaxed) as f64 / all as f64;
        observe(Stage { done: first + (PRESSED - first) * share, what: "pressing" })
    };
    let jobs: Vec<(usize, usize)> = (0..setup.positions_mm.len()).flat_map(|k| [(k, 0), (k, 1)]).collect();
    let done: Vec<Done> = jobs
        .par_iter()
        .map(|&(k, which)| {
            let (tissue, name) = &tissues[which];
            let (position_mm, keep) = (setup.positions_mm[k], which == 0 && k == shown);
            if !stage() {
                return Err(ScanError::Stopped);
            }
            // What is shown needs more than the face.
            let compliance = compliances.as_ref().filter(|_| !keep).map(|both| &both[which]);
            let pressed = match compliance.and_then(|c| press_linear(tissue, &mesh, c, position_mm)) {
                Some(pressed) => pressed,
                None => press(tissue, &mesh, position_mm, &mut |_| stage()).map_err(|cause| match cause {
                    PathError::Stopped => ScanError::Stopped,
                    cause => ScanError::Position { position_mm, tissue: name, cause },
                })?,
            };
            finished.fetch_add(1, Ordering::Relaxed);
            Ok(reduce(pressed, position_mm, &setup.places_mm, keep))
        })
        .collect::<Result<_, ScanError>>()?;
    let one_factorisation = compliances.is_some();
    let iterations = done.iter().map(|one| one.iterations).sum();
    let unknowns = done.first().map_or(0, |one| one.unknowns);
    let (mut frames, mut without, mut force_n_per_mm, mut kept) = (Vec::new(), Vec::new(), Vec::new(), None);
    for (one, (_, which)) in done.into_iter().zip(jobs) {
        kept = kept.or(one.shown);
        if which == 0 {
            frames.push(one.frame);
            force_n_per_mm.push(one.force_n_per_mm);
        } else {
            without.push(one.frame);
        }
    }
    let seconds = started.elapsed().as_secs_f64();
    let (frames, without) = (Frames::new(frames)?, Frames::new(without)?);
    let shown = kept.ok_or(ScanError::Stopped)?;
    let started = Instant::now();
    let error = match settings.estimate_error {
        true => estimate(setup, &shown, &mut |_| observe(Stage { done: PRESSED, what: "estimating the error" }))?,
        false => None,
    };
    let error_seconds = started.elapsed().as_secs_f64();
    Ok(Scanned {
        frames,
        without,
        force_n_per_mm,
        shown,
        error,
        unknowns,
        one_factorisation,
        iterations,
        seconds,
        error_seconds,
    })
}

/// What is the same at each position of a scan of unknown tissue.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Held<'a> {
    /// The depth of the press, as the setup says.
    Depth,
    /// The force at each position, N per mm of the indenter's length.
    Force(&'a [f64]),
}

/// The frames alone of the tissue as it is, on a mesh of it. `observe` is asked between positions, from any thread, and
/// may stop it.
///
/// # Errors
/// [`ScanError`]; `Force` for any force on tissue that is not linear, or does not slide.
pub fn frames(
    setup: &ScanSetup,
    mesh: &Mesh,
    held: Held,
    observe: &(dyn Fn() -> bool + Sync),
) -> Result<Frames, ScanError> {
    let compliance = match Compliance::suits(setup) {
        true => Compliance::new(setup, mesh, &|| observe())
            .map_or(Ok(None), |made| made.map(Some).ok_or(ScanError::Stopped))?,
        false => None,
    };
    let positions = 0..setup.positions_mm.len();
    let pressed = positions.into_par_iter().map(|k| {
        if !observe() {
            return Err(ScanError::Stopped);
        }
        let position_mm = setup.positions_mm[k];
        let failed = |cause| ScanError::Position { position_mm, tissue: "with its inclusions", cause };
        let pressed = match (held, &compliance) {
            (Held::Force(forces), Some(c)) => {
                let force = forces.get(k).copied().unwrap_or(0.0);
                press_to_force(setup, mesh, c, position_mm, force).ok_or(ScanError::Force { position_mm })?
            }
            (Held::Force(_), None) => return Err(ScanError::Force { position_mm }),
            (Held::Depth, c) => match c.as_ref().and_then(|c| press_linear(setup, mesh, c, position_mm)) {
                Some(pressed) => pressed,
                None => press(setup, mesh, position_mm, &mut |_| observe()).map_err(|cause| match cause {
                    PathError::Stopped => ScanError::Stopped,
                    cause => failed(cause),
                })?,
            },
        };
        Ok(reduce(pressed, position_mm, &setup.places_mm, false).frame)
    });
    Ok(Frames::new(pressed.collect::<Result<_, _>>()?)?)
}

/// Compliances of both tissues, where they are linear enough and can be factorised.
fn compliances(
    tissues: &[(ScanSetup, &str); 2],
    mesh: &Mesh,
    observe: &(dyn Fn(Stage) -> bool + Sync),
) -> Result<Option<Vec<Compliance>>, ScanError> {
    if !Compliance::suits(&tissues[0].0) {
        return Ok(None);
    }
    let mut both = Vec::new();
    for ((tissue, _), first) in tissues.iter().zip([0.0, 0.5]) {
        let observe = || observe(Stage { done: FACTORISED * first, what: "factorising" });
        match Compliance::new(tissue, mesh, &observe) {
            Ok(Some(compliance)) => both.push(compliance),
            Ok(None) => return Err(ScanError::Stopped),
            // Then each position has to be solved whole.
            Err(_) => return Ok(None),
        }
    }
    Ok(Some(both))
}

/// Place of the position nearest to one.
fn nearest(positions: &[f64], to: f64) -> usize {
    let mut best = 0;
    for (k, position) in positions.iter().enumerate() {
        if (position - to).abs() < (positions[best] - to).abs() {
            best = k;
        }
    }
    best
}

fn reduce(pressed: Pressed, position_mm: f64, places_mm: &[f64], keep: bool) -> Done {
    let Pressed { problem, state, iterations } = pressed;
    let points = contact_points(&problem, 0, &state);
    Done {
        frame: frame(&points, position_mm, places_mm),
        force_n_per_mm: 1e-3 * points.iter().map(|point| point.force_mn).sum::<f64>(),
        iterations,
        unknowns: problem.unknowns(),
        shown: keep.then_some(Shown { position_mm, problem, state, points }),
    }
}

/// Presses the shown position again on elements of twice the size; nothing where that mesh does not converge.
fn estimate(
    setup: &ScanSetup,
    shown: &Shown,
    observe: &mut dyn FnMut(f64) -> bool,
) -> Result<Option<FrameError>, ScanError> {
    let coarse = setup.halved();
    let mesh = coarse.tissue.build_2d()?;
    let coarse = match press(&coarse, &mesh, shown.position_mm, observe) {
        Ok(coarse) => reduce(coarse, shown.position_mm, &setup.places_mm, false).frame,
        Err(PathError::Stopped) => return Err(ScanError::Stopped),
        Err(_) => return Ok(None),
    };
    let fine = frame(&shown.points, shown.position_mm, &setup.places_mm);
    let squares = |values: &mut dyn Iterator<Item = f64>| values.map(|p| p * p).sum::<f64>();
    let pairs = || fine.pressure_kpa.iter().zip(&coarse.pressure_kpa);
    let size = squares(&mut fine.pressure_kpa.iter().copied());
    let peak = |frame: &Frame| frame.pressure_kpa.iter().copied().fold(0.0, f64::max);
    let (high, low) = (peak(&fine), peak(&coarse));
    Ok((size > 0.0 && high > 0.0).then_some(FrameError {
        position_mm: shown.position_mm,
        rms: SHARE * (squares(&mut pairs().map(|(a, b)| a - b)) / size).sqrt(),
        peak: SHARE * (high - low).abs() / high,
    }))
}
