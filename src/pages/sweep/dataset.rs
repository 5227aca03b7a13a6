//! The table of labels beside the images of a sweep, in the layout of Hugging Face's `imagefolder`, and its data card.

use crate::output::Records;
use crate::pages::PageError;
use crate::pages::facts::figure;
use crate::pages::tables::table;
use crate::pipeline::Truth;
use crate::sweep::{Format, Images, Loads, Record, Sweep};
use std::collections::BTreeMap;

/// `metadata.csv` of a split: a row an image, with its file, those of its baseline, mask and contact
/// pressures, what varied and what is true.
///
/// # Errors
/// Never for what a sweep holds.
pub fn metadata_csv(sweep: &Sweep, images: &Images, records: &Records, split: &str) -> Result<String, PageError> {
    let mut head = vec!["file_name".to_owned()];
    let beside =
        [("baseline_file_name", images.baseline), ("mask_file_name", images.masks), ("pressure_npy", images.pressures)];
    head.extend(beside.iter().filter(|(_, kept)| *kept).map(|(name, _)| (*name).to_owned()));
    head.push("row".into());
    head.extend(sweep.plan.names().map(str::to_owned));
    let truths = ["true_size_mm", "true_depth_mm", "true_youngs_kpa", "true_phantom_youngs_kpa"];
    head.extend(truths.map(str::to_owned));
    let of_image = ["load", "press_depth_mm", "force_n", "mm_per_pixel", "light_stream", "sensor_stream"];
    head.extend(of_image.map(str::to_owned));
    let own = sweep.kept(records).filter(|(row, _)| images.split(*row) == split);
    let rows = own.flat_map(|(row, record)| rows(sweep, images, row, &record));
    table("metadata.csv", head, rows)
}

fn rows(sweep: &Sweep, images: &Images, row: usize, record: &Record) -> Vec<Vec<String>> {
    let text = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    let truth = truth(sweep, row);
    let truth = match &truth {
        Some(truth) => {
            [&truth.size_mm, &truth.depth_mm, &truth.youngs_kpa, &truth.phantom_youngs_kpa].map(|one| text(one.value()))
        }
        None => Default::default(),
    };
    let one = |kept: &crate::sweep::Kept| {
        let mut cells = vec![kept.file.clone()];
        cells.extend(images.baseline.then(|| images.baseline_file(row)));
        cells.extend(images.masks.then(|| Images::mask_file(row)));
        cells.extend(images.pressures.then(|| Images::pressure_file(&kept.file)));
        cells.push(row.to_string());
        cells.extend(record.values.iter().map(ToString::to_string));
        cells.extend(truth.clone());
        let load = |of: fn(&(usize, f64, f64)) -> String| kept.load.as_ref().map_or(String::new(), of);
        cells.extend([load(|one| one.0.to_string()), load(|one| one.1.to_string()), load(|one| one.2.to_string())]);
        cells.push(kept.mm_per_pixel.to_string());
        cells.extend(kept.streams.map(|stream| stream.to_string()));
        cells
    };
    record.images.iter().map(one).collect()
}

/// What a point's phantom holds.
fn truth(sweep: &Sweep, row: usize) -> Option<Truth> {
    let loaded = sweep.scene(&sweep.plan.point(row).ok()?).ok()?;
    Truth::of(loaded.scene.phantom.as_ref(), &loaded.files, false).ok()
}

/// What values lie between, or all that there are.
fn range(values: &BTreeMap<String, Option<f64>>) -> String {
    let numbers = || values.values().flatten().copied();
    let [low, high] = [numbers().fold(f64::INFINITY, f64::min), numbers().fold(f64::NEG_INFINITY, f64::max)];
    match values.values().all(Option::is_some) {
        true if low < high => format!("{} to {}", figure(low), figure(high)),
        true if low == high => figure(low),
        _ => values.keys().cloned().collect::<Vec<_>>().join(", "),
    }
}

/// The data card: what the images are of, with ranges and units.
pub fn card(sweep: &Sweep, images: &Images, records: &Records) -> String {
    let names: Vec<&str> = sweep.plan.names().collect();
    let mut values = vec![BTreeMap::new(); names.len()];
    let (mut count, mut points, mut tests) = (0, 0, 0);
    for (row, record) in sweep.kept(records) {
        points += 1;
        tests += usize::from(images.is_test(row));
        count += record.images.len();
        for (seen, value) in values.iter_mut().zip(&record.values) {
            seen.insert(value.to_string(), value.number());
        }
    }
    let scene = &sweep.base.scene;
    let [width, height] = scene.camera.pixels;
    let what = match images.format {
        Format::Png => format!("{} grey levels of the camera", 1u32 << scene.camera.sensor.bit_depth),
        Format::Npy => "radiance, W/(m^2 sr), arrays of NumPy's (rows, columns), 32-bit float".into(),
        Format::Exr => "radiance with its variance, W/(m^2 sr), linear, 32-bit float".into(),
    };
    let loads = match images.loads {
        Loads::Last => "the last load of each press",
        Loads::All => "every load of each press",
    };
    let rows = names.iter().zip(&values).map(|(name, seen)| format!("| `{name}` | {} |\n", range(seen)));
    let ranges: String = rows.collect();
    format!(
        "# {}\n\n{}\n\nSynthetic images of the multilayer total-internal-reflection tactile sensor, made by tirtouch {}.\n\n\
         - {count} images of {points} points, {tests} of these for testing (`test/`), the others in `train/`.\n\
         - {width} x {height} pixels: {what}. Of {loads}.\n\
         - `metadata.csv` has a row an image: what varied, what is true, depth (mm) and force (N) of the press.\n\
         - Base scene: `scene.toml` ({}, SHA-256 {}); `sweep.toml` has what varies. `tirtouch sweep scene . ROW` prints \
         the scene of any row.\n\n| what varies | range here |\n|---|---|\n{ranges}\nThe images are simulated: materials, \
         contact and exposure are those of the scene, some of them assumed. They hold no measured data.\n\nCite tirtouch \
         {} and the scene's sources.\n",
        sweep.name,
        if sweep.file.sweep.description.is_empty() { &scene.description } else { &sweep.file.sweep.description },
        env!("CARGO_PKG_VERSION"),
        scene.name,
        sweep.base.sha256,
        env!("CARGO_PKG_VERSION"),
    )
}
