//! `piezotact roughness`: the roughness of a profile or a height map.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::Args;
use piezotact::quantity::{Measure, Unit};
use piezotact::surface::HeightMap;
use piezotact_surface::{
    ArealConfig, ArealRoughness, Cutoff, EvaluatedSurface, Form, LineDirection, MeasuredProfile,
    ProfileFilter, ProfileRoughness, ProfileStandard, Roughness as Evaluated, RoughnessError,
    RoughnessOptions, RoughnessSet, ShortWaves, Topography, TopographyKind, TopographyOptions,
    areal_roughness, evaluated_profile, line_roughness, read_topography, topography_formats,
};

use crate::deliver::{Outputs, deliver};
use crate::failure::{Failure, Failures, Outcome, usage};
use crate::places::outputs;
use crate::progress::{Words, Work};

const EVALUATING: Words = Words {
    doing: "evaluating",
    done: "evaluated",
    item: "surface",
    then: "ordering",
};

/// Which standard says what is averaged along a profile.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum StandardName {
    /// ISO 4287:1997: the mean over the sampling lengths.
    Iso4287,
    /// ISO 21920-2:2021: most parameters over the evaluation length.
    Iso21920,
}

/// What separates roughness from waviness.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum FilterName {
    /// The Gaussian filter of ISO 16610.
    Gauss,
    /// No filter.
    None,
}

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    #[arg(
        required = true,
        value_name = "FILE",
        help = format!("Profiles or height maps ({}); several are ordered by Ra", topography_formats())
    )]
    files: Vec<PathBuf>,
    /// The standard that defines the averages along a profile; default iso4287.
    #[arg(long, value_enum)]
    standard: Option<StandardName>,
    /// The cut-off λc of a profile, such as 2.5mm; by default chosen by the rule of ISO 4288. On a height map, the
    /// nesting index of the L-filter; by default there is no L-filter.
    #[arg(long, value_name = "LENGTH", value_parser = length, allow_hyphen_values = true)]
    cutoff: Option<f64>,
    /// Chooses the cut-off by the mean width of the profile elements (RSm), as ISO 4288 requires for turned,
    /// planed and other periodic profiles.
    #[arg(long, conflicts_with = "cutoff")]
    periodic: bool,
    /// The filter that separates roughness from waviness. Default: gauss, and none for a roughness profile that the
    /// instrument has filtered (.tx2 with its .tx3).
    #[arg(long, value_enum)]
    filter: Option<FilterName>,
    /// The form that is removed first: mean, level (least-squares line or plane) or poly2 … poly10. Default: level,
    /// or mean with --filter none.
    #[arg(long, value_parser = form_name)]
    form: Option<Form>,
    /// The S-filter, which removes short wavelengths: iso (λs of ISO 3274), none, or a length such as 8um. Default:
    /// iso for a profile and none for a height map.
    #[arg(long, value_name = "iso|none|LENGTH", value_parser = short_waves, allow_hyphen_values = true)]
    s_filter: Option<ShortWaves>,
    /// The unit of the coordinates in a text file without units, such as mm.
    #[arg(long, value_name = "UNIT", value_parser = length_unit, allow_hyphen_values = true)]
    x_unit: Option<f64>,
    /// The unit of the heights in a text file without units, or in an array (NPY, MAT), such as um.
    #[arg(long, value_name = "UNIT", value_parser = length_unit, allow_hyphen_values = true)]
    z_unit: Option<f64>,
    /// The spacing of the points in a text file without coordinates, or in an array (NPY, MAT), such as 0.5um.
    #[arg(long, value_name = "LENGTH", value_parser = length, allow_hyphen_values = true)]
    step: Option<f64>,
    /// Also evaluates the lines of a height map along its rows (x) or columns (y) as profiles: Ra, Rz and Rq beside Sa, and the
    /// slope of their spectrum.
    #[arg(long, value_name = "x|y", value_parser = direction)]
    along: Option<LineDirection>,
    #[command(flatten)]
    outputs: Outputs,
}

fn direction(text: &str) -> Result<LineDirection, String> {
    match text {
        "x" => Ok(LineDirection::X),
        "y" => Ok(LineDirection::Y),
        _ => Err("expected x (along the rows) or y (along the columns)".into()),
    }
}

/// A length with its unit, in m.
pub(super) fn length(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(Measure {
            value,
            unit: Unit::Metre,
        }) => Ok(value),
        _ => Err(format!(
            "expected a length above zero with a unit (m, mm, um, nm), found `{text}`; write for example 2.5mm"
        )),
    }
}

/// A unit of length, in m.
fn length_unit(text: &str) -> Result<f64, String> {
    match Unit::parse(text) {
        (Unit::Metre, factor) => Ok(factor),
        _ => length(text).map_err(|_says_less| {
            format!(
                "expected a unit of length (m, mm, um, nm), found `{text}`; write for example um"
            )
        }),
    }
}

fn form_name(text: &str) -> Result<Form, String> {
    let degree = |text: &str| text.strip_prefix("poly")?.parse().ok();
    match (text, degree(text)) {
        ("mean", _) => Ok(Form::Mean),
        ("level", _) => Ok(Form::Level),
        (_, Some(degree @ 2..=10)) => Ok(Form::Polynomial(degree)),
        _ => Err("expected mean, level or poly2 to poly10".into()),
    }
}

fn short_waves(text: &str) -> Result<ShortWaves, String> {
    match text {
        "iso" => Ok(ShortWaves::Iso3274),
        "none" => Ok(ShortWaves::Kept),
        text => length(text).map(ShortWaves::Stated),
    }
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let read: Vec<&Path> = args.files.iter().map(PathBuf::as_path).collect();
    outputs(&read, &args.outputs.files())?;
    match args.files.as_slice() {
        [file] => deliver(&args.outputs, &evaluated(args, file)?),
        _ => several(args),
    }
}

/// Evaluates every file; one that fails does not stop the others.
fn several(args: &Arguments) -> Outcome {
    let (mut surfaces, mut failed) = (Vec::new(), Failures::of(args.files.len()));
    let evaluating = Work::of_files(EVALUATING, &args.files);
    for file in &args.files {
        if let Some(surface) = failed.unless_failed(file, evaluated(args, file))? {
            surfaces.push(surface);
        }
        evaluating.one_more();
    }
    drop(evaluating);
    let set = RoughnessSet::of(surfaces, failed.files().to_vec());
    if set.surfaces().is_empty() {
        return failed.outcome();
    }
    deliver(&args.outputs, &set)?;
    failed.outcome()
}

fn evaluated(args: &Arguments, file: &Path) -> Outcome<EvaluatedSurface> {
    let options = TopographyOptions {
        step_m: args.step,
        coordinate_unit_m: args.x_unit,
        height_unit_m: args.z_unit,
    };
    let read = read_topography(file, &options)?;
    nothing_stated_in_vain(args, file, read.kind)?;
    let mut lines = None;
    let roughness = match &read.topography {
        Topography::Profile(profile) => {
            if args.along.is_some() {
                return Err(usage(anyhow!(
                    "{}: expected a height map for --along, found a profile; leave the option out",
                    file.display()
                )));
            }
            let measured = MeasuredProfile {
                profile,
                kind: read.profile_kind,
                instrument: read.instrument.as_ref(),
            };
            Evaluated::Profile(Box::new(of_line(args, file, measured)?))
        }
        Topography::Map(map) => {
            let of_lines = |along| {
                line_roughness(map, along, &wish(args, file)?)
                    .map_err(|error| refused(file, &error))
            };
            let of_map = of_map(args, file, map)?;
            lines = args.along.map(of_lines).transpose()?;
            Evaluated::Map(Box::new(of_map))
        }
    };
    let of_lines = lines.iter().flat_map(|lines| &lines.warnings);
    let more = roughness.warnings().iter().chain(of_lines).cloned();
    Ok(EvaluatedSurface {
        file: file.to_owned(),
        format: read.kind.to_string(),
        warnings: read.warnings.into_iter().chain(more).collect(),
        lines,
        instrument: read.instrument,
        roughness,
    })
}

/// Refuses a scale for a file that has no use for it: it would change nothing, and look as if it did.
fn nothing_stated_in_vain(args: &Arguments, file: &Path, kind: TopographyKind) -> Outcome {
    use TopographyKind as Kind;
    let (step, x_unit, z_unit) = match kind {
        Kind::PointText | Kind::ProfileText => (false, true, true),
        Kind::MatrixText | Kind::HeightText | Kind::Surfcom | Kind::Npy | Kind::Mat => {
            (true, false, true)
        }
        _ => (false, false, false),
    };
    for (option, given, used) in [
        ("--step", args.step, step),
        ("--x-unit", args.x_unit, x_unit),
        ("--z-unit", args.z_unit, z_unit),
    ] {
        if given.is_some() && !used {
            return Err(usage(anyhow!(
                "{}: expected no {option} for this kind of file ({kind}), found one; leave it out",
                file.display()
            )));
        }
    }
    Ok(())
}

/// Two options that cannot both be meant.
fn contradiction(file: &Path, expected: &str, found: &str) -> Failure {
    usage(anyhow!(
        "{}: expected {expected}, found {found}; leave one of them out",
        file.display()
    ))
}

fn of_line(
    args: &Arguments,
    file: &Path,
    measured: MeasuredProfile<'_>,
) -> Outcome<ProfileRoughness> {
    evaluated_profile(measured, &wish(args, file)?).map_err(|error| refused(file, &error))
}

/// How profiles are to be evaluated.
fn wish(args: &Arguments, file: &Path) -> Outcome<RoughnessOptions> {
    let without_filter = args.filter == Some(FilterName::None);
    if without_filter && args.s_filter.is_some_and(|s| s != ShortWaves::Kept) {
        return Err(contradiction(
            file,
            "an S-filter or no filter",
            "--filter none with --s-filter",
        ));
    }
    if without_filter && args.periodic {
        return Err(contradiction(
            file,
            "an automatic cut-off or no filter",
            "--filter none with --periodic",
        ));
    }
    Ok(RoughnessOptions {
        standard: match args.standard {
            Some(StandardName::Iso21920) => ProfileStandard::Iso21920,
            Some(StandardName::Iso4287) | None => ProfileStandard::Iso4287,
        },
        form: args.form,
        filter: args.filter.map(|filter| match filter {
            FilterName::Gauss => ProfileFilter::Gauss,
            FilterName::None => ProfileFilter::None,
        }),
        cutoff: match (args.cutoff, args.periodic) {
            (Some(cutoff_m), _) => Some(Cutoff::Stated(cutoff_m)),
            (None, true) => Some(Cutoff::Iso4288Periodic),
            (None, false) => None,
        },
        short_waves: args.s_filter,
    })
}

fn of_map(args: &Arguments, file: &Path, map: &HeightMap) -> Outcome<ArealRoughness> {
    let config = ArealConfig {
        // Without a filter only the mean is taken away, unless a person says otherwise.
        form: args.form.unwrap_or(match args.filter {
            Some(FilterName::Gauss) | None => Form::Level,
            Some(FilterName::None) => Form::Mean,
        }),
        s_nesting_m: s_nesting_of_map(args, file)?,
        l_nesting_m: args.cutoff,
    };
    areal_roughness(map, &config).map_err(|error| refused(file, &error))
}

/// The nesting index of the S-filter of a map, m; options that are for profiles alone are refused.
fn s_nesting_of_map(args: &Arguments, file: &Path) -> Outcome<Option<f64>> {
    for (option, given) in [
        ("--standard", args.standard.is_some()),
        ("--periodic", args.periodic),
    ] {
        if given && args.along.is_none() {
            return Err(usage(anyhow!(
                "{}: expected a profile for {option}, found a height map; leave the option out, or state --along",
                file.display()
            )));
        }
    }
    let s_nesting_m = match args.s_filter {
        None | Some(ShortWaves::Kept) => None,
        Some(ShortWaves::Stated(s_m)) => Some(s_m),
        Some(ShortWaves::Iso3274) if args.along.is_some() => None,
        Some(ShortWaves::Iso3274) => {
            return Err(usage(anyhow!(
                "{}: expected a profile for --s-filter iso, found a height map; state a length, or leave the option out",
                file.display()
            )));
        }
    };
    if args.filter == Some(FilterName::None) {
        for (option, given) in [
            ("--cutoff", args.cutoff.is_some()),
            ("--s-filter", s_nesting_m.is_some()),
        ] {
            if given {
                return Err(contradiction(
                    file,
                    "a filter or none",
                    &format!("--filter none with {option}"),
                ));
            }
        }
    }
    Ok(s_nesting_m)
}

/// What the surface cannot give is a matter of the data; what no surface could give, of the command.
fn refused(file: &Path, error: &RoughnessError) -> Failure {
    let said = anyhow!("{}: {error}", file.display());
    match error {
        RoughnessError::ShortWaves { .. } | RoughnessError::Degree { .. } => usage(said),
        _ => Failure::Data(said),
    }
}
