//! The documents of all people, by participant and task.

use std::collections::{BTreeMap, BTreeSet};

use piezotact::Warning;
use piezotact::statistics::{mean, mean_interval};

use super::{ALL_SURFACES, GroupError, PersonChange, PowerLevel, TaskChanges, TaskEpochs};
use crate::eeg::erd::{Mode, Order};
use crate::eeg::person::{Change, EegErd, Electrode};
use crate::eeg::{Bias, EegWarning, EpochsFault, NotCommon};

/// Epochs of different recordings correlate by 0.2 to 0.4, those of a copy by 0.7 to 1.
///
/// Source: docs/decisions/eeg.md.
const ALIKE: f64 = 0.55;

/// Tasks whose numbers of epochs differ by more than this factor give a warning.
const UNEQUAL: f64 = 1.5;

/// The documents, by participant and task.
pub(super) struct People<'a> {
    pub(super) first: &'a EegErd,
    pub(super) participants: Vec<String>,
    pub(super) tasks: Vec<String>,
    pub(super) surfaces: Vec<String>,
    /// Electrodes that all documents have.
    pub(super) channels: Vec<String>,
    /// Those of them whose position is known.
    pub(super) electrodes: Vec<Electrode>,
    by: BTreeMap<(&'a str, &'a str), &'a EegErd>,
    /// All, by participant and task.
    documents: Vec<&'a EegErd>,
}

impl<'a> People<'a> {
    /// The documents, with tasks in the order of `claimed` and then by name, and participants and surfaces by name.
    pub(super) fn of(documents: &'a [EegErd], claimed: &[String]) -> Result<Self, GroupError> {
        let mut by = BTreeMap::<(&str, &str), &EegErd>::new();
        let (mut participants, mut tasks, mut surfaces) =
            (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
        for document in documents {
            let subject = &document.subject;
            let who = pseudonym(&subject.participant);
            participants.insert(who.to_owned());
            tasks.insert(subject.task.clone());
            surfaces.extend(document.surfaces.iter().cloned());
            if let Some(first) = by.insert((who, &subject.task), document) {
                return Err(GroupError::Twice {
                    subject: subject.to_string(),
                    first: first.file.clone(),
                    second: document.file.clone(),
                });
            }
        }
        let documents: Vec<&EegErd> = by.values().copied().collect();
        let participants: Vec<String> = participants.into_iter().collect();
        one_name_each(&participants)?;
        one_name_each(&tasks)?;
        one_name_each(&surfaces)?;
        let named = claimed.iter().filter(|task| tasks.contains(*task));
        let others = tasks.iter().filter(|task| !claimed.contains(task));
        let tasks: Vec<String> = named.chain(others).cloned().collect();
        // One task of several people has no contrast, and means with their intervals.
        let Some(first) = documents.first().filter(|_| documents.len() > 1) else {
            return Err(GroupError::OneDocument {
                found: documents.len(),
            });
        };
        for other in &documents[1..] {
            same(first, other)?;
        }
        for document in &documents {
            let hz = document.config.power.frequencies_hz.len();
            let expected = document.channels.len() * hz * document.times_s.len();
            let lines = document.channels.len() * hz;
            let broken = document
                .maps
                .iter()
                .find(|map| map.decibels.len() != expected || map.baselines_db.len() != lines);
            if let Some(map) = broken {
                return Err(GroupError::Map {
                    file: document.file.clone(),
                    found: map.decibels.len(),
                });
            }
        }
        shared(&documents, &tasks)?;
        no_copies(&documents)?;
        let common = |name: &&String| documents.iter().all(|one| one.channels.contains(name));
        let channels: Vec<String> = first.channels.iter().filter(common).cloned().collect();
        if channels.is_empty() {
            return Err(GroupError::NoElectrode);
        }
        Ok(Self {
            first,
            electrodes: (first.positions.iter())
                .filter(|one| channels.contains(&one.name))
                .cloned()
                .collect(),
            participants,
            tasks,
            surfaces: surfaces.into_iter().collect(),
            channels,
            by,
            documents,
        })
    }

    /// The document of a person and task.
    pub(super) fn get(&self, participant: &str, task: &str) -> Option<&'a EegErd> {
        self.by.get(&(participant, task)).copied()
    }

    /// All pairs of tasks, in their order.
    pub(super) fn pairs(&self) -> Vec<[String; 2]> {
        let later = |i: usize| self.tasks[i + 1..].iter().map(move |b| (i, b));
        let pairs = (0..self.tasks.len()).flat_map(later);
        pairs
            .map(|(i, b)| [self.tasks[i].clone(), b.clone()])
            .collect()
    }

    /// The surfaces whose changes are looked at: each, and the mean of several.
    pub(super) fn surfaces_and_mean(&self) -> Vec<String> {
        let mut all = self.surfaces.clone();
        if all.len() > 1 {
            all.push(ALL_SURFACES.to_owned());
        }
        all
    }

    /// The changes of all people by task, surface, region and band.
    pub(super) fn changes(&self, unit: Mode) -> Vec<TaskChanges> {
        let mut all = Vec::new();
        for band in &self.first.config.bands {
            for region in &self.first.config.regions {
                for surface in self.surfaces_and_mean() {
                    for task in &self.tasks {
                        let people = self.participants.iter().filter_map(|participant| {
                            let document = self.get(participant, task)?;
                            let own = |value: &dyn Fn(&Change) -> f64| {
                                let found = self.of_document(&document.regions, value, |change| {
                                    change.place == region.name && change.band == band.name
                                });
                                let mut own = found.into_iter();
                                own.find(|(name, _)| *name == surface).map(|(_, own)| own)
                            };
                            Some(PersonChange {
                                participant: participant.clone(),
                                change: own(&|change| change.value(unit))?,
                                baseline_db: own(&Change::baseline_db)?,
                                window_db: own(&Change::window_db)?,
                            })
                        });
                        let people: Vec<PersonChange> = people.collect();
                        if !people.is_empty() {
                            all.push(of_task(task, &surface, (&region.name, &band.name), people));
                        }
                    }
                }
            }
        }
        all
    }

    /// What `value` gives of the chosen changes of a document by surface, and the mean where it has all surfaces.
    pub(super) fn of_document(
        &self,
        changes: &[Change],
        value: &dyn Fn(&Change) -> f64,
        chosen: impl Fn(&Change) -> bool,
    ) -> Vec<(String, f64)> {
        let own = changes.iter().filter(|change| chosen(change));
        let mut found: Vec<(String, f64)> = own
            .map(|change| (change.surface.clone(), value(change)))
            .collect();
        if self.surfaces.len() > 1 && found.len() == self.surfaces.len() {
            let values: Vec<f64> = found.iter().map(|(_, value)| *value).collect();
            found.push((ALL_SURFACES.to_owned(), mean(&values)));
        }
        found
    }

    /// What to know of the documents.
    pub(super) fn warnings(&self) -> Vec<Warning> {
        let documents = &self.documents;
        let epochs = self.epochs();
        let unequal = unequal(&epochs).map(unequal_warning);
        let unequal = unequal.or_else(|| self.unequal_in_one());
        let mut warnings: Vec<Warning> = unequal.into_iter().collect();
        let incomplete: Vec<String> = self
            .participants
            .iter()
            .filter(|who| self.tasks.iter().any(|task| self.get(who, task).is_none()))
            .cloned()
            .collect();
        if !incomplete.is_empty() {
            warnings.push(
                EegWarning::NotCommon {
                    names: incomplete.join(", "),
                    what: NotCommon::Tasks {
                        people: incomplete.len(),
                        of: self.participants.len(),
                    },
                }
                .into(),
            );
        }
        let lacking = documents
            .iter()
            .filter(|one| one.surfaces.len() < self.surfaces.len());
        let lacking: Vec<String> = lacking
            .map(|one| {
                let missing = self.surfaces.iter();
                let missing = missing.filter(|surface| !one.surfaces.contains(*surface));
                let missing: Vec<&str> = missing.map(String::as_str).collect();
                format!("{} lacks {}", one.subject, missing.join(", "))
            })
            .collect();
        if !lacking.is_empty() {
            let names = lacking.join("; ");
            warnings.push(
                EegWarning::NotCommon {
                    names,
                    what: NotCommon::Surfaces,
                }
                .into(),
            );
        }
        let mut left_out: Vec<&String> = documents
            .iter()
            .flat_map(|one| &one.channels)
            .filter(|name| !self.channels.contains(name))
            .collect();
        left_out.sort();
        left_out.dedup();
        if !left_out.is_empty() {
            let named = left_out.into_iter().map(|name| {
                let without = documents.iter().filter(|one| !one.channels.contains(name));
                let whose: Vec<String> = without.map(|one| one.subject.to_string()).collect();
                format!("{name} (not of {})", some_of(&whose))
            });
            let names: Vec<String> = named.collect();
            warnings.push(
                EegWarning::NotCommon {
                    names: names.join(", "),
                    what: NotCommon::Electrodes {
                        kept: self.channels.len(),
                    },
                }
                .into(),
            );
        }
        if self.first.config.order == Order::PercentOfEachEpoch {
            let worst = documents.iter().flat_map(|one| &one.electrodes);
            let worst = worst.max_by(|a, b| a.bias_points.total_cmp(&b.bias_points));
            warnings.extend(worst.map(|worst| {
                Warning::from(EegWarning::Biased {
                    channel: worst.place.clone(),
                    epochs: worst.epochs,
                    by: Bias::EachEpoch {
                        bias_points: worst.bias_points,
                    },
                })
            }));
        }
        warnings.extend(self.of_documents());
        warnings
    }

    /// The warnings of the documents, each once with those whom it is about; of biased baselines the worst.
    fn of_documents(&self) -> Vec<Warning> {
        let mut found: Vec<(Warning, Vec<String>)> = Vec::new();
        let mut worst: Option<(f64, Warning, String)> = None;
        for document in &self.documents {
            let who = document.subject.to_string();
            let biased = document.ratio_bias().zip(document.most_biased());
            if let Some((warning, change)) = &biased
                && worst
                    .as_ref()
                    .is_none_or(|(most, ..)| change.bias_points > *most)
            {
                worst = Some((change.bias_points, warning.clone(), who.clone()));
            }
            let own = biased.map(|(warning, _)| warning);
            for warning in document
                .warnings
                .iter()
                .filter(|one| Some(*one) != own.as_ref())
            {
                match found.iter_mut().find(|(known, _)| known == warning) {
                    Some((_, whom)) if whom.last() == Some(&who) => {}
                    Some((_, whom)) => whom.push(who.clone()),
                    None => found.push((warning.clone(), vec![who.clone()])),
                }
            }
        }
        let all = self.documents.len();
        let named = |(warning, whom): (Warning, Vec<String>)| match whom.len() == all {
            true => warning,
            false => EegWarning::OfPeople {
                names: some_of(&whom),
                warning,
            }
            .into(),
        };
        let worst = worst.map(|(_, warning, who)| (warning, vec![who]));
        found.into_iter().chain(worst).map(named).collect()
    }
}

/// So many names are written out.
const NAMED: usize = 6;

/// The first of `names`, and how many others there are.
fn some_of(names: &[String]) -> String {
    match names.len().saturating_sub(NAMED) {
        0 => names.join("; "),
        others => format!("{}; and {others} more", names[..NAMED].join("; ")),
    }
}

impl People<'_> {
    /// The numbers of epochs of each task.
    pub(super) fn epochs(&self) -> Vec<TaskEpochs> {
        let of = |task: &String| {
            let own = self
                .documents
                .iter()
                .filter(|one| one.subject.task == *task);
            counted(
                task.clone(),
                &own.flat_map(|one| kept(one)).collect::<Vec<_>>(),
            )
        };
        self.tasks.iter().filter_map(of).collect()
    }

    /// A warning about the person whose tasks have the most different numbers of epochs, where they are quite different.
    fn unequal_in_one(&self) -> Option<Warning> {
        let of = |who: &String| {
            let own = self.tasks.iter().filter_map(|task| {
                let document = self.get(who, task)?;
                counted(format!("{task} of {who}"), &kept(document))
            });
            let own: Vec<TaskEpochs> = own.collect();
            let [most, fewest] = unequal(&own)?;
            Some((most.mean / fewest.mean, unequal_warning([most, fewest])))
        };
        let all = self.participants.iter().filter_map(of);
        let worst = all.max_by(|a, b| a.0.total_cmp(&b.0));
        worst.map(|(_, warning)| warning)
    }
}

/// The number of epochs of a document on each surface.
fn kept(document: &EegErd) -> Vec<usize> {
    let of = |surface: &String| {
        let mut own = document.electrodes.iter();
        let own = own.find(|change| change.surface == *surface)?;
        Some(own.epochs)
    };
    document.surfaces.iter().filter_map(of).collect()
}

/// The numbers of epochs of what is called `task`; none without a number.
fn counted(task: String, counts: &[usize]) -> Option<TaskEpochs> {
    let as_numbers: Vec<f64> = counts.iter().map(|count| *count as f64).collect();
    Some(TaskEpochs {
        task,
        fewest: *counts.iter().min()?,
        most: *counts.iter().max()?,
        mean: mean(&as_numbers),
    })
}

/// The tasks with the most and the fewest epochs, where they are quite different.
pub(super) fn unequal(epochs: &[TaskEpochs]) -> Option<[&TaskEpochs; 2]> {
    let most = epochs.iter().max_by(|a, b| a.mean.total_cmp(&b.mean))?;
    let fewest = epochs.iter().min_by(|a, b| a.mean.total_cmp(&b.mean))?;
    (most.mean > UNEQUAL * fewest.mean).then_some([most, fewest])
}

fn unequal_warning([most, fewest]: [&TaskEpochs; 2]) -> Warning {
    EegWarning::Epochs {
        fault: EpochsFault::Unequal {
            most: most.task.clone(),
            most_epochs: most.mean,
            fewest: fewest.task.clone(),
            fewest_epochs: fewest.mean,
        },
    }
    .into()
}

/// A participant without the prefix that BIDS puts before a label.
fn pseudonym(participant: &str) -> &str {
    participant.strip_prefix("sub-").unwrap_or(participant)
}

/// Refuses two names that may be those of one person: `P1` and `p01`.
fn one_name_each<'n>(names: impl IntoIterator<Item = &'n String>) -> Result<(), GroupError> {
    let mut seen = BTreeMap::<String, &String>::new();
    for name in names {
        let mut plain = String::new();
        for sign in name.chars().filter(|sign| sign.is_alphanumeric()) {
            // A zero behind another digit counts.
            let counts = sign != '0' || plain.ends_with(|last: char| last.is_ascii_digit());
            plain.extend(
                counts
                    .then_some(sign)
                    .into_iter()
                    .flat_map(char::to_lowercase),
            );
        }
        if let Some(first) = seen.insert(plain, name) {
            return Err(GroupError::AlmostTwice {
                first: first.clone(),
                second: name.clone(),
            });
        }
    }
    Ok(())
}

/// Refuses a recording that is there under two names: with the same numbers, or with another reference, scale, noise, or epochs of its own.
fn no_copies(documents: &[&EegErd]) -> Result<(), GroupError> {
    for (i, one) in documents.iter().enumerate() {
        for other in &documents[..i] {
            let named = |of: &EegErd| format!("{} ({})", of.file, of.subject);
            let likeness = one.trace.likeness(&other.trace);
            if likeness > ALIKE {
                return Err(GroupError::Copy {
                    first: named(other),
                    second: named(one),
                    likeness,
                });
            }
        }
    }
    Ok(())
}

fn of_task(
    task: &str,
    surface: &str,
    (region, band): (&str, &str),
    people: Vec<PersonChange>,
) -> TaskChanges {
    let values: Vec<f64> = people.iter().map(|one| one.change).collect();
    let level = |of: &dyn Fn(&PersonChange) -> f64| {
        let levels: Vec<f64> = people.iter().map(of).collect();
        PowerLevel::of(&levels)
    };
    TaskChanges {
        baseline: level(&|one| one.baseline_db),
        window: level(&|one| one.window_db),
        task: task.to_owned(),
        surface: surface.to_owned(),
        region: region.to_owned(),
        band: band.to_owned(),
        people,
        mean: mean(&values),
        interval: mean_interval(&values),
    }
}

/// Refuses documents that were made with other settings.
fn same(first: &EegErd, other: &EegErd) -> Result<(), GroupError> {
    let (a, b) = (&first.config, &other.config);
    let (p, q) = (&first.preparation, &other.preparation);
    let what = [
        (a.baseline_s != b.baseline_s, "baseline"),
        (a.window_s != b.window_s, "window"),
        (a.bands != b.bands, "bands"),
        (
            a.regions != b.regions,
            "regions (interpolate electrodes that a person lacks)",
        ),
        (a.order != b.order, "order of averages"),
        (
            a.power.frequencies_hz != b.power.frequencies_hz || a.power.cycles != b.power.cycles,
            "frequencies and cycles",
        ),
        (p.filters != q.filters, "filters"),
        (p.reference != q.reference, "reference"),
        (p.extent != q.extent, "extent of epochs"),
        (p.criteria != q.criteria, "criteria of rejection"),
        (
            p.eog.is_empty() != q.eog.is_empty(),
            "removal of eye movements",
        ),
        (
            !same_times(&first.times_s, &other.times_s),
            "times of the maps",
        ),
    ];
    match what.iter().find(|(differs, _)| *differs) {
        None => Ok(()),
        Some((_, what)) => Err(GroupError::Settings {
            what: (*what).to_owned(),
            first: format!("{} ({})", first.file, first.subject),
            second: format!("{} ({})", other.file, other.subject),
        }),
    }
}

fn same_times(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6)
}

/// Refuses tasks of which no two share a surface: nothing in them can be compared.
fn shared(documents: &[&EegErd], tasks: &[String]) -> Result<(), GroupError> {
    let of = |task: &String| -> BTreeSet<&str> {
        let own = documents.iter().filter(|one| one.subject.task == *task);
        own.flat_map(|one| one.surfaces.iter().map(String::as_str))
            .collect()
    };
    let all: Vec<BTreeSet<&str>> = tasks.iter().map(of).collect();
    let shares = |at: usize| {
        all[at + 1..]
            .iter()
            .any(|other| !all[at].is_disjoint(other))
    };
    if all.len() < 2 || (0..all.len()).any(shares) {
        return Ok(());
    }
    let each = tasks.iter().zip(&all).map(|(task, surfaces)| {
        let surfaces: Vec<&str> = surfaces.iter().copied().collect();
        format!("{task}: {}", surfaces.join(", "))
    });
    Err(GroupError::NoSurface {
        found: each.collect::<Vec<_>>().join("; "),
    })
}
