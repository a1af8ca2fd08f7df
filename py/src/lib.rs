//! The extension behind the Python package: recordings over arrays, commands as functions, and the program itself. It computes nothing.

mod called;
mod errors;
mod recording;
mod watched;

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::PathBuf;

use piezotact_app::library;
use pyo3::prelude::*;

use called::Called;
use recording::RecordingData;

/// Does what `words` ask for as the program `piezotact` (the first word is its name), and returns the exit code. `again` starts this
/// program. It takes over signals, and is called once in a process.
#[pyfunction]
fn program(py: Python<'_>, words: Vec<OsString>, again: Vec<OsString>) -> u8 {
    py.detach(|| piezotact_app::program(&words, again))
}

/// Does what `words` ask for as a function. A word that is the name of one of the recordings `given` stands for that recording.
#[pyfunction]
fn call(
    py: Python<'_>,
    words: Vec<OsString>,
    given: Vec<(PathBuf, Py<RecordingData>)>,
) -> PyResult<Called> {
    let given = given.into_iter();
    let given = given.map(|(name, data)| (name, data.get().contents()));
    let given: BTreeMap<_, _> = given.collect();
    let called = watched::run(py, move || library::call(&words, given))?;
    Called::of(py, called)
}

/// Every command with its arguments, as JSON.
#[pyfunction]
fn commands() -> PyResult<String> {
    serde_json::to_string(&library::commands()).map_err(errors::internal)
}

/// The transfer function in the file at `path`, of any format that is read, as JSON.
#[pyfunction]
fn transfer_function(py: Python<'_>, path: PathBuf) -> PyResult<String> {
    let found = watched::run(py, move || library::transfer_function(&path))?;
    found.map_err(|error| errors::raised(py, &error))
}

#[pymodule]
fn _piezotact(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<RecordingData>()?;
    module.add_class::<Called>()?;
    module.add_function(wrap_pyfunction!(program, module)?)?;
    module.add_function(wrap_pyfunction!(call, module)?)?;
    module.add_function(wrap_pyfunction!(commands, module)?)?;
    module.add_function(wrap_pyfunction!(transfer_function, module)?)
}
