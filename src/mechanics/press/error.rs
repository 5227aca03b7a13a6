//! Why a press did not come to its end, and what may help.

use super::{AssemblyError, Load, Pressed, SensorBody, Setup};
use crate::mechanics::material::MaterialError;
use crate::mechanics::memory;
use crate::mechanics::mesh::MeshError;
use crate::mechanics::path::PathError;
use crate::scene::DataFileError;
use thiserror::Error;

/// Why a press did not come to its end.
#[derive(Debug, Error)]
pub enum PressError {
    /// The scene has no press.
    #[error("the scene has no [press]")]
    NoPress,
    /// What cannot be computed, and what can.
    #[error("{0}")]
    Unsupported(String),
    /// More than there is memory for.
    #[error(
        "the press of {unknowns} unknowns takes about {memory_gib:.1} GiB, the limit is {limit_gib:.1} GiB ({}): {}",
        memory::VARIABLE,
        match fits {
            Some(share) => format!("press.resolution times {share} fits"),
            None => "a quarter of press.resolution is still too much".to_owned(),
        }
    )]
    TooLarge {
        /// Displacement unknowns.
        unknowns: usize,
        /// What it takes, GiB.
        memory_gib: f64,
        /// What it may take, GiB.
        limit_gib: f64,
        /// Share of the resolution that would fit.
        fits: Option<f64>,
    },
    /// The geometry.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A material.
    #[error(transparent)]
    Material(#[from] MaterialError),
    /// A file that the scene names.
    #[error(transparent)]
    File(#[from] DataFileError),
    /// A load was not reached; the steps before it are kept.
    #[error("{}", stopped(cause, reached))]
    Stopped {
        /// Why.
        cause: PathError,
        /// What was reached.
        reached: Box<Pressed>,
    },
}

impl From<AssemblyError> for PressError {
    fn from(error: AssemblyError) -> Self {
        match error {
            AssemblyError::Unsupported(what) => Self::Unsupported(what),
            AssemblyError::Mesh(error) => Self::Mesh(error),
            AssemblyError::Material(error) => Self::Material(error),
        }
    }
}

/// Which press stopped where, why, and what may help.
fn stopped(cause: &PathError, reached: &Pressed) -> String {
    let setup = &reached.setup;
    let which = if setup.is_baseline() { "the phantom without its inclusions" } else { "the phantom" };
    match cause {
        PathError::Stuck { reached, target, cause } => {
            let help = if cause.is_too_large() { "a smaller press.resolution" } else { help(setup) };
            let way = if matches!(setup.load, Load::Path(_)) { " of its way" } else { "" };
            format!("the press of {which} stops at {reached:.3} of {target} mm{way}: {cause}; {help} may help")
        }
        PathError::Hold { load, cause } => {
            let way = if matches!(setup.load, Load::Path(_)) { " of its way" } else { "" };
            format!("the press of {which}, held at {load:.3} mm{way}, does not settle: {cause}")
        }
        PathError::NoForce { .. } | PathError::Stopped => format!("the press of {which}: {cause}"),
    }
}

fn help(setup: &Setup) -> &'static str {
    match setup.sensor {
        SensorBody::Layers { edge_radius_mm: 0.0, .. } => "a rounder rim (press.edge_radius_mm) or a smaller load",
        _ => "a smaller load or another press.resolution",
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::mechanics::from_scene::press_setup;
    use crate::mechanics::newton::StepError;
    use crate::mechanics::press::{PressSettings, press};
    use crate::mechanics::sparse::SparseError;
    use crate::scene::preset;

    #[test]
    fn a_press_that_stops_says_which_where_and_what_may_help() {
        let stopped = |without_inclusions: bool, edge_radius_mm: f64, cause: StepError| {
            let mut loaded = preset("phantom-size-8mm").unwrap();
            let scene_press = loaded.scene.press.as_mut().unwrap();
            (scene_press.depths_mm, scene_press.resolution) = (Some(vec![0.1]), 0.25);
            scene_press.edge_radius_mm = Some(edge_radius_mm);
            let setup = press_setup(&loaded).unwrap();
            let setup = if without_inclusions { setup.without_inclusions() } else { setup };
            let reached = Box::new(press(&setup, PressSettings::default(), &mut |_| true).unwrap());
            let cause = PathError::Stuck { reached: 3.4137, target: 3.8, cause };
            PressError::Stopped { cause, reached }.to_string()
        };
        assert_eq!(
            stopped(false, 0.5, StepError::InsideOut),
            "the press of the phantom stops at 3.414 of 3.8 mm: an element turns inside out; a smaller load or another \
             press.resolution may help"
        );
        assert_eq!(
            stopped(true, 0.0, StepError::InsideOut),
            "the press of the phantom without its inclusions stops at 3.414 of 3.8 mm: an element turns inside out; a \
             rounder rim (press.edge_radius_mm) or a smaller load may help"
        );
        let said = stopped(false, 0.5, StepError::Sparse(SparseError::TooLarge));
        assert!(said.ends_with("; a smaller press.resolution may help"), "{said}");
    }
}
