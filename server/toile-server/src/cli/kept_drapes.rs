//! Drapes of one outfit as arrays, for tables and simulations outside this program.

use std::path::Path;

use glam::Vec3;
use safetensors::tensor::{Dtype, TensorView, serialize_to_file};
use toile_drape::outfit::Outfit;
use toile_drape::pipeline::Frame;

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

    /// Writes `rest` (bodies, N, 3) and the A-pose `skin` (bodies, V, 3) under it; `draped`, `resolved` (bodies, poses, N, 3) without and with the resolve; `body`
    /// (bodies, poses, V, 3) float32; `triangles` (T, 3), `layer` and `garment` (N,) uint32, in welded order.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, outfit: &Outfit, bodies: usize, path: &Path) -> Result<(), Failure> {
        let (vertices, count) = (outfit.positions.len(), bodies.max(1));
        let poses = self.draped.len() / (12 * count * vertices.max(1));
        let body = self.body.len() / (12 * count * poses.max(1));
        let triangles: Vec<u8> = outfit.triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
        let (mut layer, mut garment) = (vec![0; 4 * vertices], vec![0; 4 * vertices]);
        for (number, g) in outfit.garments.iter().enumerate() {
            for v in g.vertices.clone().map(|v| 4 * v as usize) {
                layer[v..v + 4].copy_from_slice(&g.layer.to_le_bytes());
                garment[v..v + 4].copy_from_slice(&(number as u32).to_le_bytes());
            }
        }
        let arrays = [
            ("rest", Dtype::F32, vec![bodies, vertices, 3], &self.rest),
            ("skin", Dtype::F32, vec![bodies, body, 3], &self.skin),
            ("draped", Dtype::F32, vec![bodies, poses, vertices, 3], &self.draped),
            ("resolved", Dtype::F32, vec![bodies, poses, vertices, 3], &self.resolved),
            ("body", Dtype::F32, vec![bodies, poses, body, 3], &self.body),
            ("triangles", Dtype::U32, vec![outfit.triangles.len(), 3], &triangles),
            ("layer", Dtype::U32, vec![vertices], &layer),
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

    fn frame(height: f32) -> Frame {
        let body = PosedBody {
            vertices: vec![Vec3::X; 2],
            normals: vec![Vec3::Y; 2],
            facing: vec![],
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
        let garment = Garment { layer: 7, vertices: 1..3, ..Garment::default() };
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
        kept.write(&outfit, 2, file.path()).unwrap();
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
        assert_eq!(read.tensor("layer").unwrap().data(), [0, 0, 0, 0, 7, 0, 0, 0, 7, 0, 0, 0]);
    }
}
