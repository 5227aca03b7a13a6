//! An adapter and its device, with every failure turned into an error.

use crate::trace::TraceError;
use std::sync::{Arc, Mutex, PoisonError};

/// A device, its queue, and what went wrong with it so far.
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// Its adapter.
    pub info: wgpu::AdapterInfo,
    trouble: Arc<Mutex<Option<Trouble>>>,
}

#[derive(Debug, Clone)]
enum Trouble {
    Lost(String),
    Refused(String),
}

impl Gpu {
    /// Opens the fastest adapter. `NoAdapter` where there is none.
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
            Ok(Self { device, queue, info: adapter.get_info(), trouble })
        })
    }

    /// What went wrong, if anything did.
    pub fn check(&self) -> Result<(), TraceError> {
        let trouble = self.trouble.lock().unwrap_or_else(PoisonError::into_inner);
        match trouble.as_ref() {
            None => Ok(()),
            Some(Trouble::Lost(why)) => Err(TraceError::DeviceLost(one_line(why))),
            Some(Trouble::Refused(why)) => Err(TraceError::Driver(one_line(why))),
        }
    }

    /// Submits commands and waits for them.
    pub fn submit(&self, encoder: wgpu::CommandEncoder) -> Result<(), TraceError> {
        self.check()?;
        self.queue.submit([encoder.finish()]);
        self.wait()
    }

    /// Waits for everything submitted.
    pub fn wait(&self) -> Result<(), TraceError> {
        self.check()?;
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|e| TraceError::DeviceLost(one_line(&e.to_string())))?;
        self.check()
    }

    /// A buffer of at least 16 bytes; an error where the device does not allow its size.
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
    place.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(what);
}

fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}
