"""Golden values for ST-SIM and SPQI, from the Python package vibromaf.

    pip install vibromaf==0.0.8
    python3 golden/score.py > crates/piezotact/tests/golden/score.json

Made with vibromaf 0.0.8, NumPy 2.4.6 and SciPy 1.17.1. The signals are formulas that the test computes too, at the 8 kHz
that the package takes every input for: it converts no rate. A signal whose length is no multiple of 512 has its rest
left out. Where the temporal similarity is negative the package returns a complex number: `st_sim` is null there.
"""

import json
from importlib.metadata import version

import numpy as np
import scipy
from vibromaf.metrics.spqi import SPQI
from vibromaf.metrics.stsim import STSIM
from vibromaf.signal.perception import PerceptualThreshold
from vibromaf.signal.spectrum import compute_spectral_support
from vibromaf.signal.transform import PerceptualSpectrumBuilder

RATE = 8000.0


def hashed(n, seed):
    """Noise of whole numbers: the same bits everywhere."""
    out = []
    for i in range(n):
        h = (i * 2654435761 + seed * 40503 + 12345) & 0xFFFFFFFF
        h ^= h >> 16
        h = (h * 2246822519) & 0xFFFFFFFF
        h ^= h >> 13
        h = (h * 3266489917) & 0xFFFFFFFF
        h ^= h >> 16
        out.append(h / 4294967296.0 - 0.5)
    return np.array(out)


def sines(n, later_s=0.0):
    t = np.arange(n) / RATE - later_s
    return (
        0.3 * np.sin(2 * np.pi * 55.0 * t)
        + 0.2 * np.sin(2 * np.pi * 180.0 * t + 1.0)
        + 0.1 * np.sin(2 * np.pi * 411.0 * t + 2.0)
    )


n = 8000  # 15 blocks and 320 samples
base = sines(n) + 0.2 * hashed(n, 1)
pairs = {
    "equal": (base, base),
    "little noise": (base, base + 0.01 * hashed(n, 2)),
    "much noise": (base, base + 0.8 * hashed(n, 2)),
    "louder": (base, 1.2 * base),
    "much softer": (base, 1e-3 * base),
    "later by 5 ms": (base, sines(n, 0.005) + 0.2 * hashed(n, 1)),
    "other noise": (hashed(n, 3), hashed(n, 4)),
    "longer": (base, np.concatenate([base + 0.05 * hashed(n, 5), hashed(777, 6)])),
    "one block": (base[:512], base[:512] + 0.1 * hashed(512, 7)),
    "reversed": (base, -0.9 * base),
    "with a pause": (np.where(np.arange(n) < 4096, base, 0.0), base),
}



class AsWritten(PerceptualThreshold):
    """The same formula without the package's hold above 0 dB, which would make this curve a constant."""

    def calculate(self, block_length):
        f = np.linspace(0, self.sampling_frequency, 2 * block_length)[:block_length]
        b = self.x_offset
        return abs(self.x_scaler / np.log10(b) ** 2 * np.log10(self.y_scaler * f + b) ** 2) - self.y_offset


curves = {
    "vibromaf": PerceptualThreshold(8000),
    "mpeg": AsWritten(8000, x_scaler=50, y_offset=45),
}
cases = []
for curve, threshold in curves.items():
    builder = PerceptualSpectrumBuilder(
        perceptual_threshold=threshold
    )
    for name, (reference, distorted) in pairs.items():
        # Class attributes of frozen dataclasses: both metrics look the builder up on the class.
        STSIM.perceptual_spectrum_builder = builder
        SPQI.perceptual_spectrum_builder = builder
        distorted = distorted[: reference.size]
        st_sim = STSIM(2 / 3).calculate(distorted, reference)
        blocks = builder.block_builder.divide_and_normalize
        support = lambda x: compute_spectral_support(builder.compute_perceptual_spectrum(x))
        with np.errstate(divide="ignore"):
            temporal = STSIM.compute_sim(blocks(reference), blocks(distorted))
            spectral = STSIM.compute_sim(support(reference), support(distorted))
            spqi = float(SPQI(0.3, -2.0).calculate(distorted, reference))
        cases.append(
            dict(
                name=name,
                curve=curve,
                st_sim=None if isinstance(st_sim, complex) else float(st_sim),
                temporal=temporal,
                spectral=spectral,
                spqi=spqi,
            )
        )

print(
    json.dumps(
        dict(
            vibromaf=version("vibromaf"),
            numpy=np.__version__,
            scipy=scipy.__version__,
            thresholds_every_50={
                name: [float(v) for v in threshold.calculate(512)[::50]]
                for name, threshold in curves.items()
            },
            cases=cases,
        ),
        indent=1,
    )
)
