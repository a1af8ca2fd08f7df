//! One module for each command.

mod align;
#[cfg(feature = "study")]
mod bids;
mod burst;
#[cfg(feature = "study")]
mod campaign;
mod characterise;
mod demo;
#[cfg(feature = "study")]
mod eeg;
mod export;
mod info;
#[cfg(not(feature = "every-command"))]
mod lacking;
pub(crate) mod manipulate;
mod manual;
#[cfg(feature = "study")]
mod matrix;
mod noise;
pub(crate) mod panel;
mod play;
mod prepare;
mod record;
mod render;
mod replay;
pub(crate) mod rerun;
#[cfg(feature = "surface")]
mod roughness;
mod score;
#[cfg(feature = "web")]
mod serve;
pub(crate) mod sound;
mod spectrum;
pub(crate) mod touch;
mod transfer;
pub(crate) mod twin;
mod verify;

use std::ffi::OsString;

use clap::{CommandFactory as _, FromArgMatches as _, Subcommand};

use crate::arguments::Arguments;
use crate::cli::{self, Cli};
use crate::failure::Outcome;
use crate::invocation;
use crate::output::{message, say};
use crate::progress::Work;
use crate::replacing::Existing;

#[cfg(not(feature = "study"))]
lacking::lacking! {
    bids(Bids), "bids";
    campaign(Campaign), "campaign";
    eeg(Eeg), "eeg";
    matrix(Arguments), "matrix";
}
#[cfg(not(feature = "web"))]
lacking::lacking! { serve(Arguments), "serve"; }
#[cfg(not(feature = "surface"))]
lacking::lacking! { roughness(Arguments), "roughness"; }

/// One line for each command: its name with its arguments, which its help stands above, and what runs it.
macro_rules! commands {
    ($($(#[$help:meta])* $name:ident($arguments:ty) => $run:path,)*) => {
        #[derive(Debug, Subcommand)]
        pub(crate) enum Command {
            $($(#[$help])* $name($arguments),)*
        }

        fn done(command: &Command) -> Outcome {
            match command {
                $(Command::$name(arguments) => $run(arguments),)*
            }
        }
    };
}

/// The command line, with the options that every report has.
pub(crate) fn command() -> clap::Command {
    let command = crate::parts::with_options(Cli::command());
    #[cfg(not(feature = "every-command"))]
    let command = lacking::marked(command);
    command
}

/// Does what `words` ask for, the first of which is the name of the program.
pub(crate) fn run(words: &[OsString]) -> Outcome {
    let mut command = command();
    let parsed = command.try_get_matches_from_mut(words);
    let matches = parsed.unwrap_or_else(|error| refused(&error));
    let cli = Cli::from_arg_matches(&matches);
    let cli = cli.unwrap_or_else(|error| refused(&error.format(&mut command)));
    let arguments = Arguments::of(&command, &matches);
    let existing = match arguments.value("bench") {
        _ if cli.force => Existing::Replaced,
        // Nobody sits at a bench for what is refused at the end. What `prepare` computes is compared before it is played.
        Some(_) if arguments.names != ["prepare"] => Existing::Refused,
        _ => Existing::Compared,
    };
    invocation::begin(words, &arguments, cli.date.as_deref(), existing)?;
    let _shown = Work::one(format!("piezotact {}", arguments.names.join(" ")));
    done(&cli.command)
}

/// Shows why a command line is refused, or the help that it asks for, and ends.
fn refused(error: &clap::Error) -> ! {
    let text = error.render().to_string();
    let shown = message(&text);
    if shown == text {
        error.exit();
    }
    say(shown.trim_end());
    std::process::exit(2);
}

commands! {
    /// Runs the complete chain on the digital twin (record, characterise, render, play, verify) and writes a report.
    #[command(after_help = "Example:\n  piezotact demo --out demo --seed 7")]
    Demo(cli::Demo) => demo::run,
    /// Shows the contents of a file: channels, units, sampling rate, duration, warnings.
    #[command(
        after_help = "Example:\n  piezotact info measured.parquet\n  piezotact info texture.wav --scale \"200 m/s2\" --json"
    )]
    Info(cli::Info) => info::run,
    /// Estimates the power spectral density (PSD) of one channel, averaged or over time.
    #[command(
        after_help = "Example:\n  piezotact spectrum texture.wav --scale \"200 m/s2\" --svg psd.svg\n  piezotact spectrum texture.wav --scale \"200 m/s2\" --spectrogram time.svg --max-frequency 500\n  piezotact spectrum measured.parquet --channel acceleration --json > psd.json"
    )]
    Spectrum(cli::Spectrum) => spectrum::run,
    /// Measures the noise of a sensor at rest: noise floor, mains hum, drift.
    #[command(
        after_help = "It also says whether the sensor was at rest. The exit code is 0 whatever it finds.\n\nExample:\n  piezotact noise rest.parquet --channel acceleration --report noise.html"
    )]
    Noise(noise::Arguments) => noise::run,
    /// Measures the transfer function of a device with a finger on it.
    #[command(
        after_help = "Example:\n  piezotact characterise --bench twin:participant=1,seed=7 --seconds 60 --out tf.json\n  piezotact characterise --bench twin:participant=1,seed=7 --excitation multisine --repeats 3 --out tf.json"
    )]
    Characterise(cli::Characterise) => characterise::run,
    /// Estimates the transfer function between two channels of a recording.
    #[command(
        after_help = "Example:\n  piezotact transfer bench.csv --drive drive --response nail --gain B3 --volts-per-full-scale 1.41 --out tf.json"
    )]
    Transfer(cli::Transfer) => transfer::run,
    /// Manipulates a texture (level, spectrum, phases, duration) and stores every operation with the result.
    #[command(
        after_help = "Operations are applied in the order given and stored in OUT.wav.json; `piezotact info` shows them.\n\nExample:\n  piezotact manipulate S2.wav --rms-of S13.wav --out S2inv.wav --report S2inv.html\n  piezotact manipulate S8.parquet --stroke 2 --band 50..100:+6dB --tilt 3dB/oct@200Hz --loop 10s --out S8b.wav\n  piezotact manipulate S8.wav --gain -3dB --shift 20Hz --warp 1.25:keep-length --out S8c.wav\n  piezotact manipulate S8.wav --spectrum-of S1.wav --randomise-phases --seed 7 --out S8d.wav"
    )]
    Manipulate(cli::manipulate::Manipulate) => manipulate::run,
    /// Computes the drive that reproduces a texture on a resting finger.
    #[command(
        after_help = "Example:\n  piezotact render texture.wav --scale \"200 m/s2\" --transfer tf.json --out drive.wav\n  piezotact render texture.wav --scale \"200 m/s2\" --transfer tf.json --mode texture --bench twin:participant=1,seed=7 --out drive.wav"
    )]
    Render(cli::Render) => render::run,
    /// Plays a drive on a bench and records the response of the finger.
    #[command(
        after_help = "Example:\n  piezotact play drive.wav --bench twin:participant=1,seed=7 --record measured.parquet\n  piezotact play drive.wav --bench measured:hand.json,seed=7 --record rehearsed.parquet"
    )]
    Play(cli::Play) => play::run,
    /// Records what the sensors of a bench acquire while a person touches something; nothing is played.
    #[command(
        after_help = "On a terminal, the level of the vibration, the normal force (mean of ten seconds and present value) with its target, the strokes\nand the time left are shown meanwhile. `piezotact segment` cuts the recording into strokes.\n\nExample:\n  piezotact record --bench audio:setup.toml --sample S8 --speed 30mm/s --load 0.2 --strokes 15 --metronome 2 --seconds 60 --out S8.parquet"
    )]
    Record(record::Arguments) => record::run,
    /// Adds a synchronisation burst before and after a drive, so that what another system records can be aligned whatever the drive is.
    #[command(
        after_help = "The burst before the drive sweeps the band upwards, that after it downwards; where they are stands in the sidecar, where `piezotact align`\nfinds it. Keep the sidecar beside the file.\n\nExample:\n  piezotact burst drive.wav --out with.wav\n  piezotact burst drive.wav --band 80..500 --duration 1 --peak 0.1 --out with.wav"
    )]
    Burst(burst::Arguments) => burst::run,
    /// Places what another system recorded on the clock of the drive that was played: offset, drift, and their uncertainty.
    #[command(
        after_help = "The two systems may have other rates and clocks, and the recording may begin and end at any time. A drive that repeats, such as\na tone, needs the bursts of `piezotact burst`. The delay of the device is in the offset. With --out, `piezotact transfer`\nestimates the transfer function from the file.\n\nExample:\n  piezotact align drive.wav dewesoft.csv --channel nail --report align.html\n  piezotact align drive.wav other.mat --out aligned.parquet\n  piezotact transfer aligned.parquet --drive drive --response nail --out tf.json"
    )]
    Align(align::Arguments) => align::run,
    /// Verifies how close a measurement is to its target.
    #[command(
        after_help = "Example:\n  piezotact verify --target texture.wav --scale \"200 m/s2\" --measured measured.parquet --report report.html\n  piezotact verify --target S7.wav --measured own.parquet --also averaged.parquet --transfer tf.json --report report.html\n  piezotact verify --target S2inv.wav --measured measured.parquet --before S2.wav --before S13.wav --report report.html"
    )]
    Verify(cli::Verify) => verify::run,
    /// Prepares one verified drive for each texture from the strokes of a participant who has just touched the samples.
    #[command(
        after_help = "Of each texture, the stroke closest to the median of its strokes is rendered; all textures are rendered at one level, so\nthat differences in level between them are kept; every drive is played on --bench, measured and compared with its\nstroke. Exit code: 0 all passed, 3 one not passed, 4 one passed in part, 5 one not decided or not measured.\n\nExample:\n  piezotact prepare S1.parquet S8.parquet --transfer tf.json --bench twin:participant=1,seed=7 --out prepared --report prepared.html"
    )]
    Prepare(prepare::Arguments) => prepare::run,
    /// Estimates whether a person can discriminate two vibrations, in just-noticeable differences (JND).
    #[command(
        after_help = "The score is the largest difference in spectrum, level and balance of low and high frequencies, above the detection\nthreshold, in JND. It does not depend on which realisation of a texture was recorded. Verdict: below the just-noticeable\ndifference (75 % of judgements correct) when the whole 95 % interval is below 1 JND; distinguishable when the whole\ninterval is above the published range (2.5 dB); otherwise not decided. The exit code is 0 for every verdict.\n\nExample:\n  piezotact score texture.wav measured.parquet --scale \"200 m/s2\" --report score.html\n  piezotact score S8.wav S8-synthetic.wav --scale \"200 m/s2\" --band 20..500 --json"
    )]
    Score(cli::Score) => score::run,
    /// Cuts recordings into strokes and lists what was rejected, with the reason.
    #[command(
        after_help = "Example:\n  piezotact segment S8.parquet --report cuts.html\n  piezotact segment S8.parquet --write-cuts S8.parquet.cuts\n\nThe file RECORDING.cuts, beside the recording, can be edited by hand; all commands then apply it."
    )]
    Segment(cli::Segment) => touch::segment::run,
    /// Computes vibration, spectral and friction features of the strokes, for each stroke and averaged.
    #[command(
        after_help = "Example:\n  piezotact analyse S*.parquet --by sample --report chapter3.html --csv strokes.csv\n  piezotact analyse bench/*.csv --meta '{participant}_{sample}_{speed:mm/s}mmps' --ridge 0.545mm --json"
    )]
    Analyse(cli::Analyse) => touch::analyse::run,
    /// Compares samples, speeds, participants, or active with passive touch.
    #[command(
        after_help = "Two samples are distinguishable when a permutation test of their strokes is significant (5 % over all pairs), and\nthe whole 95 % interval of their distance is above the published range of the just-noticeable difference (JND) and\nabove the distance between halves of one sample. Distance, JND and detection threshold are those of `piezotact score`;\nthey need accelerations in m/s².\n\nExample:\n  piezotact compare Board2mm_*.csv --by speed --json\n  piezotact compare passive/S*.parquet active/S*.parquet --by touch --report comparison.html"
    )]
    Compare(cli::Compare) => touch::compare::run,
    /// Computes the roughness of a measured profile or height map.
    #[command(
        after_help = "Profiles give Ra, Rq, Rz, Rt, Rp, Rv, Rsk, Rku, RSm, Rdq, Rk, Rpk, Rvk, Mr1, Mr2; maps Sa, Sq, Sz, Sp, Sv, Ssk, Sku, Sdq, Sdr, Sal, Str.\nWith --filter none only the mean height is removed, unless --form states another form. The settings of a\nSurfcom profile (.tx3) are read beside it. Several files are ordered by Ra; one that fails does not stop the others. --csv holds the points of the primary and the\nroughness profile; of several files or a map, the parameters.\n\nExample:\n  piezotact roughness S*.tx2 --report set.html\n  piezotact roughness plate.x3p --report roughness.html\n  piezotact roughness line.txt --cutoff 2.5mm --x-unit mm --z-unit um --json"
    )]
    Roughness(roughness::Arguments) => roughness::run,
    /// Computes association matrices of participants' answers: what was presented, and what it was declared to be.
    #[command(
        after_help = "Columns of the table, between commas or semicolons: participant, task, trial, presented, answered; optional are set, session,\nposition, offered (the samples that could be answered), source and expected (of a manipulated texture), flags\n(missed_target, not_measured, wrong_sample, simulated), rehearsal (yes, no) and judge (of virtual volunteers). A pair of which neither was\npresented while the other could be answered is untested: n/a, not 0 %.\n\nExample:\n  piezotact matrix answers.csv --report matrices.html\n  piezotact matrix answers.csv --samples S1,S2,S3,S4 --by task --ordering 1 --csv cells.csv\n  piezotact matrix answers.csv --felt prepared --report matrices.html"
    )]
    Matrix(matrix::Arguments) => matrix::run,
    /// Designs campaigns with volunteers: protocols, the check of a design, the data dictionary.
    Campaign(campaign::Campaign) => campaign::run,
    /// Exports, imports and checks studies in the Brain Imaging Data Structure (BIDS), which other programs open.
    Bids(bids::Bids) => bids::run,
    /// Analyses EEG: epochs, event-related desynchronisation, and what differs over participants.
    Eeg(eeg::Eeg) => eeg::run,
    /// Leads a session with a participant on pages of a browser (experimenter, participant, one to look on), shows a study, or opens the console of a bench.
    #[command(
        after_help = "A session is the same as that of `piezotact campaign run`, which goes on with it, and the other way round. STUDY alone shows\nits sessions with their reports, matrices and tables. Without STUDY, --bench opens the console of that\nbench. The pages are served on this machine only, unless --network opens them to others; the addresses that are printed\nhold the codes that let a page in.\n\nExample:\n  piezotact serve study P01 discrimination --drives P01 --bench twin:participant=1,seed=7\n  piezotact serve study P01 discrimination --by-hand --network 192.168.1.10 --password password.txt\n  piezotact serve --bench twin:participant=1,seed=7"
    )]
    Serve(serve::Arguments) => serve::run,
    /// Measures, collects, analyses and averages the transfer functions of a panel of participants.
    Panel(cli::panel::Panel) => panel::run,
    /// Lists sound systems and sound devices with their rates, channels and buffers.
    #[command(after_help = "Example:\n  piezotact devices\n  piezotact devices --host jack --json")]
    Devices(sound::devices::Arguments) => sound::devices::run,
    /// Calibrates a sound device: volts at full scale, sensitivities of inputs, cables, the level of its loopback.
    #[command(
        after_help = "What was calibrated before is kept, where it is of the same device. A bench opens only if its loopback is within 0.1 dB of the\ncalibration. Each sensor is calibrated by --exciter, or by its stated sensitivity and --input-volts.\n\nExample:\n  piezotact calibrate setup.toml --tone 20\n  piezotact calibrate setup.toml --voltmeter 0.349 --wires\n  piezotact calibrate setup.toml --exciter 2"
    )]
    Calibrate(sound::calibrate::Arguments) => sound::calibrate::run,
    /// Measures the latency of a sound device from output to input over restarts of its streams.
    #[command(
        after_help = "Median, 95 % and 99 % are stored beside the set-up, and stand in every later recording.\n\nExample:\n  piezotact latency setup.toml\n  piezotact latency setup.toml --restarts 200 --json"
    )]
    Latency(sound::latency::Arguments) => sound::latency::run,
    /// Exports a texture, a drive or a transfer function for other devices and programs, and lists what the format loses.
    #[command(
        after_help = "The file extension selects the format: .wav (32-bit float at 48 kHz, with a sidecar), .hjif (MPEG haptics), .haptic (clips for consumer\ndevices), .ahap (Apple), .uff (universal file). A .haptic clip is converted to .ahap as NiceVibrations does.\n\nExample:\n  piezotact export texture.wav --scale \"200 m/s2\" --out texture.haptic\n  piezotact export drive.wav --transfer tf.json --out drive.hjif\n  piezotact export tf.json --out tf.uff"
    )]
    Export(cli::Export) => export::run,
    /// Simulates recordings and surfaces with the digital twin: samples, participants and benches without hardware.
    Twin(cli::twin::Twin) => twin::run,
    /// Repeats the measurements of the thesis on the digital twin and reports which of its claims hold there.
    #[command(
        after_help = "Not in this program: it is now `piezotact-validation replay`, which ./x validate builds and runs.\n\nExample:\n  ./x validate replay --chapter 3 --out replay"
    )]
    Replay(replay::Arguments) => replay::run,
    /// Writes completions for the shells and man pages into a folder, as `./x build` does.
    #[command(hide = true, after_help = "Example:\n  piezotact manual .")]
    Manual(manual::Arguments) => manual::run,
    /// Runs the command again that made a report or a document, and compares every value.
    #[command(
        after_help = "Executed is this program alone, with the command that the file states and its outputs in a temporary folder, which is\nremoved. Read are the files that the command names. Relative paths begin in the folder of the first run, or in that\nof the file where its inputs are found there. Exit codes: 0 the same, 3 different, 1 cannot be run again.\n\nExample:\n  piezotact rerun report.html\n  piezotact rerun demo/verification.json --json"
    )]
    Rerun(rerun::Arguments) => rerun::run,
}
