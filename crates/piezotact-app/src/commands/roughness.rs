//! `piezotact roughness`: the roughness of a profile or a height map.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use piezotact::surface::{
    ArealConfig, ArealRoughness, Cutoff, EvaluatedSurface, Form, HeightMap, HeightProfile,
    ProfileConfig, ProfileFilter, ProfileRoughness, ProfileStandard, Roughness as Evaluated,
    RoughnessDocument, ShortWaves, SurfaceError, Topography, areal_roughness, profile_roughness,
};
use piezotact_dataset::{TopographyKind, TopographyOptions, read_topography};
use piezotact_report::{report, roughness};

use super::outputs;
use crate::advice::OptionWords;
use crate::cli::{FilterName, Roughness, StandardName};
use crate::failure::{Failure, Outcome, usage};
use crate::invocation::write_report;
use crate::output::{print, print_document, say_doubts, write_text};

pub(crate) fn run(args: &Roughness) -> Outcome {
    let written: Vec<&Path> = args
        .csv
        .iter()
        .chain(&args.report)
        .map(PathBuf::as_path)
        .collect();
    outputs(&[&args.file], &written)?;
    let surface = evaluated(args)?;
    if let (Some(path), Evaluated::Profile(roughness)) = (&args.csv, &surface.roughness) {
        write_text(path, &report::csv(&roughness.points_table())?)?;
    }
    if let Some(path) = &args.report {
        write_report(path, &roughness::html(&surface, &OptionWords)?)?;
    }
    if args.json {
        return print_document(&RoughnessDocument::of(&surface));
    }
    say_doubts(&surface.doubts);
    print(&text_of(&surface))?;
    for path in &written {
        print(&format!("wrote {}", path.display()))?;
    }
    Ok(())
}

fn evaluated(args: &Roughness) -> Outcome<EvaluatedSurface> {
    let options = TopographyOptions {
        step_m: args.step,
        coordinate_unit_m: args.x_unit,
        height_unit_m: args.z_unit,
    };
    let file = read_topography(&args.file, &options)?;
    nothing_stated_in_vain(args, file.kind)?;
    let roughness = match &file.topography {
        Topography::Profile(profile) => Evaluated::Profile(Box::new(of_line(args, profile)?)),
        Topography::Map(map) => Evaluated::Map(Box::new(of_map(args, map)?)),
    };
    let more = roughness.doubts().iter().cloned();
    Ok(EvaluatedSurface {
        file: args.file.clone(),
        format: file.kind.to_string(),
        doubts: file.doubts.into_iter().chain(more).collect(),
        roughness,
    })
}

/// Refuses a scale for a file that has no use for it: it would change nothing, and look as if it did.
fn nothing_stated_in_vain(args: &Roughness, kind: TopographyKind) -> Outcome {
    use TopographyKind as Kind;
    let (step, x_unit, z_unit) = match kind {
        Kind::PointText | Kind::ProfileText => (false, true, true),
        Kind::MatrixText | Kind::HeightText | Kind::Surfcom => (true, false, true),
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
                args.file.display()
            )));
        }
    }
    Ok(())
}

/// The form that is taken away: without a filter only the mean, unless a person says otherwise.
fn form(args: &Roughness) -> Form {
    args.form.unwrap_or(match args.filter {
        FilterName::Gauss => Form::Level,
        FilterName::None => Form::Mean,
    })
}

/// Two options that cannot both be meant.
fn contradiction(file: &Path, expected: &str, found: &str) -> Failure {
    usage(anyhow!(
        "{}: expected {expected}, found {found}; leave one of them out",
        file.display()
    ))
}

fn of_line(args: &Roughness, profile: &HeightProfile) -> Outcome<ProfileRoughness> {
    let without_filter = args.filter == FilterName::None;
    if without_filter && args.s_filter.is_some_and(|s| s != ShortWaves::Kept) {
        return Err(contradiction(
            &args.file,
            "an S-filter or no filter",
            "--filter none with --s-filter",
        ));
    }
    if without_filter && args.periodic {
        return Err(contradiction(
            &args.file,
            "an automatic cut-off or no filter",
            "--filter none with --periodic",
        ));
    }
    let config = ProfileConfig {
        standard: match args.standard {
            Some(StandardName::Iso21920) => ProfileStandard::Iso21920,
            Some(StandardName::Iso4287) | None => ProfileStandard::Iso4287,
        },
        form: form(args),
        filter: match args.filter {
            FilterName::Gauss => ProfileFilter::Gauss,
            FilterName::None => ProfileFilter::None,
        },
        cutoff: match (args.cutoff, args.periodic) {
            (Some(cutoff_m), _) => Cutoff::Stated(cutoff_m),
            (None, true) => Cutoff::Iso4288Periodic,
            (None, false) => Cutoff::Iso4288,
        },
        short_waves: args.s_filter.unwrap_or(ShortWaves::Iso3274),
    };
    profile_roughness(profile, &config).map_err(|error| refused(&args.file, &error))
}

fn of_map(args: &Roughness, map: &HeightMap) -> Outcome<ArealRoughness> {
    let config = ArealConfig {
        form: form(args),
        s_nesting_m: s_nesting_of_map(args)?,
        l_nesting_m: args.cutoff,
    };
    areal_roughness(map, &config).map_err(|error| refused(&args.file, &error))
}

/// The nesting index of the S-filter of a map, m; options that are for profiles alone are refused.
fn s_nesting_of_map(args: &Roughness) -> Outcome<Option<f64>> {
    for (option, given) in [
        ("--standard", args.standard.is_some()),
        ("--periodic", args.periodic),
        ("--csv", args.csv.is_some()),
    ] {
        if given {
            return Err(usage(anyhow!(
                "{}: expected a profile for {option}, found a height map; leave the option out",
                args.file.display()
            )));
        }
    }
    let s_nesting_m = match args.s_filter {
        None | Some(ShortWaves::Kept) => None,
        Some(ShortWaves::Stated(s_m)) => Some(s_m),
        Some(ShortWaves::Iso3274) => {
            return Err(usage(anyhow!(
                "{}: expected a profile for --s-filter iso, found a height map; state a length, or leave the option out",
                args.file.display()
            )));
        }
    };
    if args.filter == FilterName::None {
        for (option, given) in [
            ("--cutoff", args.cutoff.is_some()),
            ("--s-filter", s_nesting_m.is_some()),
        ] {
            if given {
                return Err(contradiction(
                    &args.file,
                    "a filter or none",
                    &format!("--filter none with {option}"),
                ));
            }
        }
    }
    Ok(s_nesting_m)
}

/// What the surface cannot give is a matter of the data; what no surface could give, of the command.
fn refused(file: &Path, error: &SurfaceError) -> Failure {
    let said = anyhow!("{}: {error}", file.display());
    match error {
        SurfaceError::ShortWaves { .. } | SurfaceError::Degree { .. } => usage(said),
        _ => Failure::Data(said),
    }
}

fn text_of(surface: &EvaluatedSurface) -> String {
    let mut text = format!(
        "{}: {} ({})",
        surface.file.display(),
        surface.roughness.size_text(),
        surface.format
    );
    for parameter in surface.roughness.parameters() {
        text += &format!(
            "\n  {:<4} {:>10} {:<3} {}",
            parameter.symbol,
            parameter.number(),
            parameter.value.map_or("", |_| parameter.unit),
            parameter.meaning
        );
    }
    text + "\n" + &surface.roughness.method_text()
}
