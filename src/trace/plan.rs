//! Which method finds the light of a scene, and why.

use super::error::TraceError;
use super::kernel::Kernel;
use super::modes::{CameraMode, PhotonMode};
use crate::scene::Integrator;

/// A light-transport method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Camera paths followed until they meet an LED.
    Path,
    /// Photons connected to the pinhole at each diffuse vertex; camera paths for all other light.
    Splat,
    /// Photons fill an exitance map; camera paths read it at tissue and carry on to the LEDs by themselves elsewhere.
    Map,
}

impl Method {
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

/// A method with the reason for it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plan {
    /// The method.
    pub method: Method,
    /// Why, in a sentence.
    pub why: &'static str,
}

impl Plan {
    /// Chooses the method for a scene, or checks that the one asked for suits it.
    ///
    /// # Errors
    /// `Unsuited`: `map` and `splat` where no tissue touches; `splat` where interfaces are deformed or rough, or the
    /// camera has a lens.
    pub fn choose(asked: Integrator, kernel: &Kernel) -> Result<Self, TraceError> {
        let plan = |method, why| Ok(Self { method, why });
        let unsuited = |why: &str| Err(TraceError::Unsuited(why.into()));
        match asked {
            Integrator::Path => plan(Method::Path, "asked for"),
            Integrator::Auto if !kernel.touched => {
                plan(Method::Path, "no tissue touches: there is no diffuse light to gather")
            }
            Integrator::Auto => plan(
                Method::Map,
                "tissue touches: photons gather its diffuse light, camera paths see it through the exact geometry",
            ),
            Integrator::Map | Integrator::Splat if !kernel.touched => {
                unsuited("--integrator map and splat need tissue in contact; this scene has none: use path")
            }
            Integrator::Map => plan(Method::Map, "asked for"),
            Integrator::Splat if kernel.deformed() => {
                unsuited("--integrator splat needs flat interfaces; this scene deforms them: use map or path")
            }
            Integrator::Splat if kernel.lens => {
                unsuited("--integrator splat needs a pinhole; this scene has a lens: use map or path")
            }
            Integrator::Splat if kernel.rough => {
                unsuited("--integrator splat needs smooth interfaces; this scene has rough ones: use map or path")
            }
            Integrator::Splat => plan(Method::Splat, "asked for"),
        }
    }
}
