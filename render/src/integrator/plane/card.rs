//! Hemispheres rasterised by a graphics card, many in one submission.

use super::{SurfaceLight, Viewpoint};
use crate::gpu::{self, Canvas, Device, Drawing, GpuError, Program};
use crate::hemisphere::Plane;
use crate::scene::Rgb;
use crate::world::World;
use glam::Vec3A;
use wgpu::Buffer;

/// Squares along an edge of the canvas: so many squared are drawn at once. A driver may take seconds of drawing for something that hangs.
const SQUARES: u32 = 8;
/// Threads that sum a square: a power of two.
const THREADS: u32 = 64;

const DRAW: &str = concat!(include_str!("settings.wgsl"), include_str!("draw.wgsl"));
const SUM: &str = concat!(include_str!("settings.wgsl"), include_str!("sum.wgsl"));

/// A scene on a graphics card, ready to be drawn from many points.
pub struct Rasterizer {
    device: &'static Device,
    drawing: Drawing,
    sum: Program,
    triangles: Buffer,
    light: Buffer,
    vertices: u32,
    /// Size of the scene.
    scale: f32,
}

/// What is the same for all points.
struct Task {
    canvas: Canvas,
    settings: Buffer,
    weights: Buffer,
    sums: Buffer,
    side: u32,
}

type Row = [u32; 4];

fn row(v: Vec3A, last: u32) -> Row {
    let [x, y, z] = v.to_array().map(f32::to_bits);
    [x, y, z, last]
}

impl Rasterizer {
    /// Brings the surfaces of a scene and their light to the card.
    ///
    /// # Errors
    /// There is no adapter, or it has no room.
    pub fn new(world: &World, light: &SurfaceLight) -> Result<Self, GpuError> {
        let device = gpu::shared()?;
        let of_patch = |patch: &super::patch::Patch| {
            let back = patch.pieces();
            patch
                .triangles()
                .into_iter()
                .map(move |([a, b, c], first, edge)| [row(a, first), row(b, edge), row(c, back)])
        };
        let triangles: Vec<[Row; 3]> = light.patches.iter().flat_map(of_patch).collect();
        let (min, max) = world.bounds();
        let sum = SUM.replace("{{THREADS}}", &format!("{THREADS}u"));
        Ok(Self {
            device,
            drawing: device.drawing(DRAW),
            sum: device.program(&sum),
            vertices: 3 * triangles.len() as u32,
            triangles: device.upload("the triangles of the scene", &triangles)?,
            light: device.upload("the light of surfaces", &light.light)?,
            scale: (max - min).max(Vec3A::ZERO).length().max(f32::MIN_POSITIVE),
        })
    }

    /// What draws: the adapter's name.
    pub fn name(&self) -> &str {
        self.device.name()
    }

    /// As [`SurfaceLight::pictures`].
    ///
    /// # Errors
    /// The card was lost or has no room.
    pub fn pictures(&self, viewpoints: &[Viewpoint], plane: &Plane) -> Result<Vec<Vec<u32>>, GpuError> {
        let task = self.task(plane)?;
        let (side, pitch) = (task.side as usize, task.canvas.pitch as usize);
        let mut pictures = Vec::with_capacity(viewpoints.len());
        for some in viewpoints.chunks((SQUARES * SQUARES) as usize) {
            let corners = self.draw(&task, some)?;
            let pixels: Vec<u32> = self.device.read(&task.canvas.pixels)?;
            pictures.extend(corners.iter().map(|[x, y]| {
                let rows = (0..side).map(|row| *x as usize + (*y as usize + row) * pitch);
                rows.flat_map(|first| &pixels[first..first + side]).copied().collect()
            }));
        }
        Ok(pictures)
    }

    /// As [`SurfaceLight::irradiances`].
    ///
    /// # Errors
    /// The card was lost or has no room.
    pub fn irradiances(&self, viewpoints: &[Viewpoint], plane: &Plane) -> Result<Vec<Rgb>, GpuError> {
        let task = self.task(plane)?;
        let mut irradiances = Vec::with_capacity(viewpoints.len());
        for some in viewpoints.chunks((SQUARES * SQUARES) as usize) {
            self.draw(&task, some)?;
            let bound = [&task.settings, &task.canvas.pixels, &self.light, &task.weights, &task.sums];
            self.device.run(&self.sum, &bound, [some.len() as u32, 1, 1]);
            let sums: Vec<[f32; 4]> = self.device.read(&task.sums)?;
            irradiances.extend(sums[..some.len()].iter().map(|sum| Rgb::from_slice(sum)));
        }
        Ok(irradiances)
    }

    fn task(&self, plane: &Plane) -> Result<Task, GpuError> {
        let (device, side) = (self.device, plane.side());
        let edge = side.saturating_mul(SQUARES);
        let canvas = device.canvas("the cells of planes", [edge, edge])?;
        let settings = [side, SQUARES, canvas.pitch, (plane.height() as f32).to_bits(), self.scale.to_bits()];
        Ok(Task {
            settings: device.upload("the settings of planes", &settings)?,
            weights: device.upload("the weights of cells", &plane.weights())?,
            sums: device.room("irradiances", 16 * u64::from(SQUARES * SQUARES))?,
            canvas,
            side,
        })
    }

    /// Draws what is seen from some points, no more than there are squares, and tells their left upper corners.
    fn draw(&self, task: &Task, viewpoints: &[Viewpoint]) -> Result<Vec<[u32; 2]>, GpuError> {
        let rows: Vec<[Row; 4]> = viewpoints
            .iter()
            .map(|Viewpoint { eye, frame, offset }| {
                let [x, y, z] = frame.axes().map(|axis| row(axis, 0));
                [row(*eye, offset.max(f32::MIN_POSITIVE).to_bits()), x, y, z]
            })
            .collect();
        let rows = self.device.upload("the points of planes", &rows)?;
        let corners: Vec<_> =
            (0..viewpoints.len() as u32).map(|i| [i % SQUARES, i / SQUARES].map(|square| square * task.side)).collect();
        let bound = [&task.settings, &rows, &self.triangles];
        self.device.draw(&self.drawing, &bound, &task.canvas, self.vertices, task.side, &corners);
        Ok(corners)
    }
}
