//! Trials: one exposure of one phantom, inverted.

use super::StudyError;
use crate::calibrate::{
    CalibrateError, FORCE_ERROR, FrameModel, Frames, Inclusion, Inferred, InferredUnknown, Limits, PressFrame,
    same_depth, sweep_of,
};
use crate::camera::expose;
use crate::camera::noise::PixelRandom;
use crate::estimate::{Estimates, GreyImage, Value};
use crate::film::Film;
use crate::image_io::read_radiance;
use crate::output::Records;
use crate::pipeline::Truth;
use crate::scene::{Camera, LoadedScene};
use crate::streams::Streams;
use crate::sweep::{Record, Rejected, Sweep};
use rayon::prelude::*;
use serde::Serialize;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Draws among which the truth has a rank.
pub(super) const RANKED: usize = 99;

/// One exposure of one phantom.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trial {
    /// Row of the phantom in its sweep.
    pub row: usize,
    /// Which exposure, from 0.
    pub exposure: u32,
    /// The inclusion that is there, if there is one.
    pub truth: Option<Inclusion>,
    /// Young's modulus of the phantom itself, kPa.
    pub phantom_youngs_kpa: Option<f64>,
    /// What its frames say.
    pub estimates: Estimates,
    /// Rank of the true size, depth and modulus among 99 draws of the posterior within the ranges that truths are drawn
    /// from, 0 to 99; none where there are no draws.
    pub ranks: [Option<usize>; 3],
    /// Least standard deviations of size, depth and modulus by what frames and forces tell of the calibration's scores,
    /// shares of the truth: the Cramér-Rao bound, without the calibration's own error. None where there are no draws,
    /// or what is true of an unknown was not learnt.
    pub bounds: [Option<f64>; 3],
    /// The calibration's unknowns that the phantoms' sweep has variables of, by their names.
    pub others: Vec<Other>,
}

/// An unknown of the calibration, by its name.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Other {
    /// The name.
    pub name: String,
    /// What is true of it.
    pub truth: f64,
    /// What its frames say.
    pub value: Value,
}

/// How phantoms are tried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct How<'a> {
    /// An inclusion is of the phantom's own modulus, and none.
    pub empty: bool,
    /// Exposures of each phantom.
    pub exposures: u32,
    /// Their time, ms; none: the scene's.
    pub exposure_ms: Option<f64>,
    /// Relative error of the forces, told beside the frames; none: they are not.
    pub force_error: Option<f64>,
    /// Depths of the presses whose frames are told, mm; none: all.
    pub depths_mm: Option<&'a [f64]>,
}

/// Trials of all phantoms of a sweep's folder. `observe` is told how many phantoms are done, of how many, and stops the
/// work by saying no.
///
/// # Errors
/// A folder that is none of a sweep that keeps the radiance of the calibration's loads.
pub fn trials(
    model: &FrameModel,
    folder: &Path,
    how: How<'_>,
    observe: &(dyn Fn(usize, usize) -> bool + Sync),
) -> Result<Option<Vec<Trial>>, StudyError> {
    let (sweep, records) = sweep_of(folder)?;
    let depths_mm = sweep.base.scene.press.as_ref().and_then(|press| press.depths_mm.clone()).unwrap_or_default();
    let same = |(ours, theirs): (&f64, &f64)| same_depth(*ours, *theirs);
    let known = model.depths_mm.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
    if depths_mm.len() != model.depths_mm.len() || !depths_mm.iter().zip(&model.depths_mm).all(same) {
        let why = format!("must press to {known} mm, as the calibration does");
        return Err(CalibrateError::Unsuited { folder: folder.to_path_buf(), why }.into());
    }
    let unknown = |asked: &&f64| !model.depths_mm.iter().any(|known| same_depth(**asked, *known));
    if let Some(asked) = how.depths_mm.iter().copied().flatten().find(unknown) {
        return Err(StudyError::Depth { asked: *asked, known });
    }
    let kept: Vec<(usize, Record)> = sweep.kept(&records).collect();
    let ranges = model.unknowns().map(|(unknown, keys)| range(&sweep, &unknown.name, keys)).collect();
    let limits = Limits::of(model)?;
    let (done, study) =
        (AtomicUsize::new(0), Phantoms { model, limits, sweep: &sweep, records: &records, how, ranges });
    let each = |(row, record): &(usize, Record)| {
        if !observe(done.load(Ordering::Relaxed), kept.len()) {
            return Ok(None);
        }
        let trials = study.one(*row, record)?;
        done.fetch_add(1, Ordering::Relaxed);
        Ok(Some(trials))
    };
    let all = kept.par_iter().map(each).collect::<Result<Option<Vec<_>>, StudyError>>()?;
    Ok(all.map(|all| all.into_iter().flatten().collect()))
}

/// What a sweep kept of a point.
pub(super) struct Seen {
    /// Its scene.
    pub loaded: LoadedScene,
    /// Radiance of its loads.
    pub films: Vec<Film>,
}

/// A point of a sweep that kept radiance.
pub(super) fn seen(sweep: &Sweep, records: &Records, row: usize, record: &Record) -> Result<Seen, StudyError> {
    let unsuited = |why: String| CalibrateError::Unsuited { folder: records.folder().to_path_buf(), why };
    let point = sweep.plan.point(row).map_err(unsuited)?;
    let loaded = sweep.scene(&point).map_err(|rejected| match rejected {
        Rejected::Point(why) => unsuited(format!("point {row}: {why}")),
        Rejected::Sweep(broken) => unsuited(broken.to_string()),
    })?;
    let split = sweep.file.sweep.images.map_or("", |images| images.split(row));
    let folder = records.folder().join(split);
    let films = record.images.iter().map(|kept| Ok(read_radiance(&folder.join(&kept.file))?.0));
    Ok(Seen { loaded, films: films.collect::<Result<_, CalibrateError>>()? })
}

/// A frame of a camera; each exposure has noise of its own.
pub(super) fn exposed(
    film: &Film,
    camera: &Camera,
    wavelength_nm: f64,
    exposure: u32,
) -> Result<GreyImage, StudyError> {
    let seed = Streams::of_image(exposure, &film.mean).sensor();
    Ok(GreyImage::from_frame(&expose(film, camera, wavelength_nm, seed)?)?)
}

struct Phantoms<'a> {
    model: &'a FrameModel,
    limits: Limits<'a>,
    sweep: &'a Sweep,
    records: &'a Records,
    how: How<'a>,
    /// Where the truth of each unknown is drawn from.
    ranges: Vec<Option<[f64; 2]>>,
}

/// A sweep's variable of a name and keys.
fn variable(sweep: &Sweep, name: &str, keys: &[String]) -> Option<usize> {
    let place = sweep.plan.names().position(|own| own == name)?;
    let own = sweep.file.vary.get(place)?.key.as_ref().map(|keys| keys.all()).unwrap_or_default();
    (own == keys).then_some(place)
}

/// The range that it is drawn from; none where it has none.
fn range(sweep: &Sweep, name: &str, keys: &[String]) -> Option<[f64; 2]> {
    let vary = sweep.file.vary.get(variable(sweep, name, keys)?)?;
    vary.uniform.or(vary.log_uniform)
}

impl Phantoms<'_> {
    fn one(&self, row: usize, record: &Record) -> Result<Vec<Trial>, StudyError> {
        let Seen { loaded, films } = seen(self.sweep, self.records, row, record)?;
        let (mut camera, wavelength_nm) = (loaded.scene.camera.clone(), loaded.scene.light.wavelength_nm);
        camera.sensor.exposure_ms = self.how.exposure_ms.unwrap_or(camera.sensor.exposure_ms);
        let truth = Truth::of(loaded.scene.phantom.as_ref(), &loaded.files, self.how.empty)?;
        let figures = [&truth.size_mm, &truth.depth_mm, &truth.youngs_kpa].map(|figure| figure.value());
        let inclusion = match figures {
            [Some(size_mm), Some(depth_mm), Some(youngs_kpa)] => Some(Inclusion { size_mm, depth_mm, youngs_kpa }),
            _ => None,
        };
        let exposure = |exposure: u32| {
            let frame = |film: &Film| exposed(film, &camera, wavelength_nm, exposure);
            let frames = films.iter().map(frame).collect::<Result<Vec<_>, _>>()?;
            let frame = |(load, image)| {
                let depth_mm = self.model.depths_mm.get(load).copied()?;
                if self.how.depths_mm.is_some_and(|told| !told.iter().any(|told| same_depth(*told, depth_mm))) {
                    return None;
                }
                Some(PressFrame { depth_mm, image, force_n: self.force_n(record, load, exposure) })
            };
            let frames = frames.iter().enumerate().filter_map(frame).collect();
            let force_error = self.how.force_error.unwrap_or(FORCE_ERROR);
            let (estimates, inferred) =
                self.model.inverted(&Frames { camera: &camera, wavelength_nm, frames, force_error });
            let rank = |k: usize| {
                let share =
                    inferred.as_ref().ok()?.posterior.below(self.model.unknown(k)?, figures[k]?, &self.ranges)?;
                Some(((share * (RANKED + 1) as f64) as usize).min(RANKED))
            };
            let others: Vec<Other> = inferred.iter().flat_map(|inferred| self.others(record, inferred)).collect();
            let bounds = inferred.iter().zip(&inclusion).find_map(|(inferred, inclusion)| {
                let others: Vec<(&str, f64)> = others.iter().map(|one| (one.name.as_str(), one.truth)).collect();
                self.limits.by(&inferred.told, inclusion, &others).ok()
            });
            let bounds = bounds.map_or([None; 3], |bounds| {
                [&bounds.size, &bounds.depth, &bounds.youngs].map(|bound| bound.best().copied())
            });
            Ok(Trial {
                row,
                exposure,
                truth: inclusion,
                phantom_youngs_kpa: truth.phantom_youngs_kpa.value(),
                ranks: [0, 1, 2].map(rank),
                bounds,
                estimates,
                others,
            })
        };
        (0..self.how.exposures).map(exposure).collect()
    }

    /// The force of a load, N, as it is measured with an exposure; none where forces are not told.
    fn force_n(&self, record: &Record, load: usize, exposure: u32) -> Option<f64> {
        let kept = record.images.get(load)?;
        // Of the image's own stream, and apart from the noise of its pixels.
        let error = PixelRandom::new(kept.streams[1] ^ exposure, u32::MAX).normal();
        Some(kept.force_n()? * (self.how.force_error? * error).exp())
    }

    /// What is inferred of variables that the sweep draws under the calibration's names and keys.
    fn others(&self, record: &Record, inferred: &Inferred) -> Vec<Other> {
        let of = |unknown: &InferredUnknown| {
            let truth = record.values.get(variable(self.sweep, &unknown.name, &unknown.keys)?)?.number()?;
            Some(Other { name: unknown.name.clone(), truth, value: unknown.value.clone() })
        };
        inferred.unknowns.iter().filter_map(of).collect()
    }
}
