//! Does the estimated error of presses whose tissue relaxes hold what they are off?
//!
//!     cargo run --release --example relaxing -- [--cases 100] [--seed 1] [--resolution 0.5] [--of-time]
//!
//! Draws phantoms, laws, terms of relaxation, rates and holds at random, presses each by 1, 2 and 4 mm, tied to a rigid
//! sensor, and again on elements of half the size by four times as many steps in time; with `--of-time` on the same
//! elements, which the estimate then has to hold too. Prints how often the estimate of the force's error holds the
//! difference, and medians of both.

use anyhow::{Context as _, Result};
use clap::Parser;
use std::path::Path;
use tirtouch::camera::noise::PixelRandom;
use tirtouch::mechanics::from_scene::press_setup;
use tirtouch::mechanics::press::{PressSettings, Setup, press};
use tirtouch::scene::preset;
use tirtouch::vary::{Set, with};

#[derive(Parser)]
struct Arguments {
    /// How many presses are drawn.
    #[arg(long, default_value_t = 100)]
    cases: u32,
    /// Seed of the draws.
    #[arg(long, default_value_t = 1)]
    seed: u32,
    /// `press.resolution`.
    #[arg(long, default_value_t = 0.5)]
    resolution: f64,
    /// Refine in time alone.
    #[arg(long)]
    of_time: bool,
}

fn draw(random: &mut PixelRandom, low: f64, high: f64) -> f64 {
    low * (high / low).powf(random.uniform())
}

fn case(arguments: &Arguments, number: u32) -> Result<(String, Setup)> {
    let mut random = PixelRandom::new(arguments.seed, number);
    let terms = |random: &mut PixelRandom| {
        let [share, other] = [0.1 + 0.4 * random.uniform(), 0.3 * random.uniform()];
        let [time_s, later_s] = [draw(random, 0.05, 5.0), draw(random, 5.0, 100.0)];
        format!("[{{ share = {share}, time_s = {time_s} }}, {{ share = {other}, time_s = {later_s} }}]")
    };
    let (relaxation, youngs) = (terms(&mut random), draw(&mut random, 3.0, 10.0));
    let law = match random.uniform() {
        which if which < 0.5 => format!("law = \"neo_hookean\", youngs_kpa = {youngs}"),
        _ => format!("law = \"exponential\", modulus_kpa = {youngs}, exponent = {}", draw(&mut random, 2.0, 15.0)),
    };
    let [rate, hold_s] = [draw(&mut random, 0.1, 10.0), draw(&mut random, 0.1, 30.0)];
    let hold_s = if random.uniform() < 0.3 { 0.0 } else { hold_s };
    let [size, depth, ball] =
        [draw(&mut random, 4.0, 10.0), draw(&mut random, 3.0, 9.0), draw(&mut random, 20.0, 150.0)];
    let sets = [
        format!("phantom.material={{ {law}, relaxation = {relaxation} }}"),
        format!("phantom.inclusion[0].shape.diameter_mm={size}"),
        format!("phantom.inclusion[0].depth_mm={depth}"),
        format!("phantom.inclusion[0].material.youngs_kpa={ball}"),
        format!("press.rate_mm_per_s={rate}"),
        format!("press.hold_s={hold_s}"),
        format!("press.resolution={}", arguments.resolution),
        "press.sensor=rigid".into(),
    ];
    let sets: Vec<Set> =
        sets.iter().map(|set| set.parse()).collect::<Result<_, String>>().map_err(anyhow::Error::msg)?;
    let base = preset("phantom-size-8mm").context("no such preset")?;
    let loaded = with(base, Path::new("relaxing.toml"), &sets)?;
    Ok((format!("{law}, {relaxation}, {rate:.2} mm/s, held {hold_s:.1} s"), press_setup(&loaded)?))
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let (mut held, mut off, mut said, mut failed) = (0, Vec::new(), Vec::new(), 0);
    for number in 0..arguments.cases {
        let (what, setup) = case(&arguments, number)?;
        let settings = PressSettings { estimate_error: true, ..PressSettings::default() };
        let mut fine = Setup { time_steps: 4 * setup.time_steps, ..setup.clone() };
        if !arguments.of_time {
            fine.phantom.resolution = fine.phantom.resolution.doubled();
        }
        let pressed = press(&setup, settings, &mut |_| true);
        let (Ok(pressed), Ok(fine)) = (pressed, press(&fine, PressSettings::default(), &mut |_| true)) else {
            failed += 1;
            println!("{number}: not reached: {what}");
            continue;
        };
        for (step, fine) in pressed.steps.iter().zip(&fine.steps) {
            let error = step.error.context("no estimate")?.force;
            let difference = (step.force_n / fine.force_n - 1.0).abs();
            held += u32::from(error >= difference);
            if error < difference {
                println!("{number}, {} mm: off by {difference:.2e}, said {error:.2e}: {what}", step.depth_mm);
            }
            off.push(difference);
            said.push(error);
        }
    }
    let largest = off.iter().copied().fold(0.0, f64::max);
    println!(
        "{held} of {} loads held, {failed} not reached; off by {:.2e} (median; most {largest:.2e}), said {:.2e}",
        off.len(),
        median(&mut off),
        median(&mut said)
    );
    Ok(())
}
