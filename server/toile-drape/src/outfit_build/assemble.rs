//! Putting the outfit together: garments innermost first, vertices and triangles sorted by garment.

use std::collections::{BTreeSet, HashMap};

use glam::Vec2;

use super::OutfitSource;
use super::garments::Draft;
use super::weld::{Face, Soup};
use crate::outfit::{Garment, Material, Outfit, Part};

/// Builds the outfit from its drafts and their layers.
pub(super) fn assemble(source: OutfitSource, soup: Soup, drafts: Vec<Draft>, layers: &[u32]) -> Outfit {
    let mut drafts: Vec<(u32, Draft)> = layers.iter().copied().zip(drafts).collect();
    drafts.sort_by_key(|(layer, _)| *layer);
    let palette = Palette::new(&soup);
    let mut assembly = Assembly { soup: &soup, palette: &palette, outfit: Outfit::default() };
    for (layer, draft) in drafts {
        assembly.add(layer, draft);
    }
    let mut outfit = assembly.outfit;
    outfit.materials = palette.materials(source.materials);
    let mesh_names = source.meshes.into_iter().map(|mesh| mesh.name);
    let mut names = source.name.into_iter().chain(mesh_names).filter(|name| !name.trim().is_empty());
    outfit.name = names.next().unwrap_or_else(|| "outfit".to_owned());
    outfit
}

/// Which materials are in use, and the index that each gets.
struct Palette {
    used: Vec<usize>,
    has_plain: bool,
}

impl Palette {
    fn new(soup: &Soup) -> Self {
        let used: BTreeSet<usize> = soup.faces.iter().filter_map(|face| face.material).collect();
        Self {
            used: used.into_iter().collect(),
            has_plain: soup.faces.iter().any(|face| face.material.is_none()),
        }
    }

    /// Plain cloth comes after the file's materials.
    fn index(&self, material: Option<usize>) -> usize {
        material.and_then(|material| self.used.binary_search(&material).ok()).unwrap_or(self.used.len())
    }

    fn materials(&self, from_file: Vec<Material>) -> Vec<Material> {
        let is_used = |(index, _): &(usize, Material)| self.used.binary_search(index).is_ok();
        let mut materials: Vec<Material> =
            from_file.into_iter().enumerate().filter(is_used).map(|(_, material)| material).collect();
        if self.has_plain {
            materials.push(Material::default());
        }
        materials
    }
}

struct Assembly<'a> {
    soup: &'a Soup,
    palette: &'a Palette,
    outfit: Outfit,
}

impl Assembly<'_> {
    fn add(&mut self, layer: u32, draft: Draft) {
        let mut faces: Vec<&Face> =
            draft.faces.iter().filter_map(|&face| self.soup.faces.get(face as usize)).collect();
        faces.sort_by_key(|face| self.palette.index(face.material));
        let first_vertex = self.outfit.positions.len() as u32;
        let first_drawn = self.outfit.surface.vertex_of.len() as u32;
        let drawn_index = self.add_vertices(&faces);
        let mut parts: Vec<Part> = Vec::new();
        for face in faces {
            let material = self.palette.index(face.material);
            let at = self.outfit.triangles.len() as u32;
            let drawn = face.drawn.map(|corner| drawn_index.get(&corner).copied().unwrap_or(first_drawn));
            let vertex_of = &self.outfit.surface.vertex_of;
            let welded = drawn.map(|corner| vertex_of.get(corner as usize).copied().unwrap_or(first_vertex));
            self.outfit.surface.triangles.push(drawn);
            self.outfit.triangles.push(welded);
            match parts.last_mut().filter(|part| part.material == material) {
                Some(part) => part.triangles.end = at + 1,
                None => parts.push(Part { material, triangles: at..at + 1 }),
            }
        }
        self.outfit.garments.push(Garment {
            name: draft.name,
            layer,
            vertices: first_vertex..self.outfit.positions.len() as u32,
            drawn_vertices: first_drawn..self.outfit.surface.vertex_of.len() as u32,
            parts,
        });
    }

    /// Adds the vertices that the faces use in file order; where each drawn vertex of the file went.
    fn add_vertices(&mut self, faces: &[&Face]) -> HashMap<u32, u32> {
        let mut drawn: Vec<u32> = faces.iter().flat_map(|face| face.drawn).collect();
        drawn.sort_unstable();
        drawn.dedup();
        let mut welded_index: HashMap<u32, u32> = HashMap::with_capacity(drawn.len());
        let mut drawn_index = HashMap::with_capacity(drawn.len());
        let outfit = &mut self.outfit;
        for corner in drawn {
            let vertex = self.soup.vertex_of.get(corner as usize).copied().unwrap_or_default();
            let next = outfit.positions.len() as u32;
            let welded = *welded_index.entry(vertex).or_insert(next);
            if welded == next {
                outfit.positions.push(self.soup.position(vertex));
            }
            drawn_index.insert(corner, outfit.surface.vertex_of.len() as u32);
            outfit.surface.vertex_of.push(welded);
            if !self.soup.uvs.is_empty() {
                outfit.surface.uvs.push(self.soup.uvs.get(corner as usize).copied().unwrap_or(Vec2::ZERO));
            }
        }
        drawn_index
    }
}
