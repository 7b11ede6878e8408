//! The path tracer against what is known to be true:
//! closed forms, its plain twin, itself on other numbers of threads, converged images of another renderer.

#[path = "render_truth/analytic.rs"]
mod analytic;
#[path = "support/lamp_shapes.rs"]
mod lamp_shapes;
#[path = "render_truth/lamps.rs"]
mod lamps;
#[path = "render_truth/leaks.rs"]
mod leaks;
#[path = "support/pieces.rs"]
mod pieces;
#[path = "render_truth/references.rs"]
mod references;
#[path = "render_truth/scenes.rs"]
mod scenes;
#[path = "render_truth/twin.rs"]
mod twin;
