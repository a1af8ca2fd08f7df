//! `piezotact-validation conclusions`: conclusions against the truth. Studies whose recordings are known to be right, odd or wrong, and what
//! `strokes` and `compare` conclude of them.

#![allow(clippy::print_stdout, reason = "it prints a table")]

mod generator;
mod kinds;
mod truth;

use std::collections::BTreeMap;

use anyhow::{Result, bail, ensure};
use piezotact::discrimination::Model;
use piezotact::quantity::{Band, Hertz};
use piezotact::study::{
    AnalysedRecording, Breadth, Factor, Gesture, Question, Stated, StudyAnalysis, StudySettings,
    analyse, cut,
};
use piezotact::surface::{SampleSet, SurfaceSample};

use super::signal::Draws;
use super::verdicts::in_threads;
use generator::{Made, Plan, Texture, generate};
use kinds::{Is, KINDS, Kind};
use truth::{About, Conclusion, Fact, Truth};

/// The target: the largest share of right conclusions that are withheld.
const MOST_WITHHELD: f64 = 0.05;
/// So many false conclusions of a kind are listed.
const LISTED: usize = 4;

/// What of the benchmark is run.
struct Part {
    textures: Vec<Texture>,
    seeds: Vec<u64>,
    kinds: Vec<&'static Kind>,
    /// The facts that are listed one by one beside those that are false.
    listed: Vec<Fact>,
}

impl Part {
    fn all() -> Self {
        Self {
            textures: Texture::ALL.to_vec(),
            seeds: (1..=5).collect(),
            kinds: KINDS.iter().collect(),
            listed: Vec::new(),
        }
    }

    /// `textures=fine,rough seeds=2 kinds=mains,copies list=withheld`: those whose name holds one of the words; seeds from 1 up to the
    /// number.
    fn of(words: &[&str]) -> Result<Self> {
        let mut part = Self::all();
        for word in words {
            let Some((what, which)) = word.split_once('=') else {
                bail!("expected textures=…, seeds=…, kinds=… or list=withheld, found {word}");
            };
            let asked = |name: &str| which.split(',').any(|which| name.contains(which));
            match what {
                "textures" => part.textures.retain(|texture| asked(texture.name())),
                "seeds" => part.seeds = (1..=which.parse()?).collect(),
                "kinds" => part.kinds.retain(|kind| asked(kind.name)),
                "list" if which == "withheld" => part.listed = vec![Fact::Withheld],
                _ => bail!("expected textures, seeds, kinds or list=withheld, found {word}"),
            }
        }
        Ok(part)
    }
}

/// One study judged.
struct Judged {
    kind: &'static Kind,
    texture: Texture,
    seed: u64,
    conclusions: Vec<Conclusion>,
    /// Why nothing is concluded.
    refused: Option<String>,
}

impl Judged {
    fn of(kind: &'static Kind, texture: Texture, seed: u64) -> Result<Self> {
        let mut draws = Draws::of(seed, &format!("{} {}", kind.name, texture.name()));
        let mut plan = Plan::usual(texture);
        (kind.plan)(&mut plan);
        let mut made = generate(&plan, &mut draws);
        (kind.change)(&mut made, &mut draws);
        let (mut conclusions, mut refused) = (Vec::new(), None);
        match study(&plan, &made)? {
            Ok(study) => {
                conclusions = Truth {
                    made: &made,
                    is: kind.is,
                }
                .of(&study)
            }
            Err(why) => refused = Some(why),
        }
        Ok(Self {
            kind,
            texture,
            seed,
            conclusions,
            refused,
        })
    }

    fn count(&self, about: About, fact: Fact) -> usize {
        let all = self.conclusions.iter();
        all.filter(|one| (one.about, one.fact) == (about, fact))
            .count()
    }
}

/// The study of what was made, or why there is none.
fn study(plan: &Plan, made: &[Made]) -> Result<Result<StudyAnalysis, String>> {
    let mut takes: Vec<AnalysedRecording> = Vec::new();
    for (place, one) in made.iter().enumerate() {
        match cut(one.recorded(place)?, &Stated::nothing()) {
            Ok(take) => takes.push(take),
            Err(error) => return Ok(Err(error.to_string())),
        }
    }
    let several = made.iter().any(|one| one.sample != made[0].sample);
    let settings = StudySettings {
        gesture: Gesture::Usual,
        segment: None,
        sets: vec![set(plan)],
        twin_sets: Vec::new(),
        ridge_m: None,
        question: Question::Changes {
            by: if several {
                Factor::Sample
            } else {
                Factor::Speed
            },
            model: Model::over(Band::new(Hertz(20.0), Hertz(1000.0))?),
        },
        breadth: Breadth::Report,
    };
    Ok(analyse(takes, &settings).map_err(|error| error.to_string()))
}

/// The roughness of the samples, as a person states it.
fn set(plan: &Plan) -> SampleSet {
    let samples = plan.surfaces.iter().map(|surface| SurfaceSample {
        name: surface.name.into(),
        ra_m: Some(surface.ra_m),
        grit: None,
        dot_height_m: None,
        dot_diameter_m: None,
        dot_gap_m: None,
        wavelength_m: None,
        perceptual_category: None,
        hedonistic_category: None,
        judgement: None,
    });
    SampleSet {
        name: "made".into(),
        source: "made".into(),
        material: "none".into(),
        plate_m: [0.05, 0.05, 0.005],
        samples: samples.collect(),
    }
}

fn judge(part: &Part) -> Result<Vec<Judged>> {
    let mut works = Vec::new();
    for kind in &part.kinds {
        for texture in &part.textures {
            works.extend(part.seeds.iter().map(|seed| (*kind, *texture, *seed)));
        }
    }
    in_threads(works.len(), |i| {
        let (kind, texture, seed) = works[i];
        Judged::of(kind, texture, seed)
    })
}

/// Runs the part that `words` name and prints the table.
pub(crate) fn run(words: &[&str]) -> Result<()> {
    let part = Part::of(words)?;
    let judged = judge(&part)?;
    table(&part, &judged);
    offences(&part, &judged);
    let missed = totals(&judged);
    ensure!(missed.is_empty(), "not reached: {}", missed.join("; "));
    println!("  every target is reached");
    Ok(())
}

fn table(part: &Part, judged: &[Judged]) {
    println!(
        "\nV2 conclusions of strokes and compare against the truth of {} studies: said and right/to be said and withheld/false",
        judged.len()
    );
    let about = About::ALL.map(|about| format!("{:>16}", about.name()));
    println!("  {:<38}studies  refused{}", "kind", about.concat());
    for is in [Is::Right, Is::Odd, Is::WrongUnit] {
        for kind in part.kinds.iter().filter(|kind| kind.is == is) {
            let of_kind: Vec<&Judged> = judged
                .iter()
                .filter(|one| one.kind.name == kind.name)
                .collect();
            let cells = About::ALL.map(|about| {
                let [right, withheld, wrong] =
                    [Fact::Right, Fact::Withheld, Fact::False].map(|fact| {
                        of_kind
                            .iter()
                            .map(|one| one.count(about, fact))
                            .sum::<usize>()
                    });
                format!("{:>16}", format!("{right}/{withheld}/{wrong}"))
            });
            let refused = of_kind.iter().filter(|one| one.refused.is_some()).count();
            let name = match is {
                Is::Right => kind.name.to_owned(),
                Is::Odd => format!("odd: {}", kind.name),
                Is::WrongUnit => format!("wrong unit: {}", kind.name),
            };
            println!(
                "  {name:<38}{:>7}  {refused:>7}{}",
                of_kind.len(),
                cells.concat()
            );
        }
    }
}

/// Lists what is false, by kind and what it is about, with how often.
fn offences(part: &Part, judged: &[Judged]) {
    let facts = [Fact::False].into_iter().chain(part.listed.iter().copied());
    for fact in facts {
        let what = if fact == Fact::False {
            "false conclusions"
        } else {
            "withheld"
        };
        let mut found: BTreeMap<(&str, &str), Vec<String>> = BTreeMap::new();
        for one in judged {
            let (texture, seed) = (one.texture.name(), one.seed);
            for conclusion in one.conclusions.iter().filter(|c| c.fact == fact) {
                let of_kind = found
                    .entry((one.kind.name, conclusion.about.name()))
                    .or_default();
                of_kind.push(format!("{texture} {seed}: {conclusion}"));
            }
            if fact == Fact::Withheld && one.kind.is == Is::Right {
                let refused = one
                    .refused
                    .iter()
                    .map(|why| format!("{texture} {seed}: {why}"));
                found
                    .entry((one.kind.name, "refused"))
                    .or_default()
                    .extend(refused);
            }
        }
        found.retain(|_, all| !all.is_empty());
        if found.is_empty() {
            continue;
        }
        println!("\n{what}:");
        for ((kind, about), all) in found {
            println!("  {kind}, {about}: {}", all.len());
            all.iter()
                .take(LISTED)
                .for_each(|one| println!("    {one}"));
        }
    }
}

/// Prints the totals and gives back which targets are missed.
fn totals(judged: &[Judged]) -> Vec<String> {
    let count = |is: Option<Is>, fact: Fact| -> usize {
        let of = judged
            .iter()
            .filter(|one| is.is_none_or(|is| one.kind.is == is));
        let each = of.flat_map(|one| About::ALL.map(|about| one.count(about, fact)));
        each.sum()
    };
    let wrong = count(None, Fact::False);
    let [right, withheld] = [Fact::Right, Fact::Withheld].map(|fact| count(Some(Is::Right), fact));
    let share = withheld as f64 / (right + withheld).max(1) as f64;
    let refused = judged
        .iter()
        .filter(|one| one.kind.is == Is::Right && one.refused.is_some());
    let refused = refused.count();
    let said = count(None, Fact::Right) + wrong;
    println!("\n{} studies", judged.len());
    println!(
        "  false               {wrong:>6} of {said} that are said (to reach 0); {} of them of a wrong unit",
        count(Some(Is::WrongUnit), Fact::False)
    );
    println!(
        "  withheld            {withheld:>6} of {} that have to be said, {:.1} % (to reach {:.0} %)",
        right + withheld,
        100.0 * share,
        100.0 * MOST_WITHHELD
    );
    println!("  refused             {refused:>6} right studies (to reach 0)");
    let missed = [
        (wrong > 0, format!("{wrong} false conclusions")),
        (share > MOST_WITHHELD, format!("{withheld} withheld")),
        (refused > 0, format!("{refused} right studies refused")),
    ];
    let missed = missed.into_iter().filter(|(is, _)| *is);
    missed.map(|(_, what)| what).collect()
}

#[cfg(test)]
mod tests;
