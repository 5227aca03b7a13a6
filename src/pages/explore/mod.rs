//! What the report of a run lets its reader look at: values of pixels, loads, the deformed bodies.

mod solid;

use super::facts::load_name;
use super::press_files::{drawn_pressure, most_shown_kpa};
use super::shot::scale_of;
use crate::camera::{ProjectionError, View as Projection};
use crate::estimate::GreyImage;
use crate::film::RADIANCE_UNIT;
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::press::{PressStep, Pressed};
use crate::pipeline::{EarlierFrame, Shot, view_of};
use crate::report::explore::{Curves, Explore, Frame, Load, Noise, Packed, Place, Scale, View};
use crate::report::{ColorScale, Raster};
use crate::scene::Sensor;
use crate::surface::pressed::pressure_map;

/// Most pixels whose values are kept one by one; of larger images, means over squares are. Half a million are some
/// megabytes of page.
const MOST_PIXELS: usize = 1 << 19;
/// Points of the table of places. Between two of them the place bends by less than 1e-4 of a pixel.
const PLACES: usize = 128;
/// Cells along the longer side of a map of pressure.
const MAP_CELLS: usize = 128;

/// Gathers it; `frames` are the frames of all loads in order, those of the loads before the last in files that
/// `earlier` names.
///
/// # Errors
/// A view that total reflection hides.
pub fn explore(shot: &Shot, frames: &[(f64, GreyImage)], earlier: &[EarlierFrame]) -> Result<Explore, ProjectionError> {
    let place = places(&view_of(shot.prepared.scene())?, shot);
    let mut views = vec![camera(shot, frames, earlier, place.clone()), radiance(shot, place)];
    let Some((pressed, _)) = shot.prepared.pressed() else { return Ok(Explore { views, ..Explore::default() }) };
    let solid = pressed.setup.kinematics == Kinematics::ThreeDimensional;
    if solid {
        views.push(map(pressed));
    }
    Ok(Explore {
        loads: pressed.steps.iter().map(load).collect(),
        views,
        curves: (!solid).then(|| curves(pressed)),
        solid: solid::solid(pressed),
    })
}

fn load(step: &PressStep) -> Load {
    let &PressStep { depth_mm, force_n, peak_pressure_kpa, .. } = step;
    Load { name: load_name(step), depth_mm, force_n, peak_pressure_kpa }
}

/// Distances from the axis that an image's rows of pixels see, from its middle to its corner.
fn places(projection: &Projection, shot: &Shot) -> Place {
    let [middle, corner] = [shot.frame.width, shot.frame.height].map(|size| 0.5 * f64::from(size));
    let step_px = middle.hypot(corner) / (PLACES - 1) as f64;
    let seen = |i: usize| projection.touched_from_pixel([middle + i as f64 * step_px, corner]);
    // Beyond total reflection nothing is seen.
    let radius_mm = (0..PLACES).map_while(seen).map(|[x, _]| x).collect();
    Place::Lens { step_px, radius_mm }
}

/// Means over squares of pixels, where there are too many: edge of a square, columns, rows, values.
fn kept(raster: &Raster) -> (usize, [usize; 2], Vec<f64>) {
    let block = (1..).find(|block| raster.values.len() / (block * block) <= MOST_PIXELS).unwrap_or(1);
    let size = [raster.width / block, raster.height / block];
    let mean = |i: usize| {
        let [left, top] = [i % size[0] * block, i / size[0] * block];
        let of_row = |row: usize| raster.values.iter().skip(row * raster.width + left).take(block).sum::<f64>();
        (top..top + block).map(of_row).sum::<f64>() / (block * block) as f64
    };
    (block, size, (0..size[0] * size[1]).map(mean).collect())
}

fn grey<'v>(shot: &Shot, values: &'v [f64]) -> Raster<'v> {
    shot.raster(values, "grey level", "")
}

fn camera(shot: &Shot, frames: &[(f64, GreyImage)], earlier: &[EarlierFrame], place: Place) -> View {
    let last = shot.frame.grey.iter().copied().map(f64::from).collect::<Vec<_>>();
    let mut images: Vec<&[f64]> = frames.iter().map(|(_, image)| image.grey()).collect();
    if images.is_empty() {
        images.push(&last);
    }
    let (block, [width, height], _) = kept(&grey(shot, &last));
    let all: Vec<Scale> = images.iter().map(|values| Scale::of(&grey(shot, values), ColorScale::Linear)).collect();
    let frame = |(load, values): (usize, &&[f64])| Frame {
        load,
        file: earlier.get(load).map_or_else(|| "camera.png".to_owned(), |earlier| earlier.file.clone()),
        values: Packed::linear(&kept(&grey(shot, values)).2),
        errors: None,
    };
    View {
        title: "Camera".into(),
        quantity: "grey level",
        unit: "",
        error_is: "noise of camera and rounding",
        width,
        height,
        block,
        place,
        // One scale for all loads, so that the eye can compare.
        scale: Scale {
            low: 0.0,
            high: all.iter().map(|scale| scale.high).fold(0.0, f64::max),
            log: false,
            beyond: false,
        },
        palette: "light",
        noise: Some(noise(&shot.prepared.scene().camera.sensor)),
        frames: images.iter().enumerate().map(frame).collect(),
    }
}

/// Photons are Poisson, so their variance in electrons is their number (EMVA 1288, linear model); rounding to whole
/// levels adds a twelfth.
fn noise(sensor: &Sensor) -> Noise {
    let per_level = f64::from((1u32 << sensor.bit_depth) - 1) / sensor.full_well_e;
    Noise { per_level, black: sensor.black_level, floor: (sensor.read_noise_e * per_level).powi(2) + 1.0 / 12.0 }
}

fn radiances<'v>(shot: &Shot, values: &'v [f64]) -> Raster<'v> {
    shot.raster(values, "radiance", RADIANCE_UNIT)
}

fn radiance(shot: &Shot, place: Place) -> View {
    let film = &shot.outcome.film;
    let [values, variances] = [&film.mean, &shot.outcome.unseen.variances(film)]
        .map(|values| values.iter().map(|&value| f64::from(value)).collect::<Vec<_>>());
    let (block, [width, height], means) = kept(&radiances(shot, &values));
    // Pixels move together, so the mean of some is hardly surer than one of them.
    let errors: Vec<f64> =
        kept(&radiances(shot, &variances)).2.iter().map(|variance| variance.max(0.0).sqrt()).collect();
    View {
        title: "Radiance".into(),
        quantity: "radiance",
        unit: RADIANCE_UNIT,
        error_is: "standard error",
        width,
        height,
        block,
        place,
        scale: Scale::of(&radiances(shot, &values), scale_of(&values)),
        palette: "light",
        noise: None,
        frames: vec![Frame {
            load: shot.prepared.pressed().map_or(0, |(pressed, _)| pressed.steps.len().saturating_sub(1)),
            file: "radiance.exr".into(),
            values: Packed::ratios(&means),
            errors: Some(Packed::rough_ratios(&errors)),
        }],
    }
}

fn map(pressed: &Pressed) -> View {
    let size_mm = pressed.setup.phantom.footprint.half_widths_mm().map(|half| 2.0 * half);
    let maps: Vec<_> = pressed.steps.iter().map(|step| pressure_map(pressed, step, size_mm, MAP_CELLS)).collect();
    let [width, height] = maps.first().map_or([1, 1], |(columns, rows, _)| [*columns, *rows]);
    let high = maps.iter().flat_map(|(.., values)| values).copied().fold(0.0, f64::max);
    let most = most_shown_kpa(pressed);
    let frame = |(load, (columns, _, values)): (usize, &(usize, usize, Vec<f64>))| {
        let upright: Vec<f64> = values.chunks(*columns).rev().flatten().copied().collect();
        Frame { load, file: String::new(), values: Packed::linear(&upright), errors: None }
    };
    View {
        title: "Contact pressure".into(),
        quantity: "pressure",
        unit: "kPa",
        error_is: "",
        width,
        height,
        block: 1,
        place: Place::Flat { mm_per_pixel: size_mm[0] / width as f64 },
        scale: Scale { low: 0.0, high: high.min(most), log: false, beyond: high > most },
        palette: "light",
        noise: None,
        frames: maps.iter().enumerate().map(frame).collect(),
    }
}

fn curves(pressed: &Pressed) -> Curves {
    let along = match pressed.setup.kinematics {
        Kinematics::PlaneStrain => "distance from the middle",
        _ => "distance from the axis",
    };
    let loads = pressed.steps.iter().map(|step| drawn_pressure(pressed, step)).collect();
    Curves { along, highest_kpa: most_shown_kpa(pressed), loads }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_images_are_kept_as_means_over_squares() {
        let values: Vec<f64> = (0..1392 * 1042).map(|i| f64::from(i % 1392)).collect();
        let raster =
            Raster { width: 1392, height: 1042, values: &values, quantity: "grey level", unit: "", mm_per_pixel: None };
        let (block, size, means) = kept(&raster);
        assert_eq!((block, size), (2, [696, 521]));
        assert_eq!((means[0], means[695], means[696]), (0.5, 1390.5, 0.5));
        let small = Raster { width: 348, height: 261, values: &values[..348 * 261], ..raster };
        assert_eq!((kept(&small).0, kept(&small).2.as_slice()), (1, small.values));
    }
}
