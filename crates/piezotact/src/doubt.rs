//! What a result leaves open. A value that had to be clamped, gated, guessed or estimated from little
//! comes back with a [`Doubt`] that says what was seen and what to do about it, and it reaches the report.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::quantity::Band;

/// One thing that a person should know before relying on a result. Its text says what was seen and what
/// to do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "doubt", rename_all = "snake_case")]
pub enum Doubt {
    /// Coherence is below what the estimate needs in part of the band.
    LowCoherence {
        /// The level asked for.
        asked: f64,
        /// The lowest coherence in the band.
        lowest: f64,
        /// Where it is lowest, in Hz.
        at_hz: f64,
        /// The share of the band's lines below the level, 0–1.
        share: f64,
    },
    /// A coherence outside 0–1, which no pair of signals can have.
    ImpossibleCoherence {
        /// The frequency of the worst line, Hz.
        at_hz: f64,
        /// The value found there.
        found: f64,
        /// The number of such lines.
        #[serde(default)]
        lines: usize,
    },
    /// Few averages: the estimate scatters.
    FewAverages {
        /// The number of segments averaged.
        averages: usize,
        /// The number recommended.
        recommended: usize,
    },
    /// The response comes so late after the drive that segments no longer hold the same event.
    LateResponse {
        /// The delay in s.
        delay_s: f64,
        /// The length of a segment in s.
        segment_s: f64,
    },
    /// Frequencies in the band that the inverse gives up.
    GivenUp {
        /// The bands given up.
        bands: Vec<Band>,
        /// Their share of the band's lines, 0–1.
        share: f64,
    },
    /// Samples at the limit.
    Clipped {
        /// What clips: a channel or the stage of the device.
        what: String,
        /// The share of samples at the limit, 0–1.
        fraction: f64,
    },
    /// Drive and response have next to nothing in common.
    Unrelated {
        /// The median coherence of the lines that are driven.
        median_coherence: f64,
    },
    /// The device behind a transfer function is not described: only the digital full scale limits the drive.
    DeviceNotDescribed,
    /// A measurement was made under another condition than the one its drive was rendered for.
    OtherCondition {
        /// What differs.
        what: String,
        /// As rendered for.
        rendered_for: String,
        /// As measured.
        measured: String,
    },
    /// A measurement is compared with another texture than the one its drive was rendered from.
    OtherTarget {
        /// What the drive was rendered from.
        rendered: String,
        /// What it is compared with.
        compared: String,
    },
    /// A rate was stated for a file whose own time stamps say another.
    RateStated {
        /// The rate stated, Hz.
        stated_hz: f64,
        /// The rate of the time stamps, Hz.
        found_hz: f64,
    },
    /// The measurement follows its target with the sign reversed.
    Inverted {
        /// The correlation, below zero.
        correlation: f64,
    },
    /// Not all of a drive was played, or the output ran dry.
    PlaybackIncomplete {
        /// Samples played.
        played: usize,
        /// Samples of the drive.
        expected: usize,
        /// Times the output ran dry.
        underruns: usize,
    },
    /// A later recording of the same name was interrupted.
    InterruptedLater {
        /// Where its journal is.
        journal: String,
    },
    /// The amplifier cannot follow the drive into the capacitive load.
    SlewLimited {
        /// The steepest slope asked for, V/s.
        asked_v_per_s: f64,
        /// What the amplifier can do, V/s.
        limit_v_per_s: f64,
    },
    /// No physical scale is known for a signal.
    Uncalibrated {
        /// The channel.
        channel: String,
    },
    /// Two scales are given for one file.
    ScaleOverridden {
        /// The scale that was used.
        used: String,
        /// The scale in the sidecar that was not.
        ignored: String,
    },
    /// Two signals were brought to one rate.
    RateConverted {
        /// What was converted.
        what: String,
        /// Its own rate in Hz.
        from_hz: f64,
        /// The rate it was brought to, in Hz.
        to_hz: f64,
    },
    /// The target and the transfer function come from recordings of different rates.
    RatesDiffer {
        /// The target's rate in Hz.
        target_hz: f64,
        /// The rate of the recording behind the transfer function, in Hz.
        transfer_hz: f64,
    },
    /// Something the file does not say was read off its content.
    Guessed {
        /// What was guessed, and from what.
        what: String,
    },
    /// The time stamps are not evenly spaced.
    UnevenSampling {
        /// The largest departure from the mean step, as a share of it.
        worst: f64,
    },
    /// A recording that has no end document: it was interrupted, or is still running.
    Interrupted {
        /// How much could be read, in s.
        read_s: f64,
    },
    /// The signal uses so few steps of the converter that quantisation shows.
    CoarseQuantisation {
        /// The channel.
        channel: String,
        /// The rms level in quantisation steps.
        rms_in_steps: f64,
    },
    /// The mean normal force was not what the condition says.
    LoadOffTarget {
        /// The mean force in N.
        mean_n: f64,
        /// The target in N.
        target_n: f64,
    },
    /// Part of the band holds next to no target: its error in dB says nothing and is left out.
    NoTargetPower {
        /// The share of the band's lines left out, 0–1.
        share: f64,
    },
    /// The measurement ends before the target does.
    Cut {
        /// How much of the target was compared, in s.
        compared_s: f64,
        /// How long the target is, in s.
        target_s: f64,
    },
    /// The texture was rendered at another level on purpose, and is compared at that level.
    LevelChanged {
        /// The level relative to the target, dB.
        level_db: f64,
    },
    /// No channel says where strokes are: the whole recording is taken as one.
    NothingCut,
    /// Nothing touches in a recording.
    NoContact {
        /// The largest force above the baseline, N.
        largest_n: f64,
        /// What a contact needs, N.
        threshold_n: f64,
    },
    /// Neither vibration nor friction says whether the finger slides.
    SlidingAssumed,
    /// No force says whether the finger touches.
    ContactAssumed,
    /// The forces never leave one level: their zeros are not known.
    ZeroUnknown,
    /// The zero of a force cell drifts.
    ForceDrift {
        /// The lowest baseline, N.
        from_n: f64,
        /// The highest baseline, N.
        to_n: f64,
        /// What a contact needs, N.
        threshold_n: f64,
    },
    /// A force that is negative in contact was taken with its sign reversed.
    SignReversed {
        /// The channel.
        channel: String,
    },
    /// More friction than skin usually has.
    HighFriction {
        /// The median friction coefficient.
        coefficient: f64,
    },
    /// A stroke much longer than others: maybe two.
    LongStroke {
        /// Where it begins, s.
        at_s: f64,
        /// How long it is, s.
        length_s: f64,
        /// How long the usual one is, s.
        usual_s: f64,
    },
    /// Recordings that have nothing to be compared with.
    NotCompared {
        /// Their names.
        recordings: String,
    },
    /// Strokes that differ far more than strokes of one texture do.
    Scattered {
        /// The group.
        group: String,
        /// The standard deviation of the rms as a share of its mean.
        share: f64,
    },
    /// The speed was not what was asked for.
    SpeedOffTarget {
        /// The median speed of the plateaus, m/s.
        mean_m_s: f64,
        /// The speed asked for, m/s.
        target_m_s: f64,
    },
    /// A channel that never changes.
    DeadChannel {
        /// The channel.
        channel: String,
    },
    /// Strokes too short for a spectrum with the lines of the others.
    ShortStrokes {
        /// How many.
        count: usize,
        /// What is needed, s.
        needed_s: f64,
    },
    /// Few strokes: their average scatters.
    FewStrokes {
        /// What was recorded.
        what: String,
        /// Strokes kept.
        kept: usize,
        /// The number recommended.
        recommended: usize,
    },
    /// Parts of a recording that looked like strokes were rejected.
    Rejected {
        /// How many.
        count: usize,
        /// Of how many.
        of: usize,
        /// The reasons and how often each.
        reasons: String,
    },
    /// A group holds recordings that differ in more than chance.
    Pooled {
        /// The group.
        group: String,
        /// In what they differ.
        what: String,
    },
    /// Most of the power lies below the band of vibration, and was not filtered out.
    GestureKept {
        /// The share of the power, 0–1.
        share: f64,
        /// Below this frequency, Hz.
        below_hz: f64,
    },
    /// A person's cuts that lie outside the recording.
    CutsNotApplied {
        /// The file of cuts.
        file: String,
        /// How many.
        count: usize,
    },
    /// No spatial period stands out at all speeds.
    NoCommonPeriod {
        /// How far the strongest candidate stands above the background, dB.
        prominence_db: f64,
    },
    /// A value from so few groups that it has no interval.
    NoInterval {
        /// What.
        what: String,
        /// Groups that it comes from.
        groups: usize,
    },
    /// Part of a height map was not measured.
    MissingPoints {
        /// The share of its points, 0–1.
        share: f64,
    },
    /// Points of a topography that are not evenly spaced were read as if they were.
    UnevenSteps {
        /// The largest departure from the mean step, as a share of it.
        worst: f64,
    },
    /// A roughness parameter from less than the standard's evaluation length.
    ShortEvaluation {
        /// Sections of one cut-off that fit.
        sections: usize,
        /// The number the standard asks for.
        asked: usize,
        /// The cut-off in m.
        cutoff_m: f64,
    },
    /// The stretch of a profile that was evaluated is not like the whole.
    UnevenProfile {
        /// Ra of what was evaluated, m.
        evaluated_ra_m: f64,
        /// Ra of the whole roughness profile, m.
        whole_ra_m: f64,
    },
    /// The cut-off rule did not settle on one cut-off.
    CutoffUnsettled {
        /// The cut-off used, m.
        used_m: f64,
        /// Ra with it, m.
        ra_m: f64,
    },
    /// The autocorrelation of a height map does not fall to its level within the lags that the map holds.
    LongCorrelation {
        /// The level, 0–1.
        level: f64,
        /// How far lags reach, m.
        reached_m: f64,
    },
    /// Fewer than the signal's segment: too short for a stable spectrum.
    ShortSignal {
        /// Segments in the average.
        segments: usize,
    },
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
            Self::LateResponse { delay_s, segment_s } => write!(
                f,
                "the response comes {:.1} ms after the drive, {} of a segment: the magnitude is underestimated; take longer segments or align the channels",
                delay_s * 1e3,
                percent(delay_s / segment_s)
            ),
            Self::GivenUp { bands, share } => {
                write!(f, "the inverse gives up {} of the band (", percent(*share))?;
                for (i, band) in bands.iter().take(4).enumerate() {
                    write!(f, "{}{band}", if i > 0 { ", " } else { "" })?;
                }
                if bands.len() > 4 {
                    write!(f, " and {} more", bands.len() - 4)?;
                }
                f.write_str(
                    "): the device hardly answers there or was not measured well; what is felt there may be missing or wrong",
                )
            }
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
            Self::Unrelated { median_coherence } => write!(
                f,
                "the median coherence of the driven lines is {median_coherence:.3}: drive and response have next to nothing in common; check the channels and the sensor"
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
            Self::LoadOffTarget { mean_n, target_n } => write!(
                f,
                "the mean normal force was {mean_n:.3} N, the condition says {target_n} N: repeat with the force held"
            ),
            Self::NoTargetPower { share } => write!(
                f,
                "{} of the band holds next to no target power and was left out of the error: narrow the band to the texture",
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
                "`{channel}` never changes and is not used: check its cable and its range"
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
            Self::ShortSignal { segments } => write!(
                f,
                "the spectrum is the mean of {segments} segment(s): it scatters by about {:.1} dB; take a longer signal",
                4.34 * (1.0 / (*segments).max(1) as f64).sqrt()
            ),
        }
    }
}
