//! Labelled images of phantoms, as a data set wants them: how many a minute, in a session that stays warm and by one
//! command after the other?
//!
//!     LP_NATIVE_VECTOR_WIDTH=512 cargo run --release --example labelled_images -- [--images 12] [--seed 1]
//!         [--error 0.01] [--sweep] [--estimate] [--alone FOLDER] [--program target/release/tirtouch]
//!
//! Draws spheres of 4 to 14 mm and 20 to 150 kPa, their tops 3 to 10 mm deep as far as they fit, in the phantom of
//! `phantom-size-8mm`; each is pressed by 1, 2 and 4 mm, and its image at 4 mm is traced to the error asked for, a
//! share of a pixel's radiance, and exposed. One thread presses the next phantom, from the last one, while this one is
//! traced. With `--alone` the scenes are written to a folder, and each is pressed from rest once the one before is
//! traced, with its number as its seed, and is traced to the error: a plain loop, which labelled_images.py times from
//! Python. With `--sweep` the phantom stays and the index of the touched layer changes. Presses estimate their errors
//! with `--estimate`.
//!
//! Prints the label, the sum of grey levels and the seconds of each image, and images a minute; with `--program` also
//! those of that program, a command for each image of the same scenes. The variable makes Mesa's llvmpipe work as
//! widely as the program lets it; other drivers do not read it.

use anyhow::{Context as _, Result, ensure};
use clap::Parser;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::time::Instant;
use tirtouch::camera::Frame;
use tirtouch::camera::noise::PixelRandom;
use tirtouch::pipeline::{Order, Prepared, Session};
use tirtouch::scene::{Elastic, InclusionBody, LoadedScene, load, preset};
use tirtouch::trace::{BackendChoice, Devices, Outcome, Precision};

#[derive(Parser)]
struct Arguments {
    /// Images.
    #[arg(long, default_value_t = 12)]
    images: u32,
    /// Seed of the draws.
    #[arg(long, default_value_t = 1)]
    seed: u32,
    /// Error of each image's pixels.
    #[arg(long, default_value_t = 0.01)]
    error: f64,
    /// The phantom stays, and the index of the touched layer changes.
    #[arg(long)]
    sweep: bool,
    /// Presses estimate their errors.
    #[arg(long)]
    estimate: bool,
    /// A plain loop over the scenes, which are written there.
    #[arg(long, value_name = "FOLDER")]
    alone: Option<PathBuf>,
    /// A program that renders the same scenes, one a command.
    #[arg(long)]
    program: Option<PathBuf>,
}

/// A scene and its label.
fn drawn(arguments: &Arguments, number: u32) -> Result<(LoadedScene, String)> {
    let mut random = PixelRandom::new(arguments.seed, number);
    let mut between = |low: f64, high: f64| low + (high - low) * random.uniform();
    let mut loaded = preset("phantom-size-8mm")?;
    let scene = &mut loaded.scene;
    let press = scene.press.as_mut().context("the preset presses")?;
    press.depths_mm = Some(vec![1.0, 2.0, 4.0]);
    press.estimate_error = arguments.estimate;
    let label = if arguments.sweep {
        let n = between(1.405, 1.43);
        scene.stack.layer[0].n = Some(n);
        format!("n {n:.4}")
    } else {
        let inclusion = &mut scene.phantom.as_mut().context("the preset has a phantom")?.inclusion[0];
        let diameter_mm = between(4.0, 14.0);
        let top_mm = between(3.0, (25.0 - 1.05 * diameter_mm).min(10.0));
        let kpa = between(20f64.ln(), 150f64.ln()).exp();
        inclusion.shape = InclusionBody::Sphere { diameter_mm };
        inclusion.depth_mm = top_mm;
        match &mut inclusion.material {
            Elastic::NeoHookean { youngs_kpa, .. } | Elastic::Linear { youngs_kpa, .. } => *youngs_kpa = kpa,
            other => anyhow::bail!("{other:?}"),
        }
        format!("{diameter_mm:.2} mm, {top_mm:.2} mm deep, {kpa:.1} kPa")
    };
    Ok((loaded, label))
}

/// Resident memory of this process, MiB, where the system says.
fn resident_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
    line.split_whitespace().nth(1)?.parse::<f64>().ok().map(|kib| kib / 1024.0)
}

/// Presses the phantoms one after the other.
fn presses(arguments: &Arguments, ready: &SyncSender<Result<(Prepared, String)>>) {
    let mut session = Session::from(Devices::cpu(Precision::F32));
    for number in 0..arguments.images {
        let prepared = drawn(arguments, number).and_then(|(loaded, label)| {
            let order = Order { near: true, ..Order::of(&loaded.scene) };
            Ok((session.prepare(loaded, &order, &mut |_| true)?, label))
        });
        if ready.send(prepared).is_err() {
            return;
        }
    }
}

/// Renders the scenes of a folder one after the other, each to the error.
fn alone(arguments: &Arguments, session: &mut Session, files: &[PathBuf]) -> Result<()> {
    for (number, file) in files.iter().enumerate() {
        let timer = Instant::now();
        let loaded = load(file)?;
        let mut order = Order::of(&loaded.scene);
        order.settings.target_error = Some(arguments.error);
        order.settings.seed = u32::try_from(number)?;
        let prepared = session.prepare(loaded, &order, &mut |_| true)?;
        let shot = session.shoot(&prepared, &mut |_| true)?;
        said(number, &file.display().to_string(), timer, &shot.frame, &shot.outcome);
    }
    Ok(())
}

/// Renders the scenes, each pressed while the one before is traced. Gives the time to the first, seconds.
fn beside(arguments: &Arguments, session: &Session, start: Instant) -> Result<f64> {
    let mut first = 0.0;
    std::thread::scope(|scope| -> Result<()> {
        // A press waits until the one before is taken.
        let (ready, images) = sync_channel(0);
        scope.spawn(|| presses(arguments, &{ ready }));
        for (number, image) in images.into_iter().enumerate() {
            let (mut prepared, label) = image?;
            let timer = Instant::now();
            prepared.settings.target_error = Some(arguments.error);
            let shot = session.shoot(&prepared, &mut |_| true)?;
            said(number, &label, timer, &shot.frame, &shot.outcome);
            if number == 0 {
                first = start.elapsed().as_secs_f64();
            }
        }
        Ok(())
    })?;
    Ok(first)
}

/// Prints what an image took.
fn said(number: usize, label: &str, timer: Instant, frame: &Frame, outcome: &Outcome) {
    let grey: u64 = frame.grey.iter().map(|&grey| u64::from(grey)).sum();
    println!(
        "{number}: {label}: {:.2} s ({:.2} kernels), error {:.4}, grey {grey}, {:.0} MiB",
        timer.elapsed().as_secs_f64(),
        outcome.setup_seconds,
        outcome.relative_error.unwrap_or(f64::NAN),
        resident_mib().unwrap_or(f64::NAN),
    );
}

/// The scenes, as files of a folder.
fn written(arguments: &Arguments, folder: &Path) -> Result<Vec<PathBuf>> {
    std::fs::create_dir_all(folder)?;
    let scenes = (0..arguments.images).map(|number| {
        let file = folder.join(format!("{number}.toml"));
        std::fs::write(&file, toml::to_string(&drawn(arguments, number)?.0.scene)?)?;
        Ok(file)
    });
    scenes.collect()
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let rate = |images: u32, seconds: f64| 60.0 * f64::from(images) / seconds;
    if let Some(folder) = &arguments.alone {
        let files = written(&arguments, folder)?;
        let start = Instant::now();
        let mut session = Session::open(BackendChoice::Auto, Precision::F32)?;
        alone(&arguments, &mut session, &files)?;
        println!("loop: {:.1} images a minute", rate(arguments.images, start.elapsed().as_secs_f64()));
    } else {
        let start = Instant::now();
        let session = Session::open(BackendChoice::Auto, Precision::F32)?;
        let first = beside(&arguments, &session, start)?;
        let seconds = start.elapsed().as_secs_f64();
        let after = rate(arguments.images.saturating_sub(1), seconds - first);
        println!("session: {:.1} images a minute, {after:.1} after the first", rate(arguments.images, seconds));
    }
    if let Some(program) = &arguments.program {
        let folder = std::env::temp_dir().join(format!("tirtouch-labelled-images-{}", std::process::id()));
        let scenes = written(&arguments, &folder)?;
        let start = Instant::now();
        for (number, scene) in scenes.iter().enumerate() {
            let mut command = Command::new(program);
            command.arg("render").arg(scene).args(["--quiet", "--target-error", &arguments.error.to_string(), "-o"]);
            let done = command.arg(folder.join(number.to_string())).stdout(Stdio::null()).status()?;
            ensure!(done.success(), "{}: {done}", scene.display());
        }
        println!("commands: {:.1} images a minute", rate(arguments.images, start.elapsed().as_secs_f64()));
        std::fs::remove_dir_all(&folder)?;
    }
    Ok(())
}
