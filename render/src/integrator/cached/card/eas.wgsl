// EAS records at glossy surfaces (eas-2015, eqs. 15 to 17).

struct Surface {
    position: vec3f,
    // Classes of the records that serve it: from the first to this one.
    first_class: u32,
    hemisphere: vec3f,
    class_: u32,
    // Axes of the local frame, and the direction to the eye in it.
    x: vec3f,
    lobe: u32,
    y: vec3f,
    // Schlick's grey reflectance at normal incidence, or a negative number where that of the table holds.
    f0: f32,
    z: vec3f,
    // What the table sums up to under light that is 1 everywhere.
    unit: f32,
    wo: vec3f,
    // Colours of the specular part, of light along the half vector and of light that grazes it.
    normal_color: vec3f,
    grazing: vec3f,
    // Reflectance for light from everywhere.
    everywhere: vec3f,
}

struct Record {
    position: vec3f,
    radius: f32,
    normal: vec3f,
    class_: u32,
    background: vec3f,
    first_source: u32,
    // The cone of the views that it was made for; pi and more for any view.
    axis: vec3f,
    half_angle: f32,
    sources: u32,
}

struct Source {
    direction: vec3f,
    inverse_distance: f32,
    light: vec3f,
    solid_angle: f32,
    normal: vec3f,
    factor: f32,
}

struct Lobe {
    table: u32,
    // Whether the reflectance of a conductor colours it.
    conductor: u32,
    // Cosine and sine of the angle beyond which a small cap does not matter.
    support: vec2f,
    eta: vec3f,
    width: f32,
    k: vec3f,
}

struct Sums {
    irradiance: vec3f,
    weights: f32,
    specular: vec3f,
    trust: f32,
    seen: f32,
    others: u32,
}

@group(0) @binding(6) var<storage, read> sources: array<Source>;
@group(0) @binding(7) var<storage, read> lobes: array<Lobe>;
@group(0) @binding(8) var<storage, read> tables: array<u32>;

// A source seen from a point.
struct Moved {
    direction: vec3f,
    solid_angle: f32,
    // Projected solid angle above the horizon, 0 for what is below.
    area: f32,
    near: bool,
}

fn moved(source: Source, offset: vec3f, s: Surface, support: vec2f) -> Moved {
    var out: Moved;
    // The centroid seen from the point, in homogeneous form: what is at infinity is a direction only.
    let toward = source.direction - offset * source.inverse_distance;
    let length2 = dot(toward, toward);
    if length2 < {{MIN_LENGTH2}} {
        return out;
    }
    let inverse = 1.0 / sqrt(length2);
    let cos_alpha = -dot(source.normal, toward) * inverse;
    let cap = min(source.solid_angle * {{OVER_TWO_PI}}, 1.0);
    let sine = sqrt(cap * (2.0 - cap));
    let softened = (max(cos_alpha, 0.0) + sine) / (1.0 + sine);
    let ratio = clamp(softened * source.factor * inverse * inverse, {{OVER_MAX_RATIO}}, {{MAX_RATIO}});
    out.solid_angle = min(source.solid_angle * ratio, {{TWO_PI}});
    let d = vec3f(dot(s.x, toward), dot(s.y, toward), dot(s.z, toward)) * inverse;
    // Less than half of a cap is above the horizon: it fades out as it sinks, and its axis stays on the horizon.
    let below = max(-d.z / max(sine, 1e-12), 0.0);
    if below >= 1.0 {
        return out;
    }
    let z = max(d.z, 0.0);
    let fade = 1.0 - below;
    out.area = mean_brdf_projected_solid_angle(vec3f(0.0, 0.0, z), out.solid_angle) * fade * fade;
    let along = select(1.0, 1.0 / sqrt(max(dot(d.xy, d.xy), 1e-12)), below > 0.0);
    out.direction = vec3f(d.xy * along, z);
    let height = out.solid_angle * {{OVER_TWO_PI}};
    let cos_r = 1.0 - height;
    let sin_r = sqrt(max(height * (2.0 - height), 0.0));
    let limit = select(support.x * cos_r - support.y * sin_r, -1.0, cos_r < -support.x);
    out.near = dot(out.direction, vec3f(-s.wo.xy, s.wo.z)) > limit;
    return out;
}

// Schlick's term between two directions.
fn edge(wi: vec3f, wo: vec3f) -> f32 {
    let h = wi + wo;
    let m = max(1.0 - 0.5 * sqrt(dot(h, h)), 0.0);
    return m * m * m * m * m;
}

// The colour that the table's value is multiplied by.
fn tint(s: Surface, lobe: Lobe, wi: vec3f) -> vec3f {
    if s.f0 >= 0.0 {
        let e = edge(wi, s.wo);
        let gray = s.f0 + (1.0 - s.f0) * e;
        if gray > 1e-12 {
            return (s.normal_color + (s.grazing - s.normal_color) * e) / gray;
        }
        return s.grazing;
    }
    if lobe.conductor == 0u {
        return s.normal_color;
    }
    let h = wi + s.wo;
    let cos_d = min(0.5 * sqrt(dot(h, h)), 1.0);
    let own = mb_conductor(cos_d, dot(lobe.eta, vec3f(1.0 / 3.0)), dot(lobe.k, vec3f(1.0 / 3.0)));
    let rgb = vec3f(
        mb_conductor(cos_d, lobe.eta.x, lobe.k.x),
        mb_conductor(cos_d, lobe.eta.y, lobe.k.y),
        mb_conductor(cos_d, lobe.eta.z, lobe.k.z),
    );
    return s.normal_color * select(vec3f(1.0), rgb / max(own, 1e-30), own > 0.0);
}

// How far a record is fine enough for a view with this mirror direction.
fn trusted_view(record: Record, mirror: vec3f, width: f32) -> f32 {
    if record.half_angle >= {{PI}} {
        return 1.0;
    }
    let angle = 0.5 * {{PI}} - mb_asin(clamp(dot(record.axis, mirror), -1.0, 1.0));
    let beyond = (angle - record.half_angle) / width;
    return clamp(({{COARSE}} - beyond) / ({{COARSE}} - {{FINE}}), 0.0, 1.0);
}

@compute @workgroup_size({{THREADS}})
fn sum_eas(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    let tile = tile_of(group);
    let i = group.z * {{THREADS}} + thread;
    if i < tile.surfaces {
        let s = surfaces[tile.first_surface + i];
        let lobe = lobes[s.lobe];
        let mirror = s.z * s.wo.z - s.x * s.wo.x - s.y * s.wo.y;
        var sum = sums[tile.first_surface + i];
        let run = run_of(tile);
        for (var k = run.x; k < run.y; k++) {
            let r = near[k];
            let class_ = records[r].class_;
            if class_ < s.first_class || class_ > s.class_ {
                continue;
            }
            let w = weight(s.position, s.hemisphere, records[r].position, records[r].normal, records[r].radius);
            if w <= 0.0 {
                continue;
            }
            let record = records[r];
            let offset = s.position - record.position;
            var irradiance = vec3f(0.0);
            var specular = vec3f(0.0);
            var whole = 0.0;
            var unit = 0.0;
            for (var j = 0u; j < record.sources; j++) {
                let source = sources[record.first_source + j];
                let seen = moved(source, offset, s, lobe.support);
                let light = source.light * seen.area;
                irradiance += light;
                whole += seen.area;
                if seen.near {
                    let mean = mean_brdf_schlick(lobe.table, s.f0, seen.direction, seen.solid_angle, s.wo);
                    specular += light * tint(s, lobe, seen.direction) * mean;
                    unit += seen.area * mean;
                }
            }
            // Caps tile the hemisphere but roughly: what they would reflect of light that is 1 everywhere tells.
            let cover = select(1.0, unit / max(s.unit, 1e-30), s.unit > 0.0);
            let off = min(max(cover, 1.0 / max(cover, 1e-30)), {{NONE}});
            let trust = min(({{NONE}} - off) / ({{NONE}} - {{WHOLE}}), 1.0);
            irradiance *= min({{ROOM}} * {{PI}} / max(whole, 1e-30), 1.0);
            irradiance += record.background * {{PI}};
            specular += record.background * s.everywhere;
            let view = w * trusted_view(record, mirror, lobe.width);
            sum.irradiance += irradiance * w;
            sum.specular += specular * (view * trust);
            sum.trust += view * trust;
            sum.weights += w;
            sum.seen += view;
            sum.others |= u32(record.half_angle < {{PI}});
        }
        sums[tile.first_surface + i] = sum;
    }
}
