//! Errors as exceptions of the package.

use std::fmt::Display;

use piezotact_app::library::{CallError, ErrorKind};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// The exception of `error`, with its sentence, and the value that is refused where the parser of the command line refuses one: its
/// argument, itself, and why.
pub(crate) fn raised(py: Python<'_>, error: &CallError) -> PyErr {
    let name = match error.kind {
        ErrorKind::Usage => "UsageError",
        ErrorKind::Data => "DataError",
    };
    let exception = py
        .import("piezotact._errors")
        .and_then(|module| module.getattr(name))
        .and_then(|class| class.call1((error.sentence.as_str(),)))
        .and_then(|exception| {
            let refused = error.refused.as_ref();
            let refused = refused.map(|one| (&one.argument, &one.value, &one.why));
            exception.setattr("_refused", refused)?;
            Ok(exception)
        });
    exception.map_or_else(|failed| failed, PyErr::from_value)
}

/// What cannot be unless there is a fault in the package.
pub(crate) fn internal(what: impl Display) -> PyErr {
    PyRuntimeError::new_err(format!(
        "a fault in piezotact: {what}; please report it with what was called"
    ))
}
