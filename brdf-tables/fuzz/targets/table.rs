//! A table file with any content under a right checksum: refused, or a table whose every value is finite and not
//! negative, and which is written as it was read.
#![no_main]

use brdf_tables::batch::CapBatch;
use brdf_tables::cap::Cap;
use brdf_tables::frame::spherical;
use brdf_tables::table::Table;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let body = &data[..data.len().saturating_sub(4)];
    let bytes = [body, &crc32fast::hash(body).to_le_bytes()].concat();
    let Ok(table) = Table::from_bytes(&bytes) else { return };
    let mut caps = CapBatch::with_capacity(4);
    let eyes = [spherical(0.0, 0.0), spherical(0.9, 4.0), spherical(1.57, 1.0)];
    for (theta, phi, half_angle) in [(0.0, 0.0, 0.01), (0.8, 1.0, 0.3), (1.5, 6.0, 1.2), (1.57, 3.0, 1.57)] {
        let cap = Cap::with_half_angle(theta, phi, half_angle).expect("a cap");
        caps.push_nearest(cap.axis().as_vec3(), cap.solid_angle() as f32);
        for eye in eyes {
            let values = table.value(&cap, eye);
            assert!(values.iter().all(|x| x.is_finite() && *x >= 0.0), "{values:?}");
        }
        assert!(table.support(&cap).is_finite());
        assert!(table.cell_errors(&cap).to_array().iter().all(|e| e.is_finite()));
    }
    for eye in eyes {
        let mut values = [0.0; 4];
        table.specular_values(&caps, eye.as_vec3(), &mut values);
        assert!(values.iter().all(|x| x.is_finite() && *x >= 0.0), "{values:?}");
    }
    assert_eq!(table.to_bytes().expect("written"), bytes);
});
