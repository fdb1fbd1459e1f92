//! The stored form of an outfit: little-endian, compact, checked on reading.
//!
//! Magic and version, then the fields in the order of [`Outfit`]; lists and texts begin with their length.

#[cfg(test)]
mod tests;

use std::ops::Range;

use bytemuck::{AnyBitPattern, NoUninit};
use glam::Vec3;
use thiserror::Error;

use crate::outfit::{Garment, Material, Outfit, Part, Picture, Surface, UvTransform};

/// Version of the stored form.
pub const OUTFIT_FORMAT: u32 = 1;
const MAGIC: &[u8; 8] = b"TOILEOUT";

/// Why bytes are no stored outfit. The checksum is the cache's; this is what it cannot see.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum CodecError {
    /// Not a stored outfit, or of another version.
    #[error("not a stored outfit of format {OUTFIT_FORMAT}")]
    Foreign,
    /// It ends early or goes on after its end.
    #[error("a stored outfit of another length")]
    Length,
    /// An index or a range points nowhere, or a text is not UTF-8.
    #[error("a stored outfit that contradicts itself")]
    Inconsistent,
}

/// Stores an outfit.
#[must_use]
pub fn to_bytes(outfit: &Outfit) -> Vec<u8> {
    let mut out = Encoder(Vec::new());
    out.0.extend_from_slice(MAGIC);
    out.word(OUTFIT_FORMAT);
    out.text(&outfit.name);
    out.list(&outfit.positions);
    out.list(&outfit.triangles);
    out.list(&outfit.surface.vertex_of);
    out.list(&outfit.surface.uvs);
    out.list(&outfit.surface.triangles);
    out.word(outfit.garments.len() as u32);
    for garment in &outfit.garments {
        out.garment(garment);
    }
    out.word(outfit.materials.len() as u32);
    for material in &outfit.materials {
        out.material(material);
    }
    out.0
}

/// Reads a stored outfit.
///
/// # Errors
/// When the bytes are not what [`to_bytes`] writes.
pub fn from_bytes(bytes: &[u8]) -> Result<Outfit, CodecError> {
    let rest = bytes.strip_prefix(MAGIC).ok_or(CodecError::Foreign)?;
    let mut input = Decoder(rest);
    if input.word()? != OUTFIT_FORMAT {
        return Err(CodecError::Foreign);
    }
    let name = input.text()?;
    let positions: Vec<Vec3> = input.list()?;
    let triangles = input.list()?;
    let surface = Surface { vertex_of: input.list()?, uvs: input.list()?, triangles: input.list()? };
    let garments = (0..input.count(24)?).map(|_| input.garment()).collect::<Result<_, _>>()?;
    let materials = (0..input.count(32)?).map(|_| input.material()).collect::<Result<_, _>>()?;
    let outfit = Outfit { name, positions, triangles, garments, surface, materials };
    match (input.0.is_empty(), is_consistent(&outfit)) {
        (false, _) => Err(CodecError::Length),
        (true, false) => Err(CodecError::Inconsistent),
        (true, true) => Ok(outfit),
    }
}

/// Whether every index and range of the outfit points at something.
fn is_consistent(outfit: &Outfit) -> bool {
    let (vertices, drawn) = (outfit.positions.len(), outfit.surface.vertex_of.len());
    let faces = outfit.triangles.len();
    let within = |range: &Range<u32>, count: usize| range.start <= range.end && range.end as usize <= count;
    outfit.triangles.iter().flatten().all(|&i| (i as usize) < vertices)
        && outfit.surface.vertex_of.iter().all(|&i| (i as usize) < vertices)
        && outfit.surface.triangles.iter().flatten().all(|&i| (i as usize) < drawn)
        && outfit.surface.triangles.len() == faces
        && (outfit.surface.uvs.is_empty() || outfit.surface.uvs.len() == drawn)
        && outfit.positions.iter().all(|position| position.is_finite())
        && outfit.garments.iter().all(|garment| {
            within(&garment.vertices, vertices)
                && within(&garment.drawn_vertices, drawn)
                && garment
                    .parts
                    .iter()
                    .all(|part| within(&part.triangles, faces) && part.material < outfit.materials.len())
        })
}

struct Encoder(Vec<u8>);

impl Encoder {
    fn word(&mut self, word: u32) {
        self.0.extend_from_slice(&word.to_le_bytes());
    }

    fn list<T: NoUninit>(&mut self, list: &[T]) {
        self.word(list.len() as u32);
        self.0.extend_from_slice(bytemuck::cast_slice(list));
    }

    fn text(&mut self, text: &str) {
        self.list(text.as_bytes());
    }

    fn range(&mut self, range: &Range<u32>) {
        self.word(range.start);
        self.word(range.end);
    }

    fn option<T>(&mut self, value: Option<&T>, write: impl FnOnce(&mut Self, &T)) {
        self.0.push(u8::from(value.is_some()));
        if let Some(value) = value {
            write(self, value);
        }
    }

    fn garment(&mut self, garment: &Garment) {
        self.text(&garment.name);
        self.word(garment.layer);
        self.range(&garment.vertices);
        self.range(&garment.drawn_vertices);
        self.word(garment.parts.len() as u32);
        for part in &garment.parts {
            self.word(part.material as u32);
            self.range(&part.triangles);
        }
    }

    fn material(&mut self, material: &Material) {
        self.text(&material.name);
        self.list(&material.base_color);
        self.list(&[material.roughness, material.metallic]);
        for picture in [&material.base_color_picture, &material.normal_picture] {
            self.option(picture.as_ref(), |out, picture| {
                out.text(&picture.mime_type);
                out.list(&picture.bytes);
            });
        }
        self.option(material.uv_transform.as_ref(), |out, UvTransform { offset, rotation, scale }| {
            out.list(&[offset[0], offset[1], *rotation, scale[0], scale[1]]);
        });
        self.option(material.sheen.as_ref(), |out, ([r, g, b], roughness)| {
            out.list(&[*r, *g, *b, *roughness])
        });
        self.option(material.alpha_cutoff.as_ref(), |out, cutoff| out.list(&[*cutoff]));
    }
}

struct Decoder<'a>(&'a [u8]);

impl Decoder<'_> {
    fn take(&mut self, count: usize) -> Result<&[u8], CodecError> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or(CodecError::Length)?;
        self.0 = rest;
        Ok(taken)
    }

    fn word(&mut self) -> Result<u32, CodecError> {
        let bytes = self.take(4)?;
        Ok(u32::from_le_bytes(*bytes.first_chunk().ok_or(CodecError::Length)?))
    }

    /// A count of things of at least `size` bytes each, so never more than the bytes can hold.
    fn count(&mut self, size: usize) -> Result<usize, CodecError> {
        let count = self.word()? as usize;
        let fits = count.checked_mul(size).is_some_and(|needed| needed <= self.0.len());
        if fits { Ok(count) } else { Err(CodecError::Length) }
    }

    fn list<T: AnyBitPattern>(&mut self) -> Result<Vec<T>, CodecError> {
        let count = self.count(size_of::<T>())?;
        let bytes = self.take(count * size_of::<T>())?;
        Ok(bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect())
    }

    fn floats<const N: usize>(&mut self) -> Result<[f32; N], CodecError> {
        self.list::<f32>()?.try_into().map_err(|_| CodecError::Inconsistent)
    }

    fn text(&mut self) -> Result<String, CodecError> {
        String::from_utf8(self.list()?).map_err(|_| CodecError::Inconsistent)
    }

    fn range(&mut self) -> Result<Range<u32>, CodecError> {
        Ok(self.word()?..self.word()?)
    }

    fn option<T>(
        &mut self,
        read: impl FnOnce(&mut Self) -> Result<T, CodecError>,
    ) -> Result<Option<T>, CodecError> {
        match self.take(1)? {
            [0] => Ok(None),
            [1] => read(self).map(Some),
            _ => Err(CodecError::Inconsistent),
        }
    }

    fn garment(&mut self) -> Result<Garment, CodecError> {
        let (name, layer) = (self.text()?, self.word()?);
        let (vertices, drawn_vertices) = (self.range()?, self.range()?);
        let part =
            |input: &mut Self| Ok(Part { material: input.word()? as usize, triangles: input.range()? });
        let parts = (0..self.count(12)?).map(|_| part(self)).collect::<Result<_, _>>()?;
        Ok(Garment { name, layer, vertices, drawn_vertices, parts })
    }

    fn picture(&mut self) -> Result<Option<Picture>, CodecError> {
        self.option(|input| Ok(Picture { mime_type: input.text()?, bytes: input.list()? }))
    }

    fn material(&mut self) -> Result<Material, CodecError> {
        let name = self.text()?;
        let base_color = self.floats()?;
        let [roughness, metallic] = self.floats()?;
        let (base_color_picture, normal_picture) = (self.picture()?, self.picture()?);
        let uv_transform = self.option(|input| {
            let [u, v, rotation, su, sv] = input.floats()?;
            Ok(UvTransform { offset: [u, v], rotation, scale: [su, sv] })
        })?;
        let sheen = self.option(|input| input.floats().map(|[r, g, b, roughness]| ([r, g, b], roughness)))?;
        let alpha_cutoff = self.option(|input| input.floats().map(|[cutoff]| cutoff))?;
        Ok(Material {
            name,
            base_color,
            base_color_picture,
            normal_picture,
            uv_transform,
            roughness,
            metallic,
            sheen,
            alpha_cutoff,
        })
    }
}
