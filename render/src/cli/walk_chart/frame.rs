//! What is measured of frames.

use super::runs::Method;
use render::image::Image;
use render::metric::Comparison;
use std::fmt::Write;

/// A frame beside its references.
pub(super) struct Frame {
    pub number: u32,
    pub figures: Comparison,
    /// From the frame before; none where that one is not there.
    pub flicker: Option<f64>,
}

/// The frames of a method in a time.
pub(super) struct Measured {
    pub method: &'static Method,
    /// Seconds for a frame that were asked for, and what it took, the share of the fill included.
    pub seconds: f64,
    pub spent: f64,
    pub spp: u32,
    /// 0 without caches.
    pub tau: f64,
    pub frames: Vec<Frame>,
    pub flicker: Option<f64>,
    pub images: Vec<Image>,
}

impl Measured {
    /// Mean of a figure over the frames.
    pub fn mean(&self, figure: impl Fn(&Comparison) -> f64) -> f64 {
        self.frames.iter().map(|f| figure(&f.figures)).sum::<f64>() / self.frames.len().max(1) as f64
    }
}

/// A line for every frame.
pub(super) fn csv(all: &[Measured]) -> String {
    let mut text = String::from("seconds,method,spent,tau,spp,frame,rmse,rel_mse,trimmed,bias,flicker\n");
    for m in all {
        for Frame { number, figures, flicker } in &m.frames {
            let flicker = flicker.map(|x| x.to_string()).unwrap_or_default();
            let Comparison { rmse, rel_mse, trimmed, bias, .. } = figures;
            // Writing to a string does not fail.
            let _ = writeln!(
                text,
                "{},{},{:.4},{},{},{number},{rmse},{rel_mse},{trimmed},{bias},{flicker}",
                m.seconds, m.method.name, m.spent, m.tau, m.spp
            );
        }
    }
    text
}
