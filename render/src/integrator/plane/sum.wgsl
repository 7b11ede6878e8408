// The irradiance of each square: the light of its pieces, weighted.

@group(0) @binding(0) var<storage, read> settings: Settings;
@group(0) @binding(1) var<storage, read> pixels: array<u32>;
// Three numbers of each piece.
@group(0) @binding(2) var<storage, read> light: array<f32>;
@group(0) @binding(3) var<storage, read> weights: array<f32>;
@group(0) @binding(4) var<storage, read_write> sums: array<vec4f>;

var<workgroup> parts: array<vec3f, {{THREADS}}>;

@compute @workgroup_size({{THREADS}})
fn sum(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    let square = vec2u(group.x % settings.columns, group.x / settings.columns) * settings.side;
    var sum = vec3f(0.0);
    for (var cell = thread; cell < settings.side * settings.side; cell += {{THREADS}}) {
        let pixel = square + vec2u(cell % settings.side, cell / settings.side);
        let first = 3u * pixels[pixel.x + pixel.y * settings.pitch];
        sum += vec3f(light[first], light[first + 1u], light[first + 2u]) * weights[cell];
    }
    parts[thread] = sum;
    for (var half = {{THREADS}} / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if thread < half {
            parts[thread] += parts[thread + half];
        }
    }
    if thread == 0u {
        sums[group.x] = vec4f(parts[0], 0.0);
    }
}
