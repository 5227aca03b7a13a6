//! The shipped phantom at 4 mm against its own finest mesh, beside the error that each rung estimates for itself.

use super::answers::phantom::{errors, setup};
use tirtouch::mechanics::press::{PressError, PressSettings, Pressed, press};

/// Rungs, and the one that stands for the truth.
const RUNGS: [usize; 4] = [1, 2, 3, 4];
const TRUTH: usize = 6;

pub fn table(inclusion: bool) {
    println!("\n## Shipped phantom{}, 4 mm\n", if inclusion { ", 8 mm inclusion" } else { "" });
    let truth = match run(inclusion, TRUTH, false) {
        Ok(truth) => truth,
        Err(error) => return println!("rung {TRUTH}: {error}"),
    };
    println!("| rung | unknowns | iterations | seconds | force, N | error | estimated | pressure, rms | estimated |");
    println!("|---|---|---|---|---|---|---|---|---|");
    for rung in RUNGS {
        match run(inclusion, rung, true) {
            Ok(pressed) => row(rung, &pressed, &truth),
            Err(PressError::Stopped { cause, reached }) => {
                println!(
                    "| {rung} | {} | {} | {:.2} | {cause} |",
                    reached.unknowns, reached.iterations, reached.seconds
                );
            }
            Err(error) => println!("| {rung} | {error} |"),
        }
    }
    let force = truth.steps.last().map_or(0.0, |step| step.force_n);
    println!("| {TRUTH} | {} | {} | {:.2} | {force:.6} | | | | |", truth.unknowns, truth.iterations, truth.seconds);
}

fn run(inclusion: bool, subdivision: usize, estimate_error: bool) -> Result<Pressed, PressError> {
    press(&setup(inclusion, subdivision), PressSettings { estimate_error, ..PressSettings::default() }, &mut |_| true)
}

fn row(rung: usize, pressed: &Pressed, truth: &Pressed) {
    let Pressed { unknowns, iterations, seconds, .. } = pressed;
    let Some((step, [rms, force])) = pressed.steps.last().zip(errors(pressed, truth)) else { return };
    let estimated = step.error.map_or([f64::NAN; 2], |error| [error.force, error.rms]);
    println!(
        "| {rung} | {unknowns} | {iterations} | {seconds:.2} | {:.6} | {force:+.2e} | {:.2e} | {rms:.2e} | {:.2e} |",
        step.force_n, estimated[0], estimated[1]
    );
}
