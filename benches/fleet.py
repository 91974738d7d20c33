"""Many machines: simulated by the core with seeds, stored as Parquet, judged by every engine; a figure each line.

    python fleet.py simulate COUNT FILE.parquet       # machines with one visit each, 250 in a row group
    python fleet.py batch|process|numpy FILE [COUNT]  # nonius batch, a process each, NumPy alone
    python fleet.py pandas|dask|spark FILE [--workers N] [--kill]

The program is $NONIUS (target/release/nonius). `--kill` ends a worker in the middle. What the engines say is compared with `batch`.
"""

import argparse
import json
import os
import signal
import subprocess
import tempfile
import threading
import time
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

PROGRAM = os.environ.get("NONIUS", str(Path(__file__).parents[1] / "target/release/nonius"))
NODES, PART, LIMIT_UM = 31, 250, 60.0
TRAVEL_MM = {"x": (0.0, 900.0), "y": (0.0, 720.0), "z": (-720.0, 0.0)}
REFERENCE_MM = {"x": 0.0, "y": 0.0, "z": 0.0}
JOB = {
    "schema": 1,
    "machine": {"name": "fleet", "chain": "wXYZt", "axes": {a: {"travel_mm": list(TRAVEL_MM[a]), "reference_mm": 0.0} for a in TRAVEL_MM}},
    "measurement": {"errors": "errors.csv", "date": "2026-11-20", "active_while_measuring": "none"},
    "compensation": {"controller": "siemens-840d-sl", "axes": {a: {"spacing_mm": s} for a, s in zip("xyz", (30.0, 24.0, 24.0))}},
    "acceptance": {"max_deviation_um": 10.0},
}
COLUMNS = ["axis", "position_mm", "ex_um", "ey_um", "ez_um"]


def truth(seed):
    """Nine smooth curves in µm, zero at the reference: slope, bow and wave of random size."""
    random = np.random.default_rng(seed)
    table = {name: [] for name in COLUMNS}
    for axis, (low, high) in TRAVEL_MM.items():
        mm = np.linspace(low, high, NODES)
        u = (mm - low) / (high - low)
        at = int(np.argmin(abs(mm - REFERENCE_MM[axis])))
        table["axis"] += [axis] * NODES
        table["position_mm"] += mm.tolist()
        for name, (a, b, c) in zip(COLUMNS[2:], random.normal(0, [8, 3, 1], (3, 3))):
            curve = a * u + b * np.sin(3 * u + c)
            table[name] += (curve - curve[at]).tolist()
    return table


def simulate(options):
    """What single-axis measurements of each machine show, noise 0.3 µm: the core's rehearsal with the seed of the machine."""
    words = ["--machine", "truth.csv", "--errors", "--without-tables", "--noise-um", "0.3", "-o", "shown.csv", "--seed"]
    with open(options.file + ".questions", "w") as file:
        for seed in range(options.count):
            # A term of some machines is small by chance; that it was not typed in mm is stated by its noise.
            job = JOB | {"measurement": JOB["measurement"] | {"errors": "truth.csv", "uncertainty": {"noise_um": 0.001}}}
            question = {"command": "simulate", "job": job, "options": [*words, str(seed)], "files": {"truth.csv": truth(seed)}}
            file.write(json.dumps(question) + "\n")
    subprocess.run([PROGRAM, "batch", file.name, "-o", options.file + ".answers"], check=True)
    writer, rows = None, []
    with open(options.file + ".answers") as answers:
        for seed, line in enumerate(answers):
            own = json.loads(line)["files"]["shown.csv"].splitlines()
            remarks = [row[1:].strip() for row in own if row.startswith("#")]
            lines = [row.split(",") for row in own if not row.startswith("#")]
            table = dict(zip(lines[0], zip(*lines[1:])))
            numbers = {name: [float(cell) for cell in cells] for name, cells in table.items() if name != "axis"}
            rows.append({"machine": f"m{seed:07}", "date": "2026-11-20", "remarks": remarks, "axis": list(table["axis"]), **numbers})
            if len(rows) == PART or seed + 1 == options.count:
                group = pa.Table.from_pylist(rows)
                writer = writer or pq.ParquetWriter(options.file, group.schema)
                writer.write_table(group)
                rows = []
    writer.close()
    for end in (".questions", ".answers"):
        os.remove(options.file + end)


def questions(frame):
    """The question of each machine to `nonius batch`."""
    for row in frame.to_dict("records"):
        job = JOB | {"measurement": JOB["measurement"] | {"date": row["date"]}}
        table = {name: list(row[name]) for name in row if name not in ("machine", "date")}
        yield json.dumps({"id": row["machine"], "command": "generate", "job": job, "options": ["--dry-run"], "files": {"errors.csv": table}})


def told(engine, count, began, more=""):
    seconds = time.perf_counter() - began
    print(f"{engine}: {count} machines, {seconds:.1f} s, {count / seconds:.0f} machines/s {more}".rstrip(), flush=True)


def batch(frame, options):
    """`nonius batch`; with --kill it is killed in the middle and resumed: the same bytes."""
    with tempfile.TemporaryDirectory() as folder:
        asked, answers = f"{folder}/questions", f"{folder}/answers"
        Path(asked).write_text("".join(line + "\n" for line in questions(frame)))
        began = time.perf_counter()
        subprocess.run([PROGRAM, "batch", asked, "-o", answers], check=False)
        seconds = time.perf_counter() - began
        told("batch", len(frame), began)
        if options.kill:
            work = subprocess.Popen([PROGRAM, "batch", asked, "-o", answers + "2"])
            time.sleep(seconds / 2)
            work.send_signal(signal.SIGKILL)
            work.wait()
            os.truncate(answers + "2", os.path.getsize(answers + "2") - 9)  # as a killed write would leave it
            done = Path(answers + "2").read_bytes().count(b"\n")
            subprocess.run([PROGRAM, "batch", asked, "-o", answers + "2", "--resume"], check=False)
            same = Path(answers).read_bytes() == Path(answers + "2").read_bytes()
            print(f"killed after {done} answers and resumed: same bytes {same}")
        documents = (json.loads(line) for line in open(answers))
        return {answer["id"]: (answer["document"]["verdict"], answer["document"]["terms"]["EXX"]["forecast_um"]) for answer in documents}


def process(frame, options):
    """A process each."""
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        for line in questions(frame):
            question = json.loads(line)
            columns = question["files"]["errors.csv"]
            table = "".join(f"# {line}\n" for line in columns.pop("remarks"))
            table += "".join(",".join(map(str, row)) + "\n" for row in [columns, *zip(*columns.values())])
            Path(folder, "errors.csv").write_text(table)
            Path(folder, "job.toml").write_text(toml(question["job"]))
            subprocess.run([PROGRAM, "generate", f"{folder}/job.toml", "--dry-run", "--format", "json"], stdout=subprocess.DEVNULL, check=False)
        told("a process each, one after the other", len(frame), began)


def toml(section, path=""):
    """A job as TOML."""
    values = "".join(f"{key} = {json.dumps(value)}\n" for key, value in section.items() if not isinstance(value, dict))
    parts = [(f"{path}{key}", value) for key, value in section.items() if isinstance(value, dict)]
    return values + "".join(f"[{name}]\n{toml(value, name + '.')}" for name, value in parts)


def numpy(frame, options):
    """The core of the work by NumPy alone, in one process: tables in counts of a nanometre, what they leave between and at the
    measured places, a squareness, diagonals; no U, no verdict, no text, no documents, no checks, no emulator."""
    began = time.perf_counter()
    for row in frame.to_dict("records"):
        axis, mm = np.array(row["axis"]), np.array(row["position_mm"])
        curves = {}
        for name, (low, high) in TRAVEL_MM.items():
            own = axis == name
            grid = np.linspace(low, high, 31)
            for of in COLUMNS[2:]:
                um = np.array(row[of])[own]
                um = um - np.interp(REFERENCE_MM[name], mm[own], um)
                table = np.round(np.interp(grid, mm[own], um), 3)
                places = np.union1d(mm[own], grid)
                left = np.interp(places, mm[own], um) - np.interp(places, grid, table)
                curves[name, of] = (np.abs(um).max(), np.abs(left).max(), (um[-1] - um[0]) / (high - low), places, left)
        squareness = [curves["x", "ey_um"][2] + curves["y", "ex_um"][2]]
        for signs in ((1, 1, 1), (-1, 1, 1), (1, -1, 1), (1, 1, -1)):
            t, along = np.linspace(0, 1, 200), 0.0
            for sign, (name, (low, high)) in zip(signs, TRAVEL_MM.items()):
                at = low + (high - low) * (t if sign > 0 else 1 - t)
                along = along + sum(s * np.interp(at, *curves[name, of][3:]) for s, of in zip(signs, COLUMNS[2:]))
            squareness.append(np.ptp(along))
    told("NumPy alone, one process", len(frame), began)


def check(results, expected):
    """Nothing lost, nothing twice, and what `batch` says."""
    assert sorted(results["machine"]) == sorted(expected), "lost, or twice"
    found = results.set_index("machine")[["verdict", "EXX_forecast_um"]]
    wrong = [name for name, (verdict, um) in expected.items() if (found.at[name, "verdict"], found.at[name, "EXX_forecast_um"]) != (verdict, um)]
    assert not wrong, f"not as batch says: {wrong[:3]}"
    print("as batch says; nothing lost, nothing twice", flush=True)


def pandas(frame, options):
    from nonius import fleet

    began = time.perf_counter()
    results = fleet.judge(frame, JOB, LIMIT_UM)
    told("pandas", len(frame), began)
    return results


def dask(frame, options):
    """Workers and scheduler are processes of their own, reached by the scheduler's address."""
    import dask as settings
    import dask.dataframe as frames
    from distributed import Client
    from nonius import fleet

    settings.config.set({"dataframe.convert-string": False})
    address = "tcp://127.0.0.1:8790"
    scheduler = subprocess.Popen(["dask", "scheduler", "--port", "8790", "--no-dashboard", "--no-show"], stderr=subprocess.DEVNULL)
    own = ["dask", "worker", address, "--nthreads", "1", "--no-dashboard"]
    workers = [subprocess.Popen([*own, "--nanny", "--nworkers", str(options.workers)], stderr=subprocess.DEVNULL)]
    try:
        with Client(address) as client:
            client.wait_for_workers(options.workers)
            read = frames.read_parquet(options.file, split_row_groups=max(1, options.part // PART))
            client.run(lambda: __import__("nonius.fleet"))
            began = time.perf_counter()
            work = client.compute(read.map_partitions(fleet.judge, JOB, limit_um=LIMIT_UM, meta=fleet.META))
            if options.kill:
                threading.Thread(target=strike, args=(client, options)).start()
            results = work.result()
            told(f"Dask, {options.workers} workers, {read.npartitions} parts", len(results), began, "one killed" if options.kill else "")
            return results
    finally:
        for own in [*workers, scheduler]:
            own.terminate()


def strike(client, options):
    time.sleep(options.kill)
    victim = next(iter(client.run(os.getpid).values()))
    os.kill(victim, signal.SIGKILL)


def spark(frame, options):
    import sys

    from pyspark.sql import SparkSession

    from nonius import fleet

    os.environ["PYSPARK_PYTHON"] = sys.executable
    # A task may fail four times: plain local[N] ends at the first failure.
    made = SparkSession.builder.master(f"local[{options.workers},4]").config("spark.ui.enabled", "false")
    session = made.config("spark.sql.execution.arrow.pyspark.enabled", "true").config("spark.driver.memory", "2g").getOrCreate()
    session.sparkContext.setLogLevel("ERROR")
    read = session.read.parquet(options.file).repartition(max(2, len(frame) // options.part), "machine").sortWithinPartitions("machine", "date")
    read.limit(10).toPandas()
    began = time.perf_counter()
    if options.kill:
        threading.Thread(target=strike_spark, args=(options,)).start()
    results = read.mapInPandas(partial(fleet.judge_parts, job=JOB, limit_um=LIMIT_UM), fleet.SCHEMA).toPandas()
    told(f"Spark, {options.workers} cores", len(results), began, "one killed" if options.kill else "")
    session.stop()
    return results


def strike_spark(options):
    """Kills a Python worker of Spark: a child of its daemon."""
    time.sleep(options.kill)
    children = lambda pid: [int(own) for own in subprocess.run(["pgrep", "-P", str(pid)], capture_output=True, text=True).stdout.split()]
    workers = [own for java in children(os.getpid()) for daemon in children(java) for own in children(daemon)]
    os.kill(workers[0], signal.SIGKILL)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("engine", choices=["simulate", "batch", "process", "numpy", "pandas", "dask", "spark"])
    parser.add_argument("words", nargs="+", help="[COUNT] FILE")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--part", type=int, default=PART, help="machines in a partition")
    parser.add_argument("--kill", type=float, default=0.0, help="seconds after which a worker is killed; of batch: 1")
    options = parser.parse_args()
    options.file = next(word for word in options.words if not word.isdigit())
    options.count = next((int(word) for word in options.words if word.isdigit()), None)
    if options.engine == "simulate":
        return simulate(options)
    frame = pq.read_table(options.file).to_pandas()[: options.count]
    results = globals()[options.engine](frame, options)
    if isinstance(results, pd.DataFrame):
        options.kill = 0.0
        check(results, batch(frame, options))


if __name__ == "__main__":
    main()
