"""Takes eye movements out of an EEG recording by independent components, in MNE-Python.

    python clean.py RECORDING CLEANED.vhdr --eog VEOG,HEOG --reference average

RECORDING is a file that MNE reads (BrainVision, EDF, BDF, EEGLAB, FIF). CLEANED holds the electrodes and the markers,
and `piezotact eeg` reads it: BrainVision (.vhdr), or EDF+ (.edf).
"""

import argparse

import mne


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording")
    parser.add_argument("cleaned")
    parser.add_argument("--eog", required=True, help="EOG channels, separated by commas")
    parser.add_argument("--reference", help="average, or channels separated by commas; default: as recorded")
    parser.add_argument("--components", type=int, default=20, help="how many components are looked for")
    parser.add_argument("--correlation", type=float, default=0.7, help="the least correlation of a component with an EOG channel")
    args = parser.parse_args()

    raw = mne.io.read_raw(args.recording, preload=True)
    eog = args.eog.split(",")
    raw.set_channel_types(dict.fromkeys(eog, "eog"))

    # Slow drifts would become components of their own: they are found above 1 Hz, and taken out of the whole recording.
    band = raw.copy().filter(1.0, 40.0)
    ica = mne.preprocessing.ICA(args.components, method="infomax", fit_params={"extended": True}, max_iter=500, random_state=1)
    ica.fit(band, picks="eeg", decim=2)
    found, correlations = ica.find_bads_eog(band, ch_name=eog, measure="correlation", threshold=args.correlation)
    # Look at them before you rely on it: ica.plot_components(), ica.plot_sources(band).
    ica.exclude = found
    for number in found:
        strongest = max(abs(of[number]) for of in correlations)
        print(f"component {number}: correlation {strongest:.2f}, taken out")
    if not found:
        raise SystemExit("no component follows an EOG channel: look at the components, or state a lower --correlation")
    ica.apply(raw)

    if args.reference:
        raw.set_eeg_reference("average" if args.reference == "average" else args.reference.split(","))
    # The export rounds times of markers down, and some are read a little early: a tenth of a sample keeps each on its own.
    raw.annotations.onset += 0.1 / raw.info["sfreq"]
    raw.pick("eeg").export(args.cleaned, overwrite=True)


if __name__ == "__main__":
    main()
