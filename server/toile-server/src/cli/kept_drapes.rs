//! Drapes of one outfit as arrays, for tables and simulations outside this program.

use std::path::Path;

use glam::Vec3;
use safetensors::tensor::{Dtype, TensorView, serialize_to_file};
use toile_drape::outfit::Outfit;
use toile_drape::pipeline::Frame;
use toile_drape::repair::garment_of_vertex;

use super::Failure;

/// Drapes on several bodies, each in the same poses; metres, rest space of each body or world space.
#[derive(Default)]
pub struct KeptDrapes {
    rest: Vec<u8>,
    skin: Vec<u8>,
    draped: Vec<u8>,
    resolved: Vec<u8>,
    body: Vec<u8>,
}

impl KeptDrapes {
    /// Adds one body: the rest pose on its A-pose `skin`, and its frames before and after the resolve.
    pub fn add(&mut self, (rest, skin): (&[Vec3], &[Vec3]), before: &[Frame], after: &[Frame]) {
        append(&mut self.rest, rest);
        append(&mut self.skin, skin);
        for (draped, resolved) in before.iter().zip(after) {
            append(&mut self.draped, &draped.positions);
            append(&mut self.resolved, &resolved.positions);
            append(&mut self.body, &draped.body.vertices);
        }
    }

    /// Writes the `rest` pose (bodies, N, 3) and the A-pose `skin` (bodies, V, 3) under it; the cloth `draped` without
    /// and `resolved` with the resolve (bodies, poses, N, 3) and the posed `body` (bodies, poses, V, 3), float32;
    /// `triangles` (T, 3) and the `garment` of each vertex (N,), uint32. Welded order.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, outfit: &Outfit, path: &Path) -> Result<(), Failure> {
        let vertices = outfit.positions.len();
        let bodies = self.rest.len() / (12 * vertices.max(1));
        let poses = self.draped.len() / self.rest.len().max(1);
        let skin = self.skin.len() / (12 * bodies.max(1));
        let triangles: Vec<u8> = outfit.triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
        let garment: Vec<u8> = garment_of_vertex(outfit).into_iter().flat_map(u32::to_le_bytes).collect();
        let arrays = [
            ("rest", Dtype::F32, vec![bodies, vertices, 3], &self.rest),
            ("skin", Dtype::F32, vec![bodies, skin, 3], &self.skin),
            ("draped", Dtype::F32, vec![bodies, poses, vertices, 3], &self.draped),
            ("resolved", Dtype::F32, vec![bodies, poses, vertices, 3], &self.resolved),
            ("body", Dtype::F32, vec![bodies, poses, skin, 3], &self.body),
            ("triangles", Dtype::U32, vec![outfit.triangles.len(), 3], &triangles),
            ("garment", Dtype::U32, vec![vertices], &garment),
        ];
        let views: Vec<_> = arrays
            .into_iter()
            .map(|(name, dtype, shape, bytes)| TensorView::new(dtype, shape, bytes).map(|view| (name, view)))
            .collect::<Result<_, _>>()?;
        Ok(serialize_to_file(views, None, path)?)
    }
}

fn append(to: &mut Vec<u8>, points: &[Vec3]) {
    to.extend(points.iter().flat_map(|p| p.to_array()).flat_map(f32::to_le_bytes));
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use safetensors::SafeTensors;
    use toile_drape::outfit::Garment;
    use toile_drape::posed_body::PosedBody;
    use toile_drape::skin_cells::SkinCells;

    fn frame(height: f32) -> Frame {
        let body = PosedBody {
            vertices: vec![Vec3::X; 2],
            normals: vec![Vec3::Y; 2],
            facing: vec![],
            cells: SkinCells::default(),
            lift: Vec3::ZERO,
        };
        Frame {
            positions: vec![Vec3::Y * height; 3],
            normals: vec![],
            body: Arc::new(body),
            penetration: vec![],
            strain: vec![],
        }
    }

    #[test]
    fn every_body_and_pose_is_found_where_its_shape_says() {
        let garment = Garment { vertices: 1..3, ..Garment::default() };
        let outfit = Outfit {
            positions: vec![Vec3::ZERO; 3],
            triangles: vec![[0, 1, 2]],
            garments: vec![Garment { vertices: 0..1, ..Garment::default() }, garment],
            ..Outfit::default()
        };
        let mut kept = KeptDrapes::default();
        for body in 0..2 {
            let at = |pose: usize| frame((2 * body + pose) as f32);
            kept.add((&[Vec3::ZERO; 3], &[Vec3::ZERO; 2]), &[at(0), at(1)], &[at(1), at(0)]);
        }
        let file = tempfile::NamedTempFile::new().unwrap();
        kept.write(&outfit, file.path()).unwrap();
        let bytes = std::fs::read(file.path()).unwrap();
        let read = SafeTensors::deserialize(&bytes).unwrap();
        let draped = read.tensor("draped").unwrap();
        assert_eq!(draped.shape(), [2, 2, 3, 3]);
        let heights: Vec<f32> = draped
            .data()
            .chunks_exact(36)
            .map(|frame| f32::from_le_bytes(frame[4..8].try_into().unwrap()))
            .collect();
        assert_eq!(heights, [0.0, 1.0, 2.0, 3.0]);
        assert_eq!(read.tensor("body").unwrap().shape(), [2, 2, 2, 3]);
        assert_eq!(read.tensor("garment").unwrap().data(), [0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
    }
}
