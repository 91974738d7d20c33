"""What the program answers, as values that do not change."""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import pandas
    from numpy.typing import NDArray

    from ._visit import TableLike, Visit

Document = dict[str, Any]


class Problem(ValueError):
    """Why the program could not do it.

    `message`, `file`, `line`, `column` (from 1) and `help` are of the first problem; `all` are all of them as the
    program names them (docs/interface.md §5). Printed, it is what the program prints.
    """

    def __init__(self, said: str, problems: list[Document]) -> None:
        super().__init__(said.strip())
        self.all = problems
        first = problems[0] if problems else {}
        place = first.get("place") or {}
        self.message: str = first.get("message") or said.strip()
        self.help: str | None = first.get("help")
        self.file: str | None = place.get("file")
        self.line: int | None = place.get("line")
        self.column: int | None = place.get("column")

    def __reduce__(self) -> tuple[type[Problem], tuple[str, list[Document]]]:
        return (Problem, (str(self.args[0]), self.all))


@dataclass(frozen=True, eq=False)
class Answer:
    """An answer of the program: `status` 0 = yes, 1 = the answer is no; the document; the files that it made."""

    status: int
    document: Any
    files: Mapping[str, bytes]


@dataclass(frozen=True, eq=False)
class Table(Mapping[str, "NDArray[Any]"]):
    """Columns by their names: words as `str`, numbers as float64 of one length, NaN = not measured. `remarks` are the comments
    of the file: what the values rest on, which the program reads again."""

    columns: Mapping[str, NDArray[Any]]
    remarks: tuple[str, ...] = field(default=(), repr=False)

    @staticmethod
    def from_csv(text: str) -> Table:
        """A table that the program wrote: comments (`#`), a header, rows."""
        lines = text.splitlines()
        header, *rows = csv.reader(line for line in lines if not line.startswith("#"))
        remarks = tuple(line[1:].strip() for line in lines if line.startswith("#"))
        return Table({name: _column(cells) for name, cells in zip(header, zip(*rows))}, remarks)

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self.columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(self.columns)

    def to_pandas(self) -> pandas.DataFrame:
        """The same as a data frame; the remarks are its `attrs["remarks"]`."""
        import pandas

        frame = pandas.DataFrame(dict(self.columns))
        frame.attrs["remarks"] = list(self.remarks)
        return frame

    def _repr_html_(self) -> str:
        return str(self.to_pandas().to_html(index=False))


def _column(cells: tuple[str, ...]) -> NDArray[Any]:
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        return np.array(cells)


@dataclass(frozen=True, eq=False)
class Figures(Mapping[str, Document]):
    """Figures of the nine terms, or of the diagonals, in the program's order.

    `figures["EXX"]` has the figures of one by their names; `figures.array("forecast_um")` has one of all, float64 of
    shape (n,), NaN = not known.
    """

    by_name: Mapping[str, Document]

    def __getitem__(self, name: str) -> Document:
        return self.by_name[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.by_name)

    def __len__(self) -> int:
        return len(self.by_name)

    def array(self, figure: str) -> NDArray[np.float64]:
        """One figure of all; KeyError where none has it."""
        if not any(figure in line for line in self.by_name.values()):
            raise KeyError(figure)
        return np.array([line.get(figure) for line in self.by_name.values()], dtype=float)

    def to_pandas(self) -> pandas.DataFrame:
        """A row each, its name as index."""
        import pandas

        return pandas.DataFrame.from_dict(dict(self.by_name), orient="index", dtype=float)

    def _repr_html_(self) -> str:
        return str(self.to_pandas().to_html(float_format="%.3f"))


def _figures(document: Document, key: str) -> Figures:
    return Figures(document.get(key) or {})


@dataclass(frozen=True, eq=False)
class Judgement:
    """What `verify` says (docs/interface.md §5): the forecast, and with a second measurement the machine as left.

    `verdict` is "pass", "fail" or "undecided"; `scope` says of what, and what it rests on. `terms` and `diagonals` have
    before_um, forecast_um, u_um, expanded_um (U, 95 %), at_most_um, with a second measurement after_um; `squareness`
    (xy, xz, yz) has before_um_per_m, after_um_per_m, expanded_um_per_m.
    """

    verdict: str
    scope: list[str]
    terms: Figures
    diagonals: Figures
    squareness: Figures
    document: Document = field(repr=False)
    page: Callable[[], str] = field(repr=False, compare=False)

    def to_pandas(self) -> pandas.DataFrame:
        """The terms, a row each."""
        return self.terms.to_pandas()

    def _repr_html_(self) -> str:
        return _framed(self.page())


def _judgement(answer: Answer, page: Callable[[], str]) -> Judgement:
    document = answer.document
    kinds = [_figures(document, key) for key in ("terms", "diagonals", "squareness")]
    return Judgement(document["verdict"], document["scope"], *kinds, document, page)


@dataclass(frozen=True, eq=False)
class Kit:
    """The files for the control, by their names, with the manifest as a document.

    `keeps_acceptance`: whether the forecast keeps the acceptance of the job; a forecast that is undecided does not.
    """

    files: Mapping[str, bytes] = field(repr=False)
    manifest: Document = field(repr=False)
    keeps_acceptance: bool
    visit: Visit = field(repr=False)

    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Writes the files into a new folder, the manifest last; FileExistsError where there is one."""
        place = Path(folder)
        place.mkdir(parents=True)
        for name, content in sorted(self.files.items(), key=lambda file: file[0] == "manifest.json"):
            (place / PurePosixPath(name).name).write_bytes(content)
        return place

    def verify(self, after: TableLike | Visit | None = None) -> Judgement:
        """Reads the files back and judges them; `after` = a measurement with them active."""
        return self.visit.verify(self, after)

    def to_pandas(self) -> pandas.DataFrame:
        """The forecast of the terms, a row each."""
        return Figures(self.manifest["forecast"]["terms"]).to_pandas()

    def _repr_html_(self) -> str:
        return _framed(self.visit.report(self))


@dataclass(frozen=True, eq=False)
class Separation:
    """The nine errors of readings: `errors` as columns (axis, position_mm, ex_um, u_ex_um …) with what they rest on
    (`remarks`); `squareness_um_per_m` of xy, xz, yz; the document of `separate`.

    `stands` is False where an error is not determined or something contradicts the result (`document["doubts"]`).
    """

    errors: Table = field(repr=False)
    squareness_um_per_m: Mapping[str, float | None]
    stands: bool
    document: Document = field(repr=False)
    page: Callable[[], str] = field(repr=False, compare=False)

    def to_pandas(self) -> pandas.DataFrame:
        """The errors, a row each position."""
        return self.errors.to_pandas()

    def _repr_html_(self) -> str:
        return _framed(self.page())


@dataclass(frozen=True, eq=False)
class Assessment:
    """What the errors do in the volume: `va_um` (volumetric accuracy: the largest difference of two error vectors),
    `length_um` (the largest error of a distance of two places), `terms`; the document of `assess`."""

    va_um: float
    length_um: float
    terms: Figures = field(repr=False)
    document: Document = field(repr=False)

    def to_pandas(self) -> pandas.DataFrame:
        """What each error contributes to VA, a row each."""
        import pandas

        return pandas.DataFrame(self.document["contributions"])


@dataclass(frozen=True, eq=False)
class Standards:
    """Figures by standard (ISO 230-2 and VDI/DGQ 3441 of one axis, ISO 230-6 of diagonals): the document of `standards`."""

    document: Document


def _framed(page: str) -> str:
    """A page in a frame of its own, so that neither its style nor that of the notebook reaches the other."""
    text = page.replace("&", "&amp;").replace('"', "&quot;")
    return f'<iframe srcdoc="{text}" sandbox style="width: 100%; height: 40em; border: 0"></iframe>'
