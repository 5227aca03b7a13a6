//! A scene on a GPU: its buffers, its pipelines (built when first used), and chunks of work.

use super::assemble::{Entry, constants, source};
use super::device::{Gpu, KernelText};
use super::layout;
use crate::trace::TraceError;
use crate::trace::constants::{EVENTS, WORKGROUP};
use crate::trace::cpu::{Limits, UNIT, book};
use crate::trace::finite;
use crate::trace::kernel::{Kernel, ShapePiece};
use crate::trace::model::Model;
use crate::trace::modes::{CameraMode, Fates, PhotonMode, deposit_cells};
use std::collections::HashMap;
use std::sync::Arc;
use wgpu::BufferUsages as Usage;

/// A change to a kernel's WGSL before it is compiled.
pub type SourceEdit = Box<dyn Fn(Entry, String) -> String + Send + Sync>;

/// Most paths of one thread in one dispatch, and threads at once, of a CPU that stands for a GPU and of a real one.
///
/// Mesa's llvmpipe ends all loops of a thread after 65,535 turns together (LP_MAX_TGSI_LOOP_ITERATIONS, "shared between
/// every loop in a shader") and says nothing: an image of few pixels and many samples lost three quarters of its light.
/// 32 paths leave 2,000 turns for each; finished paths are counted too. A GPU hides one thread's waiting behind others:
/// an H100 sends photons 4.2 times as fast by 2^18 threads of 256 as by 2^14 of 32 (docs/ERROR.md, "On a GPU").
const OF_CPU: Portion = Portion { paths: 32, threads: 1 };
const OF_GPU: Portion = Portion { paths: 256, threads: 1 << 18 };

/// What one dispatch may hold. Images are the same to the bit whatever it is.
#[derive(Debug, Clone, Copy)]
pub struct Portion {
    /// Paths of each thread, at most.
    pub paths: u32,
    /// Threads that photons are spread over, where there are photons enough.
    pub threads: u32,
}

/// A scene loaded on a GPU.
pub struct GpuTracer {
    gpu: Arc<Gpu>,
    kernel: Kernel,
    model: Model<f32>,
    run: wgpu::Buffer,
    numbers: wgpu::Buffer,
    led_tables: wgpu::Buffer,
    surface: [wgpu::Buffer; 2],
    share: wgpu::Buffer,
    film: wgpu::Buffer,
    fates: wgpu::Buffer,
    exitance: wgpu::Buffer,
    deposits: wgpu::Buffer,
    ledger: wgpu::Buffer,
    events: Option<wgpu::Buffer>,
    pipelines: HashMap<Entry, wgpu::ComputePipeline>,
    edit: Option<SourceEdit>,
    limits: Limits,
    portion: Portion,
    /// Camera paths and photons sent since their sums were emptied.
    sent: [u64; 2],
}

impl GpuTracer {
    /// Opens a device and loads a model.
    ///
    /// # Errors
    /// As [`Gpu::open`] and [`Self::on`].
    pub fn new(model: &Model<f64>) -> Result<Self, TraceError> {
        Self::on(Gpu::open()?, model)
    }

    /// Loads a model on an open device.
    ///
    /// # Errors
    /// `NotFinite` for a number of the model that is not finite in f32; as [`Gpu::upload`].
    pub fn on(gpu: impl Into<Arc<Gpu>>, model: &Model<f64>) -> Result<Self, TraceError> {
        let gpu = gpu.into();
        let model: Model<f32> = model.cast();
        finite::check(&model, "f32")?;
        let kernel = Kernel::of(&model);
        let pixels = u64::from(model.camera.size[0]) * u64::from(model.camera.size[1]);
        let (surface_a, surface_b) = layout::shape(&model);
        let storage = |what, words: &[f32]| gpu.upload(what, bytemuck::cast_slice(words), Usage::STORAGE);
        let tables: Vec<f32> = model.led_tables.iter().flatten().copied().collect();
        let grid = model.tissue.as_ref().map_or(&[][..], |t| &t.grid);
        Ok(Self {
            run: gpu.buffer("run", size_of::<layout::Run>() as u64, Usage::UNIFORM)?,
            numbers: gpu.buffer("scene", 16, Usage::STORAGE)?,
            led_tables: storage("LED tables", &tables)?,
            surface: [storage("surface", &surface_a)?, storage("triangles", &surface_b)?],
            share: storage("contact share", grid)?,
            film: gpu.buffer("film", 16 * pixels, Usage::STORAGE | Usage::COPY_SRC)?,
            fates: gpu.buffer("fates of camera paths", 16, Usage::STORAGE | Usage::COPY_SRC)?,
            exitance: gpu.buffer("exitance map", 16, Usage::STORAGE)?,
            deposits: gpu.buffer("photon deposits", 16, Usage::STORAGE | Usage::COPY_SRC)?,
            ledger: gpu.buffer("ledger", 8 * book::SLOTS as u64, Usage::STORAGE | Usage::COPY_SRC)?,
            events: None,
            pipelines: HashMap::new(),
            edit: None,
            limits: Limits::default(),
            portion: if gpu.info.device_type == wgpu::DeviceType::Cpu { OF_CPU } else { OF_GPU },
            sent: [0; 2],
            kernel,
            model,
            gpu,
        })
    }

    /// Loads a model, and changes the kernels' WGSL before it is compiled: to inject faults that tests must find.
    ///
    /// # Errors
    /// As [`Self::on`]. What the change breaks shows where kernels are built.
    pub fn with_source(gpu: impl Into<Arc<Gpu>>, model: &Model<f64>, edit: SourceEdit) -> Result<Self, TraceError> {
        Ok(Self { edit: Some(edit), ..Self::on(gpu, model)? })
    }

    /// The same with other limits of a walk.
    #[must_use]
    pub fn with_limits(self, limits: Limits) -> Self {
        Self { limits, pipelines: HashMap::new(), ..self }
    }

    /// The same by dispatches of another size than suits the adapter.
    #[must_use]
    pub fn in_portions(self, portion: Portion) -> Self {
        Self { portion, ..self }
    }

    /// Name of the adapter and its driver.
    pub fn adapter(&self) -> String {
        self.gpu.adapter()
    }

    /// The device underneath.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Keeps event histories of the paths of each following chunk: [`EVENTS`] words a path, the first their number.
    ///
    /// # Errors
    /// `Memory` where the device does not hold so many.
    pub fn record_events(&mut self, paths: u32) -> Result<(), TraceError> {
        let bytes = 4 * u64::from(EVENTS) * u64::from(paths);
        self.events = Some(self.gpu.buffer("events", bytes, Usage::STORAGE | Usage::COPY_SRC)?);
        self.pipelines.clear();
        Ok(())
    }

    /// Event histories of the last chunk.
    ///
    /// # Errors
    /// As [`Gpu::read`].
    pub fn read_events(&self) -> Result<Vec<u32>, TraceError> {
        self.events.as_ref().map_or(Ok(Vec::new()), |e| self.gpu.read(e))
    }

    /// Kernels in use.
    pub fn kernels(&self) -> usize {
        self.pipelines.len()
    }

    /// Builds the pipeline of an entry point, so that it does not count as run time.
    ///
    /// # Errors
    /// As [`Gpu::upload`], [`Gpu::kernel`] and [`Gpu::submit`].
    pub fn prepare(&mut self, entry: Entry) -> Result<(), TraceError> {
        if self.pipelines.contains_key(&entry) {
            return Ok(());
        }
        let (text, numbers) = source(&self.model, entry, self.events.is_some());
        self.numbers = self.gpu.upload("scene", bytemuck::cast_slice(numbers.values()), Usage::STORAGE)?;
        let text = match &self.edit {
            Some(edit) => edit(entry, text),
            None => text,
        };
        let name = match entry {
            Entry::Camera(_) => "camera",
            Entry::Photons(_) => "photons",
            Entry::Probe => "probe",
        };
        let text = KernelText::new(text, name, &constants(&self.kernel, entry, self.limits));
        let bindings: Vec<_> = self.bindings(entry).into_iter().map(|(k, _, kind)| layout_entry(k, kind)).collect();
        let (pipeline, new) = self.gpu.kernel(text, &bindings)?;
        self.pipelines.insert(entry, pipeline);
        if !new {
            return Ok(());
        }
        // Drivers compile at first dispatch: send an empty one.
        self.dispatch(entry, layout::Run::default(), 1)
    }

    fn bindings(&self, entry: Entry) -> Vec<(u32, &wgpu::Buffer, wgpu::BufferBindingType)> {
        let uniform = wgpu::BufferBindingType::Uniform;
        let read = wgpu::BufferBindingType::Storage { read_only: true };
        let write = wgpu::BufferBindingType::Storage { read_only: false };
        let mut out = vec![(0, &self.numbers, read), (1, &self.run, uniform), (5, &self.led_tables, read)];
        if self.kernel.has_fields() || self.kernel.shape == ShapePiece::Mesh {
            out.push((8, &self.surface[0], read));
        }
        if self.kernel.shape == ShapePiece::Mesh {
            out.push((9, &self.surface[1], read));
        }
        if self.kernel.touched {
            out.push((10, &self.share, read));
        }
        if let Some(events) = &self.events {
            out.push((11, events, write));
        }
        match entry {
            Entry::Camera(_) => {
                out.extend([(6, &self.film, write), (12, &self.fates, write)]);
                if self.kernel.touched {
                    out.push((7, &self.exitance, read));
                }
            }
            Entry::Photons(_) | Entry::Probe => {
                out.push((12, &self.ledger, write));
                if self.kernel.touched {
                    out.push((6, &self.deposits, write));
                }
            }
        }
        out
    }

    fn dispatch(&self, entry: Entry, run: layout::Run, threads: u32) -> Result<(), TraceError> {
        let Some(pipeline) = self.pipelines.get(&entry) else {
            return Ok(());
        };
        self.gpu.check()?;
        self.gpu.queue.write_buffer(&self.run, 0, bytemuck::bytes_of(&run));
        let bindings = self.bindings(entry);
        let entries: Vec<_> = bindings
            .iter()
            .map(|(k, buffer, _)| wgpu::BindGroupEntry { binding: *k, resource: buffer.as_entire_binding() })
            .collect();
        let group = self.gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("kernel"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(threads.div_ceil(WORKGROUP), 1, 1);
        }
        self.gpu.submit(encoder)
    }

    pub(in crate::trace) fn clear_film(&mut self) {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(&self.film, 0, None);
        encoder.clear_buffer(&self.fates, 0, None);
        self.sent[0] = 0;
        self.gpu.queue.submit([encoder.finish()]);
    }

    /// Traces a chunk of camera paths.
    ///
    /// # Errors
    /// As [`Self::prepare`].
    pub fn camera(
        &mut self,
        mode: CameraMode,
        seed: u32,
        [first, count]: [u32; 2],
        [first_sample, samples]: [u32; 2],
    ) -> Result<(), TraceError> {
        let entry = Entry::Camera(mode);
        self.prepare(entry)?;
        self.sent[0] += u64::from(count) * u64::from(samples);
        for (first_sample, samples, _) in portions(first_sample, samples, 1, self.portion.paths) {
            let run = layout::Run::of(seed, [first, count], [first_sample, samples]);
            self.dispatch(entry, run, count)?;
        }
        Ok(())
    }

    pub(in crate::trace) fn read_film(&mut self) -> Result<(Vec<u64>, Fates), TraceError> {
        let words = self.gpu.read(&self.film)?;
        let fates = self.gpu.read(&self.fates)?;
        let pixels = words.chunks_exact(4);
        let segments = pixels.clone().map(|p| u64::from(p[2])).sum();
        finished(pixels.clone().map(|p| u64::from(p[3])).sum(), self.sent[0])?;
        let fates = Fates { segments, lost: fates[0].into(), cut_off: join(fates[1], fates[2]) };
        Ok((pixels.map(|p| join(p[0], p[1])).collect(), fates))
    }

    pub(in crate::trace) fn set_exitance(&mut self, texels: &[[f64; 4]]) -> Result<(), TraceError> {
        let words: Vec<f32> = texels.iter().flatten().map(|&v| v as f32).collect();
        self.exitance = self.gpu.upload("exitance map", bytemuck::cast_slice(&words), Usage::STORAGE)?;
        Ok(())
    }

    pub(in crate::trace) fn clear_photons(&mut self, mode: PhotonMode) -> Result<(), TraceError> {
        let bytes = 8 * deposit_cells(&self.model, mode) as u64;
        if self.deposits.size() != bytes.max(16).next_multiple_of(16) {
            self.deposits = self.gpu.buffer("photon deposits", bytes, Usage::STORAGE | Usage::COPY_SRC)?;
        }
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(&self.deposits, 0, None);
        encoder.clear_buffer(&self.ledger, 0, None);
        self.sent[1] = 0;
        self.gpu.submit(encoder)
    }

    /// Sends a chunk of photons.
    ///
    /// # Errors
    /// As [`Self::prepare`].
    pub fn photons(
        &mut self,
        mode: PhotonMode,
        seed: u32,
        threads: u32,
        [first_sample, samples]: [u32; 2],
    ) -> Result<(), TraceError> {
        let entry = Entry::Photons(mode);
        self.prepare(entry)?;
        self.sent[1] += u64::from(threads) * u64::from(samples);
        let Portion { paths, threads: wanted } = self.portion;
        for (first_sample, samples, rows) in portions(first_sample, samples, (wanted / threads.max(1)).max(1), paths) {
            let count = threads * rows;
            let run = layout::Run { count, ..layout::Run::of(seed, [0, threads], [first_sample, samples]) };
            self.dispatch(entry, run, count)?;
        }
        Ok(())
    }

    /// Sends the rays that lie in the LEDs' tables through the probe; [`Self::record_events`] makes room for what they
    /// come to.
    ///
    /// # Errors
    /// As [`Self::prepare`].
    pub fn probe(&mut self, seed: u32, rays: u32) -> Result<(), TraceError> {
        self.prepare(Entry::Probe)?;
        self.dispatch(Entry::Probe, layout::Run::of(seed, [0, rays], [0, 1]), rays)
    }

    pub(in crate::trace) fn read_photons(
        &mut self,
        mode: PhotonMode,
    ) -> Result<([i64; book::SLOTS], Vec<u64>), TraceError> {
        let ledger = self.gpu.read(&self.ledger)?;
        let mut tally = [0i64; book::SLOTS];
        for (slot, words) in tally.iter_mut().zip(ledger.chunks_exact(2)) {
            *slot = join(words[0], words[1]) as i64;
        }
        finished((tally[book::EMITTED] as f64 / UNIT) as u64, self.sent[1])?;
        let cells = deposit_cells(&self.model, mode);
        let words = self.gpu.read(&self.deposits)?;
        let deposits = words.chunks_exact(2).take(cells).map(|w| join(w[0], w[1])).collect();
        Ok((tally, deposits))
    }
}

/// Cuts samples into what one dispatch may hold: the first, how many each thread takes, and rows of threads. A row
/// takes the samples after those of the row before it.
fn portions(first: u32, samples: u32, rows: u32, most: u32) -> impl Iterator<Item = (u32, u32, u32)> {
    let mut next = 0;
    std::iter::from_fn(move || {
        let left = samples - next;
        let rows = rows.min(left);
        let each = left.checked_div(rows)?.min(most);
        next += rows * each;
        Some((first + next - rows * each, each, rows))
    })
}

fn finished(finished: u64, sent: u64) -> Result<(), TraceError> {
    if finished == sent { Ok(()) } else { Err(TraceError::CutShort { finished, sent }) }
}

fn join(low: u32, high: u32) -> u64 {
    u64::from(low) | u64::from(high) << 32
}

fn layout_entry(binding: u32, ty: wgpu::BufferBindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    }
}
