//! The meshes that the scene shows, as triangles in file coordinates.

use glam::{Affine3A, Vec2, Vec3};
use gltf::json::Index;
use gltf::json::accessor::Accessor;
use gltf::json::mesh::{Mesh, Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use toile_drape::outfit::{RawMesh, RawPart};

use super::accessor::{read_indices, read_vectors};
use super::document::Document;
use super::{MAX_TRIANGLES, MAX_VERTICES, ReadError, node};

/// Primitives over all nodes; each costs work even when it is empty.
const MAX_PRIMITIVES: usize = 4096;

/// Reads every mesh of the scene, once per node that shows it.
pub(super) fn read_all(document: &Document<'_>) -> Result<Vec<RawMesh>, ReadError> {
    let mut budget = Budget::default();
    let mut meshes = Vec::new();
    for placed in node::walk(&document.root)? {
        let Some(node) = document.root.nodes.get(placed.node) else { continue };
        let Some(index) = node.mesh else { continue };
        let mesh = document.root.meshes.get(index.value()).ok_or_else(|| ReadError::IndexOutOfRange {
            what: format!("the mesh of node {}", placed.node),
            index: index.value() as i64,
            count: document.root.meshes.len(),
        })?;
        let name = node.name.clone().or_else(|| mesh.name.clone()).unwrap_or_default();
        let mut raw = MeshReader::new(document, &mut budget).read(mesh)?;
        if raw.parts.is_empty() {
            continue;
        }
        place(&mut raw, placed.world_from_node);
        raw.name = name;
        check_finite(&raw)?;
        meshes.push(raw);
    }
    Ok(meshes)
}

/// Counts over the whole file, against the caps.
#[derive(Debug, Default)]
struct Budget {
    primitives: usize,
    vertices: usize,
    triangles: usize,
}

impl Budget {
    fn spend(&mut self, primitives: usize, vertices: usize, triangles: usize) -> Result<(), ReadError> {
        self.primitives += primitives;
        self.vertices += vertices;
        self.triangles += triangles;
        let counts = [
            (self.primitives, "primitives", MAX_PRIMITIVES),
            (self.vertices, "vertices", MAX_VERTICES),
            (self.triangles, "triangles", MAX_TRIANGLES),
        ];
        match counts.into_iter().find(|(count, _, limit)| count > limit) {
            Some((_, what, limit)) => {
                Err(ReadError::TooLarge { what: format!("more than {limit} {what}"), limit })
            }
            None => Ok(()),
        }
    }
}

/// Vertices that primitives of a mesh share because they name the same accessors.
struct SharedVertices {
    accessors: (usize, Option<usize>),
    first: usize,
    count: usize,
}

struct MeshReader<'a, 'd> {
    document: &'a Document<'d>,
    budget: &'a mut Budget,
    raw: RawMesh,
    has_uvs: bool,
    shared: Vec<SharedVertices>,
}

impl<'a, 'd> MeshReader<'a, 'd> {
    fn new(document: &'a Document<'d>, budget: &'a mut Budget) -> Self {
        Self { document, budget, raw: RawMesh::default(), has_uvs: false, shared: Vec::new() }
    }

    fn read(mut self, mesh: &Mesh) -> Result<RawMesh, ReadError> {
        for primitive in &mesh.primitives {
            self.budget.spend(1, 0, 0)?;
            let Checked::Valid(mode) = primitive.mode else { continue };
            let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
            if let (Some(positions), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) =
                (positions, mode)
            {
                self.read_primitive(primitive, *positions, mode)?;
            }
        }
        if !self.has_uvs {
            self.raw.uvs.clear();
        }
        Ok(self.raw)
    }

    fn read_primitive(
        &mut self,
        primitive: &Primitive,
        positions: Index<Accessor>,
        mode: Mode,
    ) -> Result<(), ReadError> {
        self.check_material(primitive)?;
        let (first, count) = self.vertices(positions, self.texture_coordinates(primitive))?;
        let corners = match primitive.indices {
            Some(indices) => read_indices(self.document, indices, MAX_TRIANGLES * 3)?,
            None => (0..count as u32).collect(),
        };
        if let Some(beyond) = corners.iter().find(|corner| **corner as usize >= count) {
            let what = format!("an index of mesh \"{}\"", self.raw.name);
            return Err(ReadError::IndexOutOfRange { what, index: i64::from(*beyond), count });
        }
        let triangles = triangles(&corners, mode, first as u32);
        self.budget.spend(0, 0, triangles.len())?;
        if !triangles.is_empty() {
            let material = primitive.material.map(|material| material.value());
            self.raw.parts.push(RawPart { triangles, material });
        }
        Ok(())
    }

    fn check_material(&self, primitive: &Primitive) -> Result<(), ReadError> {
        let count = self.document.root.materials.len();
        match primitive.material {
            Some(material) if material.value() >= count => {
                let index = material.value() as i64;
                Err(ReadError::IndexOutOfRange { what: "a material".into(), index, count })
            }
            _ => Ok(()),
        }
    }

    /// The UV set that the material's base colour texture asks for, or the first.
    fn texture_coordinates(&self, primitive: &Primitive) -> Option<Index<Accessor>> {
        let material =
            primitive.material.and_then(|material| self.document.root.materials.get(material.value()));
        let texture =
            material.and_then(|material| material.pbr_metallic_roughness.base_color_texture.as_ref());
        let set = texture.map_or(0, |texture| texture.tex_coord);
        let find = |set| primitive.attributes.get(&Checked::Valid(Semantic::TexCoords(set))).copied();
        find(set).or_else(|| find(0))
    }

    /// Appends vertices, or finds them where another primitive has brought them: (first, count).
    fn vertices(
        &mut self,
        positions: Index<Accessor>,
        uvs: Option<Index<Accessor>>,
    ) -> Result<(usize, usize), ReadError> {
        let accessors = (positions.value(), uvs.map(|uvs| uvs.value()));
        if let Some(known) = self.shared.iter().find(|known| known.accessors == accessors) {
            return Ok((known.first, known.count));
        }
        let first = self.raw.positions.len();
        let read = read_vectors::<3>(self.document, positions, MAX_VERTICES)?;
        let count = read.len();
        self.budget.spend(0, count, 0)?;
        self.raw.positions.extend(read.into_iter().map(Vec3::from_array));
        if let Some(uvs) = uvs {
            let read = read_vectors::<2>(self.document, uvs, MAX_VERTICES)?;
            if read.len() != count {
                let message =
                    format!("accessors[{}] has {} UVs for {count} positions", uvs.value(), read.len());
                return Err(ReadError::InvalidAccessor(message));
            }
            self.has_uvs = true;
            let finite = |uv: Vec2| if uv.is_finite() { uv } else { Vec2::ZERO };
            self.raw.uvs.extend(read.into_iter().map(|uv| finite(Vec2::from_array(uv))));
        } else {
            self.raw.uvs.resize(first + count, Vec2::ZERO);
        }
        self.shared.push(SharedVertices { accessors, first, count });
        Ok((first, count))
    }
}

/// Triangles of a list, strip or fan (glTF 2.0, section 3.7.2.1), indices raised by `first`.
fn triangles(corners: &[u32], mode: Mode, first: u32) -> Vec<[u32; 3]> {
    let raise = |[a, b, c]: [u32; 3]| [a + first, b + first, c + first];
    match (mode, corners) {
        (Mode::Triangles, _) => corners.as_chunks::<3>().0.iter().map(|t| raise(*t)).collect(),
        (Mode::TriangleStrip, [_, second @ ..]) => {
            let windows = corners.iter().zip(second).zip(second.iter().skip(1)).enumerate();
            let turned =
                |i: usize, [a, b, c]: [u32; 3]| if i.is_multiple_of(2) { [a, b, c] } else { [a, c, b] };
            windows.map(|(i, ((a, b), c))| raise(turned(i, [*a, *b, *c]))).collect()
        }
        (Mode::TriangleFan, [centre, rim @ ..]) => {
            rim.iter().zip(rim.iter().skip(1)).map(|(a, b)| raise([*centre, *a, *b])).collect()
        }
        _ => Vec::new(),
    }
}

/// Moves the mesh to where its node puts it; a mirroring node turns the winding.
fn place(raw: &mut RawMesh, world_from_node: Affine3A) {
    for position in &mut raw.positions {
        *position = world_from_node.transform_point3(*position);
    }
    if world_from_node.matrix3.determinant() < 0.0 {
        for triangle in raw.parts.iter_mut().flat_map(|part| part.triangles.iter_mut()) {
            triangle.swap(1, 2);
        }
    }
}

fn check_finite(raw: &RawMesh) -> Result<(), ReadError> {
    match raw.positions.iter().position(|position| !position.is_finite()) {
        Some(vertex) => {
            Err(ReadError::NonFinitePosition(format!("vertex {vertex} of mesh \"{}\"", raw.name)))
        }
        None => Ok(()),
    }
}
