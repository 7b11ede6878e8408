//! The optimisers on problems with known answers, and on hostile ones.

/// Test problems: sums of cosine lobes, and the classics of the literature.
#[path = "solvers/classic.rs"]
mod classic;
#[path = "solvers/lobes.rs"]
mod lobes;

/// Every solver: what it must find, and what it must never do.
#[path = "solvers/contract.rs"]
mod contract;
#[path = "solvers/hostile.rs"]
mod hostile;
#[path = "solvers/jacobians.rs"]
mod jacobians;
/// Levenberg–Marquardt against another implementation.
#[path = "solvers/oracle.rs"]
mod oracle;
#[path = "solvers/recovery.rs"]
mod recovery;
