"""Fabric materials: tiling base-colour textures drawn with numpy, and sheen.

A tile covers `tile` metres of cloth. Colours are sRGB in [0, 1].
"""

from __future__ import annotations

import io
from dataclasses import dataclass

import numpy as np
from PIL import Image
from scipy.ndimage import gaussian_filter

from .mesh import Array

PIXELS = 512
Colour = tuple[float, float, float]


@dataclass(frozen=True)
class Fabric:
    """One cloth: weave, colours, size of the tile in metres, roughness and sheen."""

    weave: str
    colours: tuple[Colour, ...]
    tile: float = 0.12
    roughness: float = 0.85
    sheen: float = 0.25
    seed: int = 1


def hex_colour(code: str) -> Colour:
    """'#rrggbb' as sRGB in [0, 1]."""
    return tuple(int(code[i : i + 2], 16) / 255 for i in (1, 3, 5))  # type: ignore[return-value]


def texture(fabric: Fabric) -> bytes:
    """JPEG bytes of the tiling base colour, 512 x 512."""
    rng = np.random.default_rng(fabric.seed)
    image = WEAVES[fabric.weave](fabric, rng)
    out = io.BytesIO()
    Image.fromarray((np.clip(image, 0, 1) * 255 + 0.5).astype(np.uint8)).save(out, "JPEG", quality=82, optimize=True)
    return out.getvalue()


def _grid() -> tuple[Array, Array]:
    return np.meshgrid(np.arange(PIXELS), np.arange(PIXELS))


def _noise(rng: np.random.Generator, along: float, across: float) -> Array:
    """Tiling noise of unit deviation, smoothed by (rows, columns) pixels."""
    n = gaussian_filter(rng.standard_normal((PIXELS, PIXELS)), (along, across), mode="wrap")
    return n / n.std()


def _threads(period: int) -> Array:
    """Plain weave: warp over weft like a chessboard, lit as small pillows, mean 0."""
    x, y = _grid()
    over = ((x // period) + (y // period)) % 2
    wx, wy = np.sin(np.pi * ((x % period) + 0.5) / period), np.sin(np.pi * ((y % period) + 0.5) / period)
    light = np.where(over == 1, wx, wy) * 0.7 + 0.3 * wx * wy
    return light - light.mean()


def _cloth(base: Array, rng: np.random.Generator, depth: float = 0.05, period: int = 4) -> Array:
    """Add thread relief and melange to a flat picture (512, 512, 3)."""
    melange = 0.5 * (_noise(rng, 9, 0.6) + _noise(rng, 0.6, 9))
    return base * (1 + depth * _threads(period) + 0.35 * depth * melange)[..., None]


def _flat(colour: Colour) -> Array:
    return np.broadcast_to(np.array(colour), (PIXELS, PIXELS, 3)).copy()


def _plain(fabric: Fabric, rng: np.random.Generator) -> Array:
    return _cloth(_flat(fabric.colours[0]), rng)


def _linen(fabric: Fabric, rng: np.random.Generator) -> Array:
    """Slubs: thick threads of random length in both directions."""
    slub = _noise(rng, 0.8, 26) + _noise(rng, 26, 0.8)
    return _cloth(_flat(fabric.colours[0]), rng, 0.07) * (1 + 0.030 * slub)[..., None]


def _denim(fabric: Fabric, rng: np.random.Generator) -> Array:
    """3/1 twill: dark warp, light weft showing on diagonals, with streaky dye."""
    x, y = _grid()
    diagonal = ((x + y) % 8) / 8
    weft = np.clip(1.4 * np.sin(2 * np.pi * diagonal) - 0.45, 0, 1) * (0.65 + 0.25 * _noise(rng, 1, 1))
    warp, light = np.array(fabric.colours[0]), np.array(fabric.colours[-1])
    base = warp + np.clip(weft, 0, 1)[..., None] * (light - warp)
    return base * (1 + 0.045 * _noise(rng, 40, 0.9))[..., None]


def _stripes(fabric: Fabric, rng: np.random.Generator) -> Array:
    """Horizontal stripes: second colour over a third of each of four repeats."""
    _, y = _grid()
    band = (y % 128) < 44
    return _cloth(np.where(band[..., None], fabric.colours[1], fabric.colours[0]), rng)


def _pinstripe(fabric: Fabric, rng: np.random.Generator) -> Array:
    x, _ = _grid()
    line = ((x % 64) < 3)[..., None]
    return _cloth(np.where(line, fabric.colours[1], fabric.colours[0]), rng, 0.04)


def _check(fabric: Fabric, rng: np.random.Generator) -> Array:
    """Gingham: where both bands cross the second colour is full, where one runs it is half."""
    x, y = _grid()
    both = ((x % 128) < 64).astype(float) + ((y % 128) < 64)
    a, b = np.array(fabric.colours[0]), np.array(fabric.colours[1])
    return _cloth(a + (both / 2)[..., None] * (b - a), rng)


def _plaid(fabric: Fabric, rng: np.random.Generator) -> Array:
    x, y = _grid()
    wide = 0.38 * (((x % 256) < 96).astype(float) + ((y % 256) < 96))
    a, b, c = (np.array(k) for k in fabric.colours)
    base = a + wide[..., None] * (b - a)
    thin = np.maximum(((x + 78) % 256) < 8, ((y + 78) % 256) < 8) * 0.6
    return _cloth(base + thin[..., None] * (c - base), rng, 0.06)


def _dots(fabric: Fabric, rng: np.random.Generator) -> Array:
    x, y = _grid()
    row = y // 64
    dx, dy = (x + 32 * (row % 2)) % 64 - 32, y % 64 - 32
    cover = np.clip(11.5 - np.hypot(dx, dy), 0, 1)[..., None]
    a, b = np.array(fabric.colours[0]), np.array(fabric.colours[1])
    return _cloth(a + cover * (b - a), rng, 0.03)


def _floral(fabric: Fabric, rng: np.random.Generator) -> Array:
    """Scattered five-petalled flowers with eyes and leaves, wrapped over the tile's edges."""
    image = _flat(fabric.colours[0])
    x, y = _grid()
    centres: list[Array] = []
    while len(centres) < 26:
        c = rng.uniform(0, PIXELS, 2)
        apart = [np.hypot(*((c - o + PIXELS / 2) % PIXELS - PIXELS / 2)) for o in centres]
        if min(apart, default=PIXELS) > 68:
            centres.append(c)
    for i, (cx, cy) in enumerate(centres):
        size, turn = rng.uniform(0.65, 1.1), rng.uniform(0, 6.28)
        dx, dy = (x - cx + 256) % PIXELS - 256, (y - cy + 256) % PIXELS - 256
        r, a = np.hypot(dx, dy) / (27 * size), np.arctan2(dy, dx) + turn
        leaf = np.clip(14 * (1.25 * np.abs(np.cos(a * 1.0 + 0.6)) ** 9 - r), 0, 1)
        petal = np.clip(12 * (0.62 + 0.38 * np.cos(5 * a) - r), 0, 1)
        eye = np.clip(12 * (0.20 - r), 0, 1)
        for cover, colour in ((leaf, fabric.colours[3]), (petal, fabric.colours[1 + i % 2]), (eye, fabric.colours[4])):
            image += cover[..., None] * (np.array(colour) - image)
    return _cloth(image, rng, 0.03)


def _knit(fabric: Fabric, rng: np.random.Generator) -> Array:
    """Stockinette: columns of V-shaped loops."""
    x, y = _grid()
    column = (x % 32) / 32 - 0.5
    leg = np.abs(column) * 2
    loop = (y / 32 - leg * 0.8) % 1
    light = np.sin(np.pi * loop) ** 0.7 * np.sin(np.pi * np.clip(leg, 0.02, 0.98)) ** 0.5
    return _flat(fabric.colours[0]) * (0.72 + 0.38 * light + 0.02 * _noise(rng, 1.5, 1.5))[..., None]


def _herringbone(fabric: Fabric, rng: np.random.Generator) -> Array:
    x, y = _grid()
    slant = np.where((x // 64) % 2 == 0, x, -x) + y
    cover = (0.5 + 0.5 * np.sin(2 * np.pi * slant / 16))[..., None]
    a, b = np.array(fabric.colours[0]), np.array(fabric.colours[1])
    return _cloth(a + cover * (b - a), rng, 0.05)


WEAVES = {
    "plain": _plain,
    "linen": _linen,
    "denim": _denim,
    "stripes": _stripes,
    "pinstripe": _pinstripe,
    "check": _check,
    "plaid": _plaid,
    "dots": _dots,
    "floral": _floral,
    "knit": _knit,
    "herringbone": _herringbone,
}
