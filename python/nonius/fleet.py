"""Many machines, many visits: verdicts, drift and dates of service, on pandas, Dask or Spark.

A frame has a row each visit: `machine`, `date`, and the columns of its table as lists (axis, position_mm, ex_um … of
errors; diagonal, node, moved, deviation_um … of readings); `packed` makes it of a frame with a row each value, e.g. of
a CSV. `judge` answers with a row each visit (`COLUMNS`), in the order machine, date.

    results = fleet.judge(frame, job, limit_um=30)                                              # pandas
    results = frame.map_partitions(fleet.judge, job, limit_um=30, meta=fleet.META)              # Dask
    results = frame.repartition("machine").sortWithinPartitions("machine", "date") \\
                   .mapInPandas(partial(fleet.judge_parts, job=job, limit_um=30), fleet.SCHEMA)  # Spark

All visits of a machine have to lie in one partition (Dask: `frame.shuffle("machine")`, or partitions written so).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, Union

import numpy as np
import pandas as pd

from . import _core
from ._answers import Problem
from ._page import report
from ._visit import Visit

__all__ = ["COLUMNS", "META", "SCHEMA", "judge", "judge_parts", "packed", "report"]

TERMS = ("EXX", "EYX", "EZX", "EXY", "EYY", "EZY", "EXZ", "EYZ", "EZZ")
PLANES = ("xy", "xz", "yz")
DATES = ("date", "due", "due_earliest", "due_latest")
WORDS = ("machine", "verdict", "problem")
#: A job for all machines, or what gives that of a machine by its name.
JobOf = Union[Mapping[str, Any], Callable[[str], Mapping[str, Any]]]

_OF_VISIT = (
    "at_most_um",  # of all terms after the tables, 95 %
    "va_um",  # volumetric accuracy as found
    *(f"{term}_{what}_um" for term in TERMS for what in ("found", "u95", "forecast")),
    *(f"{plane}_{what}_um_per_m" for plane in PLANES for what in ("squareness", "u95")),
)
_OF_MACHINE = (
    "va_drift_um",  # since the visit before
    *(f"{term}_drift{what}_um" for term in TERMS for what in ("", "_u95")),
    *(f"{plane}_drift{what}_um_per_m" for plane in PLANES for what in ("", "_u95")),
)
#: The columns of a result. U (u95) of a drift takes the two visits as independent of each other; NaN = not known.
COLUMNS = ("machine", "date", "verdict", *_OF_VISIT, *_OF_MACHINE, "due", "due_earliest", "due_latest", "problem")
_TYPES = {name: "object" if name in WORDS else "datetime64[us]" if name in DATES else "float64" for name in COLUMNS}
#: A result without rows, for Dask.
META = pd.DataFrame({name: pd.Series(dtype=kind) for name, kind in _TYPES.items()})
#: The columns of a result, for Spark.
SCHEMA = ", ".join(
    f"{name} {'string' if name in WORDS else 'timestamp_ntz' if name in DATES else 'double'}" for name in COLUMNS
)
#: Nodes of the volume at which VA is found, as `assess --grid` takes them; "nodes" = those of the table, four times as long.
GRID = "11,11,11"
#: Days ahead in which a trend is followed.
HORIZON_DAYS = 3650


def packed(values: pd.DataFrame) -> pd.DataFrame:
    """A row each visit, of a frame with a row each value: its columns `machine` and `date`, and those of a table."""
    names = [name for name in values.columns if name not in ("machine", "date")]
    return values.groupby(["machine", "date"], sort=True)[names].agg(list).reset_index()


def judge(frame: pd.DataFrame, job: JobOf, limit_um: float | None = None, grid: str = GRID) -> pd.DataFrame:
    """The results of all visits of some machines.

    `limit_um` = VA at which a machine is due for service: `due` is the day on which the straight line through its VA
    (three visits or more) reaches it, `due_earliest` and `due_latest` are those of the band in which the line lies with
    95 %; empty = not within ten years. `grid`: nodes of the volume for VA. A visit that cannot be judged has its reason in `problem`.
    """
    frame = frame.assign(date=pd.to_datetime(frame["date"]).astype(_TYPES["date"])).sort_values(["machine", "date"])
    if frame.empty:
        return META.copy()
    names = [name for name in frame.columns if name not in ("machine", "date")]
    visits = pd.DataFrame([_visit(row, names, job, grid) for row in frame.to_dict("records")])
    machines = [_machine(own, limit_um) for _, own in visits.groupby("machine", sort=False)]
    return pd.concat(machines).reindex(columns=list(COLUMNS)).astype(_TYPES).reset_index(drop=True)


def judge_parts(
    frames: Iterable[pd.DataFrame], job: JobOf, limit_um: float | None = None, grid: str = GRID
) -> Iterator[pd.DataFrame]:
    """The same of frames that come one after the other, sorted by machine: a machine may lie in several."""
    rest = pd.DataFrame()
    for frame in frames:
        rest = pd.concat([rest, frame], ignore_index=True)
        is_last = rest["machine"] == rest["machine"].iloc[-1] if len(rest) else pd.Series(dtype=bool)
        if not is_last.all():
            yield judge(rest[~is_last], job, limit_um, grid)
            rest = rest[is_last]
    if len(rest):
        yield judge(rest, job, limit_um, grid)


def _visit(row: dict[str, Any], names: list[str], job: JobOf, grid: str) -> dict[str, Any]:
    """One visit by itself."""
    machine, date = str(row["machine"]), row["date"]
    own = dict(job(machine) if callable(job) else job)
    own["measurement"] = {**own.get("measurement", {}), "date": date.date().isoformat()}
    table = {name: row[name] for name in names if isinstance(row[name], (list, np.ndarray))}
    visit = Visit(own, **{"readings" if "diagonal" in table else "errors": table})
    result = {"machine": machine, "date": date, "verdict": "", "problem": ""}
    try:
        judged = visit.forecast()
        result["va_um"] = visit.assess("--grid", grid).va_um
    except Problem as problem:
        return result | {"problem": str(problem)}
    result |= {"verdict": judged.verdict, "at_most_um": judged.document["max_residual_at_most_um"]}
    for term, figures in judged.terms.items():
        kinds = {"found": "before_um", "u95": "expanded_um", "forecast": "forecast_um"}
        result |= {f"{term}_{kind}_um": figures[name] for kind, name in kinds.items()}
    for plane, figures in judged.squareness.items():
        kinds = {"squareness": "before_um_per_m", "u95": "expanded_um_per_m"}
        result |= {f"{plane}_{kind}_um_per_m": figures[name] for kind, name in kinds.items()}
    return result


def _machine(visits: pd.DataFrame, limit_um: float | None) -> pd.DataFrame:
    """The visits of one machine, with what follows from their order."""
    visits = visits.reindex(columns=[*WORDS, "date", *_OF_VISIT])
    visits = visits.astype({name: _TYPES[name] for name in _OF_VISIT})
    last = visits.ffill()  # of the last visit that could be judged
    drift = {"va_drift_um": visits["va_um"] - last["va_um"].shift()}
    found = [(term, f"{term}_found_um", f"{term}_u95_um", "um") for term in TERMS]
    squareness = [(plane, f"{plane}_squareness_um_per_m", f"{plane}_u95_um_per_m", "um_per_m") for plane in PLANES]
    for name, figure, u95, unit in found + squareness:
        drift[f"{name}_drift_{unit}"] = visits[figure] - last[figure].shift()
        drift[f"{name}_drift_u95_{unit}"] = np.hypot(visits[u95], last[u95].shift())
    visits = visits.assign(**drift)
    due = _due(visits["date"], visits["va_um"], limit_um)
    return visits.assign(**{name: [pd.NaT] * (len(visits) - 1) + [day] for name, day in due.items()})


def _due(dates: pd.Series, va_um: pd.Series, limit_um: float | None) -> dict[str, Any]:
    """When the straight line through VA reaches the limit, and the band of 95 % around it.

    Line y = ȳ + b·(t − t̄), band ± k·s·√(1/n + (t − t̄)²/Σ(t − t̄)²) with s² = Σ residual²/(n − 2); k: Student.
    """
    none = {"due": pd.NaT, "due_earliest": pd.NaT, "due_latest": pd.NaT}
    known = va_um.notna()
    days = ((dates[known] - dates.iloc[-1]) / pd.Timedelta(days=1)).to_numpy(dtype=float)
    values = va_um[known].to_numpy(dtype=float)
    if limit_um is None or len(days) < 3 or np.ptp(days) == 0:
        return none
    spread = days - days.mean()
    slope = (spread @ values) / (spread @ spread)
    residual = values - values.mean() - slope * spread
    s = np.sqrt((residual @ residual) / (len(days) - 2))
    ahead = np.arange(HORIZON_DAYS + 1.0) - days.mean()
    line = values.mean() + slope * ahead
    band = _core.coverage_factor(len(days) - 2.0) * s * np.sqrt(1 / len(days) + ahead**2 / (spread @ spread))
    reached = {"due": line, "due_earliest": line + band, "due_latest": line - band}
    first = {name: np.flatnonzero(curve >= limit_um) for name, curve in reached.items()}
    return none | {name: dates.iloc[-1] + pd.Timedelta(days=int(at[0])) for name, at in first.items() if len(at)}
