//! A serialized mesh: the bytes as a file, and as the content of its compressed stream; refused in one line, or a mesh
//! that a scene accepts.
#![no_main]

use libfuzzer_sys::fuzz_target;
use render::scene::load::mesh::serialized::parse;
use std::path::Path;

fuzz_target!(|data: &[u8]| {
    let check = |file: &[u8]| render_fuzz::check_mesh(parse(file, 0, Path::new("m.serialized")));
    if data.starts_with(&[0x1c, 0x04]) {
        return check(data);
    }
    // Random bytes are no zlib stream with a right checksum: they go into one, uncompressed.
    let version = if data.len() % 2 == 0 { 3u16 } else { 4 };
    let mut file = vec![0x1c, 0x04];
    file.extend(version.to_le_bytes());
    file.extend(stored(data));
    file.resize(file.len() + if version == 3 { 4 } else { 8 }, 0);
    file.extend(1u32.to_le_bytes());
    check(&file);
});

/// A zlib stream of one stored block (RFC 1950, 1951).
fn stored(data: &[u8]) -> Vec<u8> {
    let data = &data[..data.len().min(0xffff)];
    let length = data.len() as u16;
    let mut out = vec![0x78, 0x01, 0x01];
    out.extend(length.to_le_bytes());
    out.extend((!length).to_le_bytes());
    out.extend(data);
    let (a, b) =
        data.iter().fold((1u32, 0u32), |(a, b), &x| ((a + u32::from(x)) % 65521, (b + (a + u32::from(x))) % 65521));
    out.extend((b << 16 | a).to_be_bytes());
    out
}
