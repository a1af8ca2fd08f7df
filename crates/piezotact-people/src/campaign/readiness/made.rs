//! Whether the drive of each stimulus was made as the protocol states it: by its samples and its lineage, never by the name of its file.

use std::collections::BTreeMap;

use piezotact::lineage::{BandChange, Level, Lineage, Operation, Step};
use piezotact::manipulate::level;
use piezotact::quantity::{Acceleration, Band, Decibels};
use piezotact::series::Series;

use super::super::chain::Sha;
use super::super::protocol::{Protocol, Stimulus, rms_in_words};
use super::{NotReady, RenderingFacts};

/// Two levels that differ by less are one, dB: protocols state three decimals.
const SAME_LEVEL_DB: f64 = 0.01;
/// Two stimuli that are stated to have one level were measured within this, dB: below the smallest JND of level, 1.65 dB (Israr, Tan and
/// Reed 2006, JASA 120:2789).
const MEASURED_LEVEL_DB: f64 = 1.0;
/// The same stroke at another level differs by rounding alone: the largest share of its rms.
const SAME_WAVEFORM_SHARE: f64 = 1e-3;

impl RenderingFacts {
    /// The band that is rendered; `None` where its lineage does not state it.
    pub(super) fn band(&self) -> Option<Band> {
        let mut steps = self.lineage.as_ref()?.steps.iter().rev();
        steps.find_map(|step| match step.operation {
            Operation::Rendered { band_hz, .. } => Some(band_hz),
            _ => None,
        })
    }

    /// The rms of its target in the band that is rendered, m/s²: what can be played of it.
    pub(super) fn rms_m_s2(&self) -> f64 {
        let within = self.band().map_or(Level::Whole, Level::Within);
        level(&self.texture, within).unwrap_or(0.0)
    }
}

/// A difference: what the protocol states, what was found, and where.
type Difference = (String, String, String);

/// What is wrong with how the `drives` of a session were made, which `played` those of these checksums before.
pub(super) fn faults(
    protocol: &Protocol,
    drives: &[&RenderingFacts],
    played: &BTreeMap<String, Sha>,
) -> Vec<NotReady> {
    let found = drives.iter().enumerate().filter_map(|(i, facts)| {
        let made = protocol.stimulus(&facts.stimulus)?;
        let is_its_own = |other: &&&RenderingFacts| {
            let other_made = protocol.stimulus(&other.stimulus);
            other.samples == facts.samples && !other_made.is_some_and(|one| one.is_made_as(&made))
        };
        if let Some(other) = drives[..i].iter().find(is_its_own) {
            return Some(NotReady::SameDrive {
                stimulus: facts.stimulus.clone(),
                file: facts.file.clone(),
                other: other.stimulus.clone(),
                other_file: other.file.clone(),
            });
        }
        let compared = Compared {
            protocol,
            made: &made,
            facts,
            drives,
        };
        let Some((expected, found, seen_in)) = compared.difference() else {
            // A session plays one drive of a stimulus from its first trial to its last.
            let before = played.get(&facts.stimulus)?;
            return (*before != facts.sha).then(|| NotReady::Exchanged {
                stimulus: facts.stimulus.clone(),
                file: facts.file.clone(),
            });
        };
        Some(NotReady::Made {
            stimulus: facts.stimulus.clone(),
            expected,
            found,
            seen_in,
        })
    });
    found.collect()
}

/// A stimulus as the protocol states it, and what is there of it and of the others.
struct Compared<'a> {
    protocol: &'a Protocol,
    made: &'a Stimulus,
    facts: &'a RenderingFacts,
    drives: &'a [&'a RenderingFacts],
}

impl Compared<'_> {
    /// The first difference.
    fn difference(&self) -> Option<Difference> {
        self.sample()
            .or_else(|| self.target())
            .or_else(|| self.played())
            .or_else(|| self.steps())
            .or_else(|| self.level())
            .or_else(|| self.stroke())
            .or_else(|| self.level_of_samples())
            .or_else(|| self.transfer_function())
            .or_else(|| self.band())
            .or_else(|| self.measured_level())
    }

    /// The drive of `sample` as it was touched, where it is there and not the one that is compared.
    fn plain(&self, sample: &str) -> Option<&RenderingFacts> {
        let mut others = self.drives.iter().copied();
        others.find(|other| other.stimulus == sample && other.stimulus != self.facts.stimulus)
    }

    fn lineage_of_drive(&self) -> String {
        format!("the lineage of {}", self.facts.file)
    }

    /// Another sample was touched: by the target, or by the lineage of the drive.
    fn sample(&self) -> Option<Difference> {
        let facts = self.facts;
        let of_drive = facts.lineage.as_ref().and_then(|one| one.sample.as_deref());
        let stated = [
            (facts.sample.as_deref(), facts.target_file.clone()),
            (of_drive, self.lineage_of_drive()),
        ];
        let mut stated = stated.into_iter();
        stated.find_map(|(found, seen_in)| {
            let found = found.filter(|found| *found != self.made.of)?;
            let expected = format!("a texture of {}", self.made.of);
            Some((expected, format!("one of {found}"), seen_in))
        })
    }

    /// The drive was not rendered from the target beside it, or the target is not what its lineage ends with.
    fn target(&self) -> Option<Difference> {
        let of_target = self.facts.target_lineage.as_ref()?;
        let target = before_rendering(of_target);
        let drive = before_rendering(self.facts.lineage.as_ref()?);
        if target != drive {
            return Some((
                format!("a drive rendered from its target, {target}"),
                format!("one rendered from {drive}"),
                self.lineage_of_drive(),
            ));
        }
        let rendered = |step: &&Step| matches!(step.operation, Operation::Rendered { .. });
        let last = of_target.steps.iter().rev().find(|step| !rendered(step))?;
        let stated = last.rms_after.value;
        let found = self.facts.texture.rms_about_mean().value;
        let off_db = Decibels::from_amplitude_ratio(found / stated).0;
        (off_db.abs() > SAME_LEVEL_DB).then(|| {
            (
                format!("a target of {stated:.4} m/s² rms, as its lineage ends"),
                format!("{found:.4} m/s² rms"),
                format!("the samples of {}", self.facts.target_file),
            )
        })
    }

    /// The drive does not state what it stated when it was measured.
    fn played(&self) -> Option<Difference> {
        let changed = self.facts.changed_since_measured.as_ref()?;
        Some((
            "what the drive stated when it was measured".to_owned(),
            changed.clone(),
            self.facts.file.clone(),
        ))
    }

    /// What was done to the spectrum.
    fn steps(&self) -> Option<Difference> {
        let steps = self.facts.lineage.iter().flat_map(|one| &one.steps);
        let found = steps.filter_map(|step| {
            Some(match &step.operation {
                Operation::Stroke { .. }
                | Operation::MeanTakenAway { .. }
                | Operation::Looped { .. }
                | Operation::Gain { .. }
                | Operation::RmsOf { .. }
                | Operation::Rendered { .. } => return None,
                Operation::SpectrumOf { of, .. } => {
                    let stated = self.made.spectrum_of.as_ref();
                    let is_stated = |sample: &&String| !self.is_of_another(of, sample);
                    let other = || named(of);
                    let sample = stated.filter(is_stated).cloned().unwrap_or_else(other);
                    format!("spectrum of {sample}")
                }
                Operation::Warped { ratio, .. } => format!("warp × {ratio}"),
                Operation::BandChanged {
                    band_hz,
                    change: BandChange::Gain { gain_db },
                    ..
                } => format!("{band_hz} {gain_db:+} dB"),
                other => other.brief_text(),
            })
        });
        let found: Vec<String> = found.collect();
        let stated = self.made.of_spectrum();
        let words = |steps: Vec<String>| match steps.is_empty() {
            true => "its own spectrum".to_owned(),
            false => steps.join(", "),
        };
        (found != stated).then(|| (words(stated), words(found), self.lineage_of_drive()))
    }

    /// The level that the lineage states, with that of the rendering: relative to the level at which most drives are rendered.
    fn level(&self) -> Option<Difference> {
        let (made, facts) = (self.made, self.facts);
        if let Some(rms_db) = made.rms_db {
            let found = Decibels::from_amplitude_ratio(facts.rms_m_s2());
            let found_db = found.0 + facts.level_db;
            return ((found_db - rms_db).abs() > SAME_LEVEL_DB).then(|| {
                (
                    rms_in_words(rms_db),
                    format!(
                        "{found_db:.3} dB re 1 m/s², rendered at {} dB",
                        facts.level_db
                    ),
                    format!("the samples of {}", facts.target_file),
                )
            });
        }
        let (sample, level_of, gain_db) = (made.of.as_str(), made.level_of(), made.gain_db());
        let nothing = Lineage::default();
        let lineage = facts.lineage.as_ref().unwrap_or(&nothing);
        let (of, by_db) = lineage.level();
        let without_stated = |other: &RenderingFacts| {
            let stated = self.protocol.stimulus(&other.stimulus)?;
            let stated = Some(stated).filter(|one| one.rms_db.is_none())?;
            let by_db = other.lineage.as_ref().map_or(0.0, |one| one.level().1);
            Some(other.level_db + by_db - stated.gain_db())
        };
        let is_one = |a: &f64, b: &f64| (a - b).abs() <= SAME_LEVEL_DB;
        let (usual_db, like) = self.commonest(without_stated, is_one)?;
        let rendered_db = facts.level_db - usual_db;
        let is_of_it = match of {
            None => level_of == sample,
            Some(of) => !self.is_of_another(of, level_of) && !of.is_manipulated(),
        };
        let is_its_own = of.is_none_or(|of| level_of != sample || of.source == lineage.source);
        if is_of_it && is_its_own && (by_db + rendered_db - gain_db).abs() <= SAME_LEVEL_DB {
            return None;
        }
        let mut found = match of {
            None => words("its own level", by_db),
            Some(of) => words(&format!("the level of {}", named(of)), by_db),
        };
        if rendered_db.abs() > SAME_LEVEL_DB {
            found += &format!(", rendered {rendered_db:+.3} dB re {}", like.file);
        }
        Some((self.stated_level(), found, self.lineage_of_drive()))
    }

    fn stated_level(&self) -> String {
        if let Some(rms_db) = self.made.rms_db {
            return rms_in_words(rms_db);
        }
        let (level_of, itself) = match self.made.level_of() {
            other if other == self.made.of => (other, " itself"),
            other => (other, ""),
        };
        words(
            &format!("the level of {level_of}{itself}"),
            self.made.gain_db(),
        )
    }

    /// Whether its texture has other samples than its stroke: it was joined with itself, or cut as a stroke once more.
    fn is_cut_again(&self) -> bool {
        let steps = self.facts.lineage.iter().flat_map(|one| &one.steps);
        let count = |of: fn(&Operation) -> bool| {
            let steps = steps.clone();
            steps.filter(|step| of(&step.operation)).count()
        };
        count(|one| matches!(one, Operation::Looped { .. })) > 0
            || count(|one| matches!(one, Operation::Stroke { .. })) > 1
    }

    /// The target is of another stroke than the plain stimulus of its sample: by its samples, or by its lineage where a change of the
    /// spectrum, or a second cut, leaves it others.
    fn stroke(&self) -> Option<Difference> {
        let plain = self.plain(&self.made.of)?;
        let by_samples = self.made.keeps_waveform() && !self.is_cut_again();
        let (is_another, seen_in) = match by_samples {
            true => (
                !is_scaled(&plain.texture, &self.facts.texture),
                format!("the samples of {}", self.facts.target_file),
            ),
            false => {
                let strokes = [self.facts, plain].map(|one| first_stroke(one.lineage.as_ref()));
                let [Some(own), Some(other)] = strokes else {
                    return None;
                };
                (own != other, self.lineage_of_drive())
            }
        };
        is_another.then(|| {
            (
                format!("the stroke in {}", plain.target_file),
                "another one".to_owned(),
                seen_in,
            )
        })
    }

    /// By how much the level of the samples of the target differs from the stated one, dB, in the band that is rendered; `None` where
    /// none is stated, or it is stated in m/s².
    fn level_off_db(&self, plain: &RenderingFacts) -> Option<f64> {
        let is_stated = self.made.rms_db.is_none() && self.made.states_level();
        let ratio = self.facts.rms_m_s2() / plain.rms_m_s2();
        is_stated.then(|| Decibels::from_amplitude_ratio(ratio).0 - self.made.gain_db())
    }

    /// The level of the samples of the target.
    fn level_of_samples(&self) -> Option<Difference> {
        let plain = self.plain(self.made.level_of())?;
        let off_db = self.level_off_db(plain)?;
        // What was cut once more, or joined with itself, has nearly the level that its lineage states, and what has the level of another
        // texture over all frequencies nearly that level in the band that is rendered.
        let steps = self.facts.lineage.iter().flat_map(|one| &one.steps);
        let elsewhere = |step: &Step| matches!(&step.operation, Operation::RmsOf { measured, .. } if self.facts.band().map(Level::Within) != Some(*measured));
        let is_nearly = self.is_cut_again() || steps.into_iter().any(elsewhere);
        let within_db = match is_nearly {
            true => MEASURED_LEVEL_DB,
            false => SAME_LEVEL_DB,
        };
        // Nothing is known of the level of a silent texture.
        (off_db.abs() > within_db).then(|| {
            (
                self.stated_level(),
                format!(
                    "{:+.3} dB re {}",
                    off_db + self.made.gain_db(),
                    plain.target_file
                ),
                format!("the samples of {}", self.facts.target_file),
            )
        })
    }

    /// All drives with the transfer function of one kind are rendered with one, so that nothing else differs between them.
    fn transfer_function(&self) -> Option<Difference> {
        let own = self.facts.made_with.first()?;
        let whose = self.protocol.transfer_function_of(self.made);
        let of_alike = |other: &RenderingFacts| {
            let made = self.protocol.stimulus(&other.stimulus)?;
            let is_alike = self.protocol.transfer_function_of(&made) == whose;
            other.made_with.first().filter(|_| is_alike).copied()
        };
        let (usual, like) = self.commonest(of_alike, PartialEq::eq)?;
        (usual != *own).then(|| {
            (
                format!("the transfer function that {} was rendered with", like.file),
                "another one".to_owned(),
                format!("the checksum in {}", self.facts.file),
            )
        })
    }

    /// All drives are rendered in one band.
    fn band(&self) -> Option<Difference> {
        let common = self.commonest(RenderingFacts::band, PartialEq::eq);
        let (own, (usual, like)) = self.facts.band().zip(common)?;
        (usual != own).then(|| {
            (
                format!("a drive over {usual} as {}", like.file),
                format!("one over {own}"),
                self.lineage_of_drive(),
            )
        })
    }

    /// What most drives have in common by `of`, and the first that has it.
    fn commonest<T>(
        &self,
        of: impl Fn(&RenderingFacts) -> Option<T>,
        is_one: impl Fn(&T, &T) -> bool,
    ) -> Option<(T, &RenderingFacts)> {
        let of_each = self.drives.iter().filter_map(|one| Some((of(one)?, *one)));
        let mut of_each: Vec<_> = of_each.collect();
        let alike = |value: &T| {
            of_each
                .iter()
                .filter(|(other, _)| is_one(value, other))
                .count()
        };
        let most = of_each.iter().map(|(value, _)| alike(value)).max()?;
        let first = of_each.iter().position(|(value, _)| alike(value) == most)?;
        Some(of_each.swap_remove(first))
    }

    /// The level that was to be reached, as it was measured on the bench.
    fn measured_level(&self) -> Option<Difference> {
        let (of_plain_db, off_db) = match self.made.rms_db {
            Some(_) => (0.0, None),
            None => {
                let plain = self.plain(self.made.level_of())?;
                (plain.level_error_db?, self.level_off_db(plain))
            }
        };
        let found_db = self.facts.level_error_db? - of_plain_db + off_db.unwrap_or(0.0);
        (found_db.abs() > MEASURED_LEVEL_DB).then(|| {
            (
                match self.made.states_level() {
                    true => format!("{} within ±{MEASURED_LEVEL_DB} dB", self.stated_level()),
                    false => format!("the level of its target within ±{MEASURED_LEVEL_DB} dB"),
                },
                format!("{found_db:+.2} dB from it"),
                "its measurement on the bench".to_owned(),
            )
        })
    }

    /// Whether the texture of the lineage `of` is known to be one of another sample than `sample`: as it states, or by the drives of plain
    /// samples.
    fn is_of_another(&self, of: &Lineage, sample: &str) -> bool {
        if let Some(stated) = &of.sample {
            return stated != sample;
        }
        let of_source = |one: &&&RenderingFacts| {
            let lineage = one.lineage.as_ref();
            lineage.is_some_and(|lineage| lineage.source == of.source && !lineage.is_manipulated())
        };
        let mut known = self.drives.iter().filter(of_source).peekable();
        known.peek().is_some() && known.all(|one| one.stimulus != sample)
    }
}

/// The stroke that a texture began with: its number in its recording, and its ends to 1 ms.
fn first_stroke(lineage: Option<&Lineage>) -> Option<(usize, i64, i64)> {
    lineage?.steps.iter().find_map(|step| match step.operation {
        Operation::Stroke {
            number,
            from_s,
            to_s,
            ..
        } => Some((
            number,
            (from_s * 1e3).round() as i64,
            (to_s * 1e3).round() as i64,
        )),
        _ => None,
    })
}

/// A texture by its source, with its sample where that is stated.
fn named(of: &Lineage) -> String {
    match &of.sample {
        Some(sample) => format!("{} ({sample})", of.source),
        None => of.source.clone(),
    }
}

/// A lineage in words, without its rendering: two that were read from different files are compared so.
///
/// Source: docs/decisions/campaigns.md.
#[must_use]
pub fn before_rendering(lineage: &Lineage) -> String {
    let mut before = lineage.clone();
    before
        .steps
        .retain(|step| !matches!(step.operation, Operation::Rendered { .. }));
    before.to_string()
}

/// Whether `scaled` has the samples of `x`, all multiplied by one factor above 0.
fn is_scaled(x: &Series<Acceleration>, scaled: &Series<Acceleration>) -> bool {
    let (x, y) = (x.samples(), scaled.samples());
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (xx, xy, yy) = (dot(x, x), dot(x, y), dot(y, y));
    let residual = yy - xy * xy / xx.max(f64::MIN_POSITIVE);
    x.len() == y.len() && xy > 0.0 && residual <= SAME_WAVEFORM_SHARE.powi(2) * yy
}

fn words(level: &str, by_db: f64) -> String {
    match by_db == 0.0 {
        true => level.to_owned(),
        false => format!("{level} {by_db:+.3} dB"),
    }
}
