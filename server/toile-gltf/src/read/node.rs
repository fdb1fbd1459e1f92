//! The node tree: its checks, its order, its transforms.

use glam::{Affine3A, Mat3A, Quat, Vec3, Vec3A};
use gltf::json::{Index, Root, scene};

use super::ReadError;

const MAX_DEPTH: usize = 64;

/// A node that shows a mesh, in file coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedNode {
    pub(super) node: usize,
    pub(super) world_from_node: Affine3A,
}

/// Refuses cycles, shared children, missing nodes and deep trees.
pub(super) fn check_tree(root: &Root) -> Result<(), ReadError> {
    walk(root).map(drop)
}

/// Nodes of the scene that is shown, parents first, siblings in file order.
pub(super) fn walk(root: &Root) -> Result<Vec<PlacedNode>, ReadError> {
    let mut visited = vec![false; root.nodes.len()];
    let mut placed = Vec::new();
    let tops = top_nodes(root)?;
    let mut stack: Vec<(usize, usize, Affine3A)> =
        tops.into_iter().rev().map(|n| (n, 1, Affine3A::IDENTITY)).collect();
    while let Some((index, depth, world_from_parent)) = stack.pop() {
        let node = root.nodes.get(index).ok_or_else(|| missing_node(index, root))?;
        if depth > MAX_DEPTH {
            return Err(ReadError::too_large(depth, "levels of nodes", MAX_DEPTH));
        }
        if visited.get_mut(index).is_none_or(|seen| std::mem::replace(seen, true)) {
            return Err(ReadError::NotAMesh(format!(
                "node {index} is reached twice, so its nodes are not a tree"
            )));
        }
        let world_from_node = world_from_parent * parent_from_node(node);
        placed.push(PlacedNode { node: index, world_from_node });
        let children = node.children.iter().flatten().rev();
        stack.extend(children.map(|child| (child.value(), depth + 1, world_from_node)));
    }
    Ok(placed)
}

/// The shown scene's nodes; without a scene, the nodes that are nobody's child.
fn top_nodes(root: &Root) -> Result<Vec<usize>, ReadError> {
    let index = root.scene.map_or(0, |scene| scene.value());
    if let Some(scene) = root.scenes.get(index) {
        return Ok(scene.nodes.iter().map(Index::value).collect());
    }
    if root.scene.is_some() {
        let what = "the scene to show".to_owned();
        return Err(ReadError::IndexOutOfRange { what, index: index as i64, count: root.scenes.len() });
    }
    let mut is_child = vec![false; root.nodes.len()];
    for child in root.nodes.iter().flat_map(|node| node.children.iter().flatten()) {
        *is_child.get_mut(child.value()).ok_or_else(|| missing_node(child.value(), root))? = true;
    }
    if !is_child.is_empty() && is_child.iter().all(|child| *child) {
        return Err(ReadError::NotAMesh(
            "every node is the child of another, so its nodes are not a tree".into(),
        ));
    }
    Ok(is_child.iter().enumerate().filter(|(_, child)| !**child).map(|(node, _)| node).collect())
}

fn missing_node(index: usize, root: &Root) -> ReadError {
    ReadError::IndexOutOfRange { what: "a node".into(), index: index as i64, count: root.nodes.len() }
}

fn parent_from_node(node: &scene::Node) -> Affine3A {
    if let Some(m) = node.matrix {
        let linear = Mat3A::from_cols(
            Vec3A::new(m[0], m[1], m[2]),
            Vec3A::new(m[4], m[5], m[6]),
            Vec3A::new(m[8], m[9], m[10]),
        );
        return Affine3A { matrix3: linear, translation: Vec3A::new(m[12], m[13], m[14]) };
    }
    let rotation = node.rotation.map_or(Quat::IDENTITY, |rotation| Quat::from_array(rotation.0));
    let length = rotation.length();
    let rotation = if length.is_finite() && length > 1e-6 { rotation / length } else { Quat::IDENTITY };
    Affine3A::from_scale_rotation_translation(
        node.scale.map_or(Vec3::ONE, Vec3::from_array),
        rotation,
        node.translation.map_or(Vec3::ZERO, Vec3::from_array),
    )
}
