//! Phantoms that a calibration is learnt from, each inverted by one that was learnt without it.
//!
//!     cargo run --release --example left_out -- FOLDER [--folds N] [--depths-mm A,B] [--exposure-ms T] [--csv FILE]
//!
//! FOLDER is what `tirtouch calibrate` filled: `design`, `leds` and `empty` in it, whole or not. Phantoms of the
//! design are dealt out to N folds (4); for each a calibration is learnt of the others, and inverts its frames, exposed
//! with the camera's noise for T ms (0.0778, as in `scenes/studies/random.toml`). Nothing is pressed or traced: mesh
//! and noise of the light are those of what is learnt. Printed: what `tirtouch study` prints, of all folds; FILE has
//! each phantom.

use anyhow::{Context as _, Result, bail};
use std::fs;
use std::path::{Path, PathBuf};
use tirtouch::calibrate::{FrameModel, Training};
use tirtouch::estimate::Value;
use tirtouch::study::{How, Summary, Trial, trials};

struct Flags {
    folder: PathBuf,
    folds: usize,
    depths_mm: Option<Vec<f64>>,
    exposure_ms: f64,
    csv: Option<PathBuf>,
}

impl Flags {
    fn read() -> Result<Self> {
        let mut words = std::env::args().skip(1);
        let folder = words.next().context("names no folder of a calibration")?.into();
        let mut flags = Self { folder, folds: 4, depths_mm: None, exposure_ms: 0.0778, csv: None };
        while let Some(word) = words.next() {
            let given = words.next().with_context(|| format!("{word} takes a value"))?;
            match word.as_str() {
                "--folds" => flags.folds = given.parse()?,
                "--depths-mm" => {
                    flags.depths_mm = Some(given.split(',').map(str::parse).collect::<Result<_, _>>()?);
                }
                "--exposure-ms" => flags.exposure_ms = given.parse()?,
                "--csv" => flags.csv = Some(given.into()),
                other => bail!("there is no flag {other}"),
            }
        }
        Ok(flags)
    }
}

/// A folder of a sweep with some of its rows.
fn dealt(design: &Path, rows: &[usize], out: &Path) -> Result<()> {
    fs::create_dir_all(out.join("items"))?;
    let of_sweep = ["sweep.toml", "scene.toml", "items/order.json", "items/place.json"].map(str::to_owned);
    for file in of_sweep.into_iter().chain(rows.iter().map(|row| format!("items/{row:07}.json"))) {
        fs::copy(design.join(&file), out.join(&file))?;
    }
    fs::create_dir_all(out.join("train"))?;
    for entry in fs::read_dir(design.join("train"))? {
        let name = entry?.file_name();
        let row = name.to_string_lossy().split('_').next().and_then(|row| row.parse().ok());
        if row.is_some_and(|row: usize| rows.contains(&row)) {
            fs::hard_link(design.join("train").join(&name), out.join("train").join(&name))?;
        }
    }
    Ok(())
}

fn main() -> Result<()> {
    let flags = Flags::read()?;
    let design = flags.folder.join("design");
    let read = |name: &str| {
        let folder = flags.folder.join(name);
        folder.is_dir().then(|| Training::read(&folder)).transpose()
    };
    let (all, leds, empty) = (Training::read(&design)?, read("leds")?, read("empty")?);
    let how = How {
        empty: false,
        exposures: 1,
        exposure_ms: Some(flags.exposure_ms),
        force_error: None,
        depths_mm: flags.depths_mm.as_deref(),
    };
    let mut tried: Vec<Trial> = Vec::new();
    for fold in 0..flags.folds {
        let others = all.only(|k| k % flags.folds != fold);
        let model = FrameModel::learn(&others, leds.as_ref(), empty.as_ref(), &mut |_| true)?.context("was stopped")?;
        let these = all.only(|k| k % flags.folds == fold).rows;
        // Beside the design, so that images are linked and not copied.
        let folder = flags.folder.join(format!("left_out_{fold}"));
        dealt(&design, &these, &folder)?;
        let of_fold = trials(&model, &folder, how, &|_, _| true);
        fs::remove_dir_all(&folder)?;
        tried.extend(of_fold?.unwrap_or_default());
        eprintln!("fold {} of {}: {} scores, {} phantoms in all", fold + 1, flags.folds, model.scores(), tried.len());
    }
    if let Some(file) = &flags.csv {
        let mut out = String::from("row,size_mm,depth_mm,youngs_kpa,phantom_youngs_kpa,figure,value,low,high,bound\n");
        for trial in &tried {
            let Some(truth) = trial.truth else { continue };
            let told = [&trial.estimates.size_mm, &trial.estimates.depth_mm, &trial.estimates.youngs_kpa];
            for (k, value) in told.into_iter().enumerate() {
                let [value, low, high] = match value {
                    Value::Known { value, low, high } => [*value, *low, *high],
                    Value::Undefined { .. } => [f64::NAN; 3],
                };
                let own = trial.phantom_youngs_kpa.unwrap_or(f64::NAN);
                let bound = trial.bounds[k].unwrap_or(f64::NAN);
                let (size, depth, youngs) = (truth.size_mm, truth.depth_mm, truth.youngs_kpa);
                out += &format!("{},{size},{depth},{youngs},{own},{k},{value},{low},{high},{bound}\n", trial.row);
            }
        }
        fs::write(file, out)?;
    }
    let summary = Summary::of(&tried, &[])?;
    println!("{} phantoms, found {}", summary.phantoms, said(&summary.found));
    for one in &summary.quantities {
        println!("{}: known {}, median error {}", one.name, one.known, said(&one.median_error));
        println!("  bias {}, half width {:?}", said(&one.relative_bias), one.median_half_width);
        println!(
            "  bound {:?}, errors over bounds {} ({})",
            one.median_bound,
            said(&one.error_over_bound),
            one.bounded
        );
        for group in &one.coverage {
            println!("  {}: {} of {}, {}", group.name, group.held, group.known, said(&group.share));
        }
        for reason in one.reasons.iter().take(4) {
            println!("  {}: {}", reason.phantoms, reason.why);
        }
    }
    for one in &summary.unknowns {
        println!("{}: known {}, held {}, median error {:?}", one.name, one.known, one.held, one.median_error);
    }
    Ok(())
}

fn said(value: &Value) -> String {
    match value {
        Value::Known { value, low, high } => format!("{value:.4} ({low:.4} to {high:.4})"),
        Value::Undefined { reason } => reason.clone(),
    }
}
