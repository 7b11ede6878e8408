// The triangles of a scene as they are seen from a point, on a square above it: in each pixel the number of the piece of a surface.

struct Triangle {
    a: vec3f,
    // Number of its first piece.
    first: u32,
    b: vec3f,
    // Pieces along an edge.
    edge: u32,
    c: vec3f,
    // From a piece of the front to that of the back.
    back: u32,
}

struct Viewpoint {
    eye: vec3f,
    // What is less high does not count.
    near: f32,
    x: vec3f,
    y: vec3f,
    z: vec3f,
}

@group(0) @binding(0) var<storage, read> settings: Settings;
@group(0) @binding(1) var<storage, read> viewpoints: array<Viewpoint>;
@group(0) @binding(2) var<storage, read> triangles: array<Triangle>;

struct Seen {
    @builtin(position) place: vec4f,
    @location(0) @interpolate(flat) triangle: u32,
    @location(1) @interpolate(flat) instance: u32,
}

struct Drawn {
    @location(0) piece: u32,
    @builtin(frag_depth) depth: f32,
}

@vertex
fn corner(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Seen {
    let v = viewpoints[instance];
    let triangle = vertex / 3u;
    let t = triangles[triangle];
    var corners = array<vec3f, 3>(t.a, t.b, t.c);
    let offset = corners[vertex % 3u] - v.eye;
    let local = vec3f(dot(offset, v.x), dot(offset, v.y), dot(offset, v.z));
    // Rows go down as y goes up.
    let place = vec4f(settings.height * local.x, -settings.height * local.y, v.near, local.z);
    return Seen(place, triangle, instance);
}

fn piece_of_triangle(barycentric: vec2f, n: u32) -> u32 {
    let at = max(barycentric * f32(n), vec2f(0.0));
    let j = min(u32(at.y), n - 1u);
    let i = min(u32(at.x), n - 1u - j);
    let beyond = at.x - f32(i) + at.y - f32(j) > 1.0;
    return j * (2u * n - j) + 2u * i + u32(beyond && i + j + 1u < n);
}

@fragment
fn seen(s: Seen) -> Drawn {
    let v = viewpoints[s.instance];
    let t = triangles[s.triangle];
    let square = vec2f(f32(s.instance % settings.columns), f32(s.instance / settings.columns)) * f32(settings.side);
    let across = 2.0 * (s.place.xy - square) / f32(settings.side) - 1.0;
    let direction = v.x * across.x + v.y * across.y + v.z * settings.height;
    // Where the ray through the middle of the pixel meets the triangle.
    let e1 = t.b - t.a;
    let e2 = t.c - t.a;
    let normal = cross(e1, e2);
    let toward = dot(normal, direction);
    let offset = v.eye - t.a;
    let distance = -dot(normal, offset) / toward;
    if !(distance > 0.0) {
        discard;
    }
    let p = offset + direction * distance;
    let barycentric = vec2f(dot(cross(p, e2), normal), dot(cross(e1, p), normal)) / dot(normal, normal);
    let piece = t.first + piece_of_triangle(barycentric, t.edge) + select(0u, t.back, toward > 0.0);
    return Drawn(piece, 1.0 / (1.0 + distance / settings.scale));
}
