//! A power-of-two transform of two real segments in eight lanes of `f64`, summed in the order it comes out.
//!
//! Lane l holds the samples l, 8 + l, 16 + l … of a segment, so vectors are loaded as the samples lie in memory
//! and eight transforms of an eighth of the length run beside each other without touching one another. The
//! last step turns eight vectors by a transposition and joins the lanes with one transform of length 8.
//! Bins come out in the order of their reversed digits. Sums of powers do not mind, so the order is undone
//! once, when the sums are read.

use num_complex::Complex;
use pulp::{Simd, WithSimd};

use super::butterfly::{LANES, Lanes, Pair, Wide};
use super::eight::EightLanes;

/// The lengths of segments that these transforms are for, powers of two.
pub(super) const LENGTHS: std::ops::RangeInclusive<usize> = 256..=65_536;

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

/// exp(−2πi·numerator/denominator) for a denominator that 8 divides or that is 2 or 4, to the last digit: from an
/// angle of at most an eighth of a turn. The strongest lines would otherwise be heard in the weakest.
fn turn(numerator: usize, denominator: usize) -> Complex<f64> {
    let eighths = 8 * (numerator % denominator);
    let octant = eighths / denominator;
    // From the nearest quarter of a turn, forwards or backwards.
    let quarters = octant.div_ceil(2);
    let beyond = eighths as f64 - (2 * quarters * denominator) as f64;
    let angle = beyond / denominator as f64 * std::f64::consts::FRAC_PI_4;
    let (sine, cosine) = angle.sin_cos();
    match quarters % 4 {
        0 => Complex::new(cosine, -sine),
        1 => Complex::new(-sine, -cosine),
        2 => Complex::new(-cosine, sine),
        _ => Complex::new(sine, cosine),
    }
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
    pub(super) fn add<S: EightLanes>(&mut self, simd: S, a: &[f64], b: &[f64]) {
        let to = self;
        simd.vectorize(AddPower { simd, to, a, b });
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

struct AddPower<'a, S> {
    simd: S,
    to: &'a mut LanePower,
    a: &'a [f64],
    b: &'a [f64],
}

impl<S: EightLanes> WithSimd for AddPower<'_, S> {
    type Output = ();

    #[inline(always)]
    fn with_simd<Same: Simd>(self, _same: Same) {
        Lanes(self.simd).add_pair(self.to, self.a, self.b);
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
    pub(super) fn add<S: EightLanes>(&mut self, simd: S, x: [&[f64]; 2], y: [&[f64]; 2]) {
        let to = self;
        simd.vectorize(AddCross { simd, to, x, y });
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

struct AddCross<'a, S> {
    simd: S,
    to: &'a mut LaneCross,
    x: [&'a [f64]; 2],
    y: [&'a [f64]; 2],
}

impl<S: EightLanes> WithSimd for AddCross<'_, S> {
    type Output = ();

    #[inline(always)]
    fn with_simd<Same: Simd>(self, _same: Same) {
        Lanes(self.simd).add_pairs(self.to, self.x, self.y);
    }
}

impl<S: EightLanes> Lanes<S> {
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
        let (re, im) = (self.transposed(re), self.transposed(im));
        for ((x, re), im) in x.iter_mut().zip(re).zip(im) {
            *x = Pair { re, im };
        }
        self.butterfly_8(x)
    }

    #[inline(always)]
    fn add_pair(self, to: &mut LanePower, a: &[f64], b: &[f64]) {
        let LanePower { transform, z, sums } = to;
        self.all_but_last(transform, a, b, z);
        match transform.last {
            LastPass::Two => self.power::<2>(transform, z, sums),
            LastPass::Four => self.power::<4>(transform, z, sums),
            LastPass::Eight => self.power::<8>(transform, z, sums),
        }
    }

    #[inline(always)]
    fn power<const RADIX: usize>(self, plan: &LaneTransform, z: &[Wide], sums: &mut [Row]) {
        let groups = z.as_chunks::<8>().0.iter();
        let groups = groups.zip(plan.lane_turns.as_chunks::<8>().0);
        for ((z, turns), sums) in groups.zip(sums.as_chunks_mut::<8>().0) {
            let z = self.join::<RADIX>(z, turns);
            let [a, b, c, d, e, f, g, h] = sums;
            self.add_power(z[0], a);
            self.add_power(z[1], b);
            self.add_power(z[2], c);
            self.add_power(z[3], d);
            self.add_power(z[4], e);
            self.add_power(z[5], f);
            self.add_power(z[6], g);
            self.add_power(z[7], h);
        }
    }

    #[inline(always)]
    fn add_power(self, z: Pair<S>, sum: &mut Row) {
        let s = self.0;
        let power = s.mul_add_e_f64s(z.re, z.re, self.load(&sum.0));
        sum.0 = bytemuck::cast(s.mul_add_e_f64s(z.im, z.im, power));
    }

    #[inline(always)]
    fn add_pairs(self, to: &mut LaneCross, of_x: [&[f64]; 2], of_y: [&[f64]; 2]) {
        let LaneCross {
            transform,
            x,
            y,
            sums,
        } = to;
        self.all_but_last(transform, of_x[0], of_x[1], x);
        self.all_but_last(transform, of_y[0], of_y[1], y);
        match transform.last {
            LastPass::Two => self.cross::<2>(transform, x, y, sums),
            LastPass::Four => self.cross::<4>(transform, x, y, sums),
            LastPass::Eight => self.cross::<8>(transform, x, y, sums),
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
        let groups = x.as_chunks::<8>().0.iter().zip(y.as_chunks::<8>().0);
        let groups = groups.zip(plan.lane_turns.as_chunks::<8>().0);
        for (((x, y), turns), sums) in groups.zip(sums.as_chunks_mut::<8>().0) {
            let x = self.join::<RADIX>(x, turns);
            let y = self.join::<RADIX>(y, turns);
            let [a, b, c, d, e, f, g, h] = sums;
            self.add_joint(x[0], y[0], a);
            self.add_joint(x[1], y[1], b);
            self.add_joint(x[2], y[2], c);
            self.add_joint(x[3], y[3], d);
            self.add_joint(x[4], y[4], e);
            self.add_joint(x[5], y[5], f);
            self.add_joint(x[6], y[6], g);
            self.add_joint(x[7], y[7], h);
        }
    }

    #[inline(always)]
    fn add_joint(self, x: Pair<S>, y: Pair<S>, sum: &mut Joint) {
        let s = self.0;
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

/// The first eight parts of `stride` of a slice.
#[inline(always)]
fn eighths<T>(all: &[T], stride: usize) -> [&[T]; 8] {
    std::array::from_fn(|q| &all[q * stride..(q + 1) * stride])
}
