//! Which units and which up-axis a file uses: stated, or told from where it lies on the reference body.

use std::str::FromStr;

use glam::{Vec2, Vec3};
use toile_drape::outfit::{RawMesh, Report};

use super::ReadError;

/// Units of length of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Units {
    /// Metres.
    Metres,
    /// Centimetres.
    Centimetres,
    /// Millimetres.
    Millimetres,
    /// Inches.
    Inches,
}

impl Units {
    const ALL: [Self; 4] = [Self::Metres, Self::Centimetres, Self::Millimetres, Self::Inches];

    /// Metres in one unit.
    #[must_use]
    pub fn in_metres(self) -> f32 {
        match self {
            Self::Metres => 1.0,
            Self::Centimetres => 0.01,
            Self::Millimetres => 0.001,
            Self::Inches => 0.0254,
        }
    }

    /// The unit in words.
    fn words(self) -> &'static str {
        match self {
            Self::Metres => "metres",
            Self::Centimetres => "centimetres",
            Self::Millimetres => "millimetres",
            Self::Inches => "inches",
        }
    }

    /// Symbol at the API: `m`, `cm`, `mm` or `in`.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Metres => "m",
            Self::Centimetres => "cm",
            Self::Millimetres => "mm",
            Self::Inches => "in",
        }
    }
}

impl FromStr for Units {
    type Err = String;

    fn from_str(symbol: &str) -> Result<Self, String> {
        let known = Self::ALL.into_iter().find(|unit| unit.symbol() == symbol);
        known.ok_or_else(|| format!("\"{symbol}\" is not a unit; use m, cm, mm or in"))
    }
}

/// Which axis of a file points up. Z-up files face −Y, as in Blender.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Up {
    /// Y up, facing +Z, as in glTF.
    Y,
    /// Z up, facing −Y.
    Z,
}

impl Up {
    const ALL: [Self; 2] = [Self::Y, Self::Z];

    /// Symbol at the API: `y` or `z`.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Y => "y",
            Self::Z => "z",
        }
    }

    fn to_gltf_axes(self, p: Vec3) -> Vec3 {
        match self {
            Self::Y => p,
            Self::Z => Vec3::new(p.x, p.z, -p.y),
        }
    }
}

impl FromStr for Up {
    type Err = String;

    fn from_str(symbol: &str) -> Result<Self, String> {
        let known = Self::ALL.into_iter().find(|up| up.symbol() == symbol);
        known.ok_or_else(|| format!("\"{symbol}\" is not an up-axis; use y or z"))
    }
}

/// What the uploader states about the file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Hints {
    /// Units of length; detected when absent.
    pub units: Option<Units>,
    /// Up-axis; detected when absent.
    pub up: Option<Up>,
}

/// The reference body's bounding box, metres, glTF axes.
const BODY_MIN: Vec3 = Vec3::new(-0.591, 0.0, -0.103);
const BODY_MAX: Vec3 = Vec3::new(0.591, 1.838, 0.374);
/// How far clothes may reach beyond that box: hats and shoulders up, soles down, trains and flares sideways.
const REACH_ABOVE: f32 = 0.3;
const REACH_BELOW: f32 = 0.15;
const REACH_ASIDE: f32 = 0.6;
/// Smallest and largest plausible extent of an outfit, metres.
const EXTENT: std::ops::RangeInclusive<f32> = 0.05..=3.0;
/// A reading of the file that makes it so many times smaller than another is not meant.
const TOY_SCALE: f32 = 5.0;

#[derive(Clone, Copy, Debug)]
struct Bounds {
    min: Vec3,
    max: Vec3,
}

impl Bounds {
    fn of(points: impl Iterator<Item = Vec3>) -> Option<Self> {
        points.fold(None, |bounds, p| match bounds {
            None => Some(Self { min: p, max: p }),
            Some(b) => Some(Self { min: b.min.min(p), max: b.max.max(p) }),
        })
    }

    fn mapped(self, units: Units, up: Up) -> Self {
        let (a, b) =
            (up.to_gltf_axes(self.min) * units.in_metres(), up.to_gltf_axes(self.max) * units.in_metres());
        Self { min: a.min(b), max: a.max(b) }
    }

    fn extent(self) -> f32 {
        (self.max - self.min).max_element()
    }

    fn is_worn(self) -> bool {
        let low = BODY_MIN - Vec3::new(REACH_ASIDE, REACH_BELOW, REACH_ASIDE);
        let high = BODY_MAX + Vec3::new(REACH_ASIDE, REACH_ABOVE, REACH_ASIDE);
        let overlaps = self.min.cmple(BODY_MAX).all() && self.max.cmpge(BODY_MIN).all();
        EXTENT.contains(&self.extent()) && overlaps && self.min.cmpge(low).all() && self.max.cmple(high).all()
    }
}

/// Converts the meshes to metres and glTF axes in place and writes what was assumed into `report`.
pub(super) fn normalise(meshes: &mut [RawMesh], hints: &Hints, report: &mut Report) -> Result<(), ReadError> {
    let used = meshes.iter().flat_map(|mesh| {
        let corners = mesh.parts.iter().flat_map(|part| part.triangles.iter().flatten());
        corners.filter_map(|&corner| mesh.positions.get(corner as usize).copied())
    });
    let bounds = Bounds::of(used).ok_or(ReadError::NoTriangles)?;
    let (units, up) = choose(bounds, hints, &mut report.notes)?;
    for position in meshes.iter_mut().flat_map(|mesh| mesh.positions.iter_mut()) {
        *position = up.to_gltf_axes(*position) * units.in_metres();
    }
    report.scale_applied = units.in_metres();
    report.units = units.symbol().to_owned();
    report.up_axis = up.symbol().to_owned();
    Ok(())
}

fn choose(bounds: Bounds, hints: &Hints, notes: &mut Vec<String>) -> Result<(Units, Up), ReadError> {
    if let (Some(units), Some(up)) = (hints.units, hints.up) {
        return Ok((units, up));
    }
    let candidates = Units::ALL
        .into_iter()
        .filter(|unit| hints.units.is_none_or(|stated| stated == *unit))
        .flat_map(|unit| Up::ALL.map(|up| (unit, up)))
        .filter(|(_, up)| hints.up.is_none_or(|stated| stated == *up));
    let mut worn: Vec<(Units, Up)> =
        candidates.filter(|&(units, up)| bounds.mapped(units, up).is_worn()).collect();
    // A skirt in centimetres is not a toy one in millimetres at the ankles.
    let largest = worn.iter().map(|(units, _)| units.in_metres()).fold(0.0, f32::max);
    worn.retain(|(units, _)| units.in_metres() * TOY_SCALE > largest);
    let usual = (hints.units.unwrap_or(Units::Metres), hints.up.unwrap_or(Up::Y));
    match worn.as_slice() {
        // glTF is in metres and Y up: where that fits, it is what the file means.
        fitting if fitting.contains(&usual) => Ok(usual),
        [only] => {
            let (units, up) = (only.0.words(), only.1.symbol());
            notes.push(format!(
                "The file was taken to be in {units} with {up} up, because only so it lies on the body."
            ));
            Ok(*only)
        }
        [] => fallback(bounds, usual, hints),
        several => Err(ReadError::WrongUnits(ambiguous(several))),
    }
}

/// Nothing lies on the body: a plausible size is a matter of placement, which is judged on the mesh itself.
fn fallback(bounds: Bounds, usual: (Units, Up), hints: &Hints) -> Result<(Units, Up), ReadError> {
    let extent = bounds.extent() * usual.0.in_metres();
    if hints.units.is_some() || EXTENT.contains(&extent) {
        return Ok(usual);
    }
    Err(ReadError::WrongUnits(format!(
        "the outfit is {} units across, which fits a body in none of m, cm, mm and in",
        bounds.extent()
    )))
}

fn ambiguous(several: &[(Units, Up)]) -> String {
    let list: Vec<String> =
        several.iter().map(|(units, up)| format!("in {} with {} up", units.words(), up.symbol())).collect();
    format!("the outfit would lie on the body {}", list.join(" or "))
}

/// UVs of OBJ count from the bottom, those of glTF from the top.
pub(super) fn uv_from_bottom_left(uv: Vec2) -> Vec2 {
    Vec2::new(uv.x, 1.0 - uv.y)
}
