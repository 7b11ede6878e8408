// A quad for each record, over the pixels that it may reach. What it adds to them is blended: (E w, w).

struct Seen {
    @builtin(position) place: vec4f,
    @location(0) @interpolate(flat) record: u32,
}

// Left, top, right, bottom of each record, pixels.
@group(0) @binding(6) var<storage, read> rectangles: array<vec4f>;
// Records in the order in which they are drawn.
@group(0) @binding(7) var<storage, read> drawn: array<u32>;
// Width and height of the picture.
@group(0) @binding(8) var<storage, read> size: array<u32>;

@vertex
fn corner(@builtin(vertex_index) corner: u32, @builtin(instance_index) instance: u32) -> Seen {
    let record = drawn[instance];
    let r = rectangles[record];
    let pixel = vec2f(select(r.x, r.z, (corner & 1u) != 0u), select(r.y, r.w, (corner & 2u) != 0u));
    let across = pixel / vec2f(f32(size[0]), f32(size[1]));
    return Seen(vec4f(2.0 * across.x - 1.0, 1.0 - 2.0 * across.y, 0.0, 1.0), record);
}

@fragment
fn added(seen: Seen) -> @location(0) vec4f {
    let s = surfaces[u32(seen.place.x) + u32(seen.place.y) * size[0]];
    let r = seen.record;
    let w = weight(s.position, s.hemisphere, records[r].position, records[r].normal, records[r].radius);
    if w <= 0.0 {
        discard;
    }
    return vec4f(irradiance_of(r, s) * w, w);
}
