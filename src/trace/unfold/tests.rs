//! Unfolding against the photons that it replaces, and against its own finer tables.

#![allow(clippy::unwrap_used)]

use super::*;
use crate::film::mean_interval;
use crate::scene::{LoadedScene, Pattern};
use crate::surface::{ContactMap, Surface, TissueDisc, contact_map};
use crate::trace::cpu::Limits;
use crate::trace::cpu::photons::{DEPOSIT_UNIT, Deposits, send};
use crate::trace::exitance::tissue_share;
use crate::trace::model::{Spare, Tissue};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

const BATCHES: u32 = 16;
const THREADS: u32 = 1 << 13;
const SAMPLES: u32 = 16;

fn model(loaded: &LoadedScene, map: impl Fn(ContactMap) -> ContactMap) -> Model<f64> {
    Model::new(loaded, &Surface::Flat, contact_map(loaded).unwrap().map(map)).unwrap()
}

fn on_a_disc(map: ContactMap, center_mm: [f64; 2], radius_mm: f64) -> ContactMap {
    ContactMap { disc: Some(TissueDisc { center_mm, radius_mm }), ..map }
}

/// A stack half as thick, absorbing, under tissue of another index that is partly in contact, lit by unlike LEDs.
fn awkward() -> Model<f64> {
    let mut loaded = crate::scene::preset("contact-disc").unwrap();
    let scene = &mut loaded.scene;
    for layer in &mut scene.stack.layer {
        layer.thickness_mm *= 0.5;
        layer.absorption_per_mm = 0.01;
    }
    for (k, led) in scene.led.iter_mut().enumerate() {
        (led.height_mm, led.diameter_mm) = (1.5 + 1.2 * k as f64, 1.5);
        led.along_mm = 3.0 * k as f64 - 4.0;
        led.radiance_w_per_m2_sr = Some(1.0 + k as f64);
    }
    scene.led[1].pattern = Pattern::CosinePower { half_power_deg: 40.0 };
    scene.led[2].cutoff_half_angle_deg = Some(50.0);
    scene.touch.contact.as_mut().unwrap().tissue.n = 1.37;
    model(&loaded, |map| ContactMap { uniform: 0.4, ..on_a_disc(map, [2.0, -3.0], 5.0) })
}

/// Tissue given by coefficients, partly in contact.
fn half_space(absorption: f64) -> Model<f64> {
    let mut loaded = crate::scene::preset("contact-disc").unwrap();
    let tissue = &mut loaded.scene.touch.contact.as_mut().unwrap().tissue;
    tissue.diffuse_reflectance = None;
    (tissue.reduced_scattering_per_mm, tissue.absorption_per_mm) = (Some(1.0), Some(absorption));
    model(&loaded, |map| ContactMap { uniform: 0.4, ..map })
}

/// A thin guide: light that reaches the tissue has met it before.
fn thin() -> Model<f64> {
    let mut loaded = crate::scene::preset("contact-disc").unwrap();
    let scene = &mut loaded.scene;
    scene.stack.layer.iter_mut().for_each(|layer| layer.thickness_mm *= 0.25);
    scene.led.iter_mut().for_each(|led| (led.height_mm, led.diameter_mm) = (1.5, 1.5));
    model(&loaded, |map| ContactMap { uniform: 0.4, ..on_a_disc(map, [0.0; 2], 5.0) })
}

/// Light of photons in eighths of the map along y, through true contact and through the gap, film units times mm^2.
fn photons(model: &Model<f64>, seed: u32) -> Vec<f64> {
    let cells: Vec<AtomicU64> = (0..2 * model.map_size[0] * model.map_size[1]).map(|_| AtomicU64::new(0)).collect();
    send(model, Some(&Deposits { cells: &cells, splatted: false }), seed, THREADS, [0, SAMPLES], Limits::default());
    let each = model.power * model.aimed_share / f64::from(SAMPLES * THREADS) / DEPOSIT_UNIT;
    let mut sums = vec![0.0; 16];
    let half = model.map_size[0] * model.map_size[1];
    for (k, cell) in cells.iter().enumerate() {
        sums[k / 2 * 8 / half * 2 + k % 2] += cell.load(Ordering::Relaxed) as f64 * each;
    }
    sums
}

/// The same of unfolding.
fn unfolded(model: &Model<f64>, shift: [f64; 2]) -> Vec<f64> {
    let size = [0, 1].map(|k| 2.0 * model.half_size[k] / model.map_size[k] as f64);
    let light = direct_light(model, model.unfolded, shift);
    let mut sums = vec![0.0; 16];
    let (columns, all) = (model.map_size[0], light[0].len());
    for k in 0..all {
        let low = [(k % columns, 0), (k / columns, 1)].map(|(i, a)| i as f64 * size[a] - model.half_size[a]);
        let area = size[0] * size[1] * tissue_share(model, low, size);
        (0..2).for_each(|which| sums[k * 8 / all * 2 + which] += light[which][k] * area);
    }
    sums
}

/// What photons find that unfolding is to replace, batch by batch.
fn replaced(model: &Model<f64>) -> Vec<Vec<f64>> {
    let mut whole = model.clone();
    whole.spare.push(Spare::Direct);
    let batch = |k: u32| photons(&whole, k).iter().zip(photons(model, k)).map(|(all, rest)| all - rest).collect();
    (0..BATCHES).into_par_iter().map(batch).collect()
}

/// Largest difference between unfolding and the photons that it replaces, over the 95 % intervals of the bands.
fn worst(replaced: &[Vec<f64>], unfolding: &Model<f64>) -> f64 {
    let shift = |k: u32, s: f64| (f64::from(k) * s).fract();
    let differences: Vec<Vec<f64>> = replaced
        .par_iter()
        .enumerate()
        .map(|(k, replaced)| {
            let found = unfolded(unfolding, [shift(k as u32, 0.618_034), shift(k as u32, 0.754_878)]);
            replaced.iter().zip(found).map(|(replaced, found)| replaced - found).collect()
        })
        .collect();
    let band = |k: usize| -> Vec<f64> { differences.iter().map(|d| d[k]).collect() };
    let off = |[mean, half]: [f64; 2]| if mean == 0.0 { 0.0 } else { (mean / half).abs() };
    (0..16).map(|k| off(mean_interval(&band(k)))).fold(0.0, |a, b| if a >= b { a } else { b })
}

#[test]
fn unfolding_finds_the_light_of_the_photons_that_it_replaces() {
    let plain = model(&crate::scene::preset("contact-disc").unwrap(), |map| map);
    let mut by_photons = Vec::new();
    let half = |batches: &[Vec<f64>]| batches[..BATCHES as usize / 2].to_vec();
    for model in [plain, awkward(), thin()] {
        assert!(model.unfolded >= 4, "{}", model.unfolded);
        by_photons = replaced(&model);
        // One of 16 passes twice its interval with a chance of 1e-2.
        assert!(worst(&by_photons, &model) < 2.0, "{}", worst(&by_photons, &model));
        let mut low = model.clone();
        low.leds.iter_mut().for_each(|led| led.height -= 0.1);
        assert!(worst(&half(&by_photons), &low) > 2.0, "LEDs a tenth of a millimetre lower are not noticed");
    }
    // One reflection that photons leave out and unfolding does not find; mirrors below tissue that reflect as if all
    // were contact.
    let model = thin();
    // These are seen in a quarter of the batches.
    let quarter = |batches: &[Vec<f64>]| batches[..BATCHES as usize / 4].to_vec();
    let few = Model { unfolded: 3, ..model.clone() };
    assert!(worst(&quarter(&by_photons), &few) > 2.0, "reflections that are left out are not noticed");
    let tissue = model.tissue.clone().map(|tissue| Tissue { share: 1.0, ..tissue });
    assert!(worst(&quarter(&by_photons), &Model { tissue, ..model }) > 2.0, "what tissue mirrors is not noticed");
    let model = half_space(0.1);
    let by_photons = replaced(&model);
    assert!(worst(&by_photons, &model) < 2.0, "{}", worst(&by_photons, &model));
    // That sends back a sixth less.
    assert!(worst(&quarter(&by_photons), &half_space(0.2)) > 2.0, "darker tissue is not noticed");
}

#[test]
fn texels_hold_the_mean_of_what_tissue_they_have() {
    let fine = thin();
    let sum = |model: &Model<f64>| unfolded(model, [0.3, 0.6]).iter().sum::<f64>();
    for size in [[15, 12], [31, 64]] {
        let coarse = Model { map_size: size, ..fine.clone() };
        assert!((sum(&coarse) / sum(&fine) - 1.0).abs() < 5e-3, "{size:?}: {} {}", sum(&coarse), sum(&fine));
    }
}

/// Rows at the touched face itself, where no depth is left.
#[test]
fn leds_up_to_the_touched_face_shine_too() {
    let mut loaded = crate::scene::preset("contact-disc").unwrap();
    loaded.scene.led.iter_mut().for_each(|led| led.height_mm = 10.5);
    let model = model(&loaded, |map| map);
    let light = direct_light(&model, model.unfolded, [0.0, 0.5]);
    assert!(light[0].iter().all(|v| v.is_finite()) && light[0].iter().any(|v| *v > 0.0));
}

/// Between the points of the face, and between the entries of the tables.
#[test]
fn points_and_tables_are_finer_than_what_they_hold() {
    let mut wide = crate::scene::preset("contact-disc").unwrap();
    wide.scene.led.iter_mut().for_each(|led| led.height_mm = 8.5);
    let wide = model(&wide, |map| on_a_disc(map, [0.0; 2], 12.0));
    for model in [model(&crate::scene::preset("contact-disc").unwrap(), |map| map), awkward(), thin(), wide] {
        let site = Site::of(&model).unwrap();
        let light = direct_light(&model, model.unfolded, [0.3, 0.6]);
        let highest = light[0].iter().copied().fold(0.0, f64::max);
        let path = Path::new(&model, Limits::default());
        let off = |site: &Site| {
            let rows = |led: &Led<f64>| rows_of(&model, led, site, model.unfolded, 0.3);
            let rows: Vec<Vec<Row>> = model.leds.iter().map(rows).collect();
            let sources: Vec<(&Led<f64>, &[Row])> = model.leds.iter().zip(rows.iter().map(Vec::as_slice)).collect();
            let (mut square, mut count) = (0.0, 0.0);
            for k in (0..light[0].len()).step_by(7) {
                let place = [k % model.map_size[0], k / model.map_size[0]];
                let at = [0, 1]
                    .map(|a| ((place[a] as f64 + 0.5) / model.map_size[a] as f64 * 2.0 - 1.0) * model.half_size[a]);
                if path.tissue_here(at[0], at[1]) {
                    square += (at_point(&path, site, &sources, at, 0.6)[0] - light[0][k]).powi(2);
                    count += 1.0;
                }
            }
            (square / count).sqrt() / highest
        };
        assert!(off(&site) < 1e-3, "{}", off(&site));
        let fine = Site { steps: 10 * site.steps, ..Site::of(&model).unwrap() };
        assert!(off(&fine) < 1e-3, "{}", off(&fine));
    }
}
