//! The file of a family: what is written reads back, and what is damaged is refused with one clear line.

use super::rng;
use crate::hostile::{absurd_headers, crc32, header_range, sealed};
use brdf_tables::axis::Axes;
use brdf_tables::cubature::Node;
use brdf_tables::errors::{Errors, Summary};
use brdf_tables::family::{
    Family, FamilyHeader, Kin, Lattice, MAGIC, Measured, RuleCells, Store, VERSION, ZonalSlices,
};
use brdf_tables::format::FormatError;
use brdf_tables::material::Material;
use brdf_tables::parts::PartsError;
use fitter::family::random_member;
use std::fs;
use std::path::Path;

fn header(kin: Kin, lattice: Lattice) -> FamilyHeader {
    let error = Errors { rmse_hemi: 1e-4, rmse_lobe: 1e-3, l1: 2e-3, max: 3e-3, albedo: 4e-3 };
    let summary = Summary { caps: 5, median: error, p95: error, worst: error };
    FamilyHeader {
        kin,
        lattice,
        creator: "tests".into(),
        command: "fitter fit-family α".into(),
        seed: 7,
        tolerance: 0.003,
        promise: [0.003, 0.0075, 0.015],
        notes: vec!["one".into()],
        at_nodes: summary,
        off_nodes: summary,
        clipped: summary,
    }
}

/// Small ones of each store, by the names of their files, made of numbers that no library computes.
fn small() -> [(&'static str, Family); 3] {
    let grid = |theta, phi, omega| Axes { theta, phi, omega, sharpness: 1.0, stretch: 0.5 };
    let measured = |count: usize| (0..count).map(|i| Measured([i as u8, 10, 20, 30, 40, 200])).collect();
    let rules = |axes: Axes, cells: usize| {
        let node = |i: usize| Node { disc: (i % 4) as u8, product: 7, outer: 60 + i as u8, far: 200 };
        Store::Rules(RuleCells::new(axes, (0..cells * axes.len()).map(node).collect()))
    };
    let one = Lattice { widths: vec![0.1, 0.2, 0.5], reach: None };
    let two = Lattice { reach: Some(1), ..one.clone() };
    let exponents = Lattice { widths: vec![1.0, 4.0, 20.0, 300.0], reach: None };
    let slices = ZonalSlices::new(3, 2, (0..24).map(|i| i * 0x0101_0011).collect(), [[-0.5, 2e-5], [0.0, 1e-5]]);
    let new = |kin, lattice, axes, store| {
        let lattice: Lattice = lattice;
        let cells = lattice.cells() * Axes::len(&axes);
        Family::new(header(kin, lattice), axes, measured(cells), store).unwrap()
    };
    [
        ("family-rules", new(Kin::Ggx, one, grid(2, 1, 3), rules(grid(3, 1, 4), 2))),
        ("family-anisotropic", new(Kin::Ward1992, two, grid(2, 3, 2), rules(grid(2, 3, 2), 3))),
        ("family-zonal", new(Kin::Phong, exponents, grid(2, 1, 2), Store::Zonal(slices))),
    ]
}

/// What is accepted, however odd, answers every query with a number.
fn answers(family: &Family) {
    let mut rng = rng(6);
    for _ in 0..5 {
        let specular = random_member(family.header.kin, &family.header.lattice, &mut rng);
        let Some(table) = family.for_model(&Material::specular(specular)) else { continue };
        let caps: Vec<_> = (0..20).map(|_| super::any_cap(&mut rng)).collect();
        let mut out = [0f32; 20];
        for wo in [brdf_tables::frame::spherical(0.4, 2.0), brdf_tables::frame::spherical(1.5, 5.0)] {
            table.specular_values(&caps.iter().collect(), wo.as_vec3(), &mut out);
            assert!(out.iter().all(|x| x.is_finite() && *x >= 0.0), "{out:?}");
        }
        assert!(table.support(&caps[0]).is_finite());
        assert!(table.cell_errors(&caps[0]).to_array().iter().all(|e| e.is_finite()));
    }
}

fn refused(bytes: &[u8]) -> FormatError {
    let error = Family::from_bytes(bytes).unwrap_err();
    let line = error.to_string();
    assert!(!line.is_empty() && !line.contains('\n'), "{line:?}");
    error
}

/// The format is public, as that of tables is: these bytes never change; `BLESS=1` writes those that are missing.
#[test]
fn golden_bytes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden");
    for (name, family) in small() {
        let (path, bytes) = (folder.join(format!("{name}.fam")), family.to_bytes().unwrap());
        if std::env::var_os("BLESS").is_some() {
            fs::write(&path, &bytes).unwrap();
        }
        let stored = fs::read(&path).unwrap();
        assert!(stored == bytes, "{name}: other bytes than {}", path.display());
        let back = Family::from_bytes(&stored).unwrap();
        assert_eq!(back, family, "{name}");
        assert_eq!((&bytes[..8], &bytes[8..12]), (&MAGIC[..], &VERSION.to_le_bytes()[..]));
        let (content, checksum) = bytes.split_at(bytes.len() - 4);
        assert_eq!(checksum, crc32(content).to_le_bytes());
        answers(&back);
    }
}

#[test]
fn truncation_and_flipped_bits_are_refused() {
    for (_, family) in small() {
        let bytes = family.to_bytes().unwrap();
        for length in 0..bytes.len() {
            refused(&bytes[..length]);
        }
        for bit in 0..8 * bytes.len() {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            refused(&damaged);
        }
    }
}

#[test]
fn each_damage_has_its_own_error() {
    let [(_, rules), _, (_, zonal)] = small();
    let bytes = rules.to_bytes().unwrap();
    assert!(matches!(refused(b""), FormatError::FamilyMagic));
    let mut newer = bytes.clone();
    newer[8..12].copy_from_slice(&(VERSION + 1).to_le_bytes());
    assert!(matches!(refused(&sealed(newer)), FormatError::FamilyVersion(v) if v == VERSION + 1));
    assert!(matches!(refused(&bytes[..bytes.len() - 1]), FormatError::Checksum { .. }));
    let longer = |bytes: &[u8], extra: &[u8]| sealed([&bytes[..bytes.len() - 4], extra, &[0; 4]].concat());
    for extra in [3, 4, 30] {
        assert!(matches!(refused(&longer(&bytes, &vec![0; extra])), FormatError::Parts(PartsError::Count { .. })));
        let zonal = zonal.to_bytes().unwrap();
        assert!(matches!(refused(&longer(&zonal, &vec![0; extra])), FormatError::Parts(PartsError::Count { .. })));
    }
    // A rule that is none.
    let mut wrong = bytes.clone();
    let last = wrong.len() - 4 - 3;
    wrong[last] = 0xff;
    assert!(matches!(refused(&sealed(wrong)), FormatError::Parts(PartsError::Number { what: "node", at: 23 })));
    // A table is not a family, and the other way round.
    let error = brdf_tables::Table::from_bytes(&bytes).unwrap_err();
    assert!(matches!(error, FormatError::Magic));
    assert!(header_range(&bytes).end < bytes.len());
}

#[test]
fn absurd_headers_are_refused_or_harmless() {
    let (mut accepted, mut refusals) = (0, 0);
    for (_, family) in small() {
        for bytes in absurd_headers(&family.to_bytes().unwrap()) {
            match Family::from_bytes(&bytes) {
                Ok(family) => {
                    accepted += 1;
                    answers(&family);
                }
                Err(_) => refusals += 1,
            }
        }
    }
    assert!(refusals > accepted / 4, "{accepted} accepted, {refusals} refused");
}

/// Parts that do not belong together make no family.
#[test]
fn wrong_parts_are_refused() {
    let [(_, rules), (_, two), (_, zonal)] = small();
    let with = |family: &Family, change: &dyn Fn(&mut FamilyHeader)| {
        let (axes, measured, store) = family.parts();
        let mut header = family.header.clone();
        change(&mut header);
        Family::new(header, axes, measured.to_vec(), store.clone())
    };
    assert!(with(&rules, &|_| ()).is_ok());
    for (family, change) in [
        (&zonal, &(|h: &mut FamilyHeader| h.kin = Kin::Sheen) as &dyn Fn(&mut FamilyHeader)),
        (&two, &|h| h.kin = Kin::Sheen),
        (&two, &|h| h.lattice.reach = None),
        (&rules, &|h| h.lattice.widths = vec![0.1, 0.2]),
        (&rules, &|h| h.lattice.widths = vec![0.1, 0.2, 1.5]),
        (&rules, &|h| h.lattice.widths = vec![0.2, 0.1, 0.5]),
        (&zonal, &|h| h.lattice.widths.truncate(3)),
    ] {
        assert!(with(family, change).is_err());
    }
}
