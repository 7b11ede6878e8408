// The mean BRDF of the specular part of a table at unit strength over a cap, sr^-1.
//
// `table` is the place of the table in the buffer. `axis` is a unit vector in the local frame (z = normal), its z >= 0;
// `solid_angle` that of the whole cap, in (0, 2 pi] sr; `wo` the unit direction to the eye. 0 for wo below the horizon.
fn mean_brdf(table: u32, axis: vec3f, solid_angle: f32, wo: vec3f) -> f32 {
    return mean_brdf_schlick(table, -1.0, axis, solid_angle, wo);
}

// The same as if facets had Schlick's reflectance, grey, of f0 at normal incidence; that of the table where f0 < 0.
fn mean_brdf_schlick(table: u32, f0: f32, axis: vec3f, solid_angle: f32, wo: vec3f) -> f32 {
    let kind = mb_word(table);
    if wo.z <= 0.0 || kind == {{DIFFUSE}} {
        return 0.0;
    }
    let height = clamp(solid_angle * {{OVER_TWO_PI}}, {{MIN_HEIGHT}}, 1.0);
    let model = mb_word(table + 1u);
    let at = mb_word(table + 2u);
    if kind == {{CUBATURE}} {
        return mb_by_rule(model, f0, axis, height, wo, mb_rule(at, axis, height, wo));
    }
    var value: f32;
    if kind == {{ZONAL}} {
        value = mb_zonal(model, at, axis, height, wo);
    } else {
        value = mb_lobes(at, axis, height, wo);
    }
    let facets = mb_word(model) == {{BECKMANN}} || mb_word(model) == {{GGX}};
    if f0 >= 0.0 && facets {
        let h = axis + wo;
        let cos_d = min(0.5 * sqrt(dot(h, h)), 1.0);
        let own = mb_fresnel(model, -1.0, cos_d);
        value *= select(0.0, mb_schlick(cos_d, f0) / max(own, 1e-30), own > 0.0);
    }
    return value;
}

// Albedo of the Lambertian part.
fn mean_brdf_diffuse(table: u32) -> vec3f {
    return vec3f(mb_number(table + 3u), mb_number(table + 4u), mb_number(table + 5u));
}

// Strength of the specular part.
fn mean_brdf_specular(table: u32) -> vec3f {
    return vec3f(mb_number(table + 6u), mb_number(table + 7u), mb_number(table + 8u));
}

// Projected solid angle of a cap above the horizon, sr: its irradiance over its radiance.
fn mean_brdf_projected_solid_angle(axis: vec3f, solid_angle: f32) -> f32 {
    return mb_projected_solid_angle(axis.z, clamp(solid_angle * {{OVER_TWO_PI}}, {{MIN_HEIGHT}}, 1.0));
}
