//! The table of labels beside the images of a sweep, in the layout of Hugging Face's `imagefolder`, and its data card.

use crate::output::Records;
use crate::pages::PageError;
use crate::pages::facts::figure;
use crate::pages::tables::table;
use crate::pipeline::Truth;
use crate::scene::{Layer, LoadedScene, Scene};
use crate::sweep::{Format, Images, KeptLoad, Loads, Record, Sweep};
use crate::vary::KeyPath;
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
    head.extend(["row", "split", "seed"].map(str::to_owned));
    head.extend(sweep.plan.names().map(str::to_owned));
    let truths = ["true_size_mm", "true_depth_mm", "true_youngs_kpa", "true_phantom_youngs_kpa"];
    head.extend(truths.map(str::to_owned));
    head.extend(sweep.of_load().iter().map(|name| (*name).to_owned()));
    head.extend(["mm_per_pixel", "light_stream", "sensor_stream"].map(str::to_owned));
    let own = sweep.kept(records).filter(|(row, _)| images.split(*row) == split);
    let rows = own.flat_map(|(row, record)| rows(sweep, images, row, &record));
    table("metadata.csv", head, rows)
}

fn rows(sweep: &Sweep, images: &Images, row: usize, record: &Record) -> Vec<Vec<String>> {
    let text = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    let scene = sweep.plan.point(row).ok().and_then(|point| sweep.scene(&point).ok());
    let truth = match scene.as_ref().and_then(truth_of) {
        Some(truth) => {
            [&truth.size_mm, &truth.depth_mm, &truth.youngs_kpa, &truth.phantom_youngs_kpa].map(|one| text(one.value()))
        }
        None => Default::default(),
    };
    let seed = sweep.file.sweep.seed.or(scene.map(|loaded| loaded.scene.render.seed));
    let one = |kept: &crate::sweep::Kept| {
        let mut cells = vec![kept.file.clone()];
        cells.extend(images.baseline.then(|| images.baseline_file(row)));
        cells.extend(images.masks.then(|| Images::mask_file(record, kept)));
        cells.extend(images.pressures.then(|| Images::pressure_file(&kept.file)));
        cells.extend([
            row.to_string(),
            images.split(row).to_owned(),
            seed.map_or(String::new(), |seed| seed.to_string()),
        ]);
        cells.extend(record.values.iter().map(ToString::to_string));
        cells.extend(truth.clone());
        let load = |load: KeptLoad| {
            let [x, y] = load.slide_mm;
            let numbers = [load.depth_mm, load.force_n, x, y, load.hold_s].map(|number| number.to_string());
            [load.number.to_string()].into_iter().chain(numbers).collect()
        };
        let of_load: Vec<String> = kept.load.map_or(vec![String::new(); 6], load);
        cells.extend(of_load.into_iter().take(sweep.of_load().len()));
        cells.push(kept.mm_per_pixel.to_string());
        cells.extend(kept.streams.map(|stream| stream.to_string()));
        cells
    };
    record.images.iter().map(one).collect()
}

/// What a scene's phantom holds.
fn truth_of(loaded: &LoadedScene) -> Option<Truth> {
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
    let loads = match (images.loads, scene.press.is_some()) {
        (_, false) => "",
        (Loads::Last, true) => ", of the last load of each press",
        (Loads::All, true) => ", of every load of each press",
    };
    let keys = |keys: &[KeyPath]| match keys {
        [] => "-".to_owned(),
        keys => keys.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(", "),
    };
    let ranges: String = (names.iter().zip(&values).zip(sweep.plan.keys()))
        .map(|((name, seen), of)| format!("| `{name}` | {} | {} |\n", range(seen), keys(of)))
        .collect();
    let asked = &sweep.file.sweep.description;
    let beside = beside(images);
    let (name, version, sensor) = (&sweep.name, env!("CARGO_PKG_VERSION"), sensor(scene));
    let about = if asked.is_empty() { &scene.description } else { asked };
    format!(
        "# {name}\n\n{about}\n\nSynthetic images of the multilayer total-internal-reflection tactile sensor, made by \
         tirtouch {version}.\n\n\
         - {count} images of {points} points, {tests} of these for testing (`test/`), the others in `train/`.\n\
         - {width} x {height} pixels: {what}{loads}.\n{beside}\
         - `metadata.csv` has a row an image: what varied, what is true, depth (mm) and force (N) of the press. \
         Columns that end in `_mm`, `_kpa` and `_n` are in mm, kPa and N.\n\
         - Base scene: `scene.toml` ({}, SHA-256 {}); `sweep.toml` has what varies. `tirtouch sweep scene . ROW` prints \
         the scene of any row.\n\n## The sensor\n\n{sensor}\n\n## What varies\n\n\
         | column | range here | key of the scene, with its unit |\n|---|---|---|\n{ranges}\n\
         ## Limits\n\nThe images are simulated: materials, contact and exposure are those of the scene, some of them \
         assumed. They hold no measured data.\n\n## How to cite\n\n> tirtouch {version}: open simulator of the \
         multilayer total-internal-reflection tactile sensor. Data set {name}, scene {} (SHA-256 {}).\n\nThe comments \
         of `scene.toml` name the papers that its numbers are from; cite these too.\n",
        scene.name, sweep.base.sha256, scene.name, sweep.base.sha256,
    )
}

/// What lies beside each image.
fn beside(images: &Images) -> String {
    let kept = [
        (
            images.baseline,
            "the phantom without its inclusion, once a phantom, at its last load: it suits that load's frame",
        ),
        (images.masks, "a mask, once a phantom or where this slides a load: 255 over an inclusion's outline"),
        (images.pressures, "contact pressures of each image, kPa (`numpy.load`)"),
    ];
    kept.iter().filter(|(kept, _)| *kept).map(|(_, what)| format!("- Beside them: {what}.\n")).collect()
}

/// The base scene's sensor in words.
fn sensor(scene: &Scene) -> String {
    let layer = |one: &Layer| match one.n {
        Some(n) => format!("{} ({} mm, n = {n})", one.name, one.thickness_mm),
        None => format!("{} ({} mm)", one.name, one.thickness_mm),
    };
    let layers = scene.stack.layer.iter().map(layer).collect::<Vec<_>>().join(", ");
    let [length, width] = scene.stack.footprint_mm;
    let (leds, sensor) = (scene.led.len(), &scene.camera.sensor);
    format!(
        "Layers, touch side first: {layers}; {length} x {width} mm. {leds} LEDs, {} nm. Camera below: {} ms, {} bits.",
        scene.light.wavelength_nm, sensor.exposure_ms, sensor.bit_depth,
    )
}
