//! A Mitsuba scene of any bytes: refused in one line, or a scene that can be drawn.
#![no_main]

use libfuzzer_sys::fuzz_target;
use render_fuzz::{Scratch, one_thread};
use std::sync::LazyLock;

static SCRATCH: LazyLock<Scratch> = LazyLock::new(|| Scratch::new("xml"));

fuzz_target!(init: one_thread(), |data: &[u8]| SCRATCH.check_scene(data));
