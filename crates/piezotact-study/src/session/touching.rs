//! The trial of touch that is under way: recorded from when the sample was handed over until the trial is confirmed, without its pauses.

use piezotact_people::campaign::session::{Stage, Step, TouchRecord};

use super::{Heard, Played, RunError, Runner, Stimuli, TouchEnd};

/// What is known of the touch of a trial.
pub(super) struct Touching {
    trial: String,
    attempt: u32,
    /// How many parts were begun.
    parts: u32,
    is_listening: bool,
    record: TouchRecord,
    /// Whether it was said that strokes are missing.
    is_said: bool,
}

impl Touching {
    fn of(trial: &str, attempt: u32) -> Self {
        Self {
            trial: trial.to_owned(),
            attempt,
            parts: 0,
            is_listening: false,
            record: TouchRecord {
                strokes: Some(0),
                ..TouchRecord::default()
            },
            is_said: false,
        }
    }

    fn add(&mut self, heard: Heard) {
        self.record.recordings.extend(heard.recording);
        self.record.strokes = self.record.strokes.zip(heard.strokes).map(|(a, b)| a + b);
        if let Some(why) = heard.failed {
            self.fail(why);
        }
    }

    /// What was not recorded cannot be counted.
    fn fail(&mut self, why: String) {
        self.record.not_recorded.get_or_insert(why);
        self.record.strokes = None;
    }
}

impl Runner<'_> {
    /// Begins to record where a sample is being touched, and ends it where it is not any more.
    pub(super) fn follow_touch(&mut self) {
        // Where it is not known what is stored, everything stays as it is.
        if self.unsure.is_some() || self.unstored.is_some() {
            return;
        }
        let state = &self.state;
        let now = state.current().and_then(|(trial, of)| {
            let is_touched = state.strokes_wanted(trial).is_some() && !of.plays.is_empty();
            let sample = state.presented(trial).into_iter().next()?;
            is_touched.then(|| (trial.name.clone(), of.attempts, sample))
        });
        let runs = state.stage() == Stage::Running
            && matches!(state.step(), Step::Answer { .. })
            && !self.is_cut_off();
        let is_same = |touch: &Touching| {
            now.as_ref().is_some_and(|(trial, attempt, _)| {
                touch.trial == *trial && touch.attempt == *attempt
            })
        };
        let is_other = self.touch.as_ref().is_some_and(|touch| !is_same(touch));
        if is_other || !runs {
            self.end_part(TouchEnd::Cut);
        }
        if is_other {
            self.touch = None;
        }
        if let Some((trial, attempt, sample)) = now.filter(|_| runs) {
            self.begin_part(&trial, attempt, &sample);
        }
    }

    fn begin_part(&mut self, trial: &str, attempt: u32, sample: &str) {
        let Stimuli::On(stimulator) = &mut self.stimuli else {
            return;
        };
        let known = self.touch.take();
        let mut touch = known.unwrap_or_else(|| Touching::of(trial, attempt));
        // What failed once is not tried again under the finger.
        if !touch.is_listening && touch.record.not_recorded.is_none() {
            touch.parts += 1;
            let part = Played {
                trial,
                attempt,
                element: 0,
                play: touch.parts,
                stimulus: sample,
            };
            match stimulator.listen(part, &self.outside.stop.touch()) {
                // There are no sensors.
                Ok(false) => return,
                Ok(true) => touch.is_listening = true,
                Err(why) => touch.fail(why),
            }
        }
        self.touch = Some(touch);
    }

    /// Ends the part that is being recorded.
    pub(super) fn end_part(&mut self, end: TouchEnd) {
        let Some(touch) = &mut self.touch else {
            return;
        };
        if !std::mem::take(&mut touch.is_listening) {
            return;
        }
        let heard = match &mut self.stimuli {
            Stimuli::On(stimulator) => stimulator.heard(end),
            Stimuli::ByHand | Stimuli::Nowhere => None,
        };
        match heard {
            Some(heard) => touch.add(heard),
            None => touch.fail("the recording broke down".to_owned()),
        }
    }

    /// What is known of the touch of the trial that is to be confirmed; it ends with this.
    ///
    /// # Errors
    /// That strokes are missing, once: they go on then.
    pub(super) fn touched(&mut self) -> Result<TouchRecord, RunError> {
        if let (Some(touch), Stimuli::On(stimulator)) = (&mut self.touch, &self.stimuli)
            && !touch.is_said
            && let Some(found) = touch.record.strokes.zip(stimulator.strokes())
            && let Some(missing) = self.state.too_few(found.0 + found.1)
        {
            touch.is_said = true;
            return Err(missing.into());
        }
        self.end_part(TouchEnd::Done);
        let touch = self.touch.as_ref();
        Ok(touch.map_or_else(TouchRecord::default, |touch| touch.record.clone()))
    }
}
