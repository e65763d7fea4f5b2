"""Errors of Polyarm: a code for programs, texts for people."""
from __future__ import annotations

from typing import Any


class Error(RuntimeError):
    """What went wrong.

    `code` is short and stable ("unknown-robot"). `problems` has every finding as a dict with the keys code, what,
    advice, where and severity.
    """

    def __init__(self, problems: list[dict[str, Any]], text: str | None = None) -> None:
        super().__init__(text or "; ".join(problem["what"] for problem in problems))
        self.problems = problems

    @property
    def code(self) -> str:
        """The code of the first problem."""
        return str(self.problems[0]["code"]) if self.problems else "unknown"

    @property
    def advice(self) -> str:
        """What to do about the first problem; may be empty."""
        return str(self.problems[0]["advice"]) if self.problems else ""


def problem(code: str, what: str, advice: str = "") -> dict[str, Any]:
    """One finding of an Error."""
    return {"code": code, "what": what, "advice": advice, "where": "", "severity": "error"}
