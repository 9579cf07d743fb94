"""Seeds and orders of an experiment: the same for the same seed, on every machine and in every version of Python and numpy."""

from __future__ import annotations

import hashlib
import random
from collections.abc import Sequence
from typing import TypeVar

Item = TypeVar("Item")


def derive_seed(*parts: object) -> int:
    """A seed of 63 bits from a seed and what it is for: derive_seed(7, "trial", 12). SHA-256 of the texts of the parts, so that the seeds of
    neighbouring trials have nothing in common."""
    digest = hashlib.sha256("\x1f".join(map(str, parts)).encode()).digest()
    return int.from_bytes(digest[:8], "big") >> 1


def shuffled(items: Sequence[Item], seed: int) -> list[Item]:
    """The items in a random order. random.Random.random() is the same sequence for a seed in all versions of Python; shuffle() need not be."""
    generator = random.Random(seed)
    keys = [generator.random() for _ in items]
    return [items[i] for i in sorted(range(len(items)), key=keys.__getitem__)]


def shuffled_blocks(items: Sequence[Item], blocks: int, seed: int) -> list[list[Item]]:
    """Blocks that contain each item once, each block in a random order of its own: balanced after every block."""
    return [shuffled(items, derive_seed(seed, "block", block)) for block in range(blocks)]


def latin_square(size: int) -> list[list[int]]:
    """Orders of `size` conditions, one row for each participant. In the columns each condition occurs equally often, and so does each ordered
    pair of neighbours (E. J. Williams, Aust. J. Sci. Res. A 2, 149, 1949). An even number of conditions has that many rows, an odd one twice
    as many: the mirror image of each row is needed, too."""
    if size < 1:
        raise ValueError("a Latin square has at least one condition")
    first = [0]
    for step in range(1, size):
        first.append((step + 1) // 2 if step % 2 else size - step // 2)
    rows = [[(place + row) % size for place in first] for row in range(size)]
    return rows + [row[::-1] for row in rows] if size % 2 and size > 1 else rows


def order_for(conditions: Sequence[Item], participant: int) -> list[Item]:
    """The conditions in the order of this participant (0, 1, 2 ...), by the rows of latin_square() in turn."""
    rows = latin_square(len(conditions))
    return [conditions[place] for place in rows[participant % len(rows)]]
