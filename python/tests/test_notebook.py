"""The worked notebook runs."""

from pathlib import Path

import pytest


def test_the_notebook_runs():
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    place = Path(__file__).parents[1] / "examples/visit.ipynb"
    notebook = nbformat.read(place, as_version=4)
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(place.parent)}}).execute()
    said = [str(output) for cell in notebook.cells for output in cell.get("outputs", [])]
    assert any("PPN" in text or "EXX" in text for text in said) and any("iframe" in text for text in said)
