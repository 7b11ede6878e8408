use super::*;
use fearless_simd::{Level, dispatch};

/// Every lane function against f64 at points that cover its range.
#[test]
fn lane_functions_match_f64() {
    #[inline(always)]
    fn check<S: Simd>(simd: S) {
        for i in 0..4096 {
            let x = (i as f64 + 0.5) / 2048.0 - 1.0;
            let v = f32x16::splat(simd, x as f32);
            let x = f64::from(x as f32);
            let angle = v * v.lit(3.1);
            let (s, c) = Real::sin_cos(angle);
            let a = f64::from(angle[0]);
            assert!((f64::from(s[0]) - a.sin()).abs() < 1e-6, "sin {a}");
            assert!((f64::from(c[0]) - a.cos()).abs() < 1e-6, "cos {a}");
            assert!((f64::from(v.asin()[0]) - x.asin()).abs() < 4e-7, "asin {x}");
            let (low, high) = (
                [0x0002_0001, 0x0004_0003, 0x0006_0005, 0x0008_0007],
                [0xfff1_fff0, 0xfff3_fff2, 0xfff5_fff4, 0xffff_fff6],
            );
            let cell = Real::fetch_cell(Real::floor(v + v.lit(1.0)), &[low, high]);
            let right = if v[0] < 0.0 { low } else { high };
            for (found, pair) in cell.into_iter().zip(right) {
                assert_eq!(
                    found.map(|half| (half[i % LANES] - 1.0) * 65536.0),
                    [(pair & 0xffff) as f32, (pair >> 16) as f32]
                );
            }
            if x != 0.0 {
                let r = f64::from(v.recip()[0]) * x;
                assert!((r - 1.0).abs() < 1e-6, "recip {x}: {r}");
            }
            let e = v * v.lit(60.0);
            assert!((f64::from(e.exp2()[0]) / f64::from(e[0]).exp2() - 1.0).abs() < 3e-7, "exp2 {x}");
            let positive = e.exp2();
            assert!((f64::from(positive.log2()[0]) - f64::from(positive[0]).log2()).abs() < 1e-5, "log2 {x}");
            let base = Real::abs(v);
            let exact = x.abs().powf(500.0);
            assert!((f64::from(base.powf(v.lit(500.0))[0]) - exact).abs() < 1e-4 * exact + 1e-37, "pow {x}");
        }
        let zero = f32x16::splat(simd, 0.0);
        assert_eq!(zero.powf(zero.lit(20.0))[0], 0.0);
        assert_eq!(zero.lit(-1.0).powf(zero.lit(20.0))[0], 0.0);
    }
    dispatch!(Level::new(), simd => check(simd));
}
