"""The fixtures of the program: jobs as dicts, tables as NumPy arrays."""

import csv
import tomllib
from pathlib import Path

import numpy as np
import pytest

FIXTURES = Path(__file__).parents[2] / "fixtures"


def job_of(path):
    return tomllib.loads((FIXTURES / path).read_text())


def columns(path):
    """A table as arrays, empty cells as NaN or an empty word."""
    rows = csv.DictReader(line for line in (FIXTURES / path).open() if not line.startswith("#"))
    lists = {name: [] for name in rows.fieldnames}
    for row in rows:
        for name, cell in row.items():
            lists[name].append(cell)
    words = ("axis", "direction", "diagonal", "moved")
    to_numbers = lambda cells: np.array([float(cell) if cell else np.nan for cell in cells])
    return {name: np.array(cells) if name in words else to_numbers(cells) for name, cells in lists.items()}


@pytest.fixture
def job():
    """The golden machine on a Siemens 840D sl; its errors are given apart."""
    job = job_of("nine_errors_900/siemens-840d-sl.toml")
    del job["measurement"]["errors"]
    return job


@pytest.fixture
def errors():
    return columns("nine_errors_900/errors.csv")
