// Fitted lobes of the corners of a cell, blended in the mirror frame of the cap.

fn mb_lobes(at: u32, axis: vec3f, height: f32, wo: vec3f) -> f32 {
    let nodes = vec3u(mb_word(at), mb_word(at + 1u), mb_word(at + 2u));
    let count = mb_word(at + 6u);
    // The mirror frame.
    let sin_t = sqrt(axis.x * axis.x + axis.y * axis.y);
    var cs = vec2f(1.0, 0.0);
    if sin_t >= 1e-9 {
        cs = axis.xy / sin_t;
    }
    let x = cs.x * wo.x + cs.y * wo.y;
    var y = cs.x * wo.y - cs.y * wo.x;
    if axis.x * axis.y < 0.0 {
        y = -y;
    }
    // (x cos + z sin, y, z cos - x sin), with z = 1 - off: the last component has all its digits near the pole.
    let d = vec3f(wo.x + axis.x, wo.y + axis.y, wo.z - axis.z);
    let off = 0.5 * dot(d, d);
    let w = vec3f(x * axis.z + wo.z * sin_t, y, off);
    // Places on the axes.
    let theta = select({{FRAC_PI_2}} - mb_asin(min(axis.z, 1.0)), mb_asin(min(sin_t, 1.0)), axis.z > sin_t) * {{FRAC_2_PI}};
    let phi = select(mb_asin(min(abs(cs.y), 1.0)) * {{FRAC_2_PI}}, 0.0, nodes.y == 1u);
    let tau = mb_ln_1m(-height * mb_number(at + 3u)) * mb_number(at + 4u);
    let stretch = mb_number(at + 5u);
    let omega = select(mb_pow(tau, stretch), tau, stretch == 1.0);
    let place = clamp(vec3f(theta, phi, omega), vec3f(0.0), vec3f(1.0)) * vec3f(nodes - 1u);
    let low = floor(min(place, vec3f(max(nodes, vec3u(2u)) - 2u)));
    let f = place - low;
    let node = vec3u(low);
    var sum = 0.0;
    for (var corner = 0u; corner < 8u; corner++) {
        let up = vec3u(corner >> 2u, corner >> 1u, corner) & vec3u(1u);
        let weights = select(1.0 - f, f, up == vec3u(1u));
        let weight = weights.x * weights.y * weights.z;
        // A weight of zero is that of a node beyond the last, too.
        if weight > 0.0 {
            let i = node + up;
            var lobe = at + 7u + ((i.x * nodes.y + i.y) * nodes.z + i.z) * count * 6u;
            for (var k = 0u; k < count; k++) {
                // [x, y, 1 - z, amplitude, exponent, 1 - (the squared length of the axis + 1)/2]
                let a = vec3f(mb_number(lobe), mb_number(lobe + 1u), mb_number(lobe + 2u));
                let chord = a - w;
                let off_axis = fma(0.5, dot(chord, chord), mb_number(lobe + 5u));
                sum = fma(weight * mb_number(lobe + 3u), mb_pow_1m(off_axis, mb_number(lobe + 4u)), sum);
                lobe += 6u;
            }
        }
    }
    return max(sum, 0.0);
}
