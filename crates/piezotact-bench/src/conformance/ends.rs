//! Conformance tests of how runs end.

use std::time::{Duration, Instant};

use piezotact::quantity::Seconds;

use super::{
    DURATION, Draws, Make, Playing, Subject, begin, expect, playback, renewed, same, take, until,
    usual,
};
use crate::plan::Until;

/// The largest number of chunks that may still arrive after a stop.
const CHUNKS_BEHIND: usize = 2;
/// A stop ends a run within this time, also while something waits.
const ENDS_WITHIN: Duration = Duration::from_millis(1_500);
/// From the start of a run to a stop from outside.
const STOPS_AFTER: Duration = Duration::from_millis(60);

pub(super) fn duration(make: &Make, subject: &Subject) -> Result<(), String> {
    let mut bench = make();
    let rate = bench.acquirer.describe().rate;
    let expected = rate.samples_in(DURATION) as u64;
    let found = usual(&mut bench, subject)?.samples();
    expect(
        found == expected,
        format!("{expected} samples in {DURATION:.3}"),
        found,
    )?;
    let Some(drive) = &subject.drive else {
        return Ok(());
    };
    // Longer than the drive.
    let longer = Seconds(drive.duration().0 + 1.234);
    let run = until(subject, Until::Duration(longer));
    let found = super::whole_run(&mut bench, playback(subject), &run)?.samples();
    let expected = rate.samples_in(longer) as u64;
    expect(
        found == expected,
        format!("{expected} samples in {longer:.3}"),
        found,
    )?;
    // Nothing plays.
    let run = until(subject, Until::Duration(DURATION));
    let found = super::whole_run(&mut bench, None, &run)?.samples();
    let expected = rate.samples_in(DURATION) as u64;
    expect(
        found == expected,
        format!("{expected} samples where nothing plays"),
        found,
    )
}

pub(super) fn stopped(make: &Make, subject: &Subject) -> Result<(), String> {
    let mut bench = make();
    let rate = bench.acquirer.describe().rate;
    let enough = rate.samples_in(subject.goes_on_for) as u64;
    begin(
        &mut bench,
        playback(subject),
        &until(subject, Until::Stopped),
    )?;
    let playing = Playing::of(subject.drive.as_ref());
    let taken = take(&mut bench, playing, |taken| taken.samples() >= enough)?;
    expect(
        taken.samples() >= enough,
        format!(
            "samples for {:.2} and more, since it is not stopped",
            subject.goes_on_for
        ),
        format!("an end after {}", taken.samples()),
    )?;
    bench.stop.stop();
    ends_soon(&mut bench)?;
    bench.player.stop();
    bench.acquirer.stop();
    Ok(())
}

/// The run ends within a few chunks.
fn ends_soon(bench: &mut super::Bench) -> Result<(), String> {
    for _ in 0..=CHUNKS_BEHIND {
        if bench.acquirer.next_chunk().map_err(super::said)?.is_none() {
            return Ok(());
        }
    }
    Err(format!(
        "expected an end at most {CHUNKS_BEHIND} chunks after a stop, found more"
    ))
}

pub(super) fn stop_from_outside(make: &Make, subject: &Subject) -> Result<(), String> {
    let mut bench = make();
    begin(
        &mut bench,
        playback(subject),
        &until(subject, Until::Stopped),
    )?;
    let outside = bench.stop.clone();
    let stops = std::thread::spawn(move || {
        std::thread::sleep(STOPS_AFTER);
        outside.stop();
        Instant::now()
    });
    let (mut behind, began) = (0, Instant::now());
    let over_at = loop {
        let stopped = bench.stop.is_stopped();
        if bench.acquirer.next_chunk().map_err(super::said)?.is_none() {
            break Instant::now();
        }
        behind += usize::from(stopped);
        if behind > CHUNKS_BEHIND || began.elapsed() > 10 * ENDS_WITHIN {
            break Instant::now();
        }
    };
    let stopped_at = stops
        .join()
        .map_err(|_panic| "the thread that stops panicked".to_owned())?;
    bench.player.stop();
    bench.acquirer.stop();
    expect(
        behind <= CHUNKS_BEHIND,
        format!("at most {CHUNKS_BEHIND} chunks after a stop"),
        "more",
    )?;
    let late = over_at.saturating_duration_since(stopped_at);
    expect(
        late <= ENDS_WITHIN,
        format!(
            "an end within {} ms of a stop from another thread",
            ENDS_WITHIN.as_millis()
        ),
        format!("{} ms", late.as_millis()),
    )
}

pub(super) fn stopped_before(make: &Make, subject: &Subject) -> Result<(), String> {
    let mut bench = make();
    bench.stop.stop();
    begin(
        &mut bench,
        playback(subject),
        &until(subject, Until::Stopped),
    )?;
    let chunk = bench.acquirer.next_chunk().map_err(super::said)?;
    bench.player.stop();
    bench.acquirer.stop();
    expect(
        chunk.is_none(),
        "nothing in a run that was stopped before its start",
        "a chunk",
    )
}

pub(super) fn stop_harmless(make: &Make, subject: &Subject) -> Result<(), String> {
    let fresh = usual(&mut make(), subject)?;
    let mut bench = make();
    let both = |bench: &mut super::Bench| {
        for _ in 0..2 {
            bench.player.stop();
            bench.acquirer.stop();
        }
    };
    both(&mut bench);
    let run = until(subject, Until::Duration(DURATION));
    bench
        .acquirer
        .ready(&run, &bench.stop)
        .map_err(super::said)?;
    both(&mut bench);
    let after = usual(&mut bench, subject)?;
    both(&mut bench);
    begin(&mut bench, playback(subject), &run)?;
    both(&mut bench);
    let last = usual(&mut bench, subject)?;
    for (run, when) in [(after, "before a start"), (last, "in the middle of a run")] {
        match subject.draws {
            Draws::Seeded => same(&fresh, &run, &format!("after a stop {when}"))?,
            Draws::Unseeded => expect(
                fresh.samples() == run.samples(),
                fresh.samples(),
                run.samples(),
            )?,
        }
    }
    Ok(())
}

pub(super) fn after_stop(make: &Make, subject: &Subject) -> Result<(), String> {
    let fresh = usual(&mut make(), subject)?;
    let mut bench = make();
    begin(
        &mut bench,
        playback(subject),
        &until(subject, Until::Stopped),
    )?;
    let _first = bench.acquirer.next_chunk().map_err(super::said)?;
    bench.stop.stop();
    ends_soon(&mut bench)?;
    bench.player.stop();
    bench.acquirer.stop();
    renewed(&mut bench);
    let after = usual(&mut bench, subject)?;
    match subject.draws {
        Draws::Seeded => same(&fresh, &after, "after a run that was stopped"),
        Draws::Unseeded => expect(
            fresh.samples() == after.samples(),
            fresh.samples(),
            after.samples(),
        ),
    }
}
