//! The kinds of rendering in the benchmark: faults, and differences that are still right.

use super::scene::Texture;

/// A modification of a rendering or of its recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    // Level.
    /// By so many dB.
    Level(f64),
    /// From half of it above to half of it below, dB, evenly over the texture.
    Ramp(f64),
    /// Amplitude modulation at 4 Hz by this share.
    Modulated(f64),
    // Spectrum.
    StrongestLineMissing,
    WeakLineMissing,
    StrongestBandMissing,
    BandMissing,
    StrongestBandBoosted(f64),
    BandBoosted(f64),
    /// dB an octave.
    Tilt(f64),
    LowPass,
    // In time.
    /// Silence for so many seconds.
    DropOut(f64),
    TapsLost(usize),
    /// So many seconds of silence inserted.
    Pause(f64),
    SecondHalfSilent,
    FirstHalfTwice,
    /// A fade of so many seconds at both ends.
    FadeUntold(f64),
    /// The first quarter of a short texture.
    AttackMissing,
    /// The first third rises.
    AttackSmeared,
    /// A click as high as the texture, 40 ms after it, or in a pause.
    ClickAdded,
    /// A tick of a train.
    TickLost,
    /// 10 ms later than the others.
    TickLate,
    Echo,
    /// Played faster by this share.
    Faster(f64),
    /// A delay that swings by so many ms at 0.7 Hz.
    Wander(f64),
    RandomWalk,
    // Waveform.
    Polarity,
    Conjugate,
    Reversed,
    PhasesTurned,
    // Added.
    WhiteNoise(f64),
    PinkNoise(f64),
    ToneInStrongest(f64),
    ToneElsewhere(f64),
    ToneBelowBand,
    HumPlaying,
    HumThroughout,
    // Limits.
    Clipped(f64),
    SoftSaturation,
    /// The drive saturates beyond this share of its peak.
    DriveSaturates(f64),
    SensorClips(f64),
    SensorFrozen,
    // Another one.
    /// The one of 20 who differs most but for so many.
    WrongPerson(usize),
    PressedHarder,
    AnotherTexture,
    NoiseInstead,
    RandomPhases,
    AnotherDraw,
    AnotherDrawLevel(f64),
    AnotherDrawBandMissing,
    AnotherDrawTilted,
    // Parts.
    RecordingStops,
    StrongestGivenUp,
    TopGivenUp,
    // Right.
    /// The response is the target, sample by sample.
    Copy,
    Exact,
    Good,
    OtherNoise,
    NoisierSensor,
    OtherPlacement(&'static str),
    Repeat,
    Clock(f64),
    Delay(f64),
    CutStart,
    LostSamples,
    Offset,
    Baseline,
    OneLine,
    RenderedAt(f64),
}

/// Whether a fault is a gross one, on which a verdict has to be found, where the truth is that it is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Size {
    Usual,
    Gross,
    /// In replicate alone.
    GrossWaveform,
}

impl Kind {
    /// All of them: those that are meant to be wrong, and then those that are meant to be right.
    pub(super) fn all() -> Vec<Self> {
        use Kind::*;
        vec![
            Level(2.0),
            Level(-2.0),
            Level(3.0),
            Level(-3.0),
            Level(6.0),
            Level(-6.0),
            Ramp(6.0),
            Ramp(12.0),
            Modulated(0.8),
            StrongestLineMissing,
            WeakLineMissing,
            StrongestBandMissing,
            BandMissing,
            StrongestBandBoosted(6.0),
            BandBoosted(6.0),
            Tilt(3.0),
            Tilt(-3.0),
            LowPass,
            DropOut(0.02),
            DropOut(0.05),
            DropOut(0.1),
            DropOut(0.2),
            DropOut(0.5),
            DropOut(1.0),
            TapsLost(1),
            TapsLost(2),
            TapsLost(5),
            Pause(0.1),
            Pause(0.3),
            SecondHalfSilent,
            FirstHalfTwice,
            FadeUntold(0.5),
            FadeUntold(0.02),
            AttackMissing,
            AttackSmeared,
            ClickAdded,
            TickLost,
            TickLate,
            Echo,
            Faster(0.03),
            Faster(0.2),
            Faster(-0.2),
            Wander(0.5),
            Wander(1.0),
            Wander(3.0),
            RandomWalk,
            Polarity,
            Conjugate,
            Reversed,
            PhasesTurned,
            WhiteNoise(-6.0),
            PinkNoise(-6.0),
            ToneInStrongest(0.0),
            ToneElsewhere(-6.0),
            ToneBelowBand,
            HumPlaying,
            HumThroughout,
            Clipped(0.05),
            Clipped(0.2),
            Clipped(0.45),
            SoftSaturation,
            DriveSaturates(0.4),
            DriveSaturates(0.8),
            SensorClips(0.01),
            SensorClips(0.05),
            SensorFrozen,
            WrongPerson(0),
            WrongPerson(3),
            WrongPerson(9),
            PressedHarder,
            AnotherTexture,
            NoiseInstead,
            AnotherDrawLevel(-3.0),
            AnotherDrawLevel(3.0),
            AnotherDrawBandMissing,
            AnotherDrawTilted,
            RecordingStops,
            StrongestGivenUp,
            TopGivenUp,
            Copy,
            Exact,
            Good,
            OtherNoise,
            NoisierSensor,
            RandomPhases,
            AnotherDraw,
            OtherPlacement("again"),
            OtherPlacement("tomorrow"),
            Repeat,
            Level(0.3),
            Level(-0.3),
            Level(0.5),
            Level(-0.5),
            Clock(10e-6),
            Clock(50e-6),
            Clock(-50e-6),
            Delay(0.1),
            Delay(0.000_137),
            CutStart,
            LostSamples,
            Wander(0.01),
            ToneElsewhere(-50.0),
            WhiteNoise(-40.0),
            Offset,
            Baseline,
            OneLine,
            Tilt(0.1),
            RenderedAt(-6.0),
        ]
    }

    /// Whether it can happen to this texture of so many samples.
    pub(super) fn happens_to(self, texture: Texture, samples: usize) -> bool {
        match self {
            Self::TapsLost(_) => texture == Texture::Taps,
            Self::TickLost | Self::TickLate => texture == Texture::Train,
            Self::AttackMissing | Self::AttackSmeared | Self::ClickAdded => texture.is_short(),
            Self::Faster(share) if share.abs() > 0.1 => texture.is_short(),
            Self::Clipped(share) | Self::SensorClips(share) => share * samples as f64 >= 3.0,
            Self::FadeUntold(s) => s < 0.1 || !texture.is_short(),
            // They last longer than a short texture, or are narrower than its lines.
            Self::Modulated(_)
            | Self::StrongestLineMissing
            | Self::WeakLineMissing
            | Self::OneLine
            | Self::DropOut(_)
            | Self::Pause(_)
            | Self::Wander(_)
            | Self::RandomWalk
            | Self::ToneBelowBand
            | Self::SensorFrozen
            | Self::LostSamples
            | Self::AnotherDraw
            | Self::AnotherDrawLevel(_)
            | Self::AnotherDrawBandMissing
            | Self::AnotherDrawTilted
            | Self::StrongestGivenUp
            | Self::TopGivenUp => !texture.is_short(),
            _ => true,
        }
    }

    pub(super) fn size(self) -> Size {
        match self {
            Self::Level(db) if db.abs() >= 6.0 => Size::Gross,
            Self::DropOut(s) | Self::Pause(s) if s >= 0.1 => Size::Gross,
            Self::StrongestBandMissing | Self::SecondHalfSilent => Size::Gross,
            Self::Polarity => Size::GrossWaveform,
            _ => Size::Usual,
        }
    }

    pub(super) fn name(self) -> String {
        match self {
            Self::Level(db) => format!("level {db:+} dB"),
            Self::Ramp(db) => format!("level falls by {db} dB"),
            Self::Modulated(share) => format!("modulated {:.0} % at 4 Hz", share * 100.0),
            Self::StrongestLineMissing => "strongest line missing".into(),
            Self::WeakLineMissing => "weak line missing".into(),
            Self::StrongestBandMissing => "strongest band missing".into(),
            Self::BandMissing => "third octave missing".into(),
            Self::StrongestBandBoosted(db) => format!("strongest band {db:+} dB"),
            Self::BandBoosted(db) => format!("third octave {db:+} dB"),
            Self::Tilt(db) => format!("tilt {db:+} dB/octave"),
            Self::LowPass => "low-pass 250 Hz".into(),
            Self::DropOut(s) => format!("drop-out {:.0} ms", s * 1e3),
            Self::TapsLost(n) => format!("{n} of 20 taps lost"),
            Self::Pause(s) => format!("pause {:.0} ms", s * 1e3),
            Self::SecondHalfSilent => "second half silent".into(),
            Self::FirstHalfTwice => "first half twice".into(),
            Self::FadeUntold(s) => format!("fade {:.0} ms", s * 1e3),
            Self::Echo => "echo 30 ms".into(),
            Self::Faster(share) => format!("{:.0} % faster", share * 100.0),
            Self::AttackMissing => "attack missing".into(),
            Self::AttackSmeared => "attack smeared".into(),
            Self::ClickAdded => "click added".into(),
            Self::TickLost => "tick lost".into(),
            Self::TickLate => "tick 10 ms late".into(),
            Self::Wander(ms) => format!("delay wanders ±{ms} ms"),
            Self::RandomWalk => "delay walks at random".into(),
            Self::Polarity => "polarity".into(),
            Self::Conjugate => "conjugate".into(),
            Self::Reversed => "time reversed".into(),
            Self::PhasesTurned => "phases turned ±2 rad".into(),
            Self::WhiteNoise(db) => format!("white noise {db} dB"),
            Self::PinkNoise(db) => format!("pink noise {db} dB"),
            Self::ToneInStrongest(db) => format!("tone in strongest {db} dB"),
            Self::ToneElsewhere(db) => format!("tone elsewhere {db} dB"),
            Self::ToneBelowBand => "felt tone of 12 Hz".into(),
            Self::HumPlaying => "hum while playing".into(),
            Self::HumThroughout => "hum throughout".into(),
            Self::Clipped(share) => format!("clipped {:.0} %", share * 100.0),
            Self::SoftSaturation => "soft saturation".into(),
            Self::DriveSaturates(share) => format!("drive saturates at {:.0} %", share * 100.0),
            Self::SensorClips(share) => format!("sensor clips {:.0} %", share * 100.0),
            Self::SensorFrozen => "sensor frozen 300 ms".into(),
            Self::WrongPerson(0) => "wrong person, most different".into(),
            Self::WrongPerson(n) => format!("wrong person, {n} differ more"),
            Self::PressedHarder => "pressed by 0.6 N".into(),
            Self::AnotherTexture => "another texture".into(),
            Self::NoiseInstead => "noise instead".into(),
            Self::RandomPhases => "random phases".into(),
            Self::AnotherDraw => "another draw".into(),
            Self::AnotherDrawLevel(db) => format!("another draw {db:+} dB"),
            Self::AnotherDrawBandMissing => "another draw, band missing".into(),
            Self::AnotherDrawTilted => "another draw, tilt +3 dB".into(),
            Self::RecordingStops => "recording stops half-way".into(),
            Self::StrongestGivenUp => "strongest given up, told".into(),
            Self::TopGivenUp => "above 700 Hz given up, told".into(),
            Self::Copy => "the target itself".into(),
            Self::Exact => "exact".into(),
            Self::Good => "good rendering".into(),
            Self::OtherNoise => "other noise".into(),
            Self::NoisierSensor => "sensor noise +6 dB".into(),
            Self::OtherPlacement(run) => format!("placed {run}"),
            Self::Repeat => "repeat, load ±5 %".into(),
            Self::Clock(share) => format!("clock {:+.0} ppm", share * 1e6),
            Self::Delay(s) => format!("delay {:.1} ms", s * 1e3),
            Self::CutStart => "recording starts with it".into(),
            Self::LostSamples => "3 samples lost".into(),
            Self::Offset => "offset".into(),
            Self::Baseline => "baseline drifts".into(),
            Self::OneLine => "one line −3 dB".into(),
            Self::RenderedAt(db) => format!("rendered at {db} dB, told"),
        }
    }
}
