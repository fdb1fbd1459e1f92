"""Cloth at rest on a posed body by physics: the teacher and judge of draping. World space, metres.

Vertex block descent (Chen et al., Vertex Block Descent, 2024) of `newton` with the fabric of the losses: Neo-Hookean
triangles whose small strains cost what the losses' springs cost, discrete-shell bending from the rest dihedral,
friction and contact with the body and of the cloth with itself, under the weight of the losses (`weight`). Time
steps lose some of their speed, so that cloth comes to rest instead of swinging.
"""

from __future__ import annotations

from dataclasses import dataclass

import newton
import numpy as np
import torch
import warp as wp
from newton._src.solvers.vbd import particle_vbd_kernels, solver_vbd
from newton.solvers import SolverVBD
from numpy.typing import NDArray

from fabric import Fabric
from garment.graph import mesh_edges
from garment.rest_mesh import rest_mesh, topology

from . import hinges
from .quick_solver import QuickSolver

CollisionSlot, Frequency = SolverVBD.CollisionSlot, SolverVBD.CollisionFrequencyType
Floats = NDArray[np.floating]
Ints = NDArray[np.integer]

# Or else it tells of every kernel that it loads.
wp.config.quiet = True
if not wp.get_device().is_cuda:
    # A GPU's four threads for the contacts of a vertex or edge are four walks on a CPU, one after the other.
    particle_vbd_kernels.NUM_THREADS_PER_COLLISION_PRIMITIVE = solver_vbd.NUM_THREADS_PER_COLLISION_PRIMITIVE = 1
hinges.use()


@dataclass(frozen=True)
class Stage:
    """Some time steps of one length."""

    step: float  # s; what the sweeps of a step do not undo of its fall stretches the cloth, so it must be short
    most: int  # steps at most
    keep: float  # share of its speed that cloth keeps from step to step
    least: int = 0  # steps before cloth may count as at rest
    looks: float = 2.0  # for contacts of cloth, a step; twice is again once its fall is known, or it falls less far


@dataclass(frozen=True)
class Settings:
    """Of one drape."""

    #: Cloth falls and slides, then comes to rest at its true length.
    stages: tuple[Stage, ...] = (Stage(0.004, 300, 0.99), Stage(0.002, 400, 0.96))
    iterations: int = 8  # sweeps over the vertices a step
    watch: float = 0.15  # s between looks at the residual
    still: float = 3e-4  # m that the vertices move on average between two looks when the cloth counts as at rest
    friction: float = 0.6  # of cloth on skin and on cloth
    slip: float = 5e-4  # m/s, speed up to which friction grows: cloth on a slope creeps slower than this
    least: float = 0.003  # m, distance kept from the skin by cloth that rests nearer
    radius: float = 0.005  # m, distance kept from the skin
    bulge: float = 0.06  # m, radius of the skin that a triangle bridges; its corners keep off by how far it would enter
    most_off: float = 0.008  # m that they keep off at most: more would squeeze cloth out from between the thighs
    layers: float = 0.0015  # m, distance that cloth keeps from cloth
    look: float = 0.0015  # m beyond it within which contacts of cloth with cloth are looked for
    contact: float = 2e3  # N/m, stiffness of a vertex on the skin
    damping: float = 1e-4  # of stretch (N s/m) and bending (N s), beside the speed that steps lose


#: Of cloth to learn from: in a tenth of the time it ends about as far from there as the judge from itself
#: (model/LOG.md).
QUICK = Settings(
    stages=(Stage(0.004, 100, 0.99, 100), Stage(0.002, 300, 0.96, 150, looks=0.5)), still=2e-3, damping=0.0
)


@dataclass(frozen=True)
class Resting:
    """Where cloth came to rest."""

    x: Floats  # (N, 3)
    residual: float  # m that the vertices moved on average between the last two looks
    steps: int


@dataclass(frozen=True)
class Cloth:
    """What drapes."""

    rest: Floats  # (N, 3) m, in the A-pose on the same body
    triangles: Ints  # (T, 3)
    distance: Floats  # (N,) m from the skin in the rest pose
    alone: NDArray[np.bool_]  # (N,) no other garment is near in the rest pose
    pull: Floats  # (N, 3) m/s2, weight that nothing bears (`weight`)
    held: Ints  # vertices that stay where they start: waistbands


def equilibrium(cloth: Cloth, start: Floats, body: tuple[Floats, Ints], s: Settings) -> Resting:
    """Lets cloth settle on a body, (V, 3) and (F, 3), from `start`, (N, 3) outside of it."""
    model = scene(cloth, body, s)
    moving = solver(model, s)
    now, then, control = model.state(), model.state(), model.control()
    now.particle_q.assign(start.astype(np.float32))
    for state in (now, then):
        state.particle_f.assign(model.particle_mass.numpy()[:, None] * cloth.pull.astype(np.float32))
    pipeline = newton.CollisionPipeline(model)
    contacts, seen, residual, count = pipeline.contacts(), start, np.inf, 0

    def recorded(before: newton.State, after: newton.State, step: float, looking: bool) -> wp.Graph:
        """A step without the time that Python takes to ask for each of its hundreds of kernels."""
        moving.looking = looking
        with wp.ScopedCapture() as capture:
            pipeline.collide(before, contacts)
            moving.step(before, after, control, contacts, step)
        return capture.graph

    for stage in s.stages:
        every = max(1, round(s.watch / stage.step))
        often = Frequency.PRE_POST_INIT if stage.looks > 1 else Frequency.PRE_INIT
        moving.set_collision_frequency(collision_frequency_type={CollisionSlot.SOFT_SELF_CONTACT: often})
        moving.every = 1 if stage.looks >= 1 else 2
        forth, back = recorded(now, then, stage.step, True), recorded(then, now, stage.step, stage.looks >= 1)
        for k in range(1, stage.most + 1):
            wp.capture_launch(forth)
            now, then, forth, back = then, now, back, forth
            now.particle_qd.assign(stage.keep * now.particle_qd.numpy())
            if k % every == 0:
                x = now.particle_q.numpy().copy()
                residual, seen = float(np.linalg.norm(x - seen, axis=1).mean()), x
                if k >= stage.least and not residual > s.still:
                    break
        count += k
    return Resting(now.particle_q.numpy().copy(), residual, count)


def solver(model: newton.Model, s: Settings) -> SolverVBD:
    """What moves a scene's cloth by a time step."""
    kind = SolverVBD if s.damping or wp.get_device().is_cuda else QuickSolver
    return kind(
        model, iterations=s.iterations, particle_enable_self_contact=True, particle_self_contact_margin=s.layers,
        particle_self_contact_gap=s.look, particle_rest_shape_contact_exclusion_radius=2 * s.layers,
        particle_topological_contact_filter_threshold=2, friction_epsilon=s.slip,
    )  # fmt: skip


def scene(cloth: Cloth, body: tuple[Floats, Ints], s: Settings) -> newton.Model:
    """Cloth in its rest pose and a body that does not move."""
    fabric, up = Fabric(), wp.quat_identity()
    # Springs of every direction and stiffness k cost as much as both Lamé parameters k / 8 do.
    lame = fabric.stretch / 8
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
    builder.add_cloth_mesh(
        pos=wp.vec3(0.0), rot=up, scale=1.0, vel=wp.vec3(0.0), vertices=[wp.vec3(*p) for p in cloth.rest.tolist()],
        indices=cloth.triangles.reshape(-1).tolist(), density=fabric.density, tri_ke=lame, tri_ka=lame,
        tri_kd=s.damping, edge_ke=fabric.bending, edge_kd=s.damping, particle_radius=s.radius,
    )  # fmt: skip
    for v in cloth.held.tolist():
        builder.particle_mass[v] = 0.0
        builder.particle_flags[v] &= ~int(newton.ParticleFlags.ACTIVE)
    skin = newton.ModelBuilder.ShapeConfig(mu=s.friction, ke=s.contact, kd=1e-3, gap=0.0)
    builder.add_shape_mesh(-1, mesh=newton.Mesh(body[0], body[1].reshape(-1), compute_inertia=False), cfg=skin)
    builder.color(include_bending=True)
    model = builder.finalize()
    model.soft_contact_ke, model.soft_contact_kd, model.soft_contact_mu = s.contact, 1e-3, s.friction
    model.particle_radius.assign(kept_off(cloth, s).astype(np.float32))
    _bend_as_losses(model, cloth, fabric)
    return model


def kept_off(cloth: Cloth, s: Settings) -> Floats:
    """Distance that each vertex keeps from the skin, (N,): enough for the middle of its longest edge.

    Among other garments there is no room for that, and the ones above cover what shows.
    """
    edges = mesh_edges(cloth.triangles)
    longest = np.zeros(len(cloth.rest))
    for ends in edges.T:
        np.maximum.at(longest, ends, np.linalg.norm(cloth.rest[edges[:, 0]] - cloth.rest[edges[:, 1]], axis=1))
    wanted = np.minimum(s.radius + cloth.alone * longest**2 / (8 * s.bulge), s.most_off)
    return np.clip(cloth.distance, s.least, wanted)


def _bend_as_losses(model: newton.Model, cloth: Cloth, fabric: Fabric) -> None:
    """Gives every hinge the stiffness |e|^2 / area of the losses; the solver multiplies by |e| itself."""
    mesh = rest_mesh(torch.as_tensor(cloth.rest, dtype=torch.float32), topology(cloth.triangles.astype(np.int64)))
    weight = {tuple(sorted(h)): w for h, w in zip(mesh.hinges[:, :2].tolist(), mesh.hinge_weight.tolist(), strict=True)}
    ends, lengths = model.edge_indices.numpy()[:, 2:], model.edge_rest_length.numpy()
    properties = model.edge_bending_properties.numpy()
    for i, (a, b) in enumerate(ends.tolist()):
        properties[i, 0] = fabric.bending * weight.get((min(a, b), max(a, b)), 0.0) / max(lengths[i], 1e-6)
    model.edge_bending_properties.assign(properties)
