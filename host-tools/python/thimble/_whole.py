"""Whole numbers that are given to the package."""

import operator
from typing import Any


def whole(what: str, value: Any, most: int, least: int = 0) -> int:
    """value as an int; what: its name in an error."""
    try:
        number = operator.index(value)
    except TypeError:
        raise TypeError(f"{what} is {value!r}: give a whole number from {least} to {most}") from None
    if not least <= number <= most:
        raise ValueError(f"{what} is {number}: give a whole number from {least} to {most}")
    return number
