//! Where the outfit lies on the body: size, place, and each vertex's nearest body vertex.

use glam::Vec3;
use toile_geometry::nearest::PointTree;
use toile_geometry::normals::vertex_normals;

use super::OutfitError;
use super::weld::{Face, Soup};
use crate::outfit::Report;

/// Smallest and largest extent of an outfit, metres.
const EXTENT_M: std::ops::RangeInclusive<f32> = 0.05..=5.0;
/// Cloth further than this from the skin is not worn there, metres.
const REACH_M: f32 = 0.5;
/// Most vertices that may be beyond reach, percent.
const MOST_BEYOND_REACH: f32 = 50.0;
/// How far soles may lie below the feet, metres, and how many vertices may be lower, percent.
const SOLE_M: f32 = 0.08;
const MOST_BELOW_FLOOR: f32 = 25.0;

/// For every welded vertex what the body is like under it; none beyond reach.
#[derive(Debug)]
pub(super) struct Placement {
    under: Vec<Option<Skin>>,
}

/// The body under a vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct Skin {
    /// Height over the skin along its normal, negative inside, metres.
    pub(super) height: f32,
    /// Unit normal of the nearest body vertex.
    pub(super) normal: Vec3,
}

/// Refuses an outfit of a size that nobody wears.
pub(super) fn check_size(soup: &Soup, report: &Report) -> Result<(), OutfitError> {
    let corners = soup.faces.iter().flat_map(|face| soup.corners(face));
    let (min, max) = corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), p| (lo.min(p), hi.max(p)));
    let extent_m = (max - min).max_element();
    if EXTENT_M.contains(&extent_m) {
        return Ok(());
    }
    Err(OutfitError::WrongUnits { extent_m, scale: report.scale_applied })
}

impl Placement {
    /// Finds the body under every vertex that a face uses, and refuses outfits that are elsewhere.
    pub(super) fn measure(soup: &Soup, body: &[Vec3], triangles: &[[u32; 3]]) -> Result<Self, OutfitError> {
        let normals = vertex_normals(body, triangles);
        let tree = PointTree::new(body, |_| true);
        let (low, high) =
            body.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
        let is_used = used_vertices(soup);
        let skin_under = |vertex: usize, position: Vec3| {
            let beside = position.clamp(low, high).distance(position) > REACH_M;
            let hit = tree.as_ref().filter(|_| !beside)?.nearest(position);
            let (from, normal) = (*body.get(hit.index as usize)?, *normals.get(hit.index as usize)?);
            let within = hit.distance <= REACH_M && is_used.get(vertex).copied().unwrap_or(false);
            within.then_some(Skin { height: (position - from).dot(normal), normal })
        };
        let under: Vec<_> = soup.positions.iter().enumerate().map(|(i, &p)| skin_under(i, p)).collect();
        let placement = Self { under };
        placement.check_place(soup, &is_used, low.y)?;
        Ok(placement)
    }

    /// The body under a welded vertex, if it is within reach.
    pub(super) fn skin(&self, vertex: u32) -> Option<Skin> {
        self.under.get(vertex as usize).copied().flatten()
    }

    /// Mean body normal under a face's corners; zero where the body is out of reach.
    pub(super) fn outward(&self, face: &Face) -> Vec3 {
        face.welded.iter().filter_map(|&vertex| self.skin(vertex)).map(|skin| skin.normal).sum()
    }

    /// Share of the used vertices that lie inside the body, percent.
    pub(super) fn penetration_percent(&self, soup: &Soup) -> f32 {
        let is_used = used_vertices(soup);
        let inside = self.under.iter().flatten().filter(|skin| skin.height < 0.0).count();
        percent(inside, is_used.iter().filter(|used| **used).count())
    }

    fn check_place(&self, soup: &Soup, is_used: &[bool], floor: f32) -> Result<(), OutfitError> {
        let used = is_used.iter().filter(|used| **used).count();
        let beyond = percent(used - self.under.iter().flatten().count(), used);
        if beyond > MOST_BEYOND_REACH {
            return Err(OutfitError::OffBody {
                percent: beyond,
                place: "more than half a metre from the body",
            });
        }
        let is_low = |(position, used): &(&Vec3, &bool)| **used && position.y < floor - SOLE_M;
        let below = percent(soup.positions.iter().zip(is_used).filter(is_low).count(), used);
        if below > MOST_BELOW_FLOOR {
            return Err(OutfitError::OffBody { percent: below, place: "below the floor" });
        }
        Ok(())
    }
}

fn used_vertices(soup: &Soup) -> Vec<bool> {
    let mut used = vec![false; soup.positions.len()];
    for vertex in soup.faces.iter().flat_map(|face| face.welded) {
        if let Some(flag) = used.get_mut(vertex as usize) {
            *flag = true;
        }
    }
    used
}

fn percent(part: usize, whole: usize) -> f32 {
    if whole == 0 { 0.0 } else { 100.0 * part as f32 / whole as f32 }
}
