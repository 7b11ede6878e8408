//! What is drawn: triangles that a shader makes, into pictures of whole numbers with depth, side by side on one canvas.

use super::device::{Device, GpuError};
use wgpu::{
    BindGroupDescriptor, BindGroupEntry, Buffer, Color, CompareFunction, DepthStencilState, Extent3d, FragmentState,
    LoadOp, Operations, RenderPassColorAttachment, RenderPassDepthStencilAttachment, RenderPassDescriptor,
    RenderPipeline, RenderPipelineDescriptor, ShaderModuleDescriptor, ShaderSource, StoreOp, TexelCopyBufferInfo,
    TexelCopyBufferLayout, Texture, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages, VertexState,
};

/// Whole numbers of 32 bits.
const NUMBERS: TextureFormat = TextureFormat::R32Uint;
const DEPTH: TextureFormat = TextureFormat::Depth32Float;
/// Columns of a canvas come in so many: rows are copied so.
const COLUMNS: u32 = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT / 4;

/// A vertex and a fragment shader, which write one whole number and a depth per pixel: the largest depth stays.
#[derive(Debug)]
pub struct Drawing(RenderPipeline);

/// Pixels to draw into.
#[derive(Debug)]
pub struct Canvas {
    numbers: Texture,
    depth: Texture,
    /// The numbers row by row, once they are drawn; 0 where nothing is.
    pub pixels: Buffer,
    /// Numbers of a row.
    pub pitch: u32,
    height: u32,
}

impl Device {
    /// The shaders of a text that is right, with one entry point each.
    pub fn drawing(&self, source: &str) -> Drawing {
        let source = ShaderSource::Wgsl(source.into());
        let module = &self.device.create_shader_module(ShaderModuleDescriptor { label: None, source });
        let depth_stencil = DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(CompareFunction::Greater),
            stencil: Default::default(),
            bias: Default::default(),
        };
        Drawing(self.device.create_render_pipeline(&RenderPipelineDescriptor {
            label: None,
            layout: None,
            vertex: VertexState { module, entry_point: None, compilation_options: Default::default(), buffers: &[] },
            primitive: Default::default(),
            depth_stencil: Some(depth_stencil),
            multisample: Default::default(),
            fragment: Some(FragmentState {
                module,
                entry_point: None,
                compilation_options: Default::default(),
                targets: &[Some(NUMBERS.into())],
            }),
            multiview_mask: None,
            cache: None,
        }))
    }

    /// Room for a picture at least so wide and exactly so high.
    ///
    /// # Errors
    /// It is larger than the adapter can; `what` it is for is told.
    pub fn canvas(&self, what: &'static str, [width, height]: [u32; 2]) -> Result<Canvas, GpuError> {
        let pitch = width.next_multiple_of(COLUMNS);
        let largest = self.device.limits().max_texture_dimension_2d;
        if pitch.max(height) > largest {
            let bytes = |side: u32| 4 * u64::from(side) * u64::from(side);
            return Err(GpuError::Size { what, bytes: bytes(pitch.max(height)), limit: bytes(largest) });
        }
        let pixels = self.room(what, 4 * u64::from(pitch) * u64::from(height))?;
        let texture = |format, usage| {
            self.device.create_texture(&TextureDescriptor {
                label: None,
                size: Extent3d { width: pitch, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: TextureDimension::D2,
                format,
                usage: TextureUsages::RENDER_ATTACHMENT | usage,
                view_formats: &[],
            })
        };
        let (numbers, depth) = (texture(NUMBERS, TextureUsages::COPY_SRC), texture(DEPTH, TextureUsages::empty()));
        Ok(Canvas { numbers, depth, pixels, pitch, height })
    }

    /// Draws so many vertices once for each place, in squares of `side` pixels whose left upper corners are these, and copies the
    /// numbers to [`Canvas::pixels`]. Buffers are bound in their order; the instance is the place.
    pub fn draw(
        &self,
        drawing: &Drawing,
        buffers: &[&Buffer],
        canvas: &Canvas,
        vertices: u32,
        side: u32,
        places: &[[u32; 2]],
    ) {
        let Drawing(pipeline) = drawing;
        let entries: Vec<_> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        let layout = pipeline.get_bind_group_layout(0);
        let group =
            self.device.create_bind_group(&BindGroupDescriptor { label: None, layout: &layout, entries: &entries });
        let [numbers, depth] = [&canvas.numbers, &canvas.depth].map(|texture| texture.create_view(&Default::default()));
        let color = RenderPassColorAttachment {
            view: &numbers,
            depth_slice: None,
            resolve_target: None,
            ops: Operations { load: LoadOp::Clear(Color::TRANSPARENT), store: StoreOp::Store },
        };
        let depth = RenderPassDepthStencilAttachment {
            view: &depth,
            depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Discard }),
            stencil_ops: None,
        };
        let mut commands = self.device.create_command_encoder(&Default::default());
        {
            let mut pass = commands.begin_render_pass(&RenderPassDescriptor {
                color_attachments: &[Some(color)],
                depth_stencil_attachment: Some(depth),
                ..Default::default()
            });
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &group, &[]);
            for (place, [x, y]) in (0..).zip(places) {
                let [left, top, size] = [*x, *y, side].map(|pixels| pixels as f32);
                pass.set_viewport(left, top, size, size, 0.0, 1.0);
                pass.set_scissor_rect(*x, *y, side, side);
                pass.draw(0..vertices, place..place + 1);
            }
        }
        let layout = TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * canvas.pitch), rows_per_image: None };
        let to = TexelCopyBufferInfo { buffer: &canvas.pixels, layout };
        let extent = Extent3d { width: canvas.pitch, height: canvas.height, depth_or_array_layers: 1 };
        commands.copy_texture_to_buffer(canvas.numbers.as_image_copy(), to, extent);
        self.queue.submit([commands.finish()]);
    }
}
