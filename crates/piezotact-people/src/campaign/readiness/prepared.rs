//! The stimuli of a protocol as they are prepared for a participant: how each is made, what level it reached, and whether a session takes it.

use piezotact::criterion::Outcome;
use piezotact::document::Content;
use piezotact::figure::{Axis, Chart, Figure, Line, Mark, Scale, Tone};
use piezotact::page::{Block, Cell, Column, Ending, Page, Section, Shown, Table};
use piezotact::prepare::{PreparedDrives, State};
use piezotact::quantity::Decibels;
use piezotact::verify::VerifyCriterion;
use serde::Serialize;

use super::super::protocol::{Protocol, Stimulus};
use super::{Known, RenderingFacts, stimuli_not_ready};

/// The stimuli of a protocol, prepared for one participant.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PreparedStimuli {
    /// The name of the protocol.
    pub protocol: String,
    /// The drives.
    #[serde(flatten)]
    pub drives: PreparedDrives,
    /// The stimuli by name.
    pub stimuli: Vec<PreparedStimulus>,
}

/// A stimulus, and whether a session takes it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PreparedStimulus {
    /// Its name in the protocol.
    pub stimulus: String,
    /// The sample that it is made from.
    pub of: String,
    /// What is done to its spectrum.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub spectrum: Vec<String>,
    /// The sample whose rms level it has; `1 m/s²` where the protocol states the level.
    pub level_of: String,
    /// The level that was to be reached, dB re the plain stimulus of that sample, or re 1 m/s²; absent where the protocol states a spectrum
    /// alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stated_db: Option<f64>,
    /// The level of its target as it was rendered, m/s² rms.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target_m_s2: Option<f64>,
    /// The level that was measured on the bench, m/s² rms.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured_m_s2: Option<f64>,
    /// The level that was measured on the bench, dB re the plain stimulus of that sample as it was measured there, of a plain one re its
    /// target; absent where one of them was not measured, or no level is stated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured_db: Option<f64>,
    /// How far the measured spectrum is from that of its target, dB rms over the lines; absent where it was not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape_db: Option<f64>,
    /// Whether a session takes it.
    pub ready: Outcome,
    /// Why not, and what to do.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub reasons: Vec<String>,
}

/// The stimuli `wanted` of `protocol` with their `drives` for `participant`, as `known` says what is there.
///
/// Source: docs/decisions/campaigns.md.
#[must_use]
pub fn prepared_stimuli(
    protocol: &Protocol,
    (wanted, participant): (&[Stimulus], &str),
    drives: PreparedDrives,
    known: Known<'_>,
) -> PreparedStimuli {
    let names = wanted.iter().map(|one| one.name.as_str());
    let faults = stimuli_not_ready(protocol, participant, names, known);
    let there = |name: &str| known.renderings.iter().find(|one| one.stimulus == name);
    let stimuli = wanted.iter().map(|stimulus| {
        let reasons = faults
            .iter()
            .filter(|one| one.stimulus() == Some(&stimulus.name));
        let head = format!("{}: ", stimulus.name);
        let reasons =
            reasons
                .map(ToString::to_string)
                .map(|reason| match reason.strip_prefix(&head) {
                    Some(reason) => reason.to_owned(),
                    None => reason,
                });
        let mut reasons: Vec<String> = reasons.collect();
        let own = there(&stimulus.name);
        let drive = drives
            .textures
            .iter()
            .find(|one| one.strokes.texture == stimulus.name);
        if let Some(refused) = drive.filter(|one| {
            own.is_none() && matches!(one.state, State::NotRendered | State::NotMeasured)
        }) {
            reasons = vec![refused.sentence.clone()];
        }
        let target_m_s2 =
            |facts: &RenderingFacts| facts.rms_m_s2() * Decibels(facts.level_db).amplitude_ratio();
        let measured_m_s2 = |facts: &RenderingFacts| {
            Some(target_m_s2(facts) * Decibels(facts.level_error_db?).amplitude_ratio())
        };
        let stated_db = match stimulus.rms_db {
            None => stimulus.states_level().then(|| stimulus.gain_db()),
            stated => stated,
        };
        let is_plain = stimulus.name == stimulus.level_of();
        let re_m_s2 = match stimulus.rms_db {
            Some(_) => Some(1.0),
            // A plain stimulus has its target alone to be compared with.
            None if is_plain => own.map(target_m_s2),
            None => there(stimulus.level_of()).and_then(measured_m_s2),
        };
        let re_m_s2 = re_m_s2.filter(|_| stated_db.is_some());
        let measured_db = (own.and_then(measured_m_s2))
            .zip(re_m_s2)
            .map(|(own, other)| Decibels::from_amplitude_ratio(own / other).0);
        let verification = drive.and_then(|one| one.verification.as_ref());
        let shape = verification.and_then(|one| one.criterion(VerifyCriterion::SpectrumError));
        PreparedStimulus {
            stimulus: stimulus.name.clone(),
            of: stimulus.of.clone(),
            spectrum: stimulus.of_spectrum(),
            level_of: match stimulus.rms_db {
                Some(_) => "1 m/s²".to_owned(),
                None => stimulus.level_of().to_owned(),
            },
            stated_db,
            target_m_s2: own.map(target_m_s2),
            measured_m_s2: own.and_then(measured_m_s2),
            measured_db,
            shape_db: shape.and_then(|one| one.found),
            ready: match (reasons.is_empty(), own) {
                (true, _) => Outcome::Met,
                (false, Some(_)) => Outcome::NotMet,
                (false, None) => Outcome::NotDecided,
            },
            reasons,
        }
    });
    let stimuli: Vec<PreparedStimulus> = stimuli.collect();
    let ready = stimuli.iter().filter(|one| one.ready == Outcome::Met);
    let said = format!(
        "{} of {} stimuli of the protocol {} are ready",
        ready.count(),
        stimuli.len(),
        protocol.name
    );
    // A stimulus whose drive passed may not be what the protocol states.
    let drives = PreparedDrives {
        outcome: Outcome::of_all(stimuli.iter().map(|one| one.ready)),
        sentence: format!("{said}. {}", drives.sentence),
        ..drives
    };
    PreparedStimuli {
        protocol: protocol.name.clone(),
        stimuli,
        drives,
    }
}

impl Content for PreparedStimuli {
    const SCHEMA: &'static str = "prepare_stimuli";
}

impl PreparedStimuli {
    /// One row for each stimulus: what was to be reached, what was measured, and what to do.
    #[must_use]
    pub fn table(&self) -> Table {
        let mut table = Table::new([
            Column::new("stimulus", "stimulus"),
            Column::new("ready", "ready"),
            Column::new("made of", "of"),
            Column::new("level of", "level_of"),
            Column::new("stated, dB", "stated_db"),
            Column::new("measured, dB", "measured_db"),
            Column::new("target, m/s² rms", "target_m_s2"),
            Column::new("measured, m/s² rms", "measured_m_s2"),
            Column::new("shape, dB", "shape_db"),
            Column::new("what to do", "reasons"),
        ]);
        let row = |one: &PreparedStimulus| {
            let mut made = vec![one.of.clone()];
            made.extend(one.spectrum.iter().cloned());
            vec![
                Cell::from(one.stimulus.as_str()),
                Cell::from(match one.ready {
                    Outcome::Met => "yes",
                    Outcome::NotMet => "no",
                    Outcome::NotDecided => "not there",
                }),
                Cell::from(made.join(", ")),
                Cell::from(one.level_of.as_str()),
                Cell::from(one.stated_db),
                Cell::from(one.measured_db),
                Cell::from(one.target_m_s2),
                Cell::from(one.measured_m_s2),
                Cell::from(one.shape_db),
                Cell::from(one.reasons.join("; ")),
            ]
        };
        table.rows = self.stimuli.iter().map(row).collect();
        table
    }

    /// The levels of the targets, and those that were measured (thesis figure 64).
    fn levels(&self) -> Figure {
        // Side by side, so that one does not hide the other.
        let of = |beside: f64, level: fn(&PreparedStimulus) -> Option<f64>| {
            let levels = self.stimuli.iter().enumerate();
            let points = levels.filter_map(|(i, one)| Some((i as f64 + beside, level(one)?)));
            points.collect::<Vec<_>>()
        };
        let targets = of(-0.12, |one| one.target_m_s2);
        let measured = of(0.12, |one| one.measured_m_s2);
        let highest = targets
            .iter()
            .chain(&measured)
            .map(|(_, y)| *y)
            .chain([0.0]);
        let y = Axis::around("level, m/s² rms", Scale::Linear, highest);
        let names = self
            .stimuli
            .iter()
            .map(|one| one.stimulus.clone())
            .collect();
        let lines = vec![
            Line::new("target", Tone::Reference, targets).marked(Mark::Dots),
            Line::new("measured on the bench", Tone::Main, measured).marked(Mark::Dots),
        ];
        Chart::new(Axis::names("stimulus", names), y, lines)
            .captioned("Levels of the stimuli: of the targets as they were rendered, and as they were measured.")
    }
}

impl Shown for PreparedStimuli {
    fn ending(&self) -> Ending {
        let drives = self.drives.ending();
        let outcomes = self.stimuli.iter().map(|one| one.ready);
        match (drives, Outcome::of_all(outcomes)) {
            (Ending::Done, Outcome::NotMet) => Ending::NotPassed,
            (Ending::Done, Outcome::NotDecided) => Ending::NotDecided,
            _ => drives,
        }
    }

    fn page(&self) -> Page {
        let mut page = self.drives.page();
        let section = Section {
            heading: "Stimuli".to_owned(),
            blocks: vec![
                Block::Table(self.table()),
                Block::Figure(self.levels()),
                Block::Note {
                    text: "Stated and measured: the level relative to the plain stimulus of the sample whose level it has, the measured one \
                        from the recordings of both on the bench, of a plain stimulus re its own target; absent where the protocol states a spectrum alone. Shape: how far the measured spectrum is from that of the target, dB rms. \
                        Ready: a session takes it, by the same rules."
                        .to_owned(),
                },
            ],
        };
        page.sections.insert(1.min(page.sections.len()), section);
        page
    }
}
