//! Readers of measured data on files that are damaged in every way that chance finds: refused in one line, or read to finite
//! values; never a panic. What the fuzz target `measured` does with more time.

use brdf_tables::frame::spherical;
use brdf_tables::measured::{Format, Reading};
use std::path::{Path, PathBuf};

/// Damaged copies of a file.
const COPIES: usize = 1500;

/// SplitMix64.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ x >> 31) % n.max(1) as u64) as usize
    }
}

fn files() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/inputs/valid/measured");
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).expect("inputs").map(|e| e.expect("entry").path()).collect();
    files.retain(|path| Format::of(path).is_some());
    files.sort();
    files
}

fn judge(format: Format, bytes: &[u8]) -> bool {
    match Reading::from_bytes(format, bytes) {
        Ok(reading) => {
            for (to, from) in [((0.0, 0.0), (0.0, 0.0)), ((0.7, 1.0), (0.7, 4.14)), ((1.5, 2.0), (0.2, 5.0))] {
                let values = reading.source.rgb(spherical(to.0, to.1), spherical(from.0, from.1)).unwrap_or_default();
                assert!(values.iter().all(|x| x.is_finite() && *x >= 0.0), "{values:?}");
            }
            true
        }
        Err(error) => {
            let line = error.to_string();
            assert!(!line.is_empty() && !line.contains(['\n', '\r']), "{line:?}");
            false
        }
    }
}

#[test]
fn damage_is_refused_or_read() {
    let files = files();
    assert!(files.len() >= 6, "{files:?}");
    for file in files {
        let format = Format::of(&file).expect("a format");
        let whole = std::fs::read(&file).expect("readable");
        assert!(judge(format, &whole), "{}", file.display());
        let mut random = Random(whole.len() as u64);
        // Text is slow to fit: a small part of it will do.
        let text = matches!(format, Format::Cornell | Format::Csv);
        let bytes = if text { &whole[..whole.len().min(6000)] } else { &whole[..] };
        let mut refused = 0;
        for _ in 0..COPIES {
            let mut copy = bytes.to_vec();
            match random.below(4) {
                0 => copy.truncate(random.below(bytes.len())),
                1 => {
                    let at = random.below(bytes.len());
                    let extra = copy[at..(at + random.below(40)).min(bytes.len())].to_vec();
                    copy.splice(at..at, extra);
                }
                // Heads are where sizes stand.
                kind => {
                    let reach = if kind == 2 { bytes.len().min(200) } else { bytes.len() };
                    for _ in 0..=random.below(4) {
                        let at = random.below(reach);
                        copy[at] = match random.below(4) {
                            0 => 0xff,
                            1 => 0,
                            2 => copy[at] ^ 1 << random.below(8),
                            _ => b"0123456789-.,e \nn"[random.below(17)],
                        };
                    }
                }
            }
            refused += usize::from(!judge(format, &copy));
        }
        assert!(refused > COPIES / 10, "{}: only {refused} of {COPIES} refused", file.display());
    }
}
