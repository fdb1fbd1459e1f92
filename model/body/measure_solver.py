"""A body for given measurements: bounded, regularised least squares (Levenberg-Marquardt).

Unknowns x are the phenotypes in [0, 1] that are not fixed (age stays at the reference's unless given)
and the `measure-*` local changes in [-1, 1]. With m(x) in cm and kg and targets t, the solver minimises

    sum (m(x) - t)^2 + PHENOTYPE_PULL sum (x_p - 1/2)^2 + LOCAL_PULL sum x_l^2

so that what the measurements leave open stays average. Bounds: a projected step over the unknowns that
are not pushed against a bound (Kelley, Iterative Methods for Optimization, 1999, chapter 5).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from body.anny_body import AnnyBody
from body.measuring import Tape

Array = NDArray[np.float64]
SOLVED = ("gender", "muscle", "weight", "height", "proportions")
PHENOTYPE_PULL, LOCAL_PULL = 0.3, 0.1  # cm2
ITERATIONS, DAMPING, DAMPING_MOST = 25, 1e-3, 1e4
STEP = 1e-4  # half width of the central difference by a phenotype
ENOUGH = 1e-4  # relative decrease of the cost at which to stop


@dataclass(frozen=True)
class Solution:
    """The solved shape, and every measurement of it in cm and kg."""

    phenotypes: dict[str, float]
    local_changes: dict[str, float]
    achieved: dict[str, float]
    residuals: dict[str, float]  # achieved - requested, where requested
    iterations: int


class Problem:
    """Measurements requested of a body, as a function of the unknowns."""

    def __init__(self, body: AnnyBody, tape: Tape, requested: dict[str, float], fixed: dict[str, float]) -> None:
        self.body, self.tape, self.fixed = body, tape, fixed
        self.free = [name for name in SOLVED if name not in fixed]
        self.rows = [tape.names.index(name) for name in requested]
        self.targets = np.array(list(requested.values()))
        count, local = len(self.free), len(body.local_changes)
        self.low = np.concatenate([np.zeros(count), -np.ones(local)])
        self.high = np.ones(count + local)
        self.middle = np.concatenate([np.full(count, 0.5), np.zeros(local)])
        self.pull = np.concatenate([np.full(count, PHENOTYPE_PULL), np.full(local, LOCAL_PULL)])

    def shape(self, x: Array) -> tuple[dict[str, float], dict[str, float]]:
        """Phenotypes and local changes of the unknowns."""
        count = len(self.free)
        phenotypes = self.fixed | {n: float(v) for n, v in zip(self.free, x[:count], strict=True)}
        return phenotypes, {n: float(v) for n, v in zip(self.body.local_changes, x[count:], strict=True)}

    def coefficients(self, x: Array) -> Array:
        return self.body.coefficients(*self.shape(x))

    def cost(self, x: Array) -> float:
        misses = self.tape.measure(self.coefficients(x))[self.rows] - self.targets
        return float(misses @ misses + self.pull @ (x - self.middle) ** 2)

    def normal_equations(self, x: Array) -> tuple[Array, Array]:
        """Gauss-Newton matrix (N, N) and half the gradient (N,) of the cost."""
        values, rows = self.tape.with_jacobian(self.coefficients(x))
        jacobian = rows[self.rows] @ self.coefficient_jacobian(x)
        matrix = jacobian.T @ jacobian + np.diag(self.pull)
        return matrix, jacobian.T @ (values[self.rows] - self.targets) + self.pull * (x - self.middle)

    def coefficient_jacobian(self, x: Array) -> Array:
        """Derivatives of the shape coefficients by the unknowns, (K, N); at a kink, the mean of both sides."""
        count, local = len(self.free), len(self.body.local_changes)
        phenotypes = []
        for k in range(count):
            before, after = x.copy(), x.copy()
            before[k], after[k] = max(x[k] - STEP, 0.0), min(x[k] + STEP, 1.0)
            change = self.coefficients(after) - self.coefficients(before)
            phenotypes.append(change / (after[k] - before[k]))
        out = np.zeros((len(self.body.shape_basis), count + local))
        out[:, :count] = np.array(phenotypes).reshape(count, -1).T
        signs = np.sign(x[count:])
        first = len(out) - 2 * local
        for k in range(local):
            out[first + 2 * k, count + k] = (1 + signs[k]) / 2
            out[first + 2 * k + 1, count + k] = -(1 - signs[k]) / 2
        return out


def solve(body: AnnyBody, tape: Tape, requested: dict[str, float], fixed: dict[str, float] | None = None) -> Solution:
    """The body nearest to the requested measurements {name: cm or kg}, with some phenotypes fixed.

    Raises ValueError on a measurement that the tape does not know.
    """
    problem = Problem(body, tape, requested, fixed or {})
    x, damping = problem.middle.copy(), DAMPING
    cost, done = problem.cost(x), 0
    for done in range(1, ITERATIONS + 1):  # noqa: B007
        matrix, gradient = problem.normal_equations(x)
        before = cost
        while damping < DAMPING_MOST:
            trial = projected_step(problem, x, (matrix, gradient), damping)
            trial_cost = problem.cost(trial)
            if trial_cost < cost:
                x, cost, damping = trial, trial_cost, max(damping / 5, 1e-7)
                break
            damping *= 4
        if before - cost <= ENOUGH * before:
            break
    achieved = dict(zip(tape.names, tape.measure(problem.coefficients(x)).tolist(), strict=True))
    residuals = {name: achieved[name] - value for name, value in requested.items()}
    return Solution(*problem.shape(x), achieved, residuals, done)


def projected_step(problem: Problem, x: Array, equations: tuple[Array, Array], damping: float) -> Array:
    """The damped Gauss-Newton step over the unknowns that no bound holds, clamped to the bounds."""
    matrix, gradient = equations
    held = ((x <= problem.low) & (gradient > 0)) | ((x >= problem.high) & (gradient < 0))
    open_ = np.flatnonzero(~held)
    damped = matrix[np.ix_(open_, open_)] + damping * np.diag(np.diag(matrix)[open_])
    out = x.copy()
    out[open_] -= np.linalg.solve(damped, gradient[open_])
    return np.clip(out, problem.low, problem.high)
