"""Writes ``python/piezotact/_functions`` from the commands as the program describes them, and from ``docs/schemas``.

``python generate.py`` writes it, with the package installed; ``python generate.py --check`` says whether it is up to date.
"""

from __future__ import annotations

import json
import keyword
import re
import sys
import textwrap
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
SCHEMAS = HERE.parent / "docs" / "schemas"
TARGET = HERE / "python" / "piezotact" / "_functions"
WIDTH = 120


@dataclass
class Function:
    """A function: the command that it is, and what is different from it."""

    name: str
    command: str
    #: The classes of results, with the schemas of their documents.
    results: dict[str, str]
    #: The arguments that may be arrays or recordings.
    data: tuple[str, ...] = ()
    #: What required outputs are called in a temporary folder.
    outputs: dict[str, str] = field(default_factory=dict)
    #: Flags that are always set.
    fixed: tuple[str, ...] = ()
    #: Arguments that it does not have.
    without: tuple[str, ...] = ()
    #: Several of these arguments are written to a folder instead of a file.
    several: tuple[str, ...] = ()
    #: What the command says elsewhere.
    notes: str = ""
    #: What it does, where that is not what the command does.
    about: str = ""
    #: The figure of the report that it is about, from 1 on.
    figure: int = 1


FUNCTIONS = [
    Function("info", "info", {"Info": "info"}, data=("file",)),
    Function("spectrum", "spectrum", {"Spectrum": "spectrum"}, data=("file",), without=("rest", "band"),
             about="Estimates the power spectral density (PSD) of one channel, averaged or over time."),
    Function("spectrogram", "spectrum", {"Spectrogram": "spectrum"}, data=("file",), fixed=("over_time",), figure=2,
             without=("rest", "band", "median", "over_time"),
             about="Estimates the power spectral density (PSD) of one channel over time.",
             notes="`over_time` has `times_s`, `frequencies_hz` and `psd`, a row for each frequency, in `unit`. There are at most 600 times and 300 "
                   "frequencies: neighbouring segments and lines of longer signals are averaged. The other attributes are those of `spectrum`."),
    Function("noise", "spectrum", {"Noise": "noise"}, data=("file",), fixed=("rest",),
             without=("rest", "segment", "overlap", "window", "median", "over_time", "max_frequency"),
             about="Measures the noise of a sensor at rest: noise floor, mains hum, drift, and whether it was at rest."),
    Function("strokes", "strokes", {"Strokes": "analysis"}, data=("recordings",), without=("cuts_only", "write_cuts")),
    Function("cut", "strokes", {"Cuts": "segmentation"}, data=("recordings",), fixed=("cuts_only",), without=("cuts_only", "by"),
             about="Cuts recordings into strokes and lists them, with the rejected parts and their reasons."),
    Function("compare", "compare", {"Comparison": "comparison"}, data=("recordings",)),
    Function("roughness", "roughness", {"Roughness": "roughness", "RoughnessSet": "roughness_set"}),
    Function("transfer", "transfer", {"Transfer": "transfer"}, data=("recording",), outputs={"out": "transfer.json"}),
    Function("characterise", "characterise", {"Characterisation": "characterise"}, outputs={"out": "transfer.json"}),
    Function("render", "render", {"Rendering": "render", "Renderings": "render_batch"}, data=("targets",), outputs={"out": "drive.wav"},
             several=("targets", "transfer")),
    Function("play", "play", {"Played": "play"}, outputs={"record": "measured.parquet"}),
    Function("verify", "verify", {"Verification": "verify"}, data=("target", "measured", "also")),
    Function("score", "score", {"Score": "score"}, data=("reference", "test")),
    Function("manipulate", "manipulate", {"Manipulated": "manipulate"}, data=("input",), outputs={"out": "texture.wav"}),
    Function("prepare", "prepare", {"Prepared": "prepare", "PreparedStimuli": "prepare_stimuli"}, outputs={"out": "prepared"}),
    Function("panel_run", "panel run", {"PanelRun": "panel_run"}, outputs={"out": "panel"}),
    Function("panel_add", "panel add", {"PanelAddition": "panel_add"}),
    Function("panel_analyse", "panel analyse", {"PanelAnalysis": "panel_analysis"}),
    Function("panel_average", "panel average", {"PanelAverage": "panel_average"}, outputs={"out": "transfer.json"}),
    Function("eeg_erd", "eeg erd", {"EegErd": "eeg_erd"}),
    Function("eeg_stats", "eeg stats", {"EegStats": "eeg_stats"}),
    Function("answers", "answers", {"Answers": "association"},
             notes="The columns `participant`, `task`, `trial`, `presented` and `answered` are needed; `set` and `offered` may be there. "
                   "A DataFrame is written to a file first: ``table.to_csv('answers.csv', index=False)``."),
    Function("campaign_design", "campaign design", {"CampaignDesign": "campaign_design"}),
    Function("twin_record", "twin record", {"TwinRecording": "twin_record"}, outputs={"out": "recording.parquet"}),
]

#: What every result has of its own; `warnings` are those of its document.
TAKEN = ["ended", "said", "files", "recording", "function", "report", "to_dict", "to_csv", "to_columns", "to_html", "captions", "plot"]
#: Arguments that no function has: results are no text.
NEVER = {"json", "date", "force"}
#: Those that have a meaning of their own beside a file: `rate` of an array is its sampling rate.
ARRAY_RATE = "The sampling rate of an array, in Hz. Of a file: "


#: The modules, with their functions.
MODULES = {
    "_look": ("Look at signals and surfaces.", ["info", "spectrum", "spectrogram", "noise", "roughness"]),
    "_touch": ("Strokes of a finger over a surface.", ["strokes", "cut", "compare"]),
    "_device": ("Know a device.", ["transfer", "characterise"]),
    "_panel": ("Transfer functions of several people.", ["panel_run", "panel_add", "panel_analyse", "panel_average"]),
    "_render": ("Drives that make a finger feel a texture.", ["manipulate", "render", "prepare"]),
    "_verify": ("How close a rendering comes.", ["play", "verify", "score"]),
    "_people": ("What a campaign can show, and what people answered.", ["campaign_design", "answers"]),
    "_eeg": ("EEG during touch.", ["eeg_erd", "eeg_stats"]),
    "_twin": ("Recordings of the digital twin.", ["twin_record"]),
}
WRITTEN = "Written by ``generate.py``; do not edit."


def main() -> int:
    from piezotact import _call

    texts = modules(_call.commands())
    if "--check" in sys.argv:
        stale = [name for name, text in texts.items() if (TARGET / name).read_text(encoding="utf-8") != text]
        for name in stale:
            print(f"{TARGET / name} is not up to date: run python {Path(__file__).name}")
        return len(stale)
    TARGET.mkdir(exist_ok=True)
    for name, text in texts.items():
        (TARGET / name).write_text(text, encoding="utf-8")
    return 0


def modules(commands: dict[str, Any]) -> dict[str, str]:
    """The texts of the modules by their files."""
    by_name = {function.name: function for function in FUNCTIONS}
    texts, imports, names = {}, [], []
    for name, (about, own) in MODULES.items():
        functions = [by_name[one] for one in own]
        texts[f"{name}.py"] = module(about, functions, commands)
        found = sorted([*own, *(result for function in functions for result in function.results)])
        imports.append(f"from .{name} import {', '.join(found)}")
        names += found
    listed = "".join(f'    "{name}",\n' for name in sorted(names))
    texts["__init__.py"] = (
        f'"""The functions of the commands, and their results. {WRITTEN}"""\n\n'
        + "\n".join(sorted(imports))
        + f"\n\n__all__ = [\n{listed}]\n"
    )
    return texts


def module(about: str, functions: list[Function], commands: dict[str, Any]) -> str:
    """The text of a module."""
    classes = {name: result_class(name, schema, one) for one in functions for name, schema in one.results.items()}
    body = "\n\n\n".join([*classes.values(), *(function_text(one, commands[one.command]) for one in functions)])

    def used(names: str) -> str:
        return ", ".join(name for name in names.split() if re.search(rf"\b{name}\b", body))

    def imported(module: str, names: str) -> list[str]:
        return [f"from {module} import {used(names)}"] if used(names) else []

    imports = ["from __future__ import annotations", ""]
    imports += imported("collections.abc", "Sequence") + imported("typing", "Any ClassVar Literal") + [""]
    if "np." in body:
        imports += ["import numpy as np", "import numpy.typing as npt", ""]
    imports += [f"from .._call import {used('called_for run')}", *imported(".._recording", "Data Path Text Unit"), *imported(".._results", "Record Result")]
    return f'"""{about} {WRITTEN}"""\n\n' + "\n".join(imports) + "\n\n\n" + body + "\n"


# Results -------------------------------------------------------------------------------------------------------------


def result_class(name: str, schema_name: str, function: Function) -> str:
    """A class whose attributes are the fields of a document."""
    schema = json.loads((SCHEMAS / f"{schema_name}.json").read_text(encoding="utf-8"))
    about = one_line(schema.get("description", "")) or f"Result of `{function.name}`."
    lines = [f"class {name}(Result):", *docstring([about, "", *shown_fields(schema)], 4), "", f'    SCHEMA: ClassVar[str] = "{schema_name}"']
    if function.figure > 1:
        lines.append(f"    FIGURE: ClassVar[int] = {function.figure}")
    fields = schema.get("properties", {})
    for key in attributes(schema):
        text = one_line(fields[key].get("description", ""))
        kind = python_type(fields[key], schema)
        kind = without_none(kind) if key in function.fixed else kind
        optional = "" if key in [*schema.get("required", []), *function.fixed] or kind == "Any" or "None" in kind else " | None"
        for line in textwrap.wrap(text, WIDTH - 7):
            lines.append(f"    #: {line}")
        lines.append(f"    {attribute(key)}: {kind}{optional}")
    return "\n".join(lines)


def attributes(schema: dict[str, Any]) -> list[str]:
    """The fields of a document that are attributes of their own."""
    return [key for key in sorted(schema.get("properties", {})) if key not in {"warnings", "schema", "invocation", "out"} and not keyword.iskeyword(key)]


def attribute(key: str) -> str:
    """The attribute that a field is; a result has some names of its own."""
    return f"{key}_" if key in TAKEN else key


def shown_fields(schema: dict[str, Any]) -> list[str]:
    """The names of the attributes; of a document that has several forms they are not known before."""
    names = [attribute(key) for key in attributes(schema)]
    listed = ", ".join(f"`{name}`" for name in names) if names != ["version"] else "``dir(found)`` lists them"
    return [f"Attributes: {listed}.", "``found.to_dict()`` is the document."]


def python_type(node: Any, schema: dict[str, Any]) -> str:
    """The type of an attribute, as `piezotact._results.shown` makes it."""
    if not isinstance(node, dict):
        return "Any"
    if "$ref" in node:
        return python_type(schema["$defs"][node["$ref"].rsplit("/", 1)[1]], schema)
    kinds = node.get("type")
    if isinstance(kinds, list):
        others = [kind for kind in kinds if kind != "null"]
        if len(others) != 1:
            return "Any"
        return without_none(python_type({**node, "type": others[0]}, schema)) + " | None"
    if "anyOf" in node and len(node["anyOf"]) == 2 and {"type": "null"} in node["anyOf"]:
        other = next(one for one in node["anyOf"] if one != {"type": "null"})
        found = python_type(other, schema)
        return found if found == "Any" else without_none(found) + " | None"
    if "const" in node:
        return type(node["const"]).__name__
    if kinds == "array":
        inner = python_type(node.get("items", {}), schema)
        if inner in {"float", "int", "float | None"} and "prefixItems" not in node:
            # A row of one number or none is an array too, but an empty one is a list.
            return "npt.NDArray[np.float64]" if inner != "int" else "npt.NDArray[np.int64]"
        return "Any" if inner == "Any" or "NDArray" in inner or "prefixItems" in node else f"list[{inner}]"
    simple = {"number": "float", "integer": "int", "string": "str", "boolean": "bool", "object": "Record"}
    return simple.get(kinds, "Any") if isinstance(kinds, str) else "Any"


def without_none(kind: str) -> str:
    return kind.removesuffix(" | None")


# Functions -----------------------------------------------------------------------------------------------------------


def function_text(function: Function, described: dict[str, Any]) -> str:
    arguments = [
        argument
        for argument in described["arguments"]
        if argument["name"] not in NEVER and argument["name"] not in function.without and not argument["is_operation"]
    ]
    operations = [argument for argument in described["arguments"] if argument["is_operation"]]
    required = [one for one in arguments if is_required(one, function)]
    optional = [one for one in arguments if not is_required(one, function)]
    signature = [f"    {called(one)}: {type_of(one, function)}," for one in required]
    if operations:
        signature.append("    operations: Sequence[str | tuple[str, Path | Text]],")
    signature.append("    *,")
    if function.data:
        if all(one["name"] != "rate" for one in optional):
            signature.append("    rate: float | None = None,")
        signature.append("    unit: Unit = None,")
    signature += [f"    {called(one)}: {type_of(one, function)}{default_of(one)}," for one in optional]
    signature += ["    date: str | None = None,", "    force: bool = False,"]
    returns = " | ".join(function.results)
    kind = next(iter(function.results)) if len(function.results) == 1 else f"({', '.join(function.results)})"
    more = ""
    if function.data:
        more += f", data={function.data!r}"
    if function.outputs:
        called_for = f"called_for({{!r}}, {', '.join(function.several)})" if function.several else "{!r}"
        more += f", outputs={{{', '.join(f'{name!r}: {called_for.format(file)}' for name, file in function.outputs.items())}}}"
    given = "locals()" if not function.fixed else "{**locals(), " + ", ".join(f'"{flag}": True' for flag in function.fixed) + "}"
    body = f'    return run({kind}, "{function.command}", {given}{more})'.replace("'", '"')
    if len(function.results) > 1:
        body = body + "  # type: ignore[return-value]"
    text = [
        f"def {function.name}(",
        *signature,
        f") -> {returns}:",
        *docstring(doc(function, described, required, optional, operations), 4),
        body,
    ]
    return "\n".join(text)


def is_required(argument: dict[str, Any], function: Function) -> bool:
    return bool(argument["is_required"]) and argument["name"] not in function.outputs


def called(argument: dict[str, Any]) -> str:
    name: str = argument["name"].replace("-", "_")
    return f"{name}_" if keyword.iskeyword(name) else name


def type_of(argument: dict[str, Any], function: Function) -> str:
    if argument["kind"] == "flag":
        return "bool"
    if argument["name"] in function.data:
        one = "Data"
    elif argument["choices"]:
        one = "Literal[" + ", ".join(f'"{choice}"' for choice in argument["choices"]) + "]"
    else:
        one = "str" if is_name(argument) else {"path": "Path", "number": "float", "integer": "int", "text": "Text"}[argument["kind"]]
    if argument["is_several"]:
        one = f"{one} | Sequence[{one}]"
    return one


def is_name(argument: dict[str, Any]) -> bool:
    """Whether it is the name of a channel, which a number is not."""
    return argument["kind"] == "text" and (argument["value"] or "").endswith("CHANNEL")


def default_of(argument: dict[str, Any]) -> str:
    return " = False" if argument["kind"] == "flag" else " | None = None"


def doc(
    function: Function,
    described: dict[str, Any],
    required: list[dict[str, Any]],
    optional: list[dict[str, Any]],
    operations: list[dict[str, Any]],
) -> list[str]:
    lines = [in_python(function.about or described["about"], described), "", "Parameters", "----------"]
    has_rate = any(one["name"] == "rate" for one in optional)
    for one in required:
        lines += parameter(one, function, described)
    if operations:
        lines += ["operations : list of str or (str, value)", "    What is done, in this order:"]
        for one in operations:
            value = f" ({one['value']})" if one["value"] and one["kind"] != "flag" else ""
            lines.append(f"    ``{called(one)}``{value}: {in_python(one['help'], described)}")
    if function.data:
        if not has_rate:
            lines += ["rate : float, optional", "    The sampling rate of an array, in Hz."]
        lines += [
            "unit : str or dict of str, optional",
            '    The unit of an array, or of each channel by its name: ``"m/s2"``, ``"g"``, ``"N"``; ``"1"`` relative to full scale.',
        ]
    for one in optional:
        lines += parameter(one, function, described)
    lines += [
        "date : str, optional",
        "    The date that reports and documents carry, in UTC, such as 2026-03-01T10:22:33Z; default: now.",
        "force : bool, optional",
        "    Replaces existing files that the command did not write before.",
    ]
    lines += ["", "Returns", "-------", " or ".join(function.results)]
    lines += ["    The document that the command prints with ``--json``, with its report."]
    lines += ["", "Raises", "------", "Error", "    What was expected and what was found, in the sentence of the command."]
    lines += ["", "Warns", "-----", "Warning", "    What a person should know before relying on the result."]
    schemas = ", ".join(f"``docs/schemas/{schema}.json``" for schema in function.results.values())
    lines += ["", "Notes", "-----", *([function.notes, ""] if function.notes else []), f"Source: ``piezotact {function.command}``, {schemas}."]
    return lines


def parameter(argument: dict[str, Any], function: Function, described: dict[str, Any]) -> list[str]:
    name = argument["name"]
    kind = {"flag": "bool", "path": "path", "number": "float", "integer": "int", "text": "str" if is_name(argument) else "str or number"}[argument["kind"]]
    if name in function.data:
        kind = "path, Recording, array_like or dict of array_like"
    elif argument["choices"]:
        kind = "{" + ", ".join(repr(choice) for choice in argument["choices"]) + "}"
    if argument["is_several"]:
        kind += ", or a list"
    if name in function.outputs:
        kind += ", optional"
    elif not argument["is_required"]:
        kind += ", optional"
    text = in_python(argument["help"], described)
    if name == "rate" and function.data:
        text = ARRAY_RATE + text[:1].lower() + text[1:]
    if argument["default"] is not None:
        text = f"{text.rstrip('.')}. Default: {argument['default']}."
    if name in function.outputs:
        kind_of = "file, or a folder for several" if function.several else "file" if "." in function.outputs[name] else "folder"
        text = f"{text.rstrip('.')}. Default: a temporary {kind_of}, which is removed with the result."
    return [f"{called(argument)} : {kind}", *(f"    {line}" for line in text.split("\n"))]


def in_python(text: str, described: dict[str, Any]) -> str:
    """Help in the words of Python: options are arguments."""
    known = {one["option"]: called(one) for one in described["arguments"] if one["option"]}

    def argument(found: re.Match[str]) -> str:
        return f"`{known.get(found[1], found[1].replace('-', '_'))}`"

    text = re.sub(r"--([a-z][a-z-]*[a-z])", argument, text)
    if text and text[-1] not in ".:;":
        text += "."
    return text


def one_line(text: str) -> str:
    return " ".join(text.split())


def docstring(lines: list[str], indent: int) -> list[str]:
    space = " " * indent
    wrapped: list[str] = []
    for line in lines:
        inner = len(line) - len(line.lstrip())
        wrapped += textwrap.wrap(
            line, WIDTH - indent, subsequent_indent=" " * inner, break_long_words=False, break_on_hyphens=False
        ) or [""]
    text = "\n".join(space + line if line else "" for line in wrapped).strip()
    raw = "r" if "\\" in text else ""
    end = "" if len(wrapped) == 1 else "\n" + space
    return f'{space}{raw}"""{text}{end}"""'.split("\n")


if __name__ == "__main__":
    sys.exit(main())
