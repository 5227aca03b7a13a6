//! Error against run time of the press's mechanics on problems with a known answer.
//!
//!     cargo run --release --example mechanics_ladder [-- SECONDS]
//!
//! Prints the tables of docs/decisions/mechanics-ladders.md. Rung n divides all elements of the first into n along each
//! axis. A ladder ends with the first rung that takes longer than SECONDS (1 if not given). Takes about 2 minutes, and
//! the shipped phantoms at the end some more: they climb all rungs whatever the time.

#![allow(clippy::unwrap_used)]

#[path = "../tests/mechanics/answers/mod.rs"]
mod answers;

#[path = "mechanics_ladder/phantom.rs"]
mod phantom;

use answers::{Answer, cook, eshelby, hayes, hertz, press, sphere};
use tirtouch::mechanics::kinematics::Kinematics;

/// A problem on one rung.
type Solve = Box<dyn Fn(usize) -> Answer>;

fn main() {
    let longest = std::env::args().nth(1).and_then(|argument| argument.parse().ok()).unwrap_or(1.0);
    let mut ladders: Vec<(String, Solve)> = vec![
        ("Cook's membrane".into(), Box::new(cook::solve)),
        ("Thick sphere, linear, nu = 0.5".into(), Box::new(|n| sphere::linear(n, Kinematics::Axisymmetric))),
        ("Thick sphere inflated to twice its hollow, neo-Hookean, nu = 0.5".into(), Box::new(sphere::inflated)),
        ("Eshelby's sphere, k = 20, nu = 0.5".into(), Box::new(|n| eshelby::strain(n, 20.0))),
    ];
    for poisson in [0.3, 0.5] {
        ladders.push((format!("Flat punch on a half space, nu = {poisson}"), {
            Box::new(move |n| hayes::half_space(n, poisson))
        }));
        ladders.push((format!("Uniform pressure on a disc, nu = {poisson}"), {
            Box::new(move |n| hayes::disc_pressure(n, poisson))
        }));
        ladders.push((format!("Hertz, ball, nu = {poisson}"), Box::new(move |n| hertz::ball(n, poisson))));
        ladders.push((format!("Hertz, cylinder, nu = {poisson}"), Box::new(move |n| hertz::cylinder(n, poisson))));
    }
    for [a_over_h, compressible, incompressible] in hayes::KAPPA {
        for (poisson, exact) in [(0.45, compressible), (0.5, incompressible)] {
            let name = format!("Hayes, a/h = {a_over_h}, nu = {poisson}");
            ladders.push((name, Box::new(move |n| hayes::kappa(n, a_over_h, poisson, exact))));
        }
    }
    for (name, inclusion) in [("Tied press", false), ("Tied press, 8 mm inclusion", true)] {
        ladders.push((name.into(), Box::new(move |n| press::tied(n, inclusion))));
    }
    for (name, solve) in ladders {
        table(&name, longest, &solve);
    }
    for inclusion in [false, true] {
        phantom::table(inclusion);
    }
}

fn table(name: &str, longest: f64, solve: &Solve) {
    println!("\n## {name}\n");
    for rung in [1, 2, 4, 8] {
        let answer = solve(rung);
        if rung == 1 {
            let heads: Vec<String> =
                answer.figures.iter().map(|figure| format!(" {} | error |", figure.name)).collect();
            println!("| rung | unknowns | iterations | seconds |{}", heads.concat());
            println!("|---|---|---|---|{}", "---|---|".repeat(heads.len()));
        }
        let cells: Vec<String> =
            answer.figures.iter().map(|figure| format!(" {:.6} | {:+.2e} |", figure.value, figure.error())).collect();
        let Answer { unknowns, iterations, seconds, .. } = answer;
        println!("| {rung} | {unknowns} | {iterations} | {seconds:.3} |{}", cells.concat());
        if seconds > longest {
            break;
        }
    }
}
