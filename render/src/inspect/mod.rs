//! Records under the lens: pictures and numbers (eas-2015, Figs. 5–7).

#[cfg(feature = "cli")]
pub mod chart;
pub mod disk;
pub mod overlay;

use crate::frame::Frame;
use crate::hemisphere::{GatherSample, hemisphere_directions};
use crate::record::eas::{EasRecord, Estimator};
use crate::record::{
    Albedo, Centroid, Cut, CutSettings, Receiver, Record, Reflector, Scratch, Tree, cut, global_error, reflect,
};
use crate::scene::Rgb;
use core::f32::consts::FRAC_1_PI;
use glam::Vec3A;
use rayon::prelude::*;

/// Directions over the hemisphere that errors are measured in.
pub const DIRECTIONS: usize = 1024;

/// A record is read at its own point: frame, material, and what reflects.
#[derive(Clone, Copy, Debug)]
pub struct Place<'a> {
    /// Position, world space.
    pub position: Vec3A,
    /// Frame of the hemisphere.
    pub frame: Frame,
    /// Table and colours.
    pub reflector: Reflector<'a>,
    /// Albedo of the specular part.
    pub albedo: &'a Albedo,
}

/// A record with what it was made of.
#[derive(Clone, Debug)]
pub struct Compressed {
    /// The tree over the samples.
    pub tree: Tree,
    /// The cut through it.
    pub cut: Cut,
    /// The sources.
    pub record: EasRecord,
    /// How they are summed.
    pub estimator: Estimator,
}

/// The tree over the samples, as the estimator builds it.
pub fn tree(samples: &[GatherSample], estimator: Estimator) -> Tree {
    let centroid = match estimator {
        Estimator::Paper => Centroid::Position,
        Estimator::Improved => Centroid::Direction,
    };
    Tree::new(&mut samples.to_vec(), 1, centroid)
}

impl Compressed {
    /// Cuts a tree over #D directions of the hemisphere.
    pub fn new(place: &Place, tree: Tree, estimator: Estimator, settings: &CutSettings, directions: usize) -> Self {
        let cut = cut(&tree, &place.reflector, &hemisphere_directions(directions), settings);
        let record = EasRecord::new(place.position, &place.frame, 0, &tree, &cut, estimator);
        Self { tree, cut, record, estimator }
    }

    /// Radiance reflected into local directions.
    pub fn reflected(&self, place: &Place, directions: &[Vec3A]) -> Vec<Rgb> {
        reflected(&self.record, place, self.estimator, directions)
    }
}

/// Radiance that a record reflects into local directions at its own point.
pub fn reflected(record: &EasRecord, place: &Place, estimator: Estimator, directions: &[Vec3A]) -> Vec<Rgb> {
    let of = |scratch: &mut Scratch, wo: &Vec3A| {
        let at = Receiver { position: place.position, frame: place.frame, wo: *wo };
        let part = reflect(record, &at, &place.reflector, place.albedo, estimator, scratch);
        place.reflector.diffuse * FRAC_1_PI * part.irradiance + part.specular
    };
    directions.par_iter().map_init(Scratch::default, of).collect()
}

/// Radiance reflected into local directions, exactly: Σ L f_r(ωi, ωo) cosθ ΔΩ over all samples. `progress` is told the
/// share of the work done.
pub fn exact(
    samples: &[GatherSample],
    reflector: &Reflector,
    directions: &[Vec3A],
    progress: &(dyn Fn(f64) + Sync),
) -> Vec<Rgb> {
    let lit: Vec<_> = samples.iter().filter(|s| s.radiance != Rgb::ZERO).collect();
    let diffuse = reflector.diffuse * FRAC_1_PI * lit.iter().map(|s| s.irradiance()).sum::<Rgb>();
    let done = core::sync::atomic::AtomicUsize::new(0);
    let of = |wo: &Vec3A| {
        let sum: Rgb = lit.iter().map(|s| s.irradiance() * reflector.specular(s.direction, *wo)).sum();
        let n = done.fetch_add(1, core::sync::atomic::Ordering::Relaxed);
        progress(n as f64 / directions.len() as f64);
        diffuse + sum
    };
    directions.par_iter().map(of).collect()
}

/// Error of records of growing size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Most EAS that the cut was allowed.
    pub max_eas: usize,
    /// EAS of the record.
    pub eas: usize,
    /// Bytes of the record.
    pub bytes: usize,
    /// RMSE over mean of the reflected radiance, luminance (eq. 13), over all directions.
    pub error: f32,
}

/// Bounds on #EAS that are measured.
pub const SWEEP: [usize; 7] = [7, 15, 25, 50, 100, 200, 400];

/// Error against #EAS for one tree (Fig. 7, right): cuts bounded by number alone, against the exact sum.
pub fn sweep(
    place: &Place,
    tree: &Tree,
    estimator: Estimator,
    cut_directions: usize,
    directions: &[Vec3A],
    exact: &[Rgb],
) -> Vec<Measured> {
    SWEEP
        .into_iter()
        .map(|max_eas| {
            let settings = CutSettings { tolerance: 0.0, max_eas };
            let made = Compressed::new(place, tree.clone(), estimator, &settings, cut_directions);
            measure(&made.record, place, estimator, max_eas, directions, exact)
        })
        .collect()
}

/// Error of one record against the exact sum.
pub fn measure(
    record: &EasRecord,
    place: &Place,
    estimator: Estimator,
    max_eas: usize,
    directions: &[Vec3A],
    exact: &[Rgb],
) -> Measured {
    let error = global_error(&reflected(record, place, estimator, directions), exact);
    Measured { max_eas, eas: record.sources.len(), bytes: record.bytes(), error }
}

/// Both curves as CSV, a line per bound.
pub fn csv(paper: &[Measured], improved: &[Measured]) -> String {
    let mut text =
        String::from("max_eas,eas_paper,bytes_paper,error_paper,eas_improved,bytes_improved,error_improved\n");
    for (p, i) in paper.iter().zip(improved) {
        text += &format!("{},{},{},{:.6},{},{},{:.6}\n", p.max_eas, p.eas, p.bytes, p.error, i.eas, i.bytes, i.error);
    }
    text
}
