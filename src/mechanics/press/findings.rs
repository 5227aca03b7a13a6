//! What a press found, apart from its mesh: for other programs that press the same.

use super::{Assembly, ContactPoint, PressStep, Pressed, Setup};
use crate::mechanics::newton::LinearSolver;
use crate::mechanics::problem::State;
use serde::{Deserialize, Serialize};

/// What a press found, to be written and read again; its mesh is made anew of its description.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Findings {
    steps: Vec<PressStep>,
    iterations: usize,
    cycles: usize,
    seconds: f64,
    error_seconds: f64,
    unestimated: Option<String>,
    method: LinearSolver,
    factor_mib: f64,
}

impl Pressed {
    /// What it found.
    pub fn findings(&self) -> Findings {
        Findings {
            steps: self.steps.clone(),
            iterations: self.iterations,
            cycles: self.cycles,
            seconds: self.seconds,
            error_seconds: self.error_seconds,
            unestimated: self.unestimated.clone(),
            method: self.method,
            factor_mib: self.factor_mib,
        }
    }

    /// The press of a description that found this; none where it cannot be that press's.
    pub fn of_findings(setup: &Setup, findings: Findings) -> Option<Self> {
        let assembly = Assembly::new(setup).ok()?;
        let sizes = |state: &State| {
            let touched: Vec<usize> = state.traction.iter().map(Vec::len).collect();
            let remembered: Vec<usize> = state.history.iter().map(Vec::len).collect();
            (state.displacement.len(), state.pressure.len(), touched, remembered)
        };
        let own = sizes(&assembly.problem.start());
        let is_node = |point: &ContactPoint| (point.node as usize) < own.0;
        let suits = |step: &PressStep| sizes(&step.state) == own && step.points.iter().all(is_node);
        if findings.steps.is_empty() || !findings.steps.iter().all(suits) {
            return None;
        }
        Some(Self {
            setup: setup.clone(),
            unknowns: assembly.problem.unknowns(),
            assembly,
            steps: findings.steps,
            iterations: findings.iterations,
            cycles: findings.cycles,
            seconds: findings.seconds,
            error_seconds: findings.error_seconds,
            unestimated: findings.unestimated,
            method: findings.method,
            factor_mib: findings.factor_mib,
        })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::mechanics::from_scene::press_setup;
    use crate::mechanics::press::{PressSettings, press};

    #[test]
    fn a_press_is_the_same_to_the_bit_after_it_was_written() {
        let mut loaded = crate::scene::preset("phantom-size-8mm").unwrap();
        let asked = loaded.scene.press.as_mut().unwrap();
        (asked.depths_mm, asked.resolution) = (Some(vec![0.3, 0.6]), 0.5);
        let setup = press_setup(&loaded).unwrap();
        let pressed = press(&setup, PressSettings::default(), &mut |_| true).unwrap();
        let text = serde_json::to_string(&pressed.findings()).unwrap();
        let again = Pressed::of_findings(&setup, serde_json::from_str(&text).unwrap()).unwrap();
        assert_eq!(format!("{:?}", again.steps), format!("{:?}", pressed.steps));
        assert_eq!(again.unknowns, pressed.unknowns);
        // Of another mesh it is none.
        let other = setup.halved();
        assert!(Pressed::of_findings(&other, pressed.findings()).is_none());
        let mut short = pressed.findings();
        short.steps[0].state.pressure.pop();
        assert!(Pressed::of_findings(&setup, short).is_none());
    }
}
