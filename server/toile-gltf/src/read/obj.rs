//! Wavefront OBJ: `v`, `vt`, `f`, `usemtl`, `o` and `g`. Polygons become fans; material files are not read.

use std::collections::{BTreeMap, HashMap};

use glam::{Vec2, Vec3};
use toile_drape::outfit::{Material, RawMesh, RawPart};

use super::{Contents, MAX_TRIANGLES, MAX_VERTICES, ReadError, units};

const MAX_UVS: usize = MAX_TRIANGLES * 3;
const MAX_OBJECTS: usize = 4096;
const NO_UV: u32 = u32::MAX;

/// Position and UV of a corner.
type Corner = (u32, u32);

#[derive(Clone, Copy, Debug)]
struct Face {
    corners: [Corner; 3],
    material: Option<usize>,
    object: usize,
}

#[derive(Debug, Default)]
struct Parser {
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    faces: Vec<Face>,
    materials: Vec<String>,
    material_of: HashMap<String, usize>,
    material: Option<usize>,
    /// Names of `o`, or of `g` in a file without `o`.
    objects: Vec<String>,
    has_o: bool,
}

pub(super) fn read(bytes: &[u8]) -> Result<Contents, ReadError> {
    let text = String::from_utf8_lossy(bytes).replace("\\\r\n", " ").replace("\\\n", " ");
    let has_o = text.lines().any(|line| line.starts_with("o "));
    let mut parser = Parser { has_o, objects: vec![String::new()], ..Parser::default() };
    for (number, line) in text.lines().enumerate() {
        parser.line(line, number + 1)?;
    }
    if parser.positions.is_empty() {
        return Err(ReadError::NotAMesh("it has no vertex lines as an OBJ has".into()));
    }
    parser.finish()
}

impl Parser {
    fn line(&mut self, line: &str, number: usize) -> Result<(), ReadError> {
        let line = line.split('#').next().unwrap_or_default();
        let (keyword, rest) = line.trim().split_once(char::is_whitespace).unwrap_or((line.trim(), ""));
        match keyword {
            "v" => {
                let position = Vec3::from_array(numbers(rest, number)?);
                if !position.is_finite() {
                    return Err(ReadError::NonFinitePosition(format!("the vertex in line {number}")));
                }
                self.positions.push(position);
                check(self.positions.len(), "vertices", MAX_VERTICES)
            }
            "vt" => {
                let uv = numbers::<2>(rest, number).map(Vec2::from_array)?;
                self.uvs.push(units::uv_from_bottom_left(if uv.is_finite() { uv } else { Vec2::ZERO }));
                check(self.uvs.len(), "UVs", MAX_UVS)
            }
            "f" => self.face(rest, number),
            "usemtl" => self.use_material(rest.trim()),
            "o" => self.begin_object(rest.trim()),
            "g" if !self.has_o => self.begin_object(rest.trim()),
            _ => Ok(()),
        }
    }

    fn face(&mut self, rest: &str, number: usize) -> Result<(), ReadError> {
        let corners: Result<Vec<Corner>, _> =
            rest.split_whitespace().map(|word| self.corner(word, number)).collect();
        let corners = corners?;
        let Some((first, rim)) = corners.split_first() else { return Ok(()) };
        let (material, object) = (self.material, self.objects.len() - 1);
        for (a, b) in rim.iter().zip(rim.iter().skip(1)) {
            self.faces.push(Face { corners: [*first, *a, *b], material, object });
        }
        check(self.faces.len(), "triangles", MAX_TRIANGLES)
    }

    /// A corner `v`, `v/vt`, `v/vt/vn` or `v//vn`.
    fn corner(&self, word: &str, number: usize) -> Result<Corner, ReadError> {
        let mut parts = word.split('/');
        let position = resolve(parts.next().unwrap_or_default(), self.positions.len(), number)?;
        let uv = match parts.next() {
            None | Some("") => NO_UV,
            Some(uv) => resolve(uv, self.uvs.len(), number)?,
        };
        Ok((position, uv))
    }

    fn use_material(&mut self, name: &str) -> Result<(), ReadError> {
        let next = self.materials.len();
        let index = *self.material_of.entry(name.to_owned()).or_insert(next);
        if index == next {
            self.materials.push(name.to_owned());
        }
        self.material = Some(index);
        check(self.materials.len(), "materials", MAX_OBJECTS)
    }

    fn begin_object(&mut self, name: &str) -> Result<(), ReadError> {
        self.objects.push(name.to_owned());
        check(self.objects.len(), "objects", MAX_OBJECTS)
    }

    fn finish(self) -> Result<Contents, ReadError> {
        let owner = united_objects(&self.faces, self.objects.len(), self.positions.len());
        let mut faces_of: BTreeMap<usize, Vec<Face>> = BTreeMap::new();
        for face in &self.faces {
            let object = owner.get(face.object).copied().unwrap_or(face.object);
            faces_of.entry(object).or_default().push(*face);
        }
        let mut meshes = Vec::new();
        for (object, faces) in faces_of {
            let name = self.objects.get(object).cloned().unwrap_or_default();
            meshes.push(self.mesh(name, &faces));
        }
        let vertices = meshes.iter().map(|mesh| mesh.positions.len()).sum();
        check(vertices, "vertices", MAX_VERTICES)?;
        let materials =
            self.materials.into_iter().map(|name| Material { name, ..Material::default() }).collect();
        Ok(Contents { name: None, meshes, materials, notes: Vec::new() })
    }

    /// A mesh whose vertices are the corners that occur, in file order of their positions.
    fn mesh(&self, name: String, faces: &[Face]) -> RawMesh {
        let mut corners: Vec<Corner> = faces.iter().flat_map(|face| face.corners).collect();
        corners.sort_unstable();
        corners.dedup();
        let mut parts: BTreeMap<Option<usize>, Vec<[u32; 3]>> = BTreeMap::new();
        for face in faces {
            let triangle =
                face.corners.map(|corner| corners.binary_search(&corner).unwrap_or_default() as u32);
            parts.entry(face.material).or_default().push(triangle);
        }
        let position = |corner: &Corner| self.positions.get(corner.0 as usize).copied().unwrap_or_default();
        let uv = |corner: &Corner| self.uvs.get(corner.1 as usize).copied().unwrap_or_default();
        let has_uvs = corners.iter().any(|corner| corner.1 != NO_UV);
        RawMesh {
            name,
            positions: corners.iter().map(position).collect(),
            uvs: if has_uvs { corners.iter().map(uv).collect() } else { Vec::new() },
            parts: parts.into_iter().map(|(material, triangles)| RawPart { triangles, material }).collect(),
        }
    }
}

/// For every object the first object that it shares vertices with: groups of one surface are one mesh.
fn united_objects(faces: &[Face], objects: usize, positions: usize) -> Vec<usize> {
    let mut parent: Vec<usize> = (0..objects).collect();
    let mut first_user = vec![usize::MAX; positions];
    for face in faces {
        for (position, _) in face.corners {
            let Some(user) = first_user.get_mut(position as usize) else { continue };
            if *user == usize::MAX {
                *user = face.object;
            }
            let (a, b) = (root_of(&mut parent, *user), root_of(&mut parent, face.object));
            if let Some(slot) = parent.get_mut(a.max(b)) {
                *slot = a.min(b);
            }
        }
    }
    (0..objects).map(|object| root_of(&mut parent, object)).collect()
}

/// Follows parents to the root, halving the path.
fn root_of(parent: &mut [usize], mut object: usize) -> usize {
    while let Some(&up) = parent.get(object).filter(|up| **up != object) {
        let grandparent = parent.get(up).copied().unwrap_or(up);
        if let Some(slot) = parent.get_mut(object) {
            *slot = grandparent;
        }
        object = grandparent;
    }
    object
}

/// A one-based or, counted from the end, negative index.
fn resolve(word: &str, count: usize, number: usize) -> Result<u32, ReadError> {
    let malformed = || ReadError::NotAMesh(format!("line {number} has an index that is no number"));
    let index: i64 = word.parse().map_err(|_| malformed())?;
    let position = if index < 0 { count as i64 + index } else { index - 1 };
    let in_range = u32::try_from(position).ok().filter(|position| (*position as usize) < count);
    in_range.ok_or_else(|| ReadError::IndexOutOfRange {
        what: format!("an index in line {number}"),
        index,
        count,
    })
}

/// The first `N` numbers of a line.
fn numbers<const N: usize>(rest: &str, number: usize) -> Result<[f32; N], ReadError> {
    let mut words = rest.split_whitespace();
    let mut out = [0.0; N];
    for value in &mut out {
        let parsed = words.next().and_then(|word| word.parse().ok());
        *value = parsed.ok_or_else(|| ReadError::NotAMesh(format!("line {number} lacks a number")))?;
    }
    Ok(out)
}

fn check(count: usize, what: &str, limit: usize) -> Result<(), ReadError> {
    if count > limit { Err(ReadError::too_large(count, what, limit)) } else { Ok(()) }
}
