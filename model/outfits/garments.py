"""Garments of the training families: how the measurements of each kind vary."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .pattern import Pattern

Rng = np.random.Generator
Neck = tuple[float, float, float, float, float]


def uniform(rng: Rng, low: float, high: float) -> float:
    return float(rng.uniform(low, high))


def draw_neck(rng: Rng, kinds: str) -> Neck:
    kind = str(rng.choice(kinds.split()))
    if kind == "scoop":
        return (
            uniform(rng, 1.38, 1.46),
            uniform(rng, 1.47, 1.53),
            uniform(rng, 0.095, 0.115),
            uniform(rng, 2.2, 3.0),
            2.4,
        )
    if kind == "v":
        return (uniform(rng, 1.32, 1.43), uniform(rng, 1.52, 1.545), uniform(rng, 0.085, 0.10), 1.15, 2.2)
    if kind == "boat":
        return (uniform(rng, 1.505, 1.525), 1.535, uniform(rng, 0.115, 0.135), 3.2, 3.2)
    if kind == "square":
        return (uniform(rng, 1.40, 1.45), uniform(rng, 1.47, 1.52), uniform(rng, 0.095, 0.11), 7.0, 5.0)
    if kind == "stand":
        return (uniform(rng, 1.553, 1.563), uniform(rng, 1.588, 1.602), 0.066, 2.0, 2.0)
    return (uniform(rng, 1.485, 1.52), uniform(rng, 1.535, 1.555), uniform(rng, 0.078, 0.092), 2.2, 2.2)


def tee(rng: Rng) -> Pattern:
    ease = uniform(rng, 0.010, 0.045)
    return Pattern(
        "T-shirt",
        "tee",
        hem=uniform(rng, 0.80, 1.02),
        chest=ease,
        waist=ease * uniform(rng, 0.8, 1.3),
        hip=ease,
        looseness=uniform(rng, 0.2, 1.0),
        neck=draw_neck(rng, "crew crew v scoop boat"),
        sleeve=uniform(rng, 0.11, 0.27),
        sleeve_ease=uniform(rng, 0.008, 0.035),
        cuff_ease=uniform(rng, 0.008, 0.045),
        hem_dip=uniform(rng, 0, 0.04),
    )


def shirt(rng: Rng) -> Pattern:
    ease = uniform(rng, 0.012, 0.040)
    return Pattern(
        "shirt",
        "shirt",
        hem=uniform(rng, 0.78, 0.96),
        chest=ease,
        waist=ease * uniform(rng, 0.7, 1.2),
        hip=ease,
        looseness=uniform(rng, 0.3, 1.0),
        neck=draw_neck(rng, "stand stand crew v"),
        sleeve=uniform(rng, 0.44, 0.53),
        sleeve_ease=uniform(rng, 0.010, 0.030),
        cuff_ease=uniform(rng, 0.005, 0.014),
        hem_dip=uniform(rng, 0, 0.05),
    )


def tank(rng: Rng) -> Pattern:
    ease = uniform(rng, 0.006, 0.030)
    tight = ease < 0.011
    return Pattern(
        "tank top",
        "tank",
        hem=uniform(rng, 0.84, 1.08),
        skin=0.004 if tight else 0.006,
        chest=ease,
        waist=ease,
        hip=ease,
        looseness=uniform(rng, 0.0, 0.4) if tight else uniform(rng, 0.2, 0.9),
        neck=draw_neck(rng, "scoop scoop square v"),
        strap=uniform(rng, 0.015, 0.055),
        armhole=uniform(rng, 0.0, 0.05),
    )


def trousers(rng: Rng) -> Pattern:
    thigh = uniform(rng, 0.008, 0.045)
    return Pattern(
        "trousers",
        "trousers",
        top=uniform(rng, 1.02, 1.13),
        hem=uniform(rng, 0.085, 0.30),
        waist=uniform(rng, 0.006, 0.012),
        hip=min(thigh, 0.02) + 0.002,
        thigh=thigh,
        leg_hem=uniform(rng, 0.008, 0.06),
        rise=uniform(rng, 0.006, 0.035),
        looseness=uniform(rng, 0.3, 1.0),
    )


def shorts(rng: Rng) -> Pattern:
    thigh = uniform(rng, 0.012, 0.05)
    long = replace(trousers(rng), name="shorts", kind="shorts", hem=uniform(rng, 0.50, 0.76), thigh=thigh)
    return replace(long, leg_hem=thigh * uniform(rng, 0.8, 1.4), hip=min(thigh, 0.022))


def straight_skirt(rng: Rng) -> Pattern:
    top = uniform(rng, 1.05, 1.15)
    return Pattern(
        "straight skirt",
        "skirt",
        top=top,
        hem=uniform(rng, 0.40, 0.66),
        waist=uniform(rng, 0.006, 0.010),
        hip=uniform(rng, 0.008, 0.02),
        looseness=uniform(rng, 0.0, 0.2),
        skirt_from=uniform(rng, 0.88, 0.96),
        flare=uniform(rng, -0.02, 0.06),
    )


def flared_skirt(rng: Rng) -> Pattern:
    top, depth = uniform(rng, 1.06, 1.17), uniform(rng, 0.0, 0.020)
    return Pattern(
        "flared skirt",
        "skirt",
        top=top,
        hem=uniform(rng, 0.20, 0.70),
        waist=0.007,
        hip=uniform(rng, 0.012, 0.03),
        looseness=0.1,
        skirt_from=top - uniform(rng, 0.03, 0.12),
        flare=uniform(rng, 0.12, 0.48),
        folds=int(rng.integers(6, 13)),
        fold_depth=depth,
        fold_phase=uniform(rng, 0, 6.28),
        hem_dip=uniform(rng, 0, 0.08) * (rng.random() < 0.3),
    )


def skirt(rng: Rng) -> Pattern:
    return straight_skirt(rng) if rng.random() < 0.4 else flared_skirt(rng)


def dress(rng: Rng) -> Pattern:
    base = (tank, tank, tee, shirt)[int(rng.integers(4))](rng)
    below = straight_skirt(rng) if rng.random() < 0.35 else flared_skirt(rng)
    start = uniform(rng, 1.05, 1.22) if below.name == "flared skirt" else below.skirt_from
    return replace(
        base,
        name="dress",
        kind="dress",
        hem=below.hem,
        skirt_from=start,
        flare=below.flare,
        folds=below.folds,
        fold_depth=below.fold_depth,
        fold_phase=below.fold_phase,
        looseness=uniform(rng, 0.0, 0.35),
        skin=0.006,
        hip=max(base.hip, 0.01),
        hem_dip=below.hem_dip,
    )


def jumpsuit(rng: Rng) -> Pattern:
    base = (tank, tee, shirt)[int(rng.integers(3))](rng)
    legs = shorts(rng) if rng.random() < 0.25 else trousers(rng)
    return replace(
        base,
        name="jumpsuit",
        kind="jumpsuit",
        hem=legs.hem,
        thigh=legs.thigh,
        leg_hem=legs.leg_hem,
        rise=legs.rise + 0.01,
        looseness=uniform(rng, 0.1, 0.6),
        hip=max(legs.hip, 0.012),
        hem_dip=0.0,
        skin=0.006,
    )


def jacket(rng: Rng) -> Pattern:
    ease = uniform(rng, 0.030, 0.055)
    return Pattern(
        "jacket",
        "jacket",
        hem=uniform(rng, 0.76, 1.0),
        chest=ease,
        waist=ease * uniform(rng, 0.7, 1.1),
        hip=ease,
        skin=0.010,
        looseness=uniform(rng, 0.3, 0.9),
        neck=(uniform(rng, 1.22, 1.46), 1.55, uniform(rng, 0.085, 0.10), uniform(rng, 1.0, 1.4), 2.2),
        sleeve=uniform(rng, 0.40, 0.53),
        sleeve_ease=uniform(rng, 0.024, 0.040),
        cuff_ease=uniform(rng, 0.015, 0.028),
        opening=uniform(rng, 0.02, 0.13),
    )
