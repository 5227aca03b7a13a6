//! The extreme cases of the tracer, the finite elements and the estimators, each with its reference and its error.
//!
//! A [`Check`] is one family of cases; it gives [`Row`]s. What is checked comes from a [`Context`], so that a test can
//! put a faulty tracer or element in and see rows fail.

mod compressibility;
pub mod creeping;
mod geometry;
mod images;
pub mod inclusions;
pub mod membrane;
pub mod presses;
mod reflectance;
mod row;
pub mod scenes;
pub mod solved;
mod tracer;
mod walks;
pub mod watch;

pub use compressibility::{PressureSample, pressure_errors};
pub use geometry::{corners, grazing};
pub use reflectance::{Sample, about_critical};
pub use row::{Part, Row, Subject};
pub use tracer::{Finish, Start, Tracer};
pub use walks::{DriftSample, drift_curve};

use crate::estimate::{CalibrationError, GreyImageError};
use crate::mechanics::material::MaterialError;
use crate::mechanics::mesh::MeshError;
use crate::mechanics::path::PathError;
use crate::mechanics::press::PressError;
use crate::pipeline::PipelineError;
use crate::progress::{Observer, Stage};
use crate::scene::SceneError;
use crate::surface::SurfaceError;
use crate::trace::TraceError;
use thiserror::Error;

/// Why a case could not be computed.
#[derive(Debug, Error)]
#[allow(missing_docs)] // each variant is the error of one stage
pub enum StabilityError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    #[error(transparent)]
    Trace(#[from] TraceError),
    #[error(transparent)]
    Mesh(#[from] MeshError),
    #[error(transparent)]
    Material(#[from] MaterialError),
    #[error(transparent)]
    Path(#[from] PathError),
    #[error(transparent)]
    Press(#[from] PressError),
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    #[error(transparent)]
    Image(#[from] GreyImageError),
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    #[error(transparent)]
    File(#[from] std::io::Error),
    /// Something that must be there is not.
    #[error("{0}")]
    Missing(&'static str),
}

/// What is checked, and how thoroughly.
pub struct Context {
    /// The tracers.
    pub tracers: Vec<Tracer>,
    /// Deflection of Cook's membrane, mm, on a mesh of so many elements along a side.
    pub membrane: fn(usize) -> Result<f64, StabilityError>,
    /// Fewer and smaller cases.
    pub quick: bool,
}

/// One family of cases.
#[derive(Clone, Copy)]
pub struct Check {
    /// Its name.
    pub name: &'static str,
    part: Part,
    rows: Rows,
}

#[derive(Clone, Copy)]
enum Rows {
    /// For each tracer.
    EachTracer(fn(&Context, &Tracer) -> Result<Vec<Row>, StabilityError>),
    /// Once.
    Once(fn(&Context) -> Result<Vec<Row>, StabilityError>),
}

/// All families, in the order of the table.
pub const CHECKS: [Check; 14] = [
    each("near-critical incidence", reflectance::near_critical),
    each("steps of the index", reflectance::index_steps),
    each("lateral shift", walks::lateral_shift),
    each("lossless bounces", walks::lossless_bounces),
    each("guided positions", walks::guided_positions),
    each("grazing and corner rays", geometry::hard_rays),
    each("flux ledgers", geometry::ledgers),
    once("paths of the twin", Part::Light, geometry::watched_paths),
    once("truncated light", Part::Light, geometry::truncated_light),
    once("compressibility", Part::Mechanics, compressibility::rows),
    once("inclusions", Part::Mechanics, inclusions::rows),
    once("large compression", Part::Mechanics, compressibility::half_height),
    once("presses", Part::Mechanics, presses::rows),
    once("images", Part::Image, images::rows),
];

const fn each(name: &'static str, rows: fn(&Context, &Tracer) -> Result<Vec<Row>, StabilityError>) -> Check {
    Check { name, part: Part::Light, rows: Rows::EachTracer(rows) }
}

const fn once(name: &'static str, part: Part, rows: fn(&Context) -> Result<Vec<Row>, StabilityError>) -> Check {
    Check { name, part, rows: Rows::Once(rows) }
}

/// The rows of all families, in the order of the table; none where `observe` stops it.
pub fn run(context: &Context, observe: &mut Observer) -> Option<Vec<Row>> {
    let mut rows = Vec::new();
    for (k, check) in CHECKS.iter().enumerate() {
        if !observe(Stage { done: k as f64 / CHECKS.len() as f64, what: check.name }) {
            return None;
        }
        rows.extend(check.run(context));
    }
    Some(rows)
}

impl Check {
    /// Its rows. What cannot be computed is a row that fails, and says why.
    pub fn run(&self, context: &Context) -> Vec<Row> {
        let or_failed = |rows: Result<Vec<Row>, StabilityError>, by: &str| {
            rows.unwrap_or_else(|error| vec![Subject::new(self.part, self.name, by).failed(error.to_string())])
        };
        match self.rows {
            Rows::Once(rows) => or_failed(rows(context), "cpu f64"),
            Rows::EachTracer(rows) => {
                let tracers = context.tracers.iter();
                tracers.flat_map(|tracer| or_failed(rows(context, tracer), tracer.name())).collect()
            }
        }
    }
}
