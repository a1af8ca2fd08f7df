//! Lines common to all recordings, independent of sample and speed: they come from the machine or the mains, not from a texture.

use serde::{Deserialize, Serialize};

use super::Summary;
use super::left_out::beside;
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
/// Speeds of one sample count as different from this ratio on where lines that stay are looked for in it alone.
const CERTAINLY_OTHER_SPEED: f64 = 1.2;
/// Hum has its strongest lines below this, Hz.
const HUM_HZ: f64 = 190.0;
/// Fewer recordings than this share a line by chance too often.
const ENOUGH: usize = 3;
/// What of a line stands so many lines beside it …
const SKIRT_LINES: usize = 3;
/// … above what stands so many beside it …
const FLOOR_LINES: usize = 9;
/// … is at most this share of a tone: a Hann window leaves less than a thousandth.
const SKIRT_SHARE: f64 = 0.03;
/// A recording has a line that rises by more than this above what is beside it, dB …
const RISES_DB: f64 = 10.0;
/// … and has none at a frequency where nothing rises by this, dB.
const LACKS_DB: f64 = 3.0;

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
    /// The lines of whole strokes, each with its width, Hz, where they are needed.
    pub fine_hz: &'a [[f64; 2]],
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
    /// It does not move with the speed and is broader than a tone: a resonance of the machine, of the mount of the sensor, or of the finger.
    Resonance,
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
    /// Whether it certainly comes neither from the ridges of the finger nor from the texture.
    #[must_use]
    pub fn is_the_machines(&self) -> bool {
        self.origin != LineOrigin::NotDecided
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
    let within_hz = within_hz(recordings);
    let moves_not = speed_ratio.is_some_and(|ratio| ratio > OTHER_SPEED);
    let line = |frequency_hz: f64| CommonLine {
        frequency_hz,
        within_hz,
        recordings: recordings.len(),
        samples: samples.len(),
        speed_ratio,
        origin: match moves_not {
            true if !is_narrow(recordings, frequency_hz) => LineOrigin::Resonance,
            true if of_the_mains(frequency_hz, within_hz) => LineOrigin::Mains,
            true => LineOrigin::Machine,
            false => LineOrigin::NotDecided,
        },
    };
    shared(recordings).into_iter().map(line).collect()
}

/// Whether the line at `hz` is as narrow as the window of the PSDs makes a tone: three lines beside it next to nothing of it is left.
fn is_narrow(recordings: &[LinesOf<'_>], hz: f64) -> bool {
    let shares = recordings.iter().map(|one| {
        let psd = &one.psd.mean;
        let at = (hz / one.psd.resolution_hz).round() as usize;
        let beside = |lines: usize| {
            let sides = [at.saturating_sub(lines), at + lines];
            let sides = sides.iter().filter_map(|k| psd.get(*k).copied());
            crate::statistics::mean(&sides.collect::<Vec<_>>())
        };
        let near = psd.iter().skip(at.saturating_sub(1)).take(3);
        let floor = beside(FLOOR_LINES);
        let height = near.copied().fold(0.0, f64::max) - floor;
        (beside(SKIRT_LINES) - floor) / height.max(f64::MIN_POSITIVE)
    });
    crate::statistics::mean(&shares.collect::<Vec<_>>()) <= SKIRT_SHARE
}

/// How far apart peaks of `recordings` are one line, Hz.
fn within_hz(recordings: &[LinesOf<'_>]) -> f64 {
    let steps = recordings.iter().map(|r| r.psd.resolution_hz);
    SAME_LINE * steps.fold(0.0, f64::max)
}

/// The peaks of `one`, Hz.
fn peaks_hz(one: &LinesOf<'_>) -> Vec<f64> {
    let found = peaks(&one.psd.mean, one.psd.resolution_hz, one.band);
    found.iter().map(|peak| peak.frequency_hz).collect()
}

/// The mean frequencies of the peaks that all of `recordings` have, Hz, lowest first.
fn shared(recordings: &[LinesOf<'_>]) -> Vec<f64> {
    let within_hz = within_hz(recordings);
    let found: Vec<Vec<f64>> = recordings.iter().map(peaks_hz).collect();
    let Some(first) = found.first() else {
        return Vec::new();
    };
    let near_all = |first: &f64| {
        let near: Option<Vec<f64>> = found
            .iter()
            .map(|all| {
                let nearest = all
                    .iter()
                    .min_by(|a, b| (*a - first).abs().total_cmp(&(*b - first).abs()))?;
                ((nearest - first).abs() <= within_hz).then_some(*nearest)
            })
            .collect();
        near.map(|near| crate::statistics::mean(&near))
    };
    let mut lines: Vec<f64> = first.iter().filter_map(near_all).collect();
    lines.sort_by(f64::total_cmp);
    lines
}

/// The mean frequencies of the lines of whole strokes that all of `recordings` have, Hz.
fn shared_fine(recordings: &[LinesOf<'_>]) -> Vec<f64> {
    let Some((first, others)) = recordings.split_first() else {
        return Vec::new();
    };
    let near_all = |[hz, width_hz]: &[f64; 2]| {
        let near: Option<Vec<f64>> = others
            .iter()
            .map(|other| {
                let mut lines = other.fine_hz.iter();
                let line =
                    lines.find(|[own, width]| (own - hz).abs() <= 0.5 * width.max(*width_hz));
                line.map(|[own, _]| *own)
            })
            .collect();
        near.map(|near| (near.iter().sum::<f64>() + hz) / recordings.len() as f64)
    };
    first.fine_hz.iter().filter_map(near_all).collect()
}

/// The frequencies of the peaks, Hz, that one of `recordings` has and another one of its sample lacks, there and where its speed would move
/// them to: a texture makes its lines whenever it is touched at that speed.
fn of_some_recordings(recordings: &[LinesOf<'_>]) -> Vec<f64> {
    let rise_db = |one: &LinesOf<'_>, hz: f64| {
        let psd = &one.psd.mean;
        let line = beside(psd, hz / one.psd.resolution_hz).into_iter();
        let ratios = line.map(|(bin, straight)| psd[bin] / straight);
        10.0 * ratios.fold(0.0, f64::max).log10()
    };
    let lack = |one: &LinesOf<'_>, hz: f64| {
        let mut others = recordings.iter().filter(|other| other.sample == one.sample);
        others.any(|other| {
            let ratio = other.speed_m_s.zip(one.speed_m_s).map(|(a, b)| a / b);
            let places = ratio.map(|ratio| [hz, hz * ratio]);
            places.is_some_and(|places| places.iter().all(|hz| rise_db(other, *hz) < LACKS_DB))
        })
    };
    let of = |one| peaks_hz(one).into_iter().map(move |hz| (one, hz));
    let peaks = recordings.iter().flat_map(of);
    let found = peaks.filter(|(one, hz)| rise_db(one, *hz) > RISES_DB && lack(one, *hz));
    found.map(|(_, hz)| hz).collect()
}

/// The lines of which it is not known whether the textures make them, Hz, lowest first. `recordings` are those of one speed: what all of them
/// have, where they are of two samples at least, may be of the machine or of the finger, also where it moves with the speed; what one recording
/// has and another of the same sample lacks is not of the texture alone. `all_speeds` are recordings
/// of each sample: what one sample has at one frequency at three speeds or more does not move. Peaks at the mains and its second and third
/// harmonic may be hum, also in one recording alone.
///
/// Formula: lines of whole strokes no more than half of their width apart, or peaks no more than one line of the PSDs apart; speeds whose ratio is above 1.2 are different ones.
///
/// Source: house rule, as for [`common_lines`].
#[must_use]
pub fn lines_in_doubt(recordings: &[LinesOf<'_>], all_speeds: &[Vec<LinesOf<'_>>]) -> Vec<f64> {
    let samples = |all: &[LinesOf<'_>]| all.iter().any(|one| one.sample != all[0].sample);
    let mut found = if samples(recordings) {
        [shared(recordings), shared_fine(recordings)].concat()
    } else {
        Vec::new()
    };
    for of_sample in all_speeds {
        let mut speeds: Vec<f64> = of_sample.iter().filter_map(|r| r.speed_m_s).collect();
        speeds.sort_by(f64::total_cmp);
        speeds.dedup_by(|faster, slower| *faster <= CERTAINLY_OTHER_SPEED * *slower);
        if speeds.len() >= ENOUGH {
            found.extend(shared(of_sample));
        }
    }
    found.extend(of_some_recordings(recordings));
    for one in recordings {
        let hum = |hz: &f64| of_the_mains(*hz, one.psd.resolution_hz) && *hz < HUM_HZ;
        found.extend(peaks_hz(one).into_iter().filter(hum));
    }
    found.sort_by(f64::total_cmp);
    let within_hz = within_hz(recordings);
    found.dedup_by(|a, b| *a - *b <= 0.5 * within_hz);
    found
}

fn of_the_mains(frequency_hz: f64, resolution_hz: f64) -> bool {
    [50.0, 60.0].iter().any(|mains| {
        let order = (frequency_hz / mains).round();
        (1.0..=MAINS_ORDERS as f64).contains(&order)
            && (frequency_hz - order * mains).abs() <= MAINS_NEAR * resolution_hz
    })
}

/// Removes machine and mains `lines` (Hz) from the peaks that `summary` assigns to finger and texture: such a peak is neither
/// the ridge frequency of the finger nor a harmonic of the texture's period. Those, and the lines `in_doubt_hz`, are noted with the share of
/// the power that they hold.
///
/// Source: [`common_lines`].
pub fn set_apart(summary: &mut Summary, lines: &[CommonLine], in_doubt_hz: &[f64]) {
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
    let machines = machines.iter().map(|line| line.frequency_hz);
    let mut apart_hz: Vec<f64> = machines.chain(in_doubt_hz.iter().copied()).collect();
    apart_hz.sort_by(f64::total_cmp);
    let step_hz = summary.psd.resolution_hz;
    apart_hz.dedup_by(|a, b| *a - *b <= 0.5 * step_hz);
    let (mut left, all) = (summary.psd.mean.clone(), &summary.psd.mean);
    for hz in &apart_hz {
        for (bin, straight) in beside(&left, hz / step_hz) {
            left[bin] = straight.min(left[bin]);
        }
    }
    let power = all.iter().sum::<f64>();
    if power > 0.0 {
        summary.share_in_doubt = 1.0 - left.iter().sum::<f64>() / power;
    }
    summary.lines_in_doubt_hz = apart_hz;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Hertz;

    /// A resonance of a finger that is excited at every speed stays at its frequency, at 200 Hz too: it is neither hum nor a machine's for sure.
    #[test]
    fn a_broad_peak_that_stays_is_a_resonance() {
        let resonance = |hz: f64, quality: f64| {
            let of = |k: i32| {
                let ratio = 2.0 * f64::from(k) / hz;
                let gain = (1.0 - ratio * ratio).powi(2) + (ratio / quality).powi(2);
                0.2 + 0.01 * f64::from(k * 7919 % 10) + 0.2 / gain
            };
            StrokeSpectra::over(vec![(0..501).map(of).collect()], 2.0, String::new())
        };
        for (hz, quality) in [(200.0, 15.0), (150.0, 10.0), (223.0, 15.0)] {
            let psd = resonance(hz, quality);
            let all: Vec<LinesOf<'_>> = [("S1", 0.02), ("S2", 0.02), ("S1", 0.05), ("S2", 0.05)]
                .map(|(sample, speed_m_s)| LinesOf {
                    sample,
                    speed_m_s: Some(speed_m_s),
                    psd: &psd,
                    band: Band::new(Hertz(10.0), Hertz(1000.0)).unwrap(),
                    fine_hz: &[],
                })
                .to_vec();
            let found = common_lines(&all);
            let near = found
                .iter()
                .find(|line| (line.frequency_hz - hz).abs() < 6.0);
            assert_eq!(near.unwrap().origin, LineOrigin::Resonance, "{found:?}");
        }
    }

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
                fine_hz: &[],
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
