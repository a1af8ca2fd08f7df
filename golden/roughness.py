"""Golden values of roughness parameters: every filter, parameter and contour once more, point by point as the
standards define them, with NumPy 2.4.6, SciPy 1.17.1 and contourpy 1.3.3; and what surfalize 0.19.2 and
SurfaceTopography 1.27.1 give for the same surfaces.

    python3 golden/roughness.py ../shared/data/topography/nanovea/test1.txt > crates/piezotact-surface/tests/golden/roughness.json

The surfaces come from formulas that the Rust test computes too, and one from the measured map named in the command.
"""

import json
import sys
from importlib.metadata import version

import contourpy
import numpy as np
import SurfaceTopography
import surfalize
from scipy import signal

ALPHA = np.sqrt(np.log(2) / np.pi)


def noise(count, seed):
    """Sums of twelve uniform numbers less six, from Knuth's linear congruential generator."""
    state, values = seed, []
    for _ in range(count):
        total = 0.0
        for _ in range(12):
            state = (state * 6364136223846793005 + 1442695040888963407) % 2**64
            total += (state >> 11) / 2**53
        values.append(total - 6.0)
    return values


def rough_profile(points):
    z, heights = 0.0, []
    for i, w in enumerate(noise(points, 11)):
        z = 0.98 * z + 1e-7 * w
        x = i * 1e-6
        heights.append(z + 1e-3 * x + 2e-6 * np.sin(2 * np.pi * x / 3e-3))
    return np.array(heights)


def sine(points):
    return 1e-6 * np.sin(2 * np.pi * np.arange(points) / 100 + 0.1)


def square_wave(points):
    return np.where(np.arange(points) // 50 % 2 == 0, 1e-6, -1e-6)


def rough_map(rows, columns, with_holes):
    z = 1e-7 * np.array(noise(rows * columns, 12)).reshape(rows, columns)
    for c in range(1, columns):
        z[:, c] += 0.9 * z[:, c - 1]
    for r in range(1, rows):
        z[r] += 0.7 * z[r - 1]
    if with_holes:
        z.ravel()[np.arange(rows * columns) * 7 % 97 == 3] = np.nan
    return z


def mean_line(z, step, cutoff):
    """The Gaussian mean line of a profile that is continued by its mirror image at both ends."""
    reach = min(int(cutoff / step + 1e-9), len(z))
    longer = np.pad(z, reach, mode="symmetric")
    d = np.arange(-reach, reach + 1) * step
    w = np.exp(-np.pi * (d / (ALPHA * cutoff)) ** 2)
    return np.array([np.sum(w * longer[i : i + 2 * reach + 1]) for i in range(len(z))]) / np.sum(w)


def mean_surface(z, step_x, step_y, nesting):
    measured = ~np.isnan(z)
    filled = np.where(measured, z, 0.0)
    y, x = np.mgrid[: z.shape[0], : z.shape[1]] * np.array([step_y, step_x])[:, None, None]
    surface = np.full(z.shape, np.nan)
    for r, c in zip(*np.nonzero(measured)):
        dx, dy = x - x[r, c], y - y[r, c]
        w = np.exp(-np.pi * (dx**2 + dy**2) / (ALPHA * nesting) ** 2) * measured
        w = w * (abs(dx) <= nesting * (1 + 1e-9)) * (abs(dy) <= nesting * (1 + 1e-9))
        surface[r, c] = np.sum(w * filled) / np.sum(w)
    return surface


def degree(form):
    return {"mean": 0, "level": 1}[form] if isinstance(form, str) else form["polynomial"]


def element_width(z, step, section, rz):
    """The mean width of profile elements: mean-line crossings between peaks and valleys that count."""
    above = z > 0
    flips = np.nonzero(above[1:] != above[:-1])[0]
    zeros = flips + z[flips] / (z[flips] - z[flips + 1])
    edges = np.concatenate([[0.0], zeros, [len(z) - 1.0]])
    firsts = np.concatenate([[0], flips + 1])
    counting = []
    for k, first in enumerate(firsts):
        last = flips[k] if k < len(flips) else len(z) - 1
        tall = np.max(np.abs(z[first : last + 1])) >= 0.1 * rz
        if tall and (edges[k + 1] - edges[k]) * step >= 0.01 * section:
            counting.append((bool(above[first]), edges[k]))
    kept = [b[1] for a, b in zip(counting, counting[1:]) if a[0] != b[0]]
    elements = [b - a for a, b in zip(kept[::2], kept[2::2])]
    return float(np.mean(elements) * step) if elements else None


def slopes(z, step):
    taps = np.array([-1, 9, -45, 0, 45, -9, 1]) / (60 * step)
    inner = np.array([np.dot(taps, z[i - 3 : i + 4]) for i in range(3, len(z) - 3)])
    return np.concatenate([[np.nan] * 3, inner, [np.nan] * 3])


def profile_parameters(z, step, config):
    x = np.linspace(-1, 1, len(z))
    z = z - np.polynomial.legendre.Legendre.fit(x, z, degree(config["form"]))(x)
    cutoff = config["cutoff"]["stated"]
    if config["filter"] == "gauss":
        if config["short_waves"] != "kept":
            z = mean_line(z, step, config["short_waves"]["stated"])
        z = z - mean_line(z, step, cutoff)
    sections = min(5, int(len(z) * step / cutoff + 1e-6))
    start = (len(z) - sections * cutoff / step) / 2
    bounds = [int(np.floor(start + k * cutoff / step + 0.5)) for k in range(sections + 1)]
    gradient = slopes(z, step)
    z = z - np.mean(z[bounds[0] : bounds[-1]])
    pieces = list(zip(bounds, bounds[1:]))
    parts = [z[a:b] for a, b in pieces]
    everything = z[bounds[0] : bounds[-1]]
    rp, rv = np.mean([p.max() for p in parts]), np.mean([-p.min() for p in parts])
    own = config["standard"] == "iso4287"
    averaged = parts if own else [everything]

    def rq(p):
        return np.sqrt(np.mean(p**2))

    def average(f):
        return float(np.mean([f(p) for p in averaged]))

    rises = [p.max() - p.min() for p in parts] if own else [rp + rv]
    widths = [element_width(p, step, cutoff, rz) for p, rz in zip(averaged, rises)]
    widths = [w for w in widths if w is not None]
    steps = pieces if own else [(bounds[0], bounds[-1])]
    return dict(
        ra_m=average(lambda p: np.mean(abs(p))),
        rq_m=average(rq),
        rz_m=float(rp + rv),
        rt_m=float(everything.max() - everything.min()),
        rp_m=float(rp),
        rv_m=float(rv),
        rsk=average(lambda p: np.mean(p**3) / rq(p) ** 3),
        rku=average(lambda p: np.mean(p**4) / rq(p) ** 4),
        rsm_m=float(np.mean(widths)) if widths else None,
        rdq=float(np.mean([np.sqrt(np.nanmean(gradient[a:b] ** 2)) for a, b in steps])),
        sections=sections,
    )


def without_form(z, total):
    rows, columns = z.shape
    y, x = np.meshgrid(np.linspace(-1, 1, rows), np.linspace(-1, 1, columns), indexing="ij")
    terms = np.stack([x**i * y**j for i in range(total + 1) for j in range(total + 1 - i)], axis=-1)
    measured = ~np.isnan(z)
    coefficients = np.linalg.lstsq(terms[measured], z[measured], rcond=None)[0]
    return z - terms @ coefficients


def central_contour(z, step_x, step_y):
    """The nearest and farthest point of the 0.2 contour round zero lag."""
    measured = (~np.isnan(z)).astype(float)
    filled = np.where(measured > 0, z, 0.0)
    products = signal.correlate(filled, filled, method="direct")
    pairs = signal.correlate(measured, measured, method="direct")
    rows, columns = z.shape
    acf = products / np.maximum(pairs, 1) / (products[rows - 1, columns - 1] / pairs[rows - 1, columns - 1])
    y0, x0 = rows // 2, columns // 2
    acf = acf[rows - 1 - y0 : rows + y0, columns - 1 - x0 : columns + x0]
    x, y = np.arange(-x0, x0 + 1) * step_x, np.arange(-y0, y0 + 1) * step_y
    lines = contourpy.contour_generator(x, y, acf).lines(0.2)
    # the closed line that winds round the origin
    for line in lines:
        angles = np.unwrap(np.arctan2(line[:, 1], line[:, 0]))
        if abs(angles[-1] - angles[0]) > 6:
            distances = np.hypot(line[:, 0], line[:, 1])
            return float(distances.min()), float(distances.min() / distances.max())
    return None, None


def areal_parameters(z, step_x, step_y, config):
    z = without_form(z, degree(config["form"]))
    if config["s_nesting_m"]:
        z = mean_surface(z, step_x, step_y, config["s_nesting_m"])
    if config["l_nesting_m"]:
        z = z - mean_surface(z, step_x, step_y, config["l_nesting_m"])
    z = z - np.nanmean(z)
    sq = np.sqrt(np.nanmean(z**2))
    steep = []
    for r in range(z.shape[0] - 1):
        for c in range(z.shape[1] - 1):
            square = z[r : r + 2, c : c + 2]
            for x in np.diff(square, axis=1).ravel() / step_x:
                for y in np.diff(square, axis=0).ravel() / step_y:
                    steep.append(x**2 + y**2)
    steep = np.array(steep)
    sal, aspect = central_contour(z, step_x, step_y)
    whole = ~np.isnan(steep)
    # a square with a hole has corners whose own sides are measured: they do not count
    whole = np.repeat(whole.reshape(-1, 4).all(axis=1), 4)
    return dict(
        sa_m=float(np.nanmean(abs(z))),
        sq_m=float(sq),
        sz_m=float(np.nanmax(z) - np.nanmin(z)),
        sp_m=float(np.nanmax(z)),
        sv_m=float(-np.nanmin(z)),
        ssk=float(np.nanmean(z**3) / sq**3),
        sku=float(np.nanmean(z**4) / sq**4),
        sdq=float(np.sqrt(np.mean(steep[whole]))),
        sdr=float(np.mean(np.sqrt(1 + steep[whole]) - 1)),
        sal_m=sal,
        str_ratio=aspect,
    )


def profile_case(surface, heights, **changes):
    config = dict(standard="iso21920", form="level", filter="gauss", cutoff={"stated": 0.8e-3}, short_waves="kept")
    config |= changes
    return dict(surface=surface, points=len(heights), config=config, values=profile_parameters(heights, 1e-6, config))


def areal_case(rows, columns, with_holes, form, s, l):
    config = dict(form=form, s_nesting_m=s, l_nesting_m=l)
    z = rough_map(rows, columns, with_holes)
    return dict(
        rows=rows,
        columns=columns,
        holes="holes" if with_holes else "none",
        config=config,
        values=areal_parameters(z, 1e-6, 1.5e-6, config),
    )


def areal_by_surfalize(surface):
    return dict(
        sa_m=surface.Sa() * 1e-6,
        sq_m=surface.Sq() * 1e-6,
        sz_m=surface.Sz() * 1e-6,
        ssk=surface.Ssk(),
        sku=surface.Sku(),
        sdq=surface.Sdq(),
        sdr=surface.Sdr() / 100,
        sal_m=surface.Sal() * 1e-6,
        str_ratio=surface.Str(),
    )


def stratified(points):
    """A plateau with valleys: noise, its depths three times as deep."""
    heights = 1e-7 * np.array(noise(points, 13))
    return np.where(heights < -5e-8, 3 * heights + 1e-7, heights)


def material_ratio(heights):
    profile = surfalize.Profile((heights - np.mean(heights)) * 1e6, 1.0)
    return dict(
        rk_m=profile.Rk() * 1e-6,
        rpk_m=profile.Rpk() * 1e-6,
        rvk_m=profile.Rvk() * 1e-6,
        mr1=profile.Rmrk1() / 100,
        mr2=profile.Rmrk2() / 100,
    )


def second_opinions():
    _, _, measured = np.loadtxt(sys.argv[1], delimiter=",").T
    measured = surfalize.Surface(measured.reshape(101, 101), 5.0, 5.0).level()
    heights = rough_profile(5000)
    profile = surfalize.Profile(heights * 1e6, 1.0).level()
    z = rough_map(120, 120, False)
    surface = surfalize.Surface(z * 1e6, 1.0, 1.0)
    topography = SurfaceTopography.Topography(z, (120e-6, 120e-6)).detrend("center")
    return dict(
        surfalize_profile=dict(
            ra_m=profile.Ra() * 1e-6,
            rq_m=profile.Rq() * 1e-6,
            rz_m=profile.Rz(5) * 1e-6,
            rt_m=profile.Rt() * 1e-6,
            rp_m=profile.Rp(5) * 1e-6,
            rv_m=profile.Rv(5) * 1e-6,
            rsk=profile.Rsk(),
            rku=profile.Rku(),
        ),
        surfalize_material_ratio=[material_ratio(heights) for heights in (rough_profile(5000), stratified(5000))],
        surfalize_map=areal_by_surfalize(surface),
        surfalize_nanovea=areal_by_surfalize(measured),
        surface_topography_map=dict(
            sq_m=topography.rms_height_from_area(),
            sdq=topography.rms_gradient(),
        ),
    )


def plain(value):
    if isinstance(value, dict):
        return {k: plain(v) for k, v in value.items()}
    if isinstance(value, list):
        return [plain(v) for v in value]
    return value.item() if isinstance(value, np.generic) else value


rough = rough_profile(5000)
profiles = [
    profile_case("rough", rough),
    profile_case("rough", rough, standard="iso4287"),
    profile_case("rough", rough, short_waves={"stated": 10e-6}),
    profile_case("rough", rough, standard="iso4287", form={"polynomial": 5}, filter="none"),
    profile_case("rough", rough[:2900], form={"polynomial": 3}),
    profile_case("rough", rough[:2900], standard="iso4287", cutoff={"stated": 0.25e-3}),
    profile_case("sine", sine(5000), form="mean"),
    profile_case("sine", sine(5000), form="mean", standard="iso4287"),
    profile_case("square_wave", square_wave(5000), form="mean", filter="none"),
]
maps = [
    areal_case(60, 80, False, "mean", None, None),
    areal_case(60, 80, True, "mean", None, None),
    areal_case(60, 80, False, "level", 3e-6, 40e-6),
    areal_case(60, 80, True, {"polynomial": 2}, None, 50e-6),
]
packages = ("numpy", "scipy", "contourpy", "surfalize", "SurfaceTopography")
made_with = ", ".join(f"{name} {version(name)}" for name in packages)
print(json.dumps(plain(dict(made_with=made_with, profiles=profiles, maps=maps, **second_opinions())), indent=1))
