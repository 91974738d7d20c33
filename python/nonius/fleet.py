"""Many machines, many visits: verdicts, drift and dates of service, on pandas, Dask or Spark (docs/fleets.md).

A frame has a row each visit: `machine`, `date` and the columns of its table as lists (those of docs/interface.md §2.1 or
§2.2, and `remarks`). Where tables were loaded between visits, `since` names the state of the machine: drift and trend begin
anew where it changes. `packed` makes such a frame of one with a row each value.
"""

from __future__ import annotations

import datetime
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, Union

import numpy as np
import pandas as pd

from . import _core
from ._answers import Problem, Table
from ._page import report
from ._visit import Visit, _is_missing

__all__ = ["COLUMNS", "META", "SCHEMA", "judge", "judge_parts", "packed", "report"]

TERMS = ("EXX", "EYX", "EZX", "EXY", "EYY", "EZY", "EXZ", "EYZ", "EZZ")
PLANES = ("xy", "xz", "yz")
DATES = ("date", "due", "due_earliest", "due_latest")
WORDS = ("machine", "since", "verdict", "scope", "missing", "problem")
#: A job for all machines (or its path), or what gives that of a machine by its name.
JobOf = Union[Mapping[str, Any], str, Callable[[str], Mapping[str, Any]]]
#: The columns of a result, a row each visit; NaN = not known. docs/fleets.md tells each.
COLUMNS = (
    *("machine", "since", "date", "verdict", "scope", "max_residual_um", "at_most_um", "va_um", "missing"),
    *(f"{term}_{what}_um" for term in TERMS for what in ("found", "u95", "forecast")),
    *(f"{plane}_{what}_um_per_m" for plane in PLANES for what in ("squareness", "u95")),
    "va_drift_um",
    *(f"{term}_drift{what}_um" for term in TERMS for what in ("", "_u95")),
    *(f"{plane}_drift{what}_um_per_m" for plane in PLANES for what in ("", "_u95")),
    *("due", "due_earliest", "due_latest", "problem"),
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
    if isinstance(job, str):
        with open(job, "rb") as file:
            job = tomllib.load(file)
    visits = [_visit(row, job, grid) for row in frame.to_dict("records")]
    order = sorted(visits, key=lambda visit: (visit["machine"], not _is_missing(visit["date"]) and visit["date"] or pd.Timestamp.min))
    before: dict[str, list[dict[str, Any]]] = {}
    for visit in order:
        if visit["problem"] == "" or "_curves" in visit:
            own = before.setdefault(visit["machine"], [])
            if own and own[-1]["since"] != visit["since"]:
                own.clear()
            if own:
                visit |= _drift(own[-1], visit)
            own.append(visit)
    for own in before.values():
        own[-1] |= _due([visit for visit in own if visit["missing"] == own[-1]["missing"]], limit_um)
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


def _visit(row: dict[str, Any], job: JobOf, grid: str) -> dict[str, Any]:
    """One visit by itself; `_curves` where its errors could be read."""
    machine, since = ("" if _is_missing(row.get(key)) else str(row.get(key)) for key in ("machine", "since"))
    result = {"machine": machine, "since": since, "date": pd.NaT, "verdict": "", "missing": "", "problem": ""}
    table = {name: values for name, values in row.items() if name not in ("machine", "since", "date")}
    table = {name: values for name, values in table.items() if isinstance(values, (list, tuple, np.ndarray)) or not _is_missing(values)}
    try:
        if not machine:
            raise ValueError("the machine has no name")
        result["date"] = _day(row["date"])
        own = dict(job(machine) if callable(job) else job)
        measurement = {key: value for key, value in own.get("measurement", {}).items() if key not in ("errors", "readings")}
        own["measurement"] = {**measurement, "date": result["date"].date().isoformat()}
        visit = Visit(own, **{"readings" if "diagonal" in table else "errors": table})
        reference = {axis: own["machine"]["axes"].get(axis, {}).get("reference_mm", 0.0) for axis in "xyz"}
        result |= _found(visit, grid)
        errors = visit.separate(0).errors if "diagonal" in table else {name: np.asarray(values) for name, values in table.items()}
        result["_curves"] = _curves(errors, reference)
        judged = visit.forecast()
    except (Problem, KeyError, TypeError, ValueError) as problem:
        words = f"{type(problem).__name__}: {problem}" if isinstance(problem, KeyError) else str(problem)
        return result | {"problem": words}
    result |= {"verdict": judged.verdict, "scope": "; ".join(judged.scope)}
    result |= {name: judged.document[f"max_residual{of}_um"] for name, of in (("max_residual_um", ""), ("at_most_um", "_at_most"))}
    return result | {f"{term}_forecast_um": figures["forecast_um"] for term, figures in judged.terms.items()}


def _found(visit: Visit, grid: str) -> dict[str, Any]:
    """The machine as found."""
    document = visit.assess("--grid", grid).document
    result = {"va_um": document["definitions"]["va_um"], "missing": " ".join(entry["name"] for entry in document["missing"])}
    for term, figures in document["terms"].items():
        result |= {f"{term}_found_um": figures["before_um"], f"{term}_u95_um": figures["expanded_um"]}
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


Curve = tuple[np.ndarray, np.ndarray, np.ndarray]


def _curves(errors: Mapping[str, Any] | Table, reference_mm: Mapping[str, float]) -> dict[tuple[str, str], Curve]:
    """Positions, deviations and standard uncertainties against the reference of each term and direction, µm; what cannot be
    compared (other units than µm and mm) is left out."""
    curves: dict[tuple[str, str], Curve] = {}
    if "position_mm" not in errors:
        return curves
    axes = np.char.lower(np.asarray(errors["axis"], dtype=str))
    directions = np.asarray(errors["direction"], dtype=str) if "direction" in errors else np.full(len(axes), "")
    for axis in "xyz":
        for direction in sorted(set(directions[axes == axis])):
            rows = (axes == axis) & (directions == direction)
            mm = np.asarray(errors["position_mm"], dtype=float)[rows]
            for of in "xyz":
                if f"e{of}_um" not in errors or rows.sum() < 2:
                    continue
                um = np.asarray(errors[f"e{of}_um"], dtype=float)[rows]
                u = np.asarray(errors[f"u_e{of}_um"], dtype=float)[rows] if f"u_e{of}_um" in errors else np.full(len(um), np.nan)
                at = [np.interp(reference_mm[axis], mm, values) for values in (um, u)]
                if not np.isnan(um).any():
                    curves[f"E{of.upper()}{axis.upper()}", direction] = (mm, um - at[0], np.hypot(u, at[1]))
    return curves


def _drift(old: dict[str, Any], new: dict[str, Any]) -> dict[str, Any]:
    """What changed between two visits, with U; the two are taken as independent.

    Of a term the change e₂(p) − e₁(p), each against the reference, where it is largest, at the later positions within
    both ranges; U = K·√(u₁² + u₂²) there, each u with that of the reference.
    """
    drift = {}
    if old["missing"] == new["missing"]:
        drift["va_drift_um"] = new["va_um"] - old["va_um"]
    for plane in PLANES:
        figures = [visit.get(f"{plane}_squareness_um_per_m") for visit in (old, new)]
        u95 = [visit.get(f"{plane}_u95_um_per_m") for visit in (old, new)]
        if None not in figures:
            drift[f"{plane}_drift_um_per_m"] = figures[1] - figures[0]
            drift[f"{plane}_drift_u95_um_per_m"] = np.nan if None in u95 else float(np.hypot(*u95))
    for (term, direction), (mm, um, u) in new.get("_curves", {}).items():
        if (term, direction) not in old.get("_curves", {}):
            continue
        old_mm, old_um, old_u = old["_curves"][term, direction]
        common = (mm >= old_mm[0]) & (mm <= old_mm[-1])
        change = um[common] - np.interp(mm[common], old_mm, old_um)
        if not len(change):
            continue
        at = int(np.argmax(np.abs(change)))
        if abs(change[at]) >= abs(drift.get(f"{term}_drift_um", 0.0)):
            drift[f"{term}_drift_um"] = change[at]
            drift[f"{term}_drift_u95_um"] = K * np.hypot(u[common], np.interp(mm[common], old_mm, old_u))[at]
    return drift


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
    band = _core.coverage_factor(len(days) - 2.0) * s * np.sqrt(1 / len(days) + ahead**2 / (spread @ spread))
    first = (np.flatnonzero(curve >= limit_um) for curve in (line, line + band, line - band))
    return {name: last["date"] + pd.Timedelta(days=int(at[0])) for name, at in zip(names, first) if len(at)}
