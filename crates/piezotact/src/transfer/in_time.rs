//! Cross-spectrum, correlations and impulse response: the spectra of an estimate and what they are over time.

use super::{CrossSpectra, TransferReport};
use crate::figure::{Axis, Chart, Line, Panels, Scale, Tone};
use crate::fourier::RealTransform;
use crate::page::{Block, Cell, Column, Table};
use crate::quantity::Quantity;

/// The figure shows the lags in which the impulse response has this share of its energy, and as much again.
const SHOWN_ENERGY: f64 = 0.99;

/// The correlation functions of a drive x and a response y, one value a lag: the first half from lag 0 on, the second half for negative
/// lags, in units of x², y² and x·y.
struct Correlations {
    /// Rxx(τ) = E[x(t + τ)·x(t)].
    drive: Vec<f64>,
    /// Ryy(τ) = E[y(t + τ)·y(t)].
    response: Vec<f64>,
    /// Ryx(τ) = E[y(t + τ)·x(t)]: positive lags are those of a response after its drive.
    cross: Vec<f64>,
}

impl<I: Quantity, O: Quantity> CrossSpectra<I, O> {
    /// The correlation functions at twice the highest line, of as many lags as twice the lines less two, in units of x², y² and x·y.
    /// They repeat themselves after a segment, and are those of the segments under their window.
    ///
    /// Formula: R(τ) = ∫ S(f)·exp(2πifτ) df over both sides of the spectra, by the inverse Fourier transform.
    ///
    /// Source: thesis 2.5.3, equations 7 to 12, with the cross-spectrum E[conj(X)·Y]: equation 7 gives its conjugate.
    fn correlations(&self) -> Correlations {
        let last = self.cross.len() - 1;
        let count = 2 * last;
        let mut transform = RealTransform::new(count);
        let scale = |line: usize| {
            let sides = if line == 0 || line == last { 1.0 } else { 2.0 };
            self.resolution_hz * count as f64 / sides
        };
        let mut of = |spectrum: &dyn Fn(usize) -> num_complex::Complex<f64>| {
            transform.inverse((0..=last).map(|k| spectrum(k) * scale(k)).collect())
        };
        Correlations {
            drive: of(&|line| self.drive_power[line].into()),
            response: of(&|line| self.response_power[line].into()),
            cross: of(&|line| self.cross[line]),
        }
    }
}

/// The figure of the impulse response and of the correlation between drive and response, with their values and those of the spectra.
pub(super) fn blocks<I: Quantity, O: Quantity>(
    report: &TransferReport<'_, I, O>,
    spectra: &CrossSpectra<I, O>,
) -> Vec<Block> {
    let correlations = spectra.correlations();
    let impulse = report.function.impulse_response();
    let count = impulse.len();
    // The lags from the most negative one on.
    let lags = || (0..count).map(|i| (i + count / 2) % count);
    let step_s = 1.0 / (count as f64 * spectra.resolution_hz);
    let lag_s = |at: usize| match at < count / 2 {
        true => at as f64 * step_s,
        false => (at as f64 - count as f64) * step_s,
    };
    let size = (correlations.drive[0] * correlations.response[0]).sqrt();
    let coefficient = |at: usize| correlations.cross[at] / size.max(f64::MIN_POSITIVE);
    let reach_s = reach(&impulse) as f64 * step_s;
    let points = |value: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        let near = lags().filter(|at| lag_s(*at).abs() <= reach_s);
        near.map(|at| (lag_s(at) * 1e3, value(at))).collect()
    };
    let (impulses, coefficients) = (points(&|at| impulse[at]), points(&coefficient));
    let chart = |label: String, points: Vec<(f64, f64)>| {
        let y = Axis::around(label, Scale::Linear, points.iter().map(|(_, y)| *y));
        let x = Axis::new("time after the drive, ms", -reach_s * 1e3, reach_s * 1e3);
        Chart::new(x, y, vec![Line::new("", Tone::Main, points).thin()])
    };
    let figure = Panels::new(vec![
        chart(format!("impulse response, {}", report.unit), impulses),
        chart("correlation, −1 to 1".into(), coefficients),
    ])
    .captioned(format!(
        "Impulse response, a sample each {:.3} ms, and correlation of the response with the drive, re the product of their rms.",
        step_s * 1e3
    ));
    let (drive, response) = (&report.drive_unit, &report.response_unit);
    let mut of_lags = Table::new([
        Column::new("time after the drive, s", "lag_s"),
        Column::new(
            &format!("impulse response, {}", report.unit),
            "impulse_response",
        ),
        Column::new(&format!("Rxx, ({drive})²"), "drive_correlation"),
        Column::new(&format!("Ryy, ({response})²"), "response_correlation"),
        Column::new(&format!("Ryx, {response}·{drive}"), "cross_correlation"),
    ]);
    of_lags.rows = lags()
        .map(|at| {
            let Correlations {
                drive,
                response,
                cross,
            } = &correlations;
            [lag_s(at), impulse[at], drive[at], response[at], cross[at]]
        })
        .map(row)
        .collect();
    let mut of_lines = Table::new([
        Column::new("frequency, Hz", "frequency_hz"),
        Column::new(&format!("Sxx, ({drive})²/Hz"), "drive_density"),
        Column::new(&format!("Syy, ({response})²/Hz"), "response_density"),
        Column::new(
            &format!("Re Sxy, {response}·{drive}/Hz"),
            "cross_density_re",
        ),
        Column::new(
            &format!("Im Sxy, {response}·{drive}/Hz"),
            "cross_density_im",
        ),
    ]);
    of_lines.rows = (0..spectra.cross.len())
        .map(|line| {
            let cross = spectra.cross[line];
            let [x, y] = [spectra.drive_power[line], spectra.response_power[line]];
            [
                line as f64 * spectra.resolution_hz,
                x,
                y,
                cross.re,
                cross.im,
            ]
        })
        .map(row)
        .collect();
    vec![
        Block::Figure(figure),
        Block::folded("Impulse response and correlations", [Block::Table(of_lags)]),
        Block::folded("Power and cross-spectra", [Block::Table(of_lines)]),
    ]
}

fn row<const N: usize>(values: [f64; N]) -> Vec<Cell> {
    values.map(Cell::from).to_vec()
}

/// Twice the number of samples on either side of lag 0 that hold most of the energy of `impulse`, half of its length at the most.
fn reach(impulse: &[f64]) -> usize {
    let half = impulse.len() / 2;
    let pair = |lag: usize| {
        let behind = impulse[lag].powi(2);
        behind + impulse[(impulse.len() - lag) % impulse.len()].powi(2)
    };
    let all: f64 = impulse.iter().map(|v| v * v).sum();
    let mut sum = impulse[0].powi(2);
    let most = (1..half).find(|lag| {
        sum += pair(*lag);
        sum >= SHOWN_ENERGY * all
    });
    (2 * most.unwrap_or(half)).clamp(8.min(half), half)
}

#[cfg(test)]
mod tests {
    use crate::quantity::{SampleRate, Uncalibrated};
    use crate::series::Series;
    use crate::spectrum::WelchConfig;
    use crate::statistics::random::Random;
    use crate::transfer::cross_spectra;

    /// White noise of rms 0.5, and twice of it five samples later: Rxx(0) = 0.25, Ryx(5) = 0.5 by the definition.
    #[test]
    fn correlations_are_those_of_the_definition() {
        let mut random = Random::stream(3, 0, "correlations");
        let x: Vec<f64> = (0..400_000).map(|_| 0.5 * random.normal()).collect();
        let y: Vec<f64> = (0..x.len()).map(|i| 2.0 * x[i.saturating_sub(5)]).collect();
        let rate = SampleRate::new(1_000.0).unwrap();
        let series = |samples| Series::<Uncalibrated>::new(samples, rate).unwrap();
        let config = WelchConfig::hann(512);
        let spectra = cross_spectra(&series(x.clone()), &series(y.clone()), &config).unwrap();
        let found = spectra.correlations();
        assert_eq!(found.cross.len(), 512);
        let mean_of = |lag: usize| {
            let products = (0..x.len() - lag).map(|t| y[t + lag] * x[t]);
            products.sum::<f64>() / x.len() as f64
        };
        // 0.01: the standard error of a correlation of 1500 segments, √(1/1500)·0.5, and the window's bias of 5 of 512 samples.
        for (found, expected) in [
            (found.drive[0], 0.25),
            (found.response[0], 1.0),
            (found.cross[5], mean_of(5)),
            (found.cross[40], mean_of(40)),
            (found.cross[512 - 5], 0.0),
        ] {
            assert!((found - expected).abs() < 0.01, "{found} of {expected}");
        }
    }
}
