// The mean over a cap by a rule over the model itself.

// Where the lobe seen from wo lies: see the library's `Footprint`.
struct MbLobe {
    sin_o: f32,
    cos_o: f32,
    // Cosine and sine of the azimuth of wo.
    rotation: vec2f,
    sin_peak: f32,
    cos_peak: f32,
    width_a: f32,
    tilt: f32,
    k0: f32,
    k1: f32,
    h0: f32,
    h1: f32,
}

fn mb_lobe(model: u32, wo: vec3f) -> MbLobe {
    var lobe: MbLobe;
    lobe.sin_o = sqrt(wo.x * wo.x + wo.y * wo.y);
    lobe.cos_o = wo.z;
    lobe.rotation = vec2f(1.0, 0.0);
    if lobe.sin_o > 1e-9 {
        lobe.rotation = wo.xy / lobe.sin_o;
    }
    let c2 = lobe.rotation.x * lobe.rotation.x;
    let s2 = lobe.rotation.y * lobe.rotation.y;
    let a = mb_number(model + 3u);
    let b = mb_number(model + 4u);
    let c = mb_number(model + 5u);
    let d = mb_number(model + 6u);
    if mb_word(model + 2u) == 0u {
        // A cosine about ((a c2 + b s2) sin_o + d, c cos_o), of width e.
        var peak = vec2f((a * c2 + b * s2) * lobe.sin_o + d, c * lobe.cos_o);
        let length = sqrt(dot(peak, peak));
        peak = select(vec2f(0.0, 1.0), peak / max(length, 1e-30), length > 1e-30);
        lobe.sin_peak = peak.x;
        lobe.cos_peak = peak.y;
        let width = mb_number(model + 7u);
        lobe.width_a = width;
        lobe.k0 = width * width;
        lobe.h0 = 1.0;
    } else {
        // Slopes of squared inverse widths a and b, the map c times as wide, with long tails if d is 1.
        let qxx = c2 * a + s2 * b;
        let qyy = s2 * a + c2 * b;
        let qxy = lobe.rotation.x * lobe.rotation.y * (b - a);
        let marginal = qxx - qxy * qxy / qyy;
        lobe.sin_peak = -lobe.sin_o;
        lobe.cos_peak = lobe.cos_o;
        lobe.width_a = 2.0 * c / sqrt(marginal);
        lobe.tilt = -qxy / qyy;
        lobe.k0 = c * c / qyy;
        lobe.k1 = d * c * c * marginal / qyy;
        lobe.h0 = lobe.cos_o;
        lobe.h1 = 1.0;
    }
    return lobe;
}

// A direction of the surface frame in the frame of wo.
fn mb_into_frame(w: vec3f, rotation: vec2f) -> vec3f {
    return vec3f(w.x * rotation.x + w.y * rotation.y, w.y * rotation.x - w.x * rotation.y, w.z);
}

fn mb_turned(w: vec3f, rotation: vec2f) -> vec3f {
    return vec3f(w.x * rotation.x - w.y * rotation.y, w.x * rotation.y + w.y * rotation.x, w.z);
}

// Middle and half length in s of the interval [lo, lo + length] under x = kappa s / (1 - s^2).
fn mb_mapped(lo: f32, length: f32, kappa: f32) -> vec2f {
    let hi = lo + length;
    let k2 = kappa * kappa;
    let w0 = sqrt(k2 + 4.0 * lo * lo);
    let w1 = sqrt(k2 + 4.0 * hi * hi);
    let d0 = 1.0 / (kappa + w0);
    let d1 = 1.0 / (kappa + w1);
    let half = length * (kappa + w0 - 4.0 * lo * (lo + hi) / (w0 + w1)) * (d0 * d1);
    return vec2f(2.0 * lo * d0 + half, max(half, 0.0));
}

// Value and Jacobian at the node x of a rule.
fn mb_mapped_at(map: vec2f, kappa: f32, x: f32) -> vec2f {
    let s = fma(map.y, x, map.x);
    let s2 = s * s;
    let r = 1.0 / max(1.0 - s2, 1e-6);
    let kr = kappa * r;
    return vec2f(kr * s, kr * r * map.y * (1.0 + s2));
}

fn mb_holds_pole(axis: vec3f, height: f32) -> bool {
    return axis.x * axis.x + axis.z * axis.z < height * (2.0 - height);
}

// Integral of f_r cos over the part of a cap above the horizon, or below it, by a product rule. The axis is in the frame of wo.
fn mb_numerator(model: u32, f0: f32, lobe: MbLobe, axis: vec3f, height: f32, below: bool, rule: u32) -> f32 {
    let turn = mb_word(model + 1u) == 0u;
    var wo = vec3f(lobe.sin_o, 0.0, lobe.cos_o);
    if turn {
        wo = mb_turned(wo, lobe.rotation);
    }
    let cos_r = 1.0 - height;
    let sin2_r = height * (2.0 - height);
    let sin_r = sqrt(sin2_r);
    let in_plane2 = max(axis.x * axis.x + axis.z * axis.z, 1e-12);
    let in_plane = sqrt(in_plane2);
    let sin_c = axis.x / in_plane;
    let cos_c = axis.z / in_plane;
    let has_pole = mb_holds_pole(axis, height);
    let sin_rho = select(min(sin_r / in_plane, 1.0), 1.0, has_pole);
    let over_rho = 1.0 / sin_rho;

    // The range of tau: the horizon cuts the side that the cap leans to.
    var lo = -{{FRAC_PI_2}};
    var hi = {{FRAC_PI_2}};
    if below || has_pole || cos_c < sin_rho {
        let cut = mb_asin(min(cos_c * over_rho, 1.0));
        let leans_right = sin_c > 0.0;
        if below {
            lo = select(lo, cut, leans_right);
            hi = select(-cut, hi, leans_right);
        } else {
            lo = select(-cut, lo, leans_right);
            hi = select(hi, cut, leans_right);
        }
        if has_pole {
            let a_cap = mb_asin(clamp(sin_c, -1.0, 1.0));
            hi = {{FRAC_PI_2}} - a_cap;
            lo = -{{FRAC_PI_2}} - a_cap;
        }
    }

    // The lobe in tau: its centre, or the nearest rim, and its width there.
    let sin_d = lobe.sin_peak * cos_c - lobe.cos_peak * sin_c;
    let excess = max(abs(sin_d) - sin_rho, 0.0);
    let reach = sqrt(lobe.width_a * lobe.width_a + excess * excess) * over_rho;
    let clamped = clamp(sin_d * over_rho, -1.0, 1.0);
    let centre = mb_asin(clamped);
    let kappa = reach / sqrt(1.0 - clamped * clamped + reach);
    let tau_map = mb_mapped(lo - centre, hi - lo, kappa);

    let count = mb_word(2u * rule);
    let nodes = mb_word(2u * rule + 1u);
    var sum = 0.0;
    for (var i = 0u; i < count; i++) {
        let tau = mb_mapped_at(tau_map, kappa, mb_number(nodes + 2u * i));
        let sin_cos = mb_sin_cos(centre + tau.x);
        let x = sin_rho * sin_cos.x;
        let root_d = sqrt(max(1.0 - x * x, 1e-12));
        let cos_d = select(root_d, sin_cos.y, has_pole);
        let jacobian = tau.y * select(sin_rho * sin_cos.y / root_d, 1.0, has_pole);
        let sin_a = sin_c * cos_d + cos_c * x;
        let cos_a = cos_c * cos_d - sin_c * x;

        // The interval of q on this meridian.
        let p = in_plane * cos_d;
        let inverse = 1.0 / max(p * p + axis.y * axis.y, 1e-12);
        let root = select(sin_r * sin_cos.y, sqrt(max(sin2_r - in_plane * in_plane * x * x, 0.0)), has_pole);
        let mid = axis.y * cos_r * inverse;
        let half = p * root * inverse;
        var q_lo = mid - half;
        var length = half + half;
        if has_pole {
            let mid_c = p * cos_r;
            let half_c = axis.y * root;
            let q_hi = select(mid + half, 1.0, mid_c - half_c < 0.0);
            q_lo = select(q_lo, -1.0, mid_c + half_c < 0.0);
            length = q_hi - q_lo;
        }

        let along = sin_a - lobe.sin_peak;
        let scale = lobe.h0 + lobe.h1 * cos_a;
        let ridge = lobe.tilt * along;
        let kappa_q = sqrt(max(lobe.k0 * scale * scale + lobe.k1 * along * along, 1e-12));
        let q_map = mb_mapped(q_lo - ridge, length, kappa_q);
        var row = 0.0;
        for (var j = 0u; j < count; j++) {
            let offset = mb_mapped_at(q_map, kappa_q, mb_number(nodes + 2u * j));
            let q = ridge + offset.x;
            let cos_b = sqrt(max(1.0 - q * q, 1e-12));
            var wi = vec3f(cos_b * sin_a, q, cos_b * cos_a);
            if turn {
                wi = mb_turned(wi, lobe.rotation);
            }
            row = fma(offset.y * mb_number(nodes + 2u * j + 1u) * wi.z, mb_rest(model, f0, wi, wo), row);
        }
        sum = fma(jacobian * mb_number(nodes + 2u * i + 1u), row, sum);
    }
    return sum * mb_factor(model, wo);
}

// The mean by a disc rule: nodes on rings about the axis of the cap.
fn mb_disc(model: u32, f0: f32, axis: vec3f, height: f32, wo: vec3f, rule: u32) -> f32 {
    let a = -1.0 / (1.0 + axis.z);
    let b = axis.x * axis.y * a;
    let t = vec3f(fma(axis.x * axis.x, a, 1.0), b, -axis.x);
    let u = vec3f(b, fma(axis.y * axis.y, a, 1.0), -axis.y);
    let count = mb_word(2u * rule);
    let nodes = mb_word(2u * rule + 1u);
    var sum = 0.0;
    var area = 0.0;
    for (var i = 0u; i < count; i++) {
        // [height, weight, cos, sin]
        let node = nodes + 4u * i;
        let h = height * mb_number(node);
        let across = sqrt(h * (2.0 - h));
        var wi = across * mb_number(node + 2u) * t + (across * mb_number(node + 3u) * u + (1.0 - h) * axis);
        wi.z = max(wi.z, 1e-9);
        let weight = mb_number(node + 1u) * wi.z;
        sum = fma(weight, mb_rest(model, f0, wi, wo), sum);
        area += weight;
    }
    return max(sum * mb_factor(model, wo), 0.0) / max(area, 1e-30);
}

// The mean by a rule.
fn mb_by_rule(model: u32, f0: f32, axis: vec3f, height: f32, wo: vec3f, rule: u32) -> f32 {
    let lobe = mb_lobe(model, wo);
    if mb_word({{RULES}} + rule) == 0u {
        if mb_word(model + 1u) == 0u {
            return mb_disc(model, f0, axis, height, wo, rule);
        }
        // What is isotropic is evaluated in the frame of wo, where the nodes lie alike about it.
        return mb_disc(model, f0, mb_into_frame(axis, lobe.rotation), height, vec3f(lobe.sin_o, 0.0, lobe.cos_o), rule);
    }
    let sum = mb_numerator(model, f0, lobe, mb_into_frame(axis, lobe.rotation), height, false, rule);
    return max(sum, 0.0) / max(mb_projected_solid_angle(axis.z, height), 1e-30);
}

// The rule of a cap: bins of cosine, azimuth and height, each with the rule in 4 bits and two squared chords in 14 bits.
fn mb_rule(at: u32, axis: vec3f, height: f32, wo: vec3f) -> u32 {
    let azimuths = mb_word(at);
    let first = mb_word(at + 2u);
    let heights = mb_word(at + 3u);
    let z = min(u32(axis.z * f32({{COSINES}})), {{COSINES}} - 1u);
    let x = abs(axis.x);
    let y = abs(axis.y);
    let a = min(u32(y / max(x + y, 1e-30) * f32(azimuths)), azimuths - 1u);
    let bits = bitcast<u32>(height * mb_number(at + 1u)) >> {{SHIFT}};
    let h = clamp(bits, first, first + heights - 1u) - first;
    let bin = mb_word(at + 4u + (z * azimuths + a) * heights + h);
    let d = vec3f(wo.x + axis.x, wo.y + axis.y, wo.z - axis.z);
    let distance2 = dot(d, d) * {{CHORD_STEPS}};
    if distance2 > f32(bin >> 18u) {
        return {{FAR}};
    }
    if distance2 > f32((bin >> 4u) & 0x3fffu) {
        return min(bin & 15u, {{OUTER}});
    }
    return bin & 15u;
}
