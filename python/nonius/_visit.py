"""A visit to a machine: its job and tables, and what the program makes of them."""

from __future__ import annotations

import copy
import decimal
import json
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Union

import numpy as np

from . import _core
from ._answers import Answer, Assessment, Judgement, Kit, Problem, Separation, Standards, Table, _figures, _framed, _judgement

TableLike = Union[Mapping[str, Any], str, os.PathLike[str], Any]
JobLike = Union[Mapping[str, Any], str, os.PathLike[str]]
# Folders of the files that a question holds; nobody calls one of his own so.
KIT, AFTER, MADE = ".nonius/kit", ".nonius/after", ".nonius/made"


def ask(command: str, *options: str, job: JobLike | None = None, files: Mapping[str, Any] | None = None) -> Answer:
    """Any command of the program that prints JSON. `files` by name: text, bytes, a table, or the sections of a job; what is
    not among them is read from disk. What the command writes is in the answer alone. `Problem` where it could not do it."""
    held = {name: _held(name, content) for name, content in (files or {}).items()}
    question = {"command": command, "options": list(options), "files": held}
    if job is not None:
        question["job"] = dict(job) if isinstance(job, Mapping) else os.fspath(job)
    try:
        asked = json.dumps(question, default=_plain, allow_nan=False)
    except ValueError as error:
        raise Problem(f"a job holds no infinite numbers and nothing that holds itself: {error}", []) from error
    answer = json.loads(_core.ask(asked))
    if answer["status"] == 2:
        raise Problem(answer.get("said", ""), answer["problems"])
    made = {name: text.encode() if isinstance(text, str) else bytes(text) for name, text in answer["files"].items()}
    return Answer(answer["status"], answer["document"], made)


@dataclass(frozen=True, eq=False)
class Visit:
    """A visit: `job` as a dict (sections and keys of docs/interface.md §2.3) or the path of a job.

    A job as a dict takes its measurement as `errors` (columns axis, position_mm, ex_um …, §2.1) or `readings` (diagonal,
    node, moved, deviation_um …, §2.2): the path of a CSV, a data frame of pandas or Polars, a table of Arrow, a mapping of
    arrays of shape (n,), or a structured array. NaN, NA and None are empty cells. What a table says of itself in comments
    (doubts, what was not stated, degrees of freedom) decides a verdict: it comes along with a path, a `Table`, with
    `frame.attrs["remarks"]` or a column `remarks` of a mapping (a list of lines). `files` by name: further files that the job
    names. Paths are relative to the current folder, those in a job on disk to the job. Later changes of what was given
    change nothing.
    """

    job: JobLike
    errors: TableLike | None = field(default=None, repr=False)
    readings: TableLike | None = field(default=None, repr=False)
    files: Mapping[str, Any] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        given = {key: table for key in ("errors", "readings") if (table := getattr(self, key)) is not None}
        if given and not isinstance(self.job, Mapping):
            raise TypeError("a job on disk names its tables itself; give the job as a dict (tomllib.load)")
        job = copy.deepcopy(self.job)
        files = {name: _held(name, content) for name, content in self.files.items()}
        for key, table in given.items():
            files[f"{key}.csv"] = _columns(table)
            job["measurement"] = {**job.get("measurement", {}), key: f"{key}.csv"}
        object.__setattr__(self, "job", job)
        object.__setattr__(self, "files", files)

    def ask(self, command: str, *options: str, files: Mapping[str, Any] | None = None) -> Answer:
        """A command of the program on this visit."""
        return ask(command, *options, job=self.job, files={**self.files, **(files or {})})

    def separate(self, trials: int = 2000, seed: int = 1) -> Separation:
        """The nine errors of the readings; `trials` of the Monte Carlo simulation of ranges and straightness, 0 = none."""
        answer = self.ask("separate", "--trials", str(trials), "--seed", str(seed), "-o", f"{MADE}/errors.csv")
        table = Table.from_csv(answer.files[f"{MADE}/errors.csv"].decode())
        squareness = answer.document["squareness_um_per_m"]
        return Separation(table, squareness, answer.status == 0, answer.document, self.report)

    def generate(self) -> Kit:
        """The files for the control."""
        answer = self.ask("generate", "-o", KIT)
        files = {name.removeprefix(f"{KIT}/"): content for name, content in answer.files.items()}
        return Kit(files, answer.document, answer.status == 0, self)

    def forecast(self) -> Judgement:
        """What the files would leave, and the verdict; no file is made."""
        return _judgement(self.ask("generate", "--dry-run"), self.report)

    def verify(self, kit: Kit | str | os.PathLike[str], after: TableLike | Visit | None = None) -> Judgement:
        """Reads the files of a kit, or of a folder, back and judges them; `after` = a measurement with them active: an
        error table, or a visit (a path is that of either)."""
        options, files = _beside(kit, after)
        return _judgement(self.ask("verify", *options, files=files), partial(self.report, kit, after))

    def assess(self, *options: str) -> Assessment:
        """What the errors do in the volume; `options` of `assess`, e.g. "--grid", "5,5,5"."""
        document = self.ask("assess", *options).document
        figures = document["definitions"]
        return Assessment(figures["va_um"], figures["length_um"], _figures(document, "terms"), document)

    def standards(self, *options: str) -> Standards:
        """Figures by standard of the readings of the diagonals."""
        return Standards(self.ask("standards", *options).document)

    def report(
        self, kit: Kit | str | os.PathLike[str] | None = None, after: TableLike | Visit | None = None, language: str = "en"
    ) -> str:
        """The page that is handed over (HTML); `language` = en, de, zh or the path of a file of texts."""
        options, files = _beside(kit, after)
        answer = self.ask("report", *options, "--language", language, "-o", f"{MADE}/report.html", files=files)
        return answer.files[f"{MADE}/report.html"].decode()

    def _repr_html_(self) -> str:
        return _framed(self.report())


def _beside(kit: Kit | str | os.PathLike[str] | None, after: TableLike | Visit | None) -> tuple[list[str], dict[str, Any]]:
    """Options and files of a kit and of a second measurement."""
    options: list[str] = []
    files: dict[str, Any] = {}
    if isinstance(kit, Kit):
        options += ["--tables", KIT]
        files.update({f"{KIT}/{name}": content for name, content in kit.files.items()})
    elif kit is not None:
        options += ["--tables", os.fspath(kit)]
    if isinstance(after, Visit):
        # By full paths, since files of the same names belong to the first visit.
        is_held = isinstance(after.job, Mapping)
        job = os.path.abspath("job.toml" if is_held else after.job)
        files.update({os.path.abspath(name): content for name, content in after.files.items()})
        files.update({job: after.job} if is_held else {})
        options += ["--after", job]
    elif isinstance(after, (str, os.PathLike)):
        options += ["--after", os.fspath(after)]
    elif after is not None:
        files[f"{AFTER}/errors.csv"] = _columns(after)
        options += ["--after", f"{AFTER}/errors.csv"]
    return options, files


def _held(name: str, content: Any) -> Any:
    """A file that a question holds."""
    if isinstance(content, bytes):
        return _text(content)
    return content if isinstance(content, str) or name.endswith(".toml") else _columns(content)


def _text(content: bytes) -> str | list[int]:
    try:
        return content.decode()
    except UnicodeDecodeError:
        return list(content)  # the program says what is wrong with it


def _columns(table: TableLike) -> Any:
    """Columns as lists by their names; a path becomes what its file holds."""
    if isinstance(table, (str, os.PathLike)):
        return _text(Path(table).read_bytes())
    if isinstance(table, list):
        return table  # bytes of a file
    names = getattr(getattr(table, "dtype", None), "names", None) or getattr(table, "column_names", None)
    if isinstance(table, Mapping) or not (names or hasattr(table, "columns")):
        names = table.keys()
    names = [str(name) for name in (table.columns if names is None else names)]
    if len(set(names)) < len(names):
        raise TypeError("a table has two columns of one name")
    remarks = getattr(table, "remarks", None) or getattr(table, "attrs", {}).get("remarks")
    return {name: _list(table[name]) for name in names} | ({"remarks": list(remarks)} if remarks else {})


def _list(values: Any) -> Any:
    """A column as JSON has it: None = empty."""
    for method in ("to_pylist", "tolist", "to_list"):
        if hasattr(values, method):
            values = getattr(values, method)()
            break
    if not isinstance(values, (list, tuple)):
        return values  # no list: the program says so
    return [_cell(cell) for cell in values]


def _cell(cell: Any) -> Any:
    """A cell as JSON has it; the program says what is wrong with one that is infinite, and where."""
    if _is_missing(cell):
        return None
    if isinstance(cell, (float, np.floating, decimal.Decimal)):
        return number if math.isfinite(number := float(cell)) else str(number)
    return cell.decode() if isinstance(cell, bytes) else cell


def _is_missing(cell: Any) -> bool:
    """None, NaN of any kind, NA and NaT of pandas."""
    return cell is None or type(cell).__name__ in ("NAType", "NaTType") or bool(cell != cell)


def _plain(value: Any) -> Any:
    """A value as JSON has it."""
    if isinstance(value, (decimal.Decimal, np.floating)):
        return float(value)
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    for method in ("tolist", "isoformat"):
        if hasattr(value, method):
            return getattr(value, method)()
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"a question cannot hold a {type(value).__name__}")
