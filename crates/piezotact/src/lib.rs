//! The science of Piezotact: functions from values to values.
//!
//! A texture vibration and the transfer function of a device with a finger on it go in; spectra, the
//! drive signal that makes the finger feel that texture, and the proof of how close it came, come out.
//! Nothing here touches a file, a clock, a thread or a device: what a function needs is an argument.
//!
//! The modules stand in four layers, and a module uses only what stands before it; `docs/layers.md` has the table and
//! `xtask tidy` checks it:
//!
//! - ground: units, statistics, checksums, criteria, doubts, lineages;
//! - signals: series, recordings, spectra, filters, rates, clipping, integrity;
//! - touch: surfaces, strokes, what they say, what is distinguishable by touch, whole studies;
//! - device: transfer functions, panels, rendering, verification, closed loops, manipulations, scores.

/// `$of` of every kind of doubts: a module that raises doubts of its own has a line here.
macro_rules! kinds_of_doubts {
    ($of:ident) => {
        [
            $of::<crate::recording::RecordingDoubt>,
            $of::<crate::recording::RehearsalDoubt>,
            $of::<crate::spectrum::SpectrumDoubt>,
            $of::<crate::resample::ResampleDoubt>,
            $of::<crate::align::AlignDoubt>,
            $of::<crate::sound::SoundDoubt>,
            $of::<crate::clipping::ClippingDoubt>,
            $of::<crate::integrity::SignalDoubt>,
            $of::<crate::noise::NoiseDoubt>,
            $of::<crate::stroke::StrokeDoubt>,
            $of::<crate::stroke::ForceDoubt>,
            $of::<crate::feature::FeatureDoubt>,
            $of::<crate::discrimination::DiscriminationDoubt>,
            $of::<crate::compare::CompareDoubt>,
            $of::<crate::transfer::TransferDoubt>,
            $of::<crate::transfer::ImpactDoubt>,
            $of::<crate::run::RunDoubt>,
            $of::<crate::run::ForceSourceDoubt>,
            $of::<crate::panel::PanelDoubt>,
            $of::<crate::render::RenderDoubt>,
            $of::<crate::verify::VerifyDoubt>,
            $of::<crate::correct::LoopDoubt>,
            $of::<crate::correct::MeasurementFaultDoubt>,
            $of::<crate::manipulate::ManipulateDoubt>,
            $of::<crate::score::ScoreDoubt>,
            $of::<crate::prepare::PrepareDoubt>,
        ]
    };
}

// Ground.
pub mod checksum;
pub mod criterion;
pub mod document;
pub mod doubt;
pub mod figure;
pub mod fourier;
pub mod invocation;
pub mod lineage;
pub mod number;
pub mod page;
pub mod quantity;
pub mod statistics;

// Signals.
pub mod align;
pub mod clipping;
pub mod convolve;
pub mod filter;
pub mod integrity;
pub mod noise;
pub mod recording;
pub mod resample;
pub mod series;
pub mod share;
pub mod sound;
pub mod spectrum;

// Touch.
pub mod compare;
pub mod discrimination;
pub mod feature;
pub mod roles;
pub mod stroke;
pub mod study;
pub mod surface;

// Device.
pub mod correct;
pub mod device;
pub mod manipulate;
pub mod monitor;
pub mod panel;
pub mod prepare;
pub mod render;
pub mod run;
pub mod score;
pub mod transfer;
pub mod verify;
pub mod wording;

pub use doubt::Doubt;
pub use series::Series;
