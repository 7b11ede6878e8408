//! The file: what is written reads back, and what is damaged is refused with one clear line.

use super::{any_cap, rng};
use crate::hostile::{absurd_headers, crc32, header_range, sealed, table, tables};
use brdf_tables::brdf::{Phong, Specular};
use brdf_tables::cap::Cap;
use brdf_tables::cubature::RULES;
use brdf_tables::format::{FormatError, MAGIC, VERSION};
use brdf_tables::frame::spherical;
use brdf_tables::parts::PartsError;
use brdf_tables::table::{Representation, Table};
use brdf_tables::zonal::Zonal;
use std::fs;
use std::path::Path;

/// What is accepted, however odd, answers every query with a number.
fn answers(table: &Table) {
    let mut rng = rng(3);
    let caps: Vec<Cap> = (0..20).map(|_| any_cap(&mut rng)).collect();
    let batch = caps.iter().collect();
    let mut out = [0f32; 20];
    for wo in [spherical(0.4, 2.0), spherical(1.5, 5.0)] {
        table.specular_values(&batch, wo.as_vec3(), &mut out);
        for (cap, single) in caps.iter().zip(out) {
            let values = table.value(cap, wo);
            assert!(values.iter().all(|x| x.is_finite() && *x >= 0.0), "{values:?} from {:?}", table.header.material);
            assert!(single.is_finite() && single >= 0.0, "{single} from {:?}", table.header.material);
            assert!(table.support(cap).is_finite());
        }
    }
}

/// One line, not empty.
fn refused(bytes: &[u8]) -> FormatError {
    let error = Table::from_bytes(bytes).unwrap_err();
    let line = error.to_string();
    assert!(!line.is_empty() && !line.contains('\n'), "{line:?}");
    error
}

#[test]
fn bytes_round_trip() {
    for table in tables() {
        let bytes = table.to_bytes().unwrap();
        let back = Table::from_bytes(&bytes).unwrap();
        assert_eq!(back, table);
        assert_eq!(back.to_bytes().unwrap(), bytes);
        // The documented frame.
        assert_eq!(bytes[..8], MAGIC);
        assert_eq!(bytes[8..12], VERSION.to_le_bytes());
        let (content, checksum) = bytes.split_at(bytes.len() - 4);
        assert_eq!(checksum, crc32(content).to_le_bytes());
        assert!(header_range(&bytes).end <= content.len());
        answers(&table);
    }
}

/// [`tables`] by the names of their files in `tests/golden`, made of numbers that no library computes.
fn golden() -> Vec<(&'static str, Table)> {
    let phong = Specular::Phong(Phong { exponent: 20.0 });
    let zonal =
        Zonal::new(phong, 3, 2, (0..6).map(|i| i * 0x0101_0011).collect(), [[-0.5, 2e-5], [0.0, 1e-5]]).unwrap();
    let mut tables = tables();
    tables[1] = table(Some(phong), Representation::Zonal(zonal));
    ["diffuse", "zonal", "cubature", "lobes", "paper"].into_iter().zip(tables).collect()
}

/// The format is public: these bytes never change while the version is the same, and stay readable in the next. A new version
/// moves them to a name of their own; `BLESS=1` writes those that are wrong or missing.
#[test]
fn golden_bytes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden");
    for (name, table) in golden() {
        let (path, bytes) = (folder.join(format!("{name}.tbl")), table.to_bytes().unwrap());
        if std::env::var_os("BLESS").is_some() {
            fs::write(&path, &bytes).unwrap();
        }
        let stored = fs::read(&path).unwrap();
        assert!(stored == bytes, "{name}: other bytes than {}", path.display());
        assert_eq!(Table::from_bytes(&stored).unwrap(), table, "{name}");
    }
}

/// Version 1 had three bytes for a node of a cubature table, an order among them, and was otherwise the same.
#[test]
fn the_version_before_is_read() {
    for (name, table) in golden() {
        let mut bytes = table.to_bytes().unwrap();
        bytes[8..12].copy_from_slice(&1u32.to_le_bytes());
        if name == "cubature" {
            let nodes = 18;
            bytes.truncate(bytes.len() - 4 - 4 * nodes);
            for i in 0..nodes {
                // Orders 1 to 16.
                bytes.extend([i as u8 % 10, 50, 200]);
            }
            bytes.extend([0; 4]);
        }
        let back = Table::from_bytes(&sealed(bytes.clone())).unwrap();
        assert_eq!(back.header, table.header);
        answers(&back);
        if let Representation::Cubature(cubature) = &back.representation {
            let products = cubature.parts().1.iter().take(10).map(|n| RULES[usize::from(n.product)].evaluations());
            assert_eq!(products.collect::<Vec<_>>(), [16, 16, 16, 16, 25, 36, 64, 100, 144, 256]);
            let end = bytes.len() - 4;
            bytes[end - 3] = 10;
            assert!(refused(&sealed(bytes)).to_string().contains("node 17"));
        } else {
            assert_eq!(back, table);
        }
    }
    let mut bytes = golden()[0].1.to_bytes().unwrap();
    for version in [0, 3, u32::MAX] {
        bytes[8..12].copy_from_slice(&version.to_le_bytes());
        assert!(matches!(refused(&sealed(bytes.clone())), FormatError::Version(v) if v == version));
    }
}

#[test]
fn truncation_and_flipped_bits_are_refused() {
    for table in tables() {
        let bytes = table.to_bytes().unwrap();
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
    let bytes = tables()[1].to_bytes().unwrap();
    let with = |at: usize, new: &[u8]| {
        let mut bytes = bytes.clone();
        bytes[at..at + new.len()].copy_from_slice(new);
        bytes
    };
    assert!(matches!(refused(b""), FormatError::Magic));
    assert!(matches!(refused(&with(0, b"burnish\n")), FormatError::Magic));
    assert!(matches!(refused(&with(8, &(VERSION + 1).to_le_bytes())), FormatError::Version(v) if v == VERSION + 1));
    assert!(matches!(refused(&with(12, &u32::MAX.to_le_bytes())), FormatError::Header(_)));
    assert!(matches!(refused(&with(12, &60_000u32.to_le_bytes())), FormatError::Length { .. }));
    assert!(matches!(refused(&bytes[..bytes.len() - 1]), FormatError::Checksum { .. }));
    let longer = |extra: &[u8]| sealed([&bytes[..bytes.len() - 4], extra, &[0; 4]].concat());
    assert!(matches!(refused(&longer(&[0; 4])), FormatError::Parts(PartsError::Count { .. })));
    assert!(matches!(refused(&longer(&[0; 3])), FormatError::Parts(PartsError::Count { .. })));
    let mut spare = bytes.clone();
    spare[12..16].copy_from_slice(&(header_range(&bytes).len() as u32 + 1).to_le_bytes());
    assert!(matches!(refused(&sealed(spare)), FormatError::Header(_)));
}

/// NaN and infinity in the payload, the checksum in order.
#[test]
fn numbers_that_are_none_are_refused() {
    for table in tables() {
        let bytes = table.to_bytes().unwrap();
        let (cells, name) = (24 * table.cells.len(), table.representation_name());
        let start = header_range(&bytes).end;
        // All floats of lobes; the cells alone of tables that store integers.
        let end = if matches!(name, "lobes" | "paper") { bytes.len() - 4 } else { start + cells };
        for at in (start..end).step_by(4) {
            for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                let mut bytes = bytes.clone();
                bytes[at..at + 4].copy_from_slice(&bad.to_le_bytes());
                assert!(matches!(refused(&sealed(bytes)), FormatError::Payload(_)), "{name} at {at}");
            }
        }
    }
}

#[test]
fn absurd_headers_are_refused_or_harmless() {
    let (mut accepted, mut refusals) = (0, 0);
    for table in tables() {
        for bytes in absurd_headers(&table.to_bytes().unwrap()) {
            match Table::from_bytes(&bytes) {
                Ok(table) => {
                    accepted += 1;
                    answers(&table);
                }
                Err(error) => {
                    refusals += 1;
                    assert!(!error.to_string().contains('\n'));
                }
            }
        }
    }
    eprintln!("{accepted} accepted, {refusals} refused");
    assert!(refusals > accepted / 4);
}

#[test]
fn saving_is_all_or_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("material.tbl");
    let [first, second] = [&tables()[1], &tables()[3]].map(Clone::clone);
    first.save(&path).unwrap();
    assert_eq!(Table::load(&path).unwrap(), first);

    // A header that does not fit: the file that is there stays.
    let mut talkative = second.clone();
    talkative.header.notes = vec!["x".repeat(1 << 21)];
    assert!(matches!(talkative.save(&path).unwrap_err(), FormatError::Header(_)));
    assert_eq!(Table::load(&path).unwrap(), first);

    // A folder in the way, and a folder that is missing.
    let taken = folder.path().join("taken");
    fs::create_dir(&taken).unwrap();
    fs::write(taken.join("inside"), b"x").unwrap();
    assert!(matches!(second.save(&taken).unwrap_err(), FormatError::Io(_)));
    assert_eq!(fs::read(taken.join("inside")).unwrap(), b"x");
    assert!(matches!(second.save(folder.path().join("missing/a.tbl")).unwrap_err(), FormatError::Io(_)));
    assert!(matches!(Table::load(&taken).unwrap_err(), FormatError::Io(_)));
    assert!(matches!(Table::load(folder.path().join("missing.tbl")).unwrap_err(), FormatError::Io(_)));

    second.save(&path).unwrap();
    assert_eq!(Table::load(&path).unwrap(), second);
    let mut names: Vec<_> = fs::read_dir(&folder).unwrap().map(|e| e.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["material.tbl", "taken"], "temporary files are left behind");
}

#[test]
fn files_larger_than_any_table_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("large.tbl");
    let mut bytes = tables()[1].to_bytes().unwrap();
    bytes.resize((1 << 24) + 1, 0);
    fs::write(&path, &bytes).unwrap();
    assert!(matches!(Table::load(&path).unwrap_err(), FormatError::TooLarge));
}
