"""`newton`'s vertex block descent in a third of the time, for drapes to learn from on a CPU.

The same steps: sweeps over the colours of the cloth's vertices, each vertex moved by a Newton step of its own energy
and kept from meeting cloth that is near. What differs is the order in which a CPU does it (`lanes`, `self_contact`).
"""

from __future__ import annotations

import newton
import numpy as np
import warp as wp
from newton.solvers import SolverVBD
from numpy.typing import NDArray
from scipy.sparse import csr_array

from .lanes import Skin, lanes, solve_elasticity
from .self_contact import Near, Search, Touch, find_corners, find_edges, keep_apart, push_apart

#: Pairs that a look may find for each edge and vertex, more than ever were.
ROOM = 8


class QuickSolver(SolverVBD):
    """Of cloth without damping and of one stiffness, on a body that does not move."""

    #: Steps that a look for contacts of the cloth must do for, and whether the next step looks.
    every, looking = 1, True

    def __init__(self, model: newton.Model, **settings: object) -> None:
        # What is around each edge and vertex is listed here (`_search`), in a hundredth of the time.
        super().__init__(model, **settings | {"particle_topological_contact_filter_threshold": 1})
        # Each vertex then knows its own contact with the skin.
        self._particle_contact_use_gather = True
        self.lanes, self.firsts = lanes(model)
        self.lame = float(model.tri_materials.numpy()[0, 0])
        self.near, self.touch, self.search = self._near(), self._touch(), self._search()
        self.all = wp.array(np.arange(model.particle_count), dtype=int)

    def _near(self) -> Near:
        near, model = Near(), self.model
        near.edges = wp.zeros(ROOM * model.edge_count, dtype=wp.vec2i)
        near.corners = wp.zeros(ROOM * model.particle_count, dtype=wp.vec2i)
        near.counts = wp.zeros(2, dtype=int)
        near.edge_ends, near.triangles = model.edge_indices, model.tri_indices
        return near

    def _touch(self) -> Touch:
        touch, model = Touch(), self.model
        touch.distance, touch.stiffness = self.particle_self_contact_margin, model.soft_contact_ke
        touch.damping, touch.friction = model.soft_contact_kd, model.soft_contact_mu
        touch.slip, touch.parallel = self.friction_epsilon, self._self_contact_edge_edge_parallel_epsilon
        return touch

    def _search(self) -> Search:
        search, model = Search(), self.model
        search.reach = self._self_contact_query_radius
        search.least = self.particle_rest_shape_contact_exclusion_radius
        search.parallel, search.rest = self._self_contact_edge_edge_parallel_epsilon, self.particle_q_rest
        ends = _incidence(model.edge_indices.numpy()[:, 2:], model.particle_count)
        corners = _incidence(model.tri_indices.numpy(), model.particle_count)
        beside = ends.T @ ends
        search.edges_by_edge, search.edge_rows = _table(ends @ beside @ ends.T)
        search.triangles_by_vertex, search.vertex_rows = _table(beside @ corners.T)
        return search

    def _refresh_collision_sets(self, state: newton.State, dt: float, **detectors: bool) -> None:
        if self.looking:
            super()._refresh_collision_sets(state, dt, **detectors)
        else:
            self._reset_dat_references(state, reset_rigid_soft=False, reset_particles=True)

    def _collision_detection_penetration_free(
        self, current_state: newton.State, *, reset_reference: bool = True
    ) -> None:
        assert not reset_reference
        trees, x = self.trimesh_collision_detector, current_state.particle_q
        trees.refit(x)
        self.near.counts.zero_()
        wp.launch(find_edges, dim=self.model.edge_count, inputs=[trees.bvh_edges.id, self.search, x, self.near])
        wp.launch(find_corners, dim=len(x), inputs=[trees.bvh_tris.id, self.search, x, self.near])

    def _penetration_free_truncation(self, state: newton.State, contacts: newton.Contacts | None) -> None:
        self.truncation_ts.fill_(1.0)
        self._keep_apart(-1, self.all, state.particle_q)

    def _keep_apart(self, colour: int, members: wp.array, now: wp.array) -> None:
        # Two vertices that were not near each other at the look must not meet before the next.
        gamma = self.dat_conservative_bound_relaxation
        most = 0.5 * gamma * self._self_contact_query_radius / self.every
        wp.launch(keep_apart, dim=1, inputs=[
            colour, members, self.model.particle_colors, self.near, gamma, most, self.pos_prev_collision_detection,
            self.truncation_ts, self.particle_displacements, now,
        ])  # fmt: skip

    def _solve_particle_iteration(
        self, state_in: newton.State, state_out: newton.State, contacts: newton.Contacts, dt: float
    ) -> None:
        self.particle_forces.zero_()
        self.particle_hessians.zero_()
        now, skin, colours = state_in.particle_q, self._skin(contacts), self.model.particle_colors
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
            self._keep_apart(colour, members, now)
        wp.copy(state_out.particle_q, now)

    def _skin(self, contacts: newton.Contacts) -> Skin:
        skin, model = Skin(), self.model
        skin.first, skin.stiffness = self._particle_contact_head, self.body_particle_contact_penalty_k
        skin.points, skin.normals = contacts.soft_contact_body_pos, contacts.soft_contact_normal
        skin.radius, skin.damping = model.particle_radius, model.soft_contact_kd
        skin.friction, skin.slip = model.soft_contact_mu, self.friction_epsilon
        return skin


def _incidence(vertices: NDArray[np.integer], count: int) -> csr_array:
    """(K, N) of the vertices (K, ...) of edges or triangles among N."""
    rows = np.repeat(np.arange(len(vertices)), vertices.shape[1])
    return csr_array((np.ones(rows.size, np.int32), (rows, vertices.ravel())), (len(vertices), count))


def _table(of: csr_array) -> tuple[wp.array, wp.array]:
    """Columns that each row has, and where each row's begin."""
    of = of.tocsr()
    return wp.array(of.indices, dtype=int), wp.array(of.indptr, dtype=int)
