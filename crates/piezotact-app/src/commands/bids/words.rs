//! What the columns of derived tables mean: name, unit (none where it is empty), and a sentence.

/// The features of strokes; columns that are not here are not carried.
pub(super) const FEATURES: &[(&str, &str, &str)] = &[
    ("sample", "", "The sample that was touched."),
    ("participant", "", "The participant, by the pseudonym."),
    (
        "touch",
        "",
        "Whether the finger moved (active) or the sample (passive).",
    ),
    ("direction", "", "The direction of the sliding."),
    ("load_n", "N", "The stated normal force."),
    ("stated_speed_m_s", "m/s", "The stated speed."),
    (
        "stroke",
        "",
        "The number of the stroke in its recording, from 1.",
    ),
    (
        "start_s",
        "s",
        "Where the steady part of the stroke begins in the recording.",
    ),
    ("duration_s", "s", "How long it lasts."),
    (
        "unit",
        "",
        "The unit u of the vibration, to which rms, peak and powers refer.",
    ),
    (
        "rms",
        "",
        "The rms of the vibration about its mean, in u; of several channels the root of the mean of their squares.",
    ),
    ("peak", "", "The largest departure from the mean, in u."),
    ("crest_factor", "1", "Peak over rms."),
    (
        "merkel_power",
        "",
        "Power in the band of Merkel's cells, in u^2.",
    ),
    (
        "meissner_power",
        "",
        "Power in the band of Meissner's corpuscles, in u^2.",
    ),
    (
        "pacini_power",
        "",
        "Power in the band of Pacini's corpuscles, in u^2.",
    ),
    (
        "ruffini_power",
        "",
        "Power in the band of Ruffini's endings, in u^2.",
    ),
    (
        "centroid_hz",
        "Hz",
        "The mean frequency of the power in the band.",
    ),
    (
        "spread_hz",
        "Hz",
        "The standard deviation of frequency around it.",
    ),
    ("strongest_hz", "Hz", "The strongest line in the band."),
    (
        "friction_mean",
        "1",
        "The mean coefficient of friction, sample by sample.",
    ),
    ("friction_sd", "1", "Its standard deviation over samples."),
    ("friction_median", "1", "Its median over samples."),
    (
        "normal_force_mean_n",
        "N",
        "The mean normal force above its zero.",
    ),
    (
        "normal_force_sd_n",
        "N",
        "Its standard deviation over samples.",
    ),
    ("speed_mean_m_s", "m/s", "The mean magnitude of the speed."),
    (
        "speed_sd_m_s",
        "m/s",
        "Its standard deviation over samples.",
    ),
    (
        "pacinian_power",
        "",
        "Power weighted by the Pacinian threshold; for accelerations only.",
    ),
    (
        "detection_power",
        "",
        "Power weighted by the detection threshold; for accelerations only.",
    ),
    (
        "kurtosis",
        "1",
        "Fourth moment over the square of the second: 3 for Gaussian noise, 1.5 for a tone.",
    ),
    (
        "level_spread_db",
        "dB",
        "The standard deviation of the levels of 0.1 s; n/a for strokes shorter than 0.3 s.",
    ),
    (
        "meissner_level_db",
        "dB",
        "The power in the band of Meissner's corpuscles relative to their threshold: above 0 they detect a steady vibration; for accelerations only.",
    ),
    ("pacini_level_db", "dB", "The same for Pacinian corpuscles."),
    (
        "meissner_from_hz",
        "Hz",
        "The part of Meissner's band that the level is over begins here.",
    ),
    (
        "meissner_level_at_most_db",
        "dB",
        "What that level is at most, with all that the unfiltered signal holds in the rest of the band; n/a where all of it is covered.",
    ),
];

/// The cells of association matrices.
pub(super) const MATRIX: &[(&str, &str, &str)] = &[
    ("group", "", "What the answers were divided by: the task."),
    (
        "presented",
        "",
        "The sample or stimulus that was presented.",
    ),
    ("source", "", "The sample that the stimulus was made of."),
    (
        "expected",
        "",
        "The declaration that counts as right; n/a where none does.",
    ),
    ("answered", "", "What it was declared to be."),
    ("declared", "", "How often it was declared to be that."),
    ("presentations", "", "How often it was presented."),
    ("offered", "", "How often both were offered together."),
    (
        "percent",
        "",
        "Declared over presentations, in percent: of all presentations, also those beside which it was not offered; n/a for a pair that was never offered together.",
    ),
    (
        "percent_low",
        "",
        "Lower end of its 95 % interval over participants, in percent.",
    ),
    (
        "percent_high",
        "",
        "Upper end of its 95 % interval over participants, in percent.",
    ),
    ("participants", "", "How many participants it comes from."),
    ("flagged", "", "How many of the answers have a flag."),
    ("felt_compared", "", "By what the two were compared."),
    (
        "felt_level_jnd",
        "",
        "How far their levels are apart, in just noticeable differences.",
    ),
    (
        "felt_level_separates",
        "",
        "Whether the levels tell them apart.",
    ),
    (
        "felt_spectrum_jnd",
        "",
        "How far their spectra are apart, in just noticeable differences.",
    ),
    (
        "felt_spectrum_separates",
        "",
        "Whether the spectra tell them apart.",
    ),
    (
        "virtual_answers_of_all",
        "",
        "How many of all answers are of virtual volunteers.",
    ),
];

/// Thresholds of adaptive comparisons.
pub(super) const THRESHOLDS: &[(&str, &str, &str)] = &[
    ("participant", "", "The participant, by the pseudonym."),
    ("session", "", "The session."),
    ("task", "", "The task."),
    ("run", "", "The run of the adaptive procedure."),
    (
        "threshold",
        "",
        "The threshold, in the unit of the levels of the task.",
    ),
    (
        "interval_low",
        "",
        "The lower end of the 95 % interval of a decided threshold of QUEST+; a staircase has none.",
    ),
    ("interval_high", "", "Its upper end."),
    (
        "posterior_sd",
        "",
        "The standard deviation of the posterior, of QUEST+.",
    ),
    (
        "reversals_sd",
        "",
        "The standard deviation of the counted reversals of a staircase, no standard error.",
    ),
    ("answers", "", "How many answers it comes from."),
    (
        "decided",
        "",
        "Whether it may be used: met, not met or not decided.",
    ),
    (
        "not_decided_because",
        "",
        "The criteria that are not met or not decided.",
    ),
    (
        "catch_trials_failed",
        "",
        "How many catch trials were answered wrongly.",
    ),
];
