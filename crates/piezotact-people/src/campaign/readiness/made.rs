//! Whether the drive of each stimulus was made as the protocol states it: by its samples and its lineage, never by the name of its file.

use piezotact::lineage::Lineage;

use super::super::protocol::Protocol;
use super::{NotReady, RenderingFacts};

/// Two levels that differ by less are one, dB: protocols state three decimals.
const SAME_LEVEL_DB: f64 = 0.01;

/// What is wrong with how the `drives` of a session were made.
pub(super) fn faults(protocol: &Protocol, drives: &[&RenderingFacts]) -> Vec<NotReady> {
    let found = drives.iter().enumerate().filter_map(|(i, facts)| {
        let made = protocol.made_of(&facts.stimulus)?;
        let is_its_own = |other: &&&RenderingFacts| {
            other.samples == facts.samples && protocol.made_of(&other.stimulus) != Some(made)
        };
        match drives[..i].iter().find(is_its_own) {
            Some(other) => Some(NotReady::SameDrive {
                stimulus: facts.stimulus.clone(),
                file: facts.file.clone(),
                other: other.stimulus.clone(),
                other_file: other.file.clone(),
                todo: todo(made),
            }),
            None => level(made, facts, drives),
        }
    });
    found.collect()
}

/// A level of `facts` that is not the one that the protocol states. That of a rendering counts where the drive to compare with is there.
fn level(
    made @ (sample, level_of, gain_db): (&str, &str, f64),
    facts: &RenderingFacts,
    drives: &[&RenderingFacts],
) -> Option<NotReady> {
    let nothing = Lineage::default();
    let lineage = facts.lineage.as_ref().unwrap_or(&nothing);
    let (of, by_db) = lineage.level();
    let with_level = drives.iter().find(|other| other.stimulus == level_of);
    let rendered_db = with_level.map_or(0.0, |other| facts.level_db - other.level_db);
    let is_of_it = match of {
        None => level_of == sample,
        Some(of) => !is_of_another(&of.source, level_of, drives),
    };
    let is_its_own = of.is_none_or(|of| level_of != sample || of.source == lineage.source);
    if is_of_it && is_its_own && (by_db + rendered_db - gain_db).abs() <= SAME_LEVEL_DB {
        return None;
    }
    let mut found = match of {
        None => words("its own level", by_db),
        Some(of) => words(&format!("the level of {}", of.source), by_db),
    };
    if rendered_db.abs() > SAME_LEVEL_DB {
        found += &format!(", rendered {rendered_db:+.3} dB re {level_of}");
    }
    let expected = match level_of == sample {
        true => words(&format!("the level of {sample} itself"), gain_db),
        false => words(&format!("the level of {level_of}"), gain_db),
    };
    Some(NotReady::Level {
        stimulus: facts.stimulus.clone(),
        expected,
        found,
        file: facts.file.clone(),
        todo: todo(made),
    })
}

/// Whether the recording called `source` is known to be one of another sample than `sample`: by the drives of plain samples.
fn is_of_another(source: &str, sample: &str, drives: &[&RenderingFacts]) -> bool {
    let of_source = |one: &&&RenderingFacts| {
        let lineage = one.lineage.as_ref();
        lineage.is_some_and(|lineage| lineage.source == source && !lineage.is_manipulated())
    };
    let mut known = drives.iter().filter(of_source).peekable();
    known.peek().is_some() && known.all(|one| one.stimulus != sample)
}

fn words(level: &str, by_db: f64) -> String {
    match by_db == 0.0 {
        true => level.to_owned(),
        false => format!("{level} {by_db:+.3} dB"),
    }
}

/// How the drive of a stimulus that is `made` so is made.
fn todo((sample, level_of, gain_db): (&str, &str, f64)) -> String {
    let mut changes = Vec::new();
    if level_of != sample {
        changes.push(format!("the rms of the target of {level_of}"));
    }
    if gain_db != 0.0 {
        changes.push(format!("a gain of {gain_db} dB"));
    }
    match changes.is_empty() {
        true => "prepare all textures of the session by one `piezotact prepare`".to_owned(),
        false => format!(
            "make its texture from the target of {sample} by `piezotact manipulate` with {} into a file of the name of this \
             drive, and prepare all textures of the session by one `piezotact prepare`",
            changes.join(" and ")
        ),
    }
}
