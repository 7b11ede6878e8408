// Harmonic records at glossy surfaces (radiance-caching-2005, eqs. 12 and 13). A group of threads takes a surface: it turns the function of
// its BRDF into the frame of each record that reaches it, and takes the dot product with the coefficients of the record.
//
// Functions are paired: .x is the cosine term of (l, m), .y the sine term, at l(l + 1)/2 + m.

struct Surface {
    position: vec3f,
    // Classes of the records that serve it: from the first to this one.
    first_class: u32,
    hemisphere: vec3f,
    class_: u32,
    // Axes of the frame of its function.
    x: vec3f,
    order: u32,
    y: vec3f,
    // Whether functions are spherical, in the frame of the world.
    spherical: u32,
    z: vec3f,
    // Bits: x and y of the eye have other signs than in the map.
    signs: u32,
    // What its function is blended of: place, order with a bit for sine terms, and share.
    texels: vec4u,
    orders: vec4u,
    shares: vec4f,
}

struct Record {
    position: vec3f,
    radius: f32,
    normal: vec3f,
    class_: u32,
    // Axes of its frame, whose z is the normal.
    x: vec3f,
    order: u32,
    y: vec3f,
    // Its coefficients: red, green, blue, then, if there are nine vectors, their derivatives along x and along y.
    first_number: u32,
    vectors: u32,
}

struct Sums {
    // Specular light, irradiance, weights.
    numbers: array<vec2f, 4>,
}

@group(0) @binding(6) var<storage, read> numbers: array<f32>;
@group(0) @binding(7) var<storage, read> lobes: array<f32>;
@group(0) @binding(8) var<storage, read> constants: array<f32>;

// A function and the cosine of the diffuse part, and room to turn them.
var<workgroup> function: array<vec2f, {{TERMS}}>;
var<workgroup> other: array<vec2f, {{TERMS}}>;
// The records of the run that reach the surface, their weights, and what is to be done for each.
var<workgroup> weights: array<f32, {{THREADS}}>;
var<workgroup> reaching: array<u32, {{THREADS}}>;
var<workgroup> ways: array<u32, {{THREADS}}>;
var<workgroup> count: u32;

// The function stays as it is, turns about the normal, turns by way of the sphere.
const KEPT = 0u;
const FLAT = 1u;
const SPHERE = 2u;

// A rotation: cosine and sine of its three turns about z, between which there are quarter turns about y.
struct Rotation {
    first: vec2f,
    second: vec2f,
    third: vec2f,
}

fn rotation_of(x: vec3f, y: vec3f, z: vec3f) -> Rotation {
    let sine = sqrt(z.x * z.x + z.y * z.y);
    var a = x.xy * select(1.0, -1.0, z.z < 0.0);
    var c = vec2f(1.0, 0.0);
    if sine > 1e-6 {
        a = z.xy / sine;
        c = vec2f(-x.z, y.z) / sine;
    }
    return Rotation(vec2f(-c.y, c.x), vec2f(-z.z, -sine), vec2f(-a.y, a.x));
}

// Band and m of a pair.
fn pair_of(p: u32) -> vec2u {
    let l = u32((sqrt(f32(8u * p + 1u)) - 1.0) * 0.5 + 1e-3);
    return vec2u(l, p - pairs(l));
}

fn pairs(bands: u32) -> u32 {
    return bands * (bands + 1u) / 2u;
}

// Bands by which a hemispherical function is turned.
fn bands_for(order: u32) -> u32 {
    return min(order + order / 3u + 3u, {{BANDS}});
}

// A pair turned about z by an angle of this cosine and sine.
fn about_z(pair: vec2f, angle: vec2f, m: u32) -> vec2f {
    var all = vec2f(1.0, 0.0);
    var power = angle;
    for (var left = m; left > 0u; left >>= 1u) {
        if (left & 1u) != 0u {
            all = vec2f(all.x * power.x - all.y * power.y, all.y * power.x + all.x * power.y);
        }
        power = vec2f(power.x * power.x - power.y * power.y, 2.0 * power.x * power.y);
    }
    return vec2f(pair.x * all.x - pair.y * all.y, pair.x * all.y + pair.y * all.x);
}

// A pair of the function of a surface.
fn blended(s: Surface, p: u32) -> vec2f {
    let at = pair_of(p);
    var sum = vec2f(0.0);
    for (var i = 0u; i < 4u; i++) {
        let order = s.orders[i] >> 1u;
        if s.shares[i] > 0.0 && at.x < order {
            sum.x += s.shares[i] * lobes[s.texels[i] + p];
            if (s.orders[i] & 1u) != 0u {
                sum.y += s.shares[i] * lobes[s.texels[i] + pairs(order) + p];
            }
        }
    }
    // From the first quadrant: φ → π − φ, φ → −φ.
    let x = select(1.0, -1.0, (s.signs & 1u) != 0u);
    let y = select(1.0, -1.0, (s.signs & 2u) != 0u);
    return sum * select(vec2f(1.0, x * y), vec2f(x, y), (at.y & 1u) != 0u);
}

// A pair of `function` from `first` on, which has so many bands, in spherical functions.
fn on_sphere(first: u32, order: u32, at: vec2u) -> vec2f {
    var sum = vec2f(0.0);
    for (var l = at.y; l < order; l++) {
        sum += constants[{{PRODUCTS}} + (at.x * {{MAX_ORDER}} + l) * {{MAX_ORDER}} + at.y] * function[first + pairs(l) + at.y];
    }
    return sum;
}

// The other way round, from `other`.
fn on_hemisphere(first: u32, bands: u32, at: vec2u) -> vec2f {
    var sum = vec2f(0.0);
    for (var k = at.y; k < bands; k++) {
        sum += constants[{{PRODUCTS}} + (k * {{MAX_ORDER}} + at.x) * {{MAX_ORDER}} + at.y] * other[first + pairs(k) + at.y];
    }
    return sum;
}

// Place of the column of a pair in the quarter turns.
fn quarters(at: vec2u, m: u32) -> u32 {
    return at.x * (at.x + 1u) * (2u * at.x + 1u) / 6u + m * (at.x + 1u) + at.y;
}

// `other` turned by a quarter about y and then about z, to `function`.
fn turn_back(first: u32, bands: u32, angle: vec2f, thread: u32) {
    for (var p = thread; p < pairs(bands); p += {{THREADS}}) {
        let at = pair_of(p);
        var sum = vec2f(0.0);
        for (var m = 0u; m <= at.x; m++) {
            let q = quarters(at, m);
            sum += vec2f(constants[{{COSINE_QUARTERS}} + q], constants[{{SINE_QUARTERS}} + q]) * other[first + pairs(at.x) + m];
        }
        function[first + p] = about_z(sum, angle, at.y);
    }
}

// The same from `function` to `other`.
fn turn_forth(first: u32, bands: u32, angle: vec2f, thread: u32) {
    for (var p = thread; p < pairs(bands); p += {{THREADS}}) {
        let at = pair_of(p);
        var sum = vec2f(0.0);
        for (var m = 0u; m <= at.x; m++) {
            let q = quarters(at, m);
            sum += vec2f(constants[{{COSINE_QUARTERS}} + q], constants[{{SINE_QUARTERS}} + q]) * function[first + pairs(at.x) + m];
        }
        other[first + p] = about_z(sum, angle, at.y);
    }
}

// Three coefficients of a record at a point `offset` away.
fn coefficients(record: Record, place: u32, offset: vec2f) -> vec3f {
    let size = record.order * record.order;
    let first = record.first_number + place;
    var sum = vec3f(numbers[first], numbers[first + size], numbers[first + 2u * size]);
    if record.vectors == 9u {
        sum += offset.x * vec3f(numbers[first + 3u * size], numbers[first + 4u * size], numbers[first + 5u * size]);
        sum += offset.y * vec3f(numbers[first + 6u * size], numbers[first + 7u * size], numbers[first + 8u * size]);
    }
    return sum;
}

// The share of a thread in the dot product of a record with a part of `function`.
fn share_of_dot(record: Record, offset: vec2f, first: u32, order: u32, thread: u32) -> vec3f {
    var sum = vec3f(0.0);
    for (var p = thread; p < pairs(min(order, record.order)); p += {{THREADS}}) {
        let at = pair_of(p);
        let pair = function[first + p];
        let place = at.x * at.x + at.y;
        sum += pair.x * coefficients(record, place, offset);
        if at.y > 0u {
            sum += pair.y * coefficients(record, place + at.x, offset);
        }
    }
    return sum;
}

@compute @workgroup_size({{THREADS}})
fn sum_harmonics(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    let tile = tile_of(group);
    let is_surface = group.z < tile.surfaces;
    let place = tile.first_surface + min(group.z, max(tile.surfaces, 1u) - 1u);
    let s = surfaces[place];
    let run = run_of(tile);
    // Each thread looks at a record of the run.
    let k = run.x + thread;
    var w = 0.0;
    if is_surface && k < run.y {
        let record = records[near[k]];
        if record.class_ >= s.first_class && record.class_ <= s.class_ {
            w = weight(s.position, s.hemisphere, record.position, record.normal, record.radius);
        }
    }
    weights[thread] = w;
    workgroupBarrier();
    if thread == 0u {
        var found = 0u;
        var before = vec3f(0.0);
        var before_x = vec3f(0.0);
        for (var j = 0u; j < {{THREADS}}; j++) {
            if weights[j] > 0.0 {
                let r = near[run.x + j];
                let normal = records[r].normal;
                let x = records[r].x;
                var way = SPHERE;
                if found > 0u && (s.spherical != 0u || (all(normal == before) && all(x == before_x))) {
                    way = KEPT;
                } else if s.spherical == 0u && dot(normal, s.z) >= {{SAME_NORMAL}} {
                    way = FLAT;
                }
                before = normal;
                before_x = x;
                reaching[found] = j;
                ways[found] = way;
                found++;
            }
        }
        count = found;
    }
    let found = workgroupUniformLoad(&count);
    // Threads 0 to 3 have two sums each.
    var sum = vec2f(0.0);
    let hemispherical = s.spherical == 0u;
    let bands = select(s.order, bands_for(s.order), hemispherical);
    let cosine_bands = select({{COSINE_ORDER}}, bands_for({{COSINE_ORDER}}), hemispherical);
    for (var j = 0u; j < found; j++) {
        let way = workgroupUniformLoad(&ways[j]);
        let record = records[near[run.x + reaching[j]]];
        // The frame of the function, seen from where it is turned to.
        var x = s.x;
        var y = s.y;
        var z = s.z;
        if hemispherical {
            let rows = transpose(mat3x3f(record.x, record.y, record.normal));
            x = rows * x;
            y = rows * y;
            z = rows * z;
        }
        if way == FLAT {
            var angle = vec2f(1.0, 0.0);
            if dot(x.xy, x.xy) > 1e-30 {
                angle = normalize(x.xy);
            }
            for (var p = thread; p < pairs(s.order); p += {{THREADS}}) {
                function[p] = about_z(blended(s, p), angle, pair_of(p).y);
            }
            for (var p = thread; p < pairs({{COSINE_ORDER}}); p += {{THREADS}}) {
                let at = pair_of(p);
                let cosine = constants[{{HEMISPHERICAL_COSINE}} + at.x];
                function[{{LOBE}} + p] = vec2f(select(0.0, cosine, at.y == 0u), 0.0);
            }
        }
        if way == SPHERE {
            let turns = rotation_of(x, y, z);
            for (var p = thread; p < pairs(s.order); p += {{THREADS}}) {
                function[p] = blended(s, p);
            }
            workgroupBarrier();
            for (var p = thread; p < pairs(bands); p += {{THREADS}}) {
                let at = pair_of(p);
                var pair = function[p];
                if hemispherical {
                    pair = on_sphere(0u, s.order, at);
                }
                other[p] = about_z(pair, turns.first, at.y);
            }
            for (var p = thread; p < pairs(cosine_bands); p += {{THREADS}}) {
                let at = pair_of(p);
                let cosine = constants[select({{SPHERICAL_COSINE}}, {{TURNING_COSINE}}, hemispherical) + at.x];
                other[{{LOBE}} + p] = vec2f(select(0.0, cosine, at.y == 0u), 0.0);
            }
            workgroupBarrier();
            turn_back(0u, bands, turns.second, thread);
            turn_back({{LOBE}}, cosine_bands, turns.second, thread);
            workgroupBarrier();
            turn_forth(0u, bands, turns.third, thread);
            turn_forth({{LOBE}}, cosine_bands, turns.third, thread);
            workgroupBarrier();
            for (var p = thread; p < pairs(s.order); p += {{THREADS}}) {
                var pair = other[p];
                if hemispherical {
                    pair = on_hemisphere(0u, bands, pair_of(p));
                }
                function[p] = pair;
            }
            for (var p = thread; p < pairs({{COSINE_ORDER}}); p += {{THREADS}}) {
                var pair = other[{{LOBE}} + p];
                if hemispherical {
                    pair = on_hemisphere({{LOBE}}, cosine_bands, pair_of(p));
                }
                function[{{LOBE}} + p] = pair;
            }
        }
        workgroupBarrier();
        let moved = s.position - record.position;
        let offset = vec2f(dot(record.x, moved), dot(record.y, moved));
        let specular = share_of_dot(record, offset, 0u, s.order, thread);
        let irradiance = share_of_dot(record, offset, {{LOBE}}, {{COSINE_ORDER}}, thread);
        other[thread] = specular.xy;
        other[{{THREADS}} + thread] = vec2f(specular.z, irradiance.x);
        other[2u * {{THREADS}} + thread] = irradiance.yz;
        workgroupBarrier();
        let w = weights[reaching[j]];
        if thread < 3u {
            var all = vec2f(0.0);
            for (var t = 0u; t < {{THREADS}}; t++) {
                all += other[thread * {{THREADS}} + t];
            }
            sum += all * w;
        }
        if thread == 3u {
            sum.x += w;
        }
    }
    if is_surface && found > 0u && thread < 4u {
        sums[place].numbers[thread] += sum;
    }
}
