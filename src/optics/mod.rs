//! Closed forms of the optics, in f64: Snell, Fresnel, total reflection, acceptance, slabs, tissue.
//!
//! The tracer's shaders and their CPU twin have the same laws in their own precision; these are what both are checked
//! against.

pub mod acceptance;
pub mod fresnel;
pub mod tissue;

pub use acceptance::{acceptance_deg, critical_deg};
pub use fresnel::{Reflectance, fresnel, reflectance};
