"""The same work in the programs that a laboratory would otherwise use, for `./x bench`.

    python3 bench/peers.py inputs FOLDER [W4]       make the inputs, from seeds, of all works or of W4 alone
    python3 bench/peers.py CONTESTANT FOLDER REPS   run one contestant on them

A contestant prints one line of JSON: the CPU seconds of every repetition after one that is not counted, the
peak memory of its process, and the memory of its input, in MB. Its result goes to FOLDER/CONTESTANT.f64, so
that results are compared as well as times.

W1a  Welch PSD of one 10-minute channel at 5 kHz (Hann 1024, 50 %)
W1b  the mean PSD of 1000 strokes of 1 s in each of 4 channels
W2a  H1, H2 and coherence of one 60 s pair at 5 kHz (Hann 2048, 50 %)
W2b  the same for 360 pairs of 30 s: 20 participants, 6 conditions, 3 repeats
E1   the power of 100 single trials of 2 s at 1 kHz, 64 channels, by Morlet wavelets at 37 frequencies, in two windows
E2   clusters over 100 times and 64 sensors of 10 people, all 512 sign flips
W3   a drive of 10 s from its texture: inversion, 5 to 48 kHz, 24-bit WAV
W4   30 s at 48 kHz through 4096 taps in blocks of 64 samples, as a sound device asks for them

W9a  a table of text of 2 min at 5 kHz, time and 4 channels
W9b  MATLAB 5, four channels of 30 min at 5 kHz and their rate, beside the same numbers mapped into memory
W9c  TDMS, the same
W9d  universal file 58, binary, 4 channels of 2 min at 5 kHz
W9e  EDF, 32 channels of 10 min at 1 kHz

For W9 the result is the mean and the root mean square of each channel. For W4 a contestant prints the time of every block of every pass instead, by the monotonic clock: clocks of CPU time are too
coarse for some microseconds. A block is in the same array before the time begins, as a sound device gives it, and what is timed is
the one call that a user would make for it; its result is copied after the time ends, and the garbage collector of Python is off.
"""

import gc
import json
import pathlib
import resource
import sys
import time

import numpy as np

RATE = 5000.0
W1 = dict(fs=RATE, window="hann", nperseg=1024, noverlap=512, detrend="constant")
W2 = dict(fs=RATE, window="hann", nperseg=2048, noverlap=1024, detrend="constant")
BLOCK, TAPS, SOUND_RATE = 64, 4096, 48_000


# Inputs


def texture(samples, seed):
    """Acceleration with a coloured floor, a ridge at 260 Hz and an offset."""
    from scipy import signal

    white = np.random.Generator(np.random.PCG64(seed)).standard_normal(samples)
    ridge = signal.lfilter(*signal.iirpeak(260.0, 4.0, fs=RATE), white)
    return signal.lfilter([1.0], [1.0, -0.7], white) + 3.0 * ridge + 0.25


def device(frequency):
    """Two resonances and a delay."""
    s = 2j * np.pi * frequency

    def mode(at, damping, gain):
        w = 2 * np.pi * at
        return gain * w**2 / (s**2 + 2 * damping * w * s + w**2)

    return (mode(180.0, 0.08, 1.0) + mode(620.0, 0.05, 0.6) + 0.05) * np.exp(-s * 8e-4)


def pair(samples, seed):
    """A drive up to 1 kHz and the device's answer with noise 30 dB down."""
    from scipy import signal

    random = np.random.Generator(np.random.PCG64(seed))
    low_pass = signal.butter(6, 1000.0, fs=RATE, output="sos")
    drive = signal.sosfilt(low_pass, random.standard_normal(samples))
    bins = np.fft.rfft(drive) * device(np.fft.rfftfreq(samples, 1 / RATE))
    answer = np.fft.irfft(bins, samples)
    return drive, answer + random.standard_normal(samples) * answer.std() * 10**-1.5


def keep(folder, name, *arrays):
    np.concatenate([np.ascontiguousarray(a, dtype=float).ravel() for a in arrays]).tofile(folder / f"{name}.f64")


def blocks_of_noise(folder):
    """Noise and an impulse response that decays, both in single precision, and their convolution in double precision."""
    from scipy import signal

    random = np.random.Generator(np.random.PCG64(4))
    x = random.standard_normal(22_500 * BLOCK).astype(np.float32)
    h = (random.standard_normal(TAPS) * np.exp(-np.arange(TAPS) / 600) / 20).astype(np.float32)
    keep(folder, "W4", x, h)
    keep(folder, "W4-offline", signal.oaconvolve(x.astype(float), h.astype(float))[: len(x)])


def inputs(folder, only):
    from scipy import signal

    folder.mkdir(parents=True, exist_ok=True)
    if only and all(name.startswith("W9") for name in only):
        return files(folder)
    blocks_of_noise(folder)
    if only == ["W4"]:
        return

    brain = np.random.Generator(np.random.PCG64(6))
    keep(folder, "E1", 1e-6 * brain.standard_normal((64, 100, 2000)))
    people = brain.standard_normal((10, 64, 100))
    people[:, 20:30, 30:60] += 0.8
    keep(folder, "E2", people)
    keep(folder, "W1a", texture(3_000_000, 1))
    random = np.random.Generator(np.random.PCG64(11))
    keep(folder, "W1b", random.standard_normal((4, 1000, 5000)) + 0.5 * np.sin(2 * np.pi * 260 * np.arange(5000) / RATE))
    drive, answer = pair(300_000, 2)
    keep(folder, "W2a", drive, answer)
    six = [pair(150_000, 100 + i) for i in range(6)]
    keep(folder, "W2b", *[d for d, _ in six], *[a for _, a in six])
    _, sxy = signal.csd(drive, answer, fs=RATE, nperseg=2048)
    _, sxx = signal.welch(drive, fs=RATE, nperseg=2048)
    h = sxy / sxx
    keep(folder, "W3", texture(50_000, 3), h.real, h.imag)
    keep(folder, "W5", *an_hour_of_strokes())
    if not only:
        files(folder)


def files(folder):
    """The files of W9, each with channels whose unit the file states as far as its format does."""
    import edfio
    import polars as pl
    import pyuff
    from nptdms import ChannelObject, RootObject, TdmsWriter
    from scipy import io

    random = np.random.Generator(np.random.PCG64(9))
    short = random.standard_normal((4, int(120 * RATE)))
    names = ["a (m/s2)", "b (m/s2)", "c (N)", "d (N)"]
    time = np.arange(short.shape[1]) / RATE
    table = pl.DataFrame({"time (s)": time, **dict(zip(names, np.round(short, 9)))})
    table.write_csv(folder / "W9a.csv")
    long = random.standard_normal((4, int(1800 * RATE)))
    keep(folder, "W9b", long)
    io.savemat(folder / "W9b.mat", {"fs": RATE, **{name: long[i] for i, name in enumerate("abcd")}})
    step = dict(wf_increment=1 / RATE, wf_samples=1, wf_start_offset=0.0)
    channels = [
        ChannelObject("group", name, data, properties=dict(unit_string=unit, **step))
        for name, unit, data in zip("abcd", ["m/s^2", "m/s^2", "N", "N"], long)
    ]
    with TdmsWriter(folder / "W9c.tdms") as writer:
        # As an instrument writes: a segment each 10 s.
        block = int(10 * RATE)
        for at in range(0, long.shape[1], block):
            some = [ChannelObject(c.group, c.channel, c.data[at : at + block], c.properties if at == 0 else {}) for c in channels]
            writer.write_segment([RootObject({}), *some])
    (folder / "W9d.uff").unlink(missing_ok=True)
    universal = pyuff.UFF(str(folder / "W9d.uff"))
    common = {"type": 58, "binary": 1, "func_type": 1, "x": time, "abscissa_spacing": 1, "abscissa_spec_data_type": 17}
    common |= {"ordinate_spec_data_type": 12, "ordinate_axis_units_lab": "m/s^2", "rsp_dir": 3, "ref_node": 0, "ref_dir": 0, "orddenom_spec_data_type": 0}
    universal.write_sets([common | {"rsp_node": i + 1, "data": short[i]} for i in range(4)], mode="add")
    head = np.round(100 * random.standard_normal((32, 600_000)), 1)
    signals = [edfio.EdfSignal(head[i], 1000, label=f"EEG {i}", physical_dimension="uV", physical_range=(-800, 800)) for i in range(32)]
    edfio.Edf(signals).write(folder / "W9e.edf")


def an_hour_of_strokes():
    """Acceleration, two tangential forces and the normal force: a stroke of 1 s every 2 s."""
    from scipy import signal

    n = int(3600 * RATE)
    random = np.random.Generator(np.random.PCG64(21))
    time = np.arange(n) / RATE
    touching = ((time % 2.0) >= 0.5) & ((time % 2.0) < 1.5)
    ramp = np.hanning(501)
    shape = signal.oaconvolve(touching.astype(float), ramp / ramp.sum(), mode="same")
    normal = 0.5 * shape + 0.01 * random.standard_normal(n)
    along = 0.35 * normal + 0.01 * random.standard_normal(n)
    across = 0.02 * random.standard_normal(n)
    acceleration = shape * (texture(n, 22) + 0.25) + 0.02 * random.standard_normal(n)
    return acceleration, along, across, normal


def load(folder, name):
    return np.fromfile(folder / f"{name}.f64")


def panel(folder):
    """360 pairs made of six, each rolled by another number of samples."""
    base = load(folder, "W2b").reshape(2, 6, 150_000)
    drive, answer = np.empty((360, 150_000)), np.empty((360, 150_000))
    for i in range(360):
        drive[i], answer[i] = np.roll(base[0, i % 6], i), np.roll(base[1, i % 6], i)
    return drive, answer


# Contestants


def segments(x, n):
    """Detrended, windowed segments of n samples, half overlapping, without a copy of x."""
    window = np.hanning(n + 1)[:-1]
    cut = np.lib.stride_tricks.sliding_window_view(x, n, axis=-1)[..., :: n // 2, :]
    return (cut - cut.mean(-1, keepdims=True)) * window


def density(power, n):
    window = np.hanning(n + 1)[:-1]
    power = power / (RATE * (window * window).sum())
    power[..., 1:-1] *= 2
    return power


def numpy_welch(x, n):
    bins = np.fft.rfft(segments(x, n))
    return density((bins.real**2 + bins.imag**2).mean(-2), n)


def w1a_scipy(folder):
    from scipy import signal

    x = load(folder, "W1a")
    return x.nbytes, lambda: signal.welch(x, **W1)[1]


def w1a_fftw(folder):
    """FFTW planned once, on blocks of 64 segments that stay in the cache, with compiled loops around it."""
    import numba
    import pyfftw

    x, n, block = load(folder, "W1a"), 1024, 64
    count = (len(x) - n) // (n // 2) + 1
    window = np.hanning(n + 1)[:-1]
    buffer = pyfftw.empty_aligned((block, n))
    bins = pyfftw.empty_aligned((block, n // 2 + 1), dtype="complex128")
    plan = pyfftw.FFTW(buffer, bins, flags=("FFTW_MEASURE",))

    @numba.njit(fastmath=True)
    def fill(x, buffer, first, rows, window):
        for row in range(rows):
            start = (first + row) * (n // 2)
            mean = 0.0
            for i in range(n):
                mean += x[start + i]
            mean /= n
            for i in range(n):
                buffer[row, i] = (x[start + i] - mean) * window[i]

    @numba.njit(fastmath=True)
    def add(bins, rows, power):
        for row in range(rows):
            for k in range(power.size):
                power[k] += bins[row, k].real ** 2 + bins[row, k].imag ** 2

    def run():
        power = np.zeros(n // 2 + 1)
        for first in range(0, count, block):
            rows = min(block, count - first)
            fill(x, buffer, first, rows, window)
            add(plan(), rows, power)
        return density(power / count, n)

    return x.nbytes, run


def w1b_scipy(folder):
    from scipy import signal

    x = load(folder, "W1b").reshape(4, 1000, 5000)
    return x.nbytes, lambda: signal.welch(x, **W1)[1].mean(1)


def w1b_numpy(folder):
    x = load(folder, "W1b").reshape(4, 1000, 5000)
    return x.nbytes, lambda: numpy_welch(x, 1024).mean(1)


def scipy_transfer(drive, answer):
    """What people write: four calls, each of which transforms everything again."""
    from scipy import signal

    _, sxy = signal.csd(drive, answer, **W2)
    _, sxx = signal.welch(drive, **W2)
    _, syy = signal.welch(answer, **W2)
    _, coherence = signal.coherence(drive, answer, **W2)
    return np.concatenate([abs(sxy / sxx), abs(syy / sxy.conj()), coherence])


def numpy_transfer(drive, answer):
    x, y = np.fft.rfft(segments(drive, 2048)), np.fft.rfft(segments(answer, 2048))
    sxx, syy = (x.real**2 + x.imag**2).mean(-2), (y.real**2 + y.imag**2).mean(-2)
    sxy = (x.conj() * y).mean(-2)
    return np.concatenate([abs(sxy / sxx), abs(syy / sxy.conj()), abs(sxy) ** 2 / (sxx * syy)])


def w2a(transfer):
    def contestant(folder):
        drive, answer = load(folder, "W2a").reshape(2, -1)
        return drive.nbytes * 2, lambda: transfer(drive, answer)

    return contestant


def w2b(transfer):
    def contestant(folder):
        drive, answer = panel(folder)
        return drive.nbytes * 2, lambda: np.concatenate([transfer(d, a) for d, a in zip(drive, answer)])

    return contestant


def w3_soxr(folder):
    import soundfile
    import soxr

    data = load(folder, "W3")
    target, h = data[:50_000], data[50_000:51_025] + 1j * data[51_025:]
    lines = np.arange(1025) * RATE / 2048

    def run():
        n = len(target)
        f = np.fft.rfftfreq(n, 1 / RATE)
        band = np.zeros_like(f)
        band[(f >= 20) & (f <= 1000)] = 1
        for inside, outside in ((20.0, 18.0), (1000.0, 1100.0)):
            edge = (f > min(inside, outside)) & (f < max(inside, outside))
            band[edge] = 0.5 + 0.5 * np.cos(np.pi * (f[edge] - inside) / (outside - inside))
        h_at = np.interp(f, lines, h.real) + 1j * np.interp(f, lines, h.imag)
        power = abs(h_at) ** 2
        inverse = h_at.conj() / (power + 1e-3 * power[band > 0.5].max()) * band
        drive = np.fft.irfft(np.fft.rfft(target) * inverse, n)
        drive = soxr.resample(drive, 5000, 48000, quality="VHQ")
        drive = drive / abs(drive).max() * 0.9
        soundfile.write(folder / "W3-soxr.wav", drive, 48000, "PCM_24")
        return drive

    return target.nbytes, run


def blocks_and_taps(folder):
    data = load(folder, "W4").astype(np.float32)
    return data[:-TAPS].reshape(-1, BLOCK), data[-TAPS:]


def w4_pedalboard(folder):
    """JUCE's convolution. It scales an impulse response to a level of its own: the gain is found from an impulse, and taken
    away from the result."""
    import pedalboard

    blocks, taps = blocks_and_taps(folder)
    plugin = pedalboard.Convolution(taps[None], mix=1.0, sample_rate=SOUND_RATE)
    answer = plugin.process(np.eye(1, 2 * TAPS, dtype=np.float32), SOUND_RATE, reset=True)[0, :TAPS]
    gain = (answer @ taps) / (taps @ taps)
    return blocks[:, None], plugin.reset, plugin.process, (SOUND_RATE, BLOCK, False), 1 / gain


def w4_call(folder):
    """The same call of a plugin that does next to nothing: what calling pedalboard from Python costs."""
    import pedalboard

    blocks, _ = blocks_and_taps(folder)
    plugin = pedalboard.Gain(0.0)
    return blocks[:, None], plugin.reset, plugin.process, (SOUND_RATE, BLOCK, False), 1.0


def w4_numpy(folder):
    """Uniformly partitioned overlap-save. The spectra stay where they are and the partitions turn: they stand twice, so that
    they are one slice in any position."""
    blocks, taps = blocks_and_taps(folder)
    count = TAPS // BLOCK
    partitions = np.fft.rfft(np.pad(taps.reshape(count, BLOCK), ((0, 0), (0, BLOCK)))).astype(np.complex64)
    partitions = np.concatenate([partitions, partitions])
    history, both = np.zeros((count, BLOCK + 1), np.complex64), np.zeros(2 * BLOCK, np.float32)
    newest = 0

    def reset():
        nonlocal newest
        newest = 0
        history[:], both[:] = 0, 0

    def process(block):
        nonlocal newest
        newest = (newest - 1) % count
        both[:BLOCK] = both[BLOCK:]
        both[BLOCK:] = block
        history[newest] = np.fft.rfft(both)
        products = history * partitions[count - newest : 2 * count - newest]
        return np.fft.irfft(products.sum(0))[BLOCK:]

    return blocks, reset, process, (), 1.0


def time_blocks(name, folder, passes):
    """Every block of every pass after one that is not counted."""
    blocks, reset, process, arguments, scale = BLOCKS[name](folder)
    clock, result, times = time.perf_counter, np.empty((len(blocks), BLOCK)), np.empty((passes + 1, len(blocks)))
    device = np.empty_like(blocks[0])
    gc.disable()
    for own in times:
        reset()
        for at, block in enumerate(blocks):
            device[:] = block
            start = clock()
            answer = process(device, *arguments)
            own[at] = clock() - start
            result[at] = answer
    keep(folder, name, result * scale)
    print(json.dumps(dict(passes_s=times[1:].tolist())))


def w5_scipy(folder):
    """Contacts by hysteresis in the smoothed force, then features stroke by stroke."""
    from scipy import ndimage, signal

    acceleration, along, across, normal = load(folder, "W5").reshape(4, -1)
    bands = [(5, 30), (30, 100), (100, 300), (300, 600), (600, 1000)]

    def contacts(on=0.2, off=0.1, width=251, shortest=2500):
        smooth = ndimage.uniform_filter1d(normal, width)
        above = smooth > off
        steps = np.diff(above.astype(np.int8))
        starts, ends = np.flatnonzero(steps == 1) + 1, np.flatnonzero(steps == -1) + 1
        if above[0]:
            starts = np.r_[0, starts]
        if above[-1]:
            ends = np.r_[ends, len(normal)]
        pressed = np.r_[0, np.cumsum(smooth > on)]
        keep = (pressed[ends] - pressed[starts] > 0) & (ends - starts >= shortest)
        return zip(starts[keep], ends[keep])

    def features(start, end):
        x = acceleration[start:end]
        ratio = np.hypot(along[start:end], across[start:end]) / np.maximum(normal[start:end], 1e-6)
        x = x - x.mean()
        rms, peak = np.sqrt(np.mean(x * x)), abs(x).max()
        f, psd = signal.welch(x, RATE, nperseg=1024)
        powers = [psd[(f >= low) & (f < high)].sum() * f[1] for low, high in bands]
        band = (f > 20) & (f < 1000)
        centroid = (f[band] * psd[band]).sum() / psd[band].sum()
        # The height of the strongest line, as its place jumps between near equals.
        strongest = psd[band].argmax()
        return [np.median(ratio), rms, peak, peak / rms, psd[band][strongest], centroid, *powers]

    return 4 * normal.nbytes, lambda: np.array([features(*contact) for contact in contacts()]).T


def e1_mne(folder):
    import mne

    mne.set_log_level("ERROR")
    trials = np.fromfile(folder / "E1.f64").reshape(64, 100, 2000).transpose(1, 0, 2).copy()
    hz = np.arange(4.0, 41.0)
    times = np.arange(2000) / 1000.0
    band = (hz >= 8.0) & (hz <= 12.0)
    windows = [(times >= low - 1e-9) & (times <= high + 1e-9) for low, high in [(0.2, 0.7), (0.8, 1.3)]]

    def run():
        power = mne.time_frequency.tfr_array_morlet(trials, 1000.0, hz, n_cycles=hz / 2, output="power", zero_mean=True)
        means = [power[:, :, band][:, :, :, window].mean(axis=(2, 3)) for window in windows]
        # Channels × windows × trials.
        return np.array(means).transpose(2, 0, 1)

    return trials.nbytes, run


def e2_mne(folder):
    import mne
    from scipy import sparse

    mne.set_log_level("ERROR")
    people = np.fromfile(folder / "E2.f64").reshape(10, 64, 100).transpose(0, 2, 1).copy()
    beside = sparse.lil_matrix((64, 64))
    for at in range(64):
        if at % 8 < 7:
            beside[at, at + 1] = beside[at + 1, at] = 1
        if at < 56:
            beside[at, at + 8] = beside[at + 8, at] = 1
    beside = sparse.csr_matrix(beside)

    def run():
        t, clusters, p, _ = mne.stats.spatio_temporal_cluster_1samp_test(
            people, threshold=2.262157, n_permutations=1000, adjacency=beside, seed=1, tail=0, out_type="indices"
        )
        masses = sorted((abs(t[cluster].sum()) for cluster in clusters), reverse=True)[:20]
        return np.concatenate([t.T.ravel(), masses, [min(p)]])

    return people.nbytes, run


def figures(channels):
    """The mean and the root mean square of each channel."""
    return np.array([value for one in channels for value in (one.mean(), np.sqrt(np.mean(one**2)))])


def w9a_polars(folder):
    import polars as pl

    def run():
        table = pl.read_csv(folder / "W9a.csv")
        return figures([table[name].to_numpy() for name in table.columns[1:]])

    return 5 * 8 * int(120 * RATE), run


def w9b_mapped(folder):
    def run():
        mapped = np.memmap(folder / "W9b.f64", dtype=float, mode="r").reshape(4, -1)
        return figures([np.array(one) for one in mapped])

    return 4 * 8 * int(1800 * RATE), run


def w9b_scipy(folder):
    from scipy import io

    def run():
        read = io.loadmat(folder / "W9b.mat")
        return figures([read[name].ravel() for name in "abcd"])

    return 4 * 8 * int(1800 * RATE), run


def w9c_nptdms(folder):
    from nptdms import TdmsFile

    def run():
        read = TdmsFile.read(folder / "W9c.tdms")["group"]
        return figures([read[name][:] for name in "abcd"])

    return 4 * 8 * int(1800 * RATE), run


def w9d_pyuff(folder):
    import pyuff

    def run():
        return figures([one["data"] for one in pyuff.UFF(str(folder / "W9d.uff")).read_sets()])

    return 4 * 8 * int(120 * RATE), run


def w9e_edfio(folder):
    import edfio

    def run():
        return figures([1e-6 * one.data for one in edfio.read_edf(folder / "W9e.edf").signals])

    return 32 * 8 * 600_000, run


CONTESTANTS = {
    "W9a-polars": w9a_polars,
    "W9b-mapped": w9b_mapped,
    "W9b-scipy": w9b_scipy,
    "W9c-mapped": w9b_mapped,
    "W9c-nptdms": w9c_nptdms,
    "W9d-pyuff": w9d_pyuff,
    "W9e-edfio": w9e_edfio,
    "E1-mne": e1_mne,
    "E2-mne": e2_mne,
    "W1a-scipy": w1a_scipy,
    "W1a-fftw": w1a_fftw,
    "W1b-scipy": w1b_scipy,
    "W1b-numpy": w1b_numpy,
    "W2a-scipy": w2a(scipy_transfer),
    "W2a-numpy": w2a(numpy_transfer),
    "W2b-scipy": w2b(scipy_transfer),
    "W2b-numpy": w2b(numpy_transfer),
    "W3-soxr": w3_soxr,
    "W5-scipy": w5_scipy,
    "W5j-scipy": w5_scipy,
}


BLOCKS = {"W4-pedalboard": w4_pedalboard, "W4-call": w4_call, "W4-numpy": w4_numpy}


def main():
    name, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    if name == "inputs":
        return inputs(folder, sys.argv[3:])
    if name in BLOCKS:
        return time_blocks(name, folder, int(sys.argv[3]))
    size, run = CONTESTANTS[name](folder)
    run()
    cpu = []
    for _ in range(int(sys.argv[3])):
        start = time.process_time()
        result = run()
        cpu.append(time.process_time() - start)
    np.ascontiguousarray(result, dtype=float).tofile(folder / f"{name}.f64")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(json.dumps(dict(cpu_s=cpu, peak_mb=peak, input_mb=size / 2**20)))


if __name__ == "__main__":
    main()
