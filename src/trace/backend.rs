//! The two backends behind one face: chunks of camera paths and of photons.
//!
//! On a GPU each of the two has a device of its own. They share nothing, so the surface is held twice, and llvmpipe,
//! which compiles in a device's queue, compiles both kernels at once (docs/decisions/two-devices.md).

use super::cpu::{self, Limits, book, camera::View, photons::Deposits};
use super::error::TraceError;
use super::finite;
use super::gpu::assemble::Entry;
use super::gpu::{Gpu, GpuTracer};
use super::model::{Model, Real};
use super::modes::{CameraMode, Fates, PhotonMode, deposit_cells};
use super::plan::Integrator;
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Which backend is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BackendChoice {
    /// A GPU if there is one, else the CPU twin.
    #[default]
    Auto,
    /// A GPU (lavapipe counts).
    Gpu,
    /// The CPU twin.
    Cpu,
}

/// Precision of the CPU twin.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Precision {
    /// As on the GPU.
    #[default]
    F32,
    /// For reference.
    F64,
}

impl BackendChoice {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Gpu => "gpu",
            Self::Cpu => "cpu",
        }
    }
}

impl FromStr for BackendChoice {
    type Err = &'static str;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let all = [Self::Auto, Self::Gpu, Self::Cpu];
        all.into_iter().find(|one| one.name() == name).ok_or("it must be auto, gpu or cpu")
    }
}

impl FromStr for Precision {
    type Err = &'static str;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        match name {
            "f32" => Ok(Self::F32),
            "f64" => Ok(Self::F64),
            _ => Err("it must be f32 or f64"),
        }
    }
}

/// What traces: devices that stay open from image to image, with the kernels built on them, or the built-in tracer.
#[derive(Clone)]
pub struct Devices {
    precision: Precision,
    /// One for camera paths, one for photons.
    gpus: Option<[Arc<Gpu>; 2]>,
    notice: Option<String>,
}

impl Devices {
    /// Opens what is asked for. f64 is computed by the built-in tracer alone.
    ///
    /// # Errors
    /// `NoAdapter` where a GPU is asked for and none is there, `Unsuited` where one is asked for f64; what a driver
    /// says.
    pub fn open(choice: BackendChoice, precision: Precision) -> Result<Self, TraceError> {
        let cpu = Self::cpu(precision);
        let gpus = || {
            let (camera, photons) = rayon::join(Gpu::open, Gpu::open);
            Ok(Self { gpus: Some([Arc::new(camera?), Arc::new(photons?)]), ..cpu.clone() })
        };
        match choice {
            BackendChoice::Cpu => Ok(cpu),
            BackendChoice::Auto if precision == Precision::F64 => Ok(cpu),
            BackendChoice::Gpu if precision == Precision::F64 => {
                Err(TraceError::Unsuited("the gpu computes in f32 only; f64 needs the built-in tracer".into()))
            }
            BackendChoice::Gpu => gpus(),
            BackendChoice::Auto => match gpus() {
                Err(TraceError::NoAdapter) => {
                    let notice = Some("no GPU adapter found: the built-in CPU tracer runs instead".into());
                    Ok(Self { notice, ..cpu })
                }
                opened => opened,
            },
        }
    }

    /// The built-in tracer.
    pub fn cpu(precision: Precision) -> Self {
        Self { precision, gpus: None, notice: None }
    }

    /// Whether a GPU (lavapipe counts) does the work.
    pub fn is_gpu(&self) -> bool {
        self.gpus.is_some()
    }

    /// Name of the adapter.
    pub fn adapter(&self) -> String {
        match &self.gpus {
            Some([camera, _]) => camera.adapter(),
            None => format!("built-in CPU tracer, {} threads", rayon::current_num_threads()),
        }
    }

    /// Why the CPU was taken, where it was not asked for.
    pub fn notice(&self) -> Option<&str> {
        self.notice.as_deref()
    }

    /// Loads a model.
    ///
    /// # Errors
    /// A number of the model that is not finite in the tracer's precision, buffers that the device does not allow.
    pub fn load(&self, model: &Model<f64>) -> Result<Backend, TraceError> {
        match self.precision {
            Precision::F32 => finite::check(&model.cast::<f32>(), "f32")?,
            Precision::F64 => finite::check(model, "f64")?,
        }
        Ok(match (&self.gpus, self.precision) {
            (Some([camera, photons]), _) => {
                let (camera, photons) = (GpuTracer::on(camera.clone(), model)?, GpuTracer::on(photons.clone(), model)?);
                Backend::Gpu { camera: Box::new(camera), photons: Some(Box::new(photons)) }
            }
            (None, Precision::F32) => Backend::Cpu32(Box::new(CpuTracer::new(model.cast()))),
            (None, Precision::F64) => Backend::Cpu64(Box::new(CpuTracer::new(model.cast()))),
        })
    }
}

/// A backend with a scene loaded.
pub enum Backend {
    /// wgpu.
    Gpu {
        /// The device of camera paths.
        camera: Box<GpuTracer>,
        /// That of photons, where they have one of their own.
        photons: Option<Box<GpuTracer>>,
    },
    /// The twin in f32.
    Cpu32(Box<CpuTracer<f32>>),
    /// The twin in f64.
    Cpu64(Box<CpuTracer<f64>>),
}

impl From<GpuTracer> for Backend {
    /// Camera paths and photons on one device.
    fn from(tracer: GpuTracer) -> Self {
        Self::Gpu { camera: Box::new(tracer), photons: None }
    }
}

impl Backend {
    /// Short name of the backend.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Gpu { .. } => "gpu",
            Self::Cpu32(_) => "cpu f32",
            Self::Cpu64(_) => "cpu f64",
        }
    }

    /// Name of the adapter.
    pub fn adapter(&self) -> String {
        match self {
            Self::Gpu { camera, .. } => camera.adapter(),
            _ => format!("built-in CPU tracer, {} threads", rayon::current_num_threads()),
        }
    }

    /// Builds the kernels of an integrator, so that they do not count as run time.
    ///
    /// # Errors
    /// As [`GpuTracer::prepare`]; the CPU has none.
    pub fn prepare(&mut self, integrator: Integrator) -> Result<(), TraceError> {
        let Self::Gpu { camera, photons } = self else {
            return Ok(());
        };
        let (seen, sent) = integrator.modes();
        let (seen, sent) = (Entry::Camera(seen), Entry::Photons(sent));
        match photons {
            Some(photons) => {
                let (one, other) = rayon::join(|| camera.prepare(seen), || photons.prepare(sent));
                one.and(other)
            }
            None => camera.prepare(seen).and_then(|()| camera.prepare(sent)),
        }
    }

    /// Empties the film of camera paths.
    ///
    /// # Errors
    /// None: a device's trouble shows at the next call.
    pub fn clear_film(&mut self) -> Result<(), TraceError> {
        match self {
            Self::Gpu { camera, .. } => camera.clear_film(),
            Self::Cpu32(cpu) => cpu.clear_film(),
            Self::Cpu64(cpu) => cpu.clear_film(),
        }
        Ok(())
    }

    /// Traces `samples` paths, from `first_sample` on, for `pixels` pixels from `first_pixel` on.
    ///
    /// # Errors
    /// As [`GpuTracer::camera`]; the CPU has none.
    pub fn camera(
        &mut self,
        mode: CameraMode,
        seed: u32,
        pixels: [u32; 2],
        samples: [u32; 2],
    ) -> Result<(), TraceError> {
        match self {
            Self::Gpu { camera, .. } => camera.camera(mode, seed, pixels, samples)?,
            Self::Cpu32(cpu) => cpu.camera(mode, seed, pixels, samples),
            Self::Cpu64(cpu) => cpu.camera(mode, seed, pixels, samples),
        }
        Ok(())
    }

    /// Sums of the film in units of 2^-48, and what became of the paths since it was emptied.
    ///
    /// # Errors
    /// As [`Gpu::read`]; `CutShort` where the driver ended paths before their time. The CPU has none.
    pub fn read_film(&mut self) -> Result<(Vec<u64>, Fates), TraceError> {
        Ok(match self {
            Self::Gpu { camera, .. } => camera.read_film()?,
            Self::Cpu32(cpu) => (cpu.film.clone(), cpu.fates),
            Self::Cpu64(cpu) => (cpu.film.clone(), cpu.fates),
        })
    }

    /// Loads the exitance map that mapped camera paths read: deposit and area for true contact and for the gap.
    ///
    /// # Errors
    /// As [`Gpu::upload`]; the CPU has none.
    pub fn set_exitance(&mut self, texels: &[[f64; 4]]) -> Result<(), TraceError> {
        match self {
            Self::Gpu { camera, .. } => camera.set_exitance(texels)?,
            Self::Cpu32(cpu) => cpu.set_exitance(texels),
            Self::Cpu64(cpu) => cpu.set_exitance(texels),
        }
        Ok(())
    }

    /// Empties deposits and ledger.
    ///
    /// # Errors
    /// `Memory` for more deposits than the device allows; else as [`Gpu::submit`]. The CPU has none.
    pub fn clear_photons(&mut self, mode: PhotonMode) -> Result<(), TraceError> {
        match self {
            Self::Gpu { camera, photons } => photons.as_mut().unwrap_or(camera).clear_photons(mode)?,
            Self::Cpu32(cpu) => cpu.clear_photons(mode),
            Self::Cpu64(cpu) => cpu.clear_photons(mode),
        }
        Ok(())
    }

    /// Sends `samples` photons, from `first_sample` on, from each of `threads` threads.
    ///
    /// # Errors
    /// As [`GpuTracer::photons`]; the CPU has none.
    pub fn photons(&mut self, mode: PhotonMode, seed: u32, threads: u32, samples: [u32; 2]) -> Result<(), TraceError> {
        match self {
            Self::Gpu { camera, photons } => {
                photons.as_mut().unwrap_or(camera).photons(mode, seed, threads, samples)?;
            }
            Self::Cpu32(cpu) => cpu.photons(mode, seed, threads, samples),
            Self::Cpu64(cpu) => cpu.photons(mode, seed, threads, samples),
        }
        Ok(())
    }

    /// Ledger in its units, and deposits in units of 2^-32.
    ///
    /// # Errors
    /// As [`Self::read_film`].
    pub fn read_photons(&mut self, mode: PhotonMode) -> Result<([i64; book::SLOTS], Vec<u64>), TraceError> {
        Ok(match self {
            Self::Gpu { camera, photons } => photons.as_mut().unwrap_or(camera).read_photons(mode)?,
            Self::Cpu32(cpu) => cpu.read_photons(),
            Self::Cpu64(cpu) => cpu.read_photons(),
        })
    }
}

/// The twin with a scene loaded.
pub struct CpuTracer<T> {
    model: Model<T>,
    limits: Limits,
    film: Vec<u64>,
    fates: Fates,
    exitance: Vec<[T; 4]>,
    deposits: Vec<AtomicU64>,
    tally: [i64; book::SLOTS],
}

impl<T: Real> CpuTracer<T> {
    /// Loads a model.
    pub fn new(model: Model<T>) -> Self {
        let [columns, rows] = model.camera.size;
        Self {
            film: vec![0; columns as usize * rows as usize],
            limits: Limits::default(),
            fates: Fates::default(),
            exitance: Vec::new(),
            deposits: Vec::new(),
            tally: [0; book::SLOTS],
            model,
        }
    }

    /// The same with other limits of a walk.
    #[must_use]
    pub fn with_limits(self, limits: Limits) -> Self {
        Self { limits, ..self }
    }

    fn clear_film(&mut self) {
        self.film.fill(0);
        self.fates = Fates::default();
    }

    fn camera(&mut self, mode: CameraMode, seed: u32, [first, count]: [u32; 2], [first_sample, samples]: [u32; 2]) {
        let view = View {
            exitance: (mode == CameraMode::Mapped).then_some(self.exitance.as_slice()),
            complement: mode == CameraMode::Complement,
        };
        let first = first as usize;
        let film = &mut self.film[first..first + count as usize];
        let fates = cpu::camera::add(&self.model, view, seed, [first_sample, samples], first, self.limits, film);
        self.fates = self.fates.and(fates);
    }

    fn set_exitance(&mut self, texels: &[[f64; 4]]) {
        self.exitance = texels.iter().map(|t| t.map(T::of)).collect();
    }

    fn clear_photons(&mut self, mode: PhotonMode) {
        self.deposits = (0..deposit_cells(&self.model, mode)).map(|_| AtomicU64::new(0)).collect();
        self.tally = [0; book::SLOTS];
    }

    fn photons(&mut self, mode: PhotonMode, seed: u32, threads: u32, samples: [u32; 2]) {
        let deposits = Deposits { cells: &self.deposits, splatted: mode == PhotonMode::Splat };
        let deposits = (mode != PhotonMode::Ledger).then_some(&deposits);
        let tally = cpu::photons::send(&self.model, deposits, seed, threads, samples, self.limits);
        self.tally.iter_mut().zip(tally).for_each(|(sum, v)| *sum += v);
    }

    fn read_photons(&self) -> ([i64; book::SLOTS], Vec<u64>) {
        (self.tally, self.deposits.iter().map(|d| d.load(Ordering::Relaxed)).collect())
    }
}
