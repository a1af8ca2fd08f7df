//! What an instrument states of a profile that it measured, and the evaluation that follows from it.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Serialize, Serializer};

use super::filtered::looks_filtered;
use super::parameters::key_of;
use super::plausible;
use super::profile::check_cutoff;
use super::{
    Cutoff, FilterFault, Form, HeightProfile, InstrumentStates, Parameter, ProfileConfig,
    ProfileFilter, ProfileRoughness, ProfileStandard, RoughnessError, ShortWaves, SurfaceWarning,
    mean, profile_mean_line, profile_roughness,
};
use piezotact::warning::Warning;

/// Two cut-offs that differ by less than this share are one.
const SAME_CUTOFF: f64 = 1e-3;
/// Two values of a parameter that differ by more than this share contradict each other: more than the ends, which instruments
/// filter otherwise, explain.
const CONTRADICTED: f64 = 0.1;

/// A filtered profile has less than this share of its power in waves from twice the cut-off on.
const LONG_WAVES: f64 = 0.25;

/// What kind of profile a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProfileKind {
    /// The primary profile: nothing was filtered, or only short waves.
    Primary,
    /// The roughness profile: the instrument has taken the long waves away.
    Roughness,
}

/// A parameter as the instrument states it.
#[derive(Clone, Debug, PartialEq)]
pub struct InstrumentValue {
    /// Its symbol, as ours: "Ra".
    pub symbol: String,
    /// In the unit of our parameter of that symbol: µm, % or none.
    pub value: f64,
}

/// What an instrument states of a measurement.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct InstrumentSettings {
    /// The file that states it.
    pub file: PathBuf,
    /// The cut-off λc, m (in documents mm).
    #[serde(rename = "cutoff_mm", serialize_with = "mm")]
    pub cutoff_m: Option<f64>,
    /// The cut-off λs of short waves, m (in documents µm).
    #[serde(rename = "lambda_s_um", serialize_with = "um")]
    pub lambda_s_m: Option<f64>,
    /// The length that was set, m (in documents mm).
    #[serde(rename = "measured_length_mm", serialize_with = "mm")]
    pub measured_length_m: Option<f64>,
    /// The length that was evaluated, m (in documents mm).
    #[serde(rename = "evaluation_length_mm", serialize_with = "mm")]
    pub evaluation_length_m: Option<f64>,
    /// The parameters that it states, in its order; in documents under our names.
    #[serde(rename = "parameters", serialize_with = "by_name")]
    #[cfg_attr(feature = "schemas", schemars(with = "BTreeMap<&str, f64>"))]
    pub values: Vec<InstrumentValue>,
}

fn mm<S: Serializer>(length_m: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    length_m.map(|m| m * 1e3).serialize(serializer)
}

fn um<S: Serializer>(length_m: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    length_m.map(|m| m * 1e6).serialize(serializer)
}

fn by_name<S: Serializer>(values: &[InstrumentValue], serializer: S) -> Result<S::Ok, S::Error> {
    let named = values
        .iter()
        .map(|value| (key_of(&value.symbol), value.value));
    named.collect::<BTreeMap<_, _>>().serialize(serializer)
}

impl InstrumentSettings {
    /// The instrument's value of `parameter`, in its unit.
    #[must_use]
    pub fn value_of(&self, parameter: &Parameter) -> Option<f64> {
        let mut values = self.values.iter();
        let found = values.find(|value| value.symbol == parameter.symbol);
        found.map(|value| value.value)
    }

    /// The settings in words, without the parameters.
    ///
    /// Source: docs/decisions/roughness.md.
    #[must_use]
    pub fn text(&self) -> String {
        let stated = [
            ("λc", self.cutoff_m),
            ("λs", self.lambda_s_m),
            ("length set", self.measured_length_m),
            ("length evaluated", self.evaluation_length_m),
        ];
        let stated: Vec<String> = (stated.iter())
            .filter_map(|(what, length_m)| {
                Some(format!("{what} {}", super::length_text((*length_m)?)))
            })
            .collect();
        match (stated.is_empty(), self.values.is_empty()) {
            (true, _) => "no settings that are known".into(),
            (false, true) => format!("{}; no parameters", stated.join(", ")),
            (false, false) => stated.join(", "),
        }
    }
}

/// A profile with what is stated of it.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredProfile<'a> {
    pub profile: &'a HeightProfile,
    /// What kind of profile it is; absent where nothing says.
    pub kind: Option<ProfileKind>,
    /// What the instrument states; absent without such a file.
    pub instrument: Option<&'a InstrumentSettings>,
}

/// How a person wants a profile evaluated; what is absent follows from the profile and the usual rules.
#[derive(Clone, Copy, Debug)]
pub struct RoughnessOptions {
    pub standard: ProfileStandard,
    /// The form that is taken away first.
    pub form: Option<Form>,
    /// What separates roughness from waviness.
    pub filter: Option<ProfileFilter>,
    /// Where it separates them.
    pub cutoff: Option<Cutoff>,
    /// What is taken away at the short end.
    pub short_waves: Option<ShortWaves>,
}

/// The roughness parameters of a profile as [`profile_roughness`] gives them, heights in m, with what the instrument states: a
/// roughness profile whose cut-off is stated is not filtered again, and one that is, or looks filtered, raises a warning.
///
/// Formula: as [`profile_roughness`]; without a wish, the form is the least-squares line before a filter and the mean without one,
/// the cut-off that of ISO 4288 and λs that of ISO 3274.
///
/// Source: docs/decisions/roughness.md.
///
/// # Errors
/// As [`profile_roughness`].
pub fn evaluated_profile(
    measured: MeasuredProfile<'_>,
    wish: &RoughnessOptions,
) -> Result<ProfileRoughness, RoughnessError> {
    let config = config(measured, wish);
    let mut roughness = profile_roughness(measured.profile, &config)?;
    let more = [
        filtered_twice(measured, &roughness)?,
        not_filtered(measured.profile, &roughness),
        contradicted(measured, &roughness),
        plausible::of_slope(roughness.rdq),
    ];
    roughness.warnings.extend(more.into_iter().flatten());
    let of_heights = plausible::of_heights(measured.profile);
    roughness.warnings.extend(of_heights);
    Ok(roughness)
}

/// How a profile of which nothing is stated is evaluated as `wish` asks.
pub(super) fn usual_config(profile: &HeightProfile, wish: &RoughnessOptions) -> ProfileConfig {
    let measured = MeasuredProfile {
        profile,
        kind: None,
        instrument: None,
    };
    config(measured, wish)
}

fn config(measured: MeasuredProfile<'_>, wish: &RoughnessOptions) -> ProfileConfig {
    let own = own_cutoff_m(measured, wish);
    let filter = match (wish.filter, own) {
        (Some(filter), _) => filter,
        (None, Some(_)) => ProfileFilter::Instrument,
        (None, None) => ProfileFilter::Gauss,
    };
    let cutoff = match own {
        // A profile shorter than the cut-off is one section.
        Some(cutoff_m) if check_cutoff(measured.profile, cutoff_m).is_ok() => {
            Cutoff::Stated(cutoff_m)
        }
        _ => wish
            .cutoff
            .or_else(|| stated_for_primary(measured, filter))
            .unwrap_or(Cutoff::Iso4288),
    };
    let usual_form = match filter {
        ProfileFilter::Gauss => Form::Level,
        ProfileFilter::None | ProfileFilter::Instrument => Form::Mean,
    };
    ProfileConfig {
        standard: wish.standard,
        form: wish.form.unwrap_or(usual_form),
        filter,
        cutoff,
        short_waves: wish.short_waves.unwrap_or(ShortWaves::Iso3274),
    }
}

/// The cut-off with which the instrument evaluated a primary profile: whoever measured it chose it, which goes before the rule.
fn stated_for_primary(measured: MeasuredProfile<'_>, filter: ProfileFilter) -> Option<Cutoff> {
    let cutoff_m = measured.instrument?.cutoff_m?;
    let usable = measured.kind == Some(ProfileKind::Primary)
        && filter == ProfileFilter::Gauss
        && check_cutoff(measured.profile, cutoff_m).is_ok();
    usable.then_some(Cutoff::Stated(cutoff_m))
}

/// The instrument's cut-off, m, where the profile is filtered with it and nobody wants another filter.
fn own_cutoff_m(measured: MeasuredProfile<'_>, wish: &RoughnessOptions) -> Option<f64> {
    let own_m = measured.instrument?.cutoff_m?;
    let same = match wish.cutoff {
        None => true,
        Some(Cutoff::Stated(cutoff_m)) => (cutoff_m / own_m - 1.0).abs() < SAME_CUTOFF,
        Some(Cutoff::Iso4288 | Cutoff::Iso4288Periodic) => false,
    };
    let nothing_else = matches!(wish.short_waves, None | Some(ShortWaves::Kept));
    (measured.kind == Some(ProfileKind::Roughness) && wish.filter.is_none() && same && nothing_else)
        .then_some(own_m)
}

/// A warning where the Gaussian filter was used on a profile that is, or looks, filtered already.
fn filtered_twice(
    measured: MeasuredProfile<'_>,
    roughness: &ProfileRoughness,
) -> Result<Option<Warning>, RoughnessError> {
    let (ProfileFilter::Gauss, Some(cutoff_m)) = (roughness.config.filter, roughness.cutoff_m)
    else {
        return Ok(None);
    };
    let declared = measured.kind == Some(ProfileKind::Roughness);
    if !declared && !looks_filtered(measured.profile, cutoff_m) {
        return Ok(None);
    }
    let unfiltered = ProfileConfig {
        filter: ProfileFilter::None,
        // without a cut-off the whole profile is one section
        cutoff: Cutoff::Iso4288,
        form: Form::Mean,
        ..roughness.config.clone()
    };
    let unfiltered_ra_m = profile_roughness(measured.profile, &unfiltered)?.ra_m;
    let ra_m = roughness.ra_m;
    Ok(Some(Warning::from(if declared {
        SurfaceWarning::Filter {
            cutoff_m,
            fault: FilterFault::Twice {
                ra_m,
                unfiltered_ra_m,
            },
        }
    } else {
        SurfaceWarning::Filter {
            cutoff_m,
            fault: FilterFault::LooksFiltered {
                ra_m,
                unfiltered_ra_m,
            },
        }
    })))
}

/// A warning where a profile that counts as filtered by the instrument has much of its power in waves that its filter removes. A
/// Gaussian filter leaves 2.5 % of the power of a wave of twice the cut-off, and less of longer ones.
fn not_filtered(profile: &HeightProfile, roughness: &ProfileRoughness) -> Option<Warning> {
    let (ProfileFilter::Instrument, Some(cutoff_m)) = (roughness.config.filter, roughness.cutoff_m)
    else {
        return None;
    };
    let waves = profile_mean_line(profile, 2.0 * cutoff_m).ok()?;
    let power = |z: &[f64]| {
        let about = mean(z.iter().copied());
        mean(z.iter().map(|z| (z - about).powi(2)))
    };
    let share = power(waves.heights_m()) / power(profile.heights_m());
    (share > LONG_WAVES).then(|| {
        Warning::from(SurfaceWarning::Filter {
            cutoff_m,
            fault: FilterFault::NotFiltered { share },
        })
    })
}

/// A warning where the instrument's Ra is another one.
fn contradicted(measured: MeasuredProfile<'_>, roughness: &ProfileRoughness) -> Option<Warning> {
    let settings = measured.instrument?;
    let ra = settings.values.iter().find(|value| value.symbol == "Ra")?;
    let (ours, theirs) = (roughness.ra_m * 1e6, ra.value);
    let same = (ours - theirs).abs() <= CONTRADICTED * theirs.abs().max(ours.abs());
    (!same).then(|| {
        Warning::from(SurfaceWarning::Instrument {
            what: InstrumentStates::Parameter {
                parameter: ra.symbol.clone(),
                ours_um: ours,
                instrument_um: theirs,
                cutoff_m: roughness.cutoff_m,
                instrument_cutoff_m: settings.cutoff_m,
            },
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const STEP_M: f64 = 1e-6;

    /// 4 mm: a wave of 0.1 mm and one of 2 mm, which a filter of 0.8 mm takes away.
    fn primary() -> HeightProfile {
        let wave = |i: i32| {
            let x_m = f64::from(i) * STEP_M;
            1e-6 * (x_m / 0.1e-3 * TAU).sin() + 3e-6 * (x_m / 2e-3 * TAU).sin()
        };
        HeightProfile::new((0..4000).map(wave).collect(), STEP_M).unwrap()
    }

    fn wish() -> RoughnessOptions {
        RoughnessOptions {
            standard: ProfileStandard::Iso4287,
            form: None,
            filter: None,
            cutoff: None,
            short_waves: None,
        }
    }

    fn settings(ra_um: f64) -> InstrumentSettings {
        InstrumentSettings {
            cutoff_m: Some(2e-3),
            values: vec![InstrumentValue {
                symbol: "Ra".into(),
                value: ra_um,
            }],
            ..InstrumentSettings::default()
        }
    }

    /// The codes of the warnings, with the fault or what differs behind each that has one.
    fn codes(roughness: &ProfileRoughness) -> Vec<String> {
        let cause = |d: &Warning| {
            let cause = d.fields.get("fault").or_else(|| d.fields.get("what"));
            let cause = cause.and_then(|cause| cause.as_str()).unwrap_or_default();
            format!("{}/{cause}", d.code)
        };
        roughness.warnings.iter().map(cause).collect()
    }

    #[test]
    fn a_roughness_profile_is_filtered_again_only_where_that_is_wanted_and_then_said() {
        let profile = primary();
        let stated = settings(2.0);
        let measured = MeasuredProfile {
            profile: &profile,
            kind: Some(ProfileKind::Roughness),
            instrument: Some(&stated),
        };
        let own = evaluated_profile(measured, &wish()).unwrap();
        assert_eq!(own.config.filter, ProfileFilter::Instrument);
        assert_eq!((own.cutoff_m, own.sections), (Some(2e-3), 2));
        let plain = ProfileConfig {
            standard: ProfileStandard::Iso4287,
            form: Form::Mean,
            filter: ProfileFilter::None,
            cutoff: Cutoff::Stated(2e-3),
            short_waves: ShortWaves::Kept,
        };
        let plain = profile_roughness(&profile, &plain).unwrap();
        assert_eq!(own.ra_m.to_bits(), plain.ra_m.to_bits());
        assert_eq!(codes(&own), ["few/sections"]);

        let other = |change: fn(&mut RoughnessOptions)| {
            let mut wish = wish();
            change(&mut wish);
            evaluated_profile(measured, &wish).unwrap()
        };
        let same = other(|wish| wish.cutoff = Some(Cutoff::Stated(2.0001e-3)));
        assert_eq!(same.config.filter, ProfileFilter::Instrument);
        for again in [
            other(|wish| wish.cutoff = Some(Cutoff::Stated(0.8e-3))),
            other(|wish| wish.filter = Some(ProfileFilter::Gauss)),
            other(|wish| wish.short_waves = Some(ShortWaves::Stated(8e-6))),
            other(|wish| wish.cutoff = Some(Cutoff::Iso4288Periodic)),
            evaluated_profile(
                MeasuredProfile {
                    instrument: None,
                    ..measured
                },
                &wish(),
            )
            .unwrap(),
        ] {
            assert_eq!(again.config.filter, ProfileFilter::Gauss);
            assert!(
                codes(&again).contains(&"filter_doubtful/twice".to_owned()),
                "{:?}",
                again.warnings
            );
        }
        let unfiltered = other(|wish| wish.filter = Some(ProfileFilter::None));
        assert!(!codes(&unfiltered).contains(&"filter_doubtful/twice".to_owned()));
        // nothing says that a primary profile is filtered, and its long wave shows that it is not
        let kind = Some(ProfileKind::Primary);
        let primary = MeasuredProfile { kind, ..measured };
        let automatic = RoughnessOptions {
            cutoff: Some(Cutoff::Iso4288),
            ..wish()
        };
        let primary = evaluated_profile(primary, &automatic).unwrap();
        assert!(
            !codes(&primary)
                .iter()
                .any(|code| code.starts_with("filter_doubtful")),
            "{:?}",
            primary.warnings
        );
    }

    #[test]
    fn another_ra_than_the_instruments_is_said_with_both_cut_offs() {
        let profile = primary();
        let of = |ra_um: f64| {
            let stated = settings(ra_um);
            let measured = MeasuredProfile {
                profile: &profile,
                kind: Some(ProfileKind::Primary),
                instrument: Some(&stated),
            };
            let automatic = RoughnessOptions {
                cutoff: Some(Cutoff::Iso4288),
                ..wish()
            };
            evaluated_profile(measured, &automatic).unwrap()
        };
        let ours_um = of(1.0).ra_m * 1e6;
        assert!(!codes(&of(ours_um * 1.08)).contains(&"instrument_differs/parameter".to_owned()));
        let differs = of(ours_um * 1.5);
        assert!(codes(&differs).contains(&"instrument_differs/parameter".to_owned()));
        let text = differs
            .warnings
            .last()
            .unwrap()
            .kind::<SurfaceWarning>()
            .unwrap()
            .to_string();
        assert!(text.contains("0.8 mm") && text.contains("2 mm"), "{text}");
    }

    #[test]
    fn a_primary_profile_gets_the_cut_off_that_its_instrument_states() {
        let profile = primary();
        let stated = InstrumentSettings {
            cutoff_m: Some(0.25e-3),
            ..settings(0.6)
        };
        let measured = MeasuredProfile {
            profile: &profile,
            kind: Some(ProfileKind::Primary),
            instrument: Some(&stated),
        };
        let own = evaluated_profile(measured, &wish()).unwrap();
        assert_eq!(own.cutoff_m, Some(0.25e-3));
        assert_eq!(own.config.filter, ProfileFilter::Gauss);
        let wanted = RoughnessOptions {
            cutoff: Some(Cutoff::Stated(0.8e-3)),
            ..wish()
        };
        let wanted = evaluated_profile(measured, &wanted).unwrap();
        assert_eq!(wanted.cutoff_m, Some(0.8e-3));
    }

    /// A primary profile under the name of a roughness profile.
    #[test]
    fn a_profile_with_long_waves_was_not_filtered() {
        let primary = primary();
        let stated = InstrumentSettings {
            cutoff_m: Some(0.25e-3),
            ..settings(0.6)
        };
        let of = |profile: &HeightProfile| {
            let measured = MeasuredProfile {
                profile,
                kind: Some(ProfileKind::Roughness),
                instrument: Some(&stated),
            };
            let found = evaluated_profile(measured, &wish()).unwrap();
            codes(&found).contains(&"filter_doubtful/not_filtered".to_owned())
        };
        assert!(of(&primary));
        let line = profile_mean_line(&primary, 0.25e-3).unwrap();
        let rest = primary.heights_m().iter().zip(line.heights_m());
        let filtered = primary.with_heights(rest.map(|(z, line)| z - line).collect());
        assert!(!of(&filtered));
    }
}
