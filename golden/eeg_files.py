"""EEG files as MNE 1.13.2 reads them (edfio 0.4.18 for channels of lower rates, pyxdf 1.17.5 for XDF), for piezotact-dataset to
compare with; and small files of other programs for it to read (eeglabio 0.1.4, edfio, pybv 0.8.1, SciPy 1.17.1, NumPy).

    python3 golden/eeg_files.py [../shared/data/eeg]
    python3 golden/eeg_files.py read FOLDER

The first form writes tests/golden/eeg. Samples are in SI as MNE has them, the index of an event is that of
`mne.events_from_annotations`, and triggers are those of `mne.find_events` with `consecutive=True` and a mask of 16 bits (a code on the way
down that lasts one sample is taken out, and one that lasts to the end is added, which MNE leaves out). The second form
reads back what the Rust test `eeg_written::others_read_what_is_written` wrote to FOLDER (WRITE_EEG_TO=FOLDER) with MNE, edfio and pybv's rules.
"""

import json
import struct
import sys
import warnings
from datetime import datetime, timezone
from importlib.metadata import version
from pathlib import Path

import mne
import numpy as np

mne.set_log_level("ERROR")
warnings.simplefilter("ignore")
out = Path(__file__).parent.parent / "crates/piezotact-dataset/tests/golden/eeg"


def number(value):
    return float(f"{float(value):.15g}")


def channel(name, samples):
    samples = np.asarray(samples, float)
    return {
        "name": name,
        "count": len(samples),
        "mean": number(samples.mean()),
        "first": [number(v) for v in samples[:2]],
        "last": [number(v) for v in samples[-2:]],
    }


def events_of(raw):
    ids = {text: k for k, text in enumerate(sorted(set(raw.annotations.description)))}
    if not ids:
        return []
    found, _ = mne.events_from_annotations(raw, event_id=ids, regexp=None)
    texts = {k: text for text, k in ids.items()}
    return [[int(at - raw.first_samp), texts[k]] for at, _, k in found]


def changes(raw, stim):
    codes = mne.find_events(raw, stim_channel=stim, mask=0xFFFF, mask_type="and", shortest_event=1, consecutive=True)
    found = [[int(at - raw.first_samp), int(code)] for at, _, code in codes]
    values = raw.get_data(picks=[stim])[0].astype(np.int64) & 0xFFFF
    last = np.flatnonzero(np.diff(values))[-1:] + 1
    if len(last) and values[last[0]] and [int(last[0]), int(values[last[0]])] not in found:
        found.append([int(last[0]), int(values[last[0]])])

    def settles(at, code):
        before, after = values[at - 1], values[at + 1] if at + 1 < len(values) else code
        return code & ~before == 0 and after != code and after & ~code == 0

    return [[at, code] for at, code in found if not settles(at, code)]


def golden(path, raw, slower=None, triggers=False):
    """`slower` maps names of channels below the highest rate to their samples, which MNE resamples."""
    slower = slower or {}
    channels = []
    for name in raw.ch_names:
        if name in slower:
            channels.append(channel(name, slower[name]))
        elif triggers and name.lower() in ("status", "trigger"):
            continue
        else:
            channels.append(channel(name, raw.get_data(picks=[name])[0]))
    found = {
        "rate_hz": raw.info["sfreq"],
        "start": raw.info["meas_date"].isoformat() if raw.info["meas_date"] else None,
        "channels": channels,
        "events": events_of(raw),
    }
    if triggers:
        stim = next(n for n in raw.ch_names if n.lower() in ("status", "trigger"))
        found["triggers"] = changes(raw, stim)
    return found


def edf(path):
    import edfio

    is_bdf = path.suffix == ".bdf"
    read = mne.io.read_raw_bdf if is_bdf else mne.io.read_raw_edf
    # EDF+D is refused by edfio; MNE reads it with its gaps closed.
    raw = read(path, preload=True)
    slower = {}
    try:
        other = (edfio.read_bdf if is_bdf else edfio.read_edf)(path)
        for name, signal in zip(raw.ch_names, other.signals):
            if signal.sampling_frequency < raw.info["sfreq"] - 1e-9:
                factor = {"uV": 1e-6, "mV": 1e-3}.get(signal.physical_dimension, 1)
                slower[name] = signal.data * factor
    except (ValueError, NotImplementedError) as error:
        print(f"edfio does not read {path.name}: {error}")
    triggers = any(n.lower() in ("status", "trigger") for n in raw.ch_names)
    return golden(path, raw, slower, triggers)


def rows(count, rate, lasts_s):
    """Channel k is a sine of 100 µV (k = 0), then of 50, 25, … µV, at 10 Hz, 11 Hz, …"""
    t = np.arange(int(rate * lasts_s)) / rate
    return np.array([100e-6 / 2**k * np.sin(2 * np.pi * (10 + k) * t) for k in range(count)])


def raw_of(data, rate):
    info = mne.create_info([f"C{k + 1}" for k in range(len(data))], rate, "eeg")
    return mne.io.RawArray(data, info)


def own_set():
    from scipy.io import savemat

    raw = raw_of(rows(3, 200, 2), 200)
    raw.set_annotations(mne.Annotations([0.1, 0.5, 1.25], [0, 0.2, 0], ["S  1", "S  2", "touch"]))
    raw.export(out / "eeglabio.set", overwrite=True)

    data = rows(2, 100, 3)
    (data.T * 1e6).astype("<f4").tofile(out / "struct.fdt")
    chanlocs = np.zeros(2, [("labels", object), ("type", object)])
    chanlocs["labels"] = ["Cz", "Pz"]
    chanlocs["type"] = ["", ""]
    event = np.zeros(4, [("type", object), ("latency", float), ("duration", float)])
    event["type"] = ["S 1", "boundary", 7, "boundary"]
    event["latency"] = [11, 100.5, 151, 200.5]
    event["duration"] = [0, 250, 5, 30]
    savemat(
        out / "struct.set",
        {"EEG": dict(setname="struct", nbchan=2.0, pnts=300.0, trials=1.0, srate=100.0, xmin=0.0, xmax=2.99,
                     data="struct.fdt", datfile="struct.fdt", chanlocs=chanlocs, event=event, epoch=[], ref="common")},
        do_compression=True,
    )
    cut = raw_of(rows(2, 100, 3), 100)
    marks = np.array([[50, 0, 1], [150, 0, 2], [250, 0, 1]])
    epochs = mne.Epochs(cut, marks, {"a": 1, "b": 2}, tmin=-0.2, tmax=0.19, baseline=None, preload=True)
    epochs.export(out / "epochs.set", overwrite=True)
    trials = epochs.get_data()
    return {
        "eeglabio.set": golden(None, mne.io.read_raw_eeglab(out / "eeglabio.set", preload=True)),
        "struct.set": golden(None, mne.io.read_raw_eeglab(out / "struct.set", preload=True)),
    }, [[channel(n, trials[e, c]) for c, n in enumerate(epochs.ch_names)] for e in range(len(trials))]


def own_edf():
    import edfio

    def signals(kind):
        return [kind(row * 1e6, 100, label=f"C{k + 1}", physical_dimension="uV", physical_range=(-200, 200))
                for k, row in enumerate(rows(2, 100, 10))]

    notes = [edfio.EdfAnnotation(0.5, None, "start"), edfio.EdfAnnotation(2.123456, 0.25, "S  1"),
             edfio.EdfAnnotation(9.99, None, "µ")]
    start = dict(starttime=datetime(2024, 3, 1, 10, 22, 33, 250_000).time(),
                 recording=edfio.Recording(startdate=datetime(2024, 3, 1).date()))
    edfio.Edf(signals(edfio.EdfSignal), annotations=notes, **start).write(out / "plus.edf")
    edfio.Bdf(signals(edfio.BdfSignal), annotations=[edfio.BdfAnnotation(a.onset, a.duration, a.text) for a in notes]
              if hasattr(edfio, "BdfAnnotation") else notes, **start).write(out / "plus.bdf")
    # EDF+D: the same without its records 3, 4 and 7.
    whole = bytearray((out / "plus.edf").read_bytes())
    header = int(whole[184:192])
    size = (len(whole) - header) // 10
    assert size * 10 == len(whole) - header
    whole[192:197] = b"EDF+D"
    whole[236:244] = b"7       "
    kept = [k for k in range(10) if k not in (3, 4, 7)]
    records = [whole[header + k * size : header + (k + 1) * size] for k in kept]
    (out / "gaps.edf").write_bytes(bytes(whole[:header]) + b"".join(bytes(r) for r in records))
    # Two annotation channels, an offset of the first record, and channels of two rates.
    two_channels()
    return {name: edf(out / name) for name in ("plus.edf", "plus.bdf", "two.edf")}


def two_channels():
    fast, slow = rows(2, 64, 4)[0] * 1e6, np.linspace(-1, 1, 4 * 8)
    labels = ["EEG Cz", "EDF Annotations", "Temp", "EDF Annotations"]
    dims, per = ["uV", "", "degC", ""], [64, 20, 8, 20]
    text = lambda values, width: b"".join(str(v).encode().ljust(width) for v in values)
    head = b"0".ljust(8) + b"X X X X".ljust(80) + b"Startdate 05-JUN-2091 X X X".ljust(80)
    head += b"05.06.91" + b"23.59.59" + str(256 * 5).encode().ljust(8) + b"EDF+C".ljust(44)
    head += text([4, 1], 8) + b"4".ljust(4)
    head += text(labels, 16) + b" " * 320 + text(dims, 8)
    head += text([-200, -1, -1, -1], 8) + text([200, 1, 1, 1], 8)
    head += text([-32768] * 4, 8) + text([32767] * 4, 8) + b" " * 320 + text(per, 8) + b" " * 128
    codes = lambda v, low, high: np.round((v - low) / (high - low) * 65535 - 32768).astype("<i2").tobytes()
    body = b""
    for k in range(4):
        first = f"+{k + 0.75}\x14\x14\0" + (f"+{k + 1}\x150.5\x14early{k}\x14also\x14\0" if k < 2 else "")
        second = f"+{3.75 - k}\x14late{k}\x14\0"
        body += codes(fast[64 * k : 64 * k + 64], -200, 200) + first.encode().ljust(40, b"\0")
        body += codes(slow[8 * k : 8 * k + 8], -1, 1) + second.encode().ljust(40, b"\0")
    (out / "two.edf").write_bytes(head + body)


def own_brainvision():
    import pybv

    data = rows(3, 250, 2)
    events = [dict(onset=int(s), description=d, type=t, duration=1) for s, d, t in
              [(10, 1, "Stimulus"), (123, 25, "Response"), (499, "a b", "Comment")]]
    for name, fmt in (("pybv_float", "binary_float32"), ("pybv_int16", "binary_int16")):
        pybv.write_brainvision(data=data, sfreq=250, ch_names=["C1", "C,2", "µ"], ref_ch_names="Cz", fname_base=name,
                               folder_out=out, overwrite=True, events=events, resolution=0.1, unit="µV", fmt=fmt,
                               meas_date=datetime(2024, 3, 1, 10, 22, 33, 125_000, tzinfo=timezone.utc))
    # Vectorized INT_16 in Latin-1, with a pause of 5 s at sample 100 and a mark of a new segment without a pause at 200.
    codes = np.round(rows(2, 100, 3) * 1e6 / 0.5).astype("<i2")
    (out / "gap.eeg").write_bytes(codes.tobytes())
    head = ["Brain Vision Data Exchange Header File Version 1.0", "", "[Common Infos]", "DataFile=gap.eeg", "MarkerFile=gap.vmrk",
            "DataFormat=BINARY", "DataOrientation=VECTORIZED", "NumberOfChannels=2", "SamplingInterval=10000", "", "[Binary Infos]",
            "BinaryFormat=INT_16", "", "[Channel Infos]", "Ch1=C1,,0.5,µV", "Ch2=Temp,,0.5,°C", ""]
    (out / "gap.vhdr").write_bytes("\r\n".join(head).encode("latin-1"))
    marks = ["Brain Vision Data Exchange Marker File, Version 1.0", "", "[Common Infos]", "DataFile=gap.eeg", "", "[Marker Infos]",
             "Mk1=New Segment,,1,1,0,20240301102233500000", "Mk2=Stimulus,S  1,51,1,0", "Mk3=New Segment,,101,1,0,20240301102239500000",
             "Mk4=Stimulus,S  2,101,1,0", "Mk5=New Segment,,201,1,0,20240301102240500000", "Mk6=Stimulus,S  3,300,1,0", ""]
    (out / "gap.vmrk").write_bytes("\r\n".join(marks).encode("latin-1"))
    return {n: golden(None, mne.io.read_raw_brainvision(out / n, preload=True)) for n in ("pybv_float.vhdr", "pybv_int16.vhdr", "gap.vhdr")}


def varlen(value):
    return b"\x01" + bytes([value]) if value < 256 else b"\x04" + struct.pack("<I", value)


def chunk(tag, content):
    return varlen(len(content) + 2) + struct.pack("<H", tag) + content


def stream_header(number, name, kind, count, rate, fmt, channels=()):
    listed = "".join(f"<channel><label>{c}</label><unit>microvolts</unit></channel>" for c in channels)
    desc = f"<desc><channels>{listed}</channels></desc>" if channels else "<desc/>"
    xml = (f'<?xml version="1.0"?><info><name>{name}</name><type>{kind}</type><channel_count>{count}</channel_count>'
           f"<nominal_srate>{rate}</nominal_srate><channel_format>{fmt}</channel_format>{desc}</info>")
    return chunk(2, struct.pack("<I", number) + xml.encode())


def numbers(number, stamps, values, dtype):
    body = b"".join((b"\x08" + struct.pack("<d", t) if t is not None else b"\0") + np.asarray(v, dtype).tobytes()
                    for t, v in zip(stamps, values))
    return chunk(3, struct.pack("<I", number) + varlen(len(stamps)) + body)


def texts(number, stamps, values):
    body = b"".join(b"\x08" + struct.pack("<d", t) + varlen(len(v.encode())) + v.encode() for t, v in zip(stamps, values))
    return chunk(3, struct.pack("<I", number) + varlen(len(stamps)) + body)


def offset(number, time, value):
    return chunk(4, struct.pack("<Idd", number, time, value))


def footer(number, count):
    return chunk(6, struct.pack("<I", number) + f"<?xml version='1.0'?><info><sample_count>{count}</sample_count></info>".encode())


BOUNDARY = chunk(5, bytes([0x43, 0xA5, 0x46, 0xDC, 0xCB, 0xF5, 0x41, 0x0F, 0xB3, 0x0E, 0xD5, 0x46, 0x73, 0x83, 0xCB, 0xE4]))


def own_xdf(others):
    import pyxdf

    rng = np.random.default_rng(3)
    start = b"XDF:" + chunk(1, b"<?xml version='1.0'?><info><version>1.0</version></info>")
    # Streams: EEG with jitter and a gap of 12 s; markers on another clock; int16 with a reset of its clock.
    body = stream_header(1, "Amp", "EEG", 2, 50, "float32", ["C3", "C4"])
    body += stream_header(2, "Marks", "Markers", 1, 0, "string")
    body += stream_header(3, "Force", "Force", 1, 25, "int16")
    counts = {1: 0, 2: 0, 3: 0}
    for k in range(40):
        t = 1000 + k + (12 if k >= 25 else 0)
        stamps = t + np.arange(50) / 50 + rng.normal(0, 1e-3, 50)
        marked = [s if i % 10 == 0 else None for i, s in enumerate(stamps)]
        i = np.arange(50) + 50 * k
        body += numbers(1, marked, np.c_[100 * np.sin(i / 7), i], "<f4")
        counts[1] += 50
        # The device of stream 3 restarts after 20 s: its clock begins again.
        own = (500 if k < 20 else -9980) + k
        body += numbers(3, [own + j / 25 if j % 5 == 0 else None for j in range(25)], (np.arange(25) + 25 * k)[:, None], "<i2")
        counts[3] += 25
        if k % 2 == 0:
            body += offset(1, 1000 + k, -3.5 + 2e-5 * k + rng.normal(0, 2e-5) + (0.02 if k == 10 else 0))
            body += offset(2, 7000 + k, -6000 + 1e-4 * k + rng.normal(0, 2e-5))
            body += offset(3, own, 1000 + k - own - 3.5 + rng.normal(0, 2e-5))
        if k % 5 == 0:
            body += texts(2, [7000 + k + 0.25], [f"S {k} µ"])
            counts[2] += 1
        if k % 10 == 9:
            body += BOUNDARY
    whole = start + body + b"".join(footer(n, c) for n, c in counts.items())
    (out / "streams.xdf").write_bytes(whole)
    found = {}
    for path in [out / "streams.xdf", *others]:
        name = path.name
        streams, _ = pyxdf.load_xdf(str(path))
        found[name] = []
        for s in streams:
            stamps, series = s["time_stamps"], s["time_series"]
            text = s["info"]["channel_format"][0] == "string"
            found[name].append({
                "name": s["info"]["name"][0],
                "count": len(stamps),
                "effective_hz": float(s["info"]["effective_srate"]),
                "segments": [[a, b + 1] for a, b in s["info"]["segments"]],
                "clock_segments": [[a, b + 1] for a, b in s["info"]["clock_segments"]],
                "times": [float(stamps[k]) for k in sorted({0, 1, len(stamps) // 2, len(stamps) - 1})],
                "time_sum": float(np.sum(stamps)),
                "sums": None if text else [float(v) for v in np.sum(series, axis=0, dtype=float)],
                "texts": [row[0] for row in series] if text else None,
            })
    return found


def read_back(folder):
    import edfio

    raw = mne.io.read_raw_brainvision(folder / "written.vhdr", preload=True)
    again = mne.io.read_raw_edf(folder / "written.edf", preload=True)
    exact = np.array(json.loads((folder / "written.json").read_text())["samples"])
    events = json.loads((folder / "written.json").read_text())["events"]
    size = np.abs(exact).max(axis=1)
    print("BrainVision: largest error, relative", (np.abs(raw.get_data() - exact) / size[:, None]).max())
    header = edfio.read_edf(folder / "written.edf")
    factors = [{"nV": 1e-9, "uV": 1e-6, "mV": 1e-3}.get(s.physical_dimension, 1) for s in header.signals]
    # MNE takes nV for V; edfio gives the values in the dimension of the file.
    steps = [(s.physical_max - s.physical_min) / (s.digital_max - s.digital_min) * f for s, f in zip(header.signals, factors)]
    data = np.array([s.data * f for s, f in zip(header.signals, factors)])[:, : exact.shape[1]]
    print("EDF: largest error in steps, edfio", (np.abs(data - exact) / np.array(steps)[:, None]).max(), "samples", again.n_times, exact.shape[1])
    print("EDF: largest error of Cz in steps, MNE", (np.abs(again.get_data()[0] - exact[0]) / steps[0]).max())
    print("events, EDF:", events_of(again) == events, "BrainVision:", [e[0] for e in events_of(raw)] == [e[0] for e in events])
    print("starts:", raw.info["meas_date"], again.info["meas_date"])
    read = edfio.read_edf(folder / "written.edf")
    print("edfio:", [s.label for s in read.signals], read.starttime, len(read.annotations))


if len(sys.argv) > 2 and sys.argv[1] == "read":
    read_back(Path(sys.argv[2]))
    sys.exit()

out.mkdir(exist_ok=True)
own, epochs = own_set()
own |= own_edf() | own_brainvision()
shared = {}
folder = Path(sys.argv[1] if len(sys.argv) > 1 else "../shared/data/eeg")
for path in sorted(folder.glob("edf/*.[eb]df")):
    shared[f"edf/{path.name}"] = edf(path)
for path in sorted(folder.glob("brainvision/*.vhdr")):
    shared[f"brainvision/{path.name}"] = golden(path, mne.io.read_raw_brainvision(path, preload=True))
for path in sorted(folder.glob("eego/*.vhdr")):
    found = golden(path, mne.io.read_raw_brainvision(path, preload=True))
    # A marker at position 0, where positions count from 1: MNE puts it on the first sample.
    found["events"].remove([0, "Marker/Impedance"])
    shared[f"eego/{path.name}"] = found
cases = folder.parent.parent / "cases"
if cases.is_dir():
    for name in ("held_codes.bdf", "comma_onset.edf"):
        shared[f"../../cases/{name}"] = edf(cases / name)
versions = {name: version(name) for name in ("mne", "edfio", "pyxdf", "pybv", "eeglabio", "scipy", "numpy")}
found = dict(versions=versions, own=own, epochs=epochs, xdf=own_xdf([folder / "xdf/clock_resets.xdf"]), shared=shared)
(out / "mne.json").write_text(json.dumps(found, ensure_ascii=False, separators=(",", ":")))
for name, one in (own | shared).items():
    print(name, len(one["channels"]), "channels", len(one["events"]), "events", len(one.get("triggers", [])), "triggers", one["rate_hz"], one["start"])
