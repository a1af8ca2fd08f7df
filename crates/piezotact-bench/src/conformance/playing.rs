//! Conformance tests of the playing half.

use std::time::Duration;

use piezotact::Series;
use piezotact::device::DriveSetup;
use piezotact::quantity::{Drive, SampleRate};
use piezotact::recording::BenchKind;

use super::{Draws, Make, Subject, begin, expect, playback, same, take, until, usual, whole_run};
use crate::error::DeviceError;
use crate::plan::{DriveSource, Playback, RunPlan, Until};
use crate::stop::StopHandle;
use crate::traits::{Play, PlayDescription, PlayProgress};

/// An output plays on for so long after a stop at most.
const SILENT_WITHIN: Duration = Duration::from_millis(100);

/// The player of a bench that only acquires.
pub(super) struct NoPlayer;

impl Play for NoPlayer {
    fn describe(&self) -> PlayDescription {
        PlayDescription {
            name: "no output".into(),
            kind: BenchKind::Scripted,
            rate: SampleRate::new(1.0)
                .unwrap_or_else(|_| unreachable!("a constant rate above zero")),
            gain: None,
        }
    }

    fn calibrate(&mut self) -> Result<Option<DriveSetup>, DeviceError> {
        Ok(None)
    }

    fn ready(&mut self, _: Playback, _: &RunPlan, _: &StopHandle) -> Result<(), DeviceError> {
        Err(DeviceError::Order {
            asked: "play",
            before: "given an output",
        })
    }

    fn start(&mut self) -> Result<(), DeviceError> {
        Ok(())
    }

    fn progress(&mut self) -> Result<PlayProgress, DeviceError> {
        Ok(PlayProgress::default())
    }

    fn stop(&mut self) {}
}

fn drive(subject: &Subject) -> Result<&Series<Drive>, String> {
    subject
        .drive
        .as_ref()
        .ok_or("expected a drive in the subject of the tests, found none".into())
}

fn ended(subject: &Subject) -> RunPlan {
    until(subject, Until::PlaybackEnded)
}

pub(super) fn playback_ended(make: &Make, subject: &Subject) -> Result<(), String> {
    let mut bench = make();
    let drive_s = drive(subject)?.duration().0;
    let rate_hz = bench.acquirer.describe().rate.hz();
    let taken = whole_run(&mut bench, playback(subject), &ended(subject))?;
    let found_s = taken.samples() as f64 / rate_hz;
    expect(
        found_s > drive_s && found_s < drive_s + 10.0,
        format!("the {drive_s:.2} s of the drive, what follows it, and an end"),
        format!("{found_s:.2} s"),
    )
}

pub(super) fn rate(make: &Make, subject: &Subject) -> Result<(), String> {
    let mut bench = make();
    let rate = bench.player.describe().rate;
    expect(
        drive(subject)?.rate() == rate,
        format!("a drive at {rate} in the subject of the tests"),
        drive(subject)?.rate(),
    )?;
    let other = SampleRate::new(rate.hz() * 0.5).map_err(|error| error.to_string())?;
    let wrong = Series::new(vec![0.0; 64], other).map_err(|error| error.to_string())?;
    let run = ended(subject);
    let refused = bench
        .player
        .ready(Playback::Whole(wrong), &run, &bench.stop);
    let rightly = matches!(refused, Err(DeviceError::Rate { .. }));
    expect(
        rightly,
        format!("a drive at {other} to be refused"),
        format!("{refused:?}"),
    )
}

/// A drive in pieces of different length.
struct InPieces {
    drive: Series<Drive>,
    at: usize,
}

impl DriveSource for InPieces {
    fn rate(&self) -> SampleRate {
        self.drive.rate()
    }

    fn next_samples(&mut self, count: usize) -> Vec<f64> {
        let all = self.drive.samples();
        let to = (self.at + count).min(all.len());
        let next = all[self.at..to].to_vec();
        self.at = to;
        next
    }
}

pub(super) fn made(make: &Make, subject: &Subject) -> Result<(), String> {
    let drive = drive(subject)?.clone();
    let expected = drive.samples().len() as u64;
    let made = Playback::Made(Box::new(InPieces { drive, at: 0 }));
    let found = whole_run(&mut make(), Some(made), &ended(subject))?;
    match subject.draws {
        Draws::Seeded => same(
            &whole_run(&mut make(), playback(subject), &ended(subject))?,
            &found,
            "of a drive that is computed during playback",
        ),
        // How long a device records after the end of a drive depends on the load of the machine.
        Draws::Unseeded => {
            let last = found.progress.last().copied().unwrap_or_default();
            expect(
                last.played == expected && last.ended,
                format!("all {expected} samples of a drive that is computed during playback"),
                format!("{last:?}"),
            )
        }
    }
}

pub(super) fn progress(make: &Make, subject: &Subject) -> Result<(), String> {
    let mut bench = make();
    let taken = whole_run(&mut bench, playback(subject), &ended(subject))?;
    let expected = drive(subject)?.samples().len() as u64;
    for pair in taken.progress.windows(2) {
        let grows = pair[1].played >= pair[0].played && pair[1].ended >= pair[0].ended;
        expect(
            grows,
            format!("more than {:?}", pair[0]),
            format!("{:?}", pair[1]),
        )?;
    }
    let last = taken.progress.last().copied().unwrap_or_default();
    expect(
        last.played == expected && last.ended,
        format!("all {expected} samples played at the end"),
        format!("{last:?}"),
    )?;
    let rate_hz = bench.acquirer.describe().rate.hz();
    let first_s = taken
        .chunks
        .first()
        .map_or(0.0, |chunk| chunk.len() as f64 / rate_hz);
    let early = taken.progress.first().is_some_and(|first| first.ended);
    expect(
        !early || first_s >= drive(subject)?.duration().0,
        "a playback that continues after the first chunk",
        "its end",
    )?;
    // A playback that was stopped is over.
    begin(&mut bench, playback(subject), &ended(subject))?;
    let _one = take(&mut bench, super::Playing::Drive, |taken| {
        !taken.chunks.is_empty()
    })?;
    bench.player.stop();
    let stopped = bench.player.progress().map_err(super::said)?;
    bench.acquirer.stop();
    expect(
        stopped.ended && stopped.played <= expected,
        "an end of a playback that was stopped",
        format!("{stopped:?}"),
    )
}

pub(super) fn output_stops(make: &Make, subject: &Subject) -> Result<(), String> {
    let mut bench = make();
    begin(&mut bench, playback(subject), &ended(subject))?;
    let _first = take(&mut bench, super::Playing::Drive, |taken| {
        taken.progress.last().is_some_and(|now| now.played > 0)
    })?;
    bench.stop.stop();
    let mut played = [0; 2];
    // What plays on plays some of its drive in as long again.
    for played in &mut played {
        std::thread::sleep(SILENT_WITHIN);
        *played = bench.player.progress().map_err(super::said)?.played;
    }
    bench.player.stop();
    bench.acquirer.stop();
    expect(
        played[0] == played[1],
        format!(
            "silence {} ms after a stop from another thread, while nobody acquires",
            SILENT_WITHIN.as_millis()
        ),
        format!("{} samples more", played[1].saturating_sub(played[0])),
    )
}

pub(super) fn calibration(make: &Make, subject: &Subject) -> Result<(), String> {
    let mut bench = make();
    let setup = bench.player.calibrate().map_err(super::said)?;
    let first = usual(&mut bench, subject)?;
    let again = bench.player.calibrate().map_err(super::said)?;
    if subject.draws == Draws::Seeded {
        expect(
            setup == again,
            format!("{setup:?} again"),
            format!("{again:?}"),
        )?;
        let after = usual(&mut bench, subject)?;
        same(&first, &after, "after a calibration of the output")?;
    }
    Ok(())
}

/// Both halves in threads of their own, as sound hardware has them.
pub(super) fn threads(make: &Make, subject: &Subject) -> Result<(), String> {
    let mut bench = make();
    let alone = whole_run(
        &mut make(),
        playback(subject),
        &until(subject, Until::Duration(super::DURATION)),
    )?;
    begin(
        &mut bench,
        playback(subject),
        &until(subject, Until::Duration(super::DURATION)),
    )?;
    let (mut player, mut acquirer) = (bench.player, bench.acquirer);
    let acquires = std::thread::spawn(move || {
        let mut taken = super::Taken::default();
        while let Some(chunk) = acquirer.next_chunk().map_err(super::said)? {
            taken.chunks.push(chunk);
        }
        acquirer.stop();
        Ok::<_, String>(taken)
    });
    let plays = std::thread::spawn(move || {
        while !acquires.is_finished() {
            player.progress().map_err(super::said)?;
            std::thread::sleep(Duration::from_millis(1));
        }
        player.stop();
        acquires
            .join()
            .map_err(|_panic| "the thread that acquires panicked".to_owned())?
    });
    let taken = plays
        .join()
        .map_err(|_panic| "the thread that plays panicked".to_owned())??;
    match subject.draws {
        Draws::Seeded => same(&alone, &taken, "where two threads hold the halves"),
        Draws::Unseeded => expect(
            alone.samples() == taken.samples(),
            alone.samples(),
            taken.samples(),
        ),
    }
}
