// Integral of the cosine over a cap of height h = 1 - cos(sigma) around an axis of cosine cz >= 0, clipped by the horizon, sr.
fn mb_projected_solid_angle(cz: f32, height: f32) -> f32 {
    let sin2_r = height * (2.0 - height);
    let whole = {{PI}} * sin2_r * cz;
    let chord2 = sin2_r - cz * cz;
    if chord2 <= 0.0 {
        return whole;
    }
    let sin2_t = max(1.0 - cz * cz, 1e-12);
    let sin_p = sqrt(min(chord2 / sin2_t, 1.0));
    let cos_p = (1.0 - height) / sqrt(sin2_t);
    let phi = mb_asin(sin_p);
    let s2 = sin_p * sin_p;
    // phi - sin(phi) cos(phi) loses its digits for a short chord: its series there.
    let short = s2 * sin_p * ({{SEGMENT}});
    let segment = select(phi - sin_p * cos_p, short, sin_p < 0.3);
    let sin_r = sqrt(max(sin2_r, 1e-30));
    let psi = {{FRAC_PI_2}} - mb_asin(clamp((1.0 - height) * cz / (sin_r * sqrt(sin2_t)), -1.0, 1.0));
    return segment + cz * cz * sin_p * cos_p + sin2_r * cz * ({{PI}} - psi);
}
