//! What the commands of this workspace share: usage, numbers and errors in one line, files that are written whole.

pub mod number;
pub mod output;
mod pending;
mod report;
pub mod rows;
mod usage;

pub use pending::{Pending, watch};
pub use report::one_line;
pub use usage::parse;
