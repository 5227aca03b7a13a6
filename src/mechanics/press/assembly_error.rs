//! Why a press cannot be put together.

use crate::mechanics::material::MaterialError;
use crate::mechanics::mesh::MeshError;
use thiserror::Error;

/// Why the parts of a press make no problem that can be solved.
#[derive(Debug, Error)]
pub enum AssemblyError {
    /// What cannot be computed, and what can.
    #[error("{0}")]
    Unsupported(String),
    /// The geometry.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A material.
    #[error(transparent)]
    Material(#[from] MaterialError),
}
