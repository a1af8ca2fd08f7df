//! Rendered stimuli as values: of which sample each is made, how, and with whose transfer function.

use std::borrow::Cow;
use std::collections::BTreeSet;

use piezotact::feature::FeatureConfig;
use piezotact::lineage::{BandChange, Level, WarpedLength};
use piezotact::manipulate::{
    ManipulateError, Texture, change_band, gain, level, rms_of, shift, spectrum_of, warp,
};
use piezotact::quantity::{Acceleration, Band, Decibels, Hertz};
use serde::{Deserialize, Serialize};

use super::{Method, Protocol, Sequence, Task, TaskKind, TransferFunctionUse};

/// A rendered stimulus. That of a sample as it was touched has the name of the sample, and is not listed. What is stated is done in the
/// order of the fields.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Stimulus {
    /// Its name: `S2 INVERTED`.
    pub name: String,
    /// The sample whose friction-induced vibration it is made from.
    pub of: String,
    /// The sample whose spectrum it has, at its own level; absent where the spectrum is its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spectrum_of: Option<String>,
    /// By how much all frequencies are multiplied, 0.1 to 10, over the same length.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub warp: Option<f64>,
    /// By how many Hz all frequencies are moved, -1000 to 1000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shift_hz: Option<f64>,
    /// A band that is changed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub band: Option<BandStated>,
    /// The sample whose rms level it has; absent where the level is its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub level_of: Option<String>,
    /// How much higher its rms level is than that, in dB, -60 to 60; absent where it is not changed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain_db: Option<f64>,
    /// Its rms level in dB re 1 m/s², -60 to 40, for detection thresholds, in place of `level_of` and `gain_db`; absent where it follows from samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rms_db: Option<f64>,
    /// Whose transfer function it is rendered with, where it is not that of `rendering`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transfer_function: Option<TransferFunctionUse>,
    /// The sample that the hypothesis expects as answer; absent where it is the one that it is made from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected: Option<String>,
}

/// A band that is changed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct BandStated {
    /// The band: `[100, 300]`.
    pub hz: Band,
    /// By how much it is raised, in dB, -60 to 60; absent where it is removed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain_db: Option<f64>,
}

impl Stimulus {
    /// The samples that it takes something of: its own first.
    pub fn samples(&self) -> impl Iterator<Item = &String> {
        let others = self.spectrum_of.iter().chain(&self.level_of);
        std::iter::once(&self.of).chain(others)
    }

    /// The sample whose level it has.
    #[must_use]
    pub fn level_of(&self) -> &str {
        self.level_of.as_ref().unwrap_or(&self.of)
    }

    /// How much higher its level is than that of [`Self::level_of`], dB.
    #[must_use]
    pub fn gain_db(&self) -> f64 {
        self.gain_db.unwrap_or(0.0)
    }

    /// Its level in words: `the rms level of S13`, `-30 dB re 1 m/s²`; absent where it is its own.
    #[must_use]
    pub fn level_in_words(&self) -> Option<String> {
        let of = self
            .level_of
            .as_ref()
            .map(|of| format!("the rms level of {of}"));
        self.rms_db.map(rms_in_words).or(of)
    }

    /// The sample that the hypothesis expects as answer.
    #[must_use]
    pub fn expected(&self) -> &str {
        self.expected.as_ref().unwrap_or(&self.of)
    }

    /// Whether the protocol states its level: not where its spectrum alone is changed.
    #[must_use]
    pub fn states_level(&self) -> bool {
        let is_of_spectrum = self.warp.is_some() || self.shift_hz.is_some() || self.band.is_some();
        !is_of_spectrum || self.level_of.is_some() || self.gain_db.is_some()
    }

    /// Whether it has the waveform of its sample, at whatever level.
    #[must_use]
    pub fn keeps_waveform(&self) -> bool {
        let Self {
            spectrum_of,
            warp,
            shift_hz,
            band,
            ..
        } = self;
        spectrum_of.is_none() && warp.is_none() && shift_hz.is_none() && band.is_none()
    }

    /// Whether it is made as `other` is, whatever their names and hypotheses.
    #[must_use]
    pub fn is_made_as(&self, other: &Self) -> bool {
        let made = |one: &Self| Self {
            name: String::new(),
            expected: None,
            ..one.clone()
        };
        made(self) == made(other)
    }

    /// What is done to its spectrum, each in words: `spectrum of S13`, `warp × 1.2`.
    #[must_use]
    pub fn of_spectrum(&self) -> Vec<String> {
        let spectrum = self.spectrum_of.as_ref();
        let mut words: Vec<String> = spectrum
            .map(|of| format!("spectrum of {of}"))
            .into_iter()
            .collect();
        words.extend(self.warp.map(|ratio| format!("warp × {ratio}")));
        words.extend(self.shift_hz.map(|by_hz| format!("shift {by_hz:+} Hz")));
        words.extend(self.band.map(|band| match band.gain_db {
            Some(gain_db) => format!("{} {gain_db:+} dB", band.hz),
            None => format!("{} removed", band.hz),
        }));
        words
    }
}

/// A stated rms level.
pub(in crate::campaign) fn rms_in_words(rms_db: f64) -> String {
    format!("{rms_db} dB re 1 m/s²")
}

impl BandStated {
    /// What is done to it.
    #[must_use]
    pub fn change(self) -> BandChange {
        match self.gain_db {
            Some(gain_db) => BandChange::Gain { gain_db },
            None => BandChange::Removed,
        }
    }
}

impl Stimulus {
    /// Its texture, m/s², made of the textures `of` samples as they were touched, with all steps in its lineage. Levels are those that are
    /// `measured` there: within the band that is rendered, as nothing else is played.
    ///
    /// Source: thesis 4.4.1 and figure 62 for levels; docs/decisions/rendering.md.
    ///
    /// # Errors
    /// [`ManipulateError`] of what cannot be done; [`ManipulateError::NoOther`] where `of` has no texture of a sample.
    pub fn texture<'a>(
        &self,
        of: impl Fn(&str) -> Option<&'a Texture<Acceleration>>,
        measured: Level,
    ) -> Result<Texture<Acceleration>, ManipulateError> {
        let of = |sample: &str| of(sample).ok_or(ManipulateError::NoOther);
        let mut texture = of(&self.of)?.clone();
        if let Some(other) = &self.spectrum_of {
            let other = of(other)?.clone();
            let other = other.at_rate(&self.name, texture.series.rate())?;
            let length = other.series.samples().len();
            let config = FeatureConfig::usual(other.series.rate(), &[length], None);
            let config = config.map_err(|error| ManipulateError::Segments {
                said: error.to_string(),
            })?;
            let done = spectrum_of(&texture.series, &other, &config.welch)?;
            texture = texture.then(done);
        }
        if let Some(ratio) = self.warp {
            let done = warp(&texture.series, ratio, WarpedLength::Kept)?;
            texture = texture.then(done);
        }
        if let Some(by_hz) = self.shift_hz {
            let done = shift(&texture.series, Hertz(by_hz))?;
            texture = texture.then(done);
        }
        if let Some(band) = self.band {
            let done = change_band(&texture.series, band.hz, band.change())?;
            texture = texture.then(done);
        }
        if let Some(rms_db) = self.rms_db {
            let own = Decibels::from_amplitude_ratio(level(&texture.series, measured)?);
            let done = gain(&texture.series, Decibels(rms_db - own.0))?;
            return Ok(texture.then(done));
        }
        // What was done to its spectrum may have changed its level too.
        let changed = !self.keeps_waveform() && self.states_level();
        if changed || self.level_of.is_some() {
            let done = rms_of(&texture.series, of(self.level_of())?, measured)?;
            texture = texture.then(done);
        }
        if let Some(gain_db) = self.gain_db {
            let done = gain(&texture.series, Decibels(gain_db))?;
            texture = texture.then(done);
        }
        Ok(texture)
    }
}

impl Protocol {
    /// The stimulus called `name`, with how it is made; `None` where the protocol declares no such stimulus or sample.
    #[must_use]
    pub fn stimulus(&self, name: &str) -> Option<Cow<'_, Stimulus>> {
        let made = self.stimuli.iter().find(|one| one.name == name);
        let plain = || {
            let sample = self.samples.iter().find(|sample| *sample == name)?;
            Some(Cow::Owned(Stimulus {
                name: sample.clone(),
                of: sample.clone(),
                ..Stimulus::default()
            }))
        };
        made.map(Cow::Borrowed).or_else(plain)
    }

    /// The sample that is the physical origin of `stimulus`; the stimulus of a sample has its name.
    #[must_use]
    pub fn sample_of<'a>(&'a self, stimulus: &'a str) -> Option<&'a str> {
        self.named(stimulus, |made| &made.of)
    }

    /// The answer that is expected for `stimulus`: its sample, or the one that the hypothesis names.
    #[must_use]
    pub fn expected<'a>(&'a self, stimulus: &'a str) -> Option<&'a str> {
        self.named(stimulus, Stimulus::expected)
    }

    fn named<'a>(&'a self, stimulus: &str, of: fn(&'a Stimulus) -> &'a str) -> Option<&'a str> {
        let made = self.stimuli.iter().find(|one| one.name == stimulus);
        let plain = || self.samples.iter().find(|sample| *sample == stimulus);
        made.map(of).or_else(|| plain().map(String::as_str))
    }

    /// Whose transfer function `stimulus` is rendered with; `None` where the protocol renders nothing.
    #[must_use]
    pub fn transfer_function_of<'a>(
        &'a self,
        stimulus: &'a Stimulus,
    ) -> Option<&'a TransferFunctionUse> {
        let of_all = self.rendering.as_ref().map(|all| &all.transfer_function);
        stimulus.transfer_function.as_ref().or(of_all)
    }

    /// The samples of all blocks of `task`, in the order of the protocol.
    #[must_use]
    pub fn touched_in(&self, task: &Task) -> Vec<&String> {
        let blocks = self.sessions.iter().flat_map(|session| &session.blocks);
        let blocks = blocks.filter(|block| block.tasks.contains(&task.name));
        let groups = blocks.flat_map(|block| self.groups(&block.over)).flatten();
        let used: BTreeSet<&String> = groups.flat_map(|group| group.samples).collect();
        let all = self.samples.iter();
        all.filter(|sample| used.contains(sample)).collect()
    }

    /// The stimuli that are rendered in the counted trials of `task`.
    #[must_use]
    pub fn rendered_in<'a>(&'a self, task: &'a Task) -> BTreeSet<&'a str> {
        let names: Vec<&String> = match &task.kind {
            TaskKind::Associate {
                sequence: Sequence::Fixed { tests },
                ..
            } => tests.iter().flat_map(|test| &test.stimuli).collect(),
            TaskKind::Associate { .. } => self.touched_in(task),
            TaskKind::Compare { method, .. } => match method {
                Method::Constant { pairs, .. } => pairs.iter().flatten().collect(),
                Method::Adaptive(adaptive) => {
                    let levels = adaptive.levels.iter().map(|level| &level.stimulus);
                    levels.chain([&adaptive.standard]).collect()
                }
            },
            _ => Vec::new(),
        };
        names.into_iter().map(String::as_str).collect()
    }

    /// All stimuli that are rendered in a session, also in catch trials.
    #[must_use]
    pub fn rendered(&self) -> BTreeSet<&str> {
        let catch = self.tasks.iter().filter_map(|task| task.catch.as_ref());
        let known = catch.flat_map(|catch| catch.known.iter().flatten());
        let counted = self.tasks.iter().flat_map(|task| self.rendered_in(task));
        counted.chain(known.map(String::as_str)).collect()
    }
}

#[cfg(test)]
mod tests {
    use piezotact::quantity::SampleRate;
    use piezotact::series::Series;

    use super::super::{from_library, read};
    use super::*;

    #[test]
    fn a_stated_rms_is_that_of_the_texture_whatever_the_stroke() {
        let protocol = from_library("detection_threshold").unwrap().unwrap();
        let made = protocol.stimulus("S8 at -30 dB").unwrap();
        for peak in [0.02, 7.0] {
            let samples = (0..4000).map(|i| 0.5 + peak * (f64::from(i) * 0.3).sin());
            let rate = SampleRate::new(4000.0).unwrap();
            let stroke = Texture::of("S8", Series::new(samples.collect(), rate).unwrap());
            let texture = made
                .texture(|name| (name == "S8").then_some(&stroke), Level::Whole)
                .unwrap();
            let rms = texture.series.rms_about_mean().value;
            assert!((rms - 10_f64.powf(-1.5)).abs() < 1e-12, "{rms}");
        }
        assert_eq!(made.level_in_words().unwrap(), "-30 dB re 1 m/s²");
        let toml = super::super::LIBRARY[6].1;
        let refused =
            |from: &str, to: &str| read(&toml.replacen(from, to, 1)).unwrap_err().to_string();
        let both = refused("rms_db = -42", "rms_db = -42, gain_db = 3");
        assert!(
            both.contains("stimulus S8 at -42 dB: `rms_db` states the level alone"),
            "{both}"
        );
        let louder = refused("rms_db = -42", "rms_db = -30");
        assert!(louder.contains("must increase"), "{louder}");
    }
}
