"""Figures of reports, drawn with matplotlib. Labels, units, ranges and numbers are those of the report."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np

from ._errors import UsageError

#: The colours of the report by what they stand for.
TONES = {
    "reference": "#1e1e1e",
    "pale": "#acb4bc",
    "main": "#007967",
    "second": "#c6531a",
    "signal": "#005a8c",
    "accent": "#d55e00",
    "third": "#009e73",
    "border": "#6e767e",
}
#: Of lines that count alike, as many as can be told apart (M. Okabe and K. Ito, Color Universal Design, 2008).
DISTINCT = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000"]
LIMIT, SHADE, LINE, UNTESTED = "#be1e2d", "#007967", "#969ea6", "#eef0f2"
WIDTHS = {"thin": 0.75, "usual": 1.5, "thick": 3.5}
DOTS = {"thin": 3.5, "usual": 5.5, "thick": 9.5}
#: More lines have their legend beside them.
MOST_ABOVE = 6
#: The deepest scale of a spectrogram in dB, and the share of its cells that may lie below.
DEEPEST_DB, BELOW_SCALE = 80.0, 0.02


def draw(figure: dict[str, Any], ax: Any = None) -> Any:
    """Draws a figure of a report; its axes, as a list where it has several. One chart may be drawn into `ax`."""
    try:
        plt = import_module("matplotlib.pyplot")
    except ModuleNotFoundError as missing:
        if missing.name is not None and missing.name.partition(".")[0] == "matplotlib":
            raise ModuleNotFoundError(
                "plot() draws with matplotlib, which is not installed: pip install matplotlib, or pip install 'piezotact[plot]'",
                name=missing.name,
            ) from None
        raise
    drawn = figure["drawn"]
    kind = drawn["kind"]
    if kind == "chart":
        if ax is None:
            ax = plt.subplots(figsize=(7, 3.6), layout="constrained")[1]
        _chart(ax, drawn)
        return ax
    if ax is not None:
        raise UsageError(f"ax: expected a figure that is one chart, found {kind}; leave ax out")
    if kind == "panels":
        charts = drawn["charts"]
        shape = {"figsize": (7, 0.8 + 2 * len(charts)), "layout": "constrained"}
        axes = list(plt.subplots(len(charts), 1, sharex=True, squeeze=False, **shape)[1].flat)
        for place, chart in zip(axes, charts):
            _chart(place, chart)
            place.label_outer()
        return axes
    if kind == "spectrograms":
        return _spectrograms(plt, drawn)
    if kind == "maps":
        return _maps(plt, drawn)
    if kind == "bars":
        place = plt.figure(figsize=(7, 5), layout="constrained").add_subplot(projection="3d")
        _bars(place, drawn)
        return place
    place = plt.subplots(figsize=(7, 4.6), layout="constrained")[1]
    {"heatmap": _heatmap, "matrix": _matrix}[kind](place, drawn)
    return place


def _numbers(values: Any, width: int) -> Any:
    """Rows of `width` numbers, in which an absent one is NaN."""
    return np.array(values, dtype=np.float64).reshape(-1, width)


def _colour(tone: Any) -> Any:
    if isinstance(tone, str):
        return TONES[tone]
    index, count = tone["of"]["index"], tone["of"]["count"]
    if count <= len(DISTINCT):
        return DISTINCT[index]
    return import_module("matplotlib").colormaps["viridis"](0.9 * index / (count - 1))


def _axis(axis: Any, described: dict[str, Any], label: Any, scale: Any, limits: Any) -> None:
    """Gives an axis of matplotlib its label, range and ticks."""
    label(described["label"])
    kind = described["scale"]
    if kind == "logarithmic":
        scale("log")
    limits(described["low"], described["high"])
    if isinstance(kind, dict):
        names = kind["names"]
        axis.set_ticks(range(len(names)), labels=names)
    elif described.get("ticks"):
        axis.set_ticks(described["ticks"], labels=[f"{tick:.3g}" for tick in described["ticks"]])
        axis.set_ticks([], minor=True)


def _axes(ax: Any, x: dict[str, Any], y: dict[str, Any]) -> None:
    _axis(ax.xaxis, x, ax.set_xlabel, ax.set_xscale, ax.set_xlim)
    _axis(ax.yaxis, y, ax.set_ylabel, ax.set_yscale, ax.set_ylim)


def _chart(ax: Any, chart: dict[str, Any]) -> None:
    for colour, ranges, strength in ((SHADE, chart["shaded"], 0.10), (LIMIT, chart["rejected"], 0.08)):
        for low, high in ranges:
            ax.axvspan(low, high, color=colour, alpha=strength, linewidth=0)
    labelled = 0
    for line in chart["lines"]:
        colour, mark, weight = _colour(line["tone"]), line["mark"], line["weight"]
        if line["ribbon"]:
            x, low, high = _numbers(line["ribbon"], 3).T
            ax.fill_between(x, low, high, color=colour, alpha=0.25, linewidth=0)
        if line["spread"]:
            x, low, high = _numbers(line["spread"], 3).T
            ax.vlines(x, low, high, color=colour, alpha=0.6, linewidth=1.2)
        style: dict[str, Any] = {"linestyle": {"dashed": "--", "dots": "none"}.get(mark, "-"), "linewidth": WIDTHS[weight]}
        if mark in {"dots", "joined"}:
            style |= {"marker": "o", "markersize": DOTS[weight], "markeredgewidth": 0}
        ax.plot(*_numbers(line["points"], 2).T, color=colour, label=line["label"] or None, **style)
        labelled += bool(line["label"])
    for level in chart["levels"]:
        ax.axhline(level, color=LIMIT, linewidth=1, zorder=1.5)
    for x, y, text in chart["notes"]:
        ax.annotate(text, (x, y), xytext=(5, 5), textcoords="offset points", fontsize="small")
    _axes(ax, chart["x"], chart["y"])
    ax.grid(color="#dee2e6", linewidth=0.8)
    ax.set_axisbelow(True)
    if chart["title"]:
        ax.set_title(chart["title"], loc="right" if labelled else "center", fontsize="medium")
    if labelled and (chart["legend"] == "beside" or labelled > MOST_ABOVE):
        ax.legend(loc="upper left", bbox_to_anchor=(1, 1), frameon=False, fontsize="small")
    elif labelled:
        ax.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=min(labelled, 3), frameon=False, fontsize="small")


def _heatmap(ax: Any, drawn: dict[str, Any]) -> None:
    wide, high = drawn["size"]
    low, top = drawn["scale"]
    image = ax.imshow(_numbers(drawn["values"], drawn["columns"]), extent=(0, wide, high, 0), vmin=low, vmax=top, cmap="viridis")
    ax.set_xlabel(f"x, {drawn['length_unit']}")
    ax.set_ylabel(f"y, {drawn['length_unit']}")
    ax.figure.colorbar(image, ax=ax, label=drawn["label"], shrink=0.8)


def _shares(drawn: dict[str, Any]) -> Any:
    """Of each square the number, the number that has the darkest colour, and the text."""
    for i, row in enumerate(drawn["squares"]):
        for j, square in enumerate(row):
            shade = square["shade"]
            if isinstance(shade, dict) and "percent" in shade:
                yield i, j, square, shade["percent"], 100.0, f"{shade['percent']:.0f}"
            elif isinstance(shade, dict):
                count, most = shade["count"]
                yield i, j, square, float(count), float(max(most, 1)), str(count)
            else:
                yield i, j, square, np.nan, 100.0, ""


def _matrix(ax: Any, drawn: dict[str, Any]) -> None:
    matplotlib = import_module("matplotlib")
    import_module("matplotlib.patches")
    colours = matplotlib.colors.LinearSegmentedColormap.from_list("association", ["#ffffff", "#005468"])
    squares = list(_shares(drawn))
    values = np.full((len(drawn["rows"]), len(drawn["columns"])), np.nan)
    full = next((most for _, _, _, value, most, _ in squares if value == value), 100.0)
    for i, j, square, value, most, text in squares:
        values[i, j] = value
        corner = (j - 0.5, i - 0.5)
        if square["shade"] == "untested":
            ax.add_patch(matplotlib.patches.Rectangle(corner, 1, 1, facecolor=UNTESTED, edgecolor="#b4bac0", hatch="///", linewidth=0))
        ax.text(j, i, text, ha="center", va="center", color="white" if value >= 0.5 * most else "#464e56")
        if square["dotted"]:
            ax.plot(j + 0.38, i - 0.36, ".", color=LIMIT)
        if square["outlined"]:
            ax.add_patch(matplotlib.patches.Rectangle(corner, 1, 1, fill=False, edgecolor="#1f262d", linewidth=2, zorder=3))
    image = ax.imshow(values, cmap=colours, vmin=0, vmax=full, aspect="auto")
    ax.set_xticks(range(len(drawn["columns"])), drawn["columns"])
    ax.set_yticks(range(len(drawn["rows"])), drawn["rows"])
    ax.xaxis.tick_top()
    ax.xaxis.set_label_position("top")
    ax.set_xlabel(drawn["column_label"])
    ax.set_ylabel(drawn["row_label"])
    ax.figure.colorbar(image, ax=ax, label=drawn["scale_label"])
    if any(square["shade"] == "untested" for _, _, square, _, _, _ in squares):
        hatched = matplotlib.patches.Patch(facecolor=UNTESTED, edgecolor="#b4bac0", hatch="///", label=drawn["untested_label"])
        ax.legend(handles=[hatched], loc="upper left", bbox_to_anchor=(0, 0), frameon=False)


def _bars(ax: Any, drawn: dict[str, Any]) -> None:
    for i, j, square, value, _, _ in _shares(drawn):
        if value == value:
            ax.bar3d(j - 0.35, i - 0.35, 0, 0.7, 0.7, value, color="#1b6d81" if square["outlined"] else "#be3440")
    ax.set_xticks(range(len(drawn["columns"])), drawn["columns"])
    ax.set_yticks(range(len(drawn["rows"])), drawn["rows"])
    ax.set_xlabel(drawn["column_label"])
    ax.set_ylabel(drawn["row_label"])
    ax.set_zlabel(drawn["scale_label"])


def _grid(plt: Any, count: int, side: float) -> tuple[Any, list[Any]]:
    """A figure of `count` panels in rows of three at most."""
    across = min(count, 3 if count != 4 else 2)
    down = -(-count // across)
    size = (max(7.0, side * across), max(3.0, 0.9 * side * down + 0.6))
    figure, axes = plt.subplots(down, across, squeeze=False, sharex=True, sharey=True, figsize=size, layout="constrained")
    for spare in axes.flat[count:]:
        spare.remove()
    return figure, list(axes.flat[:count])


def _spectrograms(plt: Any, drawn: dict[str, Any]) -> Any:
    panels = drawn["panels"]
    figure, axes = _grid(plt, len(panels), 3.2)
    levels = np.concatenate([_numbers(panel["levels_db"], 1).ravel() for panel in panels])
    levels = levels[np.isfinite(levels)] if np.isfinite(levels).any() else np.zeros(1)
    top = levels.max()
    low = max(np.quantile(levels, BELOW_SCALE), top - DEEPEST_DB)
    for ax, panel in zip(axes, panels):
        # Rows come from the highest frequency down.
        cells = _numbers(panel["levels_db"], len(panel["times_s"]))[::-1]
        image = ax.pcolormesh(panel["times_s"], panel["frequencies_hz"], cells, vmin=low, vmax=top, cmap="viridis", shading="nearest")
        ax.set_title(panel["title"], fontsize="medium")
        ax.set_facecolor("#dee2e6")
        ax.set_xlabel("time, s")
        ax.set_ylabel("frequency, Hz")
        ax.label_outer()
    figure.colorbar(image, ax=axes, label=f"PSD, dB re 1 {drawn['unit']}")
    return axes[0] if len(axes) == 1 else axes


def _maps(plt: Any, drawn: dict[str, Any]) -> Any:
    patches = import_module("matplotlib.patches")
    panels, reach = drawn["panels"], drawn["reach"]
    figure, axes = _grid(plt, len(panels), 2.8)
    for ax, panel in zip(axes, panels):
        ground = panel["ground"]
        head = ground["kind"] == "head"
        extent = [-1, 1, -1, 1] if head else [ground[axis][end] for axis in "xy" for end in ("low", "high")]
        values = _numbers(panel["values"], panel["columns"])
        image = ax.imshow(values, extent=extent, vmin=-reach, vmax=reach, cmap="RdBu_r", aspect="equal" if head else "auto")
        ax.set_title(panel["title"], fontsize="medium")
        if head:
            ax.add_patch(patches.Circle((0, 0), ground["radius"], fill=False, color="#464e56"))
            ax.plot(*_numbers([one[:2] for one in ground["electrodes"]], 2).T, "k.", markersize=3)
            ax.set_axis_off()
            continue
        for place in ground["marked"]:
            ax.axvline(place, color="#464e56", linewidth=1)
        for left, right, low, high in ground["outlined"]:
            ax.add_patch(patches.Rectangle((left, low), right - left, high - low, fill=False, color="#464e56"))
        _axes(ax, ground["x"], ground["y"])
        ax.label_outer()
    figure.colorbar(image, ax=axes, label=drawn["label"])
    return axes[0] if len(axes) == 1 else axes
