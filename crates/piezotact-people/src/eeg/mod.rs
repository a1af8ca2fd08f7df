//! EEG: from continuous signals to event-related desynchronisation, and to what differs over people.
//!
//! `Continuous` + events → [`epochs::Epochs`] → [`tfr::TfrPlan`] → [`tfr::Power`] → [`erd::Erd`] of each person → [`cluster::test`] and
//! [`contrast::paired`] over people. Signals are in V; power of wavelets is in V².
//!
//! Conventions are those of MNE-Python 1.13.2 (A. Gramfort et al. 2013, Front. Neurosci. 7), against which `golden/eeg.py` computes
//! reference values. A negative ERD is a desynchronisation (G. Pfurtscheller and F. H. Lopes da Silva 1999, Clin. Neurophysiol. 110).

pub mod cluster;
pub mod contrast;
pub mod counts;
pub mod epochs;
pub mod erd;
pub mod filter;
pub mod group;
mod held;
pub mod info;
mod linear;
pub mod person;
pub mod prepare;
pub mod pulses;
mod quality;
pub mod reference;
pub mod regression;
pub mod source;
pub mod tfr;
mod warning;

pub use warning::{
    Bias, EegWarning, ElectrodesFault, EpochsFault, LeftOutElectrodes, MarkersFault, NotCommon,
    PositionsFault, Smeared,
};
