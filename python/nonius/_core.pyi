def ask(question: str) -> str:
    """The answer (JSON) to a question of `nonius batch` (JSON)."""

def student(share: float, degrees_of_freedom: float) -> float:
    """Quantile of Student's distribution: what lies below it with this share of all cases."""

STYLE: str

_Axis = tuple[str, float, float]
_Drawn = tuple[str, list[tuple[float, float, float]]]

def picture(title: str, panels: list[tuple[str, _Axis, _Axis, list[_Drawn]]]) -> str:
    """A picture (SVG) of panels side by side, as the pages of the program draw them."""
