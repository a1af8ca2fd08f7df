//! The table of manipulations: what each is called, how it is written on the command line, and what it does.
//!
//! A new manipulation is a function of the science and a row in [`MANIPULATIONS`].

use std::path::PathBuf;
use std::sync::Arc;

use piezotact::feature::FeatureConfig;
use piezotact::lineage::{BandChange, Level, WarpedLength};
use piezotact::manipulate::{
    DrawnPhases, JoinConfig, ManipulateError, Manipulated, Texture, Tilt, change_band, gain,
    looped, phases_needed, randomise_phases, rms_of, shift, spectrum_of, tilt, time_reversed, warp,
};
use piezotact::quantity::{Acceleration, Band, Decibels, Hertz, Seconds};
use piezotact::series::Series;

/// Below this a tilt is held: gestures are there, and no device renders it.
const TILT_HELD_BELOW: Hertz = Hertz(10.0);

/// One row of the table.
pub(crate) struct Manipulation {
    /// The option without its dashes.
    pub(crate) option: &'static str,
    /// What its value looks like; none for an option without a value.
    pub(crate) form: Option<&'static str>,
    /// What it does, for people.
    pub(crate) help: &'static str,
    pub(crate) read: fn(&str) -> Result<Requested, String>,
}

/// What the options beside the manipulations say.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Settings {
    /// Where levels are measured.
    pub(crate) measured: Level,
    pub(crate) seed: u64,
}

/// What a manipulation does to a texture, with the other texture that it takes something of.
type Apply = dyn Fn(
        &Series<Acceleration>,
        Settings,
        Option<&Texture<Acceleration>>,
    ) -> Result<Manipulated<Acceleration>, ManipulateError>
    + Send
    + Sync;

/// Another texture that something is taken of.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Other {
    pub(crate) path: PathBuf,
    /// Whether it is brought to the rate of the texture first.
    pub(crate) rate: OtherRate,
}

/// At which rate another texture is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum OtherRate {
    /// At its own.
    Own,
    /// At that of the texture.
    OfTexture,
}

/// What a manipulation leaves of the condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Speed {
    /// The sliding speed holds.
    Kept,
    /// The sliding speed is another.
    Changed,
}

/// One manipulation that is requested.
#[derive(Clone)]
pub(crate) struct Requested {
    /// The other texture, where one is needed.
    pub(crate) other: Option<Other>,
    /// What becomes of the sliding speed.
    pub(crate) speed: Speed,
    apply: Arc<Apply>,
}

impl std::fmt::Debug for Requested {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Requested")
            .field("other", &self.other)
            .field("speed", &self.speed)
            .finish_non_exhaustive()
    }
}

impl Requested {
    /// A manipulation of the texture alone.
    fn alone(
        apply: impl Fn(
            &Series<Acceleration>,
            Settings,
        ) -> Result<Manipulated<Acceleration>, ManipulateError>
        + Send
        + Sync
        + 'static,
    ) -> Self {
        Self {
            other: None,
            speed: Speed::Kept,
            apply: Arc::new(move |x, settings, _| apply(x, settings)),
        }
    }

    /// A manipulation that takes something of the texture at `path`.
    fn with_other(
        path: &str,
        rate: OtherRate,
        apply: impl Fn(
            &Series<Acceleration>,
            Settings,
            &Texture<Acceleration>,
        ) -> Result<Manipulated<Acceleration>, ManipulateError>
        + Send
        + Sync
        + 'static,
    ) -> Self {
        Self {
            other: Some(Other {
                path: path.into(),
                rate,
            }),
            speed: Speed::Kept,
            apply: Arc::new(move |x, settings, other| match other {
                Some(other) => apply(x, settings, other),
                None => Err(ManipulateError::NoOther),
            }),
        }
    }

    /// What it makes of `x`.
    pub(crate) fn apply(
        &self,
        x: &Series<Acceleration>,
        settings: Settings,
        other: Option<&Texture<Acceleration>>,
    ) -> Result<Manipulated<Acceleration>, ManipulateError> {
        (self.apply)(x, settings, other)
    }
}

/// All manipulations, in the order of the help text.
pub(crate) const MANIPULATIONS: [Manipulation; 10] = [
    Manipulation {
        option: "randomise-phases",
        form: None,
        help: "Replaces the phases by random ones (--seed): the same power spectrum, another waveform",
        read: |_| {
            Ok(Requested::alone(|x, settings| {
                let needed = phases_needed(x.samples().len());
                randomise_phases(x, &DrawnPhases::drawn(settings.seed, needed))
            }))
        },
    },
    Manipulation {
        option: "rms-of",
        form: Some("FILE"),
        help: "Scales the texture to the rms of another texture: only a gain",
        read: |path| {
            Ok(Requested::with_other(
                path,
                OtherRate::Own,
                |x, settings, other| rms_of(x, other, settings.measured),
            ))
        },
    },
    Manipulation {
        option: "gain",
        form: Some("DB"),
        help: "Raises or lowers the level, such as -3dB",
        read: |text| {
            let level = Decibels(read_gain(text)?);
            Ok(Requested::alone(move |x, _| gain(x, level)))
        },
    },
    Manipulation {
        option: "band",
        form: Some("LOW..HIGH:DB"),
        help: "Raises or lowers a band in Hz, such as 50..100:+6dB, or removes it: 50..100:remove",
        read: |text| {
            let (band, change) = read_band(text)?;
            Ok(Requested::alone(move |x, _| change_band(x, band, change)))
        },
    },
    Manipulation {
        option: "tilt",
        form: Some("SLOPE@PIVOT"),
        help: "Tilts the spectrum about a frequency, such as 3dB/oct@200Hz; constant gain below 10 Hz",
        read: |text| {
            let slope = read_tilt(text)?;
            Ok(Requested::alone(move |x, _| tilt(x, slope)))
        },
    },
    Manipulation {
        option: "shift",
        form: Some("HZ"),
        help: "Shifts every frequency by this many Hz, such as 20Hz",
        read: |text| {
            let by = read_shift(text)?;
            Ok(Requested::alone(move |x, _| shift(x, by)))
        },
    },
    Manipulation {
        option: "warp",
        form: Some("RATIO"),
        help: "Multiplies every frequency, as at another sliding speed, such as 1.25; 1.25:keep-length keeps the duration",
        read: |text| {
            let (ratio, length) = read_warp(text)?;
            Ok(Requested {
                speed: Speed::Changed,
                ..Requested::alone(move |x, _| warp(x, ratio, length))
            })
        },
    },
    Manipulation {
        option: "spectrum-of",
        form: Some("FILE"),
        help: "Uses the shape of the spectrum of another texture; phases and rms are unchanged",
        read: |path| {
            Ok(Requested::with_other(
                path,
                OtherRate::OfTexture,
                |x, _, other| {
                    // The usual segments of strokes, which other figures have as well.
                    let length = other.series.samples().len();
                    let config = FeatureConfig::usual(other.series.rate(), &[length], None)
                        .map_err(|error| ManipulateError::Segments {
                            said: error.to_string(),
                        })?;
                    spectrum_of(x, other, &config.welch)
                },
            ))
        },
    },
    Manipulation {
        option: "reverse",
        form: None,
        help: "Reverses the texture in time: the same power spectrum, attacks become decays",
        read: |_| Ok(Requested::alone(|x, _| time_reversed(x))),
    },
    Manipulation {
        option: "loop",
        form: Some("SECONDS"),
        help: "Changes the duration, such as 10s: the texture is repeated without clicks, or cut",
        read: |text| {
            let duration = read_length(text)?;
            Ok(Requested::alone(move |x, _| {
                looped(x, duration, &JoinConfig::usual(x.duration()))
            }))
        },
    },
];

/// A number, with or without `unit` after it.
fn number(text: &str, unit: &str) -> Option<f64> {
    let text = text.trim();
    let value: f64 = text
        .strip_suffix(unit)
        .unwrap_or(text)
        .trim()
        .parse()
        .ok()?;
    value.is_finite().then_some(value)
}

fn read_gain(text: &str) -> Result<f64, String> {
    number(text, "dB").ok_or_else(|| "expected a gain in dB; write for example -3dB".into())
}

fn read_band(text: &str) -> Result<(Band, BandChange), String> {
    let wrong = || {
        String::from(
            "expected a band and what to do with it; write for example 50..100:+6dB or 50..100:remove",
        )
    };
    let (band, change) = text.split_once(':').ok_or_else(wrong)?;
    let band: Band = band
        .trim()
        .trim_end_matches("Hz")
        .parse()
        .map_err(|error: piezotact::quantity::QuantityError| error.to_string())?;
    let change = match change.trim() {
        "remove" => BandChange::Removed,
        db => BandChange::Gain {
            gain_db: number(db, "dB").ok_or_else(wrong)?,
        },
    };
    Ok((band, change))
}

fn read_tilt(text: &str) -> Result<Tilt, String> {
    let parts = || {
        let (slope, pivot) = text.split_once('@')?;
        let slope = slope.trim().trim_end_matches("ave");
        Some((number(slope, "dB/oct")?, number(pivot, "Hz")?))
    };
    parts()
        .map(|(db_per_octave, pivot)| Tilt {
            db_per_octave,
            pivot: Hertz(pivot),
            held_below: TILT_HELD_BELOW,
        })
        .ok_or_else(|| {
            "expected a slope and a pivot frequency; write for example 3dB/oct@200Hz".into()
        })
}

fn read_shift(text: &str) -> Result<Hertz, String> {
    number(text, "Hz")
        .map(Hertz)
        .ok_or_else(|| "expected a shift in Hz; write for example 20Hz or -20Hz".into())
}

fn read_warp(text: &str) -> Result<(f64, WarpedLength), String> {
    let (ratio, length) = match text.split_once(':') {
        None => (text, WarpedLength::Follows),
        Some((ratio, "keep-length")) => (ratio, WarpedLength::Kept),
        Some((_, other)) => {
            return Err(format!(
                "expected keep-length after the ratio, found `{other}`; write for example 1.25:keep-length"
            ));
        }
    };
    number(ratio, "x")
        .map(|ratio| (ratio, length))
        .ok_or_else(|| "expected a ratio of frequencies; write for example 1.25".into())
}

fn read_length(text: &str) -> Result<Seconds, String> {
    number(text, "s")
        .map(Seconds)
        .ok_or_else(|| "expected a duration in s; write for example 10s".into())
}
