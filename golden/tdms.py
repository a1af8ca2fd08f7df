"""TDMS files for piezotact-dataset, with what npTDMS 1.13.0 (NumPy 2.4.6) reads of them.

    python3 golden/tdms.py

Writes two small files, and the values that the Rust test `tdms.rs` compares: `scales.tdms` by the writer of npTDMS, with chains of
scales; `daqmx.tdms` of bytes made here, as npTDMS writes no DAQmx raw data: two cards, 16 and 32 bits, big-endian, two chunks, a
channel of two scalers that a scale subtracts.
"""

import struct
from pathlib import Path

import numpy as np
from nptdms import ChannelObject, TdmsFile, TdmsWriter

folder = Path(__file__).parent.parent / "crates/piezotact-dataset/tests/golden"
k = np.arange(-4, 5, dtype=np.int16)
wave = {"wf_start_time": np.datetime64("2026-03-04T09:08:07.654321"), "wf_increment": 1e-3}
raw = 0xFFFFFFFF


def scales(*each):
    """Properties of a chain: a type, and its entries by name."""
    found = {"NI_Number_Of_Scales": np.uint32(len(each)), "NI_Scaling_Status": "unscaled"}
    for at, (kind, entries) in enumerate(each):
        found[f"NI_Scale[{at}]_Scale_Type"] = kind
        for name, value in entries.items():
            is_source = name.endswith(("Source", "Size", "Configuration"))
            found[f"NI_Scale[{at}]_{kind}_{name}"] = np.uint32(value) if is_source else float(value)
    return found


def listed(name, values):
    return {f"{name}_Size": len(values), **{f"{name}[{i}]": v for i, v in enumerate(values)}}


polynomial = ("Polynomial", {**listed("Coefficients", [0.5, 2, -0.25, 0.125]), "Input_Source": raw})
table = ("Table", {**listed("Pre_Scaled_Values", [4, 1, -3]), **listed("Scaled_Values", [40, 10, 2]), "Input_Source": 0})
linear = ("Linear", {"Slope": 3, "Y_Intercept": -1, "Input_Source": raw})
bridge = {"Poisson_Ratio": 0.3, "Gage_Resistance": 350, "Lead_Wire_Resistance": 2, "Initial_Bridge_Voltage": 0.25, "Gage_Factor": 2.1,
          "Bridge_Shunt_Calibration_Gain_Adjustment": 1.1, "Voltage_Excitation": 100, "Input_Source": raw}
bridges = {"full bridge 1": 10183, "full bridge 2": 10184, "full bridge 3": 10185, "half bridge 1": 10188, "half bridge 2": 10189, "quarter bridge": 10271}
with TdmsWriter(folder / "scales.tdms") as writer:
    chains = {
        "table of polynomial": scales(polynomial, table),
        "difference": scales(polynomial, linear, ("Subtract", {"Left_Operand_Input_Source": 0, "Right_Operand_Input_Source": 1})),
        "sum": scales(polynomial, linear, ("Add", {"Left_Operand_Input_Source": 0, "Right_Operand_Input_Source": 1})),
    }
    chains |= {name: scales(("Strain", {"Configuration": code, **bridge})) for name, code in bridges.items()}
    writer.write_segment([ChannelObject("scales", name, k, {**wave, **chain}) for name, chain in chains.items()])


def text(value):
    return struct.pack(">I", len(value)) + value.encode()


def properties(values):
    found = struct.pack(">I", len(values))
    for name, value in values.items():
        found += text(name)
        match value:
            case str():
                found += struct.pack(">I", 0x20) + text(value)
            case int():
                found += struct.pack(">II", 7, value)
            case float():
                found += struct.pack(">Id", 10, value)
    return found


def channel(name, scalers, values):
    """A DAQmx channel: the type, buffer, byte and number of each scaler; buffers of 4 and 8 bytes."""
    index = struct.pack(">IIIQI", 0x1269, 0xFFFFFFFF, 1, 3, len(scalers))
    for kind, buffer, first, number in scalers:
        index += struct.pack(">5I", kind, buffer, first, 0, number)
    index += struct.pack(">3I", 2, 4, 8)
    return text(f"/'card'/'{name}'") + index + properties(values)


i16, i32 = 3, 5
entry = "NI_Scale[%d]_%s"
one = {"wf_increment": 0.5, "unit_string": "mN", "NI_Number_Of_Scales": 2, entry % (1, "Scale_Type"): "Linear",
       entry % (1, "Linear_Slope"): 0.5, entry % (1, "Linear_Y_Intercept"): 1.0, entry % (1, "Linear_Input_Source"): 0}
two = {"wf_increment": 0.5, "unit_string": "V", "NI_Number_Of_Scales": 3, entry % (2, "Scale_Type"): "Subtract",
       entry % (2, "Subtract_Left_Operand_Input_Source"): 0, entry % (2, "Subtract_Right_Operand_Input_Source"): 1}
metadata = struct.pack(">I", 4) + text("/") + struct.pack(">II", 0xFFFFFFFF, 0)
metadata += channel("first", [(i16, 0, 0, 0)], one) + channel("second", [(i16, 0, 2, 0)], one)
metadata += channel("joined", [(i32, 1, 4, 0), (i32, 1, 0, 1)], two)
data = b""
for chunk in range(2):
    rows = range(3 * chunk, 3 * chunk + 3)
    data += b"".join(struct.pack(">hh", 10 * row, -7 * row) for row in rows)
    data += b"".join(struct.pack(">ii", 100_000 * row, row * row) for row in rows)
toc = 2 | 4 | 8 | 64 | 128
lead_in = b"TDSm" + struct.pack("<I", toc) + struct.pack(">IQQ", 4713, len(metadata) + len(data), len(metadata))
(folder / "daqmx.tdms").write_bytes(lead_in + metadata + data)

for name in ("scales.tdms", "daqmx.tdms"):
    for group in TdmsFile.read(folder / name).groups():
        for of in group.channels():
            print(name, of.name, of[:].tolist())
