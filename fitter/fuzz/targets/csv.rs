//! Rows of any bytes: answered, each as often as it stands there, or refused in one line; and the same however the input
//! arrives.
#![no_main]

use fitter::rows::answer;
use libfuzzer_sys::fuzz_target;
use std::io::Read;

/// Gives so many bytes at a time.
struct Pieces<'a>(&'a [u8], usize);

impl Read for Pieces<'_> {
    fn read(&mut self, to: &mut [u8]) -> std::io::Result<usize> {
        let most = self.1.min(to.len());
        self.0.read(&mut to[..most])
    }
}

fuzz_target!(
    init: rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global().expect("one pool"),
    |data: &[u8]| {
        assert_eq!(run(data), run(Pieces(data, 1 + data.len() % 16)));
    }
);

fn run(input: impl Read) -> (Vec<u8>, Option<String>) {
    let mut output = Vec::new();
    let result = answer(input, &mut output, ["r", "g", "b"], |row, cap, eye| {
        let numbers = [row as f64, cap.projected_solid_angle(), eye.z];
        assert!(numbers.iter().all(|x| x.is_finite()), "{cap:?} {eye}");
        numbers
    });
    let error = result.err().map(|e| format!("{e:#}"));
    if let Some(line) = &error {
        assert!(!line.contains(['\n', '\r']), "{line:?}");
    }
    (output, error)
}
