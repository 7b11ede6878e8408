//! Code compiled for the vectors of the machine.

use fearless_simd::{Level, Simd};

/// Runs `f`, compiled for AVX2 where the machine has it: scalar code gains from its encodings. Nothing is fused that is not
/// written so, so pictures do not depend on it.
#[inline(always)]
pub(crate) fn widest<T>(level: Level, f: impl FnOnce() -> T) -> T {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    if let Some(avx2) = level.as_avx2() {
        return avx2.vectorize(f);
    }
    let _ = level;
    f()
}

/// Asks for a value to be brought nearer, where the processor can be asked. It changes no result.
#[inline(always)]
pub(crate) fn prefetch<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    {
        use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: a hint about an address, which is that of a value at that; nothing is read or written.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(core::ptr::from_ref(value).cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}
