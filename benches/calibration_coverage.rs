//! What a calibration's intervals hold: frames of phantoms that it was not learnt from, pressed and traced by a sweep
//! (other meshes, methods and seeds), exposed with the camera's noise and inverted.
//!
//!     cargo run --release --example calibration_coverage -- CALIBRATION.json FOLDER...

use anyhow::{Context as _, Result, bail};
use rayon::prelude::*;
use std::path::Path;
use tirtouch::calibrate::{FrameModel, Frames};
use tirtouch::camera::expose;
use tirtouch::estimate::{Detected, Estimates, GreyImage, Value};
use tirtouch::figure::Figure;
use tirtouch::image_io::read_radiance;
use tirtouch::output::Records;
use tirtouch::pipeline::Truth;
use tirtouch::statistics::{Errors, Pair, clopper_pearson};
use tirtouch::sweep::{Record, Sweep};

/// A figure of the truth, and its estimate.
type OfTruth = fn(&Truth) -> &Figure;
type OfTold = fn(&Estimates) -> &Value;

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let Some(calibration) = arguments.next() else { bail!("give a calibration and folders of sweeps") };
    let model = FrameModel::load(Path::new(&calibration))?;
    for folder in arguments {
        let (sweep, records) = Sweep::of_folder(Path::new(&folder))?;
        let kept: Vec<(usize, Record)> = sweep.kept(&records).collect();
        let all = kept.par_iter().map(|(row, record)| one(&model, &sweep, &records, *row, record));
        let all = all.collect::<Result<Vec<_>>>()?;
        let found = all.iter().filter(|(_, told)| told.detected == Detected::Known(true)).count();
        println!("{folder}: an inclusion is found in {found} of {}", all.len());
        for (_, told) in &all {
            if let Detected::Undefined { undefined } = &told.detected {
                println!("  undefined: {undefined}");
            }
        }
        let figures: [(&str, OfTruth, OfTold); 3] = [
            ("size, mm", |truth| &truth.size_mm, |told| &told.size_mm),
            ("depth, mm", |truth| &truth.depth_mm, |told| &told.depth_mm),
            ("modulus, kPa", |truth| &truth.youngs_kpa, |told| &told.youngs_kpa),
        ];
        for (name, truth_of, told_of) in figures {
            let known: Vec<[f64; 4]> = all
                .iter()
                .filter_map(|(truth, told)| match (truth_of(truth), told_of(told)) {
                    (Figure::Known(truth), Value::Known { value, low, high }) => Some([*truth, *value, *low, *high]),
                    _ => None,
                })
                .collect();
            let held = known.iter().filter(|[truth, _, low, high]| low <= truth && truth <= high).count();
            print!("  {name}: known in {} of {}", known.len(), all.len());
            if known.len() < 2 {
                println!();
                continue;
            }
            let pairs: Vec<Pair> =
                known.iter().map(|[truth, estimate, ..]| Pair { truth: *truth, estimate: *estimate }).collect();
            let relative = Errors::of(&pairs)?.median_relative.unwrap_or(f64::NAN);
            let mut widths: Vec<f64> = known.iter().map(|[truth, _, low, high]| 0.5 * (high - low) / truth).collect();
            widths.sort_by(f64::total_cmp);
            println!(
                ", held in {held} ({}); median error {:.1} %, median half width {:.1} %",
                share(&clopper_pearson(held, known.len(), 0.95)?),
                100.0 * relative,
                100.0 * widths[widths.len() / 2],
            );
        }
    }
    Ok(())
}

/// A share in percent with its interval.
fn share(value: &Value) -> String {
    match value {
        Value::Known { value, low, high } => {
            format!("{:.1} %, {:.1} to {:.1}", 100.0 * value, 100.0 * low, 100.0 * high)
        }
        Value::Undefined { reason } => reason.clone(),
    }
}

/// Truth and estimates of a point.
fn one(
    model: &FrameModel,
    sweep: &Sweep,
    records: &Records,
    row: usize,
    record: &Record,
) -> Result<(Truth, Estimates)> {
    let point = sweep.plan.point(row).map_err(anyhow::Error::msg)?;
    let loaded = sweep.scene(&point).map_err(|why| anyhow::anyhow!("{why:?}"))?;
    let (camera, wavelength_nm) = (&loaded.scene.camera, loaded.scene.light.wavelength_nm);
    let split = sweep.file.sweep.images.context("no images")?.split(row);
    let frame = |(load, kept): (usize, &tirtouch::sweep::Kept)| {
        let (film, _) = read_radiance(&records.folder().join(split).join(&kept.file))?;
        let seed = (row * 16 + load) as u32;
        Ok(GreyImage::from_frame(&expose(&film, camera, wavelength_nm, seed)?)?)
    };
    let frames = record.images.iter().enumerate().map(frame).collect::<Result<Vec<_>>>()?;
    let frames = model.depths_mm.iter().copied().zip(&frames).collect();
    let told = model.estimates(&Frames { camera, wavelength_nm, frames });
    Ok((Truth::of(loaded.scene.phantom.as_ref(), &loaded.files, false)?, told))
}
