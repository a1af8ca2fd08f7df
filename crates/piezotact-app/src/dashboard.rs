//! What a run shows on the terminal while it is acquired: level, normal force, strokes, time left, and the beats of a metronome.

use std::io::{IsTerminal as _, Write as _};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use piezotact::monitor::{FiguresNow, ForceNow, Monitor, MonitorConfig, StrokesNow};
use piezotact::number::digits;
use piezotact::quantity::Seconds;
use piezotact::run::RunDocument;

/// How often the figures change.
const EVERY: Duration = Duration::from_millis(250);
/// Counting strokes takes at most this share of the time.
const COUNTING_SHARE: u32 = 10;
/// A run in which counting them takes longer is shown without them: samples that wait meanwhile could be lost.
const LONGEST_COUNT: Duration = Duration::from_secs(1);
/// A mean of less is not judged, s.
const JUDGED_S: f64 = 2.0;
/// A beat is seen for so long.
const SEEN: Duration = Duration::from_millis(120);

/// Figures of the run that is acquired, below a bar. Nothing is kept and nothing shown where standard error is no terminal.
pub(crate) struct Dashboard {
    watched: Option<Watched>,
}

struct Watched {
    monitor: Monitor,
    bar: ProgressBar,
    line: Arc<Line>,
    due: Instant,
    counts_strokes: Counts,
    strokes: Option<StrokesNow>,
    count_due: Instant,
}

/// Whether strokes are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Counts {
    /// The finger slides, and so many are wanted, if it is known.
    Strokes(Option<usize>),
    /// The finger rests.
    Nothing,
}

/// The figures as they stand, and whether there is a beat.
#[derive(Default)]
struct Line {
    text: Mutex<String>,
    beats: AtomicBool,
    has_beats: AtomicBool,
}

impl Line {
    fn shown(&self) -> String {
        let text = self.text.lock().unwrap_or_else(PoisonError::into_inner);
        let beat = match (
            self.has_beats.load(Ordering::Acquire),
            self.beats.load(Ordering::Acquire),
        ) {
            (false, _) => "",
            (true, true) => "● ",
            (true, false) => "○ ",
        };
        match (text.is_empty(), beat) {
            (true, "") => String::new(),
            _ => format!("\n  {beat}{text}"),
        }
    }
}

impl Dashboard {
    /// Figures below `bar`.
    pub(crate) fn new(bar: &ProgressBar, counts_strokes: Counts) -> Self {
        let watched = std::io::stderr().is_terminal().then(|| Watched {
            monitor: Monitor::new(match counts_strokes {
                Counts::Strokes(_) => MonitorConfig::console(),
                // Nothing is asked of a resting finger but its last seconds.
                Counts::Nothing => MonitorConfig {
                    longest_samples: 0,
                    ..MonitorConfig::console()
                },
            }),
            bar: bar.clone(),
            line: Arc::default(),
            due: Instant::now(),
            counts_strokes,
            strokes: None,
            count_due: Instant::now() + 4 * EVERY,
        });
        Self { watched }
    }

    /// Takes the next document of the run.
    pub(crate) fn take(&mut self, document: &RunDocument) {
        if let Some(watched) = &mut self.watched {
            watched.take(document);
        }
    }

    /// Beats every `period`, seen below the bar and heard as the bell of the terminal, until what is given back is dropped.
    pub(crate) fn metronome(&self, period: Seconds) -> Option<Metronome> {
        let watched = self.watched.as_ref()?;
        watched.line.has_beats.store(true, Ordering::Release);
        Some(Metronome::start(period, &watched.line, &watched.bar))
    }
}

impl Watched {
    fn take(&mut self, document: &RunDocument) {
        self.monitor.take(document);
        let now = Instant::now();
        if now < self.due {
            return;
        }
        self.due = now + EVERY;
        let text = match self.monitor.figures() {
            Some(figures) => {
                self.count(now);
                text(&figures, self.strokes, self.counts_strokes)
            }
            None => String::new(),
        };
        *self
            .line
            .text
            .lock()
            .unwrap_or_else(PoisonError::into_inner) = text;
        self.bar.set_message(self.line.shown());
    }

    fn count(&mut self, now: Instant) {
        if self.counts_strokes == Counts::Nothing || now < self.count_due {
            return;
        }
        self.strokes = self.monitor.strokes();
        let took = now.elapsed();
        if took > LONGEST_COUNT {
            (self.counts_strokes, self.strokes) = (Counts::Nothing, None);
        }
        self.count_due = Instant::now() + (COUNTING_SHARE * took).max(4 * EVERY);
    }
}

/// The figures: level, strokes and time in one line, the force below it.
fn text(figures: &FiguresNow, strokes: Option<StrokesNow>, counts: Counts) -> String {
    let mut parts = Vec::new();
    if let Some(level) = figures.level {
        parts.push(format!(
            "vibration {} m/s² rms, peak {}",
            digits(level.rms_m_s2),
            digits(level.peak_m_s2)
        ));
    }
    if let Counts::Strokes(wanted) = counts {
        let strokes = strokes.unwrap_or_default();
        let of = wanted.map_or(String::new(), |wanted| format!(" of {wanted}"));
        let rejected = match strokes.rejected {
            0 => String::new(),
            rejected => format!(" ({rejected} rejected)"),
        };
        parts.push(format!("strokes {}{of}{rejected}", strokes.accepted));
    }
    parts.push(match figures.left_s {
        Some(left_s) => format!("{left_s:.0} s left"),
        None => format!("{:.0} s acquired", figures.acquired_s),
    });
    let line = parts.join(" | ");
    match &figures.force {
        Some(force) => format!("{line}\n  {}", force_text(force)),
        None => line,
    }
}

/// The mean that is judged, with its target, whether it is within the band, and the present value.
fn force_text(force: &ForceNow) -> String {
    let mut text = format!("force {:.3} N", force.mean_n);
    if let (Some(target), Some([low, high])) = (force.target_n, force.band_n) {
        let word = match force.mean_n {
            // Of a moment nothing is said.
            _ if force.mean_over_s < JUDGED_S => "",
            mean if mean < low => ": TOO LOW",
            mean if mean > high => ": TOO HIGH",
            _ => ": held",
        };
        text += &format!(
            " of {target} N ± {:.0} %{word}",
            100.0 * (high / target - 1.0)
        );
    }
    text + &format!(
        " (mean of {:.0} s), now {:.3} N",
        force.mean_over_s, force.now_n
    )
}

/// A metronome that runs.
pub(crate) struct Metronome {
    over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Metronome {
    fn start(period: Seconds, line: &Arc<Line>, bar: &ProgressBar) -> Self {
        let over = Arc::new(AtomicBool::new(false));
        let (stopped, line, bar) = (Arc::clone(&over), Arc::clone(line), bar.clone());
        let period = Duration::from_secs_f64(period.0);
        let beats = move || {
            // By a clock that does not drift with what each beat takes.
            let began = Instant::now();
            let mut beat = 0u32;
            while !stopped.load(Ordering::Acquire) {
                let mut err = std::io::stderr().lock();
                let _nobody_hears = err.write_all(b"\x07").and_then(|()| err.flush());
                drop(err);
                for (is_seen, until) in [(true, SEEN.min(period / 2)), (false, period)] {
                    line.beats.store(is_seen, Ordering::Release);
                    bar.set_message(line.shown());
                    let due = began + period * beat + until;
                    while !stopped.load(Ordering::Acquire) && Instant::now() < due {
                        let left = due.saturating_duration_since(Instant::now());
                        std::thread::sleep(left.min(Duration::from_millis(50)));
                    }
                }
                beat += 1;
            }
        };
        Self {
            // Without a thread there are no beats, and the run goes on.
            thread: std::thread::Builder::new().spawn(beats).ok(),
            over,
        }
    }
}

impl Drop for Metronome {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            let _panicked = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use piezotact::monitor::LevelNow;

    use super::*;

    #[test]
    fn the_figures_stand_in_one_line() {
        let force = ForceNow {
            now_n: 0.31,
            mean_n: 0.205,
            mean_over_s: 10.0,
            target_n: Some(0.2),
            band_n: Some([0.18, 0.22]),
        };
        let figures = FiguresNow {
            acquired_s: 18.2,
            left_s: Some(41.8),
            level: Some(LevelNow {
                rms_m_s2: 1.234,
                peak_m_s2: 5.0,
            }),
            force: Some(force.clone()),
        };
        let strokes = StrokesNow {
            accepted: 7,
            rejected: 1,
        };
        assert_eq!(
            text(&figures, Some(strokes), Counts::Strokes(Some(20))),
            "vibration 1.23 m/s² rms, peak 5.00 | strokes 7 of 20 (1 rejected) | 42 s left\n  \
             force 0.205 N of 0.2 N ± 10 %: held (mean of 10 s), now 0.310 N"
        );
        // The mean is judged, not the present value; that of a moment is not.
        for (mean_n, mean_over_s, word) in [
            (0.17, 10.0, "TOO LOW"),
            (0.23, 10.0, "TOO HIGH"),
            (0.18, 10.0, "held"),
            (0.23, 0.5, "%"),
        ] {
            let force = ForceNow {
                mean_n,
                mean_over_s,
                ..force.clone()
            };
            assert!(
                force_text(&force).contains(&format!("{word} (mean")),
                "{mean_n}"
            );
        }
        let free = FiguresNow {
            force: Some(ForceNow {
                target_n: None,
                band_n: None,
                ..force
            }),
            left_s: None,
            level: None,
            ..figures
        };
        assert_eq!(
            text(&free, None, Counts::Nothing),
            "18 s acquired\n  force 0.205 N (mean of 10 s), now 0.310 N"
        );
        assert!(text(&free, None, Counts::Strokes(None)).starts_with("strokes 0 | "));
    }
}
