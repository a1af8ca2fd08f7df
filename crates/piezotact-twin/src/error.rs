//! Why the twin cannot be used as asked.

use piezotact::recording::RecordingError;

/// A length in µm, as a person reads it: to the nm.
fn um(length_m: f64) -> f64 {
    let nm = length_m * 1e9;
    if nm.abs() < 1.0 {
        nm * 1e-3
    } else {
        nm.round() * 1e-3
    }
}

/// Parameters, a relief, a patch of it or an EEG that the twin does not have.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TwinError {
    /// A value outside its range.
    #[error("{what}: expected {expected}, found {found}; {todo}")]
    Value {
        what: String,
        expected: String,
        found: String,
        todo: String,
    },
    /// A sample that is not known.
    #[error(
        "expected a sample of the twin ({known}), found `{found}`; a parameter file can add one, as [samples.{found}]"
    )]
    Sample {
        /// The samples there are.
        known: String,
        /// What was asked for.
        found: String,
    },
    /// A correlation length below what the relief is made of.
    #[error(
        "expected a correlation length (grain times its factor) from {} µm, twice the shortest wave, found {} µm; state a larger grain",
        um(*least_m), um(*found_m)
    )]
    Correlation {
        /// The shortest correlation length, m.
        least_m: f64,
        /// What was found, m.
        found_m: f64,
    },
    /// Dots that touch.
    #[error(
        "expected dots that do not touch, found a diameter of {} µm at a wavelength of {} µm; state a smaller diameter, or diameter and gap together as the wavelength",
        um(*diameter_m), um(*wavelength_m)
    )]
    Touching { diameter_m: f64, wavelength_m: f64 },
    /// An edge so round that dots have no top, or that neighbours meet.
    #[error(
        "expected an edge radius up to {} µm, half the diameter and half the gap, found {} µm; state a smaller one",
        um(*most_m), um(*found_m)
    )]
    Edge {
        /// The largest radius, m.
        most_m: f64,
        /// What was found, m.
        found_m: f64,
    },
    /// A step that does not resolve the relief, or resolves what is not there.
    #[error(
        "expected a step from {} µm to {} µm (a quarter of {of}), found {} µm; state another",
        um(*least_m), um(*most_m), um(*found_m)
    )]
    Step {
        /// What a quarter of is the longest step.
        of: &'static str,
        /// The shortest step, m.
        least_m: f64,
        /// The longest step, m.
        most_m: f64,
        /// What was found, m.
        found_m: f64,
    },
    /// A side of too few or too many steps.
    #[error(
        "expected {what} of 8 to 4096 steps of {} µm, found {} µm; state another side or another step",
        um(*step_m), um(*found_m)
    )]
    Side {
        what: &'static str,
        step_m: f64,
        /// What was found, m.
        found_m: f64,
    },
    /// A patch too small to say how rough the sample is.
    #[error(
        "expected a longer side from {} µm, four correlation lengths, found {} µm; map a larger patch",
        um(*least_m), um(*found_m)
    )]
    Small {
        /// Four correlation lengths, m.
        least_m: f64,
        /// What was found, m.
        found_m: f64,
    },
    /// Heights that make no map.
    #[error(transparent)]
    Map(#[from] piezotact::surface::SurfaceError),
    /// Channels that make no recording.
    #[error(transparent)]
    Recording(#[from] RecordingError),
}

/// [`TwinError::Value`].
pub(crate) fn wrong(
    what: &str,
    expected: impl Into<String>,
    found: impl ToString,
    todo: &str,
) -> TwinError {
    TwinError::Value {
        what: what.into(),
        expected: expected.into(),
        found: found.to_string(),
        todo: todo.into(),
    }
}
