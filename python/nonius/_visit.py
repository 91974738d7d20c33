"""A visit to a machine: its job and tables, and what the program makes of them."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Union

from . import _core
from ._answers import Answer, Assessment, Judgement, Kit, Problem, Separation, Standards, Table, _figures, _judgement

TableLike = Union[Mapping[str, Any], str, os.PathLike[str], Any]
JobLike = Union[Mapping[str, Any], str, os.PathLike[str]]
KIT = "kit"


def ask(command: str, *options: str, job: JobLike | None = None, files: Mapping[str, Any] | None = None) -> Answer:
    """Any command of the program that prints JSON. `files` by name: text, columns, or the sections of a job; what is not
    among them is read from disk. What the command writes is in the answer alone. `Problem` where it could not do it."""
    question = {"command": command, "options": list(options), "files": dict(files or {})}
    if job is not None:
        question["job"] = dict(job) if isinstance(job, Mapping) else os.fspath(job)
    answer = json.loads(_core.ask(json.dumps(question, default=_plain)))
    if answer["status"] == 2:
        raise Problem(answer.get("said", ""), answer["problems"])
    made = {name: text.encode() if isinstance(text, str) else bytes(text) for name, text in answer["files"].items()}
    return Answer(answer["status"], answer["document"], made)


@dataclass(frozen=True)
class Visit:
    """A visit: `job` as a dict (sections and keys of docs/interface.md §2.3) or the path of a job.

    A job as a dict takes its measurement as `errors` (columns axis, position_mm, ex_um …, §2.1) or `readings` (diagonal,
    node, moved, deviation_um …, §2.2): a data frame of pandas or Polars, a table of Arrow, a mapping of arrays of shape
    (n,), a structured array, or the path of a CSV. NaN or None = an empty cell. `files` by name: further files that the
    job names. Paths are relative to the current folder, those in a job on disk to the job.
    """

    job: JobLike
    errors: TableLike | None = field(default=None, repr=False)
    readings: TableLike | None = field(default=None, repr=False)
    files: Mapping[str, Any] = field(default_factory=dict, repr=False)

    def ask(self, command: str, *options: str, files: Mapping[str, Any] | None = None) -> Answer:
        """A command of the program on this visit."""
        job, own = self._named("")
        return ask(command, *options, job=job, files={**own, **(files or {})})

    def separate(self, trials: int = 2000, seed: int = 1) -> Separation:
        """The nine errors of the readings; `trials` of the Monte Carlo simulation of ranges and straightness."""
        answer = self.ask("separate", "--trials", str(trials), "--seed", str(seed), "-o", "errors.csv")
        text = answer.files["errors.csv"].decode()
        squareness = answer.document["squareness_um_per_m"]
        table = Table.from_csv(text)
        return Separation(table, text, squareness, answer.status == 0, answer.document, self.report)

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
        return _judgement(self.ask("verify", *options, files=files), lambda: self.report(kit, after))

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
        answer = self.ask("report", *options, "--language", language, "-o", "report.html", files=files)
        return answer.files["report.html"].decode()

    def _repr_html_(self) -> str:
        from ._answers import _framed

        return _framed(self.report())

    def _named(self, folder: str) -> tuple[JobLike, dict[str, Any]]:
        """The job, and its files by the names that it has for them, in a folder of their own."""
        tables = {"errors": self.errors, "readings": self.readings}
        given = {key: table for key, table in tables.items() if table is not None}
        own = {f"{folder}{name}": content for name, content in self.files.items()}
        if not isinstance(self.job, Mapping):
            if given:
                raise TypeError("a job on disk names its tables itself; give the job as a dict (tomllib.load)")
            return self.job, own
        job = dict(self.job)
        for key, table in given.items():
            own[f"{folder}{key}.csv"] = _columns(table)
            job["measurement"] = {**job.get("measurement", {}), key: f"{key}.csv"}
        return job, own


def _beside(kit: Kit | str | os.PathLike[str] | None, after: TableLike | Visit | None) -> tuple[list[str], dict[str, Any]]:
    """Options and files of a kit and of a second measurement."""
    options: list[str] = []
    files: dict[str, Any] = {}
    if isinstance(kit, Kit):
        options += ["--tables", KIT]
        files.update({f"{KIT}/{name}": _text(content) for name, content in kit.files.items()})
    elif kit is not None:
        options += ["--tables", os.fspath(kit)]
    if isinstance(after, Visit):
        job, own = after._named("after/")
        if isinstance(job, Mapping):
            own["after/job.toml"] = job
            job = "after/job.toml"
        files.update(own)
        options += ["--after", os.fspath(job)]
    elif isinstance(after, (str, os.PathLike)):
        options += ["--after", os.fspath(after)]
    elif after is not None:
        files["after.csv"] = _columns(after)
        options += ["--after", "after.csv"]
    return options, files


def _text(content: bytes) -> str | list[int]:
    try:
        return content.decode()
    except UnicodeDecodeError:
        return list(content)


def _columns(table: TableLike) -> Any:
    """Columns as lists by their names; a path becomes the text of its file."""
    if isinstance(table, (str, os.PathLike)):
        return Path(table).read_text(encoding="utf-8-sig")
    names = getattr(getattr(table, "dtype", None), "names", None) or getattr(table, "column_names", None)
    names = names or getattr(table, "columns", None)
    if isinstance(table, Mapping) or names is None:
        names = table.keys()
    return {str(name): _plain(table[name]) for name in names}


def _plain(value: Any) -> Any:
    """A value as JSON has it."""
    for method in ("to_pylist", "tolist", "to_list", "isoformat"):
        if hasattr(value, method):
            value = getattr(value, method)()
            break
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [None if isinstance(cell, float) and math.isnan(cell) else cell for cell in value]
    return value
