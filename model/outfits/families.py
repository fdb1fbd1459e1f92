"""Families of outfits: which garments, in what order, and how their measurements vary.

A family is a function from a random generator to patterns, innermost first.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from .ornaments import Trimming
from .pattern import Pattern, resized

Rng = np.random.Generator
Neck = tuple[float, float, float, float, float]


def _u(rng: Rng, low: float, high: float) -> float:
    return float(rng.uniform(low, high))


def _neck(rng: Rng, kinds: str) -> Neck:
    kind = str(rng.choice(kinds.split()))
    if kind == "scoop":
        return (_u(rng, 1.38, 1.46), _u(rng, 1.47, 1.53), _u(rng, 0.095, 0.115), _u(rng, 2.2, 3.0), 2.4)
    if kind == "v":
        return (_u(rng, 1.32, 1.43), _u(rng, 1.52, 1.545), _u(rng, 0.085, 0.10), 1.15, 2.2)
    if kind == "boat":
        return (_u(rng, 1.505, 1.525), 1.535, _u(rng, 0.115, 0.135), 3.2, 3.2)
    if kind == "square":
        return (_u(rng, 1.40, 1.45), _u(rng, 1.47, 1.52), _u(rng, 0.095, 0.11), 7.0, 5.0)
    if kind == "stand":
        return (_u(rng, 1.553, 1.563), _u(rng, 1.585, 1.605), 0.09, 2.0, 2.0)
    return (_u(rng, 1.485, 1.52), _u(rng, 1.535, 1.555), _u(rng, 0.078, 0.092), 2.2, 2.2)


def tee(rng: Rng) -> Pattern:
    ease = _u(rng, 0.010, 0.045)
    return Pattern(
        "T-shirt", "tee", hem=_u(rng, 0.80, 1.02), chest=ease, waist=ease * _u(rng, 0.8, 1.3), hip=ease,
        looseness=_u(rng, 0.2, 1.0), neck=_neck(rng, "crew crew v scoop boat"), sleeve=_u(rng, 0.11, 0.27),
        sleeve_ease=_u(rng, 0.008, 0.035), cuff_ease=_u(rng, 0.008, 0.045), hem_dip=_u(rng, 0, 0.04),
    )  # fmt: skip


def shirt(rng: Rng) -> Pattern:
    ease = _u(rng, 0.012, 0.040)
    return Pattern(
        "shirt", "shirt", hem=_u(rng, 0.78, 0.96), chest=ease, waist=ease * _u(rng, 0.7, 1.2), hip=ease,
        looseness=_u(rng, 0.3, 1.0), neck=_neck(rng, "stand stand crew v"), sleeve=_u(rng, 0.44, 0.53),
        sleeve_ease=_u(rng, 0.010, 0.030), cuff_ease=_u(rng, 0.005, 0.014), hem_dip=_u(rng, 0, 0.05),
    )  # fmt: skip


def tank(rng: Rng) -> Pattern:
    ease = _u(rng, 0.006, 0.030)
    tight = ease < 0.011
    return Pattern(
        "tank top", "tank", hem=_u(rng, 0.84, 1.08), skin=0.004 if tight else 0.006, chest=ease, waist=ease, hip=ease,
        looseness=_u(rng, 0.0, 0.4) if tight else _u(rng, 0.2, 0.9), neck=_neck(rng, "scoop scoop square v"),
        strap=_u(rng, 0.015, 0.055), armhole=_u(rng, 0.0, 0.05),
    )  # fmt: skip


def trousers(rng: Rng) -> Pattern:
    thigh = _u(rng, 0.008, 0.045)
    return Pattern(
        "trousers", "trousers", top=_u(rng, 1.02, 1.13), hem=_u(rng, 0.085, 0.30), waist=_u(rng, 0.006, 0.012),
        hip=min(thigh, 0.02) + 0.002, thigh=thigh, leg_hem=_u(rng, 0.008, 0.06), rise=_u(rng, 0.006, 0.035),
        looseness=_u(rng, 0.3, 1.0),
    )  # fmt: skip


def shorts(rng: Rng) -> Pattern:
    thigh = _u(rng, 0.012, 0.05)
    long = replace(trousers(rng), name="shorts", kind="shorts", hem=_u(rng, 0.50, 0.76), thigh=thigh)
    return replace(long, leg_hem=thigh * _u(rng, 0.8, 1.4), hip=min(thigh, 0.022))


def straight_skirt(rng: Rng) -> Pattern:
    top = _u(rng, 1.05, 1.15)
    return Pattern(
        "straight skirt", "skirt", top=top, hem=_u(rng, 0.40, 0.66), waist=_u(rng, 0.006, 0.010),
        hip=_u(rng, 0.008, 0.02), looseness=_u(rng, 0.0, 0.2), skirt_from=_u(rng, 0.88, 0.96), flare=_u(rng, -0.02, 0.06),
    )  # fmt: skip


def flared_skirt(rng: Rng) -> Pattern:
    top, depth = _u(rng, 1.06, 1.17), _u(rng, 0.0, 0.020)
    return Pattern(
        "flared skirt", "skirt", top=top, hem=_u(rng, 0.20, 0.70), waist=0.007, hip=_u(rng, 0.012, 0.03), looseness=0.1,
        skirt_from=top - _u(rng, 0.03, 0.12), flare=_u(rng, 0.12, 0.48), folds=int(rng.integers(6, 13)), fold_depth=depth,
        fold_phase=_u(rng, 0, 6.28), hem_dip=_u(rng, 0, 0.08) * (rng.random() < 0.3),
    )  # fmt: skip


def skirt(rng: Rng) -> Pattern:
    return straight_skirt(rng) if rng.random() < 0.4 else flared_skirt(rng)


def dress(rng: Rng) -> Pattern:
    base = (tank, tank, tee, shirt)[int(rng.integers(4))](rng)
    below = straight_skirt(rng) if rng.random() < 0.35 else flared_skirt(rng)
    start = _u(rng, 1.05, 1.22) if below.name == "flared skirt" else below.skirt_from
    return replace(
        base, name="dress", kind="dress", hem=below.hem, skirt_from=start, flare=below.flare, folds=below.folds,
        fold_depth=below.fold_depth, fold_phase=below.fold_phase, looseness=_u(rng, 0.0, 0.35), skin=0.006,
        hip=max(base.hip, 0.01), hem_dip=below.hem_dip,
    )  # fmt: skip


def jumpsuit(rng: Rng) -> Pattern:
    base = (tank, tee, shirt)[int(rng.integers(3))](rng)
    legs = shorts(rng) if rng.random() < 0.25 else trousers(rng)
    return replace(
        base, name="jumpsuit", kind="jumpsuit", hem=legs.hem, thigh=legs.thigh, leg_hem=legs.leg_hem,
        rise=legs.rise + 0.01, looseness=_u(rng, 0.1, 0.6), hip=max(legs.hip, 0.012), hem_dip=0.0, skin=0.006,
    )  # fmt: skip


def jacket(rng: Rng) -> Pattern:
    ease = _u(rng, 0.030, 0.055)
    return Pattern(
        "jacket", "jacket", hem=_u(rng, 0.76, 1.0), chest=ease, waist=ease * _u(rng, 0.7, 1.1), hip=ease, skin=0.010,
        looseness=_u(rng, 0.3, 0.9), neck=(_u(rng, 1.22, 1.46), 1.55, _u(rng, 0.085, 0.10), _u(rng, 1.0, 1.4), 2.2),
        sleeve=_u(rng, 0.40, 0.53), sleeve_ease=_u(rng, 0.024, 0.040), cuff_ease=_u(rng, 0.015, 0.028),
        opening=_u(rng, 0.02, 0.13),
    )  # fmt: skip


def _tucked(top: Pattern, bottom: Pattern) -> list[Pattern]:
    waistband = bottom.top
    inner = replace(top, hem=waistband - 0.09, hem_dip=0.0, tucked=waistband, skin=0.005)
    return [inner, replace(bottom, waist=max(bottom.waist, 0.012), hip=max(bottom.hip, 0.016))]


def _over(bottom: Pattern, top: Pattern) -> list[Pattern]:
    return [bottom, replace(top, hem=min(top.hem, bottom.top - 0.03), hip=max(top.hip, bottom.hip + 0.006))]


def _under_jacket(top: Pattern) -> Pattern:
    return replace(top, chest=min(top.chest, 0.022), sleeve_ease=min(top.sleeve_ease, 0.014), looseness=0.5 * top.looseness,
                   cuff_ease=min(top.cuff_ease, 0.010), hip=min(top.hip, 0.022), waist=min(top.waist, 0.022))  # fmt: skip


def _jacket_over(rng: Rng, worn: list[Pattern]) -> list[Pattern]:
    return [*worn, jacket(rng)]


def _jacket_shirt_trousers(rng: Rng) -> list[Pattern]:
    top = _under_jacket((shirt, tee, tank)[int(rng.integers(3))](rng))
    pair = _tucked(top, trousers(rng)) if rng.random() < 0.5 else _over(trousers(rng), top)
    return _jacket_over(rng, pair)


def _poncho(rng: Rng) -> Pattern:
    return Pattern("poncho", "poncho", hem=_u(rng, 1.17, 1.25), cape=True, chest=0.03, skin=0.010, flare=_u(rng, 0.05, 0.2),
                   neck=_neck(rng, "crew v boat"), folds=int(rng.integers(5, 9)), fold_depth=_u(rng, 0, 0.012),
                   fold_phase=_u(rng, 0, 6.28))  # fmt: skip


def _waistcoat(rng: Rng) -> Pattern:
    return Pattern("waistcoat", "waistcoat", hem=_u(rng, 0.92, 1.0), chest=0.026, waist=0.02, hip=0.03, skin=0.012, looseness=0.2,
                   neck=(_u(rng, 1.2, 1.32), 1.53, 0.10, 1.1, 2.2), strap=_u(rng, 0.02, 0.05), armhole=_u(rng, 0.02, 0.06),
                   opening=_u(rng, 0.012, 0.05))  # fmt: skip


def _tunic(rng: Rng) -> Pattern:
    return replace(tee(rng), name="tunic", kind="tunic", hem=_u(rng, 0.58, 0.72), split=_u(rng, 0.78, 0.9), looseness=0.9,
                   sleeve=_u(rng, 0.3, 0.45), cuff_ease=_u(rng, 0.035, 0.07), hem_dip=0.0)  # fmt: skip


def _culottes(rng: Rng) -> Pattern:
    return replace(trousers(rng), name="culottes", kind="culottes", hem=_u(rng, 0.42, 0.55), thigh=0.05,
                   leg_hem=_u(rng, 0.07, 0.10), top=1.12)  # fmt: skip


def _halter(rng: Rng) -> Pattern:
    return replace(tank(rng), name="halter top", kind="halter", neck=(_u(rng, 1.48, 1.52), 1.36, 0.075, 2.0, 4.0),
                   strap=_u(rng, 0.08, 0.10), armhole=0.03)  # fmt: skip


def _wrap_skirt(rng: Rng) -> Pattern:
    return replace(flared_skirt(rng), name="wrap skirt", kind="wrap skirt", hem=_u(rng, 0.25, 0.5), split=_u(rng, 0.7, 0.85),
                   flare=_u(rng, 0.05, 0.2), hem_dip=0.0)  # fmt: skip


def _leggings(rng: Rng) -> Pattern:
    return Pattern("leggings", "leggings", top=1.10, hem=_u(rng, 0.11, 0.4), skin=0.004, waist=0.004, hip=0.005, thigh=0.004,
                   leg_hem=0.004, rise=0.004, looseness=0.0)  # fmt: skip


def _collared(rng: Rng) -> Pattern:
    return replace(shirt(rng), neck=(1.558, 1.595, 0.09, 2.0, 2.0))


def _collar(rng: Rng) -> Trimming:
    return Trimming("collar", (_u(rng, 0.030, 0.045), _u(rng, 0.02, 0.05)), on=0)


def _shirt_tie(rng: Rng) -> list[Pattern | Trimming]:
    return [*_tucked(_collared(rng), trousers(rng)), Trimming("tie", (1.545, _u(rng, 0.40, 0.52))), _collar(rng)]


def _bow(rng: Rng) -> Trimming:
    return Trimming("bow", (_u(rng, -0.06, 0.06), _u(rng, 1.10, 1.24), _u(rng, 0.05, 0.09)))


def _lapelled(rng: Rng, under: Pattern) -> list[Pattern | Trimming]:
    top = replace(jacket(rng), neck=(_u(rng, 1.22, 1.32), 1.55, 0.09, 1.2, 2.2))
    return [*_tucked(under, trousers(rng)), top, Trimming("lapels", (_u(rng, 0.04, 0.07), _u(rng, 1.1, 1.22)), on=2)]


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
    "dress_long": lambda r: [replace(dress(r), hem=_u(r, 0.12, 0.4))],
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
}
ORNAMENTED: dict[str, Family] = {
    "collared_shirt_trousers": lambda r: [*_tucked(_collared(r), trousers(r)), _collar(r)],
    "shirt_tie_trousers": lambda r: _shirt_tie(r),
    "belted_dress": lambda r: [replace(dress(r), waist=0.012, looseness=0.1), Trimming("belt", (_u(r, 1.10, 1.2), _u(r, 0.025, 0.06)))],
    "dress_bow": lambda r: [replace(dress(r), waist=0.012, looseness=0.1), _bow(r)],
    "lapelled_jacket": lambda r: _lapelled(r, _under_jacket(tee(r))),
}
TRAIN |= ORNAMENTED
VALIDATION: dict[str, Family] = {
    "poncho_trousers": lambda r: [trousers(r), _poncho(r)],
    "waistcoat_shirt_trousers": lambda r: [*_tucked(_under_jacket(shirt(r)), trousers(r)), _waistcoat(r)],
    "tunic_leggings": lambda r: _over(_leggings(r), _tunic(r)),
    "halter_culottes": lambda r: _tucked(_halter(r), _culottes(r)),
    "wrap_skirt_tank": lambda r: _tucked(tank(r), _wrap_skirt(r)),
    "halter_dress": lambda r: [replace(dress(r), sleeve=None, neck=_halter(r).neck, strap=0.09, armhole=0.03)],
}
# The common cases come more often.
TRAIN_ORDER = [*(f for f in TRAIN if f not in ORNAMENTED), "tee_trousers", "tee_shorts", "shirt_trousers", "tucked_shirt_trousers", "jacket_shirt_trousers",
               "dress", "jumpsuit", "tee_skirt"]  # fmt: skip


def patterns(rng: Rng, family: str) -> list[Pattern | Trimming]:
    """Patterns and trimmings of one outfit of a family, innermost first, in a random size."""
    make = TRAIN.get(family) or VALIDATION[family]
    size = float(np.exp(rng.normal(0.0, 0.18)))
    pieces = enumerate(make(rng))
    return [_safe(resized(p, size), layer) if isinstance(p, Pattern) else p for layer, p in pieces]


def _safe(p: Pattern, layer: int) -> Pattern:
    """No ease may fall below the distance to the skin, nor a waistband into what is tucked under it."""
    low = max(p.skin, 0.013) if layer and p.top is not None else p.skin
    grown = {k: max(getattr(p, k), low) for k in ("chest", "waist", "hip", "sleeve_ease", "cuff_ease", "leg_hem")}
    return replace(p, **grown, thigh=None if p.thigh is None else max(p.thigh, low))
