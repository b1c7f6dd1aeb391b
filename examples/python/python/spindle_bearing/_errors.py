"""Exceptions."""

from __future__ import annotations


class SpindleError(ValueError):
    """A file, an array, a frame or an option that is at fault: its words say what to do.

    Attributes
    ----------
    file : str or None
        The file at fault, as it was named.
    line, column : int or None
        The place in it, from 1.
    """

    def __init__(self, words: str, file: str | None = None, line: int | None = None, column: int | None = None) -> None:
        super().__init__(words)
        self.file = file
        self.line = line
        self.column = column


def optional(module: str, what: str):
    """A module that is not installed with the package."""
    try:
        return __import__(module, fromlist=["_"])
    except ImportError as error:
        name = module.partition(".")[0]
        raise ImportError(f"{what} needs {name}, which is not installed: pip install {name}") from error
