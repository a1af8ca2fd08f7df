"""Whose side the claims 24, 25, 27 and 28 of the thesis are on: the volunteers of the twin without its benches.

Independent of the program. People have the levels of the twin's samples, with the scatter from person to person of
`person.loudness_spread_by_sample`; the rules by which they judge are restated from docs/decisions/twin.md. Rendered textures differ
from the real ones by 0.4 dB in level and 0.5 dB in each band, and from play to play by 0.2 and 0.4 dB. Bands of the periodic samples
are means of ten people (`twin record --bench acttouch`, seed 1). What `replay --panels 40` counted comes out again: with it the
shares of the volunteers and of the stimulus can be told apart, which takes hours on the benches.

    python3 golden/claims_of_people.py      Python >= 3.11 alone, 2 min; prints the numbers in docs/decisions/thesis.md
"""

import math
import random
import tomllib
from collections import Counter, defaultdict
from pathlib import Path

TWIN = tomllib.loads(
    (Path(__file__).parent.parent / "crates/piezotact-twin/parameters.toml").read_text()
)
SCATTER = TWIN["person"]["loudness_spread_by_sample"]["value"]
COMMON = TWIN["person"]["loudness_spread"]["value"]
ISOTROPIC = [f"S{i}" for i in range(1, 14)] + ["NO"]
PERIODIC = [f"M{i}" for i in range(1, 13)]
BROAD = [0.06, 0.20, 0.38, 0.29, 0.07]  # shares of the broad part in five bands of 20-1000 Hz
MEASURED_DB = {
    "M1": [-19.8, -8.7, -6.9, -3.7, -6.8], "M2": [-19.6, -8.7, -3.8, -6.0, -8.1],
    "M3": [-17.6, -9.1, -5.5, -7.8, -4.0], "M4": [-21.5, -9.6, -3.5, -5.9, -7.9],
    "M5": [-17.3, -6.1, -3.9, -6.3, -11.3], "M6": [-19.8, -8.8, -3.3, -6.5, -8.0],
    "M7": [-17.5, -6.3, -3.8, -6.2, -11.3], "M8": [-11.0, -4.5, -5.7, -6.8, -15.3],
    "M9": [-22.1, -4.2, -5.0, -6.9, -11.2], "M10": [-17.7, -4.4, -4.8, -6.7, -13.2],
    "M11": [-17.4, -6.1, -3.9, -6.3, -11.4], "M12": [-17.4, -6.1, -3.9, -6.2, -11.3],
}  # fmt: skip
TRIPLETS = [
    s.split()
    for s in "S2 S4 S8,S5 S7 S9,S6 S11 S10,S1 S3 S13,S5 S8 S12,S5 S9 S10,S2 S3 S4,S1 S8 S13,S1 S7 S12,"
    "S4 S13 S10,S4 S8 S9,S13 S12 S10".split(",")
]
PILOT = [
    s.split()
    for s in "M1 M8 M10,M11 M9 M12,M4 M2 M3,M6 M7 M5 M11,M1 M11 M4,M8 M11 M2,M10 M11 M3,M10 M9 M4,M12 M7 M1 M2,"
    "M3 M6 M1,M1 M5 M9,M8 M9 M7 M3,M12 M8 M4 M6,M6 M9 M2,M2 M10 M5 M12,M4 M7 M5,M8 M5 M3 M12,M10 M7 M6".split(",")
]
EXCHANGED = {"S2 INVERTED": "S13", "S13 INVERTED": "S2", "S5 INVERTED": "S11", "S11 INVERTED": "S5"}
TESTS = [
    "S2 INVERTED,S6,S13 INVERTED", "S6,S13,S2", "S13 INVERTED,S2 INVERTED,S6", "S2,S13,S6",
    "S11,S8,S5", "S5 INVERTED,S8,S11 INVERTED", "S8,S5,S11", "S8,S5 INVERTED,S11 INVERTED",
]  # fmt: skip
VOLUNTEERS = {"noise": 1.0, "bias": 0.04, "lapse": 0.015}
FAULTLESS = {"noise": 1e-3, "bias": 0.0, "lapse": 0.0}


def value(sample, name, default=0.0):
    return TWIN["samples"][sample].get(name, {"value": default})["value"]


def bands_db(sample):
    if sample in MEASURED_DB:
        return MEASURED_DB[sample]
    ridge = value(sample, "ridge_share")
    shares = [(1 - ridge) * share for share in BROAD]
    shares[1] += 0.8 * ridge
    shares[2] += 0.2 * ridge
    return [10 * math.log10(share) for share in shares]


class Volunteer:
    """One person: real samples and drives as (ln rms, bands in dB), lasting biases, and the number of the judgement."""

    def __init__(self, draw, samples, touch, scatter):
        self.draw, self.touch, self.judgement = draw, touch, 0
        loud = COMMON * draw.gauss(0, 1)
        self.real = {
            s: (math.log(value(s, "rms_m_s2")) + loud + scatter * draw.gauss(0, 1), bands_db(s)) for s in samples
        }
        self.drive = {s: self.moved(self.real[s], 0.045, 0.5) for s in samples}
        for name, expected in EXCHANGED.items():
            own = name.split()[0]
            if own in samples:
                self.drive[name] = self.moved((self.real[expected][0], self.real[own][1]), 0.045, 0.5)
        self.bias = {s: touch["bias"] * draw.gauss(0, 1) for s in samples}

    def moved(self, cues, level, band):
        return cues[0] + level * self.draw.gauss(0, 1), [b + band * self.draw.gauss(0, 1) for b in cues[1]]

    def noise(self):
        n = self.judgement
        return self.touch["noise"] * (1 + 0.2 * math.exp(-n / 10) + 0.1 * n / 100)

    def order(self, samples):
        """From the roughest to the smoothest; real samples, nine looks."""
        deviation = self.noise() * 0.18 / 3
        rough = {}
        for s in samples:
            period_um = max(1e6 * value(s, "grain_m"), 100)
            level = self.real[s][0] + self.bias[s] + 0.15 * math.log(period_um / 100)
            # The plate without texture sticks: it comes last.
            rough[s] = level + deviation * self.draw.gauss(0, 1) - (1e3 if s == "NO" else 0)
        order = sorted(samples, key=lambda s: -rough[s])
        if self.draw.random() < self.touch["lapse"]:
            k = self.draw.randrange(len(order) - 1)
            order[k], order[k + 1] = order[k + 1], order[k]
        self.judgement += 1
        return order

    def associate(self, cues, alternatives, looked, memory, weight):
        """The alternative that is most like `cues`: a look at it has a noise of `looked` in ln rms."""
        if self.draw.random() < self.touch["lapse"]:
            return self.draw.choice(alternatives)
        level, band = 1 / (0.06 * math.sqrt(2)), math.sqrt(weight / 5) / 2.5
        of_level = self.noise() * math.sqrt(looked**2 / 9 + memory**2 * 0.18**2 / 9)
        of_band = self.noise() * 2.5 / math.sqrt(2) * math.sqrt((1 + memory**2) / 9)
        felt = self.moved(cues, of_level, of_band)

        def distance(s):
            apart = (level * (felt[0] - self.real[s][0] - self.bias[s])) ** 2
            return apart + sum((band * (x - y)) ** 2 for x, y in zip(felt[1], self.real[s][1]))

        return min(alternatives, key=distance)

    def rendered(self, stimulus, alternatives, weight):
        return self.associate(self.moved(self.drive[stimulus], 0.02, 0.4), alternatives, 0.21, 1.0, weight)


def places(task, order, listed):
    return zip([task] * len(order), order, sorted(order, key=listed.index))


def isotropic(draw, touch, scatter):
    one, rows = Volunteer(draw, ISOTROPIC, touch, scatter), []
    for _ in range(3):
        rows += places("1", one.order(draw.sample(ISOTROPIC, 14)), ISOTROPIC)
    for triplet in draw.sample(TRIPLETS, 12):
        rows += places("2", one.order(triplet), ISOTROPIC)
        for _ in range(draw.choice([3, 4])):
            stimulus = draw.choice(triplet)
            rows.append(("3", stimulus, one.rendered(stimulus, triplet, 1)))
        one.judgement += 1
    return rows


def exchanged(draw, touch, scatter):
    sets = [["S2", "S6", "S13"], ["S5", "S8", "S11"]]
    one, rows = Volunteer(draw, sets[0] + sets[1], touch, scatter), []
    for i, names in enumerate(sets):
        rows += places("2", one.order(names), ISOTROPIC)
        for test in TESTS[4 * i : 4 * i + 4]:
            rows += [("3", s, one.rendered(s, names, 1)) for s in test.split(",")]
            one.judgement += 1
    return rows


def pilot(draw, touch, scatter):
    one, rows = Volunteer(draw, PERIODIC, touch, scatter), []
    for names in draw.sample(PILOT, 18):
        for s in draw.sample(names, len(names)):
            rows.append(("1", s, one.associate(one.real[s], names, 0.18, 1.5, 4)))
            one.judgement += 1
        for _ in range(draw.choice([5, 6])):
            stimulus = draw.choice(names)
            rows.append(("2", stimulus, one.rendered(stimulus, names, 4)))
        one.judgement += 1
    return rows


def matrix(rows, task):
    cells = defaultdict(Counter)
    for of, presented, answered in rows:
        if of == task:
            cells[presented][answered] += 1
    return cells


def percent(cells, presented, answered):
    return 100 * cells[presented][answered] / max(1, cells[presented].total())


def of_isotropic(rows):
    tasks = {task: matrix(rows, task) for task in "123"}
    block, worst, pair, inside = {f"S{i}" for i in range(9, 14)}, {}, {}, {}
    for task, cells in tasks.items():
        worst[task] = min(percent(cells, s, s) for s in ("S4", "S5", "S6", "S7"))
        pair[task] = (percent(cells, "S2", "S3") + percent(cells, "S3", "S2")) / 2
        wrong = [(b, n) for s in block for b, n in cells[s].items() if b != s]
        inside[task] = 100 * sum(n for b, n in wrong if b in block) / max(1, sum(n for _, n in wrong))
    cells = sorted({(a, b) for names in TRIPLETS for a in names for b in names if a != b})
    x, y = ([percent(tasks[task], *cell) for cell in cells] for task in "23")
    mx, my = sum(x) / len(x), sum(y) / len(y)
    products = [sum((a - p) * (b - q) for a, b in zip(u, v)) for u, v, p, q in ((x, y, mx, my), (x, x, mx, mx), (y, y, my, my))]
    return {
        "24 S4-S7, worst cell, %": (min(worst.values()), lambda v: v >= 80),
        "   in task 1": (worst["1"], lambda v: v >= 80),
        "   in task 2": (worst["2"], lambda v: v >= 80),
        "   in task 3": (worst["3"], lambda v: v >= 80),
        "24 S2 and S3, %": (min(pair.values()), lambda v: v >= 10),
        "24 S9-S13 inside, %": (min(inside.values()), lambda v: v >= 80),
        "24 NO, %": (percent(tasks["1"], "NO", "NO"), lambda v: v == 100),
        "25 correlation": (products[0] / math.sqrt(products[1] * products[2]), lambda v: v >= 0.6),
    }


def of_exchanged(rows):
    errors = Counter((s, a) for task, s, a in rows if task == "3" and a != EXCHANGED.get(s, s))
    sets = [{"S2", "S6", "S13"}, {"S5", "S8", "S11"}]
    plain = max(sum(n for (s, _), n in errors.items() if s in names) for names in sets)
    of_exchanged = {key: n for key, n in errors.items() if key[0] in EXCHANGED}
    wanted = of_exchanged.pop(("S11 INVERTED", "S8"), 0)
    presented = sum(task == "3" and s in EXCHANGED for task, s, _ in rows)
    right = 100 * (1 - (sum(of_exchanged.values()) + wanted) / presented)
    return {
        "27 as expected, %": (right, lambda v: v >= 80),
        "27 real out of place": (sum(s != a for task, s, a in rows if task == "2"), lambda v: v == 0),
        "27 plain wrong of 30": (plain, lambda v: v <= 1),
        "27 S11 INVERTED as S8": (wanted, lambda v: v >= 1),
        "27 that less any other": (wanted - max(of_exchanged.values(), default=0), lambda v: v >= 0),
    }


def of_pilot(rows):
    hard, found = ("M5", "M7", "M11", "M12"), {}
    beyond, apart, less = [], [], []
    for task in "12":
        cells = matrix(rows, task)
        own = {s: percent(cells, s, s) for s in PERIODIC if cells[s]}
        ranked = sorted(own.values())
        median = (ranked[(len(ranked) - 1) // 2] + ranked[len(ranked) // 2]) / 2
        beyond.append(max(own[s] for s in hard if s in own) - median)
        apart.append(max(percent(cells, "M4", "M8"), percent(cells, "M8", "M4")))
        few = [own[s] for s in hard if s in own]
        rest = [p for s, p in own.items() if s not in hard]
        less.append(sum(few) / len(few) - sum(rest) / len(rest))
        found[f"   task {task}: M5, M7, M12, %"] = (sum(own.get(s, 100) for s in ("M5", "M7", "M12")) / 3, lambda v: True)
        found[f"   task {task}: M11, %"] = (own.get("M11", 100), lambda v: True)
    return {
        "28 best of four above median": (max(beyond), lambda v: v < 0),
        "28 M4 and M8, %": (max(apart), lambda v: v == 0),
        "   mean of four less others": (max(less), lambda v: v < 0),
        **found,
    }


def main():
    conditions = [
        ("all", VOLUNTEERS, SCATTER),
        ("stimulus alone: faultless volunteers", FAULTLESS, SCATTER),
        ("volunteers alone: people alike", VOLUNTEERS, 0.0),
        ("lapses of 0.05 %", {**VOLUNTEERS, "lapse": 0.0005}, SCATTER),
    ]
    for name, touch, scatter in conditions:
        print(name)
        for person, numbers, people in ((isotropic, of_isotropic, 10), (exchanged, of_exchanged, 5), (pilot, of_pilot, 1)):
            draw = random.Random(1)
            panels = [numbers([row for _ in range(people) for row in person(draw, touch, scatter)]) for _ in range(400)]
            for rule in panels[0]:
                values = sorted(panel[rule][0] for panel in panels)
                met = sum(panel[rule][1](panel[rule][0]) for panel in panels) / 4
                print(f"  {rule:30} {sum(values) / 400:7.2f}  95 % {values[10]:7.2f} to {values[389]:7.2f}  met by {met:5.1f} %")


if __name__ == "__main__":
    main()
