//! The CPU twin of the shaders, generic over f32 and f64: the same files, the same laws, the same random numbers.
//!
//! In f32 it checks the GPU's implementation path by path; in f64 it measures the rounding error; and where no GPU is
//! found it does the work.

pub mod camera;
pub mod fresnel;
pub mod led;
pub mod photons;
pub mod random;
pub mod rough;
pub mod surface;
pub mod tissue;
pub mod touch;
pub mod vec3;
pub mod walk;

pub(super) use led::wall_axis;
pub(super) use vec3::V3;

pub use super::constants::{End, STRAY, UNIT, book};

use super::kernel::Kernel;
use super::model::{Model, Real};
use crate::scene::Wall;

/// One event of a path and how far its decision was from going the other way (a probability or a squared momentum).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// Code, as recorded by the GPU.
    pub code: u32,
    /// Distance of the decision from its threshold.
    pub margin: f64,
}

/// Limits of a walk: override constants of the shaders.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Interactions after which Russian roulette begins.
    pub roulette_start: u32,
    /// Interactions after which a path is cut off.
    pub event_cap: u32,
    /// Steps of the search on a height field after which a path is lost.
    pub search_steps: u32,
    /// Whether photons are split at tissue.
    pub split: bool,
}

impl Limits {
    /// Neither roulette nor a cap, and no photon is split.
    pub const ENDLESS: Self = Self { roulette_start: u32::MAX, event_cap: u32::MAX, search_steps: 1024, split: false };

    /// As by default, but no photon is split: one way from its start to its end.
    pub fn whole() -> Self {
        Self { split: false, ..Self::default() }
    }
}

impl Default for Limits {
    fn default() -> Self {
        // Paths that walls and faces hold for long come out of it: of 144 among 8 million photons of a pressed phantom
        // that were still on their way after 256 interactions, 2 were after 2,048. Roulette before that made a few of
        // them heavier than all others of a texel (docs/decisions/roulette.md).
        Self { roulette_start: 4096, event_cap: 65_536, search_steps: 1024, split: true }
    }
}

/// A path under way: its state, and what it found.
pub struct Path<'m, T: Real> {
    /// The scene.
    pub model: &'m Model<T>,
    /// What the scene needs.
    pub kernel: Kernel,
    /// Limits.
    pub limits: Limits,
    /// Position, mm.
    pub o: V3<T>,
    /// Optical momentum: index times direction.
    pub p: V3<T>,
    /// Layer it is in.
    pub layer: usize,
    /// Weight.
    pub weight: T,
    /// Random key.
    pub key: [u32; 2],
    /// Numbers drawn.
    pub draws: u32,
    /// Number of the launch.
    pub number: u32,
    /// Seed of the launches.
    pub seed: u32,
    /// Whether it comes from the camera and ends at tissue.
    pub eye: bool,
    /// Whether it is a photon that ends where it can meet tissue no more.
    pub aimed: bool,
    /// Interactions.
    pub bounces: u32,
    /// Wall it met last.
    pub wall: Wall,
    /// Reflections at outer faces; with [`STRAY`], others too.
    pub turns: u32,
    /// Normal of the touched face at [`End::Touch`].
    pub normal: V3<T>,
    /// The mirrored part of a photon, as it met the face, where one waits.
    pub mirrored: Option<photons::Part<T>>,
    /// A surface search did not converge.
    pub lost: bool,
    /// Slope of the height field at the last hit.
    pub field_slope: [T; 2],
    /// Normals of the mesh at the last hit: interpolated, facet.
    pub mesh_normals: [V3<T>; 2],
    /// Ledger, in units of 1 / [`UNIT`] photon.
    pub tally: [i64; book::SLOTS],
    /// Events, where they are wanted.
    pub events: Option<Vec<Event>>,
    /// What the photons leave behind, where they do.
    pub deposits: Option<&'m photons::Deposits<'m>>,
    /// Points it passed, mm, where they are wanted: on interfaces and walls, and where it leaves the tissue.
    pub trail: Option<Vec<V3<T>>>,
}

impl<'m, T: Real> Path<'m, T> {
    /// A path with nothing in it yet.
    pub fn new(model: &'m Model<T>, limits: Limits) -> Self {
        Self {
            model,
            kernel: Kernel::of(model),
            limits,
            o: V3::zero(),
            p: V3::zero(),
            layer: 0,
            weight: T::one(),
            key: [0; 2],
            draws: 0,
            number: 0,
            eye: false,
            aimed: false,
            seed: 0,
            bounces: 0,
            wall: Wall::PlusX,
            turns: 0,
            normal: V3::up(),
            mirrored: None,
            lost: false,
            field_slope: [T::zero(); 2],
            mesh_normals: [V3::up(); 2],
            tally: [0; book::SLOTS],
            events: None,
            deposits: None,
            trail: None,
        }
    }

    pub(super) fn record(&mut self, code: u32, margin: T) {
        if let Some(events) = &mut self.events {
            events.push(Event { code, margin: margin.wide() });
        }
    }

    pub(super) fn leave_trail(&mut self) {
        if let Some(trail) = &mut self.trail {
            trail.push(self.o);
        }
    }

    pub(super) fn book(&mut self, slot: usize, before: T, after: T) {
        self.tally[slot] += units(before) - units(after);
    }

    pub(super) fn top(&self) -> usize {
        self.model.faces.len() - 1
    }
}

/// Ledger units of a weight.
pub fn units<T: Real>(weight: T) -> i64 {
    (weight.wide() * UNIT).round() as i64
}
