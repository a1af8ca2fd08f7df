//! Sidecars: metadata files that complete the samples of the file beside them.

use std::path::{Path, PathBuf};

use piezotact::Warning;
use piezotact::recording::{NotUsed, Provenance, Recording, RecordingWarning, Stated};

use super::{FileKind, ReadOptions};
use crate::columns::Column;
use crate::error::ReadError;
use crate::recording_file::Stored;
use crate::sidecar::{
    OfSamples, Sidecar, measure_or_unit, read_with_samples, require_unit, sidecar_path,
};

/// A sidecar and where it stands.
pub(super) struct Beside {
    place: PathBuf,
    pub(super) sidecar: Sidecar,
    pub(super) of_samples: OfSamples,
    warnings: Vec<Warning>,
}

/// The warning that a sidecar lies beside the file at `path`, whose `kind` takes none.
pub(super) fn not_read(path: &Path, kind: FileKind) -> Option<Warning> {
    let takes_one = [
        FileKind::WAV,
        FileKind::FLAC,
        super::npy::NPY.kind,
        FileKind::TABLE,
        FileKind::LVM,
        FileKind::UFF,
        FileKind::MATLAB,
        FileKind::PARQUET,
    ];
    unread(path, kind).filter(|_| !takes_one.contains(&kind))
}

/// The same of a file that takes none although its kind does.
pub(super) fn unread(path: &Path, kind: FileKind) -> Option<Warning> {
    let place = sidecar_path(path);
    place.is_file().then(|| {
        Warning::from(RecordingWarning::NotUsed {
            what: NotUsed::Sidecar {
                file: place.display().to_string(),
                format: kind.to_string(),
            },
        })
    })
}

/// What `read` makes of the file at `path`, with the names, units, condition and events of a sidecar beside it.
pub(super) fn completed(
    path: &Path,
    options: &ReadOptions,
    read: impl Fn(&ReadOptions) -> Result<Recording, ReadError>,
) -> Result<Stored, ReadError> {
    let Some(mut beside) = Beside::read(path)? else {
        return Ok(read(options)?.into());
    };
    beside.of_part(options.part);
    let (mut options, mut warnings) = (options.clone(), Vec::new());
    beside.scale(&mut options, &mut warnings);
    let mut recording = read(&options)?;
    let own: Vec<String> = (recording.channels().iter())
        .map(|channel| channel.name.clone())
        .collect();
    let names = beside.of_samples.channels.as_ref().unwrap_or(&own).clone();
    if names.len() != own.len() {
        return Err(beside.other_count(own.len(), names.len()));
    }
    beside.names_fit(names.iter().map(String::as_str))?;
    let mut has_units = false;
    for (name, own) in names.iter().zip(&own) {
        let stated = options.units.remove(name);
        if let Some(unit) = stated.or_else(|| beside.of_samples.units.get(name).cloned()) {
            options.units.insert(own.clone(), unit);
            has_units = true;
        }
    }
    if has_units {
        recording = read(&options)?;
    }
    let renamed = |name: &str| {
        let place = own.iter().position(|own| own == name);
        place.map_or(name.to_owned(), |place| names[place].clone())
    };
    recording.rename(renamed).map_err(ReadError::of(path))?;
    recording.about.warnings.append(&mut warnings);
    let started_at = recording.annotations.started_at.take();
    let losses = std::mem::take(&mut recording.about.provenance.losses);
    let mut stored = Stored::from(recording);
    beside.describe(&mut stored);
    let recording = &mut stored.recording;
    recording.about.provenance.losses = losses;
    let started = &mut recording.annotations.started_at;
    *started = started.take().or(started_at);
    Ok(stored)
}

impl Beside {
    /// The sidecar of the file at `path`, if there is one.
    pub(super) fn read(path: &Path) -> Result<Option<Self>, ReadError> {
        Ok(read_with_samples(path)?.map(|read| Self {
            place: sidecar_path(path),
            sidecar: read.sidecar,
            of_samples: read.of_samples,
            warnings: read.warnings,
        }))
    }

    /// An empty one.
    pub(super) fn none(path: &Path) -> Self {
        Self {
            place: sidecar_path(path),
            sidecar: Sidecar::default(),
            of_samples: OfSamples::default(),
            warnings: Vec::new(),
        }
    }

    /// Takes the sidecar's scale where none is stated; a warning where both are and differ.
    pub(super) fn scale(&self, options: &mut ReadOptions, warnings: &mut Vec<Warning>) {
        match (&options.scale, &self.sidecar.full_scale) {
            (Some(used), Some(ignored)) if used != ignored => {
                warnings.push(Warning::from(RecordingWarning::StatedDiffers {
                    what: Stated::Scale {
                        used: used.to_string(),
                        ignored: ignored.to_string(),
                    },
                }));
            }
            (None, Some(own)) => options.scale = Some(own.clone()),
            _ => {}
        }
    }

    /// Leaves out the start and the events, which are those of the whole file, where another part than the first is read.
    pub(super) fn of_part(&mut self, part: Option<usize>) {
        let whole = &mut self.sidecar.annotations;
        if part.is_some_and(|part| part > 1)
            && (whole.started_at.is_some() || !whole.events.is_empty())
        {
            whole.started_at = None;
            whole.events.clear();
            let what = format!(
                "start and events in {} are those of the whole file, and were left out of a later part",
                self.place.display()
            );
            self.warnings
                .push(Warning::from(RecordingWarning::Guessed { what }));
        }
    }

    /// Gives the columns of a table the sidecar's names and units.
    pub(super) fn name_columns(&self, columns: &mut [Column]) -> Result<(), ReadError> {
        if let Some(names) = &self.of_samples.channels {
            if names.len() != columns.len() {
                return Err(self.other_count(columns.len(), names.len()));
            }
            for (column, name) in columns.iter_mut().zip(names) {
                column.name.clone_from(name);
            }
        }
        self.names_fit(columns.iter().map(|column| column.name.as_str()))?;
        for column in columns {
            let Some(text) = self.of_samples.units.get(&column.name) else {
                continue;
            };
            let (unit, factor) = measure_or_unit(text);
            if let Some(own) = &column.unit
                && measure_or_unit(own) != (unit.clone(), factor)
            {
                return Err(ReadError::content(
                    &self.place,
                    format!("the unit of `{}` as the file states it, {own}", column.name),
                    text,
                    "correct the one that is wrong",
                ));
            }
            if column.unit.is_none() {
                for value in &mut column.values {
                    *value *= factor;
                }
                column.unit = Some(unit.symbol().to_owned());
            }
        }
        Ok(())
    }

    /// That `units` names channels of the file alone.
    pub(super) fn names_fit<'a>(
        &self,
        names: impl Iterator<Item = &'a str>,
    ) -> Result<(), ReadError> {
        let names: Vec<&str> = names.collect();
        for (name, text) in &self.of_samples.units {
            require_unit(&self.place, name, text)?;
        }
        let mut others = self.of_samples.units.keys();
        match others.find(|name| !names.contains(&name.as_str())) {
            None => Ok(()),
            Some(other) => Err(ReadError::content(
                &self.place,
                format!(
                    "`units` of channels that the file has ({})",
                    names.join(", ")
                ),
                format!("`{other}`"),
                "correct the name, or remove it",
            )),
        }
    }

    /// That there are as many names as channels is refused where it does not hold.
    pub(super) fn other_count(&self, expected: usize, found: usize) -> ReadError {
        ReadError::content(
            &self.place,
            format!("{expected} name(s) in `channels`, as many as the file has channels"),
            format!("{found}"),
            "correct `channels`, or remove it",
        )
    }

    /// Adds condition, labels, events, how a drive was made, and warnings to what was read of the file.
    pub(super) fn describe(self, stored: &mut Stored) {
        let recording = &mut stored.recording;
        let length_s = recording.duration().0;
        let about = self.sidecar.about;
        recording.about.condition = about.condition;
        if about.provenance != Provenance::default() {
            recording.about.provenance = about.provenance;
        }
        recording.annotations = self.sidecar.annotations;
        let own = std::mem::take(&mut recording.about.warnings);
        let outside = recording
            .annotations
            .outside(piezotact::quantity::Seconds(length_s));
        let outside = outside.first().map(|first| {
            Warning::from(RecordingWarning::NotUsed {
                what: NotUsed::Events {
                    count: outside.len(),
                    onset_s: first.onset_s.0,
                    lasts_s: first.duration_s.0,
                    length_s,
                },
            })
        });
        recording.about.warnings = about.warnings;
        // Warnings already stated in the sidecar are not added again.
        let more = own.into_iter().chain(self.warnings).chain(outside);
        recording.about.add_warnings(more);
        stored.rendering = self.sidecar.rendering;
    }
}
