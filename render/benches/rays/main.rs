//! What a picture is made of, piece by piece, on one core: `cargo bench -p burnish-render --bench rays [-- FILTER]`.
//!
//! divan reports items (rays, vertices, samples, look-ups) per second. Scenes that are not there are left out. With
//! `RAYS_EXPORT=DIR` the triangles and rays are written to DIR instead, with our seconds for them: what
//! `tests/peers/embree.py` compares.

mod export;
mod paths;
mod shading;
mod subjects;
mod traversal;

fn main() {
    match std::env::var_os("RAYS_EXPORT") {
        Some(folder) => export::run(folder.as_ref()),
        None => divan::main(),
    }
}
