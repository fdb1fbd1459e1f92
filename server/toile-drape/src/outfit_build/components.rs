//! Connected pieces of the welded mesh.

use std::collections::HashMap;

use glam::Vec3;

use super::weld::Soup;

/// A connected piece.
#[derive(Clone, Debug)]
pub(super) struct Component {
    /// Index into the source's meshes.
    pub(super) mesh: u32,
    /// Indices into the soup's faces, ascending.
    pub(super) faces: Vec<u32>,
    /// Square metres.
    pub(super) area: f32,
}

impl Component {
    /// Up to `most` of its corner positions, evenly through its faces.
    pub(super) fn samples(&self, soup: &Soup, most: usize) -> Vec<Vec3> {
        let step = self.faces.len().div_ceil(most.max(1)).max(1);
        let faces = self.faces.iter().step_by(step).filter_map(|&face| soup.faces.get(face as usize));
        faces.map(|face| soup.corners(face)[0]).collect()
    }
}

/// Pieces in order of their first face.
pub(super) fn find(soup: &Soup) -> Vec<Component> {
    let mut parent: Vec<u32> = (0..soup.positions.len() as u32).collect();
    for face in &soup.faces {
        let [a, b, c] = face.welded;
        unite(&mut parent, a, b);
        unite(&mut parent, b, c);
    }
    let mut component_of: HashMap<u32, usize> = HashMap::new();
    let mut components: Vec<Component> = Vec::new();
    for (index, face) in soup.faces.iter().enumerate() {
        let root = root_of(&mut parent, face.welded[0]);
        let next = components.len();
        let component = *component_of.entry(root).or_insert(next);
        if component == next {
            components.push(Component { mesh: face.mesh, faces: Vec::new(), area: 0.0 });
        }
        if let Some(component) = components.get_mut(component) {
            component.faces.push(index as u32);
            component.area += soup.area_vector(face).length() / 2.0;
        }
    }
    components
}

/// Makes one piece of two vertices' pieces.
pub(crate) fn unite(parent: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root_of(parent, a), root_of(parent, b));
    if let Some(slot) = parent.get_mut(a.max(b) as usize) {
        *slot = a.min(b);
    }
}

/// Follows parents to the root, halving the path.
pub(crate) fn root_of(parent: &mut [u32], mut vertex: u32) -> u32 {
    while let Some(&up) = parent.get(vertex as usize).filter(|up| **up != vertex) {
        let grandparent = parent.get(up as usize).copied().unwrap_or(up);
        if let Some(slot) = parent.get_mut(vertex as usize) {
            *slot = grandparent;
        }
        vertex = grandparent;
    }
    vertex
}
