//! PLY of any bytes: refused in one line, or a mesh that a scene accepts.
#![no_main]

use libfuzzer_sys::fuzz_target;
use render::scene::load::mesh::ply::parse;
use std::path::Path;

fuzz_target!(|data: &[u8]| render_fuzz::check_mesh(parse(data, Path::new("m.ply"), false)));
