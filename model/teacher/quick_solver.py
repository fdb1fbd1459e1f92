"""`newton`'s vertex block descent in a third of the time, for drapes to learn from on a CPU.

The same steps: sweeps over the colours of the cloth's vertices, each vertex moved by a Newton step of its own energy
and kept from meeting cloth that is near. What differs is the order in which a CPU does it (`lanes`, `self_contact`).
"""

from __future__ import annotations

import newton
import warp as wp
from newton.solvers import SolverVBD

from .lanes import Skin, lanes, solve_elasticity
from .self_contact import Near, Touch, gather, keep_apart, push_apart


class QuickSolver(SolverVBD):
    """Of cloth without damping and of one stiffness, on a body that does not move."""

    #: Steps that a look for contacts of the cloth must do for, and whether the next step looks.
    every, looking = 1, True

    def __init__(self, model: newton.Model, **settings: object) -> None:
        super().__init__(model, **settings)
        # Each vertex then knows its own contact with the skin.
        self._particle_contact_use_gather = True
        self.lanes, self.firsts = lanes(model)
        self.lame = float(model.tri_materials.numpy()[0, 0])
        found = self.trimesh_collision_info
        self.near, self.touch = Near(), Touch()
        self.near.edges = wp.zeros(len(found.edge_colliding_edges) // 2, dtype=wp.vec2i)
        self.near.corners = wp.zeros(len(found.vertex_colliding_triangles) // 2, dtype=wp.vec2i)
        self.near.counts = wp.zeros(2, dtype=int)
        self.near.edge_ends, self.near.triangles = model.edge_indices, model.tri_indices
        self.touch.distance, self.touch.stiffness = self.particle_self_contact_margin, model.soft_contact_ke
        self.touch.damping, self.touch.friction = model.soft_contact_kd, model.soft_contact_mu
        self.touch.slip, self.touch.parallel = self.friction_epsilon, self._self_contact_edge_edge_parallel_epsilon

    def _refresh_collision_sets(self, state: newton.State, dt: float, **detectors: bool) -> None:
        if self.looking:
            super()._refresh_collision_sets(state, dt, **detectors)
        else:
            self._reset_dat_references(state, reset_rigid_soft=False, reset_particles=True)

    def _collision_detection_penetration_free(self, current_state: newton.State, **settings: bool) -> None:
        super()._collision_detection_penetration_free(current_state, **settings)
        wp.launch(gather, dim=1, inputs=[self.trimesh_collision_info, self.near])

    def _solve_particle_iteration(
        self, state_in: newton.State, state_out: newton.State, contacts: newton.Contacts, dt: float
    ) -> None:
        self.particle_forces.zero_()
        self.particle_hessians.zero_()
        self.truncation_ts.fill_(1.0)
        now, skin, colours = state_in.particle_q, self._skin(contacts), self.model.particle_colors
        gamma = self.dat_conservative_bound_relaxation
        # Two vertices that were not near each other at the look must not meet before the next.
        most = 0.5 * gamma * self._self_contact_query_radius / self.every
        for colour, members in enumerate(self.model.particle_color_groups):
            wp.launch(push_apart, dim=1, inputs=[
                dt, colour, colours, self.near, self.touch, self.particle_q_prev, now, self.particle_forces,
                self.particle_hessians,
            ])  # fmt: skip
            first, end = self.firsts[colour], self.firsts[colour + 1]
            wp.launch(solve_elasticity, dim=end - first, inputs=[
                first, dt, self.lame, self.lanes, skin, self.particle_q_prev, now, self.inertia,
                self.model.particle_mass, self.particle_forces, self.particle_hessians, self.particle_displacements,
            ])  # fmt: skip
            wp.launch(keep_apart, dim=1, inputs=[
                colour, members, colours, self.near, gamma, most, self.pos_prev_collision_detection,
                self.truncation_ts, self.particle_displacements, now,
            ])  # fmt: skip
        wp.copy(state_out.particle_q, now)

    def _skin(self, contacts: newton.Contacts) -> Skin:
        skin, model = Skin(), self.model
        skin.first, skin.stiffness = self._particle_contact_head, self.body_particle_contact_penalty_k
        skin.points, skin.normals = contacts.soft_contact_body_pos, contacts.soft_contact_normal
        skin.radius, skin.damping = model.particle_radius, model.soft_contact_kd
        skin.friction, skin.slip = model.soft_contact_mu, self.friction_epsilon
        return skin
