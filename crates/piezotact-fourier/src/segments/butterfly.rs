//! Butterflies: transforms of length 2, 4 and 8 of vectors, each lane by itself, and the turning of eight
//! vectors that lets lanes meet.

use pulp::Simd;

use super::eight::EightLanes;

/// Samples in a vector.
pub(super) const LANES: usize = 8;

/// Eight complex numbers, real and imaginary parts apart, on a cache line each.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(super) struct Wide {
    pub(super) re: [f64; LANES],
    pub(super) im: [f64; LANES],
}

/// Eight complex numbers in two vector registers.
#[derive(Clone, Copy)]
pub(super) struct Pair<S: Simd> {
    pub(super) re: S::f64s,
    pub(super) im: S::f64s,
}

/// The instructions, eight `f64` wide.
#[derive(Clone, Copy)]
pub(super) struct Lanes<S: Simd>(pub(super) S);

impl<S: EightLanes> Lanes<S> {
    #[inline(always)]
    pub(super) fn load(self, row: &[f64; LANES]) -> S::f64s {
        bytemuck::cast(*row)
    }

    #[inline(always)]
    pub(super) fn nothing(self) -> Pair<S> {
        Pair {
            re: self.0.splat_f64s(0.0),
            im: self.0.splat_f64s(0.0),
        }
    }

    #[inline(always)]
    pub(super) fn get(self, wide: &Wide) -> Pair<S> {
        Pair {
            re: self.load(&wide.re),
            im: self.load(&wide.im),
        }
    }

    #[inline(always)]
    pub(super) fn put(self, value: Pair<S>, wide: &mut Wide) {
        wide.re = bytemuck::cast(value.re);
        wide.im = bytemuck::cast(value.im);
    }

    #[inline(always)]
    fn add(self, a: Pair<S>, b: Pair<S>) -> Pair<S> {
        Pair {
            re: self.0.add_f64s(a.re, b.re),
            im: self.0.add_f64s(a.im, b.im),
        }
    }

    #[inline(always)]
    fn sub(self, a: Pair<S>, b: Pair<S>) -> Pair<S> {
        Pair {
            re: self.0.sub_f64s(a.re, b.re),
            im: self.0.sub_f64s(a.im, b.im),
        }
    }

    /// a − ib
    #[inline(always)]
    fn sub_i(self, a: Pair<S>, b: Pair<S>) -> Pair<S> {
        Pair {
            re: self.0.add_f64s(a.re, b.im),
            im: self.0.sub_f64s(a.im, b.re),
        }
    }

    /// a + ib
    #[inline(always)]
    fn add_i(self, a: Pair<S>, b: Pair<S>) -> Pair<S> {
        Pair {
            re: self.0.sub_f64s(a.re, b.im),
            im: self.0.add_f64s(a.im, b.re),
        }
    }

    #[inline(always)]
    pub(super) fn mul(self, a: Pair<S>, b: Pair<S>) -> Pair<S> {
        let s = self.0;
        Pair {
            re: s.negate_mul_add_e_f64s(a.im, b.im, s.mul_f64s(a.re, b.re)),
            im: s.mul_add_e_f64s(a.im, b.re, s.mul_f64s(a.re, b.im)),
        }
    }

    #[inline(always)]
    pub(super) fn butterfly_2(self, x: [Pair<S>; 2]) -> [Pair<S>; 2] {
        [self.add(x[0], x[1]), self.sub(x[0], x[1])]
    }

    #[inline(always)]
    pub(super) fn butterfly_4(self, x: [Pair<S>; 4]) -> [Pair<S>; 4] {
        let (even, odd) = (
            self.butterfly_2([x[0], x[2]]),
            self.butterfly_2([x[1], x[3]]),
        );
        [
            self.add(even[0], odd[0]),
            self.sub_i(even[1], odd[1]),
            self.sub(even[0], odd[0]),
            self.add_i(even[1], odd[1]),
        ]
    }

    #[inline(always)]
    pub(super) fn butterfly_8(self, x: [Pair<S>; 8]) -> [Pair<S>; 8] {
        let s = self.0;
        let even = self.butterfly_4([
            self.add(x[0], x[4]),
            self.add(x[1], x[5]),
            self.add(x[2], x[6]),
            self.add(x[3], x[7]),
        ]);
        let b = [
            self.sub(x[0], x[4]),
            self.sub(x[1], x[5]),
            self.sub(x[2], x[6]),
            self.sub(x[3], x[7]),
        ];
        // (1 − i)·b1 and (−1 − i)·b3; their factor √½ goes into the last additions.
        let p = Pair::<S> {
            re: s.add_f64s(b[1].re, b[1].im),
            im: s.sub_f64s(b[1].im, b[1].re),
        };
        let q = Pair::<S> {
            re: s.sub_f64s(b[3].im, b[3].re),
            im: s.add_f64s(b[3].im, b[3].re),
        };
        let both = Pair::<S> {
            re: s.add_f64s(p.re, q.re),
            im: s.sub_f64s(p.im, q.im),
        };
        let apart = Pair::<S> {
            re: s.sub_f64s(p.re, q.re),
            im: s.add_f64s(p.im, q.im),
        };
        let (c, d) = (self.sub_i(b[0], b[2]), self.add_i(b[0], b[2]));
        let root = s.splat_f64s(std::f64::consts::FRAC_1_SQRT_2);
        [
            even[0],
            Pair {
                re: s.mul_add_e_f64s(root, both.re, c.re),
                im: s.mul_add_e_f64s(root, both.im, c.im),
            },
            even[1],
            Pair {
                re: s.mul_add_e_f64s(root, apart.im, d.re),
                im: s.negate_mul_add_e_f64s(root, apart.re, d.im),
            },
            even[2],
            Pair {
                re: s.negate_mul_add_e_f64s(root, both.re, c.re),
                im: s.negate_mul_add_e_f64s(root, both.im, c.im),
            },
            even[3],
            Pair {
                re: s.negate_mul_add_e_f64s(root, apart.im, d.re),
                im: s.mul_add_e_f64s(root, apart.re, d.im),
            },
        ]
    }

    /// Lane l of every vector, as vector l.
    #[inline(always)]
    pub(super) fn transposed(self, rows: [S::f64s; 8]) -> [S::f64s; 8] {
        let s = self.0;
        let [a, b, c, d, e, f, g, h] = rows;
        // Neighbouring rows lane by lane, and then quarters of them, twice.
        let [i, j, k, l] = [s.even(a, b), s.even(c, d), s.even(e, f), s.even(g, h)];
        let [m, n, o, p] = [s.odd(a, b), s.odd(c, d), s.odd(e, f), s.odd(g, h)];
        let [a, b, c, d] = [
            s.even_twos(i, j),
            s.even_twos(k, l),
            s.even_twos(m, n),
            s.even_twos(o, p),
        ];
        let [e, f, g, h] = [
            s.odd_twos(i, j),
            s.odd_twos(k, l),
            s.odd_twos(m, n),
            s.odd_twos(o, p),
        ];
        [
            s.even_twos(a, b),
            s.even_twos(c, d),
            s.even_twos(e, f),
            s.even_twos(g, h),
            s.odd_twos(a, b),
            s.odd_twos(c, d),
            s.odd_twos(e, f),
            s.odd_twos(g, h),
        ]
    }
}
