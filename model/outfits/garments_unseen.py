"""Garments that only the validation families have."""

from __future__ import annotations

from dataclasses import replace

from .garments import Rng, draw_neck, flared_skirt, tank, tee, trousers, uniform
from .pattern import Pattern


def poncho(rng: Rng) -> Pattern:
    return Pattern(
        "poncho",
        "poncho",
        hem=uniform(rng, 1.17, 1.25),
        cape=True,
        chest=0.03,
        skin=0.010,
        flare=uniform(rng, 0.05, 0.2),
        neck=draw_neck(rng, "crew v boat"),
        folds=int(rng.integers(5, 9)),
        fold_depth=uniform(rng, 0, 0.012),
        fold_phase=uniform(rng, 0, 6.28),
    )


def waistcoat(rng: Rng) -> Pattern:
    return Pattern(
        "waistcoat",
        "waistcoat",
        hem=uniform(rng, 0.92, 1.0),
        chest=0.026,
        waist=0.02,
        hip=0.03,
        skin=0.012,
        looseness=0.2,
        neck=(uniform(rng, 1.2, 1.32), 1.53, 0.10, 1.1, 2.2),
        strap=uniform(rng, 0.02, 0.05),
        armhole=uniform(rng, 0.02, 0.06),
        opening=uniform(rng, 0.012, 0.05),
    )


def tunic(rng: Rng) -> Pattern:
    return replace(
        tee(rng),
        name="tunic",
        kind="tunic",
        hem=uniform(rng, 0.58, 0.72),
        split=uniform(rng, 0.78, 0.9),
        looseness=0.9,
        sleeve=uniform(rng, 0.3, 0.45),
        cuff_ease=uniform(rng, 0.035, 0.07),
        hem_dip=0.0,
    )


def culottes(rng: Rng) -> Pattern:
    return replace(
        trousers(rng),
        name="culottes",
        kind="culottes",
        hem=uniform(rng, 0.42, 0.55),
        thigh=0.05,
        leg_hem=uniform(rng, 0.07, 0.10),
        top=1.12,
    )


def halter(rng: Rng) -> Pattern:
    return replace(
        tank(rng),
        name="halter top",
        kind="halter",
        neck=(uniform(rng, 1.48, 1.52), 1.36, 0.075, 2.0, 4.0),
        strap=uniform(rng, 0.08, 0.10),
        armhole=0.03,
    )


def wrap_skirt(rng: Rng) -> Pattern:
    return replace(
        flared_skirt(rng),
        name="wrap skirt",
        kind="wrap skirt",
        hem=uniform(rng, 0.25, 0.5),
        split=uniform(rng, 0.7, 0.85),
        flare=uniform(rng, 0.05, 0.2),
        hem_dip=0.0,
    )


def leggings(rng: Rng) -> Pattern:
    return Pattern(
        "leggings",
        "leggings",
        top=1.10,
        hem=uniform(rng, 0.11, 0.4),
        skin=0.004,
        waist=0.004,
        hip=0.005,
        thigh=0.004,
        leg_hem=0.004,
        rise=0.004,
        looseness=0.0,
    )
