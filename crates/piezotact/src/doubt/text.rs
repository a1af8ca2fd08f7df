//! What a [`Doubt`] tells a person: what was seen and what to do.

use std::fmt;

use super::Doubt;
use crate::quantity::Band;

/// The first four of `bands`, and how many there are beside them.
fn list(f: &mut fmt::Formatter<'_>, bands: &[Band]) -> fmt::Result {
    for (i, band) in bands.iter().take(4).enumerate() {
        write!(f, "{}{band}", if i > 0 { ", " } else { "" })?;
    }
    if bands.len() > 4 {
        write!(f, " and {} more", bands.len() - 4)?;
    }
    Ok(())
}

/// As many of a list are named.
const LISTED: usize = 4;

fn and_more(count: usize) -> String {
    match count.saturating_sub(LISTED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    }
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |share: f64| {
            let p = share * 100.0;
            if p >= 1.0 || p <= 0.0 {
                format!("{p:.0} %")
            } else {
                format!("{p:.2} %")
            }
        };
        match self {
            Self::LowCoherence {
                asked,
                lowest,
                at_hz,
                share,
            } => write!(
                f,
                "coherence is below {asked} on {} of the band (lowest {lowest:.3} at {at_hz:.0} Hz): measure longer or louder, or narrow the band",
                percent(*share)
            ),
            Self::ImpossibleCoherence { at_hz, found, lines } => write!(
                f,
                "coherence is {found:.3} at {at_hz:.1} Hz ({lines} lines in all), which no pair of signals can have: do not use such lines, and ask the program that exported them"
            ),
            Self::FewAverages {
                averages,
                recommended,
            } => write!(
                f,
                "only {averages} segments were averaged: the estimate scatters; record longer or take shorter segments ({recommended} or more)"
            ),
            Self::LateResponse { delay_s, segment_s, reach_s } => write!(
                f,
                "the response comes {:.1} ± {:.1} ms after the drive, {} of a segment: the magnitude is underestimated; take longer segments or align the channels",
                delay_s * 1e3,
                reach_s * 1e3,
                percent(delay_s / segment_s)
            ),
            Self::Acausal { lead_s, reach_s } => write!(
                f,
                "the response comes {:.2} ± {:.2} ms before the drive, which nothing can: drive and response are swapped, or their channels are out of step",
                lead_s * 1e3,
                reach_s * 1e3
            ),
            Self::SwappedUnits { drive, response } => write!(
                f,
                "the drive is in {drive} and the response in {response}: they are probably swapped; exchange --drive and --response"
            ),
            Self::NotDriven { bands, share } => {
                write!(f, "nothing drives {} of the band (", percent(*share))?;
                list(f, bands)?;
                f.write_str("): the transfer function says nothing there; drive the whole band or narrow it")
            }
            Self::UnresolvedResonance { at_hz, lines, resolution_hz } => write!(
                f,
                "the resonance at {at_hz:.1} Hz has {lines:.1} lines of {resolution_hz:.2} Hz within its half-power bandwidth: its height is underestimated; take longer segments (6 lines or more)"
            ),
            Self::LoopStopped { best, why } => write!(
                f,
                "the closed loop ended early ({why}); the drive is that of iteration {best}: if the device or the finger changed, characterise again"
            ),
            Self::RepeatsScatter { db_rms } => write!(
                f,
                "repeats lie up to {db_rms:.1} dB rms apart: the finger moved or pressed otherwise, or somebody else's is among them; measure again"
            ),
            Self::Nonlinear { level_db, band_hz } => write!(
                f,
                "distortion reaches {level_db:.0} dB of the answer at {band_hz}: the transfer function holds for this level of drive only; characterise at the level that will be played"
            ),
            Self::PolarityInverted => f.write_str(
                "the force seems to take power out of the finger: force or acceleration has the wrong sign; check the polarity of both sensors"
            ),
            Self::GivenUp { bands, share } => {
                write!(f, "the inverse gives up {} of the band (", percent(*share))?;
                list(f, bands)?;
                f.write_str(
                    "): the device hardly answers there or was not measured well; what is felt there may be missing or wrong",
                )
            }
            Self::TurnedDown {
                bands,
                share,
                fits_at_db,
            } => {
                write!(f, "so that the drive fits, {} of the band (", percent(*share))?;
                list(f, bands)?;
                write!(
                    f,
                    ") were turned down by more than 0.5 dB: what is felt there is weaker than it should be; {:.1} dB softer, nothing has to be",
                    -fits_at_db
                )
            }
            Self::TargetInNoise { share, bands } => {
                write!(f, "the target's lines in {} of the band (", percent(*share))?;
                list(f, bands)?;
                f.write_str(
                    ") are so soft there that the sensor's noise hides them: much of the error is the noise's, and little of it can be corrected; render louder, or take a quieter sensor",
                )
            }
            Self::CrestsPressed { correlation } => write!(
                f,
                "so that the drive fits, its crests were pressed down (correlation {correlation:.2} with what was asked for): the spectrum is kept, sudden bursts are softer; lower the level where they matter"
            ),
            Self::Inverted { correlation } => write!(
                f,
                "the measurement follows its target with the sign reversed (correlation {correlation:.3}): check the polarity of sensor and actuator"
            ),
            Self::PlaybackIncomplete { played, expected, underruns } => write!(
                f,
                "{played} of {expected} samples of the drive were played and the output ran dry {underruns} times: close other programs and play again"
            ),
            Self::InterruptedLater { journal } => write!(
                f,
                "a later recording of this name was interrupted and stands in {journal}: look whether that is the one you mean"
            ),
            Self::Unrelated { coherence, limit, averages } => write!(
                f,
                "the mean coherence of the driven lines is {coherence:.3}, and unrelated signals reach {limit:.3} with {averages:.0} averages: no relation of drive and response is shown; check the channels and the sensor, or record longer"
            ),
            Self::DeviceNotDescribed => f.write_str(
                "the transfer function does not say its amplifier gain and volts at full scale: only the digital full scale was checked, the amplifier may clip before; state them when it is made"
            ),
            Self::OtherCondition { what, rendered_for, measured } => write!(
                f,
                "the drive was rendered for {what} {rendered_for} and measured with {measured}: characterise and render for {measured}"
            ),
            Self::OtherTarget { rendered, compared } => write!(
                f,
                "the drive was rendered from {rendered} and is compared with {compared}: check that they are one texture"
            ),
            Self::RateStated { stated_hz, found_hz } => write!(
                f,
                "the rate of {stated_hz} Hz from the command line was used, the time stamps say {found_hz:.4} Hz: check which is right"
            ),
            Self::RateNotUsed { stated_hz, found_hz } => write!(
                f,
                "the rate of {stated_hz} Hz from the command line was not used: the file is one of {found_hz} Hz by its own header; leave --rate out, or correct the file"
            ),
            Self::Clipped { what, fraction } => {
                write!(f, "{} of {what} lies at or beyond the limit: lower the level", percent(*fraction))
            }
            Self::SlewLimited {
                asked_v_per_s,
                limit_v_per_s,
            } => write!(
                f,
                "the drive asks for {asked_v_per_s:.2e} V/s and the amplifier follows {limit_v_per_s:.2e} V/s into this load: high frequencies will be distorted; lower the level or the band"
            ),
            Self::Uncalibrated { channel } => write!(
                f,
                "{channel} has no physical scale (full scale = 1): give --scale or a sidecar to get m/s²"
            ),
            Self::ScaleOverridden { used, ignored } => write!(
                f,
                "the scale {used} from the command line was used, not {ignored} from the sidecar: check which is right"
            ),
            Self::RateConverted {
                what,
                from_hz,
                to_hz,
            } => write!(
                f,
                "{what} is sampled at {from_hz} Hz and was brought to {to_hz} Hz: what lies above 0.45 of the lower rate is weakened, keep the band below"
            ),
            Self::RatesDiffer {
                target_hz,
                transfer_hz,
            } => write!(
                f,
                "the target is sampled at {target_hz} Hz and the transfer function was measured at {transfer_hz} Hz: the band fits both and is rendered; check that they are meant for each other"
            ),
            Self::FormatLoses { format, what } => {
                write!(f, "{format} does not carry {what}: keep the original beside it")
            }
            Self::Guessed { what } => write!(f, "{what}: check it, or state it in the file"),
            Self::UnevenSampling { worst } => write!(
                f,
                "the time steps differ from their mean by up to {}: frequencies are only that exact",
                percent(*worst)
            ),
            Self::Interrupted { read_s } => write!(
                f,
                "the recording has no end: it was interrupted or is still running; {read_s:.3} s could be read"
            ),
            Self::CoarseQuantisation { channel, rms_in_steps } => write!(
                f,
                "{channel} is only {rms_in_steps:.1} converter steps rms, quantisation noise lies {:.0} dB below it: record with more gain",
                20.0 * (rms_in_steps * 12f64.sqrt()).max(1.0).log10()
            ),
            Self::ForceNotMeasured { load_n } => write!(
                f,
                "no force was measured: nobody can tell whether {load_n} N was held; take it on trust, or measure the force beside the acceleration"
            ),
            Self::Rehearsed { through, answers_hz, own_doubts } => {
                write!(
                    f,
                    "no finger was touched: this was played through {through}, which answers over {answers_hz} alone, at one placement and without distortion"
                )?;
                match own_doubts {
                    0 => {}
                    1 => f.write_str(", and carries a doubt of its own that `piezotact info` shows")?,
                    many => write!(f, ", and carries {many} doubts of its own that `piezotact info` shows")?,
                }
                f.write_str(": play it on the device before relying on it")
            }
            Self::LoadOffTarget { mean_n, target_n } => write!(
                f,
                "the mean normal force was {mean_n:.3} N, the condition says {target_n} N: repeat with the force held"
            ),
            Self::NoTargetPower { share } => write!(
                f,
                "{} of the band holds next to no target power and was left out of the error: narrow the band to the texture",
                percent(*share)
            ),
            Self::PartJudged { share, judged, band } => {
                write!(f, "{} of {band} is judged: the drive was made to reach ", percent(*share))?;
                list(f, judged)?;
                f.write_str(" alone, and what is felt elsewhere is missing or wrong")
            }
            Self::PowerAdded { ratio } => write!(
                f,
                "where the target holds next to no power the measurement holds {} of the target's: something is felt that was not meant; look for distortion, mains and other sources",
                percent(*ratio)
            ),
            Self::TargetMissed { error_db_rms, limit_db } => write!(
                f,
                "the best drive of the loop misses its target by {error_db_rms:.1} dB rms (limit {limit_db} dB): the device may not answer in all of the band; look at the lines in the report, and characterise again"
            ),
            Self::PowerOutsideBand { share, band } => write!(
                f,
                "{} of the texture's power lies outside {band} and is not rendered: widen the band where the device answers, or take out what is no texture",
                percent(*share)
            ),
            Self::Cut { compared_s, target_s } => write!(
                f,
                "target and measurement share {compared_s:.2} s of the target's {target_s:.2} s: record from before the playback until it has ended, and check that they belong together"
            ),
            Self::LevelChanged { level_db } => write!(
                f,
                "the texture was rendered at {level_db:+.1} dB on purpose and is compared at that level: what is felt is not the recorded level"
            ),
            Self::NothingCut => f.write_str(
                "no channel of force or speed was recorded: the whole recording is taken as one stroke; cut it with --cuts if it holds more"
            ),
            Self::NoContact { largest_n, threshold_n } => write!(
                f,
                "no stroke: the force rises by {largest_n:.3} N at most and a contact needs {threshold_n} N; check the force channel, or state the load with --load"
            ),
            Self::SlidingAssumed => f.write_str(
                "every contact is taken as a stroke: hesitations and stick-slip are not looked for (for want of vibration and tangential force, or as asked)"
            ),
            Self::ContactAssumed => f.write_str(
                "no normal force was recorded: the finger is taken to touch whenever the surface moves"
            ),
            Self::ZeroUnknown => f.write_str(
                "the finger never leaves the surface, or never touches it: the zeros of the forces are taken as 0, and force and friction are only that right; record a lift"
            ),
            Self::ForceDrift { from_n, to_n, threshold_n } => write!(
                f,
                "the zero of the normal force drifts between {from_n:.3} and {to_n:.3} N (a contact needs {threshold_n} N): contacts are found above the drifting zero; let the cell warm up, or zero it between trials"
            ),
            Self::SignReversed { channel } => write!(
                f,
                "{channel} is negative in contact and was taken with its sign reversed: check the polarity"
            ),
            Self::HighFriction { coefficient } => write!(
                f,
                "the friction coefficient is {coefficient:.2}, more than skin usually has: an adhesive surface, or the force axes are swapped; check which channel is normal"
            ),
            Self::LongStroke {
                at_s,
                length_s,
                usual_s,
            } => write!(
                f,
                "the stroke at {at_s:.2} s lasts {length_s:.1} s, the usual one {usual_s:.1} s: it may be two or a rubbing to and fro without a lift; look, and cut it with --cuts"
            ),
            Self::NotCompared { recordings } => write!(
                f,
                "nothing to compare with: {recordings} differ from the others in more than what is compared; give recordings that share all else"
            ),
            Self::Scattered { group, share } => write!(
                f,
                "{group}: the rms of the strokes scatters by {} of its mean, far more than strokes of one texture do: look for a loose sensor or other conditions",
                percent(*share)
            ),
            Self::SpeedOffTarget { mean_m_s, target_m_s } => write!(
                f,
                "the speed was {:.2} mm/s and {:.2} mm/s was asked for: frequencies and rms belong to the speed that was reached",
                mean_m_s * 1e3,
                target_m_s * 1e3
            ),
            Self::DeadChannel { channel } => write!(
                f,
                "`{channel}` never changes and says nothing: check its cable and its range"
            ),
            Self::ShortStrokes { count, needed_s } => write!(
                f,
                "{count} stroke(s) shorter than a segment of {needed_s:.3} s are left out: state a shorter one with --segment to keep them"
            ),
            Self::FewStrokes { what, kept, recommended } => write!(
                f,
                "{what}: strokes kept: {kept}, averages scatter; record {recommended} or more"
            ),
            Self::Rejected { count, of, reasons } => write!(
                f,
                "{count} of {of} parts that looked like strokes were rejected ({reasons}): look at them in the report, and override with --cuts"
            ),
            Self::Pooled { group, what } => write!(
                f,
                "{group}: recordings of different {what} are averaged together; group by that, or compare them"
            ),
            Self::GestureKept { share, below_hz } => write!(
                f,
                "{} of the power lies below {below_hz} Hz, where gestures are, and was kept (only accelerations are filtered unasked): state --high-pass {below_hz} to filter it",
                percent(*share)
            ),
            Self::CutsNotApplied { file, count } => write!(
                f,
                "{count} cuts of {file} lie outside the recording and were not applied: check their times"
            ),
            Self::NoCommonPeriod { prominence_db } => write!(
                f,
                "no spatial period stands out at every speed (the strongest candidate by {prominence_db:.1} dB): the surface may have none, or the speeds stated are not those that were reached"
            ),
            Self::NoInterval { what, groups } => write!(
                f,
                "{what} comes from {groups} group(s) and has no interval: measure three or more"
            ),
            Self::MissingPoints { share } => write!(
                f,
                "{} of the points were not measured and are left out: parameters hold for the rest; fill or measure again where they cluster",
                percent(*share)
            ),
            Self::UnevenSteps { worst } => write!(
                f,
                "the points are not evenly spaced (steps differ by up to {}): slopes and spacings are only that exact",
                percent(*worst)
            ),
            Self::ShortEvaluation {
                sections,
                asked,
                cutoff_m,
            } => write!(
                f,
                "only {sections} section{} of the cut-off {} mm, the standard asks for {asked}: measure a longer line, or state a shorter cut-off",
                if *sections == 1 { "" } else { "s" },
                cutoff_m * 1e3
            ),
            Self::UnevenProfile {
                evaluated_ra_m,
                whole_ra_m,
            } => write!(
                f,
                "the sections in the middle are not like the rest: their Ra is {:.4} µm, that of the whole line {:.4} µm; cut the line to the surface that is meant, or state a cut-off that takes it in",
                evaluated_ra_m * 1e6,
                whole_ra_m * 1e6
            ),
            Self::CutoffUnsettled { used_m, ra_m } => write!(
                f,
                "no cut-off of the standard's table fits its own Ra (with {} mm Ra is {:.4} µm): state the cut-off",
                used_m * 1e3,
                ra_m * 1e6
            ),
            Self::LongCorrelation { level, reached_m } => write!(
                f,
                "in some direction the autocorrelation stays above {level} as far as {:.3} mm, half the map: Str is left open, and Sal where nothing falls; measure a larger area or take away more form or waviness",
                reached_m * 1e3
            ),
            Self::IncompletePanel { missing, complete, participants } => write!(
                f,
                "{complete} of {participants} participants were measured at every load and angle; missing: {}{}: comparisons take only those who are in both sides; measure the others",
                missing.iter().take(LISTED).map(String::as_str).collect::<Vec<_>>().join("; "),
                and_more(missing.len())
            ),
            Self::FewPeople { participants, recommended } => write!(
                f,
                "{participants} participants say nothing of what another panel would find: how sure the worst case is stays open; measure {recommended} or more"
            ),
            Self::OddOneOut { participant, at, db_rms, usual_db_rms } => write!(
                f,
                "{participant} at {at} is {db_rms:.1} dB rms from the mean curve, the usual person {usual_db_rms:.1} dB: look at that measurement (sensor, placement, person), and repeat it"
            ),
            Self::MixedRepeats { what, of, db_rms, usual_db_rms } => write!(
                f,
                "{what} of {of} are up to {db_rms:.1} dB rms apart, usual are {usual_db_rms:.1} dB: they may be of different people, or the sensor came loose; look at them one by one, and repeat"
            ),
            Self::OppositeSign { measurement, count, of, such_as } => write!(
                f,
                "{measurement} has the opposite sign of {count} of the {of} others at that load and angle, such as {such_as}: one of its channels may be inverted; turn that round and add it again"
            ),
            Self::OtherParticipant { measurement, found } => write!(
                f,
                "{measurement} comes from a measurement of participant {found}: check whose it is, and file it under that name"
            ),
            Self::SeveralTwins { one, other } => write!(
                f,
                "the measurements are of digital twins of different seeds: {one}, {other}; keep them in panels of their own"
            ),
            Self::OfMembers { count, of, example } => write!(
                f,
                "{count} of {of} measurements carry doubts of their own, such as {example}"
            ),
            Self::Averaged { participants, penalty_db_rms, interval_db_rms, worst, worst_db_rms } => {
                write!(f, "the average of {participants} people: for somebody who is not in it, it is {penalty_db_rms:.1} dB rms off")?;
                if let Some([low, high]) = interval_db_rms {
                    write!(f, " (95 %: {low:.1} to {high:.1})")?;
                }
                write!(f, ", for {worst} {worst_db_rms:.1} dB; characterise the person where that is too much")
            }
            Self::ControlIncoherent { lowest, at_hz, asked } => write!(
                f,
                "the control's coherence falls to {lowest:.2} at {at_hz:.0} Hz, below {asked}: what is taken out there is partly noise; measure the control longer or louder"
            ),
            Self::NotListed { files } => write!(
                f,
                "the folder holds transfer functions that panel.json does not list and that are left out: {}{}; run the campaign again, or add them",
                files.iter().take(LISTED).map(String::as_str).collect::<Vec<_>>().join(", "),
                and_more(files.len())
            ),
            Self::NotMeasured { count, first } => write!(
                f,
                "{count} planned measurements are missing, the first is {first}: run the campaign again to go on with it"
            ),
            Self::LeftTheBand {
                operation,
                share,
                nyquist_hz,
            } => write!(
                f,
                "{operation}: {} of the power would leave 0 to {nyquist_hz} Hz and is gone; go less far, or record at another rate",
                percent(*share)
            ),
            Self::JoinShows {
                correlation,
                step_ratio,
                spectrum_db,
            } => write!(
                f,
                "where the texture is joined with itself its ends correlate by {correlation:.2}, its largest step is {step_ratio:.2} times that of the texture and its short-time spectrum {spectrum_db:+.1} dB re its strongest: it may be felt; take a longer stroke, or one freed of the gesture"
            ),
            Self::LevelJumps { jump_db, own_db } => write!(
                f,
                "where the texture is joined with itself its level changes by {jump_db:.1} dB, and by {own_db:.1} dB at most elsewhere: it may be felt as a beat; take a stroke that neither grows nor decays"
            ),
            Self::OtherModulation { reference_db, test_db } => write!(
                f,
                "short-time levels spread by {reference_db:.1} dB in the reference and {test_db:.1} dB in the other: one swells and fades, or bursts, more than the other, which spectra and the score do not see; compare them by hand"
            ),
            Self::NotFelt { what, level_db } => write!(
                f,
                "{what} lies {:.1} dB below the detection threshold: it is not felt; check the scale, or raise the level",
                -level_db
            ),
            Self::NoRealIndex { temporal } => write!(
                f,
                "ST-SIM has no value: the temporal similarity is {temporal:.3}, and a negative number has no real power 2/3 (vibromaf 0.0.8 gives a complex one); use the score"
            ),
            Self::IndexBeyondRange { value } => write!(
                f,
                "ST-SIM is {value:.3}, above its range of 0 to 1: the published formula says nothing where the test excites more than the reference; exchange the two, or use the score"
            ),
            Self::NoIndices { why } => write!(f, "ST-SIM and SPQI are left out: {why}"),
            Self::WaveformNotCompared { why } => write!(f, "the waveforms are not compared: {why}"),
            Self::Verification(doubt) => doubt.fmt(f),
            Self::ShortSignal { segments } => write!(
                f,
                "the spectrum is the mean of {segments} segment(s): it scatters by about {:.1} dB; take a longer signal",
                4.34 * (1.0 / (*segments).max(1) as f64).sqrt()
            ),
            Self::Signal(doubt) => doubt.fmt(f),
            Self::Force(doubt) => fmt::Display::fmt(doubt, f),
            Self::Rehearsal(doubt) => fmt::Display::fmt(doubt, f),
            Self::Run(doubt) => fmt::Display::fmt(doubt, f),
            Self::Discrimination(doubt) => doubt.fmt(f),
        }
    }
}
