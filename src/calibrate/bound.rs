//! What a measuring protocol can tell: the Cramér-Rao bound of size, depth and modulus by a calibration's frames.

use super::model::Role;
use super::reader::Reader;
use super::{Blocks, CalibrateError, FrameModel};
use crate::emulate::{Slopes, Variances};
use crate::estimate::Value;
use crate::infer::{Seen, Told};
use crate::scene::Camera;
use serde::Serialize;

/// How frames are taken.
#[derive(Debug, Clone, PartialEq)]
pub struct Protocol {
    /// The camera.
    pub camera: Camera,
    /// Wavelength of the light, nm.
    pub wavelength_nm: f64,
    /// Exposure, ms; none: the longest that saturates no part of the frames.
    pub exposure_ms: Option<f64>,
    /// Frames at each load of the calibration.
    pub frames: Vec<u32>,
    /// Relative standard deviation of the force of each load with a frame; none: forces are not measured.
    pub force_error: Option<f64>,
}

/// An inclusion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Inclusion {
    /// Diameter, mm.
    pub size_mm: f64,
    /// Depth of its top, mm.
    pub depth_mm: f64,
    /// Young's modulus, kPa.
    pub youngs_kpa: f64,
}

/// Least standard deviations of what is estimated, each a share of its value, with the interval of 95 % that the
/// calibration's slopes leave.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Bounds {
    /// Of the diameter.
    pub size: Value,
    /// Of the depth of its top.
    pub depth: Value,
    /// Of Young's modulus.
    pub youngs: Value,
}

/// Bounds by one calibration, for many inclusions.
pub struct Limits<'a> {
    model: &'a FrameModel,
    variances: Vec<Variances<'a>>,
}

impl<'a> Limits<'a> {
    /// # Errors
    /// A calibration that cannot be inverted.
    pub fn of(model: &'a FrameModel) -> Result<Self, CalibrateError> {
        Ok(Self { model, variances: model.learnt.scored.variances_of_scores()? })
    }

    /// Bounds for an inclusion: what is integrated away lies in the middle of what was learnt. Light has no noise of
    /// its own; `whole` adds the calibration's error to the camera's noise.
    ///
    /// # Errors
    /// Says why there are none: an inclusion that was not learnt of, frames that cannot be read.
    pub fn bounds(&self, inclusion: &Inclusion, protocol: &Protocol, whole: bool) -> Result<Bounds, String> {
        let place = self.model.place(inclusion, &[])?;
        let told = self.model.expected(&place, protocol)?;
        self.where_told(&place, inclusion, &told, whole)
    }

    /// Bounds for an inclusion by frames that were taken of it: what they told, the noise of their light with it. The
    /// phantom's other unknowns are those of these names, or lie in the middle of what was learnt.
    ///
    /// # Errors
    /// As [`Self::bounds`].
    pub(crate) fn by(&self, told: &Told, inclusion: &Inclusion, others: &[(&str, f64)]) -> Result<Bounds, String> {
        self.where_told(&self.model.place(inclusion, others)?, inclusion, told, false)
    }

    /// Bounds where frames told this much.
    fn where_told(&self, place: &[f64], inclusion: &Inclusion, told: &Told, whole: bool) -> Result<Bounds, String> {
        let followed: Vec<&Variances> = told.places.iter().filter_map(|k| self.variances.get(*k)).collect();
        let scored = &self.model.learnt.scored;
        let mut covariance = told.covariance.clone();
        if whole {
            let variances: Vec<f64> = followed.iter().map(|variances| scored.variance(variances, place)).collect();
            covariance += scored.errors(&told.places, &variances);
        }
        let slopes: Vec<Slopes> = followed.iter().map(|variances| scored.slopes(variances, place)).collect();
        let roles = &self.model.roles;
        let integrated: Vec<bool> = roles.iter().map(|role| *role == Role::Other).collect();
        let all = scored.bound(&slopes, &covariance, &integrated).map_err(|error| error.to_string())?;
        let of = |role: Role, value: f64| {
            let k = roles.iter().position(|one| *one == role);
            let found = k.and_then(|k| Some((all.get(k)?, scored.unknowns.get(k)?)));
            found.map_or(Value::undefined("the calibration does not vary it"), |(bound, unknown)| {
                bound.scaled(unknown.prior.relative(value))
            })
        };
        Ok(Bounds {
            size: of(Role::Size, inclusion.size_mm),
            depth: of(Role::Depth, inclusion.depth_mm),
            youngs: of(Role::Youngs, inclusion.youngs_kpa),
        })
    }
}

impl FrameModel {
    /// Inclusions over the inner of what was learnt: three sizes, depths and moduli, each with each.
    pub fn some_inclusions(&self) -> Vec<Inclusion> {
        let along = |role: Role| -> [f64; 3] {
            let k = self.roles.iter().position(|one| *one == role);
            let prior = k.and_then(|k| Some(self.learnt.scored.unknowns.get(k)?.prior));
            prior.map_or([0.0; 3], |prior| {
                let [low, high] = prior.bounds();
                [0.2, 0.5, 0.8].map(|share| prior.value(low + share * (high - low)))
            })
        };
        let (sizes, depths, moduli) = (along(Role::Size), along(Role::Depth), along(Role::Youngs));
        let with = |size_mm| depths.into_iter().map(move |depth_mm| (size_mm, depth_mm));
        let pairs = sizes.into_iter().flat_map(with);
        pairs
            .flat_map(|(size_mm, depth_mm)| moduli.map(|youngs_kpa| Inclusion { size_mm, depth_mm, youngs_kpa }))
            .collect()
    }

    /// Coordinates of an inclusion, and of others by their names; the rest in the middle of what was learnt.
    fn place(&self, inclusion: &Inclusion, others: &[(&str, f64)]) -> Result<Vec<f64>, String> {
        let unknowns = self.learnt.scored.unknowns.iter().zip(&self.roles);
        unknowns
            .map(|(unknown, role)| {
                let [low, high] = unknown.prior.bounds();
                let value = match role {
                    Role::Size => inclusion.size_mm,
                    Role::Depth => inclusion.depth_mm,
                    Role::Youngs => inclusion.youngs_kpa,
                    Role::Other => match others.iter().find(|(name, _)| *name == unknown.name) {
                        Some((_, value)) => *value,
                        None => return Ok(0.5 * (low + high)),
                    },
                };
                let at = unknown.prior.coordinate(value);
                let known = || {
                    let [low, high] = [low, high].map(|end| super::estimates::short(unknown.prior.value(end)));
                    format!("{} was learnt from {low} to {high}, not of {value}", unknown.name)
                };
                if unknown.prior.holds(at) { Ok(at) } else { Err(known()) }
            })
            .collect()
    }

    /// What frames without noise of the light would tell.
    fn expected(&self, place: &[f64], protocol: &Protocol) -> Result<Told, String> {
        let blocks = Blocks { count: self.blocks };
        if !blocks.fits(protocol.camera.pixels) {
            return Err("the camera's pixels do not fall into the calibration's blocks".into());
        }
        let pixels = blocks.pixels(protocol.camera.pixels);
        let numbers = self.learnt.scored.at(place);
        let logs = self.learnt.vector(&numbers);
        let taken = |load: usize| protocol.frames.get(load).copied().filter(|count| *count > 0);
        let lit = self.elements.iter().zip(&logs).filter(|([load, _], _)| taken(*load).is_some());
        let lit: Vec<(f64, &[usize])> =
            lit.filter_map(|([_, block], log)| Some((*log, pixels.get(*block)?.as_slice()))).collect();
        let mut camera = protocol.camera.clone();
        camera.sensor.exposure_ms = match protocol.exposure_ms {
            Some(exposure_ms) => exposure_ms,
            None => Reader::new(&camera, protocol.wavelength_nm)?.longest_ms(&lit),
        };
        let reader = Reader::new(&camera, protocol.wavelength_nm)?;
        let read = |([load, block], log): (&[usize; 2], f64)| {
            let frames = taken(*load)?;
            let read = reader.expected(log, pixels.get(*block)?)?;
            Some((log, read.variance / f64::from(frames)))
        };
        let read: Vec<Option<(f64, f64)>> = self.elements.iter().zip(logs).map(read).collect();
        let seen = Seen {
            values: read.iter().map(|read| read.map(|(log, _)| log)).collect(),
            variances: read.iter().map(|read| read.map_or(0.0, |(_, variance)| variance)).collect(),
        };
        let told = self.learnt.told(&seen);
        let mut told = told.ok_or("too few parts of the frames can be read: they are saturated or dark")?;
        let Some(error) = protocol.force_error else { return Ok(told) };
        for load in (0..self.depths_mm.len()).filter(|load| taken(*load).is_some()) {
            let (place, variance) = self.force(load, error)?;
            told = told.and(place, numbers.get(place).copied().unwrap_or_default(), variance);
        }
        Ok(told)
    }
}
