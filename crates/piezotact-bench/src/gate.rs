//! The gate: quality checks during a characterisation. A measurement whose force departs from the target load, or whose coherence
//! falls too low, is stopped at once and repeated.

use crate::DeviceError;
use piezotact::criterion::{Criterion, Limit, Outcome};
use piezotact::quantity::{Acceleration, Drive, Hertz, Newtons, SampleRate, Seconds};
use piezotact::recording::Recording;
use piezotact::run::{Judged, RunChunk, RunCriterion, RunDocument, Sink, SinkError};
use piezotact::spectrum::WelchConfig;
use piezotact::statistics::mean;
use piezotact::transfer::{CrossPlan, CrossSpectra};

use crate::error::ProcedureError;
#[cfg(test)]
use crate::error::Refusal;

/// Below this frequency devices of this kind do not respond, and low coherence is not reported.
pub const LOWEST_JUDGED: Hertz = Hertz(20.0);

/// The limits that a characterisation must keep.
#[derive(Clone, Debug, PartialEq)]
pub struct GateConfig {
    /// The largest departure of the mean force of a window from its target, as a share of the target.
    pub force_share: f64,
    /// The least median coherence of the excited lines of a window.
    pub least_coherence: f64,
    /// The length of a window.
    pub window: Seconds,
}

impl GateConfig {
    /// ±10 % of the load and a coherence of 0.9, over windows of 10 s.
    #[must_use]
    pub fn usual() -> Self {
        Self {
            force_share: 0.1,
            least_coherence: 0.9,
            window: Seconds(10.0),
        }
    }
}

/// The indices in a chunk of the channels that a gate judges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GateRoles {
    pub drive: usize,
    pub acceleration: usize,
    /// The normal force; without one, coherence alone is judged.
    pub force: Option<usize>,
}

/// Judges the chunks of one run, window by window, as a sink of its documents.
#[derive(Debug)]
pub struct Gate {
    config: GateConfig,
    target: Option<Newtons>,
    rate: SampleRate,
    plan: CrossPlan,
    roles: GateRoles,
    window: [Vec<f64>; 3],
    /// Samples before the window.
    before: usize,
    /// The number of samples of the run; later samples are rest and not judged.
    run: usize,
    /// Whether the whole run was judged, or a part of it was refused.
    done: bool,
    /// For each criterion the worst window so far.
    worst: Vec<Criterion<RunCriterion>>,
}

impl Gate {
    /// A gate for a run of `run` samples at `rate` at a load of `target`, whose coherence is estimated with segments of
    /// `segment` samples.
    ///
    /// # Errors
    /// [`DeviceError::Impossible`] when a window does not hold five segments.
    pub fn new(
        config: &GateConfig,
        target: Option<Newtons>,
        rate: SampleRate,
        roles: GateRoles,
        run: usize,
        segment: usize,
    ) -> Result<Self, ProcedureError> {
        let welch = WelchConfig::hann(segment);
        let plan = CrossPlan::new(&welch, rate).ok();
        let holds = rate.samples_in(config.window) / segment.max(1);
        match plan {
            Some(plan) if holds >= 5 => Ok(Self {
                config: config.clone(),
                target,
                rate,
                plan,
                roles,
                window: Default::default(),
                before: 0,
                run,
                done: false,
                worst: Vec::new(),
            }),
            _ => Err(ProcedureError::Device(DeviceError::Impossible {
                expected: format!(
                    "segments so short that five fit into the {} that the gate evaluates",
                    config.window
                ),
                found: segment.to_string(),
                todo: "use shorter segments, 2048 is usual at 5 kHz, or turn the gate off".into(),
            })),
        }
    }

    /// Judges every window as it fills, and the remainder at the end of the run if it is at least half a window. Of
    /// several windows in one chunk the first that is not met is returned, otherwise the last.
    fn admit(&mut self, chunk: &RunChunk) -> Option<Judged> {
        let GateRoles {
            drive,
            acceleration,
            force,
        } = self.roles;
        let channels = [Some(drive), Some(acceleration), force];
        for (window, place) in self.window.iter_mut().zip(channels) {
            let channel = place.and_then(|place| chunk.channels.get(place));
            window.extend(channel.into_iter().flatten());
        }
        let length = self.rate.samples_in(self.config.window);
        let mut found = None;
        while !self.done && self.window[0].len() >= length {
            found = self.judge(length).or(found);
            self.done = found.as_ref().is_some_and(not_met);
        }
        if !self.done && self.before + self.window[0].len() >= self.run {
            found = self.finish().or(found);
        }
        found
    }

    /// The judgement of the whole run so far: for each criterion the worst window. `recording` is judged if no document of
    /// its run was received, as for a recording that was stored earlier.
    pub(crate) fn judged_of(&mut self, recording: &Recording) -> Judged {
        if self.before == 0 {
            let channels = recording.channels().iter();
            let _last = self.admit(&RunChunk {
                channels: channels.map(|channel| channel.samples.clone()).collect(),
                ..RunChunk::default()
            });
        }
        Judged {
            window_s: [0.0, self.before as f64 / self.rate.hz()],
            target_n: self.target.map(|Newtons(target_n)| target_n),
            criteria: self.worst.clone(),
        }
    }

    /// Judges the remainder at the end if it is at least half a window.
    fn finish(&mut self) -> Option<Judged> {
        self.done = true;
        let left = self
            .run
            .saturating_sub(self.before)
            .min(self.window[0].len());
        if 2 * left >= self.rate.samples_in(self.config.window) || self.before == 0 {
            return self.judge(left);
        }
        None
    }

    fn judge(&mut self, length: usize) -> Option<Judged> {
        let judged = self.window_judged(length)?;
        for new in &judged.criteria {
            match self.worst.iter_mut().find(|known| known.what == new.what) {
                Some(known) if severity(new) > severity(known) => *known = new.clone(),
                Some(_) => {}
                None => self.worst.push(new.clone()),
            }
        }
        Some(judged)
    }

    fn window_judged(&mut self, length: usize) -> Option<Judged> {
        let parts: [Vec<f64>; 3] = self
            .window
            .each_mut()
            .map(|channel| channel.drain(..length.min(channel.len())).collect());
        let [drive, acceleration, force] = parts;
        let window_s = [self.before, self.before + length].map(|at| at as f64 / self.rate.hz());
        self.before += length;
        if length == 0 {
            return None;
        }
        let mut judged = Judged {
            window_s,
            target_n: self.target.map(|Newtons(target_n)| target_n),
            criteria: Vec::new(),
        };
        if let Some(target_n) = judged.target_n.filter(|_| self.roles.force.is_some()) {
            judged.criteria.push(Criterion::new(
                RunCriterion::Force,
                "",
                mean(&force) / target_n - 1.0,
                None,
                Limit::Within {
                    reach: self.config.force_share,
                },
            ));
            if not_met(&judged) {
                return Some(judged);
            }
        }
        let spectra: Result<CrossSpectra<Drive, Acceleration>, _> =
            self.plan.estimate(&drive, &acceleration);
        // A window shorter than a segment cannot be judged, nor can a sweep that is still below the frequencies to which the
        // device responds.
        let median = spectra
            .ok()
            .and_then(|spectra| spectra.excited_coherence(LOWEST_JUDGED));
        let limit = Limit::at_least(self.config.least_coherence);
        judged.criteria.push(match median {
            Some(median) => Criterion::new(RunCriterion::Coherence, "", median, None, limit),
            None => Criterion::unmeasured(RunCriterion::Coherence, "", limit),
        });
        Some(judged)
    }
}

/// How far a criterion is from being met, to compare windows by: first its outcome, then what was found.
fn severity(criterion: &Criterion<RunCriterion>) -> (u8, f64) {
    let outcome = match criterion.outcome {
        Outcome::Met => 0,
        Outcome::NotDecided => 1,
        Outcome::NotMet => 2,
    };
    let found = criterion.found.unwrap_or(f64::NEG_INFINITY);
    let beyond = match criterion.limit {
        Limit::AtMost { .. } => found,
        Limit::AtLeast { .. } => -found,
        Limit::Within { .. } => found.abs(),
    };
    (outcome, beyond)
}

fn not_met(judged: &Judged) -> bool {
    judged.outcome() == Outcome::NotMet
}

impl Sink for Gate {
    fn take(&mut self, document: &RunDocument) -> Result<Option<Judged>, SinkError> {
        Ok(match document {
            RunDocument::Chunk(chunk) if !self.done => self.admit(chunk),
            _ => None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE_HZ: f64 = 1_000.0;
    const ROLES: GateRoles = GateRoles {
        drive: 0,
        acceleration: 1,
        force: Some(2),
    };

    /// Chunks of a second: drive, acceleration and force, the last two as `answer` and `force_n` make them of the drive and
    /// of the second.
    fn run(
        seconds: usize,
        answer: impl Fn(usize, f64) -> f64,
        force_n: impl Fn(usize) -> f64,
    ) -> (Gate, Option<Refusal>) {
        let mut random = crate::random::Random::stream(1, 1, "gate");
        let rate = SampleRate::new(RATE_HZ).unwrap();
        let target = Some(Newtons(0.2));
        let mut gate = Gate::new(
            &GateConfig::usual(),
            target,
            rate,
            ROLES,
            seconds * 1_000,
            128,
        )
        .unwrap();
        for second in 0..seconds {
            let drive: Vec<f64> = (0..1_000).map(|_| random.normal()).collect();
            let acceleration = drive
                .iter()
                .map(|x| answer(second, *x) + 0.01 * random.normal())
                .collect();
            let chunk = RunChunk {
                channels: vec![drive, acceleration, vec![force_n(second); 1_000]],
                ..RunChunk::default()
            };
            let judged = gate.take(&RunDocument::Chunk(chunk)).unwrap();
            if let Some(judged) = judged.filter(not_met) {
                return (gate, Some(Refusal(judged)));
            }
        }
        (gate, None)
    }

    #[test]
    fn a_steady_run_passes() {
        assert_eq!(run(25, |_, x| x, |_| 0.21).1, None);
    }

    #[test]
    fn of_each_rule_the_worst_window_is_kept() {
        let (gate, refusal) = run(30, |_, x| x, |second| [0.2, 0.215, 0.19][second / 10]);
        assert_eq!(refusal, None);
        assert_eq!(gate.worst.len(), 2);
        assert!((gate.worst[0].found.unwrap() - 0.075).abs() < 1e-12);
        assert_eq!(gate.before, 30_000);
    }

    #[test]
    fn a_force_that_leaves_its_target_ends_the_run_there() {
        let (gate, refusal) = run(60, |_, x| x, |second| if second < 20 { 0.2 } else { 0.25 });
        let refusal = refusal.unwrap();
        let [force] = &refusal.0.criteria[..] else {
            panic!("{refusal:?}")
        };
        assert_eq!(refusal.0.window_s, [20.0, 30.0]);
        assert_eq!(force.what, RunCriterion::Force);
        assert!((force.found.unwrap() - 0.25).abs() < 1e-12);
        assert_eq!(gate.before, 30_000);
        let said = refusal.to_string();
        assert!(
            said.contains("0.250 N from 20 to 30 s") && said.contains("0.2 N ± 10 %"),
            "{said}"
        );
    }

    #[test]
    fn a_finger_that_lifts_ends_the_run() {
        let (_, refusal) = run(60, |second, x| if second < 10 { x } else { 0.0 }, |_| 0.2);
        let judged = refusal.unwrap().0;
        assert_eq!(judged.window_s, [10.0, 20.0]);
        let outcomes: Vec<_> = judged
            .criteria
            .iter()
            .map(|c| (c.what, c.outcome))
            .collect();
        assert_eq!(
            outcomes,
            [
                (RunCriterion::Force, Outcome::Met),
                (RunCriterion::Coherence, Outcome::NotMet)
            ]
        );
    }

    /// Shorter than a window: judged at the end all the same; a short rest is not judged.
    #[test]
    fn what_is_left_at_the_end_is_judged_when_it_is_long_enough() {
        assert!(run(6, |_, x| x, |_| 0.3).1.is_some());
        let lifted = |seconds| {
            run(
                seconds,
                |_, x| x,
                |second| if second < 10 { 0.2 } else { 0.3 },
            )
        };
        assert!(lifted(14).1.is_none());
        assert!(lifted(16).1.is_some());
    }

    /// Without a force, coherence is judged all the same, and no load is missed that nobody measured.
    #[test]
    fn without_a_force_the_finger_is_judged_by_coherence() {
        let roles = GateRoles {
            force: None,
            ..ROLES
        };
        let rate = SampleRate::new(RATE_HZ).unwrap();
        let mut random = crate::random::Random::stream(1, 1, "gate");
        let mut judged = |answers: f64| {
            let usual = GateConfig::usual();
            let target = Some(Newtons(0.2));
            let mut gate = Gate::new(&usual, target, rate, roles, 20_000, 128).unwrap();
            for _ in 0..20 {
                let drive: Vec<f64> = (0..1_000).map(|_| random.normal()).collect();
                let noisy = |x: &f64| answers * x + 0.01 * random.normal();
                let acceleration = drive.iter().map(noisy).collect();
                let chunk = RunChunk {
                    channels: vec![drive, acceleration],
                    ..RunChunk::default()
                };
                let judged = gate.take(&RunDocument::Chunk(chunk)).unwrap();
                if let Some(judged) = judged.filter(not_met) {
                    return Some(judged);
                }
            }
            None
        };
        assert_eq!(judged(1.0), None);
        let refused = judged(0.0).unwrap();
        assert_eq!(refused.criteria.len(), 1);
        assert_eq!(refused.criteria[0].what, RunCriterion::Coherence);
    }

    #[test]
    fn segments_longer_than_windows_are_refused() {
        let rate = SampleRate::new(RATE_HZ).unwrap();
        assert!(Gate::new(&GateConfig::usual(), None, rate, ROLES, 1, 4_096).is_err());
    }
}
