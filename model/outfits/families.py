"""Families of outfits: which garments, in what order, and how their measurements vary.

A family is a function from a random generator to patterns, innermost first.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from .garments import (
    Rng,
    dress,
    flared_skirt,
    jacket,
    jumpsuit,
    shirt,
    shorts,
    skirt,
    straight_skirt,
    tank,
    tee,
    trousers,
    uniform,
)
from .garments_unseen import culottes, halter, leggings, poncho, tunic, waistcoat, wrap_skirt
from .ornaments import Trimming
from .pattern import Pattern, resized


def _tucked(top: Pattern, bottom: Pattern) -> list[Pattern]:
    waistband = bottom.top
    inner = replace(top, hem=waistband - 0.09, hem_dip=0.0, tucked=waistband, skin=0.005)
    return [inner, replace(bottom, waist=max(bottom.waist, 0.012), hip=max(bottom.hip, 0.016))]


def _over(bottom: Pattern, top: Pattern) -> list[Pattern]:
    return [bottom, replace(top, hem=min(top.hem, bottom.top - 0.03), hip=max(top.hip, bottom.hip + 0.006))]


def _under_jacket(top: Pattern) -> Pattern:
    return replace(
        top,
        chest=min(top.chest, 0.022),
        sleeve_ease=min(top.sleeve_ease, 0.014),
        looseness=0.5 * top.looseness,
        cuff_ease=min(top.cuff_ease, 0.010),
        hip=min(top.hip, 0.022),
        waist=min(top.waist, 0.022),
    )


def _jacket_over(rng: Rng, worn: list[Pattern]) -> list[Pattern]:
    return [*worn, jacket(rng)]


def _over_top(under: Pattern, top: Pattern) -> list[Pattern]:
    """One closed top over another, as long as that or shorter."""
    under = _under_jacket(under)
    return [under, replace(top, hem=max(top.hem, under.hem - 0.02), chest=max(top.chest, under.chest + 0.008))]


def _jacket_shirt_trousers(rng: Rng) -> list[Pattern]:
    top = _under_jacket((shirt, tee, tank)[int(rng.integers(3))](rng))
    pair = _tucked(top, trousers(rng)) if rng.random() < 0.5 else _over(trousers(rng), top)
    return _jacket_over(rng, pair)


def _collared(rng: Rng) -> Pattern:
    return replace(shirt(rng), neck=(1.558, 1.597, 0.066, 2.0, 2.0))


def _collar(rng: Rng) -> Trimming:
    return Trimming("collar", (uniform(rng, 0.030, 0.045), uniform(rng, 0.02, 0.05)), on=0)


def _shirt_tie(rng: Rng) -> list[Pattern | Trimming]:
    return [*_tucked(_collared(rng), trousers(rng)), Trimming("tie", (1.545, uniform(rng, 0.40, 0.52))), _collar(rng)]


def _bow(rng: Rng) -> Trimming:
    return Trimming("bow", (uniform(rng, -0.06, 0.06), uniform(rng, 1.10, 1.24), uniform(rng, 0.05, 0.09)))


def _lapelled(rng: Rng, under: Pattern) -> list[Pattern | Trimming]:
    top = replace(jacket(rng), neck=(uniform(rng, 1.22, 1.32), 1.55, 0.09, 1.2, 2.2))
    return [
        *_tucked(under, trousers(rng)),
        top,
        Trimming("lapels", (uniform(rng, 0.04, 0.07), uniform(rng, 1.1, 1.22)), on=2),
    ]


Family = Callable[[Rng], list[Pattern | Trimming]]
TRAIN: dict[str, Family] = {
    "tee": lambda r: [tee(r)],
    "shirt": lambda r: [shirt(r)],
    "tank": lambda r: [tank(r)],
    "trousers": lambda r: [trousers(r)],
    "shorts": lambda r: [shorts(r)],
    "straight_skirt": lambda r: [straight_skirt(r)],
    "flared_skirt": lambda r: [flared_skirt(r)],
    "dress": lambda r: [dress(r)],
    "dress_long": lambda r: [replace(dress(r), hem=uniform(r, 0.12, 0.4))],
    "jumpsuit": lambda r: [jumpsuit(r)],
    "tee_trousers": lambda r: _over(trousers(r), tee(r)),
    "tee_shorts": lambda r: _over(shorts(r), tee(r)),
    "tee_skirt": lambda r: _over(skirt(r), tee(r)),
    "tank_shorts": lambda r: _over(shorts(r), tank(r)),
    "shirt_trousers": lambda r: _over(trousers(r), shirt(r)),
    "tucked_shirt_trousers": lambda r: _tucked(shirt(r), trousers(r)),
    "tucked_tank_skirt": lambda r: _tucked(tank(r), skirt(r)),
    "tucked_shirt_skirt": lambda r: _tucked(shirt(r), skirt(r)),
    "jacket_shirt": lambda r: _jacket_over(r, [_under_jacket(shirt(r))]),
    "jacket_shirt_trousers": _jacket_shirt_trousers,
    "jacket_tank_skirt": lambda r: _jacket_over(r, _tucked(_under_jacket(tank(r)), skirt(r))),
    "jacket_dress": lambda r: _jacket_over(r, [_under_jacket(dress(r))]),
    "dress_trousers": lambda r: [trousers(r), dress(r)],
    "shirt_skirt": lambda r: _over(skirt(r), shirt(r)),
    "tee_over_shirt": lambda r: _over_top(shirt(r), tee(r)),
    "tank_over_tee_trousers": lambda r: [trousers(r), *_over_top(tee(r), tank(r))],
    "jacket_tee_shorts": lambda r: _jacket_over(r, _over(shorts(r), _under_jacket(tee(r)))),
}
ORNAMENTED: dict[str, Family] = {
    "collared_shirt_trousers": lambda r: [*_tucked(_collared(r), trousers(r)), _collar(r)],
    "shirt_tie_trousers": lambda r: _shirt_tie(r),
    "belted_dress": lambda r: [
        replace(dress(r), waist=0.012, looseness=0.1),
        Trimming("belt", (uniform(r, 1.10, 1.2), uniform(r, 0.025, 0.06))),
    ],
    "dress_bow": lambda r: [replace(dress(r), waist=0.012, looseness=0.1), _bow(r)],
    "lapelled_jacket": lambda r: _lapelled(r, _under_jacket(tee(r))),
}
TRAIN |= ORNAMENTED
VALIDATION: dict[str, Family] = {
    "poncho_trousers": lambda r: [trousers(r), poncho(r)],
    "waistcoat_shirt_trousers": lambda r: [*_tucked(_under_jacket(shirt(r)), trousers(r)), waistcoat(r)],
    "tunic_leggings": lambda r: _over(leggings(r), tunic(r)),
    "halter_culottes": lambda r: _tucked(halter(r), culottes(r)),
    "wrap_skirt_tank": lambda r: _tucked(tank(r), wrap_skirt(r)),
    "halter_dress": lambda r: [replace(dress(r), sleeve=None, neck=halter(r).neck, strap=0.09, armhole=0.03)],
}
# The common cases come more often.
TRAIN_ORDER = [
    *(f for f in TRAIN if f not in ORNAMENTED),
    "tee_trousers",
    "tee_shorts",
    "shirt_trousers",
    "tucked_shirt_trousers",
    "jacket_shirt_trousers",
    "dress",
    "jumpsuit",
    "tee_skirt",
]


def patterns(rng: Rng, family: str) -> list[Pattern | Trimming]:
    """Patterns and trimmings of one outfit of a family, innermost first, in a random size."""
    make = TRAIN.get(family) or VALIDATION[family]
    size = float(np.exp(rng.normal(0.0, 0.18)))
    pieces = enumerate(make(rng))
    made = [_safe(resized(p, size), layer) if isinstance(p, Pattern) else p for layer, p in pieces]
    wrinkle = uniform(rng, 0.0015, 0.004) * (rng.random() < 0.4)
    seed = int(rng.integers(1 << 16))
    return [replace(p, wrinkle=wrinkle, wrinkle_seed=seed) if isinstance(p, Pattern) else p for p in made]


def _safe(p: Pattern, layer: int) -> Pattern:
    """No ease may fall below the distance to the skin, nor a waistband into what is tucked under it."""
    low = max(p.skin, 0.013) if layer and p.top is not None else p.skin
    grown = {k: max(getattr(p, k), low) for k in ("chest", "waist", "hip", "sleeve_ease", "cuff_ease", "leg_hem")}
    return replace(p, **grown, thigh=None if p.thigh is None else max(p.thigh, low))
