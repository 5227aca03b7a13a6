//! The tracer on a GPU: wgpu compute shaders in WGSL, assembled after the scene.
//!
//! docs/ARCHITECTURE.md has its objects by lifetime.

pub mod assemble;
pub mod device;
pub mod layout;
pub mod tracer;

pub use device::Gpu;
pub use tracer::GpuTracer;
