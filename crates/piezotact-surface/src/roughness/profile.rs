//! Roughness parameters of a profile.

use crate::roughness::SurfaceWarning;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::cutoff::{Entry, Search, TABLE, lambda_s_m, search};
use super::section::{Amplitudes, mean_element_width_m, rms, slopes};
use super::{
    Cutoff, Form, HeightProfile, MaterialRatio, RoughnessError, STEPS_PER_CUTOFF, ShortWaves,
    filter, material_ratio, mean, remove_profile_form,
};
use piezotact::warning::{Few, FewWarning, Warning};

/// The sections that both standards ask for.
const SECTIONS: usize = 5;
/// A stretch whose Ra differs from that of the whole line by more than this factor is not like it.
const UNLIKE: f64 = 1.5;
/// Sections whose Ra differ by more than this factor hold more than one surface, such as a groove beside a plane.
const SECTIONS_UNLIKE: f64 = 4.0;
/// Heights below a picometre are rounding.
pub(super) const ROUNDING_M: f64 = 1e-12;
/// Rounding of a length in a file, as a share of a section.
const LENGTH_TOLERANCE: f64 = 1e-6;

/// Which standard says what is averaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ProfileStandard {
    /// ISO 4287:1997: every parameter in each sampling length, then the mean; Rt over the evaluation length.
    Iso4287,
    /// ISO 21920-2:2021: Ra, Rq, Rsk, Rku, Rdq, `RSm` and Rt over the evaluation length; the mean over the
    /// sections only of Rz, Rp and Rv.
    Iso21920,
}

/// What separates roughness from waviness.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ProfileFilter {
    /// The Gaussian filter of ISO 16610-21: the parameters are those of the roughness profile.
    Gauss,
    /// Nothing, neither at the long nor at the short end: the parameters are those of the primary profile
    /// without its form. A cut-off that is stated makes the sections; without one the whole profile is
    /// one section.
    None,
    /// That of the instrument, before it wrote the profile: nothing more is taken away. The cut-off stated makes the
    /// sections.
    Instrument,
}

/// How a profile is evaluated. There is no default: it is stated, and goes into the result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ProfileConfig {
    /// What is averaged.
    pub standard: ProfileStandard,
    /// The form that is taken away first.
    pub form: Form,
    /// What separates roughness from waviness.
    pub filter: ProfileFilter,
    /// Where it separates them.
    pub cutoff: Cutoff,
    /// What is taken away at the short end.
    pub short_waves: ShortWaves,
}

/// What became of the ends, where a filter sees only one side.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Ends {
    /// At least half a cut-off on each side is not evaluated.
    Dropped,
    /// They are evaluated, the profile continued by its mirror image.
    Kept,
    /// No filter was used.
    Unfiltered,
}

/// The roughness of a profile: heights and widths in m, slopes and moments dimensionless.
#[derive(Clone, Debug, PartialEq)]
pub struct ProfileRoughness {
    /// Mean absolute height Ra, m.
    pub ra_m: f64,
    /// Root-mean-square height Rq, m.
    pub rq_m: f64,
    /// Height from the lowest valley to the highest peak of a section, mean over sections: Rz, m.
    pub rz_m: f64,
    /// Height from the lowest valley to the highest peak of the evaluation length: Rt, m.
    pub rt_m: f64,
    /// Highest peak of a section, mean over sections: Rp, m.
    pub rp_m: f64,
    /// Lowest valley of a section, mean over sections, above zero: Rv, m.
    pub rv_m: f64,
    /// Skewness Rsk; absent for a flat profile.
    pub rsk: Option<f64>,
    /// Kurtosis Rku, 3 for Gaussian heights; absent for a flat profile.
    pub rku: Option<f64>,
    /// Mean width of the profile elements `RSm`, m; absent when no element is whole.
    pub rsm_m: Option<f64>,
    pub rdq: f64,
    /// Core, peaks and valleys of the material ratio curve over the evaluation length; absent for a flat profile.
    pub material: Option<MaterialRatio>,
    /// How it was evaluated.
    pub config: ProfileConfig,
    /// The cut-off λc, m; absent when the whole profile was one section.
    pub cutoff_m: Option<f64>,
    /// Whether the search for the cut-off settled on one; true where it was stated.
    pub cutoff_settled: bool,
    /// The filter λs for short waves, m; absent when none was used.
    pub lambda_s_m: Option<f64>,
    /// The number of sections.
    pub sections: usize,
    /// Ra of the section in which it is lowest and of that in which it is highest, m, each about the mean of its own.
    pub section_ra_m: [f64; 2],
    /// The length evaluated, m.
    pub evaluation_length_m: f64,
    /// The points evaluated, out of those of `roughness`.
    pub evaluated: Range<usize>,
    /// What became of the ends.
    pub ends: Ends,
    /// The roughness profile over the whole length; the primary profile without a filter.
    pub roughness: HeightProfile,
    /// The mean line over the whole length, after form: zero without a filter.
    pub mean_line: HeightProfile,
    /// What a person should know before relying on it.
    pub warnings: Vec<Warning>,
}

impl ProfileRoughness {
    /// Whether its sections differ so little that the parameters describe one surface: the highest Ra of a section is at most four times
    /// the lowest.
    ///
    /// Source: docs/decisions/roughness.md.
    #[must_use]
    pub fn is_uniform(&self) -> bool {
        let [lowest_m, highest_m] = self.section_ra_m;
        highest_m <= (SECTIONS_UNLIKE * lowest_m).max(ROUNDING_M)
    }

    /// The primary profile: the one measured, without its form and without short waves, in m. It is the sum
    /// of mean line and roughness profile.
    #[must_use]
    pub fn primary(&self) -> HeightProfile {
        let heights = self.roughness.heights_m().iter();
        let line = self.mean_line.heights_m().iter();
        self.roughness
            .with_heights(heights.zip(line).map(|(z, line)| z + line).collect())
    }

    /// Where the sections begin, and the last one ends: one more point than there are sections.
    #[must_use]
    pub fn section_borders(&self) -> Vec<usize> {
        let points = self.roughness.heights_m().len();
        let section = self
            .cutoff_m
            .map_or(points as f64, |cutoff_m| cutoff_m / self.roughness.step_m());
        section_bounds(points, section)
    }
}

/// The roughness parameters of `profile`, heights in m, over five sections of the cut-off or as many as fit,
/// taken from its middle.
///
/// Formula: with z about its mean over the evaluation length, Ra = mean |z|, Rq = √mean z², Rsk = mean z³/Rq³,
/// Rku = mean z⁴/Rq⁴, Rz = Rp + Rv by section, Rt = max − min, Rdq = √mean (dz/dx)² by the seven-point
/// formula, `RSm` = mean width of the elements that rise and fall beyond 10 % of Rz and are wider than 1 % of
/// a section.
///
/// Source: ISO 4287:1997; ISO 21920-2:2021 and -3:2021; ISO 4288:1996 for the cut-off.
///
/// # Errors
/// [`RoughnessError::Cutoff`] when the profile is shorter than one cut-off or the cut-off shorter than five steps,
/// [`RoughnessError::ShortWaves`] when λs is not between 0 and λc, [`RoughnessError::Degree`] when the form
/// cannot be fitted, [`RoughnessError::Huge`] when the heights are beyond any surface.
///
/// ```
/// use piezotact_surface::*;
/// let wave = |i: i32| 1e-6 * (f64::from(i) * 1e-6 / 0.1e-3 * std::f64::consts::TAU).sin();
/// let profile = HeightProfile::new((0..6000).map(wave).collect(), 1e-6).unwrap();
/// let config = ProfileConfig {
///     standard: ProfileStandard::Iso21920,
///     form: Form::Level,
///     filter: ProfileFilter::Gauss,
///     cutoff: Cutoff::Stated(0.8e-3),
///     short_waves: ShortWaves::Kept,
/// };
/// let roughness = profile_roughness(&profile, &config).unwrap();
/// assert!((roughness.ra_m - 2e-6 / std::f64::consts::PI).abs() < 1e-9); // a sine of 1 µm
/// assert!((roughness.rsm_m.unwrap() - 0.1e-3).abs() < 1e-8);
/// ```
pub fn profile_roughness(
    profile: &HeightProfile,
    config: &ProfileConfig,
) -> Result<ProfileRoughness, RoughnessError> {
    let formless = remove_profile_form(profile, config.form)?;
    let split = match (config.filter, config.cutoff) {
        (ProfileFilter::None | ProfileFilter::Instrument, Cutoff::Stated(cutoff_m)) => {
            Split::none(formless, Some(cutoff_m))?
        }
        (ProfileFilter::None | ProfileFilter::Instrument, _) => Split::none(formless, None)?,
        (ProfileFilter::Gauss, Cutoff::Stated(cutoff_m)) => {
            Split::gauss(&formless, cutoff_m, config.short_waves)?
        }
        (ProfileFilter::Gauss, _) => return by_the_table(&formless, config),
    };
    Ok(split.evaluate(config))
}

/// Evaluates with the cut-off that the rule of ISO 4288 finds.
fn by_the_table(
    formless: &HeightProfile,
    config: &ProfileConfig,
) -> Result<ProfileRoughness, RoughnessError> {
    let split = |row: usize| Split::gauss(formless, TABLE[row].cutoff_m, config.short_waves);
    let rows = rows_that_fit(formless)?;
    let guess = table_entry(formless, TABLE[rows.0].cutoff_m, config.cutoff);
    let found = search(guess, rows, |row| {
        let roughness = split(row)?.roughness;
        Ok(table_entry(&roughness, TABLE[row].cutoff_m, config.cutoff))
    })?;
    match found {
        Search::Settled(row) => Ok(split(row)?.evaluate(config)),
        Search::Unsettled(row) => {
            let mut roughness = split(row)?.evaluate(config);
            roughness.cutoff_settled = false;
            roughness
                .warnings
                .push(Warning::from(SurfaceWarning::CutoffUnsettled {
                    used_m: TABLE[row].cutoff_m,
                    ra_m: roughness.ra_m,
                }));
            Ok(roughness)
        }
    }
}

/// One cut-off for `lines` of equal length and step, and whether the rule settled on it.
pub(super) fn common_cutoff(
    lines: &[HeightProfile],
    config: &ProfileConfig,
) -> Result<(Cutoff, bool), RoughnessError> {
    let (ProfileFilter::Gauss, Cutoff::Iso4288 | Cutoff::Iso4288Periodic) =
        (config.filter, config.cutoff)
    else {
        return Ok((config.cutoff, true));
    };
    let formless = lines
        .iter()
        .map(|line| remove_profile_form(line, config.form));
    let formless = formless.collect::<Result<Vec<_>, _>>()?;
    let rows = rows_that_fit(&formless[0])?;
    let guess = mean_entry(&formless, TABLE[rows.0].cutoff_m, config.cutoff);
    let found = search(guess, rows, |row| {
        let cutoff_m = TABLE[row].cutoff_m;
        let split = (formless.iter())
            .map(|line| Ok(Split::gauss(line, cutoff_m, config.short_waves)?.roughness));
        let roughness = split.collect::<Result<Vec<_>, RoughnessError>>()?;
        Ok(mean_entry(&roughness, cutoff_m, config.cutoff))
    })?;
    let (Search::Settled(row) | Search::Unsettled(row)) = found;
    let is_settled = matches!(found, Search::Settled(_));
    Ok((Cutoff::Stated(TABLE[row].cutoff_m), is_settled))
}

/// What the table is entered with for several lines: the mean.
fn mean_entry(lines: &[HeightProfile], section_m: f64, rule: Cutoff) -> Entry {
    let values = lines
        .iter()
        .map(|line| match table_entry(line, section_m, rule) {
            Entry::Ra(value_m) | Entry::Rsm(value_m) => value_m,
        });
    match rule {
        Cutoff::Iso4288Periodic => Entry::Rsm(mean(values)),
        Cutoff::Iso4288 | Cutoff::Stated(_) => Entry::Ra(mean(values)),
    }
}

/// What the table is entered with: over the whole profile, since five sections of a trial cut-off can lie on
/// a stretch that is not like the rest.
fn table_entry(roughness: &HeightProfile, section_m: f64, rule: Cutoff) -> Entry {
    let offset_m = mean(roughness.heights_m().iter().copied());
    let heights_m: Vec<f64> = roughness.heights_m().iter().map(|z| z - offset_m).collect();
    let amplitudes = Amplitudes::of(heights_m.iter().copied());
    match rule {
        Cutoff::Iso4288 | Cutoff::Stated(_) => Entry::Ra(amplitudes.mean_absolute_m),
        Cutoff::Iso4288Periodic => {
            let rz_m = amplitudes.range_m();
            let width_m = mean_element_width_m(&heights_m, roughness.step_m(), section_m, rz_m);
            Entry::Rsm(width_m.unwrap_or(f64::INFINITY))
        }
    }
}

/// The first and last row of the table whose cut-off fits steps and length of the profile.
fn rows_that_fit(profile: &HeightProfile) -> Result<(usize, usize), RoughnessError> {
    let fits = |cutoff_m: f64| check_cutoff(profile, cutoff_m).is_ok();
    let first = TABLE.iter().position(|row| fits(row.cutoff_m));
    let last = TABLE.iter().rposition(|row| fits(row.cutoff_m));
    let shortest = TABLE[0].cutoff_m;
    first
        .zip(last)
        .ok_or_else(|| RoughnessError::cutoff(shortest, profile.step_m(), profile.length_m()))
}

pub(super) fn check_cutoff(profile: &HeightProfile, cutoff_m: f64) -> Result<(), RoughnessError> {
    let (step_m, length_m) = (profile.step_m(), profile.length_m());
    let longest_m = length_m * (1.0 + LENGTH_TOLERANCE);
    if (STEPS_PER_CUTOFF * step_m..=longest_m).contains(&cutoff_m) {
        Ok(())
    } else {
        Err(RoughnessError::cutoff(cutoff_m, step_m, length_m))
    }
}

/// A profile split into its roughness and its mean line.
struct Split {
    roughness: HeightProfile,
    mean_line: HeightProfile,
    cutoff_m: Option<f64>,
    lambda_s_m: Option<f64>,
    filter: ProfileFilter,
}

impl Split {
    fn none(primary: HeightProfile, cutoff_m: Option<f64>) -> Result<Self, RoughnessError> {
        if let Some(cutoff_m) = cutoff_m {
            check_cutoff(&primary, cutoff_m)?;
        }
        Ok(Self {
            mean_line: primary.with_heights(vec![0.0; primary.heights_m().len()]),
            roughness: primary,
            cutoff_m,
            lambda_s_m: None,
            filter: ProfileFilter::None,
        })
    }

    fn gauss(
        formless: &HeightProfile,
        cutoff_m: f64,
        short_waves: ShortWaves,
    ) -> Result<Self, RoughnessError> {
        check_cutoff(formless, cutoff_m)?;
        let lambda_s_m = match short_waves {
            ShortWaves::Kept => None,
            ShortWaves::Iso3274 => {
                let table_m = lambda_s_m(cutoff_m);
                (table_m >= STEPS_PER_CUTOFF * formless.step_m()).then_some(table_m)
            }
            ShortWaves::Stated(found_m) if found_m > 0.0 && found_m < cutoff_m => Some(found_m),
            ShortWaves::Stated(found_m) => return Err(RoughnessError::ShortWaves { found_m }),
        };
        let smooth = lambda_s_m.map(|m| filter::profile_mean_line(formless, m));
        let smooth = smooth.transpose()?;
        let primary = smooth.as_ref().unwrap_or(formless);
        let mean_line = filter::profile_mean_line(primary, cutoff_m)?;
        let heights = primary.heights_m().iter().zip(mean_line.heights_m());
        Ok(Self {
            roughness: primary.with_heights(heights.map(|(z, line)| z - line).collect()),
            mean_line,
            cutoff_m: Some(cutoff_m),
            lambda_s_m,
            filter: ProfileFilter::Gauss,
        })
    }

    fn evaluate(self, config: &ProfileConfig) -> ProfileRoughness {
        let step_m = self.roughness.step_m();
        let points = self.roughness.heights_m().len();
        let section_m = self.cutoff_m.unwrap_or(points as f64 * step_m);
        let bounds = section_bounds(points, section_m / step_m);
        let (sections, evaluated) = (bounds.len() - 1, bounds[0]..bounds[bounds.len() - 1]);
        let parameters = match config.standard {
            ProfileStandard::Iso4287 => Parameters::iso_4287(&self.roughness, &bounds, section_m),
            ProfileStandard::Iso21920 => Parameters::iso_21920(&self.roughness, &bounds, section_m),
        };
        let cutoffs = points as f64 * step_m / section_m + LENGTH_TOLERANCE;
        let ends = match self.filter {
            ProfileFilter::None | ProfileFilter::Instrument => Ends::Unfiltered,
            ProfileFilter::Gauss if cutoffs < (SECTIONS + 1) as f64 => Ends::Kept,
            ProfileFilter::Gauss => Ends::Dropped,
        };
        let short = few_sections(sections, self.cutoff_m);
        let whole = table_entry(&self.roughness, section_m, Cutoff::Iso4288);
        let uneven = uneven(parameters.heights.mean_absolute_m, whole);
        let total = parameters.total;
        let section_ra_m = section_ra_m(&self.roughness, &bounds);
        let mut found = ProfileRoughness {
            ra_m: parameters.heights.mean_absolute_m,
            rq_m: parameters.heights.rms_m,
            rz_m: parameters.heights.range_m(),
            rt_m: total.range_m(),
            rp_m: parameters.heights.peak_m,
            rv_m: parameters.heights.valley_m,
            rsk: parameters.heights.skewness,
            rku: parameters.heights.kurtosis,
            rsm_m: parameters.element_width_m,
            rdq: parameters.slope,
            material: material_ratio(&self.roughness.heights_m()[evaluated.clone()]),
            config: config.clone(),
            cutoff_m: self.cutoff_m,
            cutoff_settled: true,
            lambda_s_m: self.lambda_s_m,
            sections,
            section_ra_m,
            evaluation_length_m: evaluated.len() as f64 * step_m,
            evaluated,
            ends,
            roughness: self.roughness,
            mean_line: self.mean_line,
            warnings: short.into_iter().chain(uneven).collect(),
        };
        if !found.is_uniform() {
            let [lowest_ra_m, highest_ra_m] = section_ra_m;
            let unlike = SurfaceWarning::UnevenSections {
                lowest_ra_m,
                highest_ra_m,
            };
            found.warnings.push(unlike.into());
        }
        found
    }
}

/// Fewer sections than the standards ask for.
pub(super) fn few_sections(sections: usize, cutoff_m: Option<f64>) -> Option<Warning> {
    let short = cutoff_m.filter(|_| sections < SECTIONS);
    short.map(|cutoff_m| {
        Warning::from(FewWarning::Few {
            found: sections,
            recommended: SECTIONS,
            what: Few::Sections { cutoff_m },
        })
    })
}

/// Ra of the section in which it is lowest and of that in which it is highest, m, each about the mean of its own.
fn section_ra_m(roughness: &HeightProfile, bounds: &[usize]) -> [f64; 2] {
    let of_each = bounds.windows(2).map(|b| {
        let heights_m = &roughness.heights_m()[b[0]..b[1]];
        let mean_m = mean(heights_m.iter().copied());
        mean(heights_m.iter().map(|z| (z - mean_m).abs()))
    });
    of_each.fold([f64::INFINITY, 0.0], |[lowest, highest], ra_m| {
        [ra_m.min(lowest), ra_m.max(highest)]
    })
}

/// Whether what was evaluated is unlike the whole line.
fn uneven(evaluated_ra_m: f64, whole: Entry) -> Option<Warning> {
    let Entry::Ra(whole_ra_m) = whole else {
        return None;
    };
    let (low_m, high_m) = (whole_ra_m / UNLIKE, whole_ra_m * UNLIKE);
    let unlike = !(low_m..=high_m).contains(&evaluated_ra_m);
    (unlike && evaluated_ra_m.max(whole_ra_m) > ROUNDING_M).then_some(Warning::from(
        SurfaceWarning::UnevenProfile {
            evaluated_ra_m,
            whole_ra_m,
        },
    ))
}

/// The first point of every section, and the end of the last: up to five sections from the middle of
/// `points`, each `section` steps long.
fn section_bounds(points: usize, section: f64) -> Vec<usize> {
    let fit = (points as f64 / section + LENGTH_TOLERANCE) as usize;
    let sections = fit.clamp(1, SECTIONS);
    let start = ((points as f64 - sections as f64 * section) / 2.0).max(0.0);
    (0..=sections)
        .map(|k| ((start + k as f64 * section).round() as usize).min(points))
        .collect()
}

/// Parameters as one of the standards averages them, and the heights over the whole evaluation length.
struct Parameters {
    heights: Amplitudes,
    total: Amplitudes,
    element_width_m: Option<f64>,
    slope: f64,
}

impl Parameters {
    fn iso_4287(roughness: &HeightProfile, bounds: &[usize], section_m: f64) -> Self {
        let evaluation = Evaluation::new(roughness, bounds);
        let by_section = evaluation.amplitudes_by_section();
        let step_m = roughness.step_m();
        let widths = bounds
            .windows(2)
            .zip(&by_section)
            .filter_map(|(b, heights)| {
                let z = evaluation.heights(b[0]..b[1]);
                mean_element_width_m(z, step_m, section_m, heights.range_m())
            });
        let widths: Vec<f64> = widths.collect();
        let slopes = bounds.windows(2).map(|b| evaluation.slopes(b[0]..b[1]));
        Self {
            heights: mean_of(&by_section),
            total: evaluation.total(),
            element_width_m: (!widths.is_empty()).then(|| mean(widths.iter().copied())),
            slope: mean(slopes.map(rms)),
        }
    }

    fn iso_21920(roughness: &HeightProfile, bounds: &[usize], section_m: f64) -> Self {
        let evaluation = Evaluation::new(roughness, bounds);
        let (total, by_section) = (evaluation.total(), evaluation.amplitudes_by_section());
        let sectional = mean_of(&by_section);
        let range = evaluation.start..evaluation.start + evaluation.heights_m.len();
        Self {
            heights: Amplitudes {
                peak_m: sectional.peak_m,
                valley_m: sectional.valley_m,
                ..total
            },
            total,
            element_width_m: mean_element_width_m(
                &evaluation.heights_m,
                roughness.step_m(),
                section_m,
                sectional.range_m(),
            ),
            slope: rms(evaluation.slopes(range)),
        }
    }
}

fn mean_of(sections: &[Amplitudes]) -> Amplitudes {
    let of = |what: fn(&Amplitudes) -> f64| mean(sections.iter().map(what));
    let of_present = |what: fn(&Amplitudes) -> Option<f64>| {
        let present = sections.iter().filter_map(what);
        present.clone().next().map(|_| mean(present))
    };
    Amplitudes {
        mean_absolute_m: of(|s| s.mean_absolute_m),
        rms_m: of(|s| s.rms_m),
        peak_m: of(|s| s.peak_m),
        valley_m: of(|s| s.valley_m),
        skewness: of_present(|s| s.skewness),
        kurtosis: of_present(|s| s.kurtosis),
    }
}

/// The heights evaluated, about their mean, and the slopes of the whole profile.
struct Evaluation<'a> {
    start: usize,
    bounds: &'a [usize],
    heights_m: Vec<f64>,
    slopes: Vec<f64>,
}

impl<'a> Evaluation<'a> {
    fn new(roughness: &HeightProfile, bounds: &'a [usize]) -> Self {
        let (start, end) = (bounds[0], bounds[bounds.len() - 1]);
        let heights_m = &roughness.heights_m()[start..end];
        let mean_m = mean(heights_m.iter().copied());
        Self {
            start,
            bounds,
            heights_m: heights_m.iter().map(|z| z - mean_m).collect(),
            slopes: slopes(roughness.heights_m(), roughness.step_m()),
        }
    }

    fn heights(&self, points: Range<usize>) -> &[f64] {
        &self.heights_m[points.start - self.start..points.end - self.start]
    }

    /// The slopes at `points`, without those that lack three neighbours in the whole profile.
    fn slopes(&self, points: Range<usize>) -> &[f64] {
        let end = points.end.saturating_sub(3).min(self.slopes.len());
        &self.slopes[points.start.saturating_sub(3).min(end)..end]
    }

    fn total(&self) -> Amplitudes {
        Amplitudes::of(self.heights_m.iter().copied())
    }

    fn amplitudes_by_section(&self) -> Vec<Amplitudes> {
        let sections = self.bounds.windows(2);
        sections
            .map(|b| Amplitudes::of(self.heights(b[0]..b[1]).iter().copied()))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    /// A cut-off of 0.8 mm after the `form`.
    fn stated(form: Form) -> ProfileConfig {
        ProfileConfig {
            standard: ProfileStandard::Iso4287,
            form,
            filter: ProfileFilter::Gauss,
            cutoff: Cutoff::Stated(0.8e-3),
            short_waves: ShortWaves::Kept,
        }
    }

    /// A plane with one groove had an Ra, and a place among other surfaces, without a word.
    #[test]
    fn a_groove_in_a_plane_is_no_roughness_of_one_surface() {
        let mut state = 1u64;
        let mut noise = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        // 6 mm of a ground plane, and a groove of 30 µm that is 0.8 mm wide.
        let mut profile = |depth_m: f64| {
            let heights = (0..6000).map(|i| {
                let from_middle = (f64::from(i) - 3000.0) / 400.0;
                0.6e-6 * noise() - depth_m * (1.0 - from_middle.powi(2)).max(0.0)
            });
            HeightProfile::new(heights.collect(), 1e-6).unwrap()
        };
        let config = stated(Form::Level);
        let plane = profile_roughness(&profile(0.0), &config).unwrap();
        assert!(plane.is_uniform());
        assert_eq!(plane.warnings, []);
        let worn = profile_roughness(&profile(30e-6), &config).unwrap();
        assert!(!worn.is_uniform());
        let [lowest_m, highest_m] = worn.section_ra_m;
        assert!(highest_m > 10.0 * lowest_m, "{:?}", worn.section_ra_m);
        // The plane has an Ra of a quarter of its range.
        assert!((lowest_m / 0.15e-6 - 1.0).abs() < 0.1, "{lowest_m}");
        let is_said = |warning: &Warning| {
            matches!(warning.kind(), Some(SurfaceWarning::UnevenSections { .. }))
        };
        assert!(worn.warnings.iter().any(is_said));
    }

    #[test]
    fn sections_unlike_the_rest_are_a_warning() {
        let config = stated(Form::Mean);
        // 10 mm; beyond 8 mm the wave is `factor` times as high
        let warnings = |factor: f64| {
            let wave = |i: i32| {
                let height_m = if i < 8000 { 1e-6 } else { factor * 1e-6 };
                height_m * (f64::from(i) / 50.0 * TAU).sin()
            };
            let profile = HeightProfile::new((0..10_000).map(wave).collect(), 1e-6).unwrap();
            let roughness = profile_roughness(&profile, &config).unwrap();
            let borders = [3000, 3800, 4600, 5400, 6200, 7000];
            assert_eq!(roughness.section_borders(), borders);
            let primary = roughness.primary();
            for (z, before) in primary.heights_m().iter().zip(profile.heights_m()) {
                assert!((z - before).abs() < 1e-9, "only the mean was taken away");
            }
            roughness.warnings
        };
        assert_eq!(warnings(1.0), []);
        let flat = HeightProfile::new(vec![3e-6; 2000], 10e-6).unwrap();
        assert_eq!(profile_roughness(&flat, &config).unwrap().warnings, []);
        let unlike = warnings(8.0);
        let Some(SurfaceWarning::UnevenProfile {
            evaluated_ra_m,
            whole_ra_m,
        }) = unlike.first().and_then(Warning::kind)
        else {
            panic!("{unlike:?}");
        };
        // a sine at 50 points to a wave is 0.13 % off, the step between the waves more
        assert!((evaluated_ra_m / (2e-6 / PI) - 1.0).abs() < 2e-3);
        assert!((whole_ra_m / (2.4 * 2e-6 / PI) - 1.0).abs() < 1e-2);
    }
}
