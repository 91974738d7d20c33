def ask(question: str) -> str:
    """The answer (JSON) to a question of `nonius batch` (JSON)."""

def coverage_factor(degrees_of_freedom: float) -> float:
    """k with which U = k·u holds the true value in 95.45 % of all cases (Student; GUM, annex G)."""

STYLE: str

_Axis = tuple[str, float, float]
_Drawn = tuple[str, list[tuple[float, float, float]]]

def picture(title: str, panels: list[tuple[str, _Axis, _Axis, list[_Drawn]]]) -> str:
    """A picture (SVG) of panels side by side, as the pages of the program draw them."""
