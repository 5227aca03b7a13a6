//! What a press in three dimensions costs: unknowns, iterations, cycles, seconds, memory.
//!
//!     cargo run --release --example solid_press -- SCENE [--method direct|multigrid] [--resolution R] [--depth MM]
//!                                                  [--edge-mm R] [--sibling] [--against R]
//!
//! Memory is the most that the process held (Linux). Runs one press and prints one row of a table. With `--sibling` the
//! scene, a body of revolution, is pressed in two dimensions too, on elements of half the size, and rows say by how
//! much force and pressure in rings differ. With `--against` it is pressed at another resolution too, and a row says by
//! how much the first differs from that, the pressure rms over 0.8 of the footprint.

use anyhow::{Context as _, Result};
use clap::{Parser, ValueEnum};
use std::path::PathBuf;
use tirtouch::mechanics::from_scene::press_setup;
use tirtouch::mechanics::newton::LinearSolver;
use tirtouch::mechanics::press::error_estimate::difference;
use tirtouch::mechanics::press::{Face, Load, PressSettings, PressStep, Pressed, Setup, press};
use tirtouch::scene::{Dimensions, LoadedScene, load, preset};

#[derive(Clone, Copy, ValueEnum)]
enum How {
    Direct,
    Multigrid,
}

#[derive(Parser, Clone)]
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
    /// `press.edge_radius_mm`, in place of the scene's.
    #[arg(long)]
    edge_mm: Option<f64>,
    /// Compare with the press in two dimensions.
    #[arg(long)]
    sibling: bool,
    /// Compare with the press at this resolution.
    #[arg(long, value_name = "R")]
    against: Option<f64>,
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
    press.edge_radius_mm = arguments.edge_mm.or(press.edge_radius_mm);
    Ok(loaded)
}

/// Mean pressure in rings about the axis, kPa: the forces of the nodes in each over their areas.
fn rings(step: &PressStep, edges: &[f64]) -> Vec<f64> {
    let mut sums = vec![[0.0; 2]; edges.len() - 1];
    for point in &step.points {
        let r = point.reference_mm[0].hypot(point.reference_mm[1]);
        if let Some(ring) = edges.windows(2).position(|pair| pair[0] <= r && r < pair[1]) {
            sums[ring][0] += point.force_mn;
            sums[ring][1] += point.area_mm2;
        }
    }
    sums.iter().map(|[force, area]| force / area).collect()
}

fn compare(arguments: &Arguments, solid: &Pressed) -> Result<()> {
    let mut loaded = scene(arguments)?;
    let press_of = loaded.scene.press.as_mut().context("the scene has no press")?;
    (press_of.dimensions, press_of.resolution) = (Dimensions::Two, 2.0);
    let mut setup = press_setup(&loaded)?;
    setup.load = solid.setup.load.clone();
    let plane = press(&setup, PressSettings::default(), &mut |_| true)?;
    let (solid, plane) = (solid.steps.last().context("no load")?, plane.steps.last().context("no load")?);
    let reach = setup.reach_mm();
    println!("force {:+.3} %", 100.0 * (solid.force_n / plane.force_n - 1.0));
    let edges: Vec<f64> = (0..=10).map(|k| 0.1 * f64::from(k) * reach).collect();
    for ((pair, solid), plane) in edges.windows(2).zip(rings(solid, &edges)).zip(rings(plane, &edges)) {
        println!("{:5.1} to {:5.1} mm: {:+.2} %", pair[0], pair[1], 100.0 * (solid / plane - 1.0));
    }
    Ok(())
}

/// Most memory that the process held, GiB.
fn peak_gib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? / f64::from(1 << 20))
}

/// Presses without an estimate of the error, and says in a row what it took.
fn row(setup: &Setup, arguments: &Arguments) -> Result<Pressed> {
    let method = arguments.method.map(|how| match how {
        How::Direct => LinearSolver::Direct,
        How::Multigrid => LinearSolver::Multigrid,
    });
    let pressed = press(setup, PressSettings { estimate_error: false, method }, &mut |stage| {
        eprintln!("{:.3}", stage.done);
        true
    })?;
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
    Ok(pressed)
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let mut setup = press_setup(&scene(&arguments)?)?;
    if let Some(depth) = arguments.depth {
        setup.load = Load::Depths(vec![depth]);
    }
    println!("| unknowns | iterations | cycles | seconds | memory, GiB | force, N | peak, kPa |");
    let pressed = row(&setup, &arguments)?;
    if arguments.sibling {
        compare(&arguments, &pressed)?;
    }
    if let Some(resolution) = arguments.against {
        let other = press_setup(&scene(&Arguments { resolution: Some(resolution), ..arguments.clone() })?)?;
        let other = row(&Setup { load: setup.load, ..other }, &arguments)?;
        let [(step, face), (others, reference)] = [&pressed, &other].map(|one| {
            let step = &one.steps[one.steps.len() - 1];
            (step, Face::of(one, step))
        });
        let force = step.force_n / others.force_n - 1.0;
        println!("force {:+.3} %, pressure {:.3} %", 100.0 * force, 100.0 * difference(&face, &reference));
    }
    Ok(())
}
