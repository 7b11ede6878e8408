//! A graphics card, or what stands in for one, and the little that is asked of it: buffers, compute shaders, numbers back.

use bytemuck::{NoUninit, Pod};
use std::sync::{Arc, OnceLock};
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{
    BindGroupDescriptor, BindGroupEntry, Buffer, BufferDescriptor, BufferUsages, CommandEncoder, ComputePipeline,
    ComputePipelineDescriptor, DeviceDescriptor, Instance, InstanceDescriptor, InstanceFlags, MapMode,
    PipelineCompilationOptions, PollType, PowerPreference, RequestAdapterOptions, ShaderModuleDescriptor, ShaderSource,
};

/// Why nothing is computed on a graphics card.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// There is none that Vulkan knows.
    #[error("no graphics adapter with Vulkan was found; a software one comes with Mesa (mesa-vulkan-drivers)")]
    NoAdapter,
    /// It gives no access.
    #[error("the graphics adapter {adapter} cannot be used: {reason}")]
    Device {
        /// Its name.
        adapter: String,
        /// What it says.
        reason: String,
    },
    /// A buffer is larger than it can bind.
    #[error("{what} takes {bytes} bytes, the graphics adapter binds {limit} at once")]
    Size {
        /// What was to be in the buffer.
        what: &'static str,
        /// Its size.
        bytes: u64,
        /// The largest size.
        limit: u64,
    },
    /// It was lost, or ran out of memory.
    #[error("the graphics adapter {adapter} failed: {reason}")]
    Lost {
        /// Its name.
        adapter: String,
        /// What it says.
        reason: String,
    },
}

/// An adapter in use.
#[derive(Debug)]
pub struct Device {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    name: String,
    limit: u64,
    /// The first thing that the adapter could not do, if there was any.
    failed: Arc<OnceLock<String>>,
}

/// A compute shader, ready to run.
#[derive(Debug)]
pub struct Program(ComputePipeline);

impl Device {
    /// The fastest adapter that there is.
    ///
    /// # Errors
    /// There is none, or it cannot be used.
    pub fn open() -> Result<Self, GpuError> {
        let instance = Instance::new(InstanceDescriptor {
            backends: wgpu::Backends::VULKAN,
            flags: InstanceFlags::empty(),
            ..InstanceDescriptor::new_without_display_handle()
        });
        let options =
            RequestAdapterOptions { power_preference: PowerPreference::HighPerformance, ..Default::default() };
        let adapter = pollster::block_on(instance.request_adapter(&options)).map_err(|_| GpuError::NoAdapter)?;
        let name = adapter.get_info().name;
        let limits = adapter.limits();
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let descriptor = DeviceDescriptor { required_limits: limits, ..Default::default() };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|e| GpuError::Device { adapter: name.clone(), reason: e.to_string() })?;
        // Without this, memory that is not there would end the program.
        let failed = Arc::new(OnceLock::new());
        let noted = Arc::clone(&failed);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| drop(noted.set(error.to_string()))));
        Ok(Self { device, queue, name, limit, failed })
    }

    /// What the adapter calls itself.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The largest buffer that can be bound, bytes.
    pub fn limit(&self) -> u64 {
        self.limit
    }

    /// A compute shader with one entry point, of a text that is right.
    pub fn program(&self, source: &str) -> Program {
        let source = ShaderSource::Wgsl(source.into());
        let module = self.device.create_shader_module(ShaderModuleDescriptor { label: None, source });
        Program(self.device.create_compute_pipeline(&ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: None,
            // What a group shares is written before it is read.
            compilation_options: PipelineCompilationOptions {
                zero_initialize_workgroup_memory: false,
                ..Default::default()
            },
            cache: None,
        }))
    }

    fn check(&self, what: &'static str, bytes: u64) -> Result<(), GpuError> {
        let limit = self.limit;
        if bytes > limit { Err(GpuError::Size { what, bytes, limit }) } else { Ok(()) }
    }

    /// A storage buffer that holds some numbers.
    ///
    /// # Errors
    /// Too many; `what` they are is told.
    pub fn upload<T: NoUninit>(&self, what: &'static str, numbers: &[T]) -> Result<Buffer, GpuError> {
        self.check(what, size_of_val(numbers) as u64)?;
        // A buffer has at least one word.
        let contents = if numbers.is_empty() { &[0; 4] } else { bytemuck::cast_slice(numbers) };
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        Ok(self.device.create_buffer_init(&BufferInitDescriptor { label: Some(what), contents, usage }))
    }

    /// A storage buffer of so many bytes, zero at first, that can be read back.
    ///
    /// # Errors
    /// Too many.
    pub fn room(&self, what: &'static str, bytes: u64) -> Result<Buffer, GpuError> {
        self.check(what, bytes)?;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let (size, mapped_at_creation) = (bytes.max(4), false);
        Ok(self.device.create_buffer(&BufferDescriptor { label: Some(what), size, usage, mapped_at_creation }))
    }

    /// Runs a program in so many groups on buffers that are bound in their order.
    pub fn run(&self, program: &Program, buffers: &[&Buffer], groups: [u32; 3]) {
        let mut commands = self.device.create_command_encoder(&Default::default());
        self.add(&mut commands, program, buffers, groups);
        self.queue.submit([commands.finish()]);
    }

    fn add(&self, commands: &mut CommandEncoder, Program(program): &Program, buffers: &[&Buffer], groups: [u32; 3]) {
        let entries: Vec<_> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        let layout = program.get_bind_group_layout(0);
        let group =
            self.device.create_bind_group(&BindGroupDescriptor { label: None, layout: &layout, entries: &entries });
        let mut pass = commands.begin_compute_pass(&Default::default());
        pass.set_pipeline(program);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(groups[0], groups[1], groups[2]);
    }

    /// Waits for all that was asked for, and gives what a buffer of [`Device::room`] holds.
    ///
    /// # Errors
    /// The adapter was lost, or could not do something since it was opened.
    pub fn read<T: Pod>(&self, buffer: &Buffer) -> Result<Vec<T>, GpuError> {
        let lost = |reason: String| GpuError::Lost { adapter: self.name.clone(), reason };
        let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
        let (size, mapped_at_creation) = (buffer.size(), false);
        let staging = self.device.create_buffer(&BufferDescriptor { label: None, size, usage, mapped_at_creation });
        let mut commands = self.device.create_command_encoder(&Default::default());
        commands.copy_buffer_to_buffer(buffer, 0, &staging, 0, size);
        self.queue.submit([commands.finish()]);
        staging.map_async(MapMode::Read, .., |_| ());
        self.device.poll(PollType::wait_indefinitely()).map_err(|e| lost(e.to_string()))?;
        if let Some(reason) = self.failed.get() {
            return Err(lost(reason.clone()));
        }
        let mapped = staging.get_mapped_range(..).map_err(|e| lost(e.to_string()))?;
        Ok(bytemuck::pod_collect_to_vec(&mapped[..]))
    }
}
