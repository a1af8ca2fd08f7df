//! What a result leaves open. A value that had to be clamped, gated, guessed or estimated from little
//! comes back with a [`Doubt`] that says what was seen and what to do about it, and it reaches the report.

mod merged;
mod text;

pub use merged::{Merged, Range, merged, merged_of};

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
        /// How far the delay may be off, s.
        #[serde(default)]
        reach_s: f64,
    },
    /// The answer comes before the drive.
    Acausal {
        /// How much before, s.
        lead_s: f64,
        /// How far that may be off, s.
        #[serde(default)]
        reach_s: f64,
    },
    /// The drive has the unit of a response, and the response that of a drive.
    SwappedUnits {
        /// The drive's unit.
        drive: String,
        /// The response's unit.
        response: String,
    },
    /// Part of the band was not driven.
    NotDriven {
        /// The parts.
        bands: Vec<Band>,
        /// Their share of the band, 0–1.
        share: f64,
    },
    /// A resonance that is narrower than segments of this length resolve.
    UnresolvedResonance {
        /// Where, Hz.
        at_hz: f64,
        /// The lines within its half-power bandwidth.
        lines: f64,
        /// The step between lines, Hz.
        resolution_hz: f64,
    },
    /// A closed loop got worse and was stopped.
    LoopStopped {
        /// The iteration that was best.
        best: usize,
        /// Why it was stopped.
        why: String,
    },
    /// Repeats of one measurement differ.
    RepeatsScatter {
        /// How far the two that differ most lie apart, dB rms.
        db_rms: f64,
    },
    /// The device distorts.
    Nonlinear {
        /// Distortion re the answer, dB.
        level_db: f64,
        /// Where it is loudest.
        band_hz: Band,
    },
    /// The force takes power out of the finger: one of two channels has the wrong sign.
    PolarityInverted,
    /// Frequencies in the band that the inverse gives up.
    GivenUp {
        /// The bands given up.
        bands: Vec<Band>,
        /// Their share of the band's lines, 0–1.
        share: f64,
    },
    /// Frequencies that were turned down on purpose, so that the drive fits.
    TurnedDown {
        /// The bands of which more than half a decibel was taken.
        bands: Vec<Band>,
        /// Their share of the band's lines, 0–1.
        share: f64,
        /// The level, re the one asked for, at which nothing has to be, dB.
        fits_at_db: f64,
    },
    /// Lines of the target that the sensor's noise hides.
    TargetInNoise {
        /// Their share of the band's lines, 0–1.
        share: f64,
        /// The bands in which they lie.
        bands: Vec<Band>,
    },
    /// The crests of a drive were pressed down, and its waveform with them.
    CrestsPressed {
        /// The correlation with the drive as it was asked for.
        correlation: f64,
    },
    /// Samples at the limit.
    Clipped {
        /// What clips: a channel or the stage of the device.
        what: String,
        /// The share of samples at the limit, 0–1.
        fraction: f64,
    },
    /// Drive and response are no more alike than two unrelated signals.
    Unrelated {
        /// The mean coherence of the lines that are driven.
        #[serde(alias = "median_coherence")]
        coherence: f64,
        /// What it exceeds in 5 % of unrelated pairs; 0 in files of before.
        #[serde(default)]
        limit: f64,
        /// Independent averages; 0 in files of before.
        #[serde(default)]
        averages: f64,
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
    /// A rate was stated for a file that states its own and keeps it.
    RateNotUsed {
        /// The rate stated, Hz.
        stated_hz: f64,
        /// The rate of the file, Hz.
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
    /// A file format cannot carry part of what is written to it.
    FormatLoses {
        /// The format.
        format: String,
        /// What it does not carry.
        what: String,
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
    /// No channel says whether the load was held.
    ForceNotMeasured {
        /// The load that the condition says, N.
        load_n: f64,
    },
    /// A drive was played through a transfer function that was measured before.
    Rehearsed {
        /// The transfer function and where it comes from.
        through: String,
        /// Where it answers.
        answers_hz: Band,
        /// How many doubts it carries of its own.
        own_doubts: usize,
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
    /// A verification judges part of the band alone.
    PartJudged {
        /// The share of the band's lines that are judged, 0–1.
        share: f64,
        /// What the drive was made to reach.
        judged: Vec<Band>,
        /// The band that was asked for.
        band: Band,
    },
    /// The measurement holds power where the target has none.
    PowerAdded {
        /// That power over the target's.
        ratio: f64,
    },
    /// A loop ended further from its target than the limit.
    TargetMissed {
        /// The rms error of the spectrum that is left, dB.
        error_db_rms: f64,
        /// The limit, dB.
        limit_db: f64,
    },
    /// Much of a texture's power lies outside the band that is rendered.
    PowerOutsideBand {
        /// The share of its power, 0–1.
        share: f64,
        /// The band.
        band: Band,
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
    /// A panel in which somebody was not measured in every cell.
    IncompletePanel {
        /// Who and where.
        missing: Vec<String>,
        /// How many people are complete.
        complete: usize,
        /// Of how many.
        participants: usize,
    },
    /// Fewer people than a panel needs to say how sure it is.
    FewPeople {
        /// How many.
        participants: usize,
        /// What is recommended.
        recommended: usize,
    },
    /// A person whose transfer function is unlike everybody else's.
    OddOneOut {
        /// The pseudonym.
        participant: String,
        /// Load and angle.
        at: String,
        /// How far it is from the mean curve, dB rms.
        db_rms: f64,
        /// How far the usual person is, dB rms.
        usual_db_rms: f64,
    },
    /// Repeats of one person that differ as those of different people do.
    MixedRepeats {
        /// Repeats or placements.
        what: String,
        /// Who and where.
        of: String,
        /// How far two of them are apart, dB rms.
        db_rms: f64,
        /// How far they usually are, dB rms.
        usual_db_rms: f64,
    },
    /// A measurement whose sign is opposite to most others' of the same load and angle.
    OppositeSign {
        /// Which.
        measurement: String,
        /// To how many of the others it is opposite.
        count: usize,
        /// How many others there are.
        of: usize,
        /// One of them.
        such_as: String,
    },
    /// A measurement whose provenance names somebody else.
    OtherParticipant {
        /// Under what it is filed.
        measurement: String,
        /// Whom it names.
        found: String,
    },
    /// Measurements of digital twins of different seeds.
    SeveralTwins {
        /// One, with its seed.
        one: String,
        /// Another.
        other: String,
    },
    /// Measurements that carry doubts of their own.
    OfMembers {
        /// How many.
        count: usize,
        /// Of how many.
        of: usize,
        /// One of them.
        example: String,
    },
    /// A transfer function that is an average over people.
    Averaged {
        /// How many.
        participants: usize,
        /// What it costs a new person, dB rms.
        penalty_db_rms: f64,
        /// The 95 % confidence interval of its mean, dB rms.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        interval_db_rms: Option<[f64; 2]>,
        /// Whom it costs most.
        worst: String,
        /// How much, dB rms.
        worst_db_rms: f64,
    },
    /// A control measurement that was not measured well where it counts.
    ControlIncoherent {
        /// The lowest coherence.
        lowest: f64,
        /// Where, Hz.
        at_hz: f64,
        /// The level asked for.
        asked: f64,
    },
    /// Transfer functions in the folder of a panel that its index does not list.
    NotListed {
        /// Their names.
        files: Vec<String>,
    },
    /// Measurements that a panel plans and lacks.
    NotMeasured {
        /// How many.
        count: usize,
        /// The first of them.
        first: String,
    },
    /// Part of a texture was moved beyond what its rate holds.
    LeftTheBand {
        /// What was done.
        operation: String,
        /// The share of the power, 0–1.
        share: f64,
        /// Half the rate, Hz.
        nyquist_hz: f64,
    },
    /// A texture joined with itself shows where.
    JoinShows {
        /// How alike the two ends are, −1 to 1.
        correlation: f64,
        /// The largest step between two samples at the join, relative to the largest of the texture.
        step_ratio: f64,
        /// The strongest short-time spectrum at the join, relative to the strongest of the texture, dB.
        spectrum_db: f64,
    },
    /// The level of a texture jumps where it is joined with itself.
    LevelJumps {
        /// The change of its short-time level there, dB.
        jump_db: f64,
        /// The largest within the texture, dB.
        own_db: f64,
    },
    /// Two textures swell and fade differently, which spectra do not show.
    OtherModulation {
        /// The spread of short-time levels of the reference, dB.
        reference_db: f64,
        /// That of the other, dB.
        test_db: f64,
    },
    /// A vibration below what can be felt.
    NotFelt {
        /// Which.
        what: String,
        /// Its excitation re the detection threshold, dB.
        level_db: f64,
    },
    /// An index of the literature that is not a real number for these signals.
    NoRealIndex {
        /// The temporal similarity, below zero.
        temporal: f64,
    },
    /// An index of the literature above its range.
    IndexBeyondRange {
        /// ST-SIM.
        value: f64,
    },
    /// The indices of the literature could not be computed.
    NoIndices {
        /// Why.
        why: String,
    },
    /// Waveforms that were not compared.
    WaveformNotCompared {
        /// Why.
        why: String,
    },
    /// Fewer than the signal's segment: too short for a stable spectrum.
    ShortSignal {
        /// Segments in the average.
        segments: usize,
    },
    /// Of a verification.
    #[serde(untagged)]
    Verification(crate::verify::VerifyDoubt),
    /// A signal that broke on its way.
    #[serde(untagged)]
    Signal(crate::integrity::SignalDoubt),
    /// Of a force and its cell.
    #[serde(untagged)]
    Force(crate::stroke::ForceDoubt),
    /// Of a drive that was played through what it was made with.
    #[serde(untagged)]
    Rehearsal(crate::recording::RehearsalDoubt),
    /// What is doubtful of whether vibrations can be told apart.
    #[serde(untagged)]
    Discrimination(crate::discrimination::DiscriminationDoubt),
    /// Of a run on a bench.
    #[serde(untagged)]
    Run(crate::run::RunDoubt),
}
