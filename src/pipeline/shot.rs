//! A traced image and the camera's frame of it.

use super::{PipelineError, Prepared};
use crate::camera::{Frame, ProjectionError, Suited, View, expected_electrons, expose};
use crate::film::Film;
use crate::progress::Observer;
use crate::scene::Scene;
use crate::trace::{Devices, Outcome, render};

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
