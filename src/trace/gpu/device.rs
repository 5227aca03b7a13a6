//! An adapter and its device, with every failure turned into an error.

use crate::trace::TraceError;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Kernels that a device keeps: scenes of the same make share theirs. All are let go where one more would come.
const KEPT_KERNELS: usize = 64;

/// A device, its queue, the kernels built on it, and what went wrong with it so far.
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// Its adapter.
    pub info: wgpu::AdapterInfo,
    kernels: Mutex<HashMap<KernelText, wgpu::ComputePipeline>>,
    trouble: Arc<Mutex<Option<Trouble>>>,
}

/// All that a kernel is compiled from. Its bindings follow from its text.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct KernelText {
    /// WGSL.
    pub wgsl: String,
    /// The entry point.
    pub entry: &'static str,
    /// Override constants, as bits.
    constants: Vec<(&'static str, u64)>,
}

impl KernelText {
    /// A text with its override constants.
    pub fn new(wgsl: String, entry: &'static str, constants: &[(&'static str, f64)]) -> Self {
        let constants = constants.iter().map(|&(name, value)| (name, value.to_bits())).collect();
        Self { wgsl, entry, constants }
    }
}

#[derive(Debug, Clone)]
enum Trouble {
    Lost(String),
    Refused(String),
}

impl Gpu {
    /// Name of the adapter and its driver.
    pub fn adapter(&self) -> String {
        let info = &self.info;
        format!("{} ({:?}, {})", info.name, info.backend, info.driver_info)
    }

    /// Opens the fastest adapter.
    ///
    /// # Errors
    /// `NoAdapter` where there is none, `Driver` where it opens no device.
    pub fn open() -> Result<Self, TraceError> {
        pollster::block_on(async {
            let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
            descriptor.flags = wgpu::InstanceFlags::empty();
            let instance = wgpu::Instance::new(descriptor);
            let options = wgpu::RequestAdapterOptions {
                power_preference: wgpu::PowerPreference::HighPerformance,
                ..Default::default()
            };
            let adapter = instance.request_adapter(&options).await.map_err(|_| TraceError::NoAdapter)?;
            let offered = adapter.limits();
            let limits = wgpu::Limits {
                max_buffer_size: offered.max_buffer_size,
                max_storage_buffer_binding_size: offered.max_storage_buffer_binding_size,
                // Eight are in use; event histories (tests) take one more where the adapter has it.
                max_storage_buffers_per_shader_stage: offered.max_storage_buffers_per_shader_stage.clamp(8, 9),
                ..wgpu::Limits::default()
            };
            let (device, queue) = adapter
                .request_device(&wgpu::DeviceDescriptor {
                    label: Some("tirtouch"),
                    required_limits: limits,
                    ..Default::default()
                })
                .await
                .map_err(|e| TraceError::Driver(one_line(&e.to_string())))?;
            let trouble = Arc::new(Mutex::new(None));
            let lost = Arc::clone(&trouble);
            device.set_device_lost_callback(move |reason, message| {
                note(&lost, Trouble::Lost(format!("{reason:?} {message}")));
            });
            let refused = Arc::clone(&trouble);
            device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| {
                note(&refused, Trouble::Refused(e.to_string()));
            }));
            let kernels = Mutex::default();
            Ok(Self { device, queue, info: adapter.get_info(), kernels, trouble })
        })
    }

    /// What went wrong, if anything did.
    ///
    /// # Errors
    /// `DeviceLost` once the device is lost, `Driver` once something was refused: at every call from then on.
    pub fn check(&self) -> Result<(), TraceError> {
        match held(&self.trouble).as_ref() {
            None => Ok(()),
            Some(Trouble::Lost(why)) => Err(TraceError::DeviceLost(one_line(why))),
            Some(Trouble::Refused(why)) => Err(TraceError::Driver(one_line(why))),
        }
    }

    /// The kernel of a text, and whether it was made just now.
    ///
    /// # Errors
    /// As [`Self::check`]; `Driver` where the WGSL, its constants or its bindings are refused.
    pub fn kernel(
        &self,
        text: KernelText,
        bindings: &[wgpu::BindGroupLayoutEntry],
    ) -> Result<(wgpu::ComputePipeline, bool), TraceError> {
        self.check()?;
        let mut kernels = held(&self.kernels);
        if let Some(kernel) = kernels.get(&text) {
            return Ok((kernel.clone(), false));
        }
        let kernel = self.build(&text, bindings)?;
        if kernels.len() >= KEPT_KERNELS {
            kernels.clear();
        }
        kernels.insert(text, kernel.clone());
        Ok((kernel, true))
    }

    /// Kernels kept.
    pub fn kernels(&self) -> usize {
        held(&self.kernels).len()
    }

    fn build(
        &self,
        text: &KernelText,
        bindings: &[wgpu::BindGroupLayoutEntry],
    ) -> Result<wgpu::ComputePipeline, TraceError> {
        let (device, label) = (&self.device, Some("kernel"));
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let source = wgpu::ShaderSource::Wgsl(text.wgsl.as_str().into());
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
        let group = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries: bindings });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label,
            bind_group_layouts: &[Some(&group)],
            ..Default::default()
        });
        let constants: Vec<_> = text.constants.iter().map(|&(name, bits)| (name, f64::from_bits(bits))).collect();
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label,
            layout: Some(&layout),
            module: &module,
            entry_point: Some(text.entry),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &constants,
                zero_initialize_workgroup_memory: false,
            },
            cache: None,
        });
        match pollster::block_on(scope.pop()) {
            Some(error) => Err(TraceError::Driver(one_line(&error.to_string()))),
            None => Ok(pipeline),
        }
    }

    /// Submits commands and waits for them.
    ///
    /// # Errors
    /// As [`Self::check`], before and after.
    pub fn submit(&self, encoder: wgpu::CommandEncoder) -> Result<(), TraceError> {
        self.check()?;
        self.queue.submit([encoder.finish()]);
        self.wait()
    }

    /// Waits for everything submitted.
    ///
    /// # Errors
    /// As [`Self::check`]; `DeviceLost` where the device cannot be waited for.
    pub fn wait(&self) -> Result<(), TraceError> {
        self.check()?;
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|e| TraceError::DeviceLost(one_line(&e.to_string())))?;
        self.check()
    }

    /// A buffer of at least 16 bytes.
    ///
    /// # Errors
    /// `Memory` where the device does not allow the size, or has no room for it (it then allows 0).
    pub fn buffer(
        &self,
        what: &'static str,
        bytes: u64,
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, TraceError> {
        let limits = self.device.limits();
        let mut allowed = limits.max_buffer_size;
        if usage.contains(wgpu::BufferUsages::STORAGE) {
            allowed = allowed.min(limits.max_storage_buffer_binding_size);
        }
        let needed = bytes.max(16).next_multiple_of(16);
        if needed > allowed {
            return Err(TraceError::Memory { what, needed, allowed });
        }
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(what),
            size: needed,
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        match pollster::block_on(scope.pop()) {
            Some(_) => Err(TraceError::Memory { what, needed, allowed: 0 }),
            None => Ok(buffer),
        }
    }

    /// A buffer with contents.
    ///
    /// # Errors
    /// As [`Self::buffer`] and [`Self::check`].
    pub fn upload(
        &self,
        what: &'static str,
        bytes: &[u8],
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, TraceError> {
        let buffer = self.buffer(what, bytes.len() as u64, usage)?;
        self.check()?;
        self.queue.write_buffer(&buffer, 0, bytes);
        Ok(buffer)
    }

    /// Contents of a storage buffer as words.
    ///
    /// # Errors
    /// As [`Self::buffer`], of the copy that is read, and [`Self::wait`]; `DeviceLost` where the copy cannot be read.
    pub fn read(&self, buffer: &wgpu::Buffer) -> Result<Vec<u32>, TraceError> {
        let staging = self.buffer("read-back", buffer.size(), wgpu::BufferUsages::MAP_READ)?;
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, buffer.size());
        self.submit(encoder)?;
        let (send, receive) = std::sync::mpsc::channel();
        staging.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            // The receiver is gone only where the read was given up.
            let _ = send.send(result);
        });
        self.wait()?;
        match receive.recv() {
            Ok(Ok(())) => {}
            Ok(Err(e)) => return Err(TraceError::DeviceLost(one_line(&e.to_string()))),
            Err(_) => return Err(TraceError::DeviceLost("no answer to a read".into())),
        }
        let view =
            staging.slice(..).get_mapped_range().map_err(|e| TraceError::DeviceLost(one_line(&e.to_string())))?;
        let words = view.chunks_exact(4).map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]])).collect();
        Ok(words)
    }
}

fn note(place: &Mutex<Option<Trouble>>, what: Trouble) {
    held(place).get_or_insert(what);
}

fn held<T>(place: &Mutex<T>) -> MutexGuard<'_, T> {
    place.lock().unwrap_or_else(PoisonError::into_inner)
}

fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}
