"""Parquet files as Polars 2.1.0 and pyarrow 26.0.1 write them, and what NumPy 2.4.6 fits to time columns.

    python3 golden/tables.py

Sample k is sin(0.37 k), k from 0 to 39; the clock has 80 Hz.
"""

from datetime import datetime, timedelta, timezone
from decimal import Decimal
from pathlib import Path

import numpy as np
import polars as pl
import pyarrow as pa
import pyarrow.parquet as pq

folder = Path(__file__).parent.parent / "crates/piezotact-dataset/tests/golden/tables"
folder.mkdir(exist_ok=True)
k = np.arange(40)
one = np.sin(0.37 * k)
start = datetime(2024, 3, 1, 10, 22, 33, 250_000, tzinfo=timezone.utc)
moments = [start + timedelta(microseconds=12_500 * int(i)) for i in k]

# Polars' default: zstd.
pl.DataFrame({"time (s)": k / 80, "acc (g)": one}).write_parquet(folder / "zstd.parquet")

stamped = pa.table(
    {
        "when": pa.array(moments, pa.timestamp("ns", "UTC")),
        "fz (N)": pa.array([Decimal(int(i)) / 1000 - 1 for i in k], pa.decimal128(12, 3)),
    }
)
pq.write_table(stamped, folder / "moments.parquet", compression="gzip", data_page_version="2.0")
text = pa.table({"clock": [f"{m:%Y-%m-%d %H:%M:%S.%f}" for m in moments], "x": one})
pq.write_table(text, folder / "text.parquet", compression="zstd", data_page_version="2.0")
pq.write_table(pa.table({"x": one}), folder / "brotli.parquet", compression="brotli")

# A clock of 100 Hz that slows down by 0.9 % in 60 s (src/time_column/tests.rs).
k = np.arange(6000.0)
t = 0.01 * k * (1 + 0.0045 * k / 6000)
period, origin = np.polyfit(k, t, 1)
residual = np.abs(t - origin - period * k).max()
print(f"drift: {1 / period:.4f} Hz, {residual / period:.4f} samples, {1e3 * residual:.3f} ms")
