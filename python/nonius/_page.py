"""The page of a fleet: one file of HTML, drawn by the program as its own pages are."""

from __future__ import annotations

from html import escape
from typing import Any

import numpy as np
import pandas as pd

from . import _core

#: Machines that are due within so many days of the last visit of all are listed.
SOON_DAYS = 365


def report(results: pd.DataFrame, title: str, limit_um: float | None = None) -> str:
    """One self-contained page (HTML) of what `fleet.judge` said: verdicts, distribution of VA, VA over time, the worst ten,
    machines due within a year of the last visit, what could not be judged. VA is that found at a visit, µm; `limit_um` is drawn."""
    results = results.assign(problem=results["problem"].fillna("")).sort_values(["machine", "date"])
    last = results.groupby("machine", sort=False).tail(1)
    known = last[last["problem"] == ""]
    counts = known["verdict"].value_counts()
    verdicts = ", ".join(f"{counts.get(word, 0)} {word}" for word in ("pass", "fail", "undecided"))
    head = f"{len(last)} machines, {len(results)} visits, {_day(results['date'].min())} to {_day(results['date'].max())}"
    due = results[results["due"] <= results["date"].max() + pd.Timedelta(days=SOON_DAYS)].sort_values("due")
    worst = known.nlargest(10, "va_um")
    wrong = results[results["problem"] != ""]
    parts = [
        f"<header><h1>{escape(title)}</h1><p>{head}</p></header>",
        f"<p>Last visit of each machine: {verdicts}, with the tables that its job would have now; not judged: {len(last) - len(known)}.</p>",
        _pictures(known["va_um"].dropna(), results.dropna(subset=["va_um", "date"]), limit_um),
        _table("Largest volumetric accuracy", worst, {"va_um": "VA/µm", "va_drift_um": "since the visit before/µm", "verdict": "verdict"}),
        _table(f"Due for service within {SOON_DAYS} days", due, {"due": "due", "due_earliest": "earliest", "due_latest": "latest", "va_um": "VA/µm"}),
        _table("Not judged", wrong, {"problem": "why"}),
        '<p class="note">VA: the largest difference of two error vectors in the volume, as found, without reversal. Due: the straight line through the VA of a machine reaches the limit; earliest and latest: the band in which that line lies with 95 %, as far as the scatter of these visits tells.</p>',
    ]
    return (
        f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title><style>{_core.STYLE}'
        "table{border-collapse:collapse}td,th{padding:.1rem .8rem .1rem 0;text-align:left;border-bottom:1px solid var(--line)}svg{max-width:100%;height:auto}"
        f"</style></head><body>{''.join(parts)}</body></html>\n"
    )


def _day(date: Any) -> str:
    return "" if pd.isna(date) else str(date.date())


def _table(title: str, rows: pd.DataFrame, columns: dict[str, str]) -> str:
    if rows.empty:
        return f"<h2>{escape(title)}</h2><p>none</p>"

    def cell(value: Any) -> str:
        if isinstance(value, float):
            return "" if np.isnan(value) else f"{value:.1f}"
        return escape(value) if isinstance(value, str) else _day(value)

    names = {"machine": "machine", "date": "visit"} | columns
    lines = [[cell(row[name]) for name in names] for row in rows.to_dict("records")]
    body = "".join("<tr>" + "".join(f"<td>{text}</td>" for text in line) + "</tr>" for line in lines)
    return f"<h2>{escape(title)}</h2><table><tr>{''.join(f'<th>{name}</th>' for name in names.values())}</tr>{body}</table>"


def _pictures(va_um: pd.Series, judged: pd.DataFrame, limit_um: float | None) -> str:
    """How VA is distributed at the last visits, and its tenth, middle and ninetieth percentile in each year."""
    if va_um.empty:
        return ""
    heights, edges = np.histogram(va_um, bins="sqrt" if len(va_um) < 400 else 20)
    bars = [(float(a), float(b), float(n)) for a, b, n in zip(edges, edges[1:], heights)]
    years = judged.groupby(judged["date"].dt.year)["va_um"].quantile([0.1, 0.5, 0.9]).unstack()
    band = [(float(year), row[0.1], row[0.9]) for year, row in years.iterrows()]
    line = [(float(year), row[0.5], 0.0) for year, row in years.iterrows()]
    ends = float(years.index.min()) - 0.5, float(years.index.max()) + 0.5
    limit = [] if limit_um is None else [("limit", [(end, limit_um, 0.0) for end in ends])]
    top = max([high for _, _, high in band] + [limit_um or 0.0])
    panels = [
        ("machines by VA at their last visit", ("VA / µm", float(edges[0]), float(edges[-1])), ("machines", 0.0, float(heights.max())), [("bars", bars)]),
        ("VA of all visits: median, 10 to 90 %", ("year", *ends), ("VA / µm", 0.0, top), [("band", band), ("line", line), *limit]),
    ]
    return _core.picture("Volumetric accuracy (VA) as found", panels)
