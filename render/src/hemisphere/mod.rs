//! The hemisphere of a record before there is one: its cells, how they follow what is looked at, and the light sampled in them.

mod cell;
mod gather;
mod guide;
mod plane;

pub(crate) use cell::MAX_CHILDREN;
pub use cell::{Cell, cap_half_angle};
pub use gather::{GatherSample, Incident, gather_cells, gather_cells_uniform, gather_uniform, nearest};
pub use guide::{Guide, View, hemisphere_directions, view_directions};
pub use plane::{Border, Plane};
