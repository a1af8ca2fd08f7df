"""Cuts the recordings of a folder into strokes on Dask, and writes a table of their features.

    python dask_strokes.py FOLDER --out strokes.parquet
    python dask_strokes.py FOLDER --out strokes.parquet --cluster tcp://HOST:8786

Without --cluster, processes of this computer do it; without FOLDER, recordings of the digital twin are made first. The workers
of a cluster see the folder by the same path, and have the same version of piezotact.
"""

import argparse
import tempfile
from pathlib import Path

import dask.dataframe as dd
import pandas as pd
import piezotact as pz
import pyarrow as pa
import pyarrow.parquet as pq
from dask.distributed import Client, LocalCluster

#: Options of strokes for all recordings, such as {"load": 0.2, "touch": "active"}.
OPTIONS: dict = {}


def strokes(part, columns, schema):
    """The strokes of one part of the table of recordings."""
    rows = pa.RecordBatch.from_pandas(part, schema=columns, preserve_index=False)
    return pz.batch(rows, schema=schema, **OPTIONS).to_pandas(types_mapper=pd.ArrowDtype)


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
    parser.add_argument("--cluster", help="the address of a scheduler of Dask")
    parser.add_argument("--partitions", type=int, default=8)
    args = parser.parse_args()

    with tempfile.TemporaryDirectory() as made:
        folder = args.folder or twin_recordings(Path(made))
        paths = [str(path.resolve()) for path in sorted(folder.glob(args.pattern)) if path.resolve() != args.out.resolve()]
        recordings = pd.DataFrame({"path": pd.array(paths, dtype=pd.ArrowDtype(pa.string()))})
        columns = pa.schema({"path": pa.string()})
        schema = pz.batch_schema(columns)
        empty = schema.empty_table().to_pandas(types_mapper=pd.ArrowDtype)

        # One thread in each process: a recording is analysed on several threads already.
        cluster = args.cluster or LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
        with Client(cluster):
            parts = dd.from_pandas(recordings, npartitions=args.partitions, sort=False)
            found = parts.map_partitions(strokes, columns, schema, meta=empty).compute()
        if not args.cluster:
            cluster.close()

    table = pa.Table.from_pandas(found, schema=schema, preserve_index=False).replace_schema_metadata(schema.metadata)
    pq.write_table(table, args.out)
    failed = table.num_rows - table["error"].null_count
    print(f"{table.num_rows - failed} strokes of {len(paths)} recordings, {failed} of them without strokes: {args.out}")


if __name__ == "__main__":
    main()
