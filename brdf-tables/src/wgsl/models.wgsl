// The reflection models. Their numbers lie in the buffer from `model` on.

// Squared half chord, 1 - cos, between wo and the mirror of wi: keeps the digits that a dot product near 1 has lost.
fn mb_off_mirror(wi: vec3f, wo: vec3f) -> f32 {
    let d = vec3f(wi.x + wo.x, wi.y + wo.y, wi.z - wo.z);
    return 0.5 * dot(d, d);
}

fn mb_schlick(cos_d: f32, f0: f32) -> f32 {
    let m = max(1.0 - cos_d, 0.0);
    let m2 = m * m;
    return fma(m2 * m2 * m, 1.0 - f0, f0);
}

// Born and Wolf 1999, section 14.2.
fn mb_conductor(cos_d: f32, eta: f32, k: f32) -> f32 {
    let cos2 = cos_d * cos_d;
    let sin2 = max(1.0 - cos2, 0.0);
    let difference = eta * eta - k * k - sin2;
    let a2_plus_b2 = sqrt(difference * difference + 4.0 * eta * eta * k * k);
    let large2 = (a2_plus_b2 + abs(difference)) * 0.5;
    let over_large = 1.0 / sqrt(large2);
    let a = select(large2 * over_large, eta * k * over_large, difference < 0.0);
    let twice = 2.0 * a * cos_d;
    let s = (a2_plus_b2 + cos2 - twice) / (a2_plus_b2 + cos2 + twice);
    let sum = cos2 * a2_plus_b2 + sin2 * sin2;
    let product = twice * sin2;
    let p = s * (sum - product) / (sum + product);
    return clamp((s + p) * 0.5, 0.0, 1.0);
}

// Grey reflectance of facets at the cosine between a direction and the half vector; f0 < 0 leaves it to the model.
fn mb_fresnel(model: u32, f0: f32, cos_d: f32) -> f32 {
    if f0 >= 0.0 {
        return mb_schlick(cos_d, f0);
    }
    let at = model + {{FRESNEL}};
    switch mb_word(at) {
        case 1u: {
            return mb_schlick(cos_d, mb_number(at + 1u));
        }
        case 2u: {
            return mb_conductor(cos_d, mb_number(at + 1u), mb_number(at + 2u));
        }
        default: {
            return 1.0;
        }
    }
}

// Smith's G1(w)/cos.
fn mb_g1_over_cos(model: u32, w: vec3f) -> f32 {
    let at = model + {{BODY}};
    let width2 = w.x * w.x * mb_number(at + 2u) + w.y * w.y * mb_number(at + 3u);
    if mb_word(model) == {{GGX}} {
        return 2.0 / (w.z + sqrt(max(w.z * w.z + width2, 1e-30)));
    }
    let over_width = 1.0 / sqrt(max(width2, 1e-30));
    let a = min(w.z * over_width, {{WALTER_END}});
    if a < {{WALTER_END}} {
        return fma(a, {{WALTER_1}}, {{WALTER_0}}) * over_width / fma(fma(a, {{WALTER_3}}, {{WALTER_2}}), a, 1.0);
    }
    return 1.0 / max(w.z, 1e-30);
}

fn mb_facets(model: u32, f0: f32, wi: vec3f, wo: vec3f) -> f32 {
    let at = model + {{BODY}};
    let h = wi + wo;
    let x2 = h.x * h.x;
    let y2 = h.y * h.y;
    let z2 = h.z * h.z;
    let slope2 = x2 * mb_number(at) + y2 * mb_number(at + 1u);
    let h2 = x2 + y2 + z2;
    var d: f32;
    if mb_word(model) == {{GGX}} {
        d = mb_sq(h2 / max(slope2 + z2, 1e-30));
    } else {
        let over_z2 = 1.0 / max(max(z2, h2 * 1e-8), 1e-30);
        d = mb_exp2(slope2 * over_z2) * mb_sq(h2 * over_z2);
    }
    let reflected = mb_fresnel(model, f0, sqrt(min(h2 * 0.25, 1.0)));
    return d * mb_g1_over_cos(model, wi) * reflected;
}

fn mb_ward(model: u32, wi: vec3f, wo: vec3f, bounded: bool) -> f32 {
    let at = model + {{BODY}};
    let h = wi + wo;
    let over_z2 = 1.0 / max(h.z * h.z, {{WARD_FLOOR}});
    let x2 = h.x * h.x;
    let y2 = h.y * h.y;
    let gauss = mb_exp2((x2 * mb_number(at) + y2 * mb_number(at + 1u)) * over_z2);
    if bounded {
        return gauss * fma(x2 + y2, over_z2, 1.0) * over_z2;
    }
    return gauss / sqrt(max(wi.z * wo.z, {{WARD_FLOOR}}));
}

fn mb_lafortune(model: u32, wi: vec3f, wo: vec3f) -> f32 {
    let at = model + {{BODY}};
    let count = mb_word(at);
    let product = wi * wo;
    let off = mb_off_mirror(wi, wo);
    var sum = 0.0;
    for (var i = 0u; i < count; i++) {
        // [Cx, Cy, Cz, n, 1 + Cx/Cz, 1 + Cy/Cz, n log2 Cz]
        let lobe = at + 1u + 7u * i;
        let cz = mb_number(lobe + 2u);
        let n = mb_number(lobe + 3u);
        if cz > 0.0 {
            // Cz times the cosine from the mirror direction, and what the other coefficients differ by.
            let x = off - mb_number(lobe + 4u) * product.x - mb_number(lobe + 5u) * product.y;
            if x < 0.9999999 {
                sum += mb_exp2(fma(n, mb_ln_1m(x) * {{LOG2_E}}, mb_number(lobe + 6u)));
            }
        } else {
            sum += mb_pow(dot(vec3f(mb_number(lobe), mb_number(lobe + 1u), cz), product), n);
        }
    }
    return sum;
}

fn mb_sheen_lambda(at: u32, cos_d: f32) -> f32 {
    let below = cos_d < 0.5;
    let x = select(1.0 - cos_d, cos_d, below);
    let l = mb_number(at + 2u) / fma(mb_pow(x, mb_number(at + 4u)), mb_number(at + 3u), 1.0)
        + mb_number(at + 5u) * x + mb_number(at + 6u);
    return mb_exp2(select(mb_number(at + 7u) - l, l, below) * {{LOG2_E}});
}

fn mb_sheen(model: u32, wi: vec3f, wo: vec3f) -> f32 {
    let at = model + {{BODY}};
    let h = wi + wo;
    let across = h.x * h.x + h.y * h.y;
    let sin2 = min(across / max(across + h.z * h.z, 1e-30), 1.0);
    let d = mb_pow(sin2, mb_number(at)) * mb_number(at + 1u);
    let cos_i = clamp(wi.z, {{SHEEN_FLOOR}}, 1.0);
    let cos_o = clamp(wo.z, {{SHEEN_FLOOR}}, 1.0);
    return d / (cos_i * cos_o * (mb_sheen_lambda(at, cos_i) + mb_sheen_lambda(at, cos_o) + 1.0));
}

// Values over the half and difference angles.
fn mb_measured(model: u32, wi: vec3f, wo: vec3f) -> f32 {
    let at = model + {{BODY}};
    let h = wi + wo;
    let z2 = h.z * h.z;
    let across2 = h.x * h.x + h.y * h.y;
    let sum2 = max(across2 + z2, 1e-30);
    let length = sqrt(sum2);
    let lowered = min(across2 / max(fma(h.z, length, sum2), 1e-30), 1.0);
    let turned = max(1.0 - 0.5 * length, 0.0);
    let largest = max(min(z2 * sum2, across2 * (4.0 - sum2)), 1e-30);
    let d = wi.z - wo.z;
    let unit = vec3f(sqrt(sqrt(lowered)), sqrt(turned), min(d * d * sum2 / largest, 1.0));
    // Nodes along each axis; pairs of neighbours along the last follow.
    let nodes = vec3u(mb_word(at), mb_word(at + 1u), mb_word(at + 2u));
    let place = unit * (vec3f(nodes - 1u) * {{INSIDE}});
    let low = floor(max(min(place, vec3f(nodes - 2u)), vec3f(0.0)));
    let f = place - low;
    let row = nodes.z - 1u;
    let first = mb_word(at + 5u) + (u32(low.x) * nodes.y + u32(low.y)) * row + u32(low.z);
    let near = mb_measured_pair(first, f.z);
    let beside = mb_measured_pair(first + row, f.z);
    let above = mb_measured_pair(first + nodes.y * row, f.z);
    let across = mb_measured_pair(first + (nodes.y + 1u) * row, f.z);
    let value = mix(mix(near, beside, f.y), mix(above, across, f.y), f.x);
    return mb_exp2(fma(value, mb_number(at + 4u), mb_number(at + 3u)));
}

fn mb_measured_pair(at: u32, f: f32) -> f32 {
    let pair = mb_word(at);
    let a = f32(pair & 0xffffu);
    return fma(f32(pair >> 16u) - a, f, a);
}

// f_r over what mb_factor gives, sr^-1.
fn mb_rest(model: u32, f0: f32, wi: vec3f, wo: vec3f) -> f32 {
    switch mb_word(model) {
        case {{PHONG}}: {
            return mb_pow_1m(mb_off_mirror(wi, wo), mb_number(model + {{BODY}}));
        }
        case {{LAFORTUNE}}: {
            return mb_lafortune(model, wi, wo);
        }
        case {{WARD_1992}}: {
            return mb_ward(model, wi, wo, false);
        }
        case {{WARD_BOUNDED}}: {
            return mb_ward(model, wi, wo, true);
        }
        case {{SHEEN}}: {
            return mb_sheen(model, wi, wo);
        }
        case {{MEASURED}}: {
            return mb_measured(model, wi, wo);
        }
        default: {
            return mb_facets(model, f0, wi, wo);
        }
    }
}

// The factor of f_r that wo alone gives.
fn mb_factor(model: u32, wo: vec3f) -> f32 {
    switch mb_word(model) {
        case {{PHONG}}: {
            return mb_number(model + {{BODY}} + 1u);
        }
        case {{WARD_1992}}, {{WARD_BOUNDED}}: {
            return mb_number(model + {{BODY}} + 2u);
        }
        case {{BECKMANN}}, {{GGX}}: {
            return mb_g1_over_cos(model, wo) * mb_number(model + {{BODY}} + 4u);
        }
        default: {
            return 1.0;
        }
    }
}
