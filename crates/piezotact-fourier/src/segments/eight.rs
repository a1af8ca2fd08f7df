//! The instructions for eight `f64` at once, and whether the machine has them.

use pulp::Simd;

/// AVX-512.
#[cfg(target_arch = "x86_64")]
pub(super) type Eight = pulp::x86::V4;
/// No other processor has instructions for eight `f64` at once: this is never made.
#[cfg(not(target_arch = "x86_64"))]
pub(super) type Eight = pulp::Scalar512b;

/// The instructions, where the machine has them.
pub(super) fn eight() -> Option<Eight> {
    #[cfg(target_arch = "x86_64")]
    return Eight::try_new();
    #[cfg(not(target_arch = "x86_64"))]
    None
}

/// Eight `f64` in a vector, and the shuffles of a transposition, each of which is one instruction.
pub(super) trait EightLanes: Simd {
    /// a0 b0 a2 b2 a4 b4 a6 b6
    fn even(self, a: Self::f64s, b: Self::f64s) -> Self::f64s;
    /// a1 b1 a3 b3 a5 b5 a7 b7
    fn odd(self, a: Self::f64s, b: Self::f64s) -> Self::f64s;
    /// a0 a1 a4 a5 b0 b1 b4 b5
    fn even_twos(self, a: Self::f64s, b: Self::f64s) -> Self::f64s;
    /// a2 a3 a6 a7 b2 b3 b6 b7
    fn odd_twos(self, a: Self::f64s, b: Self::f64s) -> Self::f64s;
}

#[cfg(target_arch = "x86_64")]
impl EightLanes for pulp::x86::V4 {
    #[inline(always)]
    fn even(self, a: Self::f64s, b: Self::f64s) -> Self::f64s {
        let (a, b) = (pulp::cast(a), pulp::cast(b));
        pulp::cast(self.avx512f._mm512_unpacklo_pd(a, b))
    }

    #[inline(always)]
    fn odd(self, a: Self::f64s, b: Self::f64s) -> Self::f64s {
        let (a, b) = (pulp::cast(a), pulp::cast(b));
        pulp::cast(self.avx512f._mm512_unpackhi_pd(a, b))
    }

    #[inline(always)]
    fn even_twos(self, a: Self::f64s, b: Self::f64s) -> Self::f64s {
        let (a, b) = (pulp::cast(a), pulp::cast(b));
        pulp::cast(self.avx512f._mm512_shuffle_f64x2::<0b10_00_10_00>(a, b))
    }

    #[inline(always)]
    fn odd_twos(self, a: Self::f64s, b: Self::f64s) -> Self::f64s {
        let (a, b) = (pulp::cast(a), pulp::cast(b));
        pulp::cast(self.avx512f._mm512_shuffle_f64x2::<0b11_01_11_01>(a, b))
    }
}

/// The same without instructions for it, so that any machine can test the transforms.
#[cfg(any(test, not(target_arch = "x86_64")))]
impl EightLanes for pulp::Scalar512b {
    fn even(self, a: Self::f64s, b: Self::f64s) -> Self::f64s {
        let (a, b): ([f64; 8], [f64; 8]) = (pulp::cast(a), pulp::cast(b));
        pulp::cast([a[0], b[0], a[2], b[2], a[4], b[4], a[6], b[6]])
    }

    fn odd(self, a: Self::f64s, b: Self::f64s) -> Self::f64s {
        let (a, b): ([f64; 8], [f64; 8]) = (pulp::cast(a), pulp::cast(b));
        pulp::cast([a[1], b[1], a[3], b[3], a[5], b[5], a[7], b[7]])
    }

    fn even_twos(self, a: Self::f64s, b: Self::f64s) -> Self::f64s {
        let (a, b): ([f64; 8], [f64; 8]) = (pulp::cast(a), pulp::cast(b));
        pulp::cast([a[0], a[1], a[4], a[5], b[0], b[1], b[4], b[5]])
    }

    fn odd_twos(self, a: Self::f64s, b: Self::f64s) -> Self::f64s {
        let (a, b): ([f64; 8], [f64; 8]) = (pulp::cast(a), pulp::cast(b));
        pulp::cast([a[2], a[3], a[6], a[7], b[2], b[3], b[6], b[7]])
    }
}
