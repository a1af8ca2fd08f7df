//! A power-of-two transform of two real segments in eight lanes of `f64`, summed in the order it comes out.
//!
//! Lane l holds the samples l, 8 + l, 16 + l … of a segment, so vectors are loaded as the samples lie in memory
//! and eight transforms of an eighth of the length run beside each other without touching one another. The
//! last step turns eight vectors by a transposition and joins the lanes with one transform of length 8.
//! Bins come out in the order of their reversed digits. Sums of powers do not mind, so the order is undone
//! once, when the sums are read.

use num_complex::Complex;
use pulp::{Simd, WithSimd};

/// Samples in a vector.
pub(super) const LANES: usize = 8;

/// The lengths of segments that these transforms are for, powers of two.
pub(super) const LENGTHS: std::ops::RangeInclusive<usize> = 128..=65_536;

/// Eight complex numbers, real and imaginary parts apart, on a cache line each.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
struct Wide {
    re: [f64; LANES],
    im: [f64; LANES],
}

/// Sums over segments of two signals for eight bins.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
struct Joint {
    xx: [f64; LANES],
    yy: [f64; LANES],
    re: [f64; LANES],
    im: [f64; LANES],
}

/// Eight windowed samples' weights or eight bins' power, on a cache line.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
struct Row([f64; LANES]);

/// What follows an eightfold butterfly: the factors of its results 1 to 7.
#[derive(Clone, Copy, Debug)]
struct Turns {
    re: [f64; 7],
    im: [f64; 7],
}

/// The tables of a transform of segments of one length.
#[derive(Clone, Debug)]
pub(super) struct LaneTransform {
    window: Vec<Row>,
    detrend: Offset,
    /// The eightfold passes over the vectors: blocks of eight times as many vectors as a pass has turns.
    passes: Vec<Vec<Turns>>,
    last: LastPass,
    /// exp(−2πi·l·k/n) for the bin k < n/8 that each vector holds before the lanes are joined.
    lane_turns: Vec<Wide>,
}

/// What is taken away from a segment before the window.
#[derive(Clone, Copy, Debug)]
pub(super) enum Offset {
    /// Nothing.
    None,
    /// The mean.
    Mean,
}

/// How many vectors the butterflies of the last pass before the lanes are joined take.
#[derive(Clone, Copy, Debug)]
enum LastPass {
    Two,
    Four,
    Eight,
}

fn turn(numerator: usize, denominator: usize) -> Complex<f64> {
    let angle = (numerator % denominator) as f64 / denominator as f64;
    Complex::from_polar(1.0, -std::f64::consts::TAU * angle)
}

impl LaneTransform {
    /// For segments of the length of `window`, one of [`LENGTHS`] and a power of two.
    pub(super) fn new(window: &[f64], detrend: Offset) -> Self {
        let n = window.len();
        debug_assert!(LENGTHS.contains(&n) && n.is_power_of_two());
        let vectors = n / LANES;
        let mut passes = Vec::new();
        let mut block = vectors;
        while block > LANES {
            let stride = block / LANES;
            let turns = |j: usize| {
                let factor = |r: usize| turn(j * (r + 1), block);
                Turns {
                    re: std::array::from_fn(|r| factor(r).re),
                    im: std::array::from_fn(|r| factor(r).im),
                }
            };
            passes.push((0..stride).map(turns).collect());
            block = stride;
        }
        let last = match block {
            2 => LastPass::Two,
            4 => LastPass::Four,
            _ => LastPass::Eight,
        };
        let lane_turns = (0..vectors)
            .map(|position| {
                let factor = |lane| turn(lane * reversed(position, vectors), n);
                Wide {
                    re: std::array::from_fn(|lane| factor(lane).re),
                    im: std::array::from_fn(|lane| factor(lane).im),
                }
            })
            .collect();
        Self {
            window: window.as_chunks().0.iter().map(|row| Row(*row)).collect(),
            detrend,
            passes,
            last,
            lane_turns,
        }
    }

    fn vectors(&self) -> usize {
        self.window.len()
    }

    /// The bin of every place in a sum, as vectors of eight.
    fn bins(&self) -> impl Iterator<Item = usize> {
        let vectors = self.vectors();
        (0..vectors).flat_map(move |place| {
            (0..LANES).map(move |lane| {
                reversed(place - place % LANES + lane, vectors) + place % LANES * vectors
            })
        })
    }
}

/// The bin that `position` of a transform of `vectors` holds after eightfold passes and one of what is left.
fn reversed(position: usize, vectors: usize) -> usize {
    let (mut position, mut block) = (position, vectors);
    let (mut bin, mut weight) = (0, 1);
    while block > 1 {
        let radix = block.min(LANES);
        block /= radix;
        bin += weight * (position / block);
        position %= block;
        weight *= radix;
    }
    bin
}

/// A sum of |Z|² over pairs of segments, Z = A + iB.
#[derive(Clone, Debug)]
pub(super) struct LanePower {
    transform: LaneTransform,
    z: Vec<Wide>,
    sums: Vec<Row>,
}

impl LanePower {
    pub(super) fn new(transform: LaneTransform) -> Self {
        Self {
            z: vec![Wide::default(); transform.vectors()],
            sums: vec![Row::default(); transform.vectors()],
            transform,
        }
    }

    pub(super) fn clear(&mut self) {
        self.sums.fill(Row::default());
    }

    /// Adds segments `a` and `b` with instructions for eight `f64` at once.
    pub(super) fn add<S: Simd>(&mut self, simd: S, a: &[f64], b: &[f64]) {
        simd.vectorize(AddPower { to: self, a, b });
    }

    /// The sum, one value a bin.
    pub(super) fn in_order(&self) -> Vec<f64> {
        let mut ordered = vec![0.0; LANES * self.sums.len()];
        let values = self.sums.iter().flat_map(|row| row.0);
        for (bin, value) in self.transform.bins().zip(values) {
            ordered[bin] = value;
        }
        ordered
    }
}

struct AddPower<'a> {
    to: &'a mut LanePower,
    a: &'a [f64],
    b: &'a [f64],
}

impl WithSimd for AddPower<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let LanePower { transform, z, sums } = self.to;
        let simd = Lanes(simd);
        simd.all_but_last(transform, self.a, self.b, z);
        match transform.last {
            LastPass::Two => simd.power::<2>(transform, z, sums),
            LastPass::Four => simd.power::<4>(transform, z, sums),
            LastPass::Eight => simd.power::<8>(transform, z, sums),
        }
    }
}

/// Sums of |X|², |Y|² and conj(X)·Y over pairs of segments of two signals.
#[derive(Clone, Debug)]
pub(crate) struct LaneCross {
    transform: LaneTransform,
    x: Vec<Wide>,
    y: Vec<Wide>,
    sums: Vec<Joint>,
}

impl LaneCross {
    pub(super) fn new(transform: LaneTransform) -> Self {
        let vectors = transform.vectors();
        Self {
            x: vec![Wide::default(); vectors],
            y: vec![Wide::default(); vectors],
            sums: vec![Joint::default(); vectors],
            transform,
        }
    }

    pub(super) fn clear(&mut self) {
        self.sums.fill(Joint::default());
    }

    /// Adds two segments of x and the same two of y with instructions for eight `f64` at once.
    pub(super) fn add<S: Simd>(&mut self, simd: S, x: [&[f64]; 2], y: [&[f64]; 2]) {
        simd.vectorize(AddCross { to: self, x, y });
    }

    /// Σ|X|², Σ|Y|² and Σconj(X)·Y, one value a bin.
    pub(super) fn in_order(&self) -> (Vec<f64>, Vec<f64>, Vec<Complex<f64>>) {
        let n = LANES * self.sums.len();
        let (mut xx, mut yy) = (vec![0.0; n], vec![0.0; n]);
        let mut xy = vec![Complex::default(); n];
        for (place, bin) in self.transform.bins().enumerate() {
            let (sums, lane) = (&self.sums[place / LANES], place % LANES);
            xx[bin] = sums.xx[lane];
            yy[bin] = sums.yy[lane];
            xy[bin] = Complex::new(sums.re[lane], sums.im[lane]);
        }
        (xx, yy, xy)
    }
}

struct AddCross<'a> {
    to: &'a mut LaneCross,
    x: [&'a [f64]; 2],
    y: [&'a [f64]; 2],
}

impl WithSimd for AddCross<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let LaneCross {
            transform,
            x,
            y,
            sums,
        } = self.to;
        let simd = Lanes(simd);
        simd.all_but_last(transform, self.x[0], self.x[1], x);
        simd.all_but_last(transform, self.y[0], self.y[1], y);
        match transform.last {
            LastPass::Two => simd.cross::<2>(transform, x, y, sums),
            LastPass::Four => simd.cross::<4>(transform, x, y, sums),
            LastPass::Eight => simd.cross::<8>(transform, x, y, sums),
        }
    }
}

/// Eight complex numbers in two vector registers.
#[derive(Clone, Copy)]
struct Pair<S: Simd> {
    re: S::f64s,
    im: S::f64s,
}

/// The instructions, eight `f64` wide.
#[derive(Clone, Copy)]
struct Lanes<S: Simd>(S);

impl<S: Simd> Lanes<S> {
    #[inline(always)]
    fn load(self, row: &[f64; LANES]) -> S::f64s {
        bytemuck::cast(*row)
    }

    #[inline(always)]
    fn nothing(self) -> Pair<S> {
        Pair {
            re: self.0.splat_f64s(0.0),
            im: self.0.splat_f64s(0.0),
        }
    }

    #[inline(always)]
    fn get(self, wide: &Wide) -> Pair<S> {
        Pair {
            re: self.load(&wide.re),
            im: self.load(&wide.im),
        }
    }

    #[inline(always)]
    fn put(self, value: Pair<S>, wide: &mut Wide) {
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
    fn mul(self, a: Pair<S>, b: Pair<S>) -> Pair<S> {
        let s = self.0;
        Pair {
            re: s.negate_mul_add_e_f64s(a.im, b.im, s.mul_f64s(a.re, b.re)),
            im: s.mul_add_e_f64s(a.im, b.re, s.mul_f64s(a.re, b.im)),
        }
    }

    #[inline(always)]
    fn butterfly_2(self, x: [Pair<S>; 2]) -> [Pair<S>; 2] {
        [self.add(x[0], x[1]), self.sub(x[0], x[1])]
    }

    #[inline(always)]
    fn butterfly_4(self, x: [Pair<S>; 4]) -> [Pair<S>; 4] {
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
    fn butterfly_8(self, x: [Pair<S>; 8]) -> [Pair<S>; 8] {
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

    /// Detrends and windows `a` as real and `b` as imaginary part into `z`, and does the eightfold passes.
    #[inline(always)]
    fn all_but_last(self, plan: &LaneTransform, a: &[f64], b: &[f64], z: &mut [Wide]) {
        let Some((first, others)) = plan.passes.split_first() else {
            return;
        };
        let (a, b) = (a.as_chunks::<LANES>().0, b.as_chunks::<LANES>().0);
        let offsets = match plan.detrend {
            Offset::None => [0.0; 2],
            Offset::Mean => [self.mean(a), self.mean(b)],
        };
        self.first_pass(plan, first, [a, b], offsets, z);
        for turns in others {
            for block in z.chunks_exact_mut(LANES * turns.len()) {
                let mut rest = block;
                let mut parts: [&mut [Wide]; 8] = std::array::from_fn(|_| {
                    let (part, after) = std::mem::take(&mut rest).split_at_mut(turns.len());
                    rest = after;
                    part
                });
                for (j, turns) in turns.iter().enumerate() {
                    let mut x = [self.nothing(); 8];
                    for (x, part) in x.iter_mut().zip(&parts) {
                        *x = self.get(&part[j]);
                    }
                    self.turned_butterfly(x, turns, j, &mut parts);
                }
            }
        }
    }

    #[inline(always)]
    fn first_pass(
        self,
        plan: &LaneTransform,
        turns: &[Turns],
        segments: [&[[f64; LANES]]; 2],
        offsets: [f64; 2],
        z: &mut [Wide],
    ) {
        let s = self.0;
        let stride = turns.len();
        let (ta, tb) = (s.splat_f64s(offsets[0]), s.splat_f64s(offsets[1]));
        let a = eighths(segments[0], stride);
        let b = eighths(segments[1], stride);
        let window = eighths(&plan.window, stride);
        let mut rest = z;
        let mut parts: [&mut [Wide]; 8] = std::array::from_fn(|_| {
            let (part, after) = std::mem::take(&mut rest).split_at_mut(stride);
            rest = after;
            part
        });
        for (j, turns) in turns.iter().enumerate() {
            let mut x = [self.nothing(); 8];
            for (((x, a), b), window) in x.iter_mut().zip(a).zip(b).zip(window) {
                let weight = self.load(&window[j].0);
                *x = Pair {
                    re: s.mul_f64s(s.sub_f64s(self.load(&a[j]), ta), weight),
                    im: s.mul_f64s(s.sub_f64s(self.load(&b[j]), tb), weight),
                };
            }
            self.turned_butterfly(x, turns, j, &mut parts);
        }
    }

    #[inline(always)]
    fn turned_butterfly(
        self,
        x: [Pair<S>; 8],
        turns: &Turns,
        j: usize,
        parts: &mut [&mut [Wide]; 8],
    ) {
        let y = self.butterfly_8(x);
        self.put(y[0], &mut parts[0][j]);
        for r in 0..7 {
            let turn = Pair {
                re: self.0.splat_f64s(turns.re[r]),
                im: self.0.splat_f64s(turns.im[r]),
            };
            self.put(self.mul(y[r + 1], turn), &mut parts[r + 1][j]);
        }
    }

    #[inline(always)]
    fn mean(self, segment: &[[f64; LANES]]) -> f64 {
        let s = self.0;
        let mut sums = [s.splat_f64s(0.0); 8];
        for rows in segment.as_chunks::<8>().0 {
            for (sum, row) in sums.iter_mut().zip(rows) {
                *sum = s.add_f64s(*sum, self.load(row));
            }
        }
        let [a, b, c, d, e, f, g, h] = sums;
        let (a, b, c, d) = (
            s.add_f64s(a, b),
            s.add_f64s(c, d),
            s.add_f64s(e, f),
            s.add_f64s(g, h),
        );
        let sum = s.add_f64s(s.add_f64s(a, b), s.add_f64s(c, d));
        let lanes: [f64; LANES] = bytemuck::cast(sum);
        lanes.iter().sum::<f64>() / (LANES * segment.len()) as f64
    }

    /// The last butterflies over eight vectors, and then over their lanes: 64 bins.
    #[inline(always)]
    fn join<const RADIX: usize>(self, z: &[Wide; 8], turns: &[Wide; 8]) -> [Pair<S>; 8] {
        let s = self.0;
        let mut x = [self.nothing(); 8];
        for (x, z) in x.iter_mut().zip(z) {
            *x = self.get(z);
        }
        let y = match RADIX {
            2 => {
                let [a, b] = self.butterfly_2([x[0], x[1]]);
                let [c, d] = self.butterfly_2([x[2], x[3]]);
                let [e, f] = self.butterfly_2([x[4], x[5]]);
                let [g, h] = self.butterfly_2([x[6], x[7]]);
                [a, b, c, d, e, f, g, h]
            }
            4 => {
                let [a, b, c, d] = self.butterfly_4([x[0], x[1], x[2], x[3]]);
                let [e, f, g, h] = self.butterfly_4([x[4], x[5], x[6], x[7]]);
                [a, b, c, d, e, f, g, h]
            }
            _ => self.butterfly_8(x),
        };
        let (mut re, mut im) = ([s.splat_f64s(0.0); 8], [s.splat_f64s(0.0); 8]);
        for (((re, im), y), turn) in re.iter_mut().zip(&mut im).zip(y).zip(turns) {
            let turned = self.mul(y, self.get(turn));
            (*re, *im) = (turned.re, turned.im);
        }
        let (re, im) = (transposed::<S>(re), transposed::<S>(im));
        for ((x, re), im) in x.iter_mut().zip(re).zip(im) {
            *x = Pair { re, im };
        }
        self.butterfly_8(x)
    }

    #[inline(always)]
    fn power<const RADIX: usize>(self, plan: &LaneTransform, z: &[Wide], sums: &mut [Row]) {
        let s = self.0;
        let groups = z.as_chunks::<8>().0.iter();
        let groups = groups.zip(plan.lane_turns.as_chunks::<8>().0);
        for ((z, turns), sums) in groups.zip(sums.as_chunks_mut::<8>().0) {
            let z = self.join::<RADIX>(z, turns);
            for (z, sum) in z.iter().zip(sums) {
                let power = s.mul_add_e_f64s(z.re, z.re, self.load(&sum.0));
                sum.0 = bytemuck::cast(s.mul_add_e_f64s(z.im, z.im, power));
            }
        }
    }

    #[inline(always)]
    fn cross<const RADIX: usize>(
        self,
        plan: &LaneTransform,
        x: &[Wide],
        y: &[Wide],
        sums: &mut [Joint],
    ) {
        let s = self.0;
        let groups = x.as_chunks::<8>().0.iter().zip(y.as_chunks::<8>().0);
        let groups = groups.zip(plan.lane_turns.as_chunks::<8>().0);
        for (((x, y), turns), sums) in groups.zip(sums.as_chunks_mut::<8>().0) {
            let x = self.join::<RADIX>(x, turns);
            let y = self.join::<RADIX>(y, turns);
            for ((x, y), sum) in x.iter().zip(&y).zip(sums) {
                let xx = s.mul_add_e_f64s(x.re, x.re, self.load(&sum.xx));
                let yy = s.mul_add_e_f64s(y.re, y.re, self.load(&sum.yy));
                let re = s.mul_add_e_f64s(x.re, y.re, self.load(&sum.re));
                let im = s.mul_add_e_f64s(x.re, y.im, self.load(&sum.im));
                sum.xx = bytemuck::cast(s.mul_add_e_f64s(x.im, x.im, xx));
                sum.yy = bytemuck::cast(s.mul_add_e_f64s(y.im, y.im, yy));
                sum.re = bytemuck::cast(s.mul_add_e_f64s(x.im, y.im, re));
                sum.im = bytemuck::cast(s.negate_mul_add_e_f64s(x.im, y.re, im));
            }
        }
    }
}

/// The first eight parts of `stride` of a slice.
#[inline(always)]
fn eighths<T>(all: &[T], stride: usize) -> [&[T]; 8] {
    std::array::from_fn(|q| &all[q * stride..(q + 1) * stride])
}

/// Lane l of every vector, as vector l.
#[inline(always)]
fn transposed<S: Simd>(rows: [S::f64s; 8]) -> [S::f64s; 8] {
    let mut r = [[0.0; 8]; 8];
    for (r, row) in r.iter_mut().zip(rows) {
        *r = bytemuck::cast(row);
    }
    // Neighbouring rows, then quarters of them twice: the shuffles that processors have.
    let low = |a: [f64; 8], b: [f64; 8]| [a[0], b[0], a[2], b[2], a[4], b[4], a[6], b[6]];
    let high = |a: [f64; 8], b: [f64; 8]| [a[1], b[1], a[3], b[3], a[5], b[5], a[7], b[7]];
    let even = |a: [f64; 8], b: [f64; 8]| [a[0], a[1], a[4], a[5], b[0], b[1], b[4], b[5]];
    let odd = |a: [f64; 8], b: [f64; 8]| [a[2], a[3], a[6], a[7], b[2], b[3], b[6], b[7]];
    let [l0, l1, l2, l3] = [
        low(r[0], r[1]),
        low(r[2], r[3]),
        low(r[4], r[5]),
        low(r[6], r[7]),
    ];
    let [h0, h1, h2, h3] = [
        high(r[0], r[1]),
        high(r[2], r[3]),
        high(r[4], r[5]),
        high(r[6], r[7]),
    ];
    let [le0, le1, lo0, lo1] = [even(l0, l1), even(l2, l3), odd(l0, l1), odd(l2, l3)];
    let [he0, he1, ho0, ho1] = [even(h0, h1), even(h2, h3), odd(h0, h1), odd(h2, h3)];
    let columns = [
        even(le0, le1),
        even(he0, he1),
        even(lo0, lo1),
        even(ho0, ho1),
        odd(le0, le1),
        odd(he0, he1),
        odd(lo0, lo1),
        odd(ho0, ho1),
    ];
    let mut result = rows;
    for (result, column) in result.iter_mut().zip(columns) {
        *result = bytemuck::cast(column);
    }
    result
}
