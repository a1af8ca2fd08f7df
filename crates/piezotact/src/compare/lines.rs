//! Lines common to all recordings, independent of sample and speed: they come from the machine or the mains, not from a texture.

use serde::{Deserialize, Serialize};

use super::Summary;
use crate::feature::{StrokeSpectra, peaks};
use crate::quantity::Band;

/// Lines this far apart, as a share of the step between the lines of a PSD, are one.
const SAME_LINE: f64 = 1.0;
/// The mains is this near to a whole multiple of 50 or 60 Hz, as a share of that step …
const MAINS_NEAR: f64 = 0.25;
/// … and no more than this multiple.
const MAINS_ORDERS: usize = 10;
/// Speeds whose ratio is above this are different ones.
const OTHER_SPEED: f64 = 1.1;
/// Fewer recordings than this share a line by chance too often.
const ENOUGH: usize = 3;

/// One recording in which lines are looked for.
#[derive(Clone, Copy, Debug)]
pub struct LinesOf<'a> {
    /// The sample that was touched.
    pub sample: &'a str,
    /// How fast, m/s; none where that is not known.
    pub speed_m_s: Option<f64>,
    /// The PSDs of its strokes.
    pub psd: &'a StrokeSpectra,
    /// Where peaks are looked for.
    pub band: Band,
}

/// The origin of a line that all samples share.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum LineOrigin {
    /// A whole multiple of 50 or 60 Hz that does not move with the speed: the mains.
    Mains,
    /// It does not move with the speed: the machine's, or the sensor's.
    Machine,
    /// Not decided: all recordings have one speed, or unknown ones, so the line may also come from the finger.
    NotDecided,
}

/// A line that every sample has.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct CommonLine {
    /// Its mean frequency, Hz.
    pub frequency_hz: f64,
    /// How far around it a peak is the same line, Hz.
    pub within_hz: f64,
    /// In how many recordings it was found: all of them.
    pub recordings: usize,
    /// Of how many samples they are.
    pub samples: usize,
    /// The fastest over the slowest speed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_ratio: Option<f64>,
    /// Whose it is.
    pub origin: LineOrigin,
}

impl CommonLine {
    /// Whether it certainly comes neither from the finger nor from the texture.
    #[must_use]
    pub fn is_the_machines(&self) -> bool {
        matches!(self.origin, LineOrigin::Mains | LineOrigin::Machine)
    }

    fn holds(&self, frequency_hz: f64) -> bool {
        (frequency_hz - self.frequency_hz).abs() <= self.within_hz
    }
}

/// The lines that the PSDs of all `recordings` have at one frequency, lowest first; none for fewer than three recordings
/// or fewer than two samples.
///
/// Formula: peaks of every mean PSD no more than one line apart. What a finger or a texture makes moves with the speed,
/// f = v/λ; what is found at speeds more than 10 % apart and does not move is the machine's.
///
/// Source: f = v/λ, J. Scheibert et al. (2009), Science 323(5920); the rule is ours.
#[must_use]
pub fn common_lines(recordings: &[LinesOf<'_>]) -> Vec<CommonLine> {
    let mut samples: Vec<&str> = recordings.iter().map(|r| r.sample).collect();
    samples.sort_unstable();
    samples.dedup();
    if recordings.len() < ENOUGH || samples.len() < 2 {
        return Vec::new();
    }
    let speeds: Vec<f64> = recordings.iter().filter_map(|r| r.speed_m_s).collect();
    let (slowest, fastest) = speeds
        .iter()
        .fold((f64::MAX, 0.0), |(low, high): (f64, f64), v| {
            (low.min(*v), high.max(*v))
        });
    let speed_ratio =
        (speeds.len() == recordings.len() && slowest > 0.0).then(|| fastest / slowest);
    let within_hz = SAME_LINE
        * recordings
            .iter()
            .map(|r| r.psd.resolution_hz)
            .fold(0.0, f64::max);
    let found: Vec<Vec<f64>> = recordings
        .iter()
        .map(|r| {
            let found = peaks(&r.psd.mean, r.psd.resolution_hz, r.band);
            found.iter().map(|peak| peak.frequency_hz).collect()
        })
        .collect();
    let mut lines: Vec<CommonLine> = found[0]
        .iter()
        .filter_map(|first| {
            let near: Vec<f64> = found
                .iter()
                .map(|all| {
                    let nearest = all
                        .iter()
                        .min_by(|a, b| (*a - first).abs().total_cmp(&(*b - first).abs()))?;
                    ((nearest - first).abs() <= within_hz).then_some(*nearest)
                })
                .collect::<Option<_>>()?;
            let frequency_hz = crate::statistics::mean(&near);
            let moves_not = speed_ratio.is_some_and(|ratio| ratio > OTHER_SPEED);
            Some(CommonLine {
                frequency_hz,
                within_hz,
                recordings: recordings.len(),
                samples: samples.len(),
                speed_ratio,
                origin: match moves_not {
                    true if of_the_mains(frequency_hz, within_hz) => LineOrigin::Mains,
                    true => LineOrigin::Machine,
                    false => LineOrigin::NotDecided,
                },
            })
        })
        .collect();
    lines.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    lines
}

fn of_the_mains(frequency_hz: f64, resolution_hz: f64) -> bool {
    [50.0, 60.0].iter().any(|mains| {
        let order = (frequency_hz / mains).round();
        (1.0..=MAINS_ORDERS as f64).contains(&order)
            && (frequency_hz - order * mains).abs() <= MAINS_NEAR * resolution_hz
    })
}

/// Removes machine and mains `lines` (Hz) from the peaks that `summary` assigns to finger and texture: such a peak is neither
/// the ridge frequency of the finger nor a harmonic of the texture's period.
///
/// Source: [`common_lines`].
pub fn set_apart(summary: &mut Summary, lines: &[CommonLine]) {
    let machines: Vec<CommonLine> = lines
        .iter()
        .filter(|l| l.is_the_machines())
        .copied()
        .collect();
    let of_machine = |hz: f64| machines.iter().any(|line| line.holds(hz));
    if let Some(finger) = &mut summary.fingerprint
        && finger.found_hz.is_some_and(of_machine)
    {
        finger.found_hz = None;
        finger.ridge_wavelength_m = None;
    }
    for tooth in &mut summary.comb {
        tooth.found_hz = tooth.found_hz.filter(|hz| !of_machine(*hz));
    }
    let own = |line: &&CommonLine| {
        summary
            .peaks
            .iter()
            .any(|peak| line.holds(peak.frequency_hz))
    };
    summary.machine_lines_hz = machines
        .iter()
        .filter(own)
        .map(|line| line.frequency_hz)
        .collect();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Hertz;

    /// A flat PSD with 2 Hz between lines, and lines at `tones_hz`.
    fn spectra(tones_hz: &[f64]) -> StrokeSpectra {
        let each = (0..501)
            .map(|k| {
                let hz = 2.0 * f64::from(k);
                let near = |tone: &&f64| (hz - **tone).abs() < 3.0;
                let lines = tones_hz.iter().filter(near);
                1.0 + 0.1 * f64::from(k * 7919 % 10)
                    + lines
                        .map(|t| 500.0 * (-(hz - t).powi(2)).exp2())
                        .sum::<f64>()
            })
            .collect();
        StrokeSpectra::over(vec![each], 2.0, String::new())
    }

    fn found(all: &[(&str, f64, &[f64])]) -> Vec<CommonLine> {
        let spectra: Vec<StrokeSpectra> = all.iter().map(|(_, _, tones)| spectra(tones)).collect();
        let recordings: Vec<LinesOf<'_>> = all
            .iter()
            .zip(&spectra)
            .map(|((sample, speed, _), psd)| LinesOf {
                sample,
                speed_m_s: Some(*speed),
                psd,
                band: Band::new(Hertz(10.0), Hertz(1000.0)).unwrap(),
            })
            .collect();
        common_lines(&recordings)
    }

    /// 100 Hz (mains) and 137 Hz (the machine) in all; the finger's ridges, 0.4 mm apart, move with the speed.
    #[test]
    fn lines_that_all_samples_have_are_the_machines() {
        let of = found(&[
            ("S1", 0.05, &[100.0, 137.0, 125.0]),
            ("S2", 0.05, &[100.0, 137.0, 125.0, 300.0]),
            ("S1", 0.10, &[100.0, 137.0, 250.0]),
            ("S3", 0.10, &[100.0, 137.0, 250.0, 420.0]),
        ]);
        let named: Vec<(f64, LineOrigin)> = of
            .iter()
            .map(|l| (l.frequency_hz.round(), l.origin))
            .collect();
        assert_eq!(
            named,
            [(100.0, LineOrigin::Mains), (137.0, LineOrigin::Machine)]
        );
        // At one speed a line of all samples may be the finger's.
        let one_speed = found(&[
            ("S1", 0.05, &[125.0]),
            ("S2", 0.05, &[125.0]),
            ("S3", 0.05, &[125.0]),
        ]);
        assert_eq!(one_speed.len(), 1);
        assert!(one_speed[0].origin == LineOrigin::NotDecided && !one_speed[0].is_the_machines());
        // One sample, or two recordings, say nothing of all.
        let one_sample = [
            ("S1", 0.05, &[100.0][..]),
            ("S1", 0.10, &[100.0]),
            ("S1", 0.15, &[100.0]),
        ];
        assert!(found(&one_sample).is_empty() && found(&one_sample[..2]).is_empty());
    }
}
