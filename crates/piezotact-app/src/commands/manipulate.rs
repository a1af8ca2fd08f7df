//! `piezotact manipulate`: a manipulated texture, with the operations that were applied.

use piezotact::warning::Warnings;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use piezotact::Warning;
use piezotact::lineage::{Level, Lineage, Step};
use piezotact::manipulate::{
    BeforeAndAfter, ManipulateDocument, ManipulateError, Manipulated, Texture, spectra_of,
    texture_of_stroke,
};
use piezotact::quantity::{Acceleration, Quantity, Seconds};
use piezotact::recording::{
    About, Annotations, Condition, Losses, Provenance, Recording, RecordingWarning,
};
use piezotact::roles::Roles;
use piezotact::series::Series;
use piezotact::study::AnalysedRecording;
use piezotact_dataset::sidecar::{Sidecar, read_sidecar, sidecar_path};
use piezotact_dataset::wav::{SampleFormat, write_wav_with_sidecar};

use super::touch::take_all;
use crate::cli::manipulate::Manipulate;
use crate::cli::{Reading, Takes};
use crate::deliver::deliver_and;
use crate::failure::{Failure, Outcome, usage};
use crate::manipulations::{Other, OtherRate, Requested, Settings, Speed};
use crate::places::outputs;
use crate::reading::{read, texture};
use crate::report::name;

/// Shorter than a period of 100 Hz nothing is a texture.
const SHORTEST: Seconds = Seconds(0.01);
/// The suffix of the name of a manipulated sample: it is no longer that sample.
const MANIPULATED: &str = " (manipulated)";

/// A texture with what its file says of it.
pub(super) struct Opened {
    pub(super) texture: Texture<Acceleration>,
    condition: Condition,
    provenance: Provenance,
    /// Those of the recording, and the number of steps of the lineage before it.
    annotations: (Annotations, usize),
}

/// A stroke by its number from 1, and the option that asked for it.
#[derive(Clone, Copy)]
pub(super) struct Chosen {
    pub(super) number: u32,
    pub(super) option: &'static str,
}

fn chosen(number: Option<u32>, option: &'static str) -> Option<Chosen> {
    number.map(|number| Chosen { number, option })
}

pub(crate) fn run(args: &Manipulate) -> Outcome {
    checked(args)?;
    let opened = open(
        &args.input,
        chosen(args.stroke, "--stroke"),
        args.channel.as_deref(),
        &args.reading,
    )?;
    let before = opened.texture.clone();
    let (after, others) = all_done(args, opened.texture)?;
    // As a WAV file states it.
    let after = after.at_whole_rate("the texture")?;
    let condition = condition_of(opened.condition, &args.operations.0);
    let (annotations, left_out) = annotations_after(opened.annotations, &after.lineage);
    let mut about = About::new(condition, opened.provenance);
    about.provenance.steps.extend(left_out);
    write(&args.out, &after, &about, annotations)?;
    let textures = std::iter::once(&before).chain(&others).chain([&after]);
    let shown = BeforeAndAfter {
        title: format!("{}, manipulated", name(&args.input)),
        bench: about.provenance.bench,
        before: &before,
        after: &after,
        others: &others,
        spectra: &spectra_of(textures)?,
    };
    let document = ManipulateDocument::of(shown, &about.condition, &args.out);
    deliver_and(&args.outputs, &document, &[&args.out])
}

/// Refuses what cannot be asked for: nothing to do, options without a use, outputs that would replace an input.
fn checked(args: &Manipulate) -> Outcome {
    let operations = &args.operations.0;
    if operations.is_empty() {
        return Err(usage(anyhow!(
            "expected an operation, found none; write for example --gain -3dB (see --help)"
        )));
    }
    require_wav(&args.out)?;
    let others = operations.iter().filter_map(|one| one.other.as_ref());
    let others: Vec<&Path> = others.map(|other| other.path.as_path()).collect();
    if others.is_empty() {
        for (option, given) in [
            ("--of-stroke", args.of_stroke.is_some()),
            ("--of-channel", args.of_channel.is_some()),
            ("--of-scale", args.of_scale.is_some()),
        ] {
            if given {
                return Err(usage(anyhow!(
                    "expected --rms-of or --spectrum-of with {option}, found neither; state one of them, or leave {option} out"
                )));
            }
        }
    }
    let read: Vec<&Path> = others.into_iter().chain([args.input.as_path()]).collect();
    let sidecar = sidecar_path(&args.out);
    let mut written = vec![args.out.as_path(), &sidecar];
    written.extend(args.outputs.files());
    outputs(&read, &written)
}

/// The texture in a file, or one stroke of it, with the lineage that it has so far and without its mean.
pub(super) fn open(
    path: &Path,
    stroke: Option<Chosen>,
    channel: Option<&str>,
    reading: &Reading,
) -> Outcome<Opened> {
    let source = match stroke {
        None => whole(path, channel, reading)?,
        Some(stroke) => one_stroke(path, stroke, channel, reading)?,
    };
    opened(path, source)
}

/// `source`, of the file at `path`, with its lineage and without its mean.
fn opened(path: &Path, source: Source) -> Outcome<Opened> {
    let Source {
        series,
        recording,
        step,
        mut warnings,
    } = source;
    warnings.splice(0..0, recording.about.warnings.iter().cloned());
    let so_far = recording.about.provenance.lineage.clone();
    let steps_before = so_far.as_ref().map_or(0, |lineage| lineage.steps.len());
    let mut lineage = so_far.unwrap_or_else(|| {
        Lineage::of_sample(name(path), recording.about.condition.sample.clone())
    });
    lineage.steps.extend(step);
    let found = Texture {
        series,
        lineage,
        warnings,
    };
    long_enough(path, &found.series)?;
    let texture = found
        .with_mean_removed()
        .map_err(|error| refused(path, error))?;
    Ok(Opened {
        texture,
        condition: recording.about.condition,
        provenance: recording.about.provenance,
        annotations: (recording.annotations, steps_before),
    })
}

/// A texture with everything that its file states.
pub(super) struct Written {
    pub(super) texture: Texture<Acceleration>,
    about: About,
    annotations: Annotations,
}

impl Written {
    /// A stroke of `take`.
    pub(super) fn stroke(
        take: &AnalysedRecording,
        cut: Manipulated<Acceleration>,
    ) -> Outcome<Self> {
        let source = Source {
            series: cut.series,
            recording: take.recording.clone(),
            step: Some(cut.step),
            warnings: cut.warnings,
        };
        let opened = opened(Path::new(&take.file), source)?;
        let texture = opened.texture.at_whole_rate("the texture")?;
        let (annotations, left_out) = annotations_after(opened.annotations, &texture.lineage);
        let mut about = About::new(opened.condition, opened.provenance);
        about.provenance.steps.extend(left_out);
        Ok(Self {
            texture,
            about,
            annotations,
        })
    }

    /// What was made of it: `texture`, at a sliding speed that is the same or another.
    #[cfg(feature = "study")]
    pub(super) fn made_into(&self, texture: Texture<Acceleration>, speed: Speed) -> Self {
        let mut about = self.about.clone();
        about.condition = manipulated(about.condition, speed);
        let before = (self.annotations.clone(), self.texture.lineage.steps.len());
        let (annotations, left_out) = annotations_after(before, &texture.lineage);
        about.provenance.steps.extend(left_out);
        Self {
            texture,
            about,
            annotations,
        }
    }

    pub(super) fn write(&self, out: &Path) -> Outcome {
        write(out, &self.texture, &self.about, self.annotations.clone())
    }
}

fn long_enough(path: &Path, series: &Series<Acceleration>) -> Outcome {
    if series.duration().0 >= SHORTEST.0 {
        return Ok(());
    }
    Err(Failure::Data(anyhow!(
        "{}: expected a texture of {SHORTEST} or longer, found {} ({} samples at {}); take a longer stroke, or check the file",
        path.display(),
        series.duration(),
        series.samples().len(),
        series.rate()
    )))
}

/// A recording of touch holds landings, pauses and the gesture beside what is felt of the surface.
fn taken_whole(path: &Path, recording: &Recording) -> Option<Warning> {
    let (roles, _) = Roles::guess(recording);
    let of_touch = roles.normal_force.is_some() || roles.motion.is_some();
    of_touch.then(|| Warning::from(RecordingWarning::TakenWhole { file: name(path) }))
}

/// A texture as it is in its file, with the recording that holds it and the step that cut it.
struct Source {
    series: Series<Acceleration>,
    recording: Recording,
    step: Option<Step>,
    warnings: Vec<Warning>,
}

/// A whole recording as a texture.
fn whole(path: &Path, channel: Option<&str>, reading: &Reading) -> Outcome<Source> {
    let recording = read(path, reading)?.recording;
    let series = texture(path, &recording, channel)?;
    let name = recording.pick(channel, &Acceleration::UNIT)?.name.clone();
    let recording = recording.on_the_clock_of([name.as_str()])?;
    Ok(Source {
        warnings: taken_whole(path, &recording).into_iter().collect(),
        series,
        recording,
        step: None,
    })
}

/// One stroke of a recording, as `strokes` sees it: cut by the rule or by a person, freed of the gesture.
fn one_stroke(
    path: &Path,
    asked: Chosen,
    channel: Option<&str>,
    reading: &Reading,
) -> Outcome<Source> {
    let at = |error: anyhow::Error| Failure::Data(error.context(path.display().to_string()));
    let (takes, _one_file) = take_all(&takes_of(path, channel, reading))?;
    let Some(AnalysedRecording {
        recording,
        segmentation,
        ..
    }) = takes.into_iter().next()
    else {
        return Err(at(anyhow!("expected a recording, found none; check it")));
    };
    let vibration = segmentation.roles.vibration.first();
    let whole = texture(path, &recording, vibration.map(String::as_str))?;
    let number = asked.number as usize;
    let cut = texture_of_stroke(&whole, (&recording, &segmentation), number);
    let Some(cut) = cut.map_err(|error| at(error.into()))? else {
        return Err(at(anyhow!(
            "expected a stroke from 1 to {}, found {} {number}; `piezotact strokes --cuts-only` lists them",
            segmentation.strokes.len(),
            asked.option
        )));
    };
    Ok(Source {
        series: cut.series,
        recording,
        step: Some(cut.step),
        warnings: cut.warnings,
    })
}

/// One recording, cut by its own roles.
fn takes_of(path: &Path, channel: Option<&str>, reading: &Reading) -> Takes {
    Takes {
        recordings: vec![path.to_owned()],
        meta: None,
        touch: None,
        direction: None,
        load: None,
        speed: None,
        vibration: channel.map(str::to_owned).into_iter().collect(),
        normal_force: None,
        tangential_force: Vec::new(),
        motion: None,
        every_contact: false,
        cuts: None,
        reading: reading.with_scale(reading.scale().cloned()),
    }
}

/// The texture after every operation, and the others that it took something of.
fn all_done(
    args: &Manipulate,
    mut texture: Texture<Acceleration>,
) -> Outcome<(Texture<Acceleration>, Vec<Texture<Acceleration>>)> {
    let mut others: Vec<(&PathBuf, Texture<Acceleration>)> = Vec::new();
    let settings = Settings {
        measured: args.rms_band.map_or(Level::Whole, Level::Within),
        seed: args.seed,
    };
    for requested in &args.operations.0 {
        let other = match &requested.other {
            Some(Other { path, rate }) => {
                let at = match others.iter().position(|(known, _)| *known == path) {
                    Some(at) => at,
                    None => {
                        others.push((path, open_other(args, path)?));
                        others.len() - 1
                    }
                };
                let other = others[at].1.clone();
                Some(match rate {
                    OtherRate::Own => other,
                    OtherRate::OfTexture => at_the_rate_of(&texture.series, path, other)?,
                })
            }
            None => None,
        };
        let done = requested.apply(&texture.series, settings, other.as_ref());
        texture = texture.then(done.map_err(|error| refused(&args.input, error))?);
    }
    let others: Vec<_> = others.into_iter().map(|(_, other)| other).collect();
    let all = others
        .iter()
        .flat_map(|other| other.warnings.iter().cloned());
    let once: Warnings = texture.warnings.into_iter().chain(all).collect();
    texture.warnings = once.into();
    Ok((texture, others))
}

/// The other texture at the rate of `x`, with the warning that it was converted.
fn at_the_rate_of(
    x: &Series<Acceleration>,
    path: &Path,
    other: Texture<Acceleration>,
) -> Outcome<Texture<Acceleration>> {
    other.at_rate(&name(path), x.rate()).map_err(|error| {
        Failure::Data(anyhow::Error::new(error).context(path.display().to_string()))
    })
}

/// Another texture, at `--of-scale`; `--scale` counts for it where it does not say its own.
fn open_other(args: &Manipulate, path: &Path) -> Outcome<Texture<Acceleration>> {
    let says_its_own = read_sidecar(path)?.is_some_and(|sidecar| sidecar.full_scale.is_some());
    let of_both = args.reading.scale().filter(|_| !says_its_own);
    let scale = args.of_scale.as_ref().or(of_both).cloned();
    let reading = args.reading.with_scale(scale);
    let stroke = chosen(args.of_stroke, "--of-stroke").or(chosen(args.stroke, "--stroke"));
    Ok(open(path, stroke, args.of_channel.as_deref(), &reading)?.texture)
}

fn refused(path: &Path, error: ManipulateError) -> Failure {
    match error {
        ManipulateError::Range { .. }
        | ManipulateError::BandAboveNyquist { .. }
        | ManipulateError::Ratio { .. } => usage(error),
        _ => Failure::Data(anyhow::Error::new(error).context(path.display().to_string())),
    }
}

/// What still holds of the condition: another texture is another sample, and after a warp the speed is another.
fn condition_of(condition: Condition, operations: &[Requested]) -> Condition {
    let changed = operations.iter().any(|one| one.speed == Speed::Changed);
    let speed = if changed { Speed::Changed } else { Speed::Kept };
    manipulated(condition, speed)
}

fn manipulated(mut condition: Condition, speed: Speed) -> Condition {
    if let Some(sample) = &mut condition.sample
        && !sample.ends_with(MANIPULATED)
    {
        sample.push_str(MANIPULATED);
    }
    if speed == Speed::Changed {
        condition.speed_m_s = None;
    }
    condition
}

/// The sample that was touched, by the name of its texture, manipulated or not.
#[cfg(feature = "study")]
pub(super) fn before_manipulation(sample: &str) -> &str {
    sample.strip_suffix(MANIPULATED).unwrap_or(sample)
}

/// What still holds of the annotations after the steps of `lineage` beyond the first so many, and what was left out.
fn annotations_after(
    (mut annotations, steps_before): (Annotations, usize),
    lineage: &Lineage,
) -> (Annotations, Vec<String>) {
    let mut left_out = Vec::new();
    for step in lineage.steps.iter().skip(steps_before) {
        let (kept, left) = annotations.after(&step.operation);
        annotations = kept;
        left_out.extend(left);
    }
    (annotations, left_out)
}

fn write(
    path: &Path,
    texture: &Texture<Acceleration>,
    about: &About,
    annotations: Annotations,
) -> Outcome {
    let (samples, full_scale) = texture.series.in_shares_of_peak();
    let sidecar = Sidecar {
        full_scale: Some(full_scale),
        channels: vec!["acceleration".into()],
        about: About {
            condition: about.condition.clone(),
            provenance: Provenance {
                lineage: Some(texture.lineage.clone()),
                losses: Losses::default(),
                ..about.provenance.clone()
            },
            warnings: texture.warnings.clone(),
        },
        annotations,
        rendering: None,
    };
    let rate_hz = texture.series.rate().hz().round() as u32;
    let format = SampleFormat::Float32;
    write_wav_with_sidecar(path, &[&samples], rate_hz, format, &sidecar)?;
    Ok(())
}

/// Nothing else is written, whatever the name.
fn require_wav(path: &Path) -> Outcome {
    let ending = path.extension().and_then(|ending| ending.to_str());
    if ending.is_some_and(|ending| ending.eq_ignore_ascii_case("wav")) {
        return Ok(());
    }
    Err(usage(anyhow!(
        "expected --out to end in .wav, found {}; use `piezotact export` for other formats",
        ending.map_or("no ending".into(), |ending| format!(".{ending}"))
    )))
}
