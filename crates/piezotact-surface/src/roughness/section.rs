//! The parameters of one stretch of a roughness profile.

/// Weights of the seven-point slope, from the farthest neighbour in, each to be taken antisymmetrically.
const SLOPE_WEIGHTS: [f64; 3] = [1.0, -9.0, 45.0];
/// A peak lower, or a valley shallower, than this share of Rz makes no profile element.
const HEIGHT_DISCRIMINATION: f64 = 0.1;
/// A peak or valley narrower than this share of the section makes no profile element.
const SPACING_DISCRIMINATION: f64 = 0.01;

/// Moments and extremes of heights about zero, in m. Skewness and kurtosis are absent where all is flat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Amplitudes {
    pub(super) mean_absolute_m: f64,
    pub(super) rms_m: f64,
    pub(super) peak_m: f64,
    pub(super) valley_m: f64,
    pub(super) skewness: Option<f64>,
    pub(super) kurtosis: Option<f64>,
}

impl Amplitudes {
    pub(super) fn of(heights_m: impl Iterator<Item = f64> + Clone) -> Self {
        let fold = |f: fn(f64, f64) -> f64| heights_m.clone().reduce(f).unwrap_or(0.0);
        let (highest, lowest) = (fold(f64::max), fold(f64::min));
        let largest = highest.abs().max(lowest.abs());
        // Moments of heights relative to the largest neither overflow nor vanish.
        let unit = if largest > 0.0 { largest } else { 1.0 };
        let moment = |k: i32| super::mean(heights_m.clone().map(|z| (z / unit).powi(k)));
        let rms = moment(2).sqrt();
        let standardised = |k: i32| (largest > 0.0).then(|| moment(k) / rms.powi(k));
        Self {
            mean_absolute_m: super::mean(heights_m.clone().map(f64::abs)),
            rms_m: unit * rms,
            peak_m: highest.max(0.0),
            valley_m: (-lowest).max(0.0),
            skewness: standardised(3),
            kurtosis: standardised(4),
        }
    }

    pub(super) fn range_m(&self) -> f64 {
        self.peak_m + self.valley_m
    }
}

/// dz/dx at every point that has three neighbours on each side, dimensionless; the first is at point 3.
///
/// Formula: (z₊₃ − 9z₊₂ + 45z₊₁ − 45z₋₁ + 9z₋₂ − z₋₃)/60Δx, ISO 4287:1997, 3.2.9.
pub(super) fn slopes(heights_m: &[f64], step_m: f64) -> Vec<f64> {
    let slope = |z: &[f64]| {
        let sum: f64 = (0..3).map(|k| SLOPE_WEIGHTS[k] * (z[6 - k] - z[k])).sum();
        sum / (60.0 * step_m)
    };
    heights_m.windows(7).map(slope).collect()
}

pub(super) fn rms(values: &[f64]) -> f64 {
    super::mean(values.iter().map(|v| v * v)).sqrt()
}

/// The mean width of the profile elements in m, absent where there is none: the elements lie between every
/// second of the crossings that [`significant_crossings`] leaves, beginning with the first.
pub(super) fn mean_element_width_m(
    heights_m: &[f64],
    step_m: f64,
    section_m: f64,
    rz_m: f64,
) -> Option<f64> {
    let crossings = significant_crossings(
        heights_m,
        HEIGHT_DISCRIMINATION * rz_m,
        SPACING_DISCRIMINATION * section_m / step_m,
    );
    let elements = crossings.len().checked_sub(1)? / 2;
    let width = crossings.get(2 * elements)? - crossings.first()?;
    (elements > 0).then(|| width * step_m / elements as f64)
}

/// Where the profile crosses its mean line between a peak and a valley that both count, in steps: of
/// several crossings between the two, the last.
fn significant_crossings(heights_m: &[f64], least_m: f64, narrowest: f64) -> Vec<f64> {
    let mut crossings = Vec::new();
    let mut side_of_last = None;
    for piece in pieces(heights_m) {
        if piece.extent_m < least_m || piece.end - piece.start < narrowest {
            continue;
        }
        if side_of_last.is_some_and(|side| side != piece.above) {
            crossings.push(piece.start);
        }
        side_of_last = Some(piece.above);
    }
    crossings
}

/// A stretch of the profile on one side of the mean line.
struct Piece {
    above: bool,
    start: f64,
    end: f64,
    extent_m: f64,
}

fn pieces(heights_m: &[f64]) -> Vec<Piece> {
    let mut pieces: Vec<Piece> = Vec::new();
    for (i, z) in heights_m.iter().enumerate() {
        let above = *z > 0.0;
        match pieces.last_mut() {
            Some(piece) if piece.above == above => {
                piece.end = i as f64;
                piece.extent_m = piece.extent_m.max(z.abs());
            }
            last => {
                let start = match last {
                    Some(piece) => {
                        let before = heights_m[i - 1];
                        piece.end = i as f64 - z / (z - before);
                        piece.end
                    }
                    None => 0.0,
                };
                pieces.push(Piece {
                    above,
                    start,
                    end: i as f64,
                    extent_m: z.abs(),
                });
            }
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(points: usize, of: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..points)
            .map(|i| of((i as f64 + 0.25) / 100.0 * std::f64::consts::TAU))
            .collect()
    }

    #[test]
    fn a_sine_has_its_textbook_values() {
        let a = Amplitudes::of(wave(1000, |x| 3.0 * x.sin()).iter().copied());
        let within = |got: f64, expected: f64| {
            // sampled at 100 points to the wave
            assert!(
                (got - expected).abs() < 2e-3 * expected.abs().max(1.0),
                "{got} {expected}"
            );
        };
        within(a.mean_absolute_m, 6.0 / std::f64::consts::PI);
        within(a.rms_m, 3.0 / 2f64.sqrt());
        within(a.range_m(), 6.0);
        within(a.skewness.unwrap(), 0.0);
        within(a.kurtosis.unwrap(), 1.5);
    }

    #[test]
    fn a_square_wave_has_its_textbook_values() {
        let a = Amplitudes::of(wave(1000, |x| 2.0 * x.sin().signum()).iter().copied());
        assert_eq!((a.mean_absolute_m, a.rms_m, a.range_m()), (2.0, 2.0, 4.0));
        assert_eq!((a.skewness, a.kurtosis), (Some(0.0), Some(1.0)));
    }

    #[test]
    fn slopes_are_exact_for_polynomials_up_to_the_sixth_degree() {
        let z: Vec<f64> = (0..9).map(|i| f64::from(i).powi(6)).collect();
        let slopes = slopes(&z, 1.0);
        assert_eq!(slopes.len(), 3);
        for (i, slope) in slopes.iter().enumerate() {
            assert!((slope - 6.0 * (i as f64 + 3.0).powi(5)).abs() < 1e-8);
        }
    }

    #[test]
    fn ripples_make_no_elements() {
        let width = |z: &[f64]| mean_element_width_m(z, 1.0, z.len() as f64, 2.0);
        let clean = width(&wave(1000, f64::sin)).unwrap();
        assert!((clean - 100.0).abs() < 1e-3, "{clean}");
        // low ripples on the flanks cross the mean line three times
        let rippled = width(&wave(1000, |x| x.sin() + 0.09 * (21.0 * x).sin())).unwrap();
        assert!((rippled - 100.0).abs() < 1.0, "{rippled}");
        // tall spikes of two points are narrower than 1 %
        let mut spiked = wave(1000, f64::sin);
        spiked[125] = -1.0;
        assert!((width(&spiked).unwrap() - 100.0).abs() < 1e-3);
        assert_eq!(width(&[0.0; 50]), None);
        assert_eq!(width(&wave(110, f64::sin)), None);
    }
}
