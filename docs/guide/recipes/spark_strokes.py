"""Cuts the recordings of a folder into strokes on Spark, and writes a table of their features.

    python spark_strokes.py FOLDER --out strokes.parquet
    python spark_strokes.py FOLDER --out strokes.parquet --master spark://HOST:7077

Without --master, two threads of this computer do it; without FOLDER, recordings of the digital twin are made first. The workers
of a cluster see the folder by the same path, and have the same version of piezotact. Spark 4 and Java 17 are needed.
"""

import argparse
import os
import sys
import tempfile
from pathlib import Path

import piezotact as pz
import pyarrow as pa
import pyarrow.parquet as pq
from pyspark.sql import SparkSession
from pyspark.sql.pandas.types import from_arrow_schema

#: Options of strokes for all recordings, such as {"load": 0.2, "touch": "active"}.
OPTIONS: dict = {}


def twin_recordings(folder):
    for sample in ["S1", "S3", "S8", "S13"]:
        pz.twin_record(
            bench="acttouch", sample=sample, participant=4, speed="30mm/s", strokes=3, seed=1, out=folder / f"{sample}.parquet"
        )
    return folder


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?")
    parser.add_argument("--pattern", default="*.parquet", help="which files of the folder are recordings")
    parser.add_argument("--out", type=Path, default=Path("strokes.parquet"))
    parser.add_argument("--master", default="local[2]", help="the address of a cluster of Spark")
    parser.add_argument("--partitions", type=int, default=8)
    args = parser.parse_args()

    # Without it, the workers start whatever python3 is.
    os.environ.setdefault("PYSPARK_PYTHON", sys.executable)
    schema = pz.batch_schema(pa.schema({"path": pa.string()}))

    def strokes(parts):
        for rows in parts:
            yield pz.batch(rows, schema=schema, **OPTIONS)

    with tempfile.TemporaryDirectory() as made:
        folder = args.folder or twin_recordings(Path(made))
        paths = [str(path.resolve()) for path in sorted(folder.glob(args.pattern)) if path.resolve() != args.out.resolve()]
        sessions = SparkSession.builder.master(args.master).appName("strokes").config("spark.ui.enabled", "false")
        with sessions.getOrCreate() as spark:
            # What is made of a list in parts keeps the order of the list.
            parts = spark.sparkContext.parallelize([(path,) for path in paths], args.partitions)
            recordings = spark.createDataFrame(parts, "path string")
            table = recordings.mapInArrow(strokes, from_arrow_schema(schema)).toArrow()

    table = table.cast(schema).replace_schema_metadata(schema.metadata)
    pq.write_table(table, args.out)
    failed = table.num_rows - table["error"].null_count
    print(f"{table.num_rows - failed} strokes of {len(paths)} recordings, {failed} of them without strokes: {args.out}")


if __name__ == "__main__":
    main()
