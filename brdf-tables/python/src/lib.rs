//! The Python module `brdf_tables._native`; its types and documentation are in `python/brdf_tables/_native.pyi`.
//!
//! Inputs are numpy arrays that are read where they lie, or what numpy makes an array of; the interpreter's lock is released
//! while numbers are computed.

mod arrays;
mod error;
mod fit;
mod integrate;
mod material;
mod question;
mod table;

/// Mean BRDFs over spherical caps, looked up from small fitted tables.
#[pyo3::pymodule(name = "_native")]
mod native {
    #[pymodule_export]
    use crate::error::BrdfTablesError;
    #[pymodule_export]
    use crate::fit::fit;
    #[pymodule_export]
    use crate::integrate::{integrate, monte_carlo, projected_solid_angle};
    #[pymodule_export]
    use crate::material::Material;
    #[pymodule_export]
    use crate::table::{Table, families};
    #[pymodule_export]
    #[expect(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
