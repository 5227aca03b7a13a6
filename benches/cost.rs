//! Run time against size: pixels, samples, layers, LEDs, contact area, texels of the map, points of height fields; and
//! how full a vector of lanes is. (Triangles: `surfaces`. Finite elements: `converge`.)
//!
//!     cargo run --release --example cost -- [--rounds 5] [--only pixels]
//!
//! Every ladder starts from one scene and changes one thing. All rungs of a ladder are timed in turn, several times; a
//! row has the medians, and the slope of log(time) against log(size) from the rung before.

use anyhow::{Context as _, Result};
use clap::Parser;
use std::collections::BTreeMap;
use tirtouch::pipeline::model_of;
use tirtouch::scene::{LoadedScene, Pressure, Shape, preset};
use tirtouch::trace::cpu::camera::View;
use tirtouch::trace::cpu::{Limits, Path, book};
use tirtouch::trace::{BackendChoice, Devices, Precision, Settings, render};

#[derive(Parser)]
struct Arguments {
    /// Rounds.
    #[arg(long, default_value_t = 5)]
    rounds: usize,
    /// Only the ladders whose name holds this.
    #[arg(long, default_value = "")]
    only: String,
}

/// One thing that is varied.
struct Ladder {
    name: &'static str,
    scene: &'static str,
    sizes: &'static [f64],
    /// Gives a scene that size.
    set: fn(&mut LoadedScene, f64),
}

const SAMPLES: u32 = 64;

const LADDERS: [Ladder; 8] = [
    Ladder { name: "pixels", scene: "flat-bonded", sizes: &[1728.0, 6912.0, 27648.0, 110_592.0], set: pixels },
    Ladder { name: "samples", scene: "flat-bonded", sizes: &[16.0, 64.0, 256.0, 1024.0], set: samples },
    Ladder {
        name: "pixels, contact",
        scene: "contact-disc",
        sizes: &[1728.0, 6912.0, 27648.0, 110_592.0],
        set: pixels,
    },
    Ladder { name: "layers", scene: "flat-bonded", sizes: &[4.0, 8.0, 16.0, 32.0], set: layers },
    Ladder { name: "LEDs", scene: "contact-disc", sizes: &[4.0, 16.0, 64.0], set: leds },
    Ladder { name: "contact area, mm2", scene: "contact-disc", sizes: &[12.6, 50.3, 201.0, 616.0], set: contact_area },
    Ladder {
        name: "texels of the map",
        scene: "contact-disc",
        sizes: &[900.0, 3600.0, 14_400.0, 57_600.0],
        set: texels,
    },
    Ladder {
        name: "points of the height field",
        scene: "dent-cap",
        sizes: &[32.0, 64.0, 128.0, 256.0, 512.0],
        set: points,
    },
];

fn pixels(loaded: &mut LoadedScene, count: f64) {
    let camera = &mut loaded.scene.camera;
    let before = camera.pixels;
    let share = (count / f64::from(before[0] * before[1])).sqrt();
    camera.pixels = before.map(|n| (f64::from(n) * share).round() as u32);
    camera.pixel_pitch_um *= f64::from(before[0]) / f64::from(camera.pixels[0]);
}

fn samples(loaded: &mut LoadedScene, count: f64) {
    loaded.scene.render.spp = count as u32;
}

/// The upper layer cut into equal ones.
fn layers(loaded: &mut LoadedScene, count: f64) {
    let layers = &mut loaded.scene.stack.layer;
    let pieces = count as usize + 1 - layers.len();
    layers[0].thickness_mm /= pieces as f64;
    let first = layers[0].clone();
    layers.splice(0..0, std::iter::repeat_n(first, pieces - 1));
}

/// The LEDs beside themselves, each with its share of the power.
fn leds(loaded: &mut LoadedScene, count: f64) {
    let leds = &mut loaded.scene.led;
    let each = count as usize / leds.len();
    let all = leds.iter().flat_map(|led| {
        (0..each).map(move |k| {
            let mut led = led.clone();
            led.along_mm += (k as f64 + 0.5 - 0.5 * each as f64) * 20.0 / each as f64;
            led.diameter_mm /= (each as f64).sqrt();
            led
        })
    });
    *leds = all.collect();
}

fn contact_area(loaded: &mut LoadedScene, area: f64) {
    if let Some(contact) = &mut loaded.scene.touch.contact {
        let radius_mm = (area / std::f64::consts::PI).sqrt();
        contact.pressure = Pressure::Disc { radius_mm, center_mm: [0.0; 2], pressure_kpa: 1.0 };
    }
}

fn texels(loaded: &mut LoadedScene, count: f64) {
    loaded.scene.render.map_texel_mm = loaded.scene.stack.footprint_mm[0] / count.sqrt();
}

fn points(loaded: &mut LoadedScene, count: f64) {
    loaded.scene.touch.shape = Shape::GaussianDent { depth_mm: 1.0, sigma_mm: 2.5, center_mm: [0.0; 2] };
    loaded.scene.render.height_field_points = count as u32;
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    println!("| varied | size | seconds | of photons | of the map | of camera paths | ns a segment | slope |");
    println!("|---|---|---|---|---|---|---|---|");
    for ladder in LADDERS.iter().filter(|ladder| ladder.name.contains(&arguments.only)) {
        climb(ladder, arguments.rounds)?;
    }
    if "lanes".contains(&arguments.only) {
        println!(
            "\n| scene | segments a camera path | share of 8 lanes at work | of 16 | segments a photon | of 8 | of 16 |"
        );
        println!("|---|---|---|---|---|---|---|");
        for scene in ["flat-bonded", "dent-cap", "tsis-dent", "contact-disc"] {
            lanes(scene)?;
        }
    }
    Ok(())
}

/// Lanes of vectors of 256 and 512 bits.
const LANES: [usize; 2] = [8, 16];

/// Segments of paths, and how many of the lanes that walk side by side still have a segment to walk: their mean over
/// their longest. Where a path waits within a segment, in the search for a deformed face, comes on top.
fn lanes(scene: &str) -> Result<()> {
    let loaded = preset(scene)?;
    let model = model_of(&loaded, None)?.2.cast::<f32>();
    let texels = vec![[1.0f32; 4]; model.map_size.iter().product()];
    let view = View { exitance: model.tissue.is_some().then_some(texels.as_slice()), complement: false };
    let count = |walk: &mut dyn FnMut(&mut Path<f32>)| {
        let mut path = Path::new(&model, Limits::default());
        walk(&mut path);
        path.tally[book::SEGMENTS] as f64
    };
    let filled = |length: &dyn Fn(u32) -> f64| {
        let lengths: Vec<f64> = (0..model.camera.size[0] * model.camera.size[1]).map(length).collect();
        let mean = lengths.iter().sum::<f64>() / lengths.len() as f64;
        let shares = LANES.map(|lanes| {
            let groups = lengths.chunks_exact(lanes);
            let longest = groups.clone().map(|group| group.iter().copied().fold(0.0, f64::max)).sum::<f64>();
            groups.flatten().sum::<f64>() / (longest * lanes as f64)
        });
        format!("{mean:.1} | {:.2} | {:.2} |", shares[0], shares[1])
    };
    let camera = filled(&|pixel| count(&mut |path| _ = path.camera_path(view, 1, pixel, 0)));
    let photon = model.tissue.as_ref().map(|_| filled(&|thread| count(&mut |path| path.photon(1, thread, 0))));
    println!("| `{scene}` | {camera} {}", photon.as_deref().unwrap_or("- | - | - |"));
    Ok(())
}

fn climb(ladder: &Ladder, rounds: usize) -> Result<()> {
    let devices = Devices::open(BackendChoice::Auto, Precision::F32)?;
    let mut timed: BTreeMap<usize, Vec<[f64; 5]>> = BTreeMap::new();
    let mut models = Vec::new();
    for &size in ladder.sizes {
        let mut loaded = preset(ladder.scene)?;
        pixels(&mut loaded, 27_648.0);
        loaded.scene.render.spp = SAMPLES;
        (ladder.set)(&mut loaded, size);
        let model = model_of(&loaded, None)?.2;
        models.push((model, Settings::of(&loaded.scene.render)));
    }
    for _ in 0..rounds {
        for (k, (model, settings)) in models.iter().enumerate() {
            let outcome = render(&devices, model, settings, &mut |_| true)?;
            let times = outcome.times;
            let each = 1e9 * (times.photons + times.camera) / outcome.segments as f64;
            timed.entry(k).or_default().push([outcome.seconds, times.photons, times.map, times.camera, each]);
        }
    }
    let mut before: Option<[f64; 2]> = None;
    for (&size, rows) in ladder.sizes.iter().zip(timed.values()) {
        let median = |column: usize| {
            let mut values: Vec<f64> = rows.iter().map(|row| row[column]).collect();
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied().context("no round")
        };
        let seconds = median(0)?;
        let slope = before.map_or(String::new(), |[s, t]| format!("{:.2}", (seconds / t).ln() / (size / s).ln()));
        println!(
            "| {} | {size} | {seconds:.3} | {:.3} | {:.3} | {:.3} | {:.1} | {slope} |",
            ladder.name,
            median(1)?,
            median(2)?,
            median(3)?,
            median(4)?
        );
        before = Some([size, seconds]);
    }
    Ok(())
}
