"""Many machines, many visits: verdicts, drift and dates of service, on pandas, Dask or Spark (docs/fleets.md).

A frame has a row each visit: `machine`, `date` and the columns of its table as lists (those of docs/interface.md §2.1 or
§2.2, and `remarks`). Where tables were loaded between visits, `since` names the state of the machine: drift and trend begin
anew where it changes. `packed` makes such a frame of one with a row each value.
"""

from __future__ import annotations

import datetime
import functools
import os
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, Union

import numpy as np
import pandas as pd

from . import _core
from ._answers import Table
from ._page import report
from ._visit import MADE, Visit, _is_missing

__all__ = ["COLUMNS", "META", "SCHEMA", "judge", "judge_parts", "packed", "report"]

TERMS = ("EXX", "EYX", "EZX", "EXY", "EYY", "EZY", "EXZ", "EYZ", "EZZ")
PLANES = ("xy", "xz", "yz")
DATES = ("date", "due", "due_earliest", "due_latest")
WORDS = ("machine", "since", "verdict", "scope", "missing", "not_compared", "problem")
JobLike = Union[Mapping[str, Any], str, "os.PathLike[str]"]
#: A job for all machines, or what gives that of a machine by its name. Relative paths in a job on disk count from it, those in a
#: dict from the current folder.
JobOf = Union[JobLike, Callable[[str], JobLike]]
#: The columns of a result, a row each visit; NaN = not known. docs/fleets.md tells each.
COLUMNS = (
    *("machine", "since", "date", "verdict", "scope", "max_residual_um", "at_most_um", "va_um", "missing"),
    *(f"{term}_{what}_um" for term in TERMS for what in ("found", "u95", "forecast")),
    *(f"{plane}_{what}_um_per_m" for plane in PLANES for what in ("squareness", "u95")),
    "va_drift_um",
    *(f"{term}_drift{what}_um" for term in TERMS for what in ("", "_u95")),
    *(f"{plane}_drift{what}_um_per_m" for plane in PLANES for what in ("", "_u95")),
    *("not_compared", "due", "due_earliest", "due_latest", "problem"),
)
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
#: U = K·u of a difference, 95 %.
K = 2.0
#: Ranges and volumes are the same whose ends differ less, mm: as much as a table may exceed the travel.
SAME_MM = 0.01


def packed(values: pd.DataFrame) -> pd.DataFrame:
    """A row each visit, of a frame with a row each value: `machine`, `date`, perhaps `since`, and the columns of a table."""
    keys = [name for name in ("machine", "since", "date") if name in values]
    names = [name for name in values if name not in keys]
    return values.groupby(keys, sort=True, dropna=False, observed=True)[names].agg(list).reset_index()


def judge(frame: pd.DataFrame, job: JobOf, limit_um: float | None = None, grid: str = GRID) -> pd.DataFrame:
    """The results of all visits of some machines, sorted by machine and date.

    `limit_um` = VA at which a machine is due for service; `grid` = nodes of the volume for VA. All visits of a machine have to
    be in the frame. A visit that cannot be judged has its reason in `problem`.
    """
    if frame.empty:
        return META.copy()
    job_of = functools.partial(_job, job, functools.cache(_sections))
    visits = [_visit(row, job_of, grid) for row in frame.to_dict("records")]
    order = sorted(visits, key=lambda visit: (visit["machine"], not _is_missing(visit["date"]) and visit["date"] or pd.Timestamp.min))
    before: dict[str, list[dict[str, Any]]] = {}
    for visit in order:
        if "_curves" in visit:
            own = before.setdefault(visit["machine"], [])
            if own and own[-1]["since"] != visit["since"]:
                own.clear()
            if own:
                visit |= _drift(own[-1], visit)
            own.append(visit)
    for own in before.values():
        own[-1] |= _due([visit for visit in own if _is_same_volume(visit, own[-1])], limit_um)
    return pd.DataFrame(order).reindex(columns=list(COLUMNS)).astype(_TYPES)


def judge_parts(
    frames: Iterable[pd.DataFrame], job: JobOf, limit_um: float | None = None, grid: str = GRID
) -> Iterator[pd.DataFrame]:
    """The same of frames that come one after the other, sorted by machine: a machine may lie in several that touch."""
    rest, given = pd.DataFrame(), set()

    def judged(part: pd.DataFrame) -> pd.DataFrame:
        names = set(part["machine"])
        if again := names & given:
            raise ValueError(f"the visits of {sorted(map(str, again))[0]} do not lie together: sort by machine")
        given.update(names)
        return judge(part, job, limit_um, grid)

    for frame in frames:
        rest = pd.concat([rest, frame], ignore_index=True)
        is_last = rest["machine"] == rest["machine"].iloc[-1] if len(rest) else pd.Series(dtype=bool)
        if not is_last.all():
            yield judged(rest[~is_last])
            rest = rest[is_last]
    if len(rest):
        yield judged(rest)


def _sections(path: str | os.PathLike[str]) -> Mapping[str, Any]:
    with open(path, "rb") as file:
        return tomllib.load(file)


def _job(job: JobOf, sections: Callable[[Any], Mapping[str, Any]], machine: str) -> tuple[str, dict[str, Any]]:
    """Where the job of a machine lies, and its sections."""
    own = job(machine) if callable(job) else job
    path = "job.toml" if isinstance(own, Mapping) else os.path.splitext(os.fspath(own))[0] + ".toml"
    return path, dict(own if isinstance(own, Mapping) else sections(own))


def _visit(row: dict[str, Any], job_of: Callable[[str], tuple[str, dict[str, Any]]], grid: str) -> dict[str, Any]:
    """One visit by itself; `_curves` where its errors could be read. Whatever it fails for is its problem, and no other's."""
    result = {"machine": "", "since": "", "date": pd.NaT, "verdict": "", "missing": "", "not_compared": "", "problem": ""}
    try:
        result |= {key: "" if _is_missing(row.get(key)) else str(row[key]) for key in ("machine", "since")}
        if not result["machine"]:
            raise ValueError("the machine has no name")
        result["date"] = _day(row["date"])
        visit = _placed(row, *job_of(result["machine"]), result["date"])
        result |= _found(visit, grid)
        result["_curves"] = {term: ways for term, ways in _curves(visit).items() if f"{term}_found_um" in result}
        judged = visit.forecast()
        result |= {"verdict": judged.verdict, "scope": "; ".join(judged.scope)}
        result |= {name: judged.document[f"max_residual{of}_um"] for name, of in (("max_residual_um", ""), ("at_most_um", "_at_most"))}
        result |= {f"{term}_forecast_um": figures["forecast_um"] for term, figures in judged.terms.items()}
    except Exception as problem:
        kind = "" if isinstance(problem, ValueError) else f"{type(problem).__name__}: "
        result["problem"] = kind + str(problem)
    return result


def _placed(row: dict[str, Any], path: str, job: dict[str, Any], date: pd.Timestamp) -> Visit:
    """The visit of a row: its job and its table stand where the job lies, so that whatever else that names is found."""
    table = {name: values for name, values in row.items() if name not in ("machine", "since", "date")}
    table = {name: values for name, values in table.items() if isinstance(values, (list, tuple, np.ndarray)) or not _is_missing(values)}
    key = "readings" if "diagonal" in table else "errors"
    measurement = job.get("measurement", {})
    if isinstance(measurement, Mapping):
        others = {name: value for name, value in measurement.items() if name not in ("errors", "readings")}
        job["measurement"] = {**others, "date": date.date().isoformat(), key: f"{key}.csv"}
    return Visit(path, files={path: job, os.path.join(os.path.dirname(path), f"{key}.csv"): table})


def _found(visit: Visit, grid: str) -> dict[str, Any]:
    """The machine as found."""
    document = visit.assess("--grid", grid).document
    result = {"va_um": document["definitions"]["va_um"], "missing": " ".join(entry["name"] for entry in document["missing"])}
    result["_volume_mm"] = document["volume_mm"]
    for term, figures in document["terms"].items():
        result |= {f"{term}_found_um": figures["before_um"], f"{term}_u95_um": figures["expanded_um"], f"{term}_u_um": figures["u_um"]}
    for plane, figures in document["squareness"].items():
        result |= {f"{plane}_squareness_um_per_m": figures["before_um_per_m"], f"{plane}_u95_um_per_m": figures["expanded_um_per_m"]}
    return result


def _day(date: Any) -> pd.Timestamp:
    """The day of a date, or of a time where it was measured; a text in the form of ISO 8601."""
    if isinstance(date, str):
        date = datetime.datetime.fromisoformat(date)
    if not isinstance(date, (datetime.date, np.datetime64)) or _is_missing(date):
        raise ValueError(f"`{date}` is no date: give one, or a text as 2026-11-29")
    return pd.Timestamp(date).tz_localize(None).normalize()


#: Of each direction of a term positions and deviations, mm and µm.
Ways = dict[str, tuple[np.ndarray, np.ndarray]]


def _curves(visit: Visit) -> dict[str, Ways]:
    """The curves of the terms without tables, as the program reads them: both directions against one zero (contract §2.3), so
    that the second has the reversal."""
    made = f"{MADE}/errors.csv"
    errors = Table.from_csv(visit.ask("simulate", "--errors", "--without-tables", "-o", made).files[made].decode())
    axes, direction = errors["axis"], errors.get("direction", np.full(len(errors["axis"]), ""))
    curves: dict[str, Ways] = {}
    for term in TERMS:
        of, along = term[1:].lower()
        for way in sorted(set(direction[axes == along])) if f"e{of}_um" in errors else ():
            mm, um = (errors[name][(axes == along) & (direction == way)] for name in ("position_mm", f"e{of}_um"))
            if not np.isnan(um).any():
                curves.setdefault(term, {})[way] = (mm, um)
    return curves


def _drift(old: dict[str, Any], new: dict[str, Any]) -> dict[str, Any]:
    """What changed between two visits, with U; the two are taken as independent.

    Of a term the change e₂(p) − e₁(p), each against the reference, where it is largest; U = K·√(u₁² + u₂²), each u the largest of
    its curve. What was measured at one of the visits alone, or differently, is `not_compared`.
    """

    def both(figure: str) -> list[Any]:
        return [visit.get(figure) for visit in (old, new)]

    is_same = _is_same_volume(old, new)
    drift, apart = ({"va_drift_um": new["va_um"] - old["va_um"]}, []) if is_same else ({}, ["VA"])
    changes = [
        (term, "um", "found", _change(*(visit["_curves"].get(term, {}) for visit in (old, new))), both(f"{term}_u_um"), K)
        for term in TERMS
    ]
    for plane in PLANES:
        angles = both(f"{plane}_squareness_um_per_m")
        change = None if None in angles else angles[1] - angles[0]
        changes.append((plane, "um_per_m", "squareness", change, both(f"{plane}_u95_um_per_m"), 1.0))
    for name, unit, figure, change, u, k in changes:
        if change is not None:
            drift[f"{name}_drift_{unit}"] = change
            drift[f"{name}_drift_u95_{unit}"] = np.nan if None in u else k * float(np.hypot(*u))
        elif both(f"{name}_{figure}_{unit}") != [None, None]:
            apart.append(name)
    return drift | {"not_compared": " ".join(apart)}


def _change(old: Ways, new: Ways) -> float | None:
    """The largest change of a term, µm; `None` unless the directions and their ranges are the same."""
    if not new or old.keys() != new.keys():
        return None
    changes = []
    for way, (mm, um) in new.items():
        old_mm, old_um = old[way]
        if not np.allclose(mm[[0, -1]], old_mm[[0, -1]], rtol=0, atol=SAME_MM):
            return None
        at = np.union1d(mm, old_mm)
        changes += list(np.interp(at, mm, um) - np.interp(at, old_mm, old_um))
    return max(changes, key=abs)


def _is_same_volume(one: dict[str, Any], other: dict[str, Any]) -> bool:
    """Whether VA is of the same errors in the same volume."""
    volumes = [np.array([ends or (np.nan, np.nan) for ends in visit["_volume_mm"].values()]) for visit in (one, other)]
    return one["missing"] == other["missing"] and np.allclose(*volumes, rtol=0, atol=SAME_MM, equal_nan=True)


def _due(visits: list[dict[str, Any]], limit_um: float | None) -> dict[str, Any]:
    """When the straight line through VA reaches the limit, and the band around it; a limit that is reached is due at once.

    Line y = ȳ + b·(t − t̄), band ± k·s·√(1/n + (t − t̄)²/Σ(t − t̄)²) with s² = Σ residual²/(n − 2), k by Student (95 %).
    """
    last = visits[-1]
    names = ("due", "due_earliest", "due_latest")
    if limit_um is None:
        return {}
    if last["va_um"] >= limit_um:
        return dict.fromkeys(names, last["date"])
    days = np.array([(visit["date"] - last["date"]).days for visit in visits], dtype=float)
    values = np.array([visit["va_um"] for visit in visits])
    if len(days) < 3 or np.ptp(days) == 0:
        return {}
    spread = days - days.mean()
    slope = (spread @ values) / (spread @ spread)
    residual = values - values.mean() - slope * spread
    s = np.sqrt((residual @ residual) / (len(days) - 2))
    ahead = np.arange(HORIZON_DAYS + 1.0) - days.mean()
    line = values.mean() + slope * ahead
    band = _core.student(0.975, len(days) - 2.0) * s * np.sqrt(1 / len(days) + ahead**2 / (spread @ spread))
    first = (np.flatnonzero(curve >= limit_um) for curve in (line, line + band, line - band))
    return {name: last["date"] + pd.Timedelta(days=int(at[0])) for name, at in zip(names, first) if len(at)}
