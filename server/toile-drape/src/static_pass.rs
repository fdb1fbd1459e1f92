//! The static pass: everything of an outfit that does not depend on pose or body shape.

use glam::Vec3;
use toile_geometry::body::{Body, BodyShape};
use toile_geometry::mesh::{Adjacency, edges};
use toile_geometry::normals::vertex_normals;

use crate::binding::{CANDIDATES, Weights, body_links, node_prior};
use crate::error::DrapeError;
use crate::features::node_features;
use crate::fitted::FittedShapes;
use crate::graph::{Links, OutfitGraph};
use crate::layers::{LayerContacts, layer_contacts};
use crate::methods::deepsd;
use crate::network::Networks;
use crate::ornaments::Riders;
use crate::outfit::Outfit;
use crate::push_out::{Field, followers};
use crate::reference::{Limb, ReferenceBody};
use crate::refine::Refined;
use crate::repair::{garment_of_vertex, outfit_ring, repaired};
use crate::settle::SettleTables;
use crate::shape::carried_to_reference;
use crate::stretch::interleaved;

/// Version of the stored form; part of the address of every static pass.
pub const STATIC_FORMAT: u32 = 10;
/// Skin weights of a vertex (glTF allows four).
pub const INFLUENCES: usize = 4;

/// What the networks say about an outfit once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rig {
    /// Joints of each vertex over the garment skeleton.
    pub joints: Vec<[u8; INFLUENCES]>,
    /// Their weights, summing to 1.
    pub weights: Vec<[f32; INFLUENCES]>,
    /// The same, of the body alone, diffused: what plain skinning uses.
    pub prior_joints: Vec<[u8; INFLUENCES]>,
    /// Their weights, summing to 1.
    pub prior_weights: Vec<[f32; INFLUENCES]>,
    /// Basis of the pose-space deformation, row-major (basis vectors, 3 x nodes), metres, rest space.
    pub basis: Vec<f32>,
    /// Descriptors of the nodes, row-major (nodes, width).
    pub descriptors: Vec<f32>,
}

/// Nodes of the canonical graph as something to be skinned by the body's own weights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodeRig {
    /// Positions, rest space, metres.
    pub positions: Vec<Vec3>,
    /// Garment of each node, innermost first.
    pub garment: Vec<u32>,
    /// Joints of each node over the garment skeleton.
    pub joints: Vec<[u8; INFLUENCES]>,
    /// Their weights, summing to 1.
    pub weights: Vec<[f32; INFLUENCES]>,
}

/// Everything of an outfit that does not depend on pose or body shape. Rest space on the reference body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StaticPass {
    /// Mended rest positions, welded order, metres.
    pub rest: Vec<Vec3>,
    /// Signed distance of each rest vertex to the skin, metres.
    pub clearance: Vec<f32>,
    /// What the networks say.
    pub rig: Rig,
    /// The nodes.
    pub nodes: NodeRig,
    /// Vertices from nodes.
    pub vertex_from_node: Links,
    /// Touching nodes.
    pub near: Links,
    /// Vertices of each node.
    pub followers: Adjacency,
    /// [`CANDIDATES`] body vertices a node.
    pub candidates: Vec<u32>,
    /// Displacement of a node from displacements of the body's.
    pub shape: Links,
    /// Outer garments over inner ones.
    pub layers: LayerContacts,
    /// Where it folds, and what of it falls together.
    pub settle: SettleTables,
    /// Edges, each once, in the order of [`interleaved`].
    pub edges: Vec<[u32; 2]>,
    /// Edges as neighbours.
    pub ring: Adjacency,
    /// Rest poses on recently asked shapes.
    pub fitted_shapes: FittedShapes,
}

impl StaticPass {
    /// Runs the static pass of every method on an outfit fitted on the given shape.
    ///
    /// # Errors
    /// When a network fails or answers with an unexpected shape.
    pub fn compute(
        outfit: &Outfit,
        body: &Body,
        fitted_on: &BodyShape,
        networks: &mut dyn Networks,
    ) -> Result<Self, DrapeError> {
        let reference = ReferenceBody::new(body)?;
        Self::compute_on(outfit, &reference, body, fitted_on, networks)
    }

    /// As [`Self::compute`], on a reference body made before.
    ///
    /// # Errors
    /// When a network fails or answers with an unexpected shape.
    pub fn compute_on(
        outfit: &Outfit,
        reference: &ReferenceBody,
        body: &Body,
        fitted_on: &BodyShape,
        networks: &mut dyn Networks,
    ) -> Result<Self, DrapeError> {
        let placed = carried_to_reference(outfit, reference, body, fitted_on);
        let rest = repaired(outfit, &placed, reference);
        let fine = Refined::new(&rest, &outfit.triangles);
        let garment = garment_of_vertex(outfit);
        let mut graph = OutfitGraph::new(&fine.positions, &fine.triangles, &fine.spread(&garment));
        graph.vertex_from_node.keep(rest.len());
        let ring = outfit_ring(outfit);
        let riders = Riders::new(&graph, &fine, &rest, &ring, &garment);
        let prior = node_prior(&graph, reference);
        let features = node_features(
            &graph,
            &vertex_normals(&fine.positions, &fine.triangles),
            &prior,
            &fine.spread(&layer_of_vertex(outfit)),
            reference,
        );
        let rig = deepsd::static_pass(&graph, &features, &prior, &riders, networks)?;
        let limbs: Vec<Limb> = prior.iter().map(|w| reference.limb(w)).collect();
        let (candidates, shape) = body_links(&graph.nodes.positions, &limbs, reference);
        let (joints, weights) = largest_influences(&prior);
        let layers = layer_contacts(outfit, &rest);
        let room = room(&graph, &layers, reference);
        Ok(Self {
            clearance: rest.iter().map(|p| reference.signed_distance(*p)).collect(),
            candidates,
            shape,
            settle: SettleTables::new(&graph, &rest, &outfit.triangles, &room),
            layers,
            edges: interleaved(edges(&outfit.triangles)),
            ring,
            rig,
            nodes: NodeRig {
                positions: graph.nodes.positions,
                garment: graph.nodes.garment,
                joints,
                weights,
            },
            followers: followers(&graph.vertex_from_node, graph.near.len()),
            vertex_from_node: graph.vertex_from_node,
            near: graph.near,
            fitted_shapes: FittedShapes::default(),
            rest,
        })
    }

    /// The mended rest pose on the reference body, welded order, metres.
    #[must_use]
    pub fn rest_positions(&self) -> &[Vec3] {
        &self.rest
    }

    /// Body vertices tested for collisions with cloth vertex `v`.
    #[must_use]
    pub fn candidates_of(&self, v: usize) -> &[u32] {
        let node = self.node_of(v).unwrap_or(0);
        self.candidates.get(node * CANDIDATES..(node + 1) * CANDIDATES).unwrap_or(&[])
    }

    /// The smooth field that pushes are spread over.
    #[must_use]
    pub fn field(&self) -> Field<'_> {
        Field { vertex_from_node: &self.vertex_from_node, near: &self.near, followers: &self.followers }
    }

    /// The node around cloth vertex `v`.
    #[must_use]
    pub fn node_of(&self, v: usize) -> Option<usize> {
        self.vertex_from_node.nearest(v)
    }

    /// Descriptors of the vertices, row-major (vertices, width), interpolated from the nodes.
    #[must_use]
    pub fn vertex_descriptors(&self) -> Vec<f32> {
        let width = self.rig.descriptors.len() / self.near.len().max(1);
        let mut out = vec![0.0; self.rest.len() * width];
        for (v, row) in out.chunks_exact_mut(width.max(1)).enumerate() {
            for (node, weight) in self.vertex_from_node.row(v) {
                let from = self.rig.descriptors.get(node * width..(node + 1) * width).unwrap_or(&[]);
                row.iter_mut().zip(from).for_each(|(r, d)| *r += weight * d);
            }
        }
        out
    }

    /// Bytes held in memory, about.
    #[must_use]
    pub fn byte_size(&self) -> usize {
        let links = |l: &Links| 8 * l.index.len();
        4 * (self.rig.basis.len() + self.rig.descriptors.len() + self.candidates.len())
            + self.nodes.positions.len() * (12 + 4 + 20)
            + self.rest.len() * (12 + 4 + 4 + 2 * 20)
            + links(&self.vertex_from_node)
            + links(&self.near)
            + links(&self.shape)
            + self.edges.len() * 16
            + self.settle.byte_size()
            + self.layers.byte_size()
    }
}

/// Distance of every node to the skin and to other cloth at rest, metres; far from both it is that to the skin.
fn room(graph: &OutfitGraph, layers: &LayerContacts, reference: &ReferenceBody) -> Vec<f32> {
    let mut room: Vec<f32> = graph.nodes.positions.iter().map(|p| reference.signed_distance(*p)).collect();
    layers.narrow(&mut room, |v| graph.vertex_from_node.nearest(v));
    room
}

/// Layer of every welded vertex.
fn layer_of_vertex(outfit: &Outfit) -> Vec<u32> {
    let garment = garment_of_vertex(outfit);
    garment.iter().map(|&g| outfit.garments.get(g as usize).map_or(0, |x| x.layer)).collect()
}

/// The largest weights of each row, renormalised, with their joints.
#[must_use]
pub fn largest_influences(rows: &[Weights]) -> (Vec<[u8; INFLUENCES]>, Vec<[f32; INFLUENCES]>) {
    rows.iter().map(largest).unzip()
}

fn largest(row: &Weights) -> ([u8; INFLUENCES], [f32; INFLUENCES]) {
    let mut order: Vec<u8> = (0..row.len() as u8).collect();
    order.sort_by(|&a, &b| row[b as usize].total_cmp(&row[a as usize]).then(a.cmp(&b)));
    let (mut joints, mut weights) = ([0; INFLUENCES], [0.0; INFLUENCES]);
    for (k, &joint) in order.iter().take(INFLUENCES).enumerate() {
        joints[k] = joint;
        weights[k] = row[joint as usize].max(0.0);
    }
    let total: f32 = weights.iter().sum();
    (joints, weights.map(|w| if total > 0.0 { w / total } else { 0.25 }))
}
