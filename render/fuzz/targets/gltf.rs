//! A glTF scene of any bytes, text or GLB: refused in one line, or a scene that can be drawn.
#![no_main]

use libfuzzer_sys::fuzz_target;
use render_fuzz::{Scratch, one_thread};
use std::sync::LazyLock;

// The first bytes tell GLB from text, whatever the name says.
static SCRATCH: LazyLock<Scratch> = LazyLock::new(|| Scratch::new("gltf"));

fuzz_target!(init: one_thread(), |data: &[u8]| SCRATCH.check_scene(data));
