//! Which recordings belong together.

use piezotact::compare::CompareDoubt;
use std::cmp::Ordering;

use anyhow::anyhow;
use piezotact::Doubt;
use piezotact::compare::{
    CommonLine, LinesOf, Periods, Summary, common_lines, set_apart, summarise,
};
use piezotact::recording::Touch;
use piezotact::surface::SampleSet;

use super::Take;
use crate::cli::By;
use crate::failure::{Failure, Outcome, usage};

/// What a recording is grouped by; what is not known is empty.
#[derive(Clone, Debug, Default, PartialEq)]
struct Key {
    sample: String,
    speed: String,
    participant: String,
    touch: String,
    file: String,
}

impl Key {
    fn of(take: &Take) -> Self {
        let condition = take.condition();
        Self {
            sample: condition.sample.clone().unwrap_or_default(),
            // A measured plateau is steady to a mm/s.
            speed: match condition.speed_m_s {
                Some(stated) => speed_text(stated),
                None => speed_m_s(take).map_or(String::new(), |v| format!("{:.0} mm/s", v * 1e3)),
            },
            participant: condition.participant.clone().unwrap_or_default(),
            touch: match condition.touch {
                Some(Touch::Active) => "active".into(),
                Some(Touch::Passive) => "passive".into(),
                Some(Touch::Resting) => "resting".into(),
                None => String::new(),
            },
            file: take.name.clone(),
        }
    }

    fn part(&mut self, by: By) -> &mut String {
        match by {
            By::Sample => &mut self.sample,
            By::Speed => &mut self.speed,
            By::Participant => &mut self.participant,
            By::Touch => &mut self.touch,
            By::File => &mut self.file,
        }
    }

    /// The parts in which the recordings differ, as a person says them.
    fn text(&self, varying: &Self) -> String {
        let parts = [
            (&self.participant, &varying.participant),
            (&self.sample, &varying.sample),
            (&self.speed, &varying.speed),
            (&self.touch, &varying.touch),
        ];
        let known: Vec<&str> = parts
            .into_iter()
            .filter(|(part, varies)| !part.is_empty() && !varies.is_empty())
            .map(|(part, _)| part.as_str())
            .collect();
        known.join(", ")
    }

    /// A key whose parts say something where `keys` differ, and nothing where they all agree.
    fn varying(keys: &[Self]) -> Self {
        let mut varying = Self::default();
        for by in [By::Sample, By::Speed, By::Participant, By::Touch] {
            let mut values = keys.iter().map(|key| key.clone().part(by).clone());
            let first = values.next();
            if values.any(|value| Some(&value) != first.as_ref()) {
                *varying.part(by) = "varies".into();
            }
        }
        varying
    }
}

/// The speed that the recording states, or else the one that was measured.
fn speed_m_s(take: &Take) -> Option<f64> {
    take.condition()
        .speed_m_s
        .or_else(|| take.analysis.as_ref()?.speed_m_s())
}

fn speed_text(speed_m_s: f64) -> String {
    let text = format!("{:.3}", speed_m_s * 1e3);
    format!("{} mm/s", text.trim_end_matches('0').trim_end_matches('.'))
}

/// Recordings that have one value of what they are grouped by, with their strokes taken together.
pub(crate) struct Cell<'a> {
    pub(crate) summary: Summary,
    pub(crate) takes: Vec<&'a Take>,
}

/// Groups that differ in one thing and share all others.
pub(crate) struct Comparison<'a> {
    /// What they share, as a person says it; empty when that is nothing.
    pub(crate) setting: String,
    pub(crate) cells: Vec<Cell<'a>>,
}

/// The recordings grouped by one thing.
pub(crate) fn cells<'a>(
    takes: &'a [Take],
    by: By,
    sets: &[SampleSet],
    ridge_m: Option<f64>,
) -> Outcome<Vec<Cell<'a>>> {
    let analysed: Vec<&Take> = takes
        .iter()
        .filter(|take| take.analysis.is_some())
        .collect();
    for take in &analysed {
        if Key::of(take).part(by).is_empty() {
            return Err(missing(take, by));
        }
    }
    of_takes(&analysed, by, sets, ridge_m, &lines_of_all(takes))
}

/// The lines that all analysed recordings have.
pub(crate) fn lines_of_all(takes: &[Take]) -> Vec<CommonLine> {
    let all: Vec<LinesOf<'_>> = takes
        .iter()
        .filter_map(|take| {
            let analysis = take.analysis.as_ref()?;
            Some(LinesOf {
                sample: take.condition().sample.as_deref()?,
                speed_m_s: speed_m_s(take),
                psd: &analysis.psd,
                band: analysis.config.band,
            })
        })
        .collect();
    common_lines(&all)
}

fn missing(take: &Take, by: By) -> Failure {
    let (what, todo) = match by {
        By::Sample => ("a sample", "{sample}"),
        By::Speed => ("a sliding speed", "{speed:mm/s}"),
        By::Participant => ("a participant", "{participant}"),
        By::Touch => ("active or passive touch", "{touch}"),
        By::File => ("a name", "{sample}"),
    };
    usage(anyhow!(
        "expected {what} for every recording, found none for {}: say it in the file names with --meta and {todo}, or in NAME.wav.json",
        take.name
    ))
}

fn of_takes<'a>(
    takes: &[&'a Take],
    by: By,
    sets: &[SampleSet],
    ridge_m: Option<f64>,
    lines: &[CommonLine],
) -> Outcome<Vec<Cell<'a>>> {
    let mut groups: Vec<(String, Vec<&Take>)> = Vec::new();
    for take in takes {
        let key = Key::of(take).part(by).clone();
        match groups.iter_mut().find(|(other, _)| *other == key) {
            Some((_, members)) => members.push(take),
            None => groups.push((key, vec![take])),
        }
    }
    groups.sort_by(|(a, _), (b, _)| order(a, b, by, sets));
    groups
        .into_iter()
        .map(|(key, takes)| {
            let members: Vec<_> = takes
                .iter()
                .filter_map(|take| Some((take.analysis.as_ref()?, take.condition())))
                .collect();
            let sample = takes
                .first()
                .and_then(|take| take.condition().sample.as_deref());
            let periods = Periods {
                ridge_m,
                texture_m: sample.and_then(|sample| {
                    sets.iter().find_map(|set| set.sample(sample))?.wavelength_m
                }),
            };
            let mut summary = summarise(&key, &members, periods)?;
            set_apart(&mut summary, lines);
            Ok(Cell { summary, takes })
        })
        .collect()
}

/// Every set of recordings that differ in `by` and share all else.
pub(crate) fn comparisons<'a>(
    takes: &'a [Take],
    by: By,
    sets: &[SampleSet],
    ridge_m: Option<f64>,
) -> Outcome<Vec<Comparison<'a>>> {
    // Asks whether all are known.
    cells(takes, by, sets, ridge_m)?;
    // Where active touch has no known speed, speeds do not set active and passive touch apart.
    let mut analysed = takes.iter().filter(|take| take.analysis.is_some());
    let all_speeds = analysed.all(|take| speed_m_s(take).is_some());
    let mut settings: Vec<(Key, Vec<&Take>)> = Vec::new();
    for take in takes.iter().filter(|take| take.analysis.is_some()) {
        let mut key = Key::of(take);
        key.part(by).clear();
        key.file.clear();
        if by == By::Touch && !all_speeds {
            key.speed.clear();
        }
        match settings.iter_mut().find(|(other, _)| *other == key) {
            Some((_, members)) => members.push(take),
            None => settings.push((key, vec![take])),
        }
    }
    settings.sort_by(|(a, _), (b, _)| {
        order(&a.participant, &b.participant, By::Participant, sets)
            .then_with(|| order(&a.sample, &b.sample, By::Sample, sets))
            .then_with(|| order(&a.speed, &b.speed, By::Speed, sets))
            .then_with(|| a.touch.cmp(&b.touch))
    });
    // A recording with nothing to be compared with is no comparison.
    settings.retain(|(_, members)| {
        let values: Vec<String> = members
            .iter()
            .map(|take| Key::of(take).part(by).clone())
            .collect();
        values.iter().any(|value| *value != values[0])
    });
    let keys: Vec<Key> = settings.iter().map(|(key, _)| key.clone()).collect();
    let varying = Key::varying(&keys);
    let lines = lines_of_all(takes);
    settings
        .into_iter()
        .map(|(key, members)| {
            Ok(Comparison {
                setting: key.text(&varying),
                cells: of_takes(&members, by, sets, ridge_m, &lines)?,
            })
        })
        .collect()
}

/// The doubt that some analysed recordings stand in no comparison.
pub(crate) fn left_out(takes: &[Take], compared: &[Comparison<'_>]) -> Option<Doubt> {
    let held = |take: &&Take| {
        let mut all = compared
            .iter()
            .flat_map(|c| &c.cells)
            .flat_map(|cell| &cell.takes);
        all.any(|other| other.path == take.path)
    };
    let names: Vec<&str> = takes
        .iter()
        .filter(|take| take.analysis.is_some())
        .filter(|take| !held(take))
        .map(|take| take.name.as_str())
        .collect();
    (!names.is_empty()).then(|| {
        Doubt::from(CompareDoubt::NotCompared {
            recordings: names.join(", "),
        })
    })
}

/// What else the recordings differ in, for a message.
pub(crate) fn differ_in(takes: &[Take], by: By) -> String {
    let keys: Vec<Key> = takes
        .iter()
        .filter(|t| t.analysis.is_some())
        .map(Key::of)
        .collect();
    let varying = Key::varying(&keys);
    let parts = [
        (By::Sample, &varying.sample, "sample"),
        (By::Speed, &varying.speed, "speed"),
        (By::Participant, &varying.participant, "participant"),
        (By::Touch, &varying.touch, "touch"),
    ];
    let names: Vec<&str> = parts
        .into_iter()
        .filter(|(part, varies, _)| *part != by && !varies.is_empty())
        .map(|(_, _, name)| name)
        .collect();
    names.join(" and ")
}

/// The same samples, touched actively and passively.
#[derive(Default)]
pub(crate) struct BothWays<'a> {
    pub(crate) active: Vec<Cell<'a>>,
    pub(crate) passive: Vec<Cell<'a>>,
}

/// Speeds that differ by no more than this share are compared.
const SAME_SPEED: f64 = 0.1;

/// Whether two recordings differ in nothing that they state but the kind of touch.
fn counterparts(a: &Take, b: &Take) -> bool {
    let (a, b) = (a.condition(), b.condition());
    let people =
        a.participant.is_none() || b.participant.is_none() || a.participant == b.participant;
    let speeds = match (a.speed_m_s, b.speed_m_s) {
        (Some(a), Some(b)) => (a / b - 1.0).abs() <= SAME_SPEED,
        _ => true,
    };
    a.sample == b.sample && people && speeds
}

/// The analysed recordings by sample, those of active and those of passive touch apart, each with a counterpart of the
/// other kind at its speed and by its participant; nothing where a recording names no sample.
pub(crate) fn both_ways<'a>(takes: &'a [Take], sets: &[SampleSet]) -> Outcome<BothWays<'a>> {
    let of = |touch: Touch| -> Vec<&'a Take> {
        takes
            .iter()
            .filter(|take| take.analysis.is_some() && take.condition().sample.is_some())
            .filter(|take| take.condition().touch == Some(touch))
            .collect()
    };
    let (active, passive) = (of(Touch::Active), of(Touch::Passive));
    let with = |takes: &[&'a Take], others: &[&'a Take]| -> Vec<&'a Take> {
        let has = |take: &&&'a Take| others.iter().any(|other| counterparts(take, other));
        takes.iter().filter(has).copied().collect()
    };
    let lines = lines_of_all(takes);
    let by = By::Sample;
    Ok(BothWays {
        active: of_takes(&with(&active, &passive), by, sets, None, &lines)?,
        passive: of_takes(&with(&passive, &active), by, sets, None, &lines)?,
    })
}

/// Samples in the order of their set, all else as people count: S2 before S10, 5 mm/s before 10 mm/s.
fn order(a: &str, b: &str, by: By, sets: &[SampleSet]) -> Ordering {
    let place = |name: &str| {
        let sets = sets.iter().enumerate();
        let mut places = sets.filter_map(|(i, set)| {
            Some((
                i,
                set.samples.iter().position(|sample| sample.name == name)?,
            ))
        });
        places.next()
    };
    match (place(a), place(b)) {
        (Some(a), Some(b)) if by == By::Sample => a.cmp(&b),
        _ => chunks(a).cmp(&chunks(b)),
    }
}

/// A name as text and numbers in turn, so that numbers compare as numbers.
fn chunks(name: &str) -> Vec<(String, u64)> {
    let mut found: Vec<(String, u64)> = vec![(String::new(), 0)];
    let mut counting = false;
    for c in name.chars() {
        let Some((text, value)) = found.last_mut() else {
            continue;
        };
        match c.to_digit(10) {
            Some(digit) => {
                *value = value.saturating_mul(10).saturating_add(u64::from(digit));
                counting = true;
            }
            None if counting => {
                found.push((c.to_string(), 0));
                counting = false;
            }
            None => text.push(c),
        }
    }
    found
}
