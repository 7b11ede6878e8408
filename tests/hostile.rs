//! Tables of every representation as bytes, and ways to damage them; shared by two test binaries.

use brdf_tables::axis::Axes;
use brdf_tables::brdf::{Distribution, Fresnel, Microfacet, Phong, Specular};
use brdf_tables::cubature::{Cubature, Node};
use brdf_tables::errors::{Errors, Summary};
use brdf_tables::lobe::Lobe;
use brdf_tables::lobes::Lobes;
use brdf_tables::material::Material;
use brdf_tables::paper::Paper;
use brdf_tables::table::{CellInfo, Header, Representation, Table};
use glam::DVec3;

/// CRC-32 (IEEE 802.3), bit by bit: what `tables/README.md` says, without the library that writes it.
pub fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg()))
    })
}

/// The same bytes with the checksum that belongs to them.
pub fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let end = bytes.len().saturating_sub(4);
    bytes.truncate(end);
    let crc = crc32(&bytes);
    bytes.extend(crc.to_le_bytes());
    bytes
}

/// Bytes of the header.
pub fn header_range(bytes: &[u8]) -> core::ops::Range<usize> {
    16..16 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize
}

/// A table with such a header as the fitter writes.
pub fn table(specular: Option<Specular>, representation: Representation) -> Table {
    let axes = Axes { theta: 3, phi: 1, omega: 2, sharpness: 20.0, stretch: 0.5 };
    let error = Errors { rmse_hemi: 1e-4, rmse_lobe: 1e-3, l1: 2e-3, max: 3e-3, albedo: 4e-3 };
    let summary = Summary { caps: 5, median: error, p95: error, worst: error };
    let header = Header {
        material: Material { kd: [0.1, 0.2, 0.3], ks: [0.5; 3], specular },
        creator: "tests".into(),
        command: "fitter fit α".into(),
        seed: 7,
        tolerance: 0.003,
        promise: [0.003, 0.0075, 0.015],
        notes: vec!["one".into(), "two".into()],
        at_nodes: summary,
        off_nodes: summary,
        clipped: summary,
    };
    let cells =
        if specular.is_some() { vec![CellInfo { errors: error, support: 1.0 }; axes.len()] } else { Vec::new() };
    Table { header, representation, axes, cells }
}

/// One small table per representation.
pub fn tables() -> Vec<Table> {
    let phong = Specular::Phong(Phong { exponent: 20.0 });
    let distribution = Distribution::Ggx;
    let ggx = Specular::Microfacet(Microfacet { distribution, alpha_x: 0.2, alpha_y: 0.3, fresnel: Fresnel::None });
    let axes = Axes { theta: 3, phi: 2, omega: 3, sharpness: 25.0, stretch: 1.0 };
    let lobe = |i: usize| Lobe { axis: DVec3::Z, amplitude: 1.0 + i as f64, exponent: 20.0 };
    let cells: Vec<Vec<Lobe>> = (0..axes.len()).map(|i| vec![lobe(i), lobe(1)]).collect();
    vec![
        table(None, Representation::Diffuse),
        table(Some(phong), Representation::Zonal(fitter::zonal::build(phong, 8, 6).unwrap())),
        table(
            Some(ggx),
            Representation::Cubature(
                Cubature::new(ggx, axes, &[Node { disc: 2, product: 7, outer: 60, far: 200 }; 18]).unwrap(),
            ),
        ),
        table(Some(ggx), Representation::Lobes(Lobes::from_nodes(axes, &cells).unwrap())),
        table(Some(phong), Representation::Paper(Paper::from_cells(6, 3, 2, &cells).unwrap())),
    ]
}

/// The header with every word, aligned or not, made each of some absurd values in turn, sealed again.
pub fn absurd_headers(bytes: &[u8]) -> impl Iterator<Item = Vec<u8>> + '_ {
    let words = [
        vec![0xff; 4],
        vec![0; 4],
        vec![0xff, 0xff, 0xff, 0x7f],
        vec![0, 0, 1, 0],
        vec![0xff; 8],
        f64::NAN.to_le_bytes().to_vec(),
        f64::MAX.to_le_bytes().to_vec(),
        f64::MIN_POSITIVE.to_le_bytes().to_vec(),
    ];
    let range = 12..header_range(bytes).end;
    range.flat_map(move |at| words.clone().map(|word| (at, word))).filter_map(move |(at, word)| {
        let mut bytes = bytes.to_vec();
        bytes.get_mut(at..at + word.len())?.copy_from_slice(&word);
        Some(sealed(bytes))
    })
}
