"""What cloth is made of, for losses, relaxation and the simulator."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Fabric:
    """Constants of a light woven cloth."""

    density: float = 0.3  # kg/m2
    stretch: float = 400.0  # N/m
    stiffening: float = 1.0  # times the stretch stiffness, added beyond `limit`
    limit: float = 0.15  # strain at which woven cloth locks
    compression: float = 0.2  # share of the stretch stiffness that resists shortening until cloth buckles
    buckling: float = 0.005  # shortening at which free cloth buckles: from there the force stays the same
    confined: float = 0.1  # the same for cloth on the skin, which has room for short folds only
    room: float = 0.03  # m from the skin over which folds grow long
    crumple: float = 0.6  # shortening at which folds touch each other
    bending: float = 3e-5  # N m
    contact: float = 4e5  # J/m4, penalty of penetration
    deep: float = 0.03  # m, depth from which the penalty grows linearly
    thickness: float = 0.004  # m, distance kept from the skin
    least: float = 0.0025  # m, distance kept by cloth that rests nearer
    gravity: float = 9.81  # m/s2
    friction: float = 160.0  # N/m3, resistance to slip where the skin faces up
    resting: float = 0.06  # m from the skin within which cloth rests on it
    hang: float = 0.03  # m from the skin over which cloth begins to hang by itself
