//! Where answers come from: a table, or a study.

use std::path::Path;

use anyhow::anyhow;
use piezotact_people::association::{Association, MatrixConfig};
use piezotact_study::{AnswersFile, read_answers};

use crate::commands::campaign::{self, study::Study};
use crate::failure::{Outcome, usage};

/// Answers, and the study that they are of.
pub(super) struct Source {
    pub(super) file: AnswersFile,
    study: Option<Study>,
}

impl Source {
    /// The answers of the table at `path`, with `samples` where any are given, or of the study in this folder.
    pub(super) fn open(path: &Path, samples: &[String]) -> Outcome<Self> {
        if path.is_dir() {
            return Self::of_study(path, samples);
        }
        Ok(Self {
            file: read_answers(path, samples)?,
            study: None,
        })
    }

    fn of_study(path: &Path, samples: &[String]) -> Outcome<Self> {
        use piezotact_people::association::AnswerTable;

        if !samples.is_empty() {
            return Err(usage(anyhow!(
                "the samples of a study are those of its protocol; leave --samples out"
            )));
        }
        let study = Study::open(path)?;
        let (declared, answers) = study.answers()?;
        let table = AnswerTable::new(declared, answers).map_err(|error| {
            let named = anyhow::Error::new(error).context(path.display().to_string());
            crate::failure::Failure::Data(named)
        })?;
        let warnings = study.warnings()?;
        Ok(Self {
            file: AnswersFile { table, warnings },
            study: Some(study),
        })
    }

    /// The tasks of a study in which samples are put in order; a table of answers does not say.
    pub(super) fn orders(&self) -> Vec<String> {
        if let Some(study) = &self.study {
            return study.orders();
        }
        Vec::new()
    }

    /// `config` for these answers, without their own orders.
    pub(super) fn config(&self, config: &MatrixConfig) -> MatrixConfig {
        let mut own = config.clone();
        own.selection.without_tasks = match own.selection.task {
            None => self.orders().into_iter().collect(),
            Some(_) => own.selection.without_tasks,
        };
        own
    }

    /// `found` with what the study asked; which judge answered a simulated one, where that is `judged`.
    pub(super) fn with_study(&self, found: Association, judged: Judged) -> Outcome<Association> {
        if let Some(study) = &self.study {
            let simulated = campaign::simulated_as(study)?;
            let which = match judged {
                Judged::Compared => campaign::which_of(study)?,
                Judged::LeftOut => None,
            };
            return Ok(found.with_study(
                &self.file.table,
                &study.campaign.protocol,
                simulated,
                which,
            ));
        }
        let _a_table_does_not_say = judged;
        Ok(found)
    }
}

/// The report of the study in `folder`: all answers, and the orders.
#[cfg(feature = "web")]
pub(crate) fn report_of(folder: &Path) -> Outcome<String> {
    use piezotact::page::Shown as _;
    use piezotact_people::association::{AssociationConfig, associate};

    let source = Source::open(folder, &[])?;
    let AnswersFile { table, warnings } = &source.file;
    let mut ordering_tasks = source.orders();
    ordering_tasks.retain(|task| table.answers().iter().any(|a| a.task == *task));
    let asked = AssociationConfig {
        matrix: MatrixConfig::default(),
        by: None,
        ordering_tasks,
    };
    let mut found = associate(table, &asked).map_err(anyhow::Error::new)?;
    found.warnings.splice(0..0, warnings.iter().cloned());
    let found = source.with_study(found, Judged::LeftOut)?;
    let found = Association {
        name: crate::report::name(folder),
        ..found
    };
    Ok(piezotact_report::report::html(
        &found.page(),
        &crate::advice::OptionWords,
    )?)
}

/// Whether the judges of a simulated study are compared, which takes seconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Judged {
    Compared,
    LeftOut,
}
