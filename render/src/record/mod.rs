//! What a cache keeps at a point: equivalent area light sources or harmonics for glossy surfaces, irradiance for diffuse ones.

mod cell;
mod cut;
pub mod eas;
mod guide;
pub mod harmonics;
mod hessian;
pub mod irradiance;
mod moved;
mod reflector;
mod schlick;
mod translate;
mod tree;
mod zone;

pub use cell::{Cell, cap_half_angle};
pub use cut::{Cut, CutSettings, cut, global_error};
pub use guide::{Guide, View, hemisphere_directions};
pub use hessian::Hessian;
pub use reflector::{Albedo, Reflector};
pub use translate::{Receiver, Reflected, Scratch, reflect};
pub use tree::{Centroid, Node, Tree, luminance};
pub use zone::{Record, Zone};
