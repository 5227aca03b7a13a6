//! How far is the irradiance map from the truth, against the edge of its texels?
//!
//!     cargo run --release --example map_bias -- out/map-bias
//!
//! `splat` is unbiased on flat stacks and meets the same photons as `map` where the seed is the same, so the two images
//! differ by the map's bias and by little noise. Each round is one render at default samples: its spread is the noise
//! that a user sees. The map is smoothed as such a render would smooth it, by a kernel chosen from 16 replicates of its
//! own; a third argument `raw` leaves that out. Only the middle of the image is rendered. Writes `map_bias.csv` and
//! prints the table for docs/decisions/map-texel.md. Takes about 10 minutes on 2 cores.

mod statistics;

use anyhow::{Context as _, Result};
use statistics::{Estimate, Replicates, block_means};
use std::path::PathBuf;
use tirtouch::pipeline::model_of;
use tirtouch::scene::{LoadedScene, preset};
use tirtouch::trace::batch::{Batch, Work};
use tirtouch::trace::exitance::{Smoothing, TouchedFace};
use tirtouch::trace::render::REPLICATES;
use tirtouch::trace::{BackendChoice, Devices, Integrator, Model, Precision};

/// A scene, the middle of its image, and the radius of what is looked at.
struct Case {
    scene: &'static str,
    pixels: [u32; 2],
    radius_mm: f64,
}

/// Contact with a sharp rim; a Hertz bump, whose share of contact falls to the base within its radius.
const CASES: [Case; 2] = [
    Case { scene: "contact-disc", pixels: [112, 112], radius_mm: 4.0 },
    Case { scene: "press-hertz", pixels: [144, 144], radius_mm: 5.0 },
];
const TEXELS_MM: [f64; 3] = [0.5, 0.25, 0.125];
/// Half the width of the ring of pixels about the rim.
const RIM_PIXELS: f64 = 2.5;

/// One line of the table, all relative.
struct Row {
    scene: &'static str,
    texel_mm: f64,
    /// Bias, and noise of one render: of the mean within 0.9 of the radius, of the ring about it, of blocks of 4 and of
    /// 16 pixels.
    regions: [(Estimate, f64); 4],
}

/// Rounds of one method.
#[derive(Default)]
struct Rounds {
    /// Mean within 0.9 of the radius, and over the ring about it.
    means: Replicates,
    /// Blocks of 4 and of 16 pixels.
    blocks: [Replicates; 2],
}

fn main() -> Result<()> {
    let folder = std::env::args().nth(1).map_or_else(|| PathBuf::from("out/map-bias"), PathBuf::from);
    let raw = std::env::args().nth(3).is_some_and(|word| word == "raw");
    let rounds = std::env::args().nth(2).map_or(Ok(16), |n| n.parse()).context("the second argument is rounds")?;
    std::fs::create_dir_all(&folder)?;
    let mut rows = Vec::new();
    for case in &CASES {
        let splat = measure(case, Integrator::Splat, TEXELS_MM[0], rounds, raw)?;
        for texel_mm in TEXELS_MM {
            let map = measure(case, Integrator::Map, texel_mm, rounds, raw)?;
            rows.push(row(case, texel_mm, &map, &splat));
        }
    }
    print_table(&rows, rounds);
    write_csv(&rows, &folder.join("map_bias.csv"))
}

fn measure(case: &Case, integrator: Integrator, texel_mm: f64, rounds: u32, raw: bool) -> Result<Rounds> {
    let mut loaded = preset(case.scene)?;
    loaded.scene.render.map_texel_mm = texel_mm;
    let mut model = model_of(&loaded, None)?.2;
    let whole = model.camera.size;
    model.camera.size = case.pixels;
    let spp = loaded.scene.render.spp;
    let work = Work { spp, photons: u64::from(whole[0]) * u64::from(whole[1]) * u64::from(spp) };
    let masks = masks(case, &loaded, &model);
    let mut backend = Devices::open(BackendChoice::Auto, Precision::F32)?.load(&model)?;
    eprintln!(
        "{} {} {texel_mm} mm: {} photons a round, {}",
        case.scene,
        integrator.name(),
        work.photons,
        backend.adapter()
    );
    let mut batch = Batch::new(&model, &mut backend, integrator, 1);
    let mut out = Rounds::default();
    let face = TouchedFace::new(&model);
    let mut smoothing = Smoothing::default();
    if integrator == Integrator::Map && !raw {
        let part = Work { photons: work.photons / u64::from(REPLICATES), ..work };
        let lights = (0..REPLICATES).map(|k| batch.contact_light(1000 + k, part, &face, &mut |_| true));
        smoothing = face.choose(&lights.collect::<Result<Vec<_>, _>>()?);
        eprintln!("boxes of {:?} texels", smoothing.widths);
    }
    for round in 0..rounds {
        let image = if integrator == Integrator::Map {
            let light = batch.contact_light(round, work, &face, &mut |_| true)?;
            let texels = face.texels(&[light], smoothing).pop().context("a map")?;
            batch.mapped(round, work, &texels, &mut |_| true)?
        } else {
            batch.replicate(round, work, &mut |_| true)?
        };
        out.means.rounds.push(masks.iter().map(|mask| statistics::marked_mean(&image, mask)).collect());
        for (blocks, edge) in out.blocks.iter_mut().zip([4, 16]) {
            blocks.rounds.push(block_means(&image, case.pixels, edge));
        }
    }
    Ok(out)
}

/// Pixels within 0.9 of the apparent radius, and those of the ring about it.
fn masks(case: &Case, loaded: &LoadedScene, model: &Model<f64>) -> [Vec<bool>; 2] {
    let wavelength = loaded.scene.light.wavelength_nm;
    let depth: f64 = loaded.scene.stack.layer.iter().map(|l| l.thickness_mm / l.index(wavelength)).sum();
    let radius = case.radius_mm / (model.camera.distance + depth) / model.camera.pixel_tan;
    let [width, height] = case.pixels;
    let distance = |k: u32| {
        let (x, y) = (f64::from(k % width) + 0.5, f64::from(k / width) + 0.5);
        (x - 0.5 * f64::from(width)).hypot(y - 0.5 * f64::from(height))
    };
    let mask = |inside: &dyn Fn(f64) -> bool| (0..width * height).map(|k| inside(distance(k))).collect();
    [mask(&|r| r < 0.9 * radius), mask(&|r| (r - radius).abs() < RIM_PIXELS)]
}

fn row(case: &Case, texel_mm: f64, map: &Rounds, splat: &Rounds) -> Row {
    let mean = |cell: usize| {
        let only: Vec<bool> = (0..2).map(|k| k == cell).collect();
        (map.means.relative_bias(&splat.means, cell), map.means.noise(&only))
    };
    let blocks = |k: usize| {
        let lit = splat.blocks[k].lit();
        (map.blocks[k].rms_bias(&splat.blocks[k], &lit), map.blocks[k].noise(&lit))
    };
    Row { scene: case.scene, texel_mm, regions: [mean(0), mean(1), blocks(0), blocks(1)] }
}

fn print_table(rows: &[Row], rounds: u32) {
    println!(
        "{rounds} rounds. Bias of the radiance in percent, in brackets the noise of one render at default samples.\n"
    );
    println!("| scene | texel | middle | rim | 4-pixel blocks, rms | 16-pixel blocks, rms |");
    println!("|---|---|---|---|---|---|");
    for row in rows {
        let cells = row.regions.map(|(bias, noise)| {
            format!("{:+.2} ± {:.2} ({:.2})", 100.0 * bias.value, 100.0 * bias.error, 100.0 * noise)
        });
        println!("| {} | {} mm | {} |", row.scene, row.texel_mm, cells.join(" | "));
    }
}

fn write_csv(rows: &[Row], path: &std::path::Path) -> Result<()> {
    let mut out = csv::Writer::from_path(path)?;
    let regions = ["middle", "rim", "block4", "block16"];
    let columns =
        regions.iter().flat_map(|region| ["bias", "bias_error", "noise"].map(|kind| format!("{region}_{kind}")));
    out.write_record(["scene", "texel_mm"].map(str::to_owned).into_iter().chain(columns))?;
    for row in rows {
        let numbers = row.regions.iter().flat_map(|(bias, noise)| [bias.value, bias.error, *noise]);
        let texel = row.texel_mm.to_string();
        out.write_record([row.scene.to_owned(), texel].into_iter().chain(numbers.map(|v| format!("{v:e}"))))?;
    }
    out.flush()?;
    Ok(())
}
