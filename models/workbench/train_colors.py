"""Colours of plastic: of the parts, mostly as they are meant; of other things, any."""

from __future__ import annotations

import colorsys
from collections.abc import Sequence

import numpy as np

from snapfit.models.asset import Part

Rng = np.random.Generator
Rgb = tuple[int, int, int]

_OTHER_SHARE, _OWN_SHARE = 0.15, 0.03


def painted(parts: Sequence[Part], rng: Rng) -> dict[str, Rgb]:
    """A colour for each part: printed in the asset's plastics, sometimes in others.

    Parts that are of one colour stay so; hue, saturation and brightness of a plastic vary a
    little, and in one image of seven it is another plastic altogether.
    """
    other = rng.random() < _OTHER_SHARE
    plastics = dict.fromkeys(part.color_rgb for part in parts)
    shift = rng.normal(0, (0.012, 0.07, 0.07), (len(plastics), 3))
    used = {
        color: plastic(rng) if other else _shifted(color, shift[i])
        for i, color in enumerate(plastics)
    }
    return {
        part.name: plastic(rng) if rng.random() < _OWN_SHARE else used[part.color_rgb]
        for part in parts
    }


def plastic(rng: Rng) -> Rgb:
    """Black, gray, white, or coloured."""
    if rng.random() < 0.4:
        value = rng.choice((rng.uniform(0.08, 0.3), rng.uniform(0.3, 0.7), rng.uniform(0.7, 0.95)))
        return _bytes(0.0, abs(rng.normal(0, 0.04)), float(value))
    return _bytes(rng.random(), rng.uniform(0.3, 0.95), rng.uniform(0.25, 0.95))


def jittered(color: Rgb, rng: Rng) -> Rgb:
    """The same colour of another batch."""
    return _shifted(color, rng.normal(0, (0.004, 0.02, 0.02)))


def _shifted(color: Rgb, shift: np.ndarray) -> Rgb:
    hue, saturation, value = colorsys.rgb_to_hsv(*(each / 255 for each in color))
    return _bytes(hue + shift[0], saturation + shift[1], value * (1 + shift[2]))


def _bytes(hue: float, saturation: float, value: float) -> Rgb:
    saturation, value = float(np.clip(saturation, 0, 1)), float(np.clip(value, 0.03, 1))
    red, green, blue = colorsys.hsv_to_rgb(hue % 1.0, saturation, value)
    return round(red * 255), round(green * 255), round(blue * 255)
