//! The time from output to input over many restarts.

use crate::recording::{LostBy, RecordingWarning};
use serde::{Deserialize, Serialize};

use super::{CalibrationFault, SoundWarning};
use crate::document::Content;
use crate::quantity::{SampleRate, Seconds};
use crate::warning::{Few, FewWarning, Warning};

/// Fewer restarts do not carry a 99th percentile.
const FEW: usize = 50;

/// One start of the streams, and what its loopback held.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct LatencyRun {
    /// From the sample given out to the sample taken in, s; absent where the loopback did not hold the signal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub latency_s: Option<Seconds>,
    /// The recorded value per played value.
    pub gain: f64,
    /// Times that the output or the input lost samples.
    pub drop_outs: u64,
}

/// Median and upper percentiles of latencies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Spread {
    /// The median, s.
    pub median_s: Seconds,
    /// 95 % are at most this, s.
    pub p95_s: Seconds,
    /// 99 % are at most this, s.
    pub p99_s: Seconds,
    /// The smallest and the largest, s.
    pub range_s: [Seconds; 2],
}

/// The latency of a sound device over restarts: a document.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct LatencySummary {
    /// The device, by host and ids.
    pub device: String,
    /// When it was measured: a date, as the caller gives it.
    pub measured_on: String,
    /// The rate of the streams, Hz.
    pub rate_hz: SampleRate,
    /// The frames of a buffer.
    pub buffer_frames: u32,
    /// The latencies; absent where no restart gave one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub latency: Option<Spread>,
    /// Every restart in its order.
    pub runs: Vec<LatencyRun>,
    /// What to know of it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[serde(alias = "doubts")]
    pub warnings: Vec<Warning>,
}

/// The latencies that count: a start that lost samples says something else, if there are others.
fn used(runs: &[LatencyRun]) -> impl Iterator<Item = Seconds> {
    let whole = |run: &LatencyRun| run.drop_outs == 0 && run.latency_s.is_some();
    let any_whole = runs.iter().any(whole);
    let own = runs.iter().filter(move |run| !any_whole || whole(run));
    own.filter_map(|run| run.latency_s)
}

impl Content for LatencySummary {
    const SCHEMA: &'static str = "sound_latency";
}

impl LatencySummary {
    /// The summary of `runs` of one device, in their order.
    ///
    /// Starts that lost samples are not counted, unless all did.
    ///
    /// Formula: percentiles are the smallest latency that at least their share does not exceed.
    ///
    /// Source: Hyndman and Fan (1996), definition 1.
    #[must_use]
    pub fn of(
        device: &str,
        measured_on: &str,
        rate_hz: SampleRate,
        buffer_frames: u32,
        runs: Vec<LatencyRun>,
    ) -> Self {
        let mut found: Vec<f64> = used(&runs).map(|s| s.0).collect();
        found.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let rank = (share * found.len() as f64).ceil() as usize;
            found.get(rank.max(1) - 1).copied().map(Seconds)
        };
        let latency = (|| {
            Some(Spread {
                median_s: at(0.5)?,
                p95_s: at(0.95)?,
                p99_s: at(0.99)?,
                range_s: [Seconds(*found.first()?), Seconds(*found.last()?)],
            })
        })();
        let mut warnings = Vec::new();
        let silent = runs.iter().filter(|run| run.latency_s.is_none()).count();
        let restarts = runs.len();
        let dropped = runs.iter().filter(|run| run.drop_outs > 0).count();
        if restarts < FEW {
            warnings.push(Warning::from(FewWarning::Few {
                found: restarts,
                recommended: FEW,
                what: Few::Restarts,
            }));
        }
        if silent + dropped > 0 {
            warnings.push(Warning::from(RecordingWarning::SamplesLost {
                by: LostBy::Restarts {
                    silent,
                    dropped,
                    restarts,
                },
            }));
        }
        Self {
            device: device.into(),
            measured_on: measured_on.into(),
            rate_hz,
            buffer_frames,
            latency,
            runs,
            warnings,
        }
    }

    /// The warning about a latency that was measured before, when one that is `found` now lies outside its range by more than `slack`.
    ///
    /// Source: docs/decisions/sound.md.
    #[must_use]
    pub fn changed(&self, found: Seconds, slack: Seconds) -> Option<Warning> {
        let [low, high] = self.latency?.range_s;
        let is_within = (low.0 - slack.0..=high.0 + slack.0).contains(&found.0);
        (!is_within).then(|| {
            Warning::from(SoundWarning::Calibration {
                fault: CalibrationFault::LatencyChanged {
                    measured_on: self.measured_on.clone(),
                    stored_s: self.latency.map_or(0.0, |spread| spread.median_s.0),
                    found_s: found.0,
                },
            })
        })
    }

    /// The restarts whose latency counts.
    #[must_use]
    pub fn found(&self) -> usize {
        used(&self.runs).count()
    }

    /// Whether there are enough of them for percentiles.
    #[must_use]
    pub fn has_percentiles(&self) -> bool {
        self.found() >= FEW
    }

    /// The largest difference between a latency and their median, s, of two or more: how far a time that is corrected by the median was off. No
    /// difference below half a sample is known.
    ///
    /// Source: docs/decisions/sound.md.
    #[must_use]
    pub fn scatter_s(&self) -> Option<Seconds> {
        let latency = self.latency.filter(|_| self.found() > 1)?;
        let [low, high] = latency.range_s.map(|s| (s.0 - latency.median_s.0).abs());
        Some(Seconds(low.max(high).max(0.5 / self.rate_hz.hz())))
    }
}
