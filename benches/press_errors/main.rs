//! Do the errors that a press estimates of itself hold?
//!
//!     cargo run --release --example press_errors -- [--cases 48] [--first 0] [--seed 2] [--solid]
//!
//! Draws presses (`cases.rs`) and compares what each says of its error with the error against a mesh 2 to 4 times as
//! fine, as unknowns allow. Where the contact's edge is tied, and so of first order, what such a mesh leaves itself is
//! added: a mesh n times as fine shows (n - 1) / n of the error of the force. Flat punches on layers are also compared
//! with the sharp punch's closed form (`tests/mechanics/layers.rs`); there the estimate is that of the mesh and that of
//! the rounding together. Prints a row for each, then the share that holds and the median of estimated over true, for
//! other factors of safety too. Takes a quarter of an hour on two cores, most of it for presses that rub.
//!
//! With `--solid` presses are in three dimensions, on coarse meshes, against ones twice as fine.

#[path = "../../tests/mechanics/layers.rs"]
#[allow(clippy::unwrap_used, dead_code)]
mod layers;

mod cases;

use anyhow::{Context as _, Result};
use cases::Case;
use clap::Parser;
use tirtouch::mechanics::contact::Grip;
use tirtouch::mechanics::kinematics::Kinematics;
use tirtouch::mechanics::press::error_estimate::{SAFETY, difference};
use tirtouch::mechanics::press::{Face, PressSettings, PressStep, Pressed, Setup, press};

#[derive(Parser)]
struct Arguments {
    /// Presses.
    #[arg(long, default_value_t = 48)]
    cases: u32,
    /// First of them.
    #[arg(long, default_value_t = 0)]
    first: u32,
    /// Seed of the draws; the estimates' rule was chosen on 1.
    #[arg(long, default_value_t = 2)]
    seed: u32,
    /// Presses in three dimensions.
    #[arg(long)]
    solid: bool,
}

/// Estimates beside what they estimate: shares of the force, of the pressure and, but against the closed form, of its
/// peak.
struct Row {
    group: &'static str,
    truth: Vec<f64>,
    estimate: Vec<f64>,
}

/// What is estimated.
const FIGURES: [&str; 3] = ["force", "pressure", "peak"];

/// Most unknowns of a reference, where that leaves more than twice the divisions.
const MOST_UNKNOWNS: f64 = 62_000.0;
const MOST_TIMES: usize = 4;
/// How many times as fine a reference in three dimensions is.
const SOLID_TIMES: f64 = 2.0;

/// Factors of safety whose outcome is printed.
const FACTORS: [f64; 5] = [1.0, 1.25, 1.5, 2.0, 3.0];

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let mut rows = Vec::new();
    for number in arguments.first..arguments.first + arguments.cases {
        let case = if arguments.solid { Case::solid } else { Case::new }(arguments.seed, number)?;
        match judge(&case) {
            Ok(found) => {
                for row in found {
                    println!("{number:3} {:22} {}: {}", row.group, case.words, row.words());
                    rows.push(row);
                }
            }
            Err(error) => println!("{number:3} {}: not told: {error:#}", case.words),
        }
    }
    summary(&rows);
    Ok(())
}

fn judge(case: &Case) -> Result<Vec<Row>> {
    let pressed = pressed(&case.setup, true)?;
    let mut finer = case.setup.clone();
    let times = if finer.kinematics == Kinematics::ThreeDimensional {
        finer.phantom.resolution = finer.phantom.resolution.finer(SOLID_TIMES);
        SOLID_TIMES
    } else {
        let times = ((MOST_UNKNOWNS / pressed.unknowns as f64).sqrt() as usize).clamp(2, MOST_TIMES);
        finer.phantom.resolution.subdivision *= times;
        times as f64
    };
    let reference = self::pressed(&finer, false)?;
    let (step, truth) = (last(&pressed)?, last(&reference)?);
    let error = step.error.context("no estimate")?;
    let tied = case.setup.grip == Grip::Bonded;
    let hidden = if tied { 1.0 / (times - 1.0) } else { 0.0 };
    let force_n = truth.force_n + hidden * (truth.force_n - step.force_n);
    let group = match (tied, case.punch) {
        (true, _) => "tied",
        (false, None) => "sliding",
        (false, Some(_)) => "punch",
    };
    let off = |true_one: f64, own: f64| (true_one / own - 1.0).abs();
    let own = Face::of(&pressed, step);
    let against = |force_n: f64, face: &Face| vec![off(force_n, step.force_n), difference(&own, face)];
    let mut truths = against(force_n, &Face::of(&reference, truth));
    truths.push(off(truth.peak_pressure_kpa, step.peak_pressure_kpa));
    let peak = error.peak.context("no estimate of the peak")?;
    let mut rows = vec![Row { group, truth: truths, estimate: vec![error.force, error.rms, peak] }];
    if let Some([a_over_h, poisson]) = case.punch {
        let sharp = layers::Punched::on(&layers::one(a_over_h, poisson));
        let rounding = error.rounding.context("no estimate of the rounding")?;
        let estimate = vec![error.force + rounding.force, error.rms + rounding.rms];
        let exact = Face::along(&pressed.setup, sharp.face());
        rows.push(Row { group: "punch, closed form", truth: against(sharp.force_n(), &exact), estimate });
    }
    Ok(rows)
}

fn pressed(setup: &Setup, estimate_error: bool) -> Result<Pressed> {
    Ok(press(setup, PressSettings { estimate_error, ..PressSettings::default() }, &mut |_| true)?)
}

fn last(pressed: &Pressed) -> Result<&PressStep> {
    pressed.steps.last().context("no depth was reached")
}

impl Row {
    fn words(&self) -> String {
        let part = |(k, name): (usize, &&str)| {
            let (truth, estimate) = (self.truth.get(k)?, self.estimate.get(k)?);
            let holds = if truth <= estimate { "holds" } else { "FAILS" };
            Some(format!("{name} {:.4} %, estimated {:.4} %, {holds}", 100.0 * truth, 100.0 * estimate))
        };
        FIGURES.iter().enumerate().filter_map(part).collect::<Vec<_>>().join("; ")
    }
}

fn summary(rows: &[Row]) {
    let heads: Vec<String> = FIGURES.iter().map(|name| format!("{name} holds | median")).collect();
    println!("\n| cases | factor | {} |\n|---|---|{}", heads.join(" | "), "---|---|".repeat(FIGURES.len()));
    for group in ["tied", "sliding", "punch", "punch, closed form", "all"] {
        let of_group: Vec<&Row> = rows.iter().filter(|row| group == "all" || row.group == group).collect();
        let factors = if group == "all" { &FACTORS[..] } else { &[SAFETY] };
        for factor in factors.iter().filter(|_| !of_group.is_empty()) {
            let part = |k: usize| {
                let ratio = |row: &&Row| Some(factor / SAFETY * row.estimate.get(k)? / row.truth.get(k)?);
                let mut ratios: Vec<f64> = of_group.iter().filter_map(ratio).collect();
                if ratios.is_empty() {
                    return "- | -".to_owned();
                }
                ratios.sort_by(f64::total_cmp);
                let hold = ratios.iter().filter(|&&ratio| ratio >= 1.0).count();
                let share = 100.0 * hold as f64 / ratios.len() as f64;
                format!("{hold} of {} ({share:.0} %) | {:.2}", ratios.len(), ratios[ratios.len() / 2])
            };
            let parts: Vec<String> = (0..FIGURES.len()).map(part).collect();
            println!("| {group} | {factor} | {} |", parts.join(" | "));
        }
    }
}
