//! Ladders of the press: meshes and orders of elements against a finer mesh, load steps against more of them.

use super::{ErrorEstimate, Rung};
use crate::mechanics::element::PressureOrder;
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::path::PathError;
use crate::mechanics::press::error_estimate::{NOTHING, difference};
use crate::mechanics::press::{Face, Load, PressError, PressSettings, Setup, press};
use crate::progress::Observer;
use serde::{Deserialize, Serialize};

/// Order of what the singular edge of a contact spoils: the force, and the pressure that it sends inwards. An error of
/// the finest rung leaves 1/r of it in a reference that is `r` times as fine (docs/PHYSICS.md, error of the pressure).
const EDGE_ORDER: f64 = 1.0;
/// Names of the two errors.
const QUANTITIES: [(&str, &str); 2] = [("force", "force"), ("pressure", "pressure, rms over 0.8 of the footprint")];

/// The family of meshes.
pub const MESH: &str = "mesh";
/// Rungs of lower order beside those of `MESH`.
const ORDER: &str = "element order";
const LOADS: &str = "load steps";

/// One press of the ladders, or a reference.
#[derive(Debug, Clone)]
pub struct Choice {
    /// The ladder.
    pub family: &'static str,
    /// In words.
    pub setting: String,
    /// Divisions of the mesh, or the number of loads.
    pub level: usize,
    /// What is pressed.
    pub setup: Setup,
    /// Whether a run without flags takes these.
    pub is_default: bool,
    /// Whether the rungs of its family are compared with it.
    pub is_reference: bool,
}

/// A press at one load.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reached {
    /// The load asked: depth in mm, or force in N.
    pub asked: f64,
    /// Force, N.
    pub force_n: f64,
    /// The touched face.
    pub face: Face,
}

/// What a press found, and how long it took.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// The loads that it reached.
    pub reached: Vec<Reached>,
    /// Why it did not reach all.
    pub stopped: Option<String>,
    /// Run time, s.
    pub seconds: f64,
    /// Displacement unknowns.
    pub unknowns: usize,
    /// Newton iterations.
    pub iterations: usize,
}

/// The rungs of a press and their references.
pub fn choices(setup: &Setup, quick: bool) -> Vec<Choice> {
    let default = setup.phantom.resolution.subdivision;
    // In three dimensions the default mesh takes minutes and gigabytes at twice its fineness.
    let (divisions, reference) = match (setup.kinematics, quick) {
        (Kinematics::ThreeDimensional, _) => (1..=default, 2 * default),
        (_, true) => (1..=2.max(default), 2 * 2.max(default)),
        (_, false) => (1..=3.max(default), 2 * 3.max(default)),
    };
    let mesh = |divisions: usize| {
        let mut setup = setup.clone();
        setup.phantom.resolution.subdivision = divisions;
        Choice {
            family: MESH,
            setting: format!("elements divided by {divisions}"),
            level: divisions,
            setup,
            is_default: divisions == default,
            is_reference: divisions == reference,
        }
    };
    let mut choices: Vec<Choice> = divisions.clone().chain([reference]).map(mesh).collect();
    choices.extend(divisions.map(mesh).map(|choice| Choice {
        family: ORDER,
        setup: Setup { pressure: PressureOrder::Constant, ..choice.setup },
        is_default: false,
        ..choice
    }));
    if let Load::Depths(depths) = &setup.load {
        let counts: &[usize] = if quick { &[1, 2, 4] } else { &[1, 2, 4, 8, 16] };
        let most = counts.last().copied();
        choices.extend(counts.iter().map(|&count| Choice {
            family: LOADS,
            setting: format!("{} loads", count * depths.len()),
            level: count * depths.len(),
            setup: Setup { load: Load::Depths(divided(depths, count)), ..setup.clone() },
            is_default: count == 1,
            is_reference: Some(count) == most,
        }));
    }
    choices
}

/// Each stretch between asked depths in `count` equal steps.
fn divided(depths: &[f64], count: usize) -> Vec<f64> {
    let starts = std::iter::once(&0.0).chain(depths);
    let between = |(&from, &to): (&f64, &f64)| (1..=count).map(move |k| from + (to - from) * k as f64 / count as f64);
    starts.zip(depths).flat_map(between).collect()
}

/// Presses once, without an estimate of the error. A press that stops early keeps the loads that it reached.
///
/// # Errors
/// As [`press`]; `Stopped` only where `observe` says so, since other loads that are not reached are told in what is
/// found.
pub fn run(setup: &Setup, observe: &mut Observer) -> Result<Found, PressError> {
    let (pressed, stopped) = match press(setup, PressSettings::default(), observe) {
        Ok(pressed) => (pressed, None),
        Err(error) => {
            let words = error.to_string();
            match error {
                PressError::Stopped { cause, reached } if cause != PathError::Stopped => (*reached, Some(words)),
                error => return Err(error),
            }
        }
    };
    let asked: Vec<f64> = match &setup.load {
        Load::Depths(asked) | Load::Forces(asked) => asked.clone(),
        Load::Path(poses) => (1..=poses.len()).map(|number| number as f64).collect(),
    };
    // Of a load that bears nothing, as after a lift, no share is known.
    let largest = pressed.steps.iter().map(|step| step.force_n.abs()).fold(0.0, f64::max);
    let reached = asked.iter().zip(&pressed.steps).filter(|(_, step)| step.force_n.abs() > NOTHING * largest);
    Ok(Found {
        reached: reached
            .map(|(&asked, step)| Reached { asked, force_n: step.force_n, face: Face::of(&pressed, step) })
            .collect(),
        stopped,
        seconds: pressed.seconds,
        unknowns: pressed.unknowns,
        iterations: pressed.iterations,
    })
}

impl Found {
    fn at(&self, asked: f64) -> Option<&Reached> {
        // Loads divided into steps come back to the asked ones but for rounding.
        self.reached.iter().find(|reached| (reached.asked - asked).abs() <= 1e-9 * asked.abs())
    }
}

/// The presses that a family compares, its reference among them.
fn members<'a>(all: &'a [(Choice, Found)], family: &str) -> Vec<&'a (Choice, Found)> {
    all.iter().filter(|(c, _)| c.family == family || (family == ORDER && c.family == MESH)).collect()
}

/// The highest load that all presses of a family reached: depth in mm, or force in N.
pub fn common_load(all: &[(Choice, Found)], family: &str) -> Option<f64> {
    let members = members(all, family);
    let mut loads = members.first()?.1.reached.iter().rev().map(|reached| reached.asked);
    loads.find(|&asked| members.iter().all(|(_, found)| found.at(asked).is_some()))
}

/// Differences to the reference as shares: of the force, and of the pressure.
fn differences(found: &Reached, reference: &Reached) -> [f64; 2] {
    [found.force_n / reference.force_n - 1.0, difference(&found.face, &reference.face)]
}

/// The rungs of force and pressure, at the highest load that all of a family reached. The reference of a mesh is off by
/// what the finest rung's error leaves of it; that of load steps is the same mesh, exact to the solver.
pub fn rungs(all: &[(Choice, Found)]) -> Vec<Rung> {
    let mut rungs = Vec::new();
    for family in [MESH, ORDER, LOADS] {
        let members = members(all, family);
        let Some((reference, exact)) = members.iter().find(|(choice, _)| choice.is_reference) else { continue };
        let Some(load) = common_load(all, family) else { continue };
        let Some(exact) = exact.at(load) else { continue };
        let measured: Vec<(&Choice, &Found, [f64; 2])> = members
            .iter()
            .filter(|(choice, _)| !choice.is_reference)
            .filter_map(|(choice, found)| Some((choice, found, differences(found.at(load)?, exact))))
            .collect();
        for (which, (quantity, series)) in QUANTITIES.into_iter().enumerate() {
            let alike = measured.iter().filter(|(choice, ..)| choice.setup.pressure == reference.setup.pressure);
            let left = match alike.max_by_key(|(choice, ..)| choice.level) {
                // d = e (1 - r^-q): the reference is off by e r^-q = d / (r^q - 1).
                Some((finest, _, differences)) if family != LOADS => {
                    let refined = reference.level as f64 / finest.level as f64;
                    differences[which].abs() / (refined.powf(EDGE_ORDER) - 1.0)
                }
                _ => 0.0,
            };
            rungs.extend(measured.iter().map(|(choice, found, differences)| Rung {
                family: family.into(),
                series: match (family, choice.setup.pressure) {
                    (ORDER, PressureOrder::Constant) => format!("{quantity}, constant pressures (Q2/P0)"),
                    (ORDER, PressureOrder::Linear) => format!("{quantity}, linear pressures (Q2/P-1)"),
                    _ => series.into(),
                },
                setting: match &found.stopped {
                    Some(why) => format!("{}; {why}", choice.setting),
                    None => choice.setting.clone(),
                },
                level: Some(if family == LOADS { choice.level as f64 } else { found.unknowns as f64 }),
                quantity: quantity.into(),
                error: ErrorEstimate::of_difference(differences[which], left),
                seconds: found.seconds,
                repeats: 1,
                is_default: choice.is_default,
            }));
        }
    }
    rungs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[allow(clippy::unwrap_used)]
    fn presses_are_compared_at_the_highest_load_that_all_reached() {
        let scene = crate::scene::preset("phantom-size-8mm").unwrap();
        let setup = crate::mechanics::from_scene::press_setup(&scene).unwrap();
        let face = Face::along(&setup, Vec::new());
        let found = |loads: &[f64]| Found {
            reached: loads.iter().map(|&asked| Reached { asked, force_n: asked, face: face.clone() }).collect(),
            stopped: None,
            seconds: 1.0,
            unknowns: 1,
            iterations: 1,
        };
        let choices: Vec<Choice> = choices(&setup, false).into_iter().filter(|c| c.family == MESH).collect();
        let loads: [&[f64]; 2] = [&[1.0, 2.0, 4.0], &[1.0, 2.0 + 1e-13]];
        let mut all: Vec<(Choice, Found)> = choices.into_iter().zip(loads.map(found)).collect();
        assert_eq!(common_load(&all, MESH), Some(2.0));
        all[1].1.reached.clear();
        assert_eq!(common_load(&all, MESH), None);
    }

    #[test]
    fn depths_are_divided_evenly() {
        assert_eq!(divided(&[1.0, 2.0, 4.0], 2), [0.5, 1.0, 1.5, 2.0, 3.0, 4.0]);
        assert_eq!(divided(&[1.0, 2.0], 1), [1.0, 2.0]);
    }
}
