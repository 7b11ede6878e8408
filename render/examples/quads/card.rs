//! An adapter that draws as well as computes.

use bytemuck::NoUninit;
use render::integrator::cached::card::irradiance_shader;
use std::error::Error;
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::*;

/// Precisions of the picture that is blended into.
const FORMATS: [TextureFormat; 2] = [TextureFormat::Rgba32Float, TextureFormat::Rgba16Float];

/// The adapter and what it runs.
pub struct Card {
    pub device: Device,
    pub queue: Queue,
    pub name: String,
    pub tiles: ComputePipeline,
    /// By the format of the picture that they are blended into, those that it can: the finest first.
    pub quads: Vec<(TextureFormat, RenderPipeline)>,
}

impl Card {
    pub fn open() -> Result<Self, Box<dyn Error>> {
        let instance = Instance::new(InstanceDescriptor {
            backends: Backends::VULKAN,
            ..InstanceDescriptor::new_without_display_handle()
        });
        let adapter = pollster::block_on(instance.request_adapter(&RequestAdapterOptions::default()))?;
        let required_features = adapter.features() & Features::FLOAT32_BLENDABLE;
        let descriptor =
            DeviceDescriptor { required_limits: adapter.limits(), required_features, ..Default::default() };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))?;
        let compile = |text: String| {
            device.create_shader_module(ShaderModuleDescriptor { label: None, source: ShaderSource::Wgsl(text.into()) })
        };
        let tiles = device.create_compute_pipeline(&ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &compile(irradiance_shader()),
            entry_point: None,
            compilation_options: Default::default(),
            cache: None,
        });
        let module = compile(irradiance_shader() + include_str!("quads.wgsl"));
        let add = BlendComponent {
            src_factor: BlendFactor::One,
            dst_factor: BlendFactor::One,
            operation: BlendOperation::Add,
        };
        let quads = |format| {
            let target = ColorTargetState {
                format,
                blend: Some(BlendState { color: add, alpha: add }),
                write_mask: ColorWrites::ALL,
            };
            device.create_render_pipeline(&RenderPipelineDescriptor {
                label: None,
                layout: None,
                vertex: VertexState {
                    module: &module,
                    entry_point: None,
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: PrimitiveState { topology: PrimitiveTopology::TriangleStrip, ..Default::default() },
                depth_stencil: None,
                multisample: Default::default(),
                fragment: Some(FragmentState {
                    module: &module,
                    entry_point: None,
                    compilation_options: Default::default(),
                    targets: &[Some(target)],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        let formats = FORMATS.into_iter().skip(usize::from(required_features.is_empty()));
        let quads = formats.map(|format| (format, quads(format))).collect();
        Ok(Self { name: adapter.get_info().name, device, queue, tiles, quads })
    }

    /// A storage buffer with these numbers.
    pub fn upload<T: NoUninit>(&self, numbers: &[T]) -> Buffer {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let contents = if numbers.is_empty() { &[0; 4] } else { bytemuck::cast_slice(numbers) };
        self.device.create_buffer_init(&BufferInitDescriptor { label: None, contents, usage })
    }

    /// Buffers bound at these places.
    pub fn bind(&self, layout: &BindGroupLayout, buffers: &[(u32, &Buffer)]) -> BindGroup {
        let entries: Vec<_> = buffers
            .iter()
            .map(|(binding, buffer)| BindGroupEntry { binding: *binding, resource: buffer.as_entire_binding() })
            .collect();
        self.device.create_bind_group(&BindGroupDescriptor { label: None, layout, entries: &entries })
    }

    /// Runs commands to their end.
    pub fn submit(&self, commands: CommandEncoder) -> Result<(), Box<dyn Error>> {
        self.queue.submit([commands.finish()]);
        self.device.poll(PollType::wait_indefinitely())?;
        Ok(())
    }

    /// The bytes of a buffer of so many, which `copy` fills.
    pub fn read(&self, bytes: u64, copy: impl FnOnce(&mut CommandEncoder, &Buffer)) -> Result<Vec<u8>, Box<dyn Error>> {
        let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
        let staging =
            self.device.create_buffer(&BufferDescriptor { label: None, size: bytes, usage, mapped_at_creation: false });
        let mut commands = self.device.create_command_encoder(&Default::default());
        copy(&mut commands, &staging);
        self.submit(commands)?;
        staging.map_async(MapMode::Read, .., |_| ());
        self.device.poll(PollType::wait_indefinitely())?;
        Ok(staging.get_mapped_range(..)?.to_vec())
    }
}
