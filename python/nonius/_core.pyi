def ask(question: str) -> str:
    """The answer (JSON) to a question of `nonius batch` (JSON)."""

def coverage_factor(degrees_of_freedom: float) -> float:
    """k with which U = k·u holds the true value in 95.45 % of all cases (Student; GUM, annex G)."""
