//! A traced image and the camera's frame of it.

use super::{PipelineError, Prepared};
use crate::camera::{Frame, ProjectionError, Suited, View, expected_electrons, expose};
use crate::estimate::Calibration;
use crate::film::{Film, RADIANCE_UNIT};
use crate::image_io::{ImageError, Provenance, write_radiance_as};
use crate::progress::Observer;
use crate::scene::Scene;
use crate::trace::{Devices, Outcome, render};
use std::path::Path;

/// An image with the camera's view of it.
#[derive(Debug, Clone)]
pub struct Shot<'a> {
    /// What was traced.
    pub prepared: &'a Prepared,
    /// The radiance, and what it cost.
    pub outcome: Outcome,
    /// The camera's frame.
    pub frame: Frame,
    /// Whether its exposure suits it.
    pub suited: Suited,
    /// Scale of the frame at the touched face.
    pub mm_per_pixel: f64,
}

impl<'a> Shot<'a> {
    pub(super) fn take(
        devices: &Devices,
        prepared: &'a Prepared,
        observe: &mut Observer,
    ) -> Result<Self, PipelineError> {
        let scene = prepared.scene();
        let (camera, wavelength_nm) = (&scene.camera, scene.light.wavelength_nm);
        let [width, height] = camera.pixels;
        // What is wrong with the exposure must not show after an hour of tracing.
        let dark = Film { width, height, mean: vec![0.0; width as usize * height as usize], ..Film::default() };
        expected_electrons(&dark, camera, wavelength_nm)?;
        let outcome = render(devices, &prepared.model, &prepared.settings, observe)?;
        let frame = expose(&outcome.film, camera, wavelength_nm, prepared.streams.sensor())?;
        let suited = Suited::of(&outcome.film, camera, wavelength_nm)?;
        let mm_per_pixel = view_of(scene)?.mm_per_pixel();
        Ok(Self { prepared, outcome, frame, suited, mm_per_pixel })
    }

    /// Writes the radiance with its variance as an EXR whose header says what made it; `command` is the user's word
    /// for that.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_radiance(&self, path: &Path, command: &str) -> Result<(), ImageError> {
        let film = &self.outcome.film;
        write_radiance_as(path, film, &self.outcome.unseen.variances(film), &self.provenance(command))
    }

    fn provenance(&self, command: &str) -> Provenance {
        let outcome = &self.outcome;
        Provenance {
            unit: RADIANCE_UNIT.into(),
            scene_name: self.prepared.scene().name.clone(),
            scene_sha256: self.prepared.loaded.sha256.clone(),
            seed: self.prepared.streams.seed,
            stream: Some(self.prepared.settings.seed),
            sensor_seed: Some(self.prepared.streams.sensor()),
            spp: u32::try_from(outcome.spp).unwrap_or(u32::MAX),
            photons: outcome.photons,
            integrator: outcome.plan.integrator.name().into(),
            backend: outcome.backend.into(),
            adapter: outcome.adapter.clone(),
            version: env!("CARGO_PKG_VERSION").into(),
            command: command.into(),
            ..Provenance::default()
        }
    }
}

/// The pinhole's view through a scene's undeformed stack.
///
/// # Errors
/// A view that total reflection hides.
pub fn view_of(scene: &Scene) -> Result<View, ProjectionError> {
    let lambda = scene.light.wavelength_nm;
    let layers: Vec<_> = scene.stack.layer.iter().map(|layer| (layer.index(lambda), layer.thickness_mm)).collect();
    View::new(&scene.camera, &layers, scene.stack.surround_n)
}

/// What is known of the frames of a scene's camera: their scale.
///
/// # Errors
/// A view that total reflection hides.
pub fn scale_of(scene: &Scene) -> Result<Calibration, ProjectionError> {
    let mm_per_pixel = view_of(scene)?.mm_per_pixel();
    Ok(Calibration { mm_per_pixel, bottom_area_mm2: None, force_n_from_sum_grey: None })
}
