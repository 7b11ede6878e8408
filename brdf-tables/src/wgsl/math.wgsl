// Elementary functions. Those of the hardware may be wrong in the fourth digit (sin, cos, asin), and log2 next to 1 by 5e-7,
// which an exponent of 1000 makes 3e-4: the polynomials below are those of the library's vectors.

fn mb_word(at: u32) -> u32 {
    return {{BUFFER}}[at];
}

fn mb_number(at: u32) -> f32 {
    return bitcast<f32>({{BUFFER}}[at]);
}

// Zero below -126.
fn mb_exp2(x: f32) -> f32 {
    if x < -126.0 {
        return 0.0;
    }
    let y = min(x, 126.0);
    let whole = round(y);
    let f = y - whole;
    let p = {{EXP2}};
    return bitcast<f32>(bitcast<i32>(p) + (i32(whole) << 23u));
}

// ln(1 + f) for 1 + f in [0.7, 1.42].
fn mb_ln_1p(f: f32) -> f32 {
    let p = {{LN}};
    let z = f * f;
    return fma(p * z, f, f - z * 0.5);
}

// Of a positive, normal number.
fn mb_log2(x: f32) -> f32 {
    let bits = bitcast<i32>(x);
    // Subtracting the bits of sqrt(1/2) leaves the exponent of the reduced mantissa in the upper nine bits.
    let exponent = (bits - 0x3f3504f3) >> 23u;
    let mantissa = bitcast<f32>(bits - (exponent << 23u));
    return fma(mb_ln_1p(mantissa - 1.0), {{LOG2_E}}, f32(exponent));
}

// x^n for a base clamped at zero; 0^n = 0.
fn mb_pow(x: f32, n: f32) -> f32 {
    if x < 1e-30 {
        return 0.0;
    }
    return mb_exp2(n * mb_log2(x));
}

// ln(1 - x), with all digits where x is small; x < 1.
fn mb_ln_1m(x: f32) -> f32 {
    if abs(x) < 0.29 {
        return mb_ln_1p(-x);
    }
    return mb_log2(max(1.0 - x, 1e-30)) * {{LN_2}};
}

// (1 - x)^n, with all digits where x is small and n large; 0 from x = 1 on.
fn mb_pow_1m(x: f32, n: f32) -> f32 {
    if x > 0.9999999 {
        return 0.0;
    }
    return mb_exp2(n * (mb_ln_1m(x) * {{LOG2_E}}));
}

// Of a number in [-1, 1].
fn mb_asin(x: f32) -> f32 {
    let a = abs(x);
    let large = a > 0.5;
    let z = select(a * a, 0.5 * abs(1.0 - a), large);
    let y = select(a, sqrt(z), large);
    let p = {{ASIN}};
    let r = fma(p * z, y, y);
    return sign(x) * select(r, {{FRAC_PI_2}} - (r + r), large);
}

// Sine and cosine of an angle in [-pi, pi].
fn mb_sin_cos(x: f32) -> vec2f {
    let h = x * 0.5;
    let z = h * h;
    let p = {{SIN}};
    let s = fma(p * z, h, h);
    let c = {{COS}};
    return vec2f(2.0 * s * c, (c - s) * (c + s));
}

fn mb_sq(x: f32) -> f32 {
    return x * x;
}
