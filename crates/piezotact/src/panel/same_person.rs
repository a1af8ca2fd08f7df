//! Participants whose transfer functions have the same magnitude but for a constant gain and noise: one person under two names.

use num_complex::Complex;
use serde::{Deserialize, Serialize};

use super::membership::LOW_COHERENCE;
use super::{Entry, Filing, Panel, PanelWarning};
use crate::compare::{CompareWarning, Mixed, Named, plain_name};
use crate::quantity::Quantity;
use crate::statistics::{mean, median, standard_deviation};
use crate::transfer::TransferFunction;
use crate::warning::Warning;

/// So many lines are taken together: a difference between people goes over more, noise does not.
const SMOOTHED: usize = 8;
/// Fewer groups of lines say nothing.
const MIN_GROUPS: usize = 5;
/// Up to this ratio what two differ by has the structure of noise. Copies with noise have about 1, resampled ones 2, repeats of one
/// placement 1 to 5 (neighbouring lines of one estimate share noise), people of the twin 30 and more.
///
/// Source: docs/decisions/transfer-functions.md.
const MAX_STRUCTURE: f64 = 3.0;
/// Where other people lie at least so far apart, the noise would not hide a difference.
const SEEN_STRUCTURE: f64 = 16.0;
/// Below this noise between lines (0.43 dB) no difference of people would be hidden, whatever others differ by.
const LOW_NOISE: f64 = 0.05;
/// Differences below this are of rounding, as of a constant gain.
const ROUNDING: f64 = 1e-5;
/// A response whose level varies by less (0.04 dB) has no shape that could be somebody's.
const MIN_SHAPE: f64 = 0.005;

/// Two measurements of different participants that differ by a constant gain and noise alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SameResponse {
    /// Of whom.
    pub one: Filing,
    /// And of whom it may be too.
    pub other: Filing,
    /// The gain of the second over the first, dB.
    pub gain_db: f64,
    /// What they differ by beside it, dB rms over lines.
    pub residual_db: f64,
}

/// What two responses differ by.
struct Likeness {
    gain_db: f64,
    /// The rms difference of the logarithms of their magnitudes beside the gain.
    residual: f64,
    /// That between neighbouring lines.
    noise: f64,
    /// The variance of means over [`SMOOTHED`] lines, over that of as many lines of noise.
    structure: f64,
}

impl Likeness {
    fn is_exact(&self) -> bool {
        self.residual < ROUNDING
    }

    fn is_noise(&self) -> bool {
        self.is_exact() || self.structure <= MAX_STRUCTURE
    }
}

/// What `one` and `other` differ by, over the lines of the second that both hold; `None` for a response without shape, and few lines.
///
/// Formula: d = ln|H₂/H₁| − mean; F = n·Σd̄ᵢ²/(k − 1) ÷ Σ(d − d̄ᵢ)²/(nk − k) over k groups of n = 8 lines. Phases are left out: a delay turns
/// them, and makes nobody else.
///
/// Source: J. von Neumann (1941), Ann. Math. Statist. 12(4), of whose ratio it is the form by groups; R. A. Fisher (1925).
fn likeness<I: Quantity, O: Quantity>(
    one: &TransferFunction<I, O>,
    other: &TransferFunction<I, O>,
) -> Option<Likeness> {
    let mut own = Vec::new();
    let mut logs: Vec<f64> = Vec::new();
    for line in 1..other.response().len() {
        let Some((a, b)) = at(one, line as f64 * other.resolution_hz())
            .zip(at(other, line as f64 * other.resolution_hz()))
        else {
            continue;
        };
        own.push(a.norm().ln());
        logs.push((b.norm() / a.norm()).ln());
    }
    let groups = logs.len() / SMOOTHED;
    if groups < MIN_GROUPS || standard_deviation(&own) < MIN_SHAPE {
        return None;
    }
    logs.truncate(groups * SMOOTHED);
    let middle = mean(&logs);
    for log in &mut logs {
        *log -= middle;
    }
    let (mut smooth, mut within, mut all) = (0.0, 0.0, 0.0);
    for group in logs.chunks_exact(SMOOTHED) {
        let its = mean(group);
        smooth += its * its;
        within += group.iter().map(|log| (log - its).powi(2)).sum::<f64>();
        all += group.iter().map(|log| log * log).sum::<f64>();
    }
    let noise = within / (logs.len() - groups) as f64;
    let smooth = smooth * SMOOTHED as f64 / (groups - 1) as f64;
    Some(Likeness {
        gain_db: 20.0 * middle / std::f64::consts::LN_10,
        residual: (all / logs.len() as f64).sqrt(),
        noise: noise.sqrt(),
        structure: smooth / noise.max(f64::MIN_POSITIVE),
    })
}

/// The response at `frequency_hz`, between two lines on the straight line through them; `None` where it is not measured well.
fn at<I: Quantity, O: Quantity>(
    function: &TransferFunction<I, O>,
    frequency_hz: f64,
) -> Option<Complex<f64>> {
    let place = frequency_hz / function.resolution_hz();
    let nearest = place.round();
    // Lines of the same axis are no mean of two.
    let is_line = (place - nearest).abs() < 1e-9;
    let is_excited = |line: usize| {
        let hz = line as f64 * function.resolution_hz();
        function.excited.is_none_or(|band| band.contains(hz))
    };
    let line = |line: usize| {
        let found = *function.response().get(line)?;
        let coherent = !function.has_coherence() || function.coherence()[line] >= LOW_COHERENCE;
        (coherent && found.norm_sqr() > 0.0 && is_excited(line)).then_some(found)
    };
    if is_line {
        return line(nearest as usize);
    }
    let (low, part) = (place.floor() as usize, place.fract());
    Some(line(low)? * (1.0 - part) + line(low + 1)? * part)
}

/// The first measurements of each two participants that are the same but for a constant gain and noise.
///
/// Two of different participants at one load and angle are, where what they differ by is rounding, or has the structure of noise and the
/// noise would not hide a difference between people: it is below 0.43 dB, or the others at that load and angle lie far apart.
///
/// Source: docs/decisions/transfer-functions.md.
pub(super) fn same_people<I: Quantity, O: Quantity>(entries: &[Entry<I, O>]) -> Vec<SameResponse> {
    let mut compared: Vec<(&Filing, &Filing, Likeness)> = Vec::new();
    for (i, other) in entries.iter().enumerate() {
        for one in &entries[..i] {
            let [a, b] = [&one.filing, &other.filing];
            if a.participant != b.participant && a.cell.is(b.cell) {
                let found = likeness(&one.function, &other.function);
                compared.extend(found.map(|found| (a, b, found)));
            }
        }
    }
    let mut found: Vec<SameResponse> = Vec::new();
    for (one, other, like) in compared.iter().filter(|(.., like)| like.is_noise()) {
        let is_known = found.iter().any(|known| {
            known.other.participant == other.participant
                || [&known.one.participant, &known.other.participant]
                    == [&other.participant, &one.participant]
        });
        let is_seen = like.is_exact() || like.noise <= LOW_NOISE || {
            let apart = compared.iter().filter(|(a, b, _)| {
                a.cell.is(one.cell)
                    && [&a.participant, &b.participant] != [&one.participant, &other.participant]
            });
            let mut apart: Vec<f64> = apart.map(|(.., like)| like.structure).collect();
            median(&mut apart).is_some_and(|middle| middle >= SEEN_STRUCTURE)
        };
        if is_seen && !is_known {
            found.push(SameResponse {
                one: (*one).clone(),
                other: (*other).clone(),
                gain_db: like.gain_db,
                residual_db: 20.0 * like.residual / std::f64::consts::LN_10,
            });
        }
    }
    found
}

/// Whether the second is the first on other lines.
pub(super) fn is_resampled<I: Quantity, O: Quantity>(
    one: &TransferFunction<I, O>,
    other: &TransferFunction<I, O>,
) -> bool {
    let found = likeness(one, other);
    found.is_some_and(|like| like.is_noise() && (like.is_exact() || like.noise <= LOW_NOISE))
}

impl<I: Quantity, O: Quantity> Panel<I, O> {
    /// The warnings about participants who may be one, by their responses and by their names.
    pub(super) fn of_same_people(&self) -> Vec<Warning> {
        let responses = self.same_people().iter().map(|found| {
            Warning::from(PanelWarning::SameResponse {
                one: found.one.to_string(),
                other: found.other.to_string(),
                gain_db: found.gain_db,
                residual_db: found.residual_db,
            })
        });
        let participants = self.participants();
        let names = participants.iter().enumerate().filter_map(|(i, other)| {
            let mut earlier = participants[..i].iter();
            let one = earlier.find(|one| plain_name(one) == plain_name(other))?;
            Some(Warning::from(CompareWarning::Mixed {
                how: Mixed::NamesAlike {
                    of: Named::Participant,
                    one: one.clone(),
                    other: other.clone(),
                },
            }))
        });
        responses.chain(names).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::criterion::Outcome;
    use crate::panel::{
        AverageCriterion, Cell, PanelConfig, PanelError, analyse, average_of_panel,
    };
    use crate::quantity::{Acceleration, Band, Degrees, Force, Hertz, Newtons, SampleRate};
    use crate::statistics::random::Random;
    use crate::transfer::{BundleAverage, Estimator};

    type H = TransferFunction<Force, Acceleration>;

    const LINES: usize = 401;
    const STEP_HZ: f64 = 2.5;

    fn band() -> Band {
        Band::new(Hertz(20.0), Hertz(900.0)).unwrap()
    }

    /// The response of a person with two resonances of their own, without noise.
    fn own(random: &mut Random, scatter: f64) -> Vec<Complex<f64>> {
        let mut near = |value: f64| value * (1.0 + scatter * random.normal());
        let modes = [(1.0, 150.0, 2.0), (0.4, 480.0, 4.0)]
            .map(|(gain, hz, quality)| (near(gain), near(hz), near(quality)));
        let lines = (0..LINES).map(|line| {
            let hz = line as f64 * STEP_HZ;
            let of = |(gain, at, quality): (f64, f64, f64)| {
                let r = hz / at;
                gain / Complex::new(1.0 - r * r, r / quality)
            };
            modes.into_iter().map(of).sum::<Complex<f64>>()
        });
        lines.collect()
    }

    fn noisy(lines: &[Complex<f64>], share: f64, random: &mut Random) -> Vec<Complex<f64>> {
        let each = lines.iter().map(|h| {
            let noise = Complex::new(random.normal(), random.normal()) / 2f64.sqrt();
            h * (1.0 + share * noise)
        });
        each.collect()
    }

    fn function(lines: Vec<Complex<f64>>, step_hz: f64) -> H {
        let coherence = vec![0.98; lines.len()];
        let rate = SampleRate::new(2_000.0).unwrap();
        H::from_lines(lines, coherence, step_hz, rate, Estimator::H1, 100).unwrap()
    }

    fn entry(who: &str, repeat: u32, mut function: H) -> Entry<Force, Acceleration> {
        let cell = Cell {
            load_n: Newtons(0.4),
            angle_deg: Degrees(20.0),
        };
        function.about.condition.participant = Some(who.into());
        function.about.condition.load_n = Some(cell.load_n);
        function.about.condition.angle_deg = Some(cell.angle_deg);
        let filing = Filing {
            participant: who.into(),
            cell,
            placement: 1,
            repeat,
        };
        Entry { filing, function }
    }

    /// Lines of `people`, each with two repeats.
    fn people(
        count: usize,
        seed: u64,
        [scatter, noise]: [f64; 2],
    ) -> Vec<Entry<Force, Acceleration>> {
        let mut random = Random::stream(seed, 0, "people");
        let mut entries = Vec::new();
        for who in 1..=count {
            let own = own(&mut random, scatter);
            for repeat in [1, 2] {
                let lines = noisy(&own, noise, &mut random);
                entries.push(entry(
                    &format!("P{who:02}"),
                    repeat,
                    function(lines, STEP_HZ),
                ));
            }
        }
        entries
    }

    fn named(entries: Vec<Entry<Force, Acceleration>>) -> Vec<[String; 2]> {
        let panel = Panel::new(entries).unwrap();
        let of = |found: &SameResponse| {
            [&found.one, &found.other].map(|filing| filing.participant.clone())
        };
        panel.same_people().iter().map(of).collect()
    }

    /// `lines` on a line every `step` of theirs, by straight lines.
    fn resampled(lines: &[Complex<f64>], step: f64) -> Vec<Complex<f64>> {
        let count = ((lines.len() - 1) as f64 / step) as usize + 1;
        let each = (0..count).map(|i| {
            let place = i as f64 * step;
            let low = (place as usize).min(lines.len() - 2);
            let part = place - low as f64;
            lines[low] * (1.0 - part) + lines[low + 1] * part
        });
        each.collect()
    }

    /// `lines`, each with `by` more in its phase.
    fn turned(lines: &[Complex<f64>], by: impl Fn(f64) -> f64) -> Vec<Complex<f64>> {
        let each = lines.iter().enumerate();
        let each = each.map(|(line, h)| h * Complex::from_polar(1.0, by(line as f64)));
        each.collect()
    }

    const USUAL: [f64; 2] = [0.06, 0.01];

    #[test]
    fn the_same_response_under_another_name_is_named() {
        let mut random = Random::stream(5, 0, "copies");
        let first =
            |entries: &[Entry<Force, Acceleration>]| entries[0].function.response().to_vec();
        for count in [2, 6] {
            let honest = people(count, 3, USUAL);
            assert_eq!(named(honest.clone()), Vec::<[String; 2]>::new());
            let lines = first(&honest);
            let times = |gain: f64| lines.iter().map(|h| h * gain).collect::<Vec<_>>();
            let mut ways = vec![
                ("rescaled", times(1.7)),
                ("of the other sign", times(-0.6)),
                ("with 0.3 % noise", noisy(&times(1.1), 0.003, &mut random)),
                ("with 1.5 % noise", noisy(&times(1.1), 0.015, &mut random)),
                ("delayed", turned(&times(1.1), |line| -0.2 * line)),
                ("with other phases", turned(&times(1.1), |line| line * line)),
            ];
            let finer = resampled(&lines, 0.8);
            let mut back = resampled(&finer, 1.25);
            back.resize(LINES, lines[LINES - 1]);
            ways.push(("on other lines and back", back));
            if count > 2 {
                ways.push(("with 10 % noise", noisy(&times(1.1), 0.1, &mut random)));
            }
            for (what, lines) in ways {
                let mut entries = honest.clone();
                entries.push(entry("Q07", 1, function(lines, STEP_HZ)));
                let pairs = named(entries.clone());
                assert_eq!(
                    pairs,
                    [["P01".to_owned(), "Q07".to_owned()]],
                    "{what}, {count}"
                );
                let said = Panel::new(entries).unwrap().warnings[0].to_string();
                assert!(said.contains("P01") && said.contains("Q07 "), "{said}");
            }
            // A part of the band, and rescaled in it.
            let mut cropped = function(times(1.2), STEP_HZ);
            cropped.excited = Band::new(Hertz(100.0), Hertz(600.0)).ok();
            let mut entries = honest.clone();
            entries.push(entry("Q07", 1, cropped));
            assert_eq!(named(entries).len(), 1);
            // On other lines it is no member, and the reason is not its lines alone.
            let mut entries = honest.clone();
            let other = function(resampled(&lines, 0.8), 0.8 * STEP_HZ);
            entries.push(entry("Q07", 1, other));
            let refused = Panel::new(entries).unwrap_err();
            assert!(matches!(refused, PanelError::Resampled { .. }), "{refused}");
        }
        // Somebody else on other lines is refused for these.
        let mut entries = people(3, 3, USUAL);
        let stranger = resampled(&first(&people(1, 9, USUAL)), 0.8);
        entries.push(entry("Q07", 1, function(stranger, 0.8 * STEP_HZ)));
        let refused = Panel::new(entries).unwrap_err();
        assert!(matches!(refused, PanelError::Differ { .. }), "{refused}");
    }

    #[test]
    fn names_of_participants_that_differ_in_case_or_zeros_are_named() {
        let mut entries = people(2, 3, USUAL);
        let stranger = people(1, 9, USUAL).remove(0).function;
        entries.push(entry("p1", 1, stranger));
        let panel = Panel::new(entries).unwrap();
        let said = panel.warnings[0].to_string();
        assert!(
            said.contains("the participants `P01` and `p1` count as two"),
            "{said}"
        );
        assert!(panel.same_people().is_empty());
    }

    /// One person entered as eight, each with a gain and 2 % of noise: nobody else is there to be apart from.
    #[test]
    fn a_panel_of_copies_is_named() {
        let mut random = Random::stream(6, 0, "copies");
        let own = own(&mut random, USUAL[0]);
        let copies = (0..8).map(|i| {
            let gain = 10f64.powf(0.7 * random.normal() / 20.0);
            let lines: Vec<_> = own.iter().map(|h| h * gain).collect();
            let lines = noisy(&lines, 0.02, &mut random);
            entry(&format!("C{i}"), 1, function(lines, STEP_HZ))
        });
        assert_eq!(named(copies.collect()).len(), 7);
    }

    /// Neither alike people, nor noise that hides what they differ by, nor many of them make one person.
    #[test]
    fn different_people_are_not_named() {
        for seed in 0..12 {
            assert_eq!(
                named(people(8, seed, USUAL)),
                Vec::<[String; 2]>::new(),
                "{seed}"
            );
            let noise = people(8, seed, [0.02, 0.3]);
            assert_eq!(named(noise), Vec::<[String; 2]>::new(), "noise, {seed}");
            let alike = people(4, seed, [0.03, 0.01]);
            assert_eq!(named(alike), Vec::<[String; 2]>::new(), "alike, {seed}");
        }
        assert_eq!(named(people(24, 99, USUAL)), Vec::<[String; 2]>::new());
    }

    /// A panel of 100 that suffices, with one of them again: the average is not decided.
    #[test]
    fn an_average_with_somebody_twice_is_not_decided() {
        let honest = people(100, 3, USUAL);
        let cell = honest[0].filing.cell;
        let again = |honest: &[Entry<Force, Acceleration>]| {
            let copy = honest[0].function.clone().times(|_| Complex::from(1.05));
            let mut twice = honest.to_vec();
            twice.push(entry("Q07", 1, copy));
            Panel::new(twice).unwrap()
        };
        let costs = |panel: &Panel<Force, Acceleration>| {
            let averaged = average_of_panel(panel, cell, BundleAverage::LogMagnitude, band());
            averaged.unwrap().costs.unwrap()
        };
        let alone = costs(&Panel::new(honest.clone()).unwrap());
        assert_eq!(alone.verdict.outcome, Outcome::Met, "{:?}", alone.verdict);
        let twice = costs(&again(&honest));
        assert_eq!(twice.verdict.outcome, Outcome::NotDecided);
        let distinct = twice.criterion(AverageCriterion::Distinct).unwrap();
        assert_eq!(distinct.found, Some(100.0 / 101.0));
        let said = twice.conclusion(cell);
        assert!(
            said.contains("participants in it may be one person. Remove"),
            "{said}"
        );
        // The analysis of a panel says the same.
        let small = again(&people(5, 3, USUAL));
        let analysed = analyse(&small, &PanelConfig::usual(band(), 1)).unwrap();
        assert_eq!(analysed.same_people.len(), 1);
        let its = analysed.penalties_at(cell).unwrap();
        assert_eq!(its.verdict.outcome, Outcome::NotDecided);
        assert!(its.criterion(AverageCriterion::Distinct).is_some());
    }
}
