"""Masks as run lengths in COCO's compact text form, a few hundred bytes a mask.

Runs go down the columns and begin with the length of nothing; each is written in characters of
five bits, from the third on as the difference to the last run of its kind. The format is that of
`rleToString` in the COCO API (https://github.com/cocodataset/cocoapi, common/maskApi.c).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

_BITS, _MORE, _SIGN, _FIRST = 5, 0x20, 0x10, 48


def encode_mask(mask: npt.NDArray[np.bool_]) -> str:
    """A mask (H, W) as text; its size is kept elsewhere."""
    columns = np.flatnonzero(mask.any(axis=0))
    if len(columns) == 0:
        return _text(np.array([mask.size]))
    left, right = int(columns[0]), int(columns[-1]) + 1
    # Only the columns that hold something are looked at; those before are empty.
    runs = np.concatenate([[False], mask[:, left:right].T.ravel(), [False]])
    changes = np.flatnonzero(runs[1:] != runs[:-1]) + left * mask.shape[0]
    ends = np.append(changes, mask.size) if changes[-1] != mask.size else changes
    return _text(np.diff(ends, prepend=0))


def decode_mask(text: str, height: int, width: int) -> npt.NDArray[np.bool_]:
    """The mask (H, W).

    Raises:
        ValueError: the text is damaged, or of a mask of another size.
    """
    counts = _counts(text)
    if min(counts, default=-1) < 0 or sum(counts) != height * width:
        raise ValueError(f"the run lengths are not those of a mask of {width}x{height} pixels")
    values = np.arange(len(counts)) % 2 == 1
    return np.repeat(values, counts).reshape(width, height).T


def _text(counts: npt.NDArray[np.int64]) -> str:
    written = counts.tolist()
    letters = []
    for i, count in enumerate(written):
        value = count - written[i - 2] if i > 2 else count
        more = True
        while more:
            bits = value & (_MORE - 1)
            value >>= _BITS
            more = value != (-1 if bits & _SIGN else 0)
            letters.append(chr(_FIRST + bits + (_MORE if more else 0)))
    return "".join(letters)


def _counts(text: str) -> list[int]:
    counts: list[int] = []
    value, shift = 0, 0
    for letter in text:
        bits = ord(letter) - _FIRST
        if not 0 <= bits < 2 * _MORE:
            raise ValueError(f"{letter!r} does not belong to run lengths")
        value |= (bits & (_MORE - 1)) << shift
        shift += _BITS
        if bits & _MORE:
            continue
        if bits & _SIGN:
            value -= 1 << shift
        counts.append(value + counts[-2] if len(counts) > 2 else value)
        value, shift = 0, 0
    if shift:
        raise ValueError("the run lengths break off")
    return counts
