//! Random heights: a self-affine Gaussian field, and the skewing of its heights.

use num_complex::Complex;
use piezotact_fourier::ComplexPlanner;
use piezotact_fourier::RealPlanner;

use piezotact_bench::random::Random;

/// The shortest wave of a random relief, m (*chosen*: what survives silicone and resin; finer detail is
/// far below what a microscope map of a sample resolves).
pub(super) const SHORTEST_WAVE_M: f64 = 2e-6;
/// How much larger than the patch the field is made, in correlation lengths: where opposite edges of the patch
/// meet round the period, the correlation has fallen below 10⁻⁴.
const MARGIN_LENGTHS: f64 = 2.0;

/// The points of a map.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    pub(super) columns: usize,
    pub(super) rows: usize,
    pub(super) step_m: f64,
}

/// The spectrum of a random relief: flat below 1/Lc, self-affine above it.
#[derive(Clone, Copy, Debug)]
pub(super) struct SelfAffine {
    /// The roll-off wavelength Lc, m.
    pub(super) correlation_m: f64,
    pub(super) hurst: f64,
}

impl SelfAffine {
    /// The square root of the two-dimensional PSD, not scaled: √C with C = (1 + (q/q0)²)^−(1+H), q0 = 2π/Lc, of
    /// the wave of `x_per_m` and `y_per_m` waves per m; 0 for waves as short as `shortest_m` and shorter.
    fn amplitude(&self, x_per_m: f64, y_per_m: f64, shortest_m: f64) -> f64 {
        let waves_per_m = x_per_m.hypot(y_per_m);
        if waves_per_m * shortest_m >= 1.0 {
            return 0.0;
        }
        let relative = waves_per_m * self.correlation_m;
        (1.0 + relative * relative).powf(-0.5 * (1.0 + self.hurst))
    }

    /// The shortest wave at a step, m: two steps, or [`SHORTEST_WAVE_M`] where that is longer. The roughness of a
    /// pattern may be finer than this; then half its correlation length.
    fn shortest_m(&self, step_m: f64) -> f64 {
        SHORTEST_WAVE_M
            .min(0.5 * self.correlation_m)
            .max(2.0 * step_m)
    }

    /// Gaussian heights on `grid`, row by row, of mean 0 and rms 1 on it.
    ///
    /// The waves have random phases and χ²-distributed powers on a grid larger than this one, so that the
    /// part that is kept has no period. Memory: 16 bytes for each row of `grid` and each bin of the larger row
    /// below the cut, and 8 bytes for each point.
    pub(super) fn heights(&self, grid: Grid, random: &mut Random) -> Vec<f64> {
        let margin = (MARGIN_LENGTHS * self.correlation_m / grid.step_m).ceil() as usize;
        let across = fast_length(grid.columns + margin);
        let down = fast_length(grid.rows + margin);
        let columns = self.columns(grid, (across, down), random);
        let mut heights = lines(&columns, grid, across);
        standardise(&mut heights);
        heights
    }

    /// The transforms along x of the first rows of the field on `across` × `down` points: bin after bin up to
    /// the cut, `grid.rows` values each.
    fn columns(
        &self,
        grid: Grid,
        (across, down): (usize, usize),
        random: &mut Random,
    ) -> Vec<Complex<f64>> {
        let shortest_m = self.shortest_m(grid.step_m);
        let x_per_m = |bin: usize| bin as f64 / (across as f64 * grid.step_m);
        let y_per_m = |row: usize| row.min(down - row) as f64 / (down as f64 * grid.step_m);
        let plan = ComplexPlanner::new().plan_fft_inverse(down);
        let mut scratch = vec![Complex::default(); plan.get_inplace_scratch_len()];
        let mut column = vec![Complex::default(); down];
        let mut columns = Vec::new();
        for bin in (0..across / 2).take_while(|&bin| x_per_m(bin) * shortest_m < 1.0) {
            // only the real half of the lowest bin is kept below: half its power
            let half = if bin == 0 { 2f64.sqrt() } else { 1.0 };
            for (row, value) in column.iter_mut().enumerate() {
                let amplitude = half * self.amplitude(x_per_m(bin), y_per_m(row), shortest_m);
                *value = if amplitude > 0.0 {
                    Complex::new(random.normal(), random.normal()) * amplitude
                } else {
                    Complex::default()
                };
            }
            plan.process_with_scratch(&mut column, &mut scratch);
            columns.extend_from_slice(&column[..grid.rows]);
        }
        columns
    }
}

/// The first `grid.columns` points of each row whose transform stands across `columns`.
fn lines(columns: &[Complex<f64>], grid: Grid, across: usize) -> Vec<f64> {
    let plan = RealPlanner::new().plan_fft_inverse(across);
    let (mut bins, mut line) = (plan.make_input_vec(), plan.make_output_vec());
    let mut scratch = plan.make_scratch_vec();
    let mut heights = Vec::with_capacity(grid.rows * grid.columns);
    for row in 0..grid.rows {
        bins.fill(Complex::default());
        let of_row = columns.iter().skip(row).step_by(grid.rows);
        for (to, from) in bins.iter_mut().zip(of_row) {
            *to = *from;
        }
        bins[0].im = 0.0;
        let done = plan.process_with_scratch(&mut bins, &mut line, &mut scratch);
        debug_assert!(done.is_ok());
        heights.extend_from_slice(&line[..grid.columns]);
    }
    heights
}

/// Makes heights of mean 0 and rms 1 of mean 0 and the skewness `skewness`, peaks where peaks were.
///
/// Formula: z = exp(s·g) − mean, mirrored for a negative skewness; with w = exp(s²), the skewness of the
/// lognormal distribution is (w + 2)·√(w − 1), so that w³ + 3w² − 4 − skewness² = 0. The heights of a map
/// meet it up to the chance of its own peaks.
pub(super) fn skew(heights: &mut [f64], skewness: f64) {
    let size = skewness.abs();
    let root = (1.0 + 0.5 * size * size + size * (1.0 + 0.25 * size * size).sqrt()).cbrt();
    let width = (root + 1.0 / root - 1.0).ln().max(0.0).sqrt();
    if width > 0.0 {
        let side = skewness.signum();
        for z in &mut *heights {
            *z = side * (side * width * *z).exp_m1();
        }
    }
    centre(heights);
}

fn centre(heights: &mut [f64]) {
    let mean = heights.iter().sum::<f64>() / heights.len() as f64;
    for z in heights {
        *z -= mean;
    }
}

fn standardise(heights: &mut [f64]) {
    centre(heights);
    let squares: f64 = heights.iter().map(|z| z * z).sum();
    let rms = (squares / heights.len() as f64).sqrt();
    for z in heights {
        *z /= rms.max(f64::MIN_POSITIVE);
    }
}

/// The smallest even length from `n` up whose only prime factors are 2, 3 and 5: quick to transform.
fn fast_length(n: usize) -> usize {
    let smooth = |mut m: usize| {
        for p in [2, 3, 5] {
            while m.is_multiple_of(p) {
                m /= p;
            }
        }
        m == 1
    };
    let lengths = n.max(2)..=2 * n.max(2);
    let mut fast = lengths.filter(|&m| m.is_multiple_of(2) && smooth(m));
    fast.next().unwrap_or(2 * n)
}
