//! A file of measured data with any content: refused in one line, or a function whose values are finite and not negative, and
//! a material that has them. The first byte says which format.
#![no_main]

use brdf_tables::brdf::Brdf;
use brdf_tables::frame::spherical;
use brdf_tables::measured::{Format, Reading};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let Some((&kind, bytes)) = data.split_first() else { return };
    let format = Format::ALL[usize::from(kind) % Format::ALL.len()];
    let reading = match Reading::from_bytes(format, bytes) {
        Ok(reading) => reading,
        Err(error) => {
            let line = error.to_string();
            assert!(!line.contains(['\n', '\r']), "{line:?}");
            return;
        }
    };
    for (to, from) in [((0.0, 0.0), (0.0, 0.0)), ((0.7, 1.0), (0.7, 4.14)), ((1.5, 2.0), (0.2, 5.0))] {
        let (wi, wo) = (spherical(to.0, to.1), spherical(from.0, from.1));
        let values = reading.source.rgb(wi, wo).unwrap_or_default();
        assert!(values.iter().all(|x| x.is_finite() && *x >= 0.0), "{values:?}");
    }
    // A lattice takes a second: of few inputs only.
    if bytes.len() % 64 != 7 {
        return;
    }
    match reading.material("fuzz") {
        Ok(built) => {
            let (wi, wo) = (spherical(0.4, 0.0), spherical(0.5, 2.0));
            let values = built.material.eval(wi, wo);
            assert!(values.iter().all(|x| x.is_finite() && *x >= 0.0), "{values:?}");
            let specular = built.material.specular.expect("values");
            assert!(specular.pdf(wi, wo).is_finite());
        }
        Err(error) => assert!(!error.to_string().contains('\n')),
    }
});
