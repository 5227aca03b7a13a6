//! What a press in three dimensions costs: unknowns, iterations, cycles, seconds, memory.
//!
//!     cargo run --release --example solid_press -- SCENE [--method direct|multigrid] [--resolution R] [--depth MM]
//!
//! Memory is the most that the process held (Linux). Runs one press and prints one row of a table.

use anyhow::{Context as _, Result};
use clap::{Parser, ValueEnum};
use std::path::PathBuf;
use tirtouch::mechanics::from_scene::press_setup;
use tirtouch::mechanics::newton::Method;
use tirtouch::mechanics::press::{Load, PressSettings, press};
use tirtouch::scene::{Dimensions, LoadedScene, load, preset};

#[derive(Clone, Copy, ValueEnum)]
enum How {
    Direct,
    Multigrid,
}

#[derive(Parser)]
struct Arguments {
    /// Scene file, or preset:NAME.
    scene: PathBuf,
    /// How linear systems are solved; by cost if not given.
    #[arg(long)]
    method: Option<How>,
    /// `press.resolution`, in place of the scene's.
    #[arg(long)]
    resolution: Option<f64>,
    /// The only depth, mm, in place of the scene's loads.
    #[arg(long)]
    depth: Option<f64>,
}

fn scene(arguments: &Arguments) -> Result<LoadedScene> {
    let name = arguments.scene.to_str().and_then(|path| path.strip_prefix("preset:"));
    let mut loaded = match name {
        Some(name) => preset(name).context("no such preset")?,
        None => load(&arguments.scene).map_err(|error| anyhow::anyhow!("{error}"))?,
    };
    let press = loaded.scene.press.as_mut().context("the scene has no press")?;
    press.dimensions = Dimensions::Three;
    press.resolution = arguments.resolution.unwrap_or(press.resolution);
    Ok(loaded)
}

/// Most memory that the process held, GiB.
fn peak_gib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? / f64::from(1 << 20))
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let mut setup = press_setup(&scene(&arguments)?)?;
    if let Some(depth) = arguments.depth {
        setup.load = Load::Depths(vec![depth]);
    }
    let method = arguments.method.map(|how| match how {
        How::Direct => Method::Direct,
        How::Multigrid => Method::Multigrid,
    });
    let pressed = press(&setup, PressSettings { estimate_error: false, method }, &mut |stage| {
        eprintln!("{:.3}", stage.done);
        true
    })?;
    println!("| unknowns | iterations | cycles | seconds | memory, GiB | force, N | peak, kPa |");
    let last = pressed.steps.last().context("no load was reached")?;
    println!(
        "| {} | {} | {} | {:.1} | {:.2} | {:.6} | {:.4} |",
        pressed.unknowns,
        pressed.iterations,
        pressed.cycles,
        pressed.seconds,
        peak_gib().unwrap_or(f64::NAN),
        last.force_n,
        last.peak_pressure_kpa,
    );
    Ok(())
}
