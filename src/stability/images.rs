//! Images that say nothing, or too much: estimates are undefined and say so.

use super::row::{Part, Row, Subject};
use super::{Context, StabilityError, scenes};
use crate::camera::expose;
use crate::estimate::{Calibration, GreyImage, Settings, Value, estimate, stiffness};
use crate::film::{BlockAccumulator, RADIANCE_UNIT};
use crate::scene::preset;
use crate::trace::Integrator;
use crate::trace::batch::{Batch, Work};

/// Columns and rows of the made-up images.
const SIDE: usize = 100;

/// A dark image, a saturated one, two equal loads, a sum outside the calibration.
pub fn rows(context: &Context) -> Result<Vec<Row>, StabilityError> {
    let mut rows = Vec::new();
    dark(context, &mut rows)?;
    let subject = Subject::new(Part::Image, "saturated image", "estimators");
    let image = disc(40.0, 255.0)?;
    let paper = estimate(&image, &Settings::default());
    let count = image.grey().iter().filter(|&&grey| grey == 255.0).count();
    let saturated = [paper.saturated_pixels as f64, count as f64];
    rows.push(subject.absolute("saturated pixels", saturated, "counted", 0.0, "a count"));
    rows.push(subject.holds("a warning says so", !paper.warnings.is_empty(), "the sum is a lower bound"));
    // F = 1e-5 N per grey level from 1e4 to 1e5.
    let text = "mm_per_pixel = 0.02\nbottom_area_mm2 = 900.0\nforce_n_from_sum_grey = [[1e4, 0.1], [1e6, 10.0]]\n";
    let calibration = Calibration::parse(text, "stability")?;
    let frame = disc(30.0, 100.0)?;
    let equal = stiffness(&frame, &frame, &Settings::default(), &calibration);
    let undefined = says(&equal.relative_stiffness_kpa, "T = 0");
    let subject = Subject::new(Part::Image, "two equal loads", "estimators");
    rows.push(subject.holds("stiffness is undefined: T = 0", undefined, "P / 0 is no number"));
    let faint = disc(3.0, 10.0)?;
    let outside = stiffness(&frame, &faint, &Settings::default(), &calibration);
    let subject = Subject::new(Part::Image, "sum of grey values outside the calibration", "estimators");
    let undefined = says(&outside.force_n, "outside the calibrated range");
    rows.push(subject.holds("force is undefined", undefined, "no extrapolation"));
    Ok(rows)
}

/// No deformation and no contact: nothing is seen, nothing estimated.
fn dark(context: &Context, rows: &mut Vec<Row>) -> Result<(), StabilityError> {
    let spp = if context.quick { 256 } else { 1 << 15 };
    let mut loaded = preset("tsis-paper")?;
    let model = scenes::model(&loaded)?;
    loaded.scene.camera.pixels = model.camera.size;
    for tracer in &context.tracers {
        let mut backend = tracer.open(&model)?;
        let mut batch = Batch::new(&model, &mut backend, Integrator::Path, 5);
        let image = batch.replicate(0, Work { spp, photons: 1 }, &mut |_| true)?;
        let subject = Subject::new(Part::Image, "flat stack, LEDs in air, nothing touches", tracer.name());
        let most = image.iter().copied().fold(0.0, f64::max);
        let quantity = format!("brightest pixel, {RADIANCE_UNIT}, {} paths", spp as usize * image.len());
        rows.push(subject.absolute(quantity, [most, 0.0], "all light is guided", 0.0, "not one path finds an LED"));
        let [width, height] = model.camera.size;
        let mut sums = BlockAccumulator::new(width, height);
        let undefined = sums.add(&image).is_ok_and(|()| {
            let frame = expose(&sums.finish(), &loaded.scene.camera, loaded.scene.light.wavelength_nm, 1);
            frame.ok().and_then(|frame| GreyImage::from_frame(&frame).ok()).is_some_and(|image| {
                let paper = estimate(&image, &Settings::default());
                paper.diameter_px.best().is_none() && paper.centroid_px.best().is_none()
            })
        });
        rows.push(subject.holds("diameter and centroid are undefined", undefined, "a blank image has none"));
    }
    Ok(())
}

fn says(value: &Value, what: &str) -> bool {
    matches!(value, Value::Undefined { reason } if reason.contains(what))
}

/// A disc of a radius in pixels and a grey level, off the middle.
fn disc(radius: f64, grey: f64) -> Result<GreyImage, StabilityError> {
    let pixel = |i: usize| {
        let (x, y) = ((i % SIDE) as f64 - 49.8, (i / SIDE) as f64 - 49.1);
        if x.hypot(y) < radius { grey } else { 0.0 }
    };
    Ok(GreyImage::new(SIDE, SIDE, &(0..SIDE * SIDE).map(pixel).collect::<Vec<_>>(), Some(255.0))?)
}
