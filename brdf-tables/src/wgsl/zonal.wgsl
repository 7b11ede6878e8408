// Two tabulated integrals of a radial lobe.

fn mb_edge(x: f32) -> f32 {
    return x / sqrt(fma(x * x, 0.25, 1.0));
}

// 1 - cos^(n + 2) of the half angle of a cap of height h.
fn mb_filled(n: f32, h: f32) -> f32 {
    let x = (n + 2.0) * mb_ln_1m(h);
    if x > -0.05 {
        return -x * fma(x, fma(x, fma(x, 1.0 / 24.0, 1.0 / 6.0), 0.5), 1.0);
    }
    return 1.0 - mb_exp2(x * {{LOG2_E}});
}

fn mb_zonal_pair(at: u32, f: f32) -> vec2f {
    let low = mb_word(at);
    let high = mb_word(at + 1u);
    let a = vec2f(f32(low & 0xffffu), f32(low >> 16u));
    let b = vec2f(f32(high & 0xffffu), f32(high >> 16u));
    return fma(b - a, vec2f(f), a);
}

fn mb_zonal(model: u32, at: u32, axis: vec3f, height: f32, wo: vec3f) -> f32 {
    let n = mb_number(at);
    let sharpness = max(n, 1.0);
    let radius = sqrt(height * 2.0 * sharpness);
    let d = vec3f(wo.x + axis.x, wo.y + axis.y, wo.z - axis.z);
    let s = sqrt(dot(d, d) * sharpness);
    let reach = min(2.0 * sqrt(sharpness) - radius, {{REACH}});
    if s >= radius + reach {
        return 0.0;
    }
    let rule = mb_word(at + 8u);
    let radius2 = height * (2.0 - height);
    let crosses = axis.z * axis.z < radius2;
    if crosses {
        // Deeply cut caps, and those much smaller than the lobe, are integrated above the horizon.
        let z2 = select(axis.z * axis.z, 0.0, height < 0.1 / sharpness);
        if z2 < radius2 * 0.25 {
            return mb_by_rule(model, -1.0, axis, height, wo, rule);
        }
    }
    let columns = mb_word(at + 2u);
    let rows = mb_word(at + 3u);
    let origin = mb_edge(radius);
    let v = (mb_edge(s - radius) + origin) / (mb_edge(reach) + origin);
    let top = sqrt(2.0 * sharpness);
    let u = radius / (radius + 3.0) * ((top + 3.0) / top);
    let gu = min(u * f32(rows - 1u), f32(rows - 1u));
    let gv = clamp(v * f32(columns - 1u), 0.0, f32(columns - 1u));
    let iu = min(floor(gu), f32(rows - 2u));
    let iv = min(floor(gv), f32(columns - 2u));
    let cell = at + 9u + u32(iu) * columns + u32(iv);
    let low = mb_zonal_pair(cell, gv - iv);
    let high = mb_zonal_pair(cell + columns, gv - iv);
    let step = vec2f(mb_number(at + 5u), mb_number(at + 7u));
    let offset = vec2f(mb_number(at + 4u), mb_number(at + 6u));
    let t = fma(fma(high - low, vec2f(gu - iu), low), step, offset);
    var sum = mb_number(at + 1u) * mb_filled(n, height) * dot(t, vec2f(axis.z, wo.z));
    if crosses {
        // The part below the horizon counts as negative there: it is taken away.
        let lobe = mb_lobe(model, wo);
        let turned = mb_into_frame(axis, lobe.rotation);
        let part = mb_numerator(model, -1.0, lobe, turned, height, true, rule);
        sum = select(sum - part, part, mb_holds_pole(turned, height));
    }
    return max(sum, 0.0) / mb_projected_solid_angle(axis.z, height);
}
