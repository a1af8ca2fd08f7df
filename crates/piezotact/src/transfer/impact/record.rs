//! What an impact test was evaluated with, and what its hits were: kept with the transfer function.

use serde::{Deserialize, Serialize};

use super::fault::HitFault;
use crate::number::rounded;

/// An exponential window that leaves less than exp(−300) at the end of a segment leaves nothing but its beginning.
pub(super) const MOST_DAMPING: f64 = 300.0;

/// One hit of an impact test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Hit {
    /// When its pulse begins, s.
    pub at_s: f64,
    /// The peak of the force, with its sign, in the unit of the force.
    pub peak: f64,
    /// How long the force is above 5 % of the largest hit, s.
    pub duration_s: f64,
    /// Why it was not used; none of a hit that was.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub faults: Vec<HitFault>,
}

impl Hit {
    /// Whether it was used.
    #[must_use]
    pub fn is_used(&self) -> bool {
        self.faults.is_empty()
    }
}

/// What an impact test was evaluated with, and its hits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ImpactTest {
    /// Every hit found, in the order of time.
    pub hits: Vec<Hit>,
    /// The length of a segment, s.
    pub segment_s: f64,
    /// How much of a segment lies before the hit, s.
    pub pretrigger_s: f64,
    /// The length of the force window from the beginning of the segment with its taper, s; absent where there was none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_window_s: Option<f64>,
    /// The damping σ that an exponential window exp(−σt) of force and response added to every resonance, 1/s; 0 where there was
    /// none. The function is H(jω + σ).
    pub added_damping_per_s: f64,
    /// The level of the response at the end of the segment re its largest, 0–1, before any window, in the octave that has
    /// decayed least; absent in files that do not state it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left: Option<f64>,
    /// Lines whose force lies by more than this below its highest level are not excited, dB.
    pub excited_within_db: f64,
}

impl ImpactTest {
    /// What no impact test can have, with its value: a file that was changed by hand may hold it.
    #[must_use]
    pub fn contradiction(&self) -> Option<String> {
        let positive = |value: f64| value.is_finite() && value > 0.0;
        let hits = |sound: &dyn Fn(&Hit) -> bool| self.hits.iter().find(|hit| !sound(hit));
        if !positive(self.segment_s) {
            return Some(format!("a segment of {} s", rounded(self.segment_s)));
        }
        if !(0.0..self.segment_s).contains(&self.pretrigger_s) {
            let (before, segment) = (rounded(self.pretrigger_s), rounded(self.segment_s));
            return Some(format!(
                "{before} s before the hit in a segment of {segment} s"
            ));
        }
        if let Some(length_s) = self.force_window_s.filter(|length| !positive(*length)) {
            return Some(format!("a force window of {} s", rounded(length_s)));
        }
        let most = MOST_DAMPING / self.segment_s;
        if !(0.0..=most).contains(&self.added_damping_per_s) {
            return Some(format!(
                "an added damping of {} 1/s over a segment of {} s",
                rounded(self.added_damping_per_s),
                rounded(self.segment_s)
            ));
        }
        if let Some(left) = self.left.filter(|left| !(0.0..=1.0).contains(left)) {
            return Some(format!("{} of the response left", rounded(left)));
        }
        if let Some(hit) = hits(&|hit| hit.at_s.is_finite() && hit.at_s >= 0.0) {
            return Some(format!("a hit at {} s", rounded(hit.at_s)));
        }
        if let Some(hit) = hits(&|hit| hit.peak.is_finite() && hit.peak != 0.0) {
            return Some(format!("a hit with a peak of {}", rounded(hit.peak)));
        }
        if let Some(hit) = hits(&|hit| hit.duration_s.is_finite() && hit.duration_s >= 0.0) {
            return Some(format!("a pulse of {} s", rounded(hit.duration_s)));
        }
        (self.used() == 0).then(|| format!("{} hits and none used", self.hits.len()))
    }

    /// How many hits were used.
    #[must_use]
    pub fn used(&self) -> usize {
        self.hits.iter().filter(|hit| hit.is_used()).count()
    }

    /// By how much the half-power bandwidth of every resonance is larger because of the exponential window, Hz.
    ///
    /// Formula: σ/π.
    ///
    /// Source: a resonance exp(−δt) has the half-power bandwidth δ/π, and the window makes it exp(−(δ + σ)t).
    #[must_use]
    pub fn added_bandwidth_hz(&self) -> f64 {
        self.added_damping_per_s / std::f64::consts::PI
    }
}

/// What a report draws of an impact test: time in s re the beginning of the hit, frequency in Hz.
#[derive(Clone, Debug, PartialEq)]
pub struct ImpactTraces {
    /// The force of every hit that was used, around the pulse.
    pub force: Vec<Vec<(f64, f64)>>,
    /// The response of every hit that was used, over the segment.
    pub response: Vec<Vec<(f64, f64)>>,
    /// The window of the force, 0–1, without the exponential.
    pub force_window: Vec<(f64, f64)>,
    /// The exponential window, 1 at the hit; none where there was none.
    pub exponential: Vec<(f64, f64)>,
    /// The mean spectrum of the force re its highest level, dB.
    pub force_db: Vec<(f64, f64)>,
}
