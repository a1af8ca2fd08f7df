//! What the thesis says of its measurements, as claims that can be checked.

use piezotact::criterion::{Criterion, Limit, Outcome};
use serde::{Deserialize, Serialize, Serializer};

/// One claim of the thesis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Claim {
    /// Its number, from 1.
    #[serde(rename = "claim")]
    pub number: u8,
    /// The chapter of the thesis.
    pub chapter: u8,
    /// The section and figures.
    pub at: &'static str,
    /// What the thesis says.
    pub says: &'static str,
    /// The sentence of the thesis that the criterion follows, where it is quoted.
    pub quote: Option<&'static str>,
    /// What holds it, in numbers.
    pub holds_if: &'static str,
}

impl Claim {
    const fn quoting(self, quote: &'static str) -> Self {
        Self {
            quote: Some(quote),
            ..self
        }
    }
}

const fn claim(
    number: u8,
    chapter: u8,
    at: &'static str,
    says: &'static str,
    holds_if: &'static str,
) -> Claim {
    Claim {
        number,
        chapter,
        at,
        says,
        quote: None,
        holds_if,
    }
}

/// All claims, by number.
pub const CLAIMS: [Claim; 37] = [
    claim(
        1,
        5,
        "5.1.1, fig. 67d",
        "The transfer functions of the fingers of five participants at three loads form a bundle with a maximum deviation of 8 \
            dB.",
        "6–10 dB over 20–1000 Hz",
    ),
    claim(
        2,
        5,
        "5.1.1, 5.1.2, fig. 68, 77",
        "The maximum deviation falls with load.",
        "0.6 N deviates less than 0.2 N: on the shaker, on the device at 20° and at 40°, each by itself in ≥ 90 % of panels; in this panel also 0.2 N > 0.4 N > 0.6 N",
    )
    .quoting("Increasing the contact load, the deviation of the Transfer Functions with the participants decreases. […] the maximum deviation shows a decreasing trend as the contact force increases, for both 20° and 40°."),
    claim(
        3,
        5,
        "5.1.1, 7.1.4, fig. 70, 74",
        "The gain rises with load for every participant, on the device over the whole band.",
        "device, 20° and 40°: the mean gain of every participant rises from 0.2 to 0.4 and to 0.6 N, and from 0.2 to 0.6 N on ≥ 95 % of the lines; shaker: the mean gain of every participant rises from load to load",
    )
    .quoting("for each participant, the gain of the finger Transfer Function increases as the contact load increases. […] Once the finger/actuator angle is fixed, the gain of the Transfer Function increases as the normal load increases throughout the interested frequency range."),
    claim(
        4,
        5,
        "fig. 75",
        "20° or 40° makes a slight difference without a trend.",
        "< 1.5 dB rms, sign test over 20 participants p > 0.05",
    ),
    claim(
        5,
        5,
        "fig. 71",
        "The antiresonance at 265 Hz is the shaker's: it is in the control and in every finger.",
        "minimum at 265 ± 5 Hz in all; after compensation at most ± 2 dB remain",
    ),
    claim(
        6,
        5,
        "5.1.2, fig. 78a",
        "Six measurements of one finger are repeatable, also after the finger is repositioned.",
        "≤ 1 dB rms between any two at 20°, 0.2 N, for every participant",
    )
    .quoting("a repeatability test has been performed, for each participant […] the 6 measurements, either with or without repositioning the finger, present a very high repeatability, with negligible variations."),
    claim(
        7,
        5,
        "5.1.2, fig. 78b",
        "The coherence is close to 1 except at very low frequencies.",
        "> 0.95 over 25–950 Hz, < 0.9 at 5 Hz, over all measurements on the device",
    )
    .quoting("a Coherence close to 1 and stable in frequency has always been found for all measurements under all the conditions."),
    claim(
        8,
        5,
        "5.1.2, fig. 77",
        "0.2 N is the load with the largest maximum deviation; the angle has no definite trend.",
        "0.2 N is the widest load of the six conditions; which angle is, is reported with its share over random halves of the panel",
    )
    .quoting("the condition {20°, 0.2N}, which is the condition associated with the greatest variability (greater deviation of the bundle of curves) of the Transfer Function. […] The variation of the angle causes a slight variation of the shape of the Transfer Function, but without a significant deviation and without a definite trend."),
    claim(
        9,
        5,
        "fig. 69, 76",
        "The average lies inside the bundle.",
        "between the lowest and the highest on every line",
    ),
    claim(
        10,
        3,
        "3.2.1, fig. 31, 32",
        "Isotropic samples have broad spectra of similar shape within 10–600 Hz.",
        "≥ 90 % of the power in 10–600 Hz, spectral shapes within 3 dB rms for every pair; in active and in passive touch",
    ),
    claim(
        11,
        3,
        "3.2.2, fig. 33",
        "The level falls from S1 to S9 and fluctuates from S10 to S13.",
        "monotone S1–S9, where S2 ≈ S3 and S8 ≈ S9 within 8 % may change places; at least one inversion in S10–S13",
    ),
    claim(
        12,
        3,
        "3.2.2, fig. 33",
        "S2 to S4 have close levels though their Ra differ by a factor of three.",
        "S2 and S3 within ± 1 dB, S2 and S4 within ± 2 dB",
    )
    .quoting("samples from S2 to S4 have close RMS values, even if the roughness are well differentiated. […] The samples S2 and S3 […] present very similar RMS of induced vibrations, although they present clearly different Ra."),
    claim(
        13,
        3,
        "4.3.2, fig. 61",
        "S7 and S8 have the same Ra and clearly different levels.",
        "S7/S8 ≥ 1.2, a just noticeable difference (1.6 dB)",
    )
    .quoting("samples S7 and S8 present similar values of Ra, but they have been always well discriminated in the entire campaign. In accordance, the associated RMS of FIV and the FIV spectra (Figure 61 and Figure 60c) are clearly different."),
    claim(
        14,
        3,
        "4.3.2",
        "The samples that are hard to distinguish have levels below about 0.7 m/s².",
        "S10–S13 < 0.7 m/s², S1–S8 > 0.7 m/s²",
    ),
    claim(
        15,
        3,
        "3.2.2, fig. 34",
        "Friction decreases with Ra and increases with the level; the plate without texture has the highest friction and the \
            lowest level.",
        "Spearman(Ra, friction) > 0.7 over S1–S13; NO at both extremes",
    ),
    claim(
        16,
        3,
        "3.2.2, fig. 37",
        "The level rises with speed for every sample, and the order of the samples does not change.",
        "all 14 rise; log-log slope 0.8–1.2; Spearman between speeds > 0.95",
    ),
    claim(
        17,
        3,
        "3.2.2, 3.2.3, fig. 35, 36",
        "Coarse samples show the fingerprint at f = v/λ: 55 Hz at 30 mm/s.",
        "within ± 10 % of v/λ for S1–S4 at 30 mm/s and S1–S3 at 10 and 20 mm/s; log-log slope of the peak on speed 1 ± 0.1; the same in active touch at 30 mm/s",
    )
    .quoting("a main frequency peak can be distinguished at about 55 Hz for the coarser textures (from S1 to S4 in particular) […] the frequency value of the peaks (in Hz) corresponds to the ratio between the considered sliding velocity and the participant fingerprint wavelength."),
    claim(
        18,
        3,
        "3.2.3, fig. 38–40",
        "Active and passive touch give the same spectra and the same order.",
        "≤ 3 dB rms over 20–500 Hz for S1–S13; Spearman of the levels > 0.95",
    ),
    claim(
        19,
        3,
        "3.1, fig. 30",
        "The spectrum repeats from stroke to stroke.",
        "third octaves of every stroke, 20–500 Hz and normalised, ≤ 3 dB rms from their mean; rms varies by ≤ 20 %; every sample, ≥ 10 strokes",
    )
    .quoting("The frequency distribution stays the same and the amplitude is quite similar. These observations are valid for all the tested samples."),
    claim(
        20,
        4,
        "4.1, fig. 42",
        "A vibration sent directly to the device is reproduced with another level and spectrum.",
        "measured below clipping and predicted: level ≥ 10 dB off at the scale of the device, level-matched error ≥ 3 × that of the rendering, waveform correlation < 0.75",
    )
    .quoting("the target FIV signal (Figure 42a) and the one obtained by the device (Figure 42b) would be definitely different. In Figure 42 the two signals are not compared on the same plot because of the different order of magnitude."),
    claim(
        21,
        4,
        "4.2, fig. 47, 48",
        "The rendered vibration agrees with the original.",
        "≤ 1 dB rms over 30–500 Hz and waveform correlation ≥ 0.95 with the participant's own transfer function",
    ),
    claim(
        22,
        5,
        "5.2, fig. 79",
        "With the averaged transfer function, the error is slightly larger.",
        "larger than with the own transfer function, ≤ 3 dB rms",
    ),
    claim(
        23,
        4,
        "4.4, fig. 62",
        "Exchanging the levels of two samples keeps their spectral shapes.",
        "levels equal to 0.1 %, shapes identical",
    ),
    claim(
        24,
        4,
        "4.3.2, fig. 55",
        "Participants confuse S2 with S3 and S9–S13 with each other, identify S4–S8, and always identify the plate without \
            texture.",
        "tasks 1 to 3: diagonal of each of S4–S7 ≥ 80 %, S2 and S3 taken for each other in ≥ 10 %, 80 % of the errors of S9–S13 among them; NO 100 % in task 1",
    ),
    claim(
        25,
        4,
        "fig. 59",
        "Real and rendered textures are confused in the same way.",
        "correlation ≥ 0.6 of the cells off the diagonal, tasks 2 and 3",
    ),
    claim(
        26,
        5,
        "5.3, fig. 80",
        "In a discrimination experiment, the averaged transfer function gives the same performance.",
        "mean diagonal within 8 points",
    ),
    claim(
        27,
        4,
        "4.4.2, fig. 63",
        "With exchanged levels, participants choose the sample that has this level.",
        "≥ 80 % as expected; real textures all in order; at most 1 of 30 rendered textures with their own levels wrong in a set; S11 INVERTED taken for S8, and no other error more often",
    ),
    claim(
        28,
        4,
        "4.3.1, fig. 51–54",
        "Periodic samples are distinguished; M5, M7, M11 and M12 least well.",
        "real and rendered: diagonal of each of those below the median; M4 and M8 never confused",
    ),
    claim(
        29,
        6,
        "6.4, fig. 90, 91",
        "In free touch, M8 shows harmonics of v/0.716 mm between 50 and 400 Hz for every participant.",
        "for every participant ≥ 2 harmonics within 50–400 Hz that stand out by 4 dB; the speed, from their spacing, within 10–50 mm/s",
    )
    .quoting("For all participants, the FIV frequency distribution presents well defined harmonics, mainly contained in a range between 50 and 400 Hz. […] The frequencies peaks are consistent with an average sliding velocity in the range between 10 and 50 mm/s for the rough texture having an equivalent wavelength of 0.716 mm."),
    claim(
        30,
        6,
        "6.4, fig. 89",
        "M3 has a lower level and a higher centroid; whether M8 or the biomimetic sample has the higher level depends on the \
            participant.",
        "centroid of M3 highest and level lowest for every participant; both orders of M8 and BIO occur among ten participants",
    ),
    claim(
        31,
        6,
        "6.4, fig. 93",
        "Participants press harder on the biomimetic sample, which has less friction; on the device they apply the same force in both tasks and on all surfaces.",
        "force BIO > M3, M8; friction M3 ≈ M8 (±10 %) and ≥ 1.5 × BIO; on the device, with rendered drives, paired tests of the tasks and of the surfaces p > 0.05 (Holm)",
    )
    .quoting("No significant differences have been found in the normal force obtained for the different surfaces and during the different tasks involving the tactile feedback by the PIEZOTACT. […] the participants explored, on average, the biomimetic surface with a higher force than the two periodic microtextured surfaces […] the periodic surfaces (rough and smooth) exhibit a similar friction coefficient, which is markedly higher than the friction coefficient associated to the biomimetic surface."),
    claim(
        32,
        6,
        "6.4, fig. 94, 95",
        "Without imagery, M3 is always identified and M8 is confused with the biomimetic sample; with imagery, all are \
            identified better.",
        "control: M3 100 %, M8 and BIO taken for each other; imagery minus control: 95 % interval over participants above 0",
    ),
    claim(
        33,
        6,
        "6.5, fig. 97",
        "The alpha rhythm decreases most in the control task, less with imagery, least in natural touch.",
        "group means in that order on all three surfaces",
    ),
    claim(
        34,
        2,
        "2.6.3, fig. 25, 26",
        "An association is the number of declarations divided by the number of presentations, for each presented sample.",
        "the worked example: SC declared SD = 1/3",
    ),
    claim(
        35,
        2,
        "2.3.1, fig. 13",
        "Transversal touch gives lower levels and more stick-slip than proximal touch.",
        "rms lower, more strokes with stick-slip, a wider peak of the fingerprint: every coarse sample, S1–S4, in active touch",
    )
    .quoting("the contact during the transversal sliding is characterized by a strong mechanical instability of the finger, leading to the occurrence of stick-slip […] the amplitude of vibration is lower in case of transversal sliding, with respect to the longitudinal one […] The main frequency peaks are more defined and characterized by a smaller bandwidth in the longitudinal direction."),
    claim(
        36,
        6,
        "6.4, fig. 90",
        "The rough and the biomimetic sample show a peak between 70 and 110 Hz, the smooth one does not.",
        "a peak of ≥ 3 dB prominence within 70–110 Hz on M8 and on BIO, none on M3: each of ten participants",
    )
    .quoting("The first definite frequency peak (approximately between 70 and 110 Hz depending on the participant), found both in the 'rough' surface and in the 'biomimetic' one (i.e. the 'coarse' textures), but not in the 'smooth' one, may be linked to participant's fingerprints."),
    claim(
        37,
        6,
        "6.3, 6.5, fig. 96",
        "The tasks differ in activity over the sensorimotor cortex, at the level of sensors.",
        "cluster tests over the region of C3 and CP3: the desynchronisation of control against natural touch, of control against imagery, and of imagery against natural touch is stronger, p < 0.05 after Holm",
    ),
];

/// What was found of a claim.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Finding {
    /// The number of the claim; documents have what it says too.
    #[serde(flatten, serialize_with = "with_its_claim")]
    #[cfg_attr(feature = "schemas", schemars(with = "Claim"))]
    pub claim: u8,
    /// What was measured, with its unit.
    pub measured: String,
    /// Whether it holds: when all criteria are met.
    #[serde(flatten)]
    pub verdict: Verdict,
    /// What the verdict follows from; empty for what cannot be measured yet.
    pub criteria: Vec<Criterion<ClaimRule>>,
}

fn with_its_claim<S: Serializer>(number: &u8, serializer: S) -> Result<S::Ok, S::Error> {
    match CLAIMS.iter().find(|claim| claim.number == *number) {
        Some(claim) => claim.serialize(serializer),
        None => serializer.collect_map([("claim", number)]),
    }
}

/// A rule that a claim holds by.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ClaimRule {
    /// What is the case where it is not met.
    pub unless_met: String,
    /// How it is counted over panels.
    #[serde(default, skip_serializing_if = "Counting::is_together")]
    pub counting: Counting,
}

/// How a rule is counted over panels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Counting {
    /// In one panel with the other rules of its claim.
    #[default]
    Together,
    /// By itself: the claim is about each such rule, over panels.
    Alone,
    /// Not at all: it is about the one panel of a report.
    InReportOnly,
}

impl Counting {
    fn is_together(&self) -> bool {
        *self == Self::Together
    }
}

/// Whether a claim holds on the twin.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "verdict", rename_all = "snake_case")]
pub enum Verdict {
    /// It does.
    Holds,
    /// It does not, or in part.
    #[serde(rename = "does_not_hold")]
    DoesNot {
        /// Why, where that is known.
        reason: String,
    },
    /// It cannot be measured yet.
    NotYet {
        /// What brings it; in documents a sentence.
        #[serde(rename = "reason", serialize_with = "requires")]
        with: &'static str,
    },
}

fn requires<S: Serializer>(with: &&'static str, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(&format_args!("not measured yet: requires {with}"))
}

impl Finding {
    pub(super) fn of(claim: u8, holds: Holds, measured: String) -> Self {
        let Holds(criteria) = holds;
        let failed: Vec<&str> = criteria
            .iter()
            .filter(|criterion| criterion.outcome != Outcome::Met)
            .map(|criterion| criterion.what.unless_met.as_str())
            .collect();
        let verdict = if failed.is_empty() {
            Verdict::Holds
        } else {
            Verdict::DoesNot {
                reason: failed.join("; "),
            }
        };
        Self {
            claim,
            measured,
            verdict,
            criteria,
        }
    }

    /// Whether it holds.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.verdict == Verdict::Holds
    }
}

/// The least of all values; NaN where one is NaN, or there is none: what was not measured holds nothing.
pub(super) fn least(values: impl IntoIterator<Item = f64>) -> f64 {
    extreme(values, f64::min)
}

/// The most of all values, likewise.
pub(super) fn most(values: impl IntoIterator<Item = f64>) -> f64 {
    extreme(values, f64::max)
}

fn extreme(values: impl IntoIterator<Item = f64>, choose: fn(f64, f64) -> f64) -> f64 {
    let chosen = values.into_iter().reduce(|a, b| {
        if a.is_nan() || b.is_nan() {
            f64::NAN
        } else {
            choose(a, b)
        }
    });
    chosen.unwrap_or(f64::NAN)
}

/// What a measurement says of a claim, rule by rule. What was not measured (NaN) is not met.
pub(super) struct Holds(Vec<Criterion<ClaimRule>>);

impl Holds {
    /// All rules; those that are not met are the reason.
    pub(super) fn all(rules: impl IntoIterator<Item = Criterion<ClaimRule>>) -> Self {
        Self(rules.into_iter().collect())
    }
}

fn rule(found: f64, limit: Limit, unit: &str, unless_met: &str) -> Criterion<ClaimRule> {
    let what = ClaimRule {
        unless_met: unless_met.into(),
        counting: Counting::Together,
    };
    if found.is_nan() {
        Criterion::unmeasured(what, unit, limit)
    } else {
        Criterion::new(what, unit, found, None, limit)
    }
}

/// The rule, counted over panels by itself.
pub(super) fn alone(rule: Criterion<ClaimRule>) -> Criterion<ClaimRule> {
    counted_as(rule, Counting::Alone)
}

/// The rule, which is about one panel alone.
pub(super) fn in_report_only(rule: Criterion<ClaimRule>) -> Criterion<ClaimRule> {
    counted_as(rule, Counting::InReportOnly)
}

fn counted_as(mut rule: Criterion<ClaimRule>, counting: Counting) -> Criterion<ClaimRule> {
    rule.what.counting = counting;
    rule
}

/// No exception is allowed.
pub(super) fn no_exception(exceptions: usize, unless_met: &str) -> Criterion<ClaimRule> {
    rule(exceptions as f64, Limit::at_most(0.0), "", unless_met)
}

/// `found` is no more than `most`.
pub(super) fn at_most(found: f64, most: f64, unit: &str, unless_met: &str) -> Criterion<ClaimRule> {
    rule(found, Limit::at_most(most), unit, unless_met)
}

/// `found` is no less than `least`.
pub(super) fn at_least(
    found: f64,
    least: f64,
    unit: &str,
    unless_met: &str,
) -> Criterion<ClaimRule> {
    rule(found, Limit::at_least(least), unit, unless_met)
}

/// `found` is less than `bound`, which is no longer met itself.
pub(super) fn below(found: f64, bound: f64, unit: &str, unless_met: &str) -> Criterion<ClaimRule> {
    beyond(at_most(found, bound, unit, unless_met), bound)
}

/// `found` is more than `bound`, which is not yet met itself.
pub(super) fn above(found: f64, bound: f64, unit: &str, unless_met: &str) -> Criterion<ClaimRule> {
    beyond(at_least(found, bound, unit, unless_met), bound)
}

fn beyond(mut rule: Criterion<ClaimRule>, bound: f64) -> Criterion<ClaimRule> {
    if rule
        .found
        .is_some_and(|found| found.total_cmp(&bound).is_eq())
    {
        rule.outcome = Outcome::NotMet;
    }
    rule
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_holds_nothing() {
        assert!(least([1.0, f64::NAN]).is_nan() && most([] as [f64; 0]).is_nan());
        assert_eq!((least([2.0, 1.0]), most([2.0, 1.0])), (1.0, 2.0));
    }

    /// The verdict follows from the criteria: at its bound `above` is not met, and neither is what was not measured.
    #[test]
    fn a_verdict_is_its_criteria() {
        let of = |p: f64, level: f64| {
            let rules = [
                above(p, 0.05, "", "a trend"),
                at_most(level, 3.0, "dB", "apart"),
            ];
            Finding::of(1, Holds::all(rules), String::new())
        };
        let good = of(0.06, 3.0);
        assert!(good.holds() && good.criteria.len() == 2);
        assert_eq!(good.criteria[1].found, Some(3.0));
        for (p, level, expected) in [
            (0.05, 2.0, "a trend"),
            (0.06, 3.1, "apart"),
            (f64::NAN, f64::NAN, "a trend; apart"),
        ] {
            let reason = expected.to_owned();
            assert_eq!(of(p, level).verdict, Verdict::DoesNot { reason });
        }
        assert!(!Finding::of(1, Holds::all([no_exception(1, "no")]), String::new()).holds());
    }

    #[test]
    fn the_claims_are_in_order() {
        for (claim, number) in CLAIMS.iter().zip(1..) {
            assert_eq!(claim.number, number);
            assert!((2..=6).contains(&claim.chapter) && !claim.says.is_empty());
        }
    }
}
