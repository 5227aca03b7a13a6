//! The tracers under test, and the probe that looks into them.

use crate::trace::backend::{Backend, CpuTracer};
use crate::trace::constants;
use crate::trace::cpu::vec3::v3;
use crate::trace::cpu::{End, Limits, Path, fresnel};
use crate::trace::gpu::assemble::Entry;
use crate::trace::gpu::{Gpu, GpuTracer};
use crate::trace::model::Real;
use crate::trace::{BackendChoice, Model, TraceError};
use rayon::prelude::*;

/// Words of one event row.
const EVENTS: usize = constants::EVENTS as usize;

/// A tracer under test. Tests put faulty ones in.
#[derive(Clone, Copy)]
pub enum Tracer {
    /// The GPU.
    Gpu {
        /// A change to its WGSL.
        edit: fn(String) -> String,
        /// Limits of its walks; those of probed rays have neither roulette nor a cap, whatever is said here.
        limits: Limits,
    },
    /// The twin in f32.
    Twin {
        /// Reflectance from a = n_i cos(theta_i), n_t^2 - n_i^2 and n_i^2.
        reflectance: fn(f32, f32, f32) -> f32,
        /// A change to the path between two of its steps.
        between: fn(&mut Path<f32>),
        /// As for the GPU.
        limits: Limits,
    },
}

/// Where a probed ray starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// Position, mm.
    pub o: [f32; 3],
    /// Optical momentum.
    pub p: [f32; 3],
    /// Layer.
    pub layer: usize,
    /// Steps that it is followed for, at most.
    pub steps: u32,
}

/// Where it came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Finish {
    /// Position, mm.
    pub o: [f64; 3],
    /// Optical momentum.
    pub p: [f64; 3],
    /// Weight.
    pub weight: f64,
    /// Largest drift of the horizontal momentum s on the way, as a share of it.
    pub drift: f64,
    /// Largest | |p|/n - 1 | on the way.
    pub stretch: f64,
    /// Layer.
    pub layer: usize,
    /// Number of its [`End`].
    pub end: u32,
    /// Steps taken.
    pub steps: u32,
}

impl Start {
    /// Puts a path there.
    pub fn put<T: Real>(&self, path: &mut Path<T>) {
        let vector = |a: [f32; 3]| v3(T::of(a[0].into()), T::of(a[1].into()), T::of(a[2].into()));
        (path.o, path.p, path.layer) = (vector(self.o), vector(self.p), self.layer);
    }
}

impl Tracer {
    /// The GPU as it is.
    pub fn gpu() -> Self {
        Self::Gpu { edit: |text| text, limits: Limits::default() }
    }

    /// The twin in f32 as it is.
    pub fn twin() -> Self {
        Self::Twin { reflectance: fresnel::reflectance::<f32>, between: |_| {}, limits: Limits::default() }
    }

    /// What a choice of backends asks for, the GPU first, and that GPU's name; without one for `Auto`, where there is
    /// none.
    ///
    /// # Errors
    /// As [`Gpu::open`], where a GPU is asked for or there is one that fails.
    pub fn all(choice: BackendChoice) -> Result<(Vec<Self>, Option<String>), TraceError> {
        let gpu = match choice {
            BackendChoice::Cpu => None,
            _ => Some(Gpu::open()),
        };
        match gpu {
            Some(Ok(Gpu { info, .. })) => {
                let name = format!("{} ({:?}, {})", info.name, info.backend, info.driver_info);
                Ok((vec![Self::gpu(), Self::twin()], Some(name)))
            }
            Some(Err(error)) if choice == BackendChoice::Gpu || !matches!(error, TraceError::NoAdapter) => Err(error),
            _ => Ok((vec![Self::twin()], None)),
        }
    }

    /// Its name in the table.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Gpu { .. } => "gpu f32",
            Self::Twin { .. } => "cpu f32",
        }
    }

    /// The tracer with a scene loaded.
    ///
    /// # Errors
    /// As [`Gpu::open`] and [`GpuTracer::on`]; the twin has none.
    pub fn open(&self, model: &Model<f64>) -> Result<Backend, TraceError> {
        Ok(match *self {
            Self::Gpu { edit, limits } => edited(edit, model)?.with_limits(limits).into(),
            Self::Twin { limits, .. } => Backend::Cpu32(Box::new(CpuTracer::new(model.cast()).with_limits(limits))),
        })
    }

    /// Follows rays without roulette and without a cap.
    ///
    /// # Errors
    /// As [`Self::open`]; `Driver` where the changed WGSL is refused, `DeviceLost`. The twin has none.
    pub fn follow(&self, model: &Model<f64>, starts: &[Start]) -> Result<Vec<Finish>, TraceError> {
        match *self {
            Self::Gpu { edit, limits } => {
                let row = |s: &Start| [s.o[0], s.o[1], s.o[2], s.p[0], s.p[1], s.p[2], s.layer as f32, s.steps as f32];
                let rows: Vec<[f32; 8]> = starts.iter().map(row).collect();
                Ok(probe(edit, limits, model, &rows)?.iter().map(|words| finish(words)).collect())
            }
            Self::Twin { between, limits, .. } => Ok(follow(&model.cast::<f32>(), starts, between, limits)),
        }
    }

    /// Reflectances at [a, n_t^2 - n_i^2, n_i^2]; `model` is any scene.
    ///
    /// # Errors
    /// As [`Self::follow`].
    pub fn reflectances(&self, model: &Model<f64>, at: &[[f32; 3]]) -> Result<Vec<f32>, TraceError> {
        match *self {
            Self::Gpu { edit, limits } => {
                let rows: Vec<[f32; 8]> =
                    at.iter().map(|&[a, dn_sq, n_sq]| [a, dn_sq, n_sq, 0.0, 0.0, 0.0, 0.0, -1.0]).collect();
                Ok(probe(edit, limits, model, &rows)?.iter().map(|words| f32::from_bits(words[0])).collect())
            }
            Self::Twin { reflectance, .. } => {
                Ok(at.iter().map(|&[a, dn_sq, n_sq]| reflectance(a, dn_sq, n_sq)).collect())
            }
        }
    }
}

/// The rays in f64: the reference.
pub fn follow_exactly(model: &Model<f64>, starts: &[Start]) -> Vec<Finish> {
    follow(model, starts, |_| {}, Limits::default())
}

/// The walks are lossless: neither roulette nor the cap may end them.
fn endless(limits: Limits) -> Limits {
    Limits { search_steps: limits.search_steps, ..Limits::ENDLESS }
}

fn follow<T: Real>(model: &Model<T>, starts: &[Start], between: fn(&mut Path<T>), limits: Limits) -> Vec<Finish> {
    let one = |(row, start): (usize, &Start)| {
        let mut path = Path::new(model, endless(limits));
        path.start_random(SEED, row as u32, 0);
        start.put(&mut path);
        let along = path.p.x.hypot(path.p.y);
        let (mut end, mut steps) = (End::GoesOn, 0);
        let (mut drift, mut stretch) = (T::zero(), T::zero());
        while end == End::GoesOn && steps < start.steps {
            end = path.step();
            steps += 1;
            if end == End::Touch {
                end = path.photon_touch();
            }
            drift = drift.max((path.p.x.hypot(path.p.y) - along).abs());
            let index = path.model.layers[path.layer].n;
            stretch = stretch.max((path.p.dot(path.p).sqrt() / index - T::one()).abs());
            between(&mut path);
        }
        let wide = |v: crate::trace::cpu::vec3::V3<T>| [v.x.wide(), v.y.wide(), v.z.wide()];
        Finish {
            o: wide(path.o),
            p: wide(path.p),
            weight: path.weight.wide(),
            drift: (drift / along).wide(),
            stretch: stretch.wide(),
            layer: path.layer,
            end: end as u32,
            steps,
        }
    };
    starts.par_iter().enumerate().map(one).collect()
}

/// Seed of the probed rays.
const SEED: u32 = 20_261_121;

/// Sends rows through the probe and gives their event rows.
fn probe(
    edit: fn(String) -> String,
    limits: Limits,
    model: &Model<f64>,
    rows: &[[f32; 8]],
) -> Result<Vec<Vec<u32>>, TraceError> {
    let mut model = model.clone();
    let pairs = rows.iter().flat_map(|row| row.chunks_exact(2));
    model.led_tables = pairs.map(|pair| [f64::from(pair[0]), f64::from(pair[1])]).collect();
    let mut tracer = edited(edit, &model)?.with_limits(endless(limits));
    let count = rows.len() as u32;
    tracer.record_events(count)?;
    tracer.probe(SEED, count)?;
    let words = tracer.read_events()?;
    Ok(words.chunks_exact(EVENTS).take(rows.len()).map(<[u32]>::to_vec).collect())
}

fn edited(edit: fn(String) -> String, model: &Model<f64>) -> Result<GpuTracer, TraceError> {
    GpuTracer::with_source(Gpu::open()?, model, Box::new(move |_: Entry, text: String| edit(text)))
}

fn finish(words: &[u32]) -> Finish {
    let float = |k: usize| f64::from(f32::from_bits(words[k]));
    Finish {
        o: [float(0), float(1), float(2)],
        p: [float(3), float(4), float(5)],
        weight: float(6),
        drift: float(7),
        stretch: float(11),
        layer: words[8] as usize,
        end: words[9],
        steps: words[10],
    }
}
