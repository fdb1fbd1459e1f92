//! The order of garments: as stated, and else the one nearer to the skin where two overlap.

use glam::Vec3;
use toile_geometry::nearest::PointTree;

use super::OutfitError;
use super::garments::Draft;
use super::placement::Placement;
use super::weld::Soup;

/// Vertices of different garments closer than this lie over one another, metres.
const OVERLAP_M: f32 = 0.04;
/// Vertices of a garment that are compared with each other garment.
const SAMPLES: usize = 1000;
/// Fewer pairs than this are a seam or a touch, not an overlap.
const LEAST_PAIRS: usize = 12;
/// Heights that differ by less are equal, metres.
const LEAST_GAP_M: f32 = 1e-4;

/// A garment's vertices for comparison.
struct Cloth {
    points: Vec<Vec3>,
    heights: Vec<f32>,
    tree: Option<PointTree>,
    low: Vec3,
    high: Vec3,
}

/// The layer of each draft, 0 next to the skin. Garments that do not overlap may share a layer.
pub(super) fn order(
    drafts: &[Draft],
    soup: &Soup,
    placement: &Placement,
    stated: &[String],
) -> Result<Vec<u32>, OutfitError> {
    let stated = stated_order(drafts, stated)?;
    let cloths: Vec<Cloth> = drafts.iter().map(|draft| Cloth::new(draft, soup, placement)).collect();
    let count = drafts.len();
    // over[inner][outer]: how sure it is that the one lies under the other.
    let mut over = vec![vec![0.0_f32; count]; count];
    for (a, cloth_a) in cloths.iter().enumerate() {
        for (b, cloth_b) in cloths.iter().enumerate().skip(a + 1) {
            let certainty = match (stated[a], stated[b]) {
                (Some(first), Some(second)) => {
                    if first < second {
                        f32::INFINITY
                    } else {
                        f32::NEG_INFINITY
                    }
                }
                _ => certainty_that_first_is_inner(cloth_a, cloth_b),
            };
            over[a][b] = certainty.max(0.0);
            over[b][a] = (-certainty).max(0.0);
        }
    }
    Ok(layers(&over))
}

/// For each draft its place in `stated`.
fn stated_order(drafts: &[Draft], stated: &[String]) -> Result<Vec<Option<usize>>, OutfitError> {
    let mut places = vec![None; drafts.len()];
    for (index, name) in stated.iter().enumerate() {
        let refuse = |problem| {
            let garments = drafts.iter().map(|draft| draft.name.as_str()).collect::<Vec<_>>().join(", ");
            OutfitError::InvalidLayers { index, name: name.clone(), problem, garments }
        };
        let draft =
            drafts.iter().position(|draft| draft.name == *name).ok_or_else(|| refuse("not a garment"))?;
        if places[draft].replace(index).is_some() {
            return Err(refuse("named twice"));
        }
    }
    Ok(places)
}

impl Cloth {
    fn new(draft: &Draft, soup: &Soup, placement: &Placement) -> Self {
        let faces = draft.faces.iter().filter_map(|&face| soup.faces.get(face as usize));
        let mut vertices: Vec<u32> = faces.flat_map(|face| face.welded).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let worn = vertices.into_iter().filter_map(|v| Some((soup.position(v), placement.skin(v)?.height)));
        let (points, heights): (Vec<Vec3>, Vec<f32>) = worn.unzip();
        let start = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let (low, high) = points.iter().fold(start, |(low, high), &p| (low.min(p), high.max(p)));
        let tree = PointTree::new(&points, |_| true);
        Self { points, heights, tree, low, high }
    }

    /// Heights of `other` over the skin minus own, where this one's samples lie over or under it.
    fn gaps_to(&self, other: &Self, gaps: &mut Vec<f32>) {
        let Some(tree) = &other.tree else { return };
        let step = self.points.len().div_ceil(SAMPLES).max(1);
        for (point, height) in self.points.iter().zip(&self.heights).step_by(step) {
            let beside = point.clamp(other.low, other.high).distance(*point) > OVERLAP_M;
            let hit = if beside { continue } else { tree.nearest(*point) };
            if let Some(other_height) =
                other.heights.get(hit.index as usize).filter(|_| hit.distance <= OVERLAP_M)
            {
                gaps.push(other_height - height);
            }
        }
    }
}

/// Positive when `first` lies under `second`, negative the other way round, zero where they do not overlap.
fn certainty_that_first_is_inner(first: &Cloth, second: &Cloth) -> f32 {
    let mut gaps = Vec::new();
    first.gaps_to(second, &mut gaps);
    let forward = gaps.len();
    second.gaps_to(first, &mut gaps);
    for gap in gaps.iter_mut().skip(forward) {
        *gap = -*gap;
    }
    if gaps.len() < LEAST_PAIRS {
        return 0.0;
    }
    let middle = gaps.len() / 2;
    let median = *gaps.select_nth_unstable_by(middle, f32::total_cmp).1;
    let agreeing = gaps.iter().filter(|gap| (**gap > 0.0) == (median > 0.0)).count();
    let certainty = agreeing as f32;
    // Where heights do not tell, the file's order does.
    if median > -LEAST_GAP_M { certainty.max(1.0) } else { -certainty.max(1.0) }
}

/// Takes the garment with the least certainly under it, again and again; a layer is one above what it covers.
fn layers(over: &[Vec<f32>]) -> Vec<u32> {
    let mut layers: Vec<u32> = vec![0; over.len()];
    let mut waiting: Vec<usize> = (0..over.len()).collect();
    let mut placed: Vec<usize> = Vec::new();
    while !waiting.is_empty() {
        let under = |outer: usize| waiting.iter().map(|&inner| over[inner][outer]).sum::<f32>();
        let costs: Vec<f32> = waiting.iter().map(|&garment| under(garment)).collect();
        let next = (0..waiting.len()).min_by(|&a, &b| costs[a].total_cmp(&costs[b])).unwrap_or(0);
        let garment = waiting.remove(next);
        let overlapping = placed.iter().filter(|&&inner| over[inner][garment] + over[garment][inner] > 0.0);
        layers[garment] = overlapping.map(|&inner| layers[inner] + 1).max().unwrap_or(0);
        placed.push(garment);
    }
    layers
}

#[cfg(test)]
mod tests {
    use super::layers;

    #[test]
    fn garments_that_do_not_overlap_share_a_layer() {
        // 0 under 1; 2 apart.
        assert_eq!(layers(&[vec![0.0, 5.0, 0.0], vec![0.0; 3], vec![0.0; 3]]), vec![0, 1, 0]);
    }

    #[test]
    fn a_cycle_is_cut_at_its_weakest_pair() {
        // 0 under 1 under 2, and weakly 2 under 0.
        let over = [vec![0.0, 9.0, 0.0], vec![0.0, 0.0, 9.0], vec![1.0, 0.0, 0.0]];
        assert_eq!(layers(&over), vec![0, 1, 2]);
    }
}
