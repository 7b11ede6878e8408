//! Zonal integrals at the exponents of a family.

use super::Plan;
use crate::zonal::{pack, scale, tabulate};
use brdf_tables::family::{Store, ZonalSlices};

/// Rows and columns: what the broadest lobes need.
const SIZE: (usize, usize) = (48, 32);

/// The slices, in one scale.
pub(super) fn fit(plan: &Plan) -> (Store, Vec<String>) {
    let slice = |n: &f64| tabulate(&plan.kin.member([*n; 2]), SIZE.0, SIZE.1).expect("a radial lobe");
    let values: Vec<(f64, f64)> = plan.lattice.widths.iter().flat_map(slice).collect();
    let scale = scale(&values);
    let store = Store::Zonal(ZonalSlices::new(SIZE.0, SIZE.1, pack(&values, scale), scale));
    let exponents = plan.lattice.widths.len();
    (store, vec![format!("zonal: {} × {} pairs of (T_P, T_R), 16 bits each, at {exponents} exponents", SIZE.0, SIZE.1)])
}
