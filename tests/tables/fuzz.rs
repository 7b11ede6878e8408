//! Random bytes and random damage: an error or a table, never a panic.

use crate::hostile::{sealed, tables};
use brdf_tables::cap::Cap;
use brdf_tables::frame::spherical;
use brdf_tables::table::Table;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn noise_is_refused(bytes in prop::collection::vec(any::<u8>(), 0..400), framed in any::<bool>(), size in 0u32..400) {
        let frame = [b"BURNISH\n".as_slice(), &1u32.to_le_bytes(), &size.to_le_bytes(), &bytes, &[0; 4]].concat();
        let bytes = if framed { sealed(frame) } else { bytes };
        prop_assert!(Table::from_bytes(&bytes).is_err());
    }

    /// A few bytes anywhere, pieces cut out or doubled, the checksum in order.
    #[test]
    fn damage_is_refused_or_harmless(
        which in 0usize..5,
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        (from, to, doubled) in (any::<prop::sample::Index>(), any::<prop::sample::Index>(), any::<Option<bool>>()),
    ) {
        let mut bytes = tables()[which].to_bytes().unwrap();
        let end = bytes.len() - 4;
        for (at, value) in edits {
            bytes[at.index(end)] = value;
        }
        let (from, to) = (from.index(end).min(to.index(end)), from.index(end).max(to.index(end)));
        match doubled {
            Some(true) => {
                let piece = bytes[from..to].to_vec();
                bytes.splice(from..from, piece);
            }
            Some(false) => drop(bytes.drain(from..to)),
            None => {}
        }
        if let Ok(table) = Table::from_bytes(&sealed(bytes)) {
            let cap = Cap::with_half_angle(0.8, 1.0, 0.3).unwrap();
            let values = table.value(&cap, spherical(0.9, 4.0));
            prop_assert!(values.iter().all(|x| x.is_finite() && *x >= 0.0), "{:?}", values);
        }
    }
}
