//! How many panels meet each claim: a panel is all that one seed draws.

use piezotact::checksum::Checksum;
use piezotact::criterion::{Criterion, Limit, Outcome};
use piezotact::document::Content;
use piezotact::feature::Statistics;
use piezotact::panel::share_interval;
use piezotact::statistics::{mean, standard_deviation};
use piezotact_twin::PARAMETERS;
use serde::{Deserialize, Serialize};

use crate::{CLAIMS, Chapter, ClaimRule, Counting};
use piezotact_volunteers::Laboratory;

/// A claim holds over panels when it does in this share of them.
pub const LEAST_SHARE: f64 = 0.9;
/// Fewer panels decide nothing: of two that hold, half of all panels may not.
pub const LEAST_PANELS: usize = 20;

/// What a panel said of a claim.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PanelFinding {
    /// The claim's number.
    pub claim: u8,
    /// What was measured, with its unit.
    pub measured: String,
    /// What was looked at, and whether it is met.
    pub criteria: Vec<Criterion<ClaimRule>>,
}

/// What a panel said of every claim that can be measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PanelFindings {
    /// What it was drawn with.
    pub seed: u64,
    /// Claim by claim.
    pub findings: Vec<PanelFinding>,
}

impl PanelFindings {
    /// What `chapters`, measured with `seed`, say.
    #[must_use]
    pub fn of(seed: u64, chapters: &[Chapter]) -> Self {
        let findings = chapters.iter().flat_map(|chapter| &chapter.findings);
        Self {
            seed,
            findings: findings
                .filter(|finding| !finding.criteria.is_empty())
                .map(|finding| PanelFinding {
                    claim: finding.claim,
                    measured: finding.measured.clone(),
                    criteria: finding.criteria.clone(),
                })
                .collect(),
        }
    }

    /// How many of its claims hold, and how many were measured; rules about the one panel of a report do not count.
    #[must_use]
    pub fn holding(&self) -> (usize, usize) {
        let holds = |finding: &&PanelFinding| {
            let mut counted = finding.criteria.iter().filter(|c| is_counted(c));
            counted.all(is_met)
        };
        (
            self.findings.iter().filter(holds).count(),
            self.findings.len(),
        )
    }
}

fn is_counted(criterion: &Criterion<ClaimRule>) -> bool {
    criterion.what.counting != Counting::InReportOnly
}

fn is_met(criterion: &Criterion<ClaimRule>) -> bool {
    criterion.outcome == Outcome::Met
}

/// What makes panels comparable: those of different settings are not counted together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct CountSettings {
    /// The version of the program.
    pub program: String,
    /// The checksum of the claims and their criteria.
    pub claims: Checksum,
    /// The checksum of the built-in parameters of the twin.
    pub parameters: Checksum,
    /// What a laboratory's own file changes of them.
    pub changes: Vec<String>,
    /// The seed of the first panel; the others follow it.
    pub seed: u64,
    /// The chapters that are measured.
    pub chapters: Vec<u8>,
}

impl CountSettings {
    /// Those of `replay` over `chapters`.
    #[must_use]
    pub fn of(laboratory: &Laboratory, chapters: &[u8]) -> Self {
        let claims: Vec<String> = CLAIMS.iter().map(|claim| format!("{claim:?}")).collect();
        Self {
            program: env!("CARGO_PKG_VERSION").into(),
            claims: Checksum::of_bytes(claims.join("\n").as_bytes()),
            parameters: Checksum::of_bytes(PARAMETERS.as_bytes()),
            changes: laboratory.parameters.changes().to_vec(),
            seed: laboratory.seed,
            chapters: chapters.to_vec(),
        }
    }

    /// The first setting in which `found` differs.
    fn difference(&self, found: &Self) -> Option<CountError> {
        let listed = |chapters: &[u8]| {
            let numbers: Vec<String> = chapters.iter().map(u8::to_string).collect();
            numbers.join(", ")
        };
        let changes = |changes: &[String]| match changes {
            [] => "none".to_owned(),
            changes => changes.join("; "),
        };
        let pairs = [
            (
                "version of the program",
                self.program.clone(),
                found.program.clone(),
            ),
            ("claims", self.claims.to_string(), found.claims.to_string()),
            (
                "built-in parameters of the twin",
                self.parameters.to_string(),
                found.parameters.to_string(),
            ),
            (
                "changed parameters of the twin",
                changes(&self.changes),
                changes(&found.changes),
            ),
            ("seed", self.seed.to_string(), found.seed.to_string()),
            ("chapters", listed(&self.chapters), listed(&found.chapters)),
        ];
        let (what, expected, found) = pairs.into_iter().find(|(_, a, b)| a != b)?;
        Some(CountError {
            what,
            expected,
            found,
        })
    }
}

/// Panels that were counted with another setting.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("its panels were counted with another setting: {what}: expected {expected}, found {found}")]
pub struct CountError {
    pub what: &'static str,
    /// What is counted now.
    pub expected: String,
    /// What was counted there.
    pub found: String,
}

/// The panels that were measured so far, in the order of their seeds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct CountedPanels {
    /// How.
    pub settings: CountSettings,
    /// What they said.
    pub panels: Vec<PanelFindings>,
}

impl Content for CountedPanels {
    const SCHEMA: &'static str = "replay_panels";
}

impl CountedPanels {
    /// None yet.
    #[must_use]
    pub fn none(settings: CountSettings) -> Self {
        Self {
            settings,
            panels: Vec::new(),
        }
    }

    /// These panels, if they were counted with `settings`.
    ///
    /// # Errors
    /// [`CountError`] naming the first setting that differs.
    pub fn go_on(self, settings: &CountSettings) -> Result<Self, CountError> {
        match settings.difference(&self.settings) {
            Some(error) => Err(error),
            None => Ok(self),
        }
    }

    /// The seeds of `count` panels that are still to be measured.
    #[must_use]
    pub fn missing(&self, count: u64) -> Vec<u64> {
        let known = |seed: &u64| self.panels.iter().any(|panel| panel.seed == *seed);
        let seeds = (0..count).map(|i| self.settings.seed.wrapping_add(i));
        seeds.filter(|seed| !known(seed)).collect()
    }

    /// One more panel; one of the same seed is replaced.
    pub fn add(&mut self, panel: PanelFindings) {
        self.panels.retain(|known| known.seed != panel.seed);
        self.panels.push(panel);
        // Seeds may pass the largest number, and go on from zero.
        let first = self.settings.seed;
        self.panels
            .sort_by_key(|panel| panel.seed.wrapping_sub(first));
    }

    /// How many of the first `count` panels meet each claim.
    #[must_use]
    pub fn counts(&self, count: u64) -> PanelCount {
        let first = self.settings.seed;
        let within: Vec<&PanelFindings> = (self.panels.iter())
            .filter(|panel| panel.seed.wrapping_sub(first) < count)
            .collect();
        PanelCount {
            first_seed: first,
            panels: within.len(),
            claims: CLAIMS
                .iter()
                .filter_map(|claim| claim_count(claim.number, &within))
                .collect(),
        }
    }
}

/// How many panels meet each claim.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PanelCount {
    /// The seed of the first panel.
    pub first_seed: u64,
    /// How many were counted.
    pub panels: usize,
    /// Claim by claim.
    pub claims: Vec<ClaimCount>,
}

/// How many panels meet a claim.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ClaimCount {
    /// Its number.
    pub claim: u8,
    /// In how many panels it holds; where rules count by themselves, the one with the fewest panels.
    pub held: usize,
    /// In how many it was measured.
    pub of: usize,
    /// Which rules are counted together.
    pub decided: Decided,
    /// The share of panels, with its 95 % interval; met at nine in ten, not decided below 20 panels.
    pub share: Criterion<ShareOfPanels>,
    /// What was not met in some panels.
    pub misses: Vec<Miss>,
}

/// Which rules of a claim are counted together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Decided {
    /// All, in one panel.
    Together,
    /// Each by itself.
    EachAlone,
}

/// What is judged: the share of panels in which a claim holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ShareOfPanels {
    /// The share.
    ShareOfPanels,
}

/// A rule that some panels do not meet, and by how much.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Miss {
    /// What is the case where it is not met.
    pub unless_met: String,
    /// In how many panels it is not met.
    pub panels: usize,
    /// The limit.
    pub limit: Limit,
    /// The unit of the limit and of the distances.
    pub unit: String,
    /// The median distance from the limit over these panels; absent where nothing was measured.
    pub usual_margin: Option<f64>,
    /// The smallest.
    pub smallest_margin: Option<f64>,
    /// The largest.
    pub largest_margin: Option<f64>,
    /// The mean of what was found over all panels, those that meet the rule too; absent where nothing was measured.
    pub mean: Option<f64>,
    /// Its standard deviation over these panels; absent for fewer than two.
    pub sd: Option<f64>,
    /// The range of 95 % of what was found: of forty panels all but the lowest and the highest; absent for fewer.
    pub range: Option<[f64; 2]>,
}

fn claim_count(number: u8, panels: &[&PanelFindings]) -> Option<ClaimCount> {
    let of_claim = |panel: &&PanelFindings| -> Option<Vec<Criterion<ClaimRule>>> {
        let found = panel.findings.iter().find(|f| f.claim == number)?;
        Some(
            found
                .criteria
                .iter()
                .filter(|c| is_counted(c))
                .cloned()
                .collect(),
        )
    };
    let measured: Vec<Vec<Criterion<ClaimRule>>> = panels.iter().filter_map(of_claim).collect();
    let rules = measured.iter().map(Vec::len).min()?;
    // A rule keeps its place in every panel; its words may name whom it was not met by.
    let alone = |place: &usize| measured[0][*place].what.counting == Counting::Alone;
    let (each, together): (Vec<usize>, Vec<usize>) = (0..rules).partition(alone);
    let met = |places: &[usize]| {
        let all_met =
            |panel: &&Vec<Criterion<ClaimRule>>| places.iter().all(|k| is_met(&panel[*k]));
        measured.iter().filter(all_met).count()
    };
    let mut held: Vec<usize> = each.iter().map(|place| met(&[*place])).collect();
    if !together.is_empty() {
        held.push(met(&together));
    }
    let held = held.into_iter().min()?;
    Some(ClaimCount {
        claim: number,
        held,
        of: measured.len(),
        decided: match each.is_empty() {
            true => Decided::Together,
            false => Decided::EachAlone,
        },
        // The panels that were counted decide; the interval says what others may give.
        share: of_panels(held, measured.len()),
        misses: (0..rules)
            .filter_map(|place| miss(measured.iter().map(|panel| &panel[place])))
            .collect(),
    })
}

/// The share of panels; not decided for a few.
fn of_panels(held: usize, of: usize) -> Criterion<ShareOfPanels> {
    let share = held as f64 / of as f64;
    let limit = Limit::at_least(LEAST_SHARE);
    let judged = Criterion::new(ShareOfPanels::ShareOfPanels, "", share, None, limit);
    let outcome = match of {
        0..LEAST_PANELS => Outcome::NotDecided,
        _ => judged.outcome,
    };
    Criterion {
        interval: Some(share_interval(held, of)),
        outcome,
        ..judged
    }
}

/// What panels miss of one rule; `None` where all meet it.
fn miss<'a>(rule: impl Iterator<Item = &'a Criterion<ClaimRule>>) -> Option<Miss> {
    let all: Vec<&Criterion<ClaimRule>> = rule.collect();
    let missed: Vec<&&Criterion<ClaimRule>> = all.iter().filter(|c| !is_met(c)).collect();
    let first = missed.first()?;
    // In the words of the first panel, which is that of the report.
    let words = all.first().map_or(&first.what, |panel| &panel.what);
    let mut found: Vec<f64> = all.iter().filter_map(|c| c.found).collect();
    found.sort_by(f64::total_cmp);
    let margins = missed
        .iter()
        .filter_map(|c| Some(distance(c.limit, c.found?)));
    let mut margins: Vec<f64> = margins.collect();
    margins.sort_by(f64::total_cmp);
    Some(Miss {
        unless_met: words.unless_met.clone(),
        panels: missed.len(),
        limit: first.limit,
        unit: first.unit.clone(),
        usual_margin: Statistics::of(&mut margins).map(|margins| margins.median),
        smallest_margin: margins.first().copied(),
        largest_margin: margins.last().copied(),
        mean: (!found.is_empty()).then(|| mean(&found)),
        sd: (found.len() > 1).then(|| standard_deviation(&found)),
        range: middle(&found),
    })
}

/// The lowest and the highest of the middle 95 % of `sorted`.
fn middle(sorted: &[f64]) -> Option<[f64; 2]> {
    let beyond = sorted.len() / 40;
    let within = sorted.get(beyond..sorted.len() - beyond)?;
    match beyond {
        0 => None,
        _ => Some([*within.first()?, *within.last()?]),
    }
}

/// How far `found` is from where `limit` is met.
fn distance(limit: Limit, found: f64) -> f64 {
    match limit {
        Limit::AtMost { met, .. } => found - met,
        Limit::AtLeast { met, .. } => met - found,
        Limit::Within { reach } => found.abs() - reach,
    }
    .max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::claims::{alone, at_least, at_most, in_report_only};
    use piezotact::document::{Document, read};
    use piezotact_twin::TwinParameters;

    fn settings() -> CountSettings {
        let laboratory = Laboratory {
            parameters: TwinParameters::built_in(),
            seed: 5,
        };
        CountSettings::of(&laboratory, &[3, 5])
    }

    fn panel(seed: u64, criteria: Vec<Criterion<ClaimRule>>) -> PanelFindings {
        PanelFindings {
            seed,
            findings: vec![PanelFinding {
                claim: 2,
                measured: "so much".into(),
                criteria,
            }],
        }
    }

    fn counted(panels: Vec<Vec<Criterion<ClaimRule>>>) -> ClaimCount {
        let mut counted = CountedPanels::none(settings());
        let count = panels.len() as u64;
        for (seed, criteria) in (5..).zip(panels) {
            counted.add(panel(seed, criteria));
        }
        counted.counts(count).claims.remove(0)
    }

    /// Nine of ten are enough, eight are not, and a few decide nothing; the distances from the limit are those of the panels that
    /// miss it.
    #[test]
    fn nine_panels_in_ten_decide() {
        let of = |db: f64| vec![at_most(db, 1.0, "dB", "apart")];
        let panels = |count: usize, missed: usize| {
            let db = |i: usize| if i < missed { 1.4 + i as f64 } else { 0.5 };
            counted((0..count).map(|i| of(db(i))).collect())
        };
        let good = panels(20, 2);
        assert_eq!(
            (good.held, good.of, good.share.outcome),
            (18, 20, Outcome::Met)
        );
        assert_eq!(good.misses.len(), 1);
        assert_eq!(panels(20, 3).share.outcome, Outcome::NotMet);
        for (count, missed) in [(2, 0), (19, 0), (19, 19)] {
            let few = panels(count, missed);
            assert_eq!(few.share.outcome, Outcome::NotDecided, "{count}");
        }
        let poor = panels(10, 2);
        assert_eq!(poor.held, 8);
        let miss = &poor.misses[0];
        assert_eq!((miss.panels, miss.unit.as_str()), (2, "dB"));
        assert!((miss.usual_margin.unwrap() - 0.9).abs() < 1e-12);
        assert!((miss.smallest_margin.unwrap() - 0.4).abs() < 1e-12);
        // Eight of 0.5 dB, 1.4 and 2.4 dB.
        assert!((miss.mean.unwrap() - 0.78).abs() < 1e-12);
        assert!((miss.sd.unwrap() - 0.603).abs() < 1e-3);
        assert!((miss.largest_margin.unwrap() - 1.4).abs() < 1e-12);
        // What was not measured is missed, by nobody knows how much.
        let unknown = counted(vec![of(f64::NAN)]);
        assert_eq!((unknown.held, unknown.misses[0].largest_margin), (0, None));
        assert_eq!(unknown.misses[0].mean, None);
    }

    /// Of forty panels the lowest and the highest are left out, of 39 none could be.
    #[test]
    fn the_range_holds_95_percent_of_panels() {
        let of = |count: usize| {
            let values = (0..count).map(|i| vec![at_most(((7 * i) % count) as f64, 0.0, "", "x")]);
            counted(values.collect()).misses.remove(0).range
        };
        assert_eq!(of(39), None);
        assert_eq!(of(40), Some([1.0, 38.0]));
        assert_eq!(of(80), Some([2.0, 77.0]));
    }

    /// Rules that count by themselves may miss in different panels; a rule about the report's panel does not count.
    #[test]
    fn rules_count_together_or_each_by_itself() {
        let both = |a: f64, b: f64, alone_too: bool| {
            let rules = [at_least(a, 0.0, "dB", "a"), at_least(b, 0.0, "dB", "b")];
            let mut rules: Vec<_> = match alone_too {
                true => rules.map(alone).into(),
                false => rules.into(),
            };
            rules.push(in_report_only(at_least(-1.0, 0.0, "dB", "c")));
            rules
        };
        let panels = |alone_too: bool| {
            let of = |i: usize| {
                both(
                    [-1.0, 1.0][usize::from(i > 0)],
                    [1.0, -1.0][usize::from(i == 1)],
                    alone_too,
                )
            };
            counted((0..10).map(of).collect())
        };
        let each = panels(true);
        assert_eq!((each.held, each.decided), (9, Decided::EachAlone));
        assert_eq!(each.misses.len(), 2);
        let together = panels(false);
        assert_eq!((together.held, together.decided), (8, Decided::Together));
    }

    /// What was written is gone on with, and only with the same settings.
    #[test]
    fn other_settings_are_refused_by_name() {
        let mut counted = CountedPanels::none(settings());
        counted.add(panel(6, vec![at_most(1.0, 2.0, "dB", "apart")]));
        assert_eq!(counted.missing(3), [5, 7]);
        let text = serde_json::to_string(&Document::of(&counted)).unwrap();
        let again: CountedPanels = read(&text).unwrap();
        assert_eq!(again.clone().go_on(&settings()).unwrap(), counted);
        type Change = fn(&mut CountSettings);
        let changes: [(Change, &str); 6] = [
            (|s| s.program = "9.9.9".into(), "version of the program"),
            (|s| s.claims = Checksum::of_bytes(b"x"), "claims"),
            (
                |s| s.parameters = Checksum::of_bytes(b"x"),
                "built-in parameters",
            ),
            (
                |s| s.changes.push("hand.yaw_deg".into()),
                "changed parameters of the twin: expected hand.yaw_deg, found none",
            ),
            (|s| s.seed = 7, "seed: expected 7, found 5"),
            (|s| s.chapters = vec![6], "chapters: expected 6, found 3, 5"),
        ];
        for (change, says) in changes {
            let mut other = settings();
            change(&mut other);
            let error = again.clone().go_on(&other).unwrap_err().to_string();
            assert!(error.contains(says), "{error}");
        }
    }
}
