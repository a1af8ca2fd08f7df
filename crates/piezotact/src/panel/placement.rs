//! The variation between placements of one finger, as a distribution from which new placements are drawn.

use num_complex::Complex;

use super::{Cell, Panel, PanelError};
use crate::quantity::{Band, Quantity};
use crate::statistics::rms;
use crate::transfer::{BundleAverage, TransferFunction, average};

/// Departures are smoothed over this part of an octave to either side, so that the scatter of single lines is not reproduced.
const SMOOTHED_OCTAVES: f64 = 1.0 / 12.0;

/// The kind of measurements between which a spread was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpreadKind {
    /// Placements: the finger taken off and put back.
    Placements,
    /// Repeats of one placement, if nobody was placed more than once: they differ less than placements.
    Repeats,
}

impl SpreadKind {
    /// What is repeated.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Placements => "placements",
            Self::Repeats => "repeats of one placement",
        }
    }
}

/// The departures of the measurements of one person in one cell from their mean, over people and cells: for each departure and
/// line ln|H/mean| as the real part and the phase of H/mean in rad as the imaginary part.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacementSpread {
    resolution_hz: f64,
    departures: Vec<Vec<Complex<f64>>>,
    freedom: usize,
    /// How many people and cells were measured more than once.
    pub groups: usize,
    /// Whether between placements or between repeats.
    pub of: SpreadKind,
}

/// The spread between placements of one person in `panel`, in `cell` if somebody was placed there more than once, otherwise in
/// all cells; if nobody was placed more than once, the spread between repeats of one placement.
///
/// Formula: dᵢ(f) = ln(Hᵢ/H̄), H̄ the mean of log magnitudes and phases of a person's placements in a cell, averaged over 1/12
/// octave to either side with the coherence as weight.
///
/// Source: log-normal magnitudes as in J. S. Bendat and A. G. Piersol, *Random Data*, 4th ed., chapter 9, for
/// multiplicative scatter.
///
/// # Errors
/// [`PanelError::NothingRepeated`] when nobody was measured twice in a cell; those of an average.
pub fn placement_spread<I: Quantity, O: Quantity>(
    panel: &Panel<I, O>,
    cell: Option<Cell>,
) -> Result<PlacementSpread, PanelError> {
    for of in [SpreadKind::Placements, SpreadKind::Repeats] {
        let all = groups(panel, of)?;
        let here: Vec<_> = all
            .iter()
            .filter(|(at, _)| cell.is_some_and(|cell| at.is(cell)))
            .collect();
        let used: Vec<_> = if here.is_empty() {
            all.iter().collect()
        } else {
            here
        };
        if used.is_empty() {
            continue;
        }
        let mut spread = PlacementSpread {
            resolution_hz: panel.entries()[0].function.resolution_hz(),
            departures: Vec::new(),
            freedom: 0,
            groups: used.len(),
            of,
        };
        for (_, members) in used {
            let each: Vec<&TransferFunction<I, O>> = members.iter().collect();
            let middle = average(&each, BundleAverage::LogMagnitude)?;
            spread.freedom += members.len() - 1;
            let departures = members.iter().map(|own| departure(own, &middle));
            spread.departures.extend(departures);
        }
        return Ok(spread);
    }
    Err(PanelError::NothingRepeated)
}

/// Transfer functions with the cell that they share.
type Group<I, O> = (Cell, Vec<TransferFunction<I, O>>);

/// Groups of two or more measurements that should agree: the placements of a person in a cell, or the repeats of a placement.
fn groups<I: Quantity, O: Quantity>(
    panel: &Panel<I, O>,
    of: SpreadKind,
) -> Result<Vec<Group<I, O>>, PanelError> {
    let mut groups = Vec::new();
    for who in panel.participants() {
        for cell in panel.cells() {
            let placements = panel.placements(who, *cell);
            match of {
                SpreadKind::Placements => {
                    let placed = placements.values();
                    let placed = placed.map(|own| average(own, BundleAverage::LogMagnitude));
                    groups.push((*cell, placed.collect::<Result<Vec<_>, _>>()?));
                }
                SpreadKind::Repeats => {
                    let each = placements.into_values();
                    groups.extend(each.map(|own| (*cell, own.into_iter().cloned().collect())));
                }
            }
        }
    }
    groups.retain(|(_, members)| members.len() > 1);
    Ok(groups)
}

fn departure<I: Quantity, O: Quantity>(
    own: &TransferFunction<I, O>,
    middle: &TransferFunction<I, O>,
) -> Vec<Complex<f64>> {
    let lines: Vec<(Complex<f64>, f64)> = own
        .response()
        .iter()
        .zip(middle.response())
        .zip(own.coherence())
        .map(|((own, middle), coherence)| {
            let ratio = own / middle;
            match ratio.is_finite() && ratio.norm() > 0.0 {
                true => (ratio.ln(), coherence.clamp(0.0, 1.0)),
                false => (Complex::default(), 0.0),
            }
        })
        .collect();
    let reach = SMOOTHED_OCTAVES.exp2();
    (0..lines.len())
        .map(|line| {
            let from = (line as f64 / reach).ceil() as usize;
            let to = ((line as f64 * reach).floor() as usize).min(lines.len() - 1);
            let near = &lines[from..=to];
            let weights: f64 = near.iter().map(|(_, weight)| weight).sum();
            let sum: Complex<f64> = near.iter().map(|(d, weight)| d * *weight).sum();
            if weights > 0.0 {
                sum / weights
            } else {
                Complex::default()
            }
        })
        .collect()
}

impl PlacementSpread {
    /// How many numbers of the standard normal distribution one placement is drawn with.
    #[must_use]
    pub fn draws(&self) -> usize {
        self.departures.len()
    }

    /// The complex factor, by frequency in Hz, from a measured placement to another one drawn at random. `normals` are
    /// [`Self::draws`] numbers from the standard normal distribution.
    ///
    /// Formula: exp(√2·Σ gₖ·dₖ(f)/√ν) with ν degrees of freedom: level and phase of neighbouring lines vary together as
    /// those of the panel do, and the factor 2 of the variance is that of the difference of two placements.
    ///
    /// Source: draws of a given covariance, as in T. W. Anderson, *An Introduction to Multivariate Statistical Analysis*,
    /// 3rd ed., section 7.2.
    pub fn factor(&self, normals: &[f64]) -> impl Fn(f64) -> Complex<f64> {
        let scale = (2.0 / self.freedom.max(1) as f64).sqrt();
        let lines = self.departures.first().map_or(0, Vec::len);
        let sum: Vec<Complex<f64>> = (0..lines)
            .map(|line| {
                let drawn = self.departures.iter().zip(normals);
                drawn.map(|(d, normal)| d[line] * (*normal * scale)).sum()
            })
            .collect();
        let resolution_hz = self.resolution_hz;
        move |frequency_hz: f64| {
            let Some(last) = sum.len().checked_sub(1) else {
                return Complex::from(1.0);
            };
            let place = (frequency_hz / resolution_hz).clamp(0.0, last as f64);
            let line = (place as usize).min(last.saturating_sub(1));
            let next = (line + 1).min(last);
            (sum[line] + (sum[next] - sum[line]) * (place - line as f64)).exp()
        }
    }

    /// How far two placements lie apart over `band`: rms of the level, dB, and of the phase, rad; `None` where no line lies
    /// in it.
    #[must_use]
    pub fn rms_difference_over(&self, band: Band) -> Option<(f64, f64)> {
        let inside = |line: &usize| band.contains(*line as f64 * self.resolution_hz);
        let lines: Vec<usize> = (0..self.departures.first()?.len()).filter(inside).collect();
        let all = || {
            self.departures
                .iter()
                .flat_map(|d| lines.iter().map(|k| d[*k]))
        };
        let scale = (2.0 * self.departures.len() as f64 / self.freedom.max(1) as f64).sqrt();
        let level_db = 20.0 * std::f64::consts::LOG10_E;
        let levels: Vec<f64> = all().map(|d| scale * level_db * d.re).collect();
        let phases: Vec<f64> = all().map(|d| scale * d.im).collect();
        (!levels.is_empty()).then(|| (rms(&levels), rms(&phases)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    use crate::panel::{Entry, Filing};
    use crate::quantity::{Acceleration, Degrees, Drive, Hertz, Newtons, SampleRate};
    use crate::transfer::Estimator;

    type H = TransferFunction<Drive, Acceleration>;

    const AT: Cell = Cell {
        load_n: Newtons(0.2),
        angle_deg: Degrees(20.0),
    };

    /// A finger whose placements vary by a tilt, a level and a delay.
    fn measured(person: u32, placement: u32) -> Entry<Drive, Acceleration> {
        let number = |what: u32| {
            let mixed = (person * 31 + placement * 7 + what).wrapping_mul(2_654_435_761);
            f64::from(mixed) / f64::from(u32::MAX) * 2.0 - 1.0
        };
        let rate = SampleRate::new(2_000.0).unwrap();
        let lines = (0..=200).map(|k| {
            let octaves = (f64::from(k) / 50.0).max(0.1).log2();
            let level_db = 2.0 * number(1) + 1.0 * number(2) * octaves;
            let phase = -0.01 * f64::from(k) * (1.0 + 0.2 * number(3));
            Complex::from_polar(10f64.powf((level_db + f64::from(person)) / 20.0), phase)
        });
        let mut function = H::from_lines(
            lines.collect(),
            vec![0.99; 201],
            5.0,
            rate,
            Estimator::H1,
            100,
        )
        .unwrap();
        let participant = format!("P{person:02}");
        function.about.condition.participant = Some(participant.clone());
        function.about.condition.load_n = Some(AT.load_n);
        function.about.condition.angle_deg = Some(AT.angle_deg);
        let filing = Filing {
            participant,
            cell: AT,
            placement,
            repeat: 1,
        };
        Entry { filing, function }
    }

    fn apart_db(one: &H, other: &H, band: Band) -> f64 {
        let lines = one.lines_in(band);
        let ratio =
            lines.map(|(k, _)| 20.0 * (one.response()[k] / other.response()[k]).norm().log10());
        rms(&ratio.collect::<Vec<_>>())
    }

    /// Placements that are drawn lie as far from the measured one as those of the panel lie apart.
    #[test]
    fn drawn_placements_lie_as_far_apart_as_measured_ones() {
        let entries: Vec<_> = (1..=8)
            .flat_map(|p| (1..=3).map(move |n| measured(p, n)))
            .collect();
        let band = Band::new(Hertz(20.0), Hertz(800.0)).unwrap();
        let mut found = Vec::new();
        for (i, one) in entries.iter().enumerate() {
            let same = |e: &&Entry<_, _>| e.filing.participant == one.filing.participant;
            let others = entries[..i].iter().filter(same);
            found.extend(others.map(|other| apart_db(&one.function, &other.function, band)));
        }
        let own = entries[0].function.clone();
        let spread = placement_spread(&Panel::new(entries).unwrap(), Some(AT)).unwrap();
        assert_eq!(
            (spread.of, spread.groups, spread.draws()),
            (SpreadKind::Placements, 8, 24)
        );
        let drawn: Vec<f64> = (0..400)
            .map(|seed| {
                let mut random = ChaCha8Rng::seed_from_u64(seed);
                let mut uniform = || (random.next_u64() >> 11) as f64 * 2f64.powi(-53);
                let mut normal = || {
                    let radius = (-2.0 * (1.0 - uniform()).ln()).sqrt();
                    radius * (std::f64::consts::TAU * uniform()).cos()
                };
                let normals: Vec<f64> = (0..spread.draws()).map(|_| normal()).collect();
                apart_db(&own.clone().times(spread.factor(&normals)), &own, band)
            })
            .collect();
        let (found, drawn) = (rms(&found), rms(&drawn));
        let (said, phase) = spread.rms_difference_over(band).unwrap();
        assert!((drawn / found - 1.0).abs() < 0.1, "{drawn} {found}");
        assert!((said / found - 1.0).abs() < 0.1, "{said} {found}");
        assert!(phase > 0.05);
    }

    #[test]
    fn nobody_placed_twice_says_nothing() {
        let entries = (1..=4).map(|p| measured(p, 1)).collect();
        let panel = Panel::new(entries).unwrap();
        assert_eq!(
            placement_spread(&panel, None),
            Err(PanelError::NothingRepeated)
        );
    }
}
