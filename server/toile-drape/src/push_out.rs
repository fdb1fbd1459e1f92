//! Pushing cloth out of a surface as a smooth field, so that it neither tears nor spikes.
//!
//! What each vertex needs is gathered on the 2.5 cm nodes of the canonical graph, spread over their
//! neighbours and interpolated back: folds and ornaments smaller than a node move as one.

use glam::Vec3;
use toile_geometry::mesh::Adjacency;

use crate::graph::Links;

/// The smooth field that pushes are spread over.
#[derive(Clone, Copy)]
pub struct Field<'a> {
    /// Vertices from nodes.
    pub vertex_from_node: &'a Links,
    /// Touching nodes.
    pub near: &'a Links,
    /// Vertices of each node ([`followers`]).
    pub followers: &'a Adjacency,
}

/// A vertex and the way that it is pushed, metres.
pub type Push = (u32, Vec3);

/// Share of a neighbour's push that a node without need of its own follows.
const FOLLOW: f32 = 0.75;
const SPREADS: usize = 3;
/// Links between a node and the vertices that follow it, at most: a vertex follows its own node and two rings around it.
const REACHED: usize = 3;
/// Rounds of averaging of a smoothed field.
const RELAXATIONS: usize = 6;

/// Those of all vertices that `need` one, metres.
#[must_use]
pub fn pushes(need: &[Vec3]) -> Vec<Push> {
    let all = (0..need.len() as u32).zip(need.iter().copied());
    all.filter(|push| push.1 != Vec3::ZERO).collect()
}

/// The vertices of each of `count` nodes, each at the node that it follows most.
#[must_use]
pub fn followers(vertex_from_node: &Links, count: usize) -> Adjacency {
    let pair = |v: usize| Some((vertex_from_node.nearest(v)? as u32, v as u32));
    Adjacency::from_pairs(count, (0..vertex_from_node.len()).filter_map(pair).collect())
}

impl Field<'_> {
    /// Spreads the pushes that single vertices `need` over the cloth around them.
    #[must_use]
    pub fn spread(&self, need: &[Push]) -> Vec<Push> {
        let nodes = self.gather(need);
        let follow = |n: u32| self.followers.of(n as usize).iter();
        let push = |v: &u32| (*v, self.vertex_from_node.blended(*v as usize, &nodes));
        self.reached(&nodes).into_iter().flat_map(follow).map(push).collect()
    }

    /// The nodes whose vertices may follow one that is pushed.
    fn reached(&self, nodes: &[Vec3]) -> Vec<u32> {
        let mut is_reached: Vec<bool> = nodes.iter().map(|n| *n != Vec3::ZERO).collect();
        let mut reached: Vec<u32> = (0..nodes.len() as u32).filter(|n| is_reached[*n as usize]).collect();
        let mut last = 0;
        for _ in 0..REACHED {
            for i in std::mem::replace(&mut last, reached.len())..reached.len() {
                for &n in self.near.targets(reached[i] as usize) {
                    if !std::mem::replace(&mut is_reached[n as usize], true) {
                        reached.push(n);
                    }
                }
            }
        }
        reached
    }

    /// A field over nodes relaxed over their neighbours and read at `vertices` vertices.
    #[must_use]
    pub fn smoothed(&self, mut nodes: Vec<Vec3>, vertices: usize) -> Vec<Vec3> {
        for _ in 0..RELAXATIONS {
            let relaxed = (0..nodes.len()).map(|i| {
                let (around, linked) =
                    self.near.row(i).fold((Vec3::ZERO, 0.0), |(s, t), (j, w)| (s + nodes[j] * w, t + w));
                nodes[i] * (1.0 - 0.5 * linked) + around * 0.5
            });
            nodes = relaxed.collect();
        }
        self.read(&nodes, vertices)
    }

    fn read(&self, nodes: &[Vec3], vertices: usize) -> Vec<Vec3> {
        (0..vertices).map(|v| self.vertex_from_node.blended(v, nodes)).collect()
    }

    /// Mean need of each node's vertices, weighted towards the largest, then passed on to its neighbours.
    fn gather(&self, need: &[Push]) -> Vec<Vec3> {
        let count = self.near.len();
        let (mut sums, mut shares) = (vec![Vec3::ZERO; count], vec![0.0_f32; count]);
        for (v, push) in need {
            let size = push.length();
            for (node, weight) in self.vertex_from_node.row(*v as usize) {
                sums[node] += *push * (weight * size);
                shares[node] += weight * size;
            }
        }
        let wanted = |i: usize| if shares[i] > 0.0 { sums[i] / shares[i] } else { Vec3::ZERO };
        let mut field: Vec<Vec3> = (0..count).map(wanted).collect();
        let mut pushed: Vec<bool> = shares.iter().map(|s| *s > 0.0).collect();
        for _ in 0..SPREADS {
            (field, pushed) = self.passed_on(&field, &pushed);
        }
        field
    }

    /// Each node's push or, where that is longer, a share of its neighbours'; most nodes have neither.
    fn passed_on(&self, field: &[Vec3], pushed: &[bool]) -> (Vec<Vec3>, Vec<bool>) {
        let (mut next, mut reached) = (field.to_vec(), pushed.to_vec());
        let mut seen = vec![false; field.len()];
        for source in (0..field.len()).filter(|&i| pushed[i]) {
            for &target in self.near.targets(source).iter().chain([&(source as u32)]) {
                let i = target as usize;
                if std::mem::replace(&mut seen[i], true) {
                    continue;
                }
                let around = self.near.row(i).fold(Vec3::ZERO, |s, (j, w)| s + field[j] * w) * FOLLOW;
                if around.length_squared() > field[i].length_squared() {
                    (next[i], reached[i]) = (around, true);
                }
            }
        }
        (next, reached)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::OutfitGraph;
    use crate::test_meshes::sheet;

    #[test]
    fn one_vertex_takes_its_neighbourhood_along_and_leaves_the_rest() {
        let (positions, triangles) = sheet(60);
        let graph = OutfitGraph::new(&positions, &triangles, &vec![0; positions.len()]);
        let followers = followers(&graph.vertex_from_node, graph.near.len());
        let field =
            Field { vertex_from_node: &graph.vertex_from_node, near: &graph.near, followers: &followers };
        let pushed = 30 * 60 + 30;
        let mut push = vec![Vec3::ZERO; positions.len()];
        let spread = field.spread(&[(pushed as u32, Vec3::Y * 0.01)]);
        spread.into_iter().for_each(|(v, way)| push[v as usize] = way);
        assert!(push[pushed].y > 0.005);
        assert!(push[pushed + 1].y > 0.005, "neighbours follow");
        assert_eq!(push[0], Vec3::ZERO, "far vertices stay");
        let step = (1..60).map(|k| (push[30 * 60 + k].y - push[30 * 60 + k - 1].y).abs()).fold(0.0, f32::max);
        assert!(step < 0.004, "no spike: neighbours 1 cm apart differ by {step} m");
    }

    #[test]
    fn a_constant_field_is_smoothed_to_itself() {
        let (positions, triangles) = sheet(20);
        let graph = OutfitGraph::new(&positions, &triangles, &vec![0; positions.len()]);
        let followers = Adjacency::new(0, &[]);
        let field =
            Field { vertex_from_node: &graph.vertex_from_node, near: &graph.near, followers: &followers };
        let smooth = field.smoothed(vec![Vec3::X; graph.nodes.positions.len()], positions.len());
        assert!(smooth.iter().all(|v| v.distance(Vec3::X) < 1e-5));
    }
}
