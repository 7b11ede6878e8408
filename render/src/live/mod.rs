//! A live view: a scene that is walked through while its caches fill.
//!
//! A [`Session`] draws one frame after the other, on the thread that runs it, and knows no network: orders come over a [`Desk`] that any
//! thread may write to, frames go to an [`Audience`]. While the camera moves, frames are as large as the time allows, and records are made
//! for a bounded time before each. When it stands still, the caches are filled for what it sees, and the picture is refined until it is the
//! one that `render image` makes with the same settings.

mod cached;
mod canvas;
mod clock;
mod command;
mod desk;
mod navigator;
mod orders;
mod recorder;
mod session;
mod status;
mod traced;

pub use command::{Command, Menu, Shown, TAUS};
pub use desk::{Answer, Desk};
pub use navigator::Navigator;
pub use session::{Audience, Engine, Frame, Options, Prepare, Session};
pub use status::{Stage, Status};
