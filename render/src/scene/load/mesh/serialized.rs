//! Mitsuba's compressed `.serialized` meshes, versions 3 and 4: a sequence of zlib streams and a table of offsets.
//!
//! Layout (little endian): `u16` 0x041C, `u16` version, zlib stream: `u32` flags, (version 4) the name up to a zero
//! byte, `u64` vertices, `u64` triangles, positions, normals (flag 1), texture coordinates (flag 2), colours (flag 8),
//! indices as `u32`. The file ends with the offset of every mesh (`u32` in version 3, `u64` in version 4) and their
//! number as `u32`.

use super::Parsed;
use crate::scene::{Mesh, load::error::FileError};
use flate2::bufread::ZlibDecoder;
use glam::{Vec2, Vec3};
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

const MAGIC: u16 = 0x041C;
const HAS_NORMALS: u32 = 0x1;
const HAS_UVS: u32 = 0x2;
const HAS_COLORS: u32 = 0x8;
const FACE_NORMALS: u32 = 0x10;
const DOUBLE_PRECISION: u32 = 0x2000;

/// Meshes do not compress better than this; a stream that claims to is a bomb.
const MAX_RATIO: u64 = 256;
/// Small streams may compress well.
const FREE_BYTES: u64 = 1 << 24;

/// Parses mesh `index` of the file; `path` serves error messages only.
///
/// # Errors
/// No such mesh; truncated or damaged data, by the stream's checksum too; sizes that the data cannot have.
pub fn parse(file: &[u8], index: usize, path: &Path) -> Result<Parsed, FileError> {
    let error = |what: String| FileError::new(path, what);
    let (version, stream) = locate(file, index).map_err(error)?;
    let (mesh, face_normals) = mesh(version, stream).map_err(|what| error(format!("mesh {index}: {what}")))?;
    Ok(Parsed { face_normals, ..Parsed::new(mesh, []) })
}

/// Version and zlib stream of mesh `index`.
fn locate(file: &[u8], index: usize) -> Result<(u16, &[u8]), String> {
    let u16_at = |at: usize| file.get(at..at + 2).map(|b| u16::from_le_bytes([b[0], b[1]]));
    let truncated = || String::from("file too short for a serialized mesh");
    if u16_at(0).ok_or_else(truncated)? != MAGIC {
        return Err("no serialized mesh: the first bytes are not 1c 04".into());
    }
    let version = u16_at(2).ok_or_else(truncated)?;
    let width = match version {
        3 => 4,
        4 => 8,
        other => return Err(format!("serialized version {other} (3 and 4 are supported)")),
    };
    let footer = file.len().checked_sub(4).ok_or_else(truncated)?;
    let count = file[footer..].try_into().map(u32::from_le_bytes).map_err(|_| truncated())? as usize;
    if index >= count {
        return Err(format!("shape index {index}, but the file holds {count} meshes"));
    }
    let table = count.checked_mul(width).and_then(|size| footer.checked_sub(size));
    let table = table.ok_or_else(|| format!("{count} meshes promised, more than the file can hold"))?;
    let offset = |i: usize| {
        let mut bytes = [0; 8];
        bytes[..width].copy_from_slice(&file[table + i * width..][..width]);
        usize::try_from(u64::from_le_bytes(bytes)).unwrap_or(usize::MAX)
    };
    // A stream says itself where it ends, and the table need not be in the order of the file.
    let start = offset(index);
    let mesh = file.get(start..table).filter(|mesh| mesh.len() >= 4);
    let mesh = mesh.ok_or_else(|| format!("offset {start} of mesh {index} is outside the file"))?;
    if mesh[..4] != file[..4] {
        return Err(format!("offset {start} of mesh {index} is not the start of a mesh"));
    }
    Ok((version, &mesh[4..]))
}

/// Decompresses and reads one mesh.
fn mesh(version: u16, stream: &[u8]) -> Result<(Mesh, bool), String> {
    let budget = stream.len() as u64 * MAX_RATIO + FREE_BYTES;
    let mut input = BufReader::with_capacity(1 << 16, ZlibDecoder::new(stream).take(budget));
    let flags = u32::from_le_bytes(array(&mut input)?);
    if version == 4 {
        input.by_ref().take(1 << 16).skip_until(0).map_err(|e| e.to_string())?;
    }
    let vertices = u64::from_le_bytes(array(&mut input)?);
    let triangles = u64::from_le_bytes(array(&mut input)?);
    // Each count must fit the bytes that the stream can expand to, before anything of its size is allocated.
    let double = flags & DOUBLE_PRECISION != 0;
    let bytes = (vertices.checked_mul(if double { 24 } else { 12 })).zip(triangles.checked_mul(12));
    if bytes.is_none_or(|(v, t)| v.saturating_add(t) > budget) || vertices > u64::from(u32::MAX) {
        return Err(format!(
            "{vertices} vertices and {triangles} triangles cannot come from {} compressed bytes",
            stream.len()
        ));
    }
    let (vertices, triangles) = (vertices as usize, triangles as usize);
    let mut out = Mesh { positions: vectors(&mut input, vertices, double, Vec3::from_array)?, ..Mesh::default() };
    if flags & HAS_NORMALS != 0 {
        out.normals = vectors(&mut input, vertices, double, Vec3::from_array)?;
    }
    if flags & HAS_UVS != 0 {
        out.uvs = vectors(&mut input, vertices, double, Vec2::from_array)?;
    }
    if flags & HAS_COLORS != 0 {
        vectors(&mut input, vertices, double, |_: [f32; 3]| ())?;
    }
    out.triangles = values(&mut input, 3 * triangles, u32::from_le_bytes)?.as_chunks().0.to_vec();
    // The checksum stands behind the data. A stream that its writer did not close has none.
    match io::copy(&mut input, &mut io::sink()) {
        Err(e) if e.kind() != io::ErrorKind::UnexpectedEof => return Err(format!("damaged: {e}")),
        _ => {}
    }
    Ok((out, flags & FACE_NORMALS != 0))
}

fn array<const N: usize>(input: &mut impl Read) -> Result<[u8; N], String> {
    let mut bytes = [0; N];
    input.read_exact(&mut bytes).map(|()| bytes).map_err(|e| format!("truncated or damaged: {e}"))
}

/// `count` numbers of `N` bytes.
fn values<T, const N: usize>(
    input: &mut impl Read,
    count: usize,
    decode: impl Fn([u8; N]) -> T,
) -> Result<Vec<T>, String> {
    let mut bytes = Vec::new();
    input.take((count * N) as u64).read_to_end(&mut bytes).map_err(|e| format!("damaged: {e}"))?;
    if bytes.len() < count * N {
        return Err("truncated".into());
    }
    Ok(bytes.as_chunks().0.iter().map(|&b| decode(b)).collect())
}

/// `count` vectors of `N` components, stored in single or double precision.
fn vectors<T, const N: usize>(
    input: &mut impl Read,
    count: usize,
    double: bool,
    vector: impl Fn([f32; N]) -> T,
) -> Result<Vec<T>, String> {
    let components = if double {
        values(input, count * N, |b| f64::from_le_bytes(b) as f32)?
    } else {
        values(input, count * N, f32::from_le_bytes)?
    };
    Ok(components.as_chunks().0.iter().map(|&c| vector(c)).collect())
}
