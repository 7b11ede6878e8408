// What both shaders are told.

struct Settings {
    // Pixels along an edge of the square, and squares along a row of the canvas.
    side: u32,
    columns: u32,
    // Numbers of a row of the canvas.
    pitch: u32,
    // Height of the square over half of its width.
    height: f32,
    // Length that depths are told in.
    scale: f32,
}
