// Irradiance records at diffuse surfaces.

struct Surface {
    position: vec3f,
    hemisphere: vec3f,
    normal: vec3f,
}

struct Record {
    position: vec3f,
    radius: f32,
    normal: vec3f,
    irradiance: vec3f,
    translation: array<vec3f, 3>,
    rotation: array<vec3f, 3>,
}

struct Sums {
    irradiance: vec3f,
    radius: f32,
    weights: f32,
}

// What a record says of a surface: irradiance by its gradients.
fn irradiance_of(r: u32, s: Surface) -> vec3f {
    let moved = s.position - records[r].position;
    let turned = cross(records[r].normal, s.normal);
    var e = records[r].irradiance;
    for (var c = 0u; c < 3u; c++) {
        e[c] += dot(moved, records[r].translation[c]) + dot(turned, records[r].rotation[c]);
    }
    return max(e, vec3f(0.0));
}

@compute @workgroup_size({{THREADS}})
fn sum_irradiance(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    let tile = tile_of(group);
    let i = group.z * {{THREADS}} + thread;
    if i < tile.surfaces {
        let s = surfaces[tile.first_surface + i];
        var sum = sums[tile.first_surface + i];
        let run = run_of(tile);
        for (var k = run.x; k < run.y; k++) {
            let r = near[k];
            let w = weight(s.position, s.hemisphere, records[r].position, records[r].normal, records[r].radius);
            if w > 0.0 {
                sum.irradiance += irradiance_of(r, s) * w;
                sum.radius += records[r].radius * w;
                sum.weights += w;
            }
        }
        sums[tile.first_surface + i] = sum;
    }
}
