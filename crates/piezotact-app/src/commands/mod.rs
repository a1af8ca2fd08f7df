//! One module for each command.

#[cfg(feature = "study")]
mod answers;
#[cfg(feature = "study")]
mod bids;
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
pub(crate) mod panel;
mod play;
mod prepare;
mod record;
pub(crate) mod refusal;
mod render;
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

use anyhow::anyhow;
use clap::{CommandFactory as _, FromArgMatches as _, Subcommand};

use crate::arguments::Arguments;
use crate::cli::{self, Cli};
use crate::failure::{Failure, Outcome, usage};
use crate::invocation;
use crate::progress::Work;
use crate::replacing::Existing;

#[cfg(not(feature = "study"))]
lacking::lacking! {
    answers(Arguments), "answers";
    bids(Bids), "bids";
    campaign(Campaign), "campaign";
    eeg(Eeg), "eeg";
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
    cli::help::grouped(command)
}

/// Does what `words` ask for, the first of which is the name of the program.
pub(crate) fn run(words: &[OsString]) -> Outcome {
    let (mut command, asked) = cli::help::asked(command(), words);
    let parsed = command.try_get_matches_from_mut(asked);
    let matches = match parsed {
        Ok(matches) => matches,
        Err(error) => {
            let given = words.iter().skip(1).filter_map(|word| word.to_str());
            let sentence = refusal::renamed(&error, &command, given);
            match sentence.or_else(|| refusal::needing(&error, &command, words)) {
                Some(sentence) => return Err(usage(anyhow!(sentence))),
                None => return Err(Failure::Words(Box::new(error))),
            }
        }
    };
    let cli = Cli::from_arg_matches(&matches);
    let cli = cli.map_err(|error| Failure::Words(Box::new(error.format(&mut command))))?;
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

commands! {
    /// Runs the complete chain on the digital twin (record, characterise, render, play, verify) and writes a report.
    #[command(after_help = "Example:\n  piezotact demo --out demo --seed 7")]
    Demo(cli::Demo) => demo::run,
    /// Shows the contents of a file: channels, units, sampling rate, duration, warnings.
    #[command(
        after_help = "Example:\n  piezotact info measured.parquet\n  piezotact info texture.wav --scale \"200 m/s2\" --json"
    )]
    Info(cli::Info) => info::run,
    /// Estimates the power spectral density (PSD) of one channel, averaged or over time, or the noise of a sensor at rest.
    #[command(
        after_help = "With --rest: noise floor, mains hum, drift, and whether the sensor was at rest. The exit code is 0 whatever is found.\n\nExample:\n  piezotact spectrum texture.wav --scale \"200 m/s2\" --report spectrum.html --figures figures\n  piezotact spectrum texture.wav --scale \"200 m/s2\" --report spectrum.html --over-time --max-frequency 500\n  piezotact spectrum measured.parquet --channel acceleration --json > psd.json\n  piezotact spectrum rest.parquet --rest --channel acceleration --report noise.html"
    )]
    Spectrum(cli::Spectrum) => spectrum::run,
    /// Measures the transfer function of a device with a finger on it.
    #[command(
        alias = "characterize",
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
        after_help = "On a terminal, the level of the vibration, the normal force (mean of ten seconds and present value) with its target, the strokes\nand the time left are shown meanwhile. `piezotact strokes` cuts the recording into strokes.\n\nExample:\n  piezotact record --bench audio:setup.toml --sample S8 --speed 30mm/s --load 0.2 --strokes 15 --metronome 2 --seconds 60 --out S8.parquet"
    )]
    Record(record::Arguments) => record::run,
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
        after_help = "The score is the perceived difference in JND, over time and by channel of receptors: level, pitch, modulation, gaps,\nrhythm, course and duration. It does not depend on which realisation of a texture was recorded. Verdict: below the\njust-noticeable difference (79 % of judgements correct) when its whole interval is below 1 JND; distinguishable when the\nwhole interval is above 1 JND and, for two recordings of textures, above twice what parts of one recording differ by;\notherwise not decided. The interval holds published ranges of the JND and the scatter of the estimate. The exit code is 0\nfor every verdict.\n\nExample:\n  piezotact score texture.wav measured.parquet --scale \"200 m/s2\" --report score.html\n  piezotact score S8.wav S8-synthetic.wav --scale \"200 m/s2\" --band 20..500 --json"
    )]
    Score(cli::Score) => score::run,
    /// Cuts recordings into strokes and computes vibration, spectral and friction features of each, and their averages.
    #[command(
        after_help = "With --cuts-only the strokes are cut and listed, with the rejected parts and their reasons. The file RECORDING.cuts, beside the\nrecording, can be edited by hand; all commands then apply it.\n\nExample:\n  piezotact strokes S*.parquet --by sample --report chapter3.html --csv strokes.csv\n  piezotact strokes bench/*.csv --meta '{participant}_{sample}_{speed:mm/s}mmps' --ridge 0.545mm --json\n  piezotact strokes S8.parquet --cuts-only --report cuts.html\n  piezotact strokes S8.parquet --cuts-only --write-cuts S8.parquet.cuts"
    )]
    Strokes(cli::Strokes) => touch::strokes::run,
    /// Compares samples, speeds, participants, or active with passive touch.
    #[command(
        after_help = "Two samples are distinguishable when a permutation test of their strokes is significant (5 % over all pairs), and\nthe whole 95 % interval of their distance is above the published range of the just-noticeable difference (JND) and\nabove the distance between halves of one sample. Distance, JND and detection threshold are those of `piezotact score\n--model spectral`; they need accelerations in m/s². The perceived difference over time (that of\n`piezotact score`) is computed too, as a mean over strokes. Below the JND needs both to be below; with several recordings\nof each sample, the perceived difference alone can show that they are distinguishable.\n\nExample:\n  piezotact compare Board2mm_*.csv --by speed --json\n  piezotact compare passive/S*.parquet active/S*.parquet --by touch --report comparison.html"
    )]
    Compare(cli::Compare) => touch::compare::run,
    /// Computes the roughness of a measured profile or height map.
    #[command(
        after_help = "Profiles give Ra, Rq, Rz, Rt, Rp, Rv, Rsk, Rku, RSm, Rdq, Rk, Rpk, Rvk, Mr1, Mr2; maps Sa, Sq, Sz, Sp, Sv, Ssk, Sku, Sdq, Sdr, Sal, Str, and the period,\nheight and width of dots or ridges. With --along, maps also give the parameters of profiles and the slope of the spectrum of their lines.\nWith --filter none only the mean height is removed, unless --form states another form. The settings of a\nSurfcom profile (.tx3) are read beside it. Several files are ordered by Ra; one that fails does not stop the others. --csv holds the points of the primary and the\nroughness profile; of several files or a map, the parameters.\n\nExample:\n  piezotact roughness S*.tx2 --report set.html\n  piezotact roughness plate.x3p --along x --report roughness.html\n  piezotact roughness line.txt --cutoff 2.5mm --x-unit mm --z-unit um --json"
    )]
    Roughness(roughness::Arguments) => roughness::run,
    /// Computes association matrices of participants' answers: what was presented, and what it was declared to be.
    #[command(
        after_help = "Columns of the table, between commas or semicolons: participant, task, trial, presented, answered; optional are set, session,\nposition, offered (the samples that could be answered), source and expected (of a manipulated texture), flags\n(missed_target, not_measured, wrong_sample, simulated), rehearsal (yes, no) and judge (of virtual volunteers). A pair of which neither was\npresented while the other could be answered is untested: n/a, not 0 %.\n\nExample:\n  piezotact answers answers.csv --report matrices.html\n  piezotact answers answers.csv --samples S1,S2,S3,S4 --by task --ordering 1 --csv cells.csv\n  piezotact answers answers.csv --felt prepared --report matrices.html"
    )]
    Answers(answers::Arguments) => answers::run,
    /// Designs campaigns with volunteers: protocols, the check of a design, the data dictionary.
    Campaign(campaign::Campaign) => campaign::run,
    /// Exports, imports and checks studies in the Brain Imaging Data Structure (BIDS), which other programs open.
    Bids(bids::Bids) => bids::run,
    /// Analyses EEG: epochs, event-related desynchronisation, and what differs over participants.
    Eeg(eeg::Eeg) => eeg::run,
    /// Leads a session with a participant on pages of a browser, shows a study, or opens the console of a bench.
    #[command(
        after_help = "A session is the same as that of `piezotact campaign run`, which goes on with it, and the other way round. STUDY alone shows\nits sessions with their reports, matrices and tables. Without STUDY, --bench opens the console of that\nbench. The pages are served on this machine only, unless --network opens them to others; the addresses that are printed\nhold the codes that let a page in.\n\nExample:\n  piezotact serve study P01 discrimination --drives P01 --bench twin:participant=1,seed=7\n  piezotact serve study P01 discrimination --by-hand --network 192.168.1.10 --password password.txt\n  piezotact serve --bench twin:participant=1,seed=7"
    )]
    Serve(serve::Arguments) => serve::run,
    /// Measures, collects, analyses and averages the transfer functions of a panel of participants.
    Panel(cli::panel::Panel) => panel::run,
    /// Lists, calibrates and measures sound devices; aligns another system's recording with the drive.
    Sound(sound::Sound) => sound::run,
    /// Exports a texture, a drive or a transfer function for other devices and programs, and lists what the format loses.
    #[command(
        after_help = "The file extension selects the format: .wav (32-bit float at 48 kHz, with a sidecar), .hjif (MPEG haptics), .haptic (clips for consumer\ndevices), .ahap (Apple), .uff (universal file). A .haptic clip is converted to .ahap as NiceVibrations does.\n\nExample:\n  piezotact export texture.wav --scale \"200 m/s2\" --out texture.haptic\n  piezotact export drive.wav --transfer tf.json --out drive.hjif\n  piezotact export tf.json --out tf.uff"
    )]
    Export(cli::Export) => export::run,
    /// Simulates recordings and surfaces with the digital twin: samples, participants and benches without hardware.
    Twin(cli::twin::Twin) => twin::run,
    /// Writes completions for the shells and man pages into a folder, as `./x build` does.
    #[command(hide = true, after_help = "Example:\n  piezotact manual .")]
    Manual(manual::Arguments) => manual::run,
    /// Runs the command again that made a report or a document, and compares every value.
    #[command(
        after_help = "Runs only this program, with the command that the file states; its outputs go into a temporary folder, which is removed.\nReads the files that the command names. Relative paths begin in the folder of the first run, or in that\nof the file where its inputs are found there. Exit codes: 0 the same, 3 different, 1 cannot be run again.\n\nExample:\n  piezotact rerun report.html\n  piezotact rerun demo/verification.json --json"
    )]
    Rerun(rerun::Arguments) => rerun::run,
}
