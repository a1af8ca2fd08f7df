//! What a command gave, for Python.

use piezotact::page::Page;
use piezotact_app::library::{self, Ended};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

use crate::errors;
use crate::watched;

/// What a command gave.
#[derive(Serialize, Deserialize)]
#[pyclass(frozen, module = "piezotact._piezotact")]
pub(crate) struct Called {
    /// The document that `--json` prints, as JSON; None where there is none.
    #[pyo3(get)]
    document: Option<String>,
    /// The warnings with their codes and sentences.
    #[pyo3(get)]
    warnings: Vec<(String, String)>,
    /// What the command prints beside, line by line.
    #[pyo3(get)]
    printed: Vec<String>,
    /// What the command says beside, line by line.
    #[pyo3(get)]
    said: Vec<String>,
    /// How it ended: "done", "not passed", "passed in part", "not decided".
    #[pyo3(get)]
    ended: String,
    page: Option<Page>,
}

impl Called {
    /// Of what a command gave. Where it failed behind a result, such as one file of several, the result stands and the error is said.
    pub(crate) fn of(py: Python<'_>, called: library::Called) -> PyResult<Self> {
        let mut said = called.said;
        let ended = match called.ended {
            Ok(Ended::Done) => "done",
            Ok(Ended::NotPassed) => "not passed",
            Ok(Ended::PassedInPart) => "passed in part",
            Ok(Ended::NotDecided) => "not decided",
            Err(error) if called.document.is_none() => return Err(errors::raised(py, &error)),
            Err(error) => {
                said.push(error.sentence);
                "done in part"
            }
        };
        let warnings = called.warnings.into_iter();
        Ok(Self {
            document: called.document.map(|document| document.to_string()),
            warnings: warnings.map(|one| (one.code, one.text)).collect(),
            printed: called.printed,
            said,
            ended: ended.to_owned(),
            page: called.page,
        })
    }
}

#[pymethods]
impl Called {
    /// Whether there is a report.
    #[getter]
    fn has_page(&self) -> bool {
        self.page.is_some()
    }

    /// The report as one HTML file; None where there is none.
    fn html(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let Some(page) = self.page.clone() else {
            return Ok(None);
        };
        let html = watched::run(py, move || library::html(&page))?;
        html.map(Some).map_err(|error| errors::raised(py, &error))
    }

    /// The table of the report as CSV; None where there is none.
    fn csv(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let table = self.page.as_ref().map(library::csv).transpose();
        let table = table.map_err(|error| errors::raised(py, &error))?;
        Ok(table.flatten())
    }

    /// The figures of the report as JSON, each with what is drawn and its caption.
    fn figures(&self) -> PyResult<String> {
        let figures = self.page.as_ref().map(library::figures);
        serde_json::to_string(&figures.unwrap_or_default()).map_err(errors::internal)
    }

    /// All of it as JSON, for another process.
    fn to_json(&self) -> PyResult<String> {
        serde_json::to_string(self).map_err(errors::internal)
    }

    /// What `to_json` wrote.
    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        serde_json::from_str(text).map_err(errors::internal)
    }

    /// The report as text; None where there is none.
    fn text(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let text = self.page.as_ref().map(library::text).transpose();
        text.map_err(|error| errors::raised(py, &error))
    }
}
