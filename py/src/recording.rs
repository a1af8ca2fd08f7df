//! Recordings, whose samples stay in Rust and are views in Python.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use numpy::ndarray::ArrayView1;
use numpy::{PyArray1, PyReadonlyArray1, PyUntypedArrayMethods as _};
use piezotact::recording::Condition;
use piezotact_app::library;
use piezotact_dataset::{ArrayChannel, Contents};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;

use crate::errors;
use crate::watched;

/// A recording as commands read it, and what is found in its samples.
#[pyclass(frozen, module = "piezotact._piezotact")]
pub(crate) struct RecordingData {
    contents: Arc<Contents>,
    /// Codes and sentences.
    warnings: Vec<(String, String)>,
}

impl RecordingData {
    pub(crate) fn contents(&self) -> Arc<Contents> {
        Arc::clone(&self.contents)
    }

    fn of(contents: Contents) -> Self {
        let warnings = library::said(&library::warnings(&contents)).into_iter();
        Self {
            warnings: warnings.map(|one| (one.code, one.text)).collect(),
            contents: Arc::new(contents),
        }
    }
}

#[pymethods]
impl RecordingData {
    /// The recording in the file at `path`; the others are the options of reading of a command.
    #[staticmethod]
    fn read(
        py: Python<'_>,
        path: PathBuf,
        scale: Vec<String>,
        rate_hz: Option<f64>,
        part: Option<usize>,
    ) -> PyResult<Self> {
        let reading = move || {
            let contents = library::read(Path::new(&path), &scale, rate_hz, part);
            contents.map(Self::of)
        };
        watched::run(py, reading)?.map_err(|error| errors::raised(py, &error))
    }

    /// The recording of arrays of float64 without gaps: name, unit and samples of each. `condition` is JSON. What is found in the
    /// samples is only looked for where warnings are `wanted`.
    #[staticmethod]
    #[allow(
        clippy::fn_params_excessive_bools,
        reason = "it is called from Python, which has True and False for it"
    )]
    fn of_arrays(
        py: Python<'_>,
        name: PathBuf,
        channels: Vec<(String, Option<String>, PyReadonlyArray1<'_, f64>)>,
        rate_hz: f64,
        condition: &str,
        wanted: bool,
    ) -> PyResult<Self> {
        let condition: Condition = serde_json::from_str(condition)
            .map_err(|wrong| PyValueError::new_err(format!("condition: {wrong}")))?;
        let channels: Vec<ArrayChannel> = channels
            .into_iter()
            .map(|(name, unit, samples)| {
                // The one copy: what Python does with its array later changes nothing.
                let samples = samples.as_slice()?.to_vec();
                Ok(ArrayChannel {
                    name,
                    unit,
                    samples,
                })
            })
            .collect::<PyResult<_>>()?;
        let making = move || {
            let contents = library::recording_of(&name, channels, rate_hz, condition);
            contents.map(|contents| match wanted {
                true => Self::of(contents),
                false => Self {
                    contents: Arc::new(contents),
                    warnings: Vec::new(),
                },
            })
        };
        watched::run(py, making)?.map_err(|error| errors::raised(py, &error))
    }

    /// Name, unit, rate in Hz, start in s and length of every channel.
    #[getter]
    fn channels(&self) -> Vec<(String, String, f64, f64, usize)> {
        let channels = self.contents.recording.channels_with_clocks();
        let described = channels.map(|(channel, clock)| {
            (
                channel.name.clone(),
                channel.unit.to_string(),
                clock.rate_hz.hz(),
                clock.start_s.0,
                channel.samples.len(),
            )
        });
        described.collect()
    }

    /// The samples of the channel of this number, as an array that cannot be written and that keeps the recording.
    #[allow(
        unsafe_code,
        reason = "an array over memory of Rust is made by an unsafe function"
    )]
    fn samples<'py>(own: &Bound<'py, Self>, number: usize) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let channels = own.get().contents.recording.channels();
        let channel = channels
            .get(number)
            .ok_or_else(|| PyIndexError::new_err("expected the number of a channel"))?;
        let view = ArrayView1::from(&channel.samples[..]);
        // SAFETY: the array's base is this object, which is frozen and holds the contents as long as it lives; nobody changes the
        // samples of contents that are shared.
        let array = unsafe { PyArray1::borrow_from_array(&view, own.clone().into_any()) };
        array.getattr("flags")?.setattr("writeable", false)?;
        debug_assert_eq!(array.len(), channel.samples.len());
        Ok(array)
    }

    #[getter]
    fn rate_hz(&self) -> f64 {
        self.contents.recording.rate().hz()
    }

    #[getter]
    fn duration_s(&self) -> f64 {
        self.contents.recording.duration().0
    }

    /// The kind of file: "WAV, 16-bit".
    #[getter]
    fn kind(&self) -> String {
        self.contents.kind.to_string()
    }

    /// The condition as JSON.
    #[getter]
    fn condition(&self) -> PyResult<String> {
        serde_json::to_string(&self.contents.recording.about.condition).map_err(errors::internal)
    }

    /// Codes and sentences of the warnings.
    #[getter]
    fn warnings(&self) -> Vec<(String, String)> {
        self.warnings.clone()
    }
}
