"""Laser measurements of a machine tool: the nine errors, the files that its control loads, forecasts and verdicts.

    visit = nonius.Visit(job, errors=frame)   # a job as a dict or a path; tables as NumPy, pandas, Arrow or Polars
    kit = visit.generate()                    # the files for the control
    kit.verify().verdict                      # read back and judged: "pass", "fail" or "undecided"
    kit.verify(after=second).verdict          # a second measurement, judged against the forecast

Positions in mm, deviations and U in µm, angles in µrad, squareness in µm/m. Deviation = actual − commanded, tool
relative to workpiece. A value that nobody measured is NaN in an array and None in a document, never 0. Tables have the
columns of docs/interface.md §2, documents the keys of its §5. The program computes; this package only wraps it.
"""

from ._answers import Answer, Assessment, Figures, Judgement, Kit, Problem, Separation, Standards, Table
from ._visit import Visit, ask

__all__ = ["Answer", "Assessment", "Figures", "Judgement", "Kit", "Problem", "Separation", "Standards", "Table", "Visit", "ask"]
