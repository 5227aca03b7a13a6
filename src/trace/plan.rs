//! Which integrator finds the light of a scene, and why.

use super::error::TraceError;
use super::kernel::Kernel;
use super::modes::{CameraMode, PhotonMode};
use crate::scene::IntegratorChoice;

/// A light-transport method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Integrator {
    /// Camera paths followed until they meet an LED.
    Path,
    /// Photons connected to the pinhole at each diffuse vertex; camera paths for all other light.
    Splat,
    /// Photons fill an exitance map; camera paths read it at tissue and carry on to the LEDs by themselves elsewhere.
    Map,
}

impl Integrator {
    /// Name, as on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Path => "path",
            Self::Splat => "splat",
            Self::Map => "map",
        }
    }

    /// What its camera paths and its photons do.
    pub fn modes(self) -> (CameraMode, PhotonMode) {
        match self {
            Self::Path => (CameraMode::Path, PhotonMode::Ledger),
            Self::Splat => (CameraMode::Complement, PhotonMode::Splat),
            Self::Map => (CameraMode::Mapped, PhotonMode::Map),
        }
    }
}

impl From<Integrator> for IntegratorChoice {
    fn from(integrator: Integrator) -> Self {
        match integrator {
            Integrator::Path => Self::Path,
            Integrator::Splat => Self::Splat,
            Integrator::Map => Self::Map,
        }
    }
}

/// An integrator with the reason for it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plan {
    /// The integrator.
    pub integrator: Integrator,
    /// Why, in a sentence.
    pub why: &'static str,
}

impl Plan {
    /// Chooses the integrator for a scene, or checks that the one asked for suits it.
    ///
    /// # Errors
    /// `Unsuited`: `map` and `splat` where no tissue touches; `splat` where interfaces are deformed or rough, or the
    /// camera has a lens.
    pub fn choose(asked: IntegratorChoice, kernel: &Kernel) -> Result<Self, TraceError> {
        let plan = |integrator, why| Ok(Self { integrator, why });
        let unsuited = |why: &str| Err(TraceError::Unsuited(why.into()));
        match asked {
            IntegratorChoice::Path => plan(Integrator::Path, "asked for"),
            IntegratorChoice::Auto if !kernel.touched => {
                plan(Integrator::Path, "no tissue touches: there is no diffuse light to gather")
            }
            IntegratorChoice::Auto => plan(
                Integrator::Map,
                "tissue touches: photons gather its diffuse light, camera paths see it through the exact geometry",
            ),
            IntegratorChoice::Map | IntegratorChoice::Splat if !kernel.touched => {
                unsuited("the integrators map and splat need tissue in contact; this scene has none: use path")
            }
            IntegratorChoice::Map => plan(Integrator::Map, "asked for"),
            IntegratorChoice::Splat if kernel.deformed() => {
                unsuited("the integrator splat needs flat interfaces; this scene deforms them: use map or path")
            }
            IntegratorChoice::Splat if kernel.lens => {
                unsuited("the integrator splat needs a pinhole; this scene has a lens: use map or path")
            }
            IntegratorChoice::Splat if kernel.rough => {
                unsuited("the integrator splat needs smooth interfaces; this scene has rough ones: use map or path")
            }
            IntegratorChoice::Splat => plan(Integrator::Splat, "asked for"),
        }
    }
}
