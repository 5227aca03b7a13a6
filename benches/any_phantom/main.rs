//! How often does a press of a phantom that nobody chose come to its end, and how long does it take?
//!
//!     cargo run --release --example any_phantom -- [--phantoms 500] [--solid] [--resolution F] [--edge-mm R] [--seed 1]
//!                                                  [--all] [--mesh] [--friction F] [--near [--estimated]]
//!
//! Draws phantoms about `phantom-size-8mm`: a sphere of 4 to 14 mm and 20 to 150 kPa (log-uniform), its top 2 to 11 mm
//! deep as far as it fits, in 3 to 10 kPa, pressed from 0.5 mm to 0.5 to 5 mm in three loads, each with and without its
//! inclusion. With `--solid` the sphere lies up to 8 mm off the axis, at any angle about it, and the phantom is tilted
//! by up to 2 degrees, so that the press is one in three dimensions without a symmetry. With `--mesh` they are meshed
//! and not pressed. With `--friction` faces slide instead of being tied, 0 without friction. With `--near`
//! each is pressed twice, alone and from what the phantom before it found. Prints a row for each failure, then counts
//! and times.

use anyhow::{Context as _, Result};
use clap::Parser;
use std::time::Instant;
use tirtouch::camera::noise::PixelRandom;
use tirtouch::mechanics::from_scene::press_setup;
use tirtouch::mechanics::press::{PressError, PressSettings, Pressed, press, press_near};
use tirtouch::scene::{Elastic, InclusionBody, Interface, LoadedScene, preset};

#[derive(Parser)]
struct Arguments {
    /// Phantoms.
    #[arg(long, default_value_t = 500)]
    phantoms: u32,
    /// First of them.
    #[arg(long, default_value_t = 0)]
    first: u32,
    /// Seed of the draws.
    #[arg(long, default_value_t = 1)]
    seed: u32,
    /// Radius of the sensor's rim, mm; the scene's own if not given.
    #[arg(long)]
    edge_mm: Option<f64>,
    /// Presses in three dimensions, of spheres off the axis.
    #[arg(long)]
    solid: bool,
    /// Fineness of the meshes, as `press.resolution`.
    #[arg(long, default_value_t = 1.0)]
    resolution: f64,
    /// Friction of faces that slide; tied if not given.
    #[arg(long)]
    friction: Option<f64>,
    /// Each phantom, with its inclusion, starts from the one before, and is pressed alone as well.
    #[arg(long)]
    near: bool,
    /// With `near`: from its own press on a coarser mesh, which estimates the error, instead of the one before.
    #[arg(long, requires = "near")]
    estimated: bool,
    /// Meshes only.
    #[arg(long)]
    mesh: bool,
    /// Force of every phantom on standard output.
    #[arg(long)]
    all: bool,
}

/// Numbers of a phantom.
struct Drawn {
    diameter_mm: f64,
    top_mm: f64,
    lump_kpa: f64,
    body_kpa: f64,
    depths_mm: Vec<f64>,
    /// Place of the sphere in plan, where the press is one in three dimensions.
    center_mm: [f64; 2],
    /// Tilt of the phantom there.
    tilt_deg: [f64; 2],
}

impl Drawn {
    fn new(seed: u32, number: u32) -> Self {
        let mut random = PixelRandom::new(seed, number);
        let mut between = |low: f64, high: f64| low + (high - low) * random.uniform();
        let diameter_mm = between(4.0, 14.0);
        // The phantom is 25 mm high; a tenth of the radius stays free above the lump.
        let deepest = (25.0 - 1.05 * diameter_mm).min(11.0);
        let top_mm = between(2.0, deepest);
        let lump_kpa = between(20f64.ln(), 150f64.ln()).exp();
        let body_kpa = between(3f64.ln(), 10f64.ln()).exp();
        let last = between(0.5, 5.0);
        let mut depths_mm = vec![0.5, 0.5 * (0.5 + last), last];
        depths_mm.dedup_by(|a, b| *a - *b < 1e-3);
        let (off_axis_mm, angle) = (between(0.0, 8.0), between(0.0, std::f64::consts::TAU));
        let center_mm = [off_axis_mm * angle.cos(), off_axis_mm * angle.sin()];
        let (tilt_deg, angle) = (between(0.0, 2.0), between(0.0, std::f64::consts::TAU));
        let tilt_deg = [tilt_deg * angle.cos(), tilt_deg * angle.sin()];
        Self { diameter_mm, top_mm, lump_kpa, body_kpa, depths_mm, center_mm, tilt_deg }
    }

    fn scene(&self, arguments: &Arguments) -> Result<LoadedScene> {
        let mut loaded = preset("phantom-size-8mm").context("the preset is missing")?;
        let elastic = |youngs_kpa: f64| Elastic::NeoHookean { youngs_kpa, poisson: 0.4999, relaxation: Vec::new() };
        let phantom = loaded.scene.phantom.as_mut().context("a phantom")?;
        phantom.material = elastic(self.body_kpa);
        let lump = phantom.inclusion.first_mut().context("an inclusion")?;
        lump.shape = InclusionBody::Sphere { diameter_mm: self.diameter_mm };
        (lump.depth_mm, lump.material) = (self.top_mm, elastic(self.lump_kpa));
        if arguments.solid {
            lump.center_mm = self.center_mm;
        }
        let press = loaded.scene.press.as_mut().context("a press")?;
        press.depths_mm = Some(self.depths_mm.clone());
        match arguments.friction {
            None => {}
            Some(0.0) => press.interface = Interface::Frictionless,
            Some(friction) => press.interface = Interface::Coulomb { friction },
        }
        if arguments.solid {
            press.tilt_deg = self.tilt_deg;
        }
        (press.edge_radius_mm, press.resolution) = (arguments.edge_mm.or(press.edge_radius_mm), arguments.resolution);
        Ok(loaded)
    }

    fn words(&self) -> String {
        let Self { diameter_mm, top_mm, lump_kpa, body_kpa, depths_mm, center_mm, tilt_deg } = self;
        format!(
            "{diameter_mm:.3} mm of {lump_kpa:.2} kPa, {top_mm:.3} mm deep in {body_kpa:.3} kPa, to {depths_mm:.3?}, \
             off the axis by {center_mm:.3?} and tilted by {tilt_deg:.2?} degrees if solid"
        )
    }
}

/// Meshes the phantoms, and prints how good the elements are.
fn meshes(arguments: &Arguments) -> Result<()> {
    let (mut fitted, mut failed, mut shapes) = (0, 0, Vec::new());
    for number in arguments.first..arguments.first + arguments.phantoms {
        let drawn = Drawn::new(arguments.seed, number);
        let body = press_setup(&drawn.scene(arguments)?)?.body();
        match if arguments.solid { body.build_3d() } else { body.build_2d() } {
            Ok(mesh) => {
                fitted += u32::from(arguments.solid && !body.boxed()?);
                shapes.push(mesh.quality().least_scaled_jacobian);
            }
            Err(error) => {
                failed += 1;
                println!("{number}: {}: {error}", drawn.words());
            }
        }
    }
    shapes.sort_by(f64::total_cmp);
    let (least, median) = (shapes.first().copied(), shapes.get(shapes.len() / 2).copied());
    let (least, median) = (least.unwrap_or(f64::NAN), median.unwrap_or(f64::NAN));
    println!(
        "{failed} of {} not meshed, {fitted} fitted; least scaled Jacobian {least:.3}, median {median:.3}",
        arguments.phantoms
    );
    Ok(())
}

/// Presses each phantom to the same depths, alone and from the one before it, and prints how far the two are apart.
fn near(arguments: &Arguments) -> Result<()> {
    let settings = PressSettings::default();
    let mut before: Option<Pressed> = None;
    let (mut shares, mut seconds, mut iterations, mut apart) = (Vec::new(), [0.0; 2], [0; 2], Vec::new());
    for number in arguments.first..arguments.first + arguments.phantoms {
        let drawn = Drawn { depths_mm: NEAR_DEPTHS_MM.to_vec(), ..Drawn::new(arguments.seed, number) };
        let setup = press_setup(&drawn.scene(arguments)?)?;
        let led = PressSettings { estimate_error: arguments.estimated, ..settings };
        let from = before.as_ref().filter(|_| !arguments.estimated);
        let (Ok(alone), Ok(near)) =
            (press(&setup, settings, &mut |_| true), press_near(&setup, from, led, &mut |_| true))
        else {
            println!("{number}: {}: a press failed", drawn.words());
            continue;
        };
        if before.is_some() {
            shares.push(near.iterations as f64 / alone.iterations as f64);
            iterations = [iterations[0] + alone.iterations, iterations[1] + near.iterations];
            (seconds[0], seconds[1]) = (seconds[0] + alone.seconds, seconds[1] + near.seconds);
            let forces = alone.steps.iter().zip(&near.steps).map(|(a, b)| (b.force_n / a.force_n - 1.0).abs());
            let off = forces.fold(0.0, f64::max);
            apart.push(off);
            if arguments.all || off > 1e-6 {
                let [alone, near] = [alone.iterations, near.iterations];
                println!(
                    "{number}: {alone} iterations alone, {near} near, forces apart by {off:.1e}: {}",
                    drawn.words()
                );
            }
        }
        before = Some(near);
    }
    shares.sort_by(f64::total_cmp);
    apart.sort_by(f64::total_cmp);
    let at = |of: &[f64], share: f64| of.get((share * (of.len() as f64 - 1.0)) as usize).copied().unwrap_or(f64::NAN);
    println!(
        "{} phantoms, seconds {:.1} alone and {:.1} near, iterations {} and {}; near over alone: median {:.2}, 95 % {:.2}, most {:.2}; \
         forces apart: median {:.1e}, 95 % {:.1e}, most {:.1e}",
        shares.len(),
        seconds[0],
        seconds[1],
        iterations[0],
        iterations[1],
        at(&shares, 0.5),
        at(&shares, 0.95),
        at(&shares, 1.0),
        at(&apart, 0.5),
        at(&apart, 0.95),
        at(&apart, 1.0)
    );
    Ok(())
}

/// Depths that neighbours are pressed to, mm.
const NEAR_DEPTHS_MM: [f64; 3] = [1.0, 2.0, 4.0];

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    if arguments.mesh {
        return meshes(&arguments);
    }
    if arguments.near {
        return near(&arguments);
    }
    let (mut failed, mut seconds) = (0, Vec::new());
    for number in arguments.first..arguments.first + arguments.phantoms {
        let drawn = Drawn::new(arguments.seed, number);
        let setup = press_setup(&drawn.scene(&arguments)?)?;
        for (which, setup) in [("phantom", setup.clone()), ("baseline", setup.without_inclusions())] {
            let start = Instant::now();
            let outcome = press(&setup, PressSettings::default(), &mut |_| true);
            let took = start.elapsed().as_secs_f64();
            seconds.push(took);
            match outcome {
                Ok(pressed) if arguments.all => {
                    let pressed = &pressed;
                    let forces: Vec<f64> = pressed.steps.iter().map(|step| step.force_n).collect();
                    let Pressed { unknowns, iterations, cycles, .. } = *pressed;
                    println!(
                        "{number} {which} {took:.2} s, {unknowns} unknowns, {iterations} iterations, {cycles} cycles, \
                         {forces:.6?} N"
                    );
                }
                Ok(_) => {}
                Err(PressError::Stopped { cause, reached }) => {
                    failed += 1;
                    let reached = reached.steps.len();
                    println!("{number} {which} {took:.2} s, {} loads: {}: {cause}", reached, drawn.words());
                }
                Err(error) => {
                    failed += 1;
                    println!("{number} {which}: {}: {error}", drawn.words());
                }
            }
        }
    }
    seconds.sort_by(f64::total_cmp);
    let at = |share: f64| seconds.get((share * (seconds.len() - 1) as f64) as usize).copied().unwrap_or(f64::NAN);
    println!(
        "{failed} of {} presses failed; median {:.2} s, 95 % {:.2} s, most {:.2} s",
        seconds.len(),
        at(0.5),
        at(0.95),
        at(1.0)
    );
    Ok(())
}
