//! The inverse of pressure frames on random tissues: how far off estimates are, how often intervals hold.
//!
//! Tissues are scanned on a mesh finer than the preset's by 1.7, where the inverse uses 0.4 and 1.1 of it, and their
//! pressures get independent noise of 1 %. The inverse starts from the preset's tissue, whatever the true one.
//!
//! ```text
//! cargo run --release --example tissue_inverse -- [--cases 40] [--first 0] [--noise 0.01] [--seeds 1] [--force] \
//!     [--free-depth] [--null]
//! ```
//!
//! One line a case of CSV; `--null` makes the inclusion of the tissue's own modulus.

use std::process::ExitCode;
use tirtouch::camera::noise::PixelRandom;
use tirtouch::estimate::Value;
use tirtouch::estimate::tissue::{Question, Tissue, invert, noisy};
use tirtouch::mechanics::frames::scan::{Held, ScanSetup, frames};
use tirtouch::scene::{Elastic, InclusionBody, LoadedScan, PhantomBody, scan_preset};

/// Thickness 18 to 40 mm, radius 2.5 to 7 mm, contrast 1.5 to 15, modulus of the tissue 4 to 30 kPa, depth 2 to 8 mm.
struct Case {
    thickness_mm: f64,
    radius_mm: f64,
    contrast: f64,
    youngs_kpa: f64,
    depth_mm: f64,
}

fn case(number: u32, null: bool) -> Case {
    let mut random = PixelRandom::new(7, number);
    loop {
        let mut between = |low: f64, high: f64| (low.ln() + random.uniform() * (high / low).ln()).exp();
        let case = Case {
            thickness_mm: between(18.0, 40.0),
            radius_mm: between(2.5, 7.0),
            contrast: if null { 1.0 } else { between(1.5, 15.0) },
            youngs_kpa: between(4.0, 30.0),
            depth_mm: between(2.0, 8.0),
        };
        if case.depth_mm + 2.0 * case.radius_mm < case.thickness_mm - 1.5 {
            return case;
        }
    }
}

fn scene(case: &Case, resolution: f64) -> anyhow::Result<LoadedScan> {
    let mut loaded = scan_preset("frames-galea")?;
    let phantom = &mut loaded.scene.phantom;
    if let PhantomBody::Block { height_mm, .. } = &mut phantom.shape {
        *height_mm = case.thickness_mm;
    }
    let linear = |youngs_kpa| Elastic::Linear { youngs_kpa, poisson: 0.4999, relaxation: Vec::new() };
    phantom.material = linear(case.youngs_kpa);
    if let Some(inclusion) = phantom.inclusion.first_mut() {
        inclusion.shape = InclusionBody::Sphere { diameter_mm: 2.0 * case.radius_mm };
        inclusion.depth_mm = case.depth_mm;
        inclusion.material = linear(case.contrast * case.youngs_kpa);
    }
    loaded.scene.scan.resolution = resolution;
    Ok(loaded)
}

fn cells(value: &Value, truth: f64) -> String {
    match value {
        Value::Known { value, low, high } => {
            format!("{value},{low},{high},{}", u8::from((*low..=*high).contains(&truth)))
        }
        Value::Undefined { .. } => ",,,".to_owned(),
    }
}

/// Why a number is not known, of the first that is not.
fn reason(found: &Tissue) -> String {
    let told = [&found.thickness_mm, &found.tissue_youngs_kpa, &found.radius_mm, &found.inclusion_youngs_kpa];
    let why = told.into_iter().chain(&found.depth_mm).find_map(|value| match value {
        Value::Known { .. } => None,
        Value::Undefined { reason } => Some(reason.replace(',', ";")),
    });
    why.unwrap_or_default()
}

fn row(case: &Case, found: &Tissue) -> String {
    let depth = found.depth_mm.as_ref().map_or(",,,".to_owned(), |depth| cells(depth, case.depth_mm));
    [
        cells(&found.thickness_mm, case.thickness_mm),
        cells(&found.tissue_youngs_kpa, case.youngs_kpa),
        cells(&found.radius_mm, case.radius_mm),
        cells(&found.inclusion_youngs_kpa, case.contrast * case.youngs_kpa),
        depth,
        format!("{},{},{},{}", found.reduced_chi_square, found.noise.share, found.features, found.scans),
        reason(found),
    ]
    .join(",")
}

fn main() -> anyhow::Result<ExitCode> {
    let arguments: Vec<String> = std::env::args().collect();
    let flag = |name: &str| arguments.iter().any(|one| one == name);
    let number = |name: &str, default: f64| {
        let place = arguments.iter().position(|one| one == name);
        place.and_then(|k| arguments.get(k + 1)?.parse().ok()).unwrap_or(default)
    };
    let (first, cases, seeds) =
        (number("--first", 0.0) as u32, number("--cases", 40.0) as u32, number("--seeds", 1.0) as u32);
    let known = ["thickness_mm", "tissue_kpa", "radius_mm", "inclusion_kpa", "depth_mm"];
    let columns = known.map(|name| format!("{name},{name}_low,{name}_high,{name}_held")).join(",");
    println!(
        "case,seed,true_thickness,true_radius,true_contrast,true_youngs,true_depth,{columns},chi,noise,features,scans,\
         undefined"
    );
    for k in first..first + cases {
        let case = case(k, flag("--null"));
        let truth = scene(&case, 1.7)?;
        let setup = ScanSetup::from_scene(&truth)?;
        let exact = frames(&setup, &setup.tissue.build_2d()?, Held::Depth, &|| true)?;
        let mut known = scan_preset("frames-galea")?;
        if let Some(inclusion) = known.scene.phantom.inclusion.first_mut().filter(|_| !flag("--free-depth")) {
            inclusion.depth_mm = case.depth_mm;
        }
        for seed in 0..seeds {
            let measured = noisy(&exact, number("--noise", 0.01), 1000 * k + seed)?;
            let question = Question {
                scene: &known,
                by_force: flag("--force"),
                free_depth: flag("--free-depth"),
                window_mm: known.scene.scan.window_mm,
                noise_kpa: 0.0,
                seed,
            };
            let true_values = [case.thickness_mm, case.radius_mm, case.contrast, case.youngs_kpa, case.depth_mm];
            let truths = true_values.map(|v| v.to_string()).join(",");
            match invert(&measured, &question, &|_| true) {
                Ok(found) => println!("{k},{seed},{truths},{}", row(&case, &found)),
                Err(error) => println!("{k},{seed},{truths},error: {error}"),
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}
