//! Transfer functions as readable JSON.

use piezotact::recording::RecordingWarning;
use piezotact::run::Attempt;
use std::path::Path;

use piezotact::Warning;
use piezotact::device::DriveSetup;
use piezotact::panel::Filing;
use piezotact::quantity::{Band, Quantity, SampleRate, Unit};
use piezotact::recording::About;
use piezotact::transfer::{
    Confidence, Distortion, Estimator, ImpactTest, Limits, StoredIdentities, TransferFunction,
};
use serde::{Deserialize, Serialize};

use crate::error::ReadError;
use crate::version::refuse_newer;

/// A transfer function as it stands in a file: four columns, and what they hold for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TransferDocument {
    /// The unit of the drive.
    #[serde(default = "full_scale")]
    pub drive_unit: Unit,
    /// The unit of the response.
    #[serde(default = "acceleration")]
    pub response_unit: Unit,
    /// How it was estimated.
    #[serde(default = "h1")]
    pub estimator: Estimator,
    /// Whether the drive is known without noise: it is the signal that was sent, not a measurement of it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    #[serde(alias = "exact_drive")]
    pub known_input: bool,
    /// The number of segments averaged; 0 when not known.
    #[serde(default)]
    pub averages: usize,
    /// The number of independent averages that scatter as much; `averages` where it is absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effective_averages: Option<f64>,
    /// From the lowest to the highest line that was excited.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[serde(alias = "driven_hz")]
    pub excited_hz: Option<Band>,
    /// The rate of the recording it was estimated from, Hz; twice the highest frequency when absent.
    #[serde(default)]
    pub rate_hz: Option<SampleRate>,
    /// Who touched how, where it comes from, and what a person should know before relying on it.
    #[serde(flatten)]
    pub about: About,
    /// The device it was measured through.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drive: Option<DriveSetup>,
    /// The lines, Hz, evenly from 0.
    pub frequency_hz: Vec<f64>,
    /// The real part of every line.
    pub real: Vec<f64>,
    /// The imaginary part of every line.
    pub imaginary: Vec<f64>,
    /// The coherence of every line; empty where there is one average, which has none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub coherence: Vec<f64>,
    /// The hits and the windows of an impact test, with the damping that an exponential window added.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub impact: Option<ImpactTest>,
    /// How far every line may be off; written for other programs, as it follows from coherence and averages.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub confidence: Option<ConfidenceColumns>,
    /// How a stored function agrees with the spectra that were stored beside it; absent where none were.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub identities: Option<StoredIdentities>,
    /// The attempts at the measurement with what was judged of each; none where nothing was judged, or nobody knows.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub attempts: Vec<Attempt>,
    /// Noise and distortion, where multisines separated them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distortion: Option<Distortion>,
    /// The panel for which it was measured; absent elsewhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub measured_for: Option<MeasuredFor>,
}

/// For which panel, and as which measurement of it, a transfer function was measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasuredFor {
    /// What all measurements of the panel have in common.
    pub bench: String,
    /// The participant, load, angle, placement and repeat.
    #[serde(flatten)]
    pub filing: Filing,
}

/// The limits of every line as they stand in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConfidenceColumns {
    /// What the limits hold: `best_linear` with 95 % confidence, or `scatter`, the random error alone.
    pub of: Limits,
    /// The lower limit of the magnitude of every line.
    pub low: Vec<f64>,
    /// The upper limit; absent where there is none.
    pub high: Vec<Option<f64>>,
    /// How far the phase may lie on either side, rad.
    pub phase_reach_rad: Vec<f64>,
}

impl From<Confidence> for ConfidenceColumns {
    fn from(confidence: Confidence) -> Self {
        let known = |high: f64| high.is_finite().then_some(high);
        Self {
            of: confidence.of,
            low: confidence.low,
            high: confidence.high.into_iter().map(known).collect(),
            phase_reach_rad: confidence.phase_reach_rad,
        }
    }
}

fn full_scale() -> Unit {
    Unit::FullScale
}

fn acceleration() -> Unit {
    Unit::MetrePerSecondSquared
}

fn h1() -> Estimator {
    Estimator::H1
}

impl TransferDocument {
    /// Whether `other` is of the same person, condition, bench and seed.
    #[must_use]
    pub fn is_of_the_same(&self, other: &Self) -> bool {
        let [one, another] = [self, other].map(|document| &document.about.provenance);
        self.about.condition == other.about.condition
            && one.source == another.source
            && one.seed == another.seed
            && one.answered_with == another.answered_with
    }

    /// The document of `function`, between the units its channels had.
    #[must_use]
    pub fn of<I: Quantity, O: Quantity>(
        function: &TransferFunction<I, O>,
        drive_unit: Unit,
        response_unit: Unit,
    ) -> Self {
        Self {
            drive_unit,
            response_unit,
            estimator: function.estimator,
            known_input: function.known_input,
            averages: function.averages,
            effective_averages: Some(function.effective_averages),
            excited_hz: function.excited,
            rate_hz: Some(function.rate),
            about: function.about.clone(),
            drive: function.drive.clone(),
            frequency_hz: function.frequencies_hz(),
            real: function.response().iter().map(|h| h.re).collect(),
            imaginary: function.response().iter().map(|h| h.im).collect(),
            coherence: if function.has_coherence() {
                function.coherence().to_vec()
            } else {
                Vec::new()
            },
            impact: function.impact.clone(),
            confidence: function.confidence().map(ConfidenceColumns::from),
            identities: None,
            attempts: Vec::new(),
            distortion: None,
            measured_for: None,
        }
    }

    /// The coherence of every line, 0 where there is none, as of one average.
    fn coherence_or_none(&self) -> Vec<f64> {
        let averages = match &self.impact {
            Some(test) => test.used(),
            None => self.averages,
        };
        if averages == 1 && self.coherence.is_empty() {
            return vec![0.0; self.frequency_hz.len()];
        }
        self.coherence.clone()
    }

    /// The transfer function in this document, from `I` to `O`.
    ///
    /// # Errors
    /// [`ReadError::Content`] when its units are not those of `I` and `O`, the columns differ in length, the
    /// frequencies are not evenly spaced from 0 Hz, or a value is no number.
    pub fn function<I: Quantity, O: Quantity>(
        &self,
        path: &Path,
    ) -> Result<TransferFunction<I, O>, ReadError> {
        let mut unstated = Vec::new();
        for (what, expected, found) in [
            ("drive", I::UNIT, &self.drive_unit),
            ("response", O::UNIT, &self.response_unit),
        ] {
            if *found == Unit::Other(String::new()) {
                unstated.push(Warning::from(RecordingWarning::Guessed {
                    what: format!("the {what} of the transfer function has no unit and is assumed to be in {expected}"),
                }));
            } else if expected != *found {
                return Err(ReadError::content(
                    path,
                    format!("a transfer function whose {what} is in {expected}"),
                    format!("{found}"),
                    "use the transfer function of the device that will play the drive",
                ));
            }
        }
        let mut function = self.lines(path)?;
        function.about.warnings.extend(unstated);
        Ok(function)
    }

    /// The same whatever its units are.
    pub(crate) fn lines<I: Quantity, O: Quantity>(
        &self,
        path: &Path,
    ) -> Result<TransferFunction<I, O>, ReadError> {
        if let Some(found) = self.impact.as_ref().and_then(ImpactTest::contradiction) {
            return Err(ReadError::content(
                path,
                "an impact test that can be, in `impact`",
                found,
                "evaluate the recording again",
            ));
        }
        let lines = self.frequency_hz.len();
        let coherence = self.coherence_or_none();
        for (what, found) in [
            ("real", self.real.len()),
            ("imaginary", self.imaginary.len()),
            ("coherence", coherence.len()),
        ] {
            if found != lines {
                return Err(ReadError::content(
                    path,
                    format!("{lines} values in `{what}`, as in `frequency_hz`"),
                    format!("{found}"),
                    "export the complete transfer function",
                ));
            }
        }
        let resolution_hz = self
            .frequency_hz
            .last()
            .map_or(0.0, |last| last / (lines.max(2) - 1) as f64);
        let uneven = self
            .frequency_hz
            .iter()
            .enumerate()
            .find(|(k, f)| (**f - *k as f64 * resolution_hz).abs() > 1e-3 * resolution_hz);
        if let Some((k, found)) = uneven {
            return Err(ReadError::content(
                path,
                format!(
                    "equally spaced frequencies from 0 Hz, {} Hz in line {k}",
                    k as f64 * resolution_hz
                ),
                format!("{found} Hz"),
                "export the transfer function on a uniform axis",
            ));
        }
        let rate = match self.rate_hz {
            Some(rate) => rate,
            None => SampleRate::new(2.0 * resolution_hz * (lines.max(2) - 1) as f64)
                .map_err(ReadError::of(path))?,
        };
        let response = self
            .real
            .iter()
            .zip(&self.imaginary)
            .map(|(re, im)| num_complex::Complex::new(*re, *im))
            .collect();
        let mut function = TransferFunction::from_lines(
            response,
            coherence,
            resolution_hz,
            rate,
            self.estimator,
            self.averages,
        )
        .map_err(ReadError::of(path))?;
        if let Some(effective) = self
            .effective_averages
            .filter(|n| n.is_finite() && *n >= 0.0)
        {
            function.effective_averages = effective;
        }
        function.excited = self.excited_hz;
        function.known_input = self.known_input;
        function.impact.clone_from(&self.impact);
        let few = function.few_averages();
        function.about.warnings.extend(few);
        // What gives a warning when it was measured, and what can be seen now, each once.
        let seen = std::mem::take(&mut function.about.warnings);
        function.about.warnings.clone_from(&self.about.warnings);
        function.about.add_warnings(seen);
        function.about.condition = self.about.condition.clone();
        function.drive = self.drive.clone();
        function.about.provenance = self.about.provenance.clone();
        function.require_possible().map_err(ReadError::of(path))?;
        let limits = self.confidence.as_ref();
        let limits = limits.and_then(|limits| function.warning_of_limits(&limits.low, limits.of));
        let of_lines = function.warnings_of_its_lines();
        function
            .about
            .add_warnings(of_lines.into_iter().chain(limits));
        Ok(function)
    }
}

/// The document in the JSON of a transfer function.
pub(crate) fn parse_json(path: &Path, bytes: &[u8]) -> Result<TransferDocument, ReadError> {
    let not_one = |found: &str| {
        ReadError::content(
            path,
            "the JSON of a transfer function (frequency_hz, real, imaginary, coherence)",
            found,
            "make one with `piezotact characterise` or `piezotact transfer`, or give a universal or a MATLAB file",
        )
    };
    refuse_newer(path, bytes)?;
    let document: TransferDocument = match std::str::from_utf8(bytes) {
        Ok(text) => serde_json::from_str(text).map_err(|error| not_one(&error.to_string()))?,
        Err(_) => return Err(not_one("a file that is not text")),
    };
    let load = document.about.condition.load_n;
    match load.filter(|load| !(0.0..=1e3).contains(&load.0)) {
        Some(load) => Err(ReadError::content(
            path,
            "a load from 0 to 1000 N in `condition.load_n`",
            format!("{} N", load.0),
            "correct it, or leave it out",
        )),
        None => Ok(document),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_that_is_none_is_refused() {
        let file = |load: &str| {
            format!(
                r#"{{"frequency_hz": [0, 1], "real": [1, 1], "imaginary": [0, 0], "coherence": [1, 1], "condition": {{"load_n": {load}}}}}"#
            )
        };
        let path = Path::new("tf.json");
        parse_json(path, file("0.2").as_bytes()).unwrap();
        let error = parse_json(path, file("-5").as_bytes()).unwrap_err();
        assert!(error.to_string().contains("found -5 N"), "{error}");
    }
}
