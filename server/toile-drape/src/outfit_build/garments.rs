//! Grouping connected pieces into garments: a mesh is a garment, its large pieces are garments of their own,
//! and small ones (buttons, pockets, buckles) go with the nearest.

use std::collections::{BTreeMap, HashSet};

use glam::Vec3;
use toile_geometry::nearest::PointTree;

use super::components::Component;
use super::weld::Soup;
use super::{OutfitError, OutfitSource};
use crate::outfit::Report;

/// A piece with this share of the largest piece's area is a garment, not an ornament.
const LARGE_SHARE: f32 = 0.08;
/// A mesh of small pieces alone with this share is still a garment of its own.
const MESH_SHARE: f32 = 0.02;
/// A mesh in more large pieces than this is one garment in pieces, not so many garments.
const MOST_PER_MESH: usize = 12;
const MOST_GARMENTS: usize = 24;
/// Points by which a small piece looks for its garment, and pieces that are looked for at all.
const SAMPLES: usize = 8;
const MOST_SEARCHED: usize = 4096;
const LONGEST_NAME: usize = 80;
/// The name of the body's node in a drape, so no garment may have it.
const BODY_NODE: &str = "body";

/// A garment to be.
#[derive(Clone, Debug)]
pub(super) struct Draft {
    pub(super) name: String,
    /// Indices into the soup's faces, ascending.
    pub(super) faces: Vec<u32>,
}

/// Groups the components; drafts in file order, within a mesh by size.
pub(super) fn group(
    soup: &Soup,
    components: &[Component],
    source: &OutfitSource,
    report: &mut Report,
) -> Result<Vec<Draft>, OutfitError> {
    let mut groups = Groups::default();
    let largest = components.iter().map(|component| component.area).fold(0.0, f32::max);
    let mut by_mesh: BTreeMap<u32, Vec<&Component>> = BTreeMap::new();
    for component in components {
        by_mesh.entry(component.mesh).or_default().push(component);
    }
    let mut ornaments = Vec::new();
    for (mesh, pieces) in by_mesh {
        let file_name = source.meshes.get(mesh as usize).map_or("", |mesh| mesh.name.as_str());
        let area: f32 = pieces.iter().map(|piece| piece.area).sum();
        let is_named = source.layers.iter().any(|layer| layer == file_name);
        if area >= MESH_SHARE * largest || is_named {
            groups.add_mesh(soup, file_name, pieces, largest);
        } else {
            ornaments.extend(pieces);
        }
    }
    let everything = 0..groups.drafts.len();
    groups.join(soup, &ornaments, everything);
    if groups.drafts.len() > MOST_GARMENTS {
        return Err(OutfitError::TooLarge { count: groups.drafts.len(), limit: MOST_GARMENTS });
    }
    report.notes.extend(match groups.joined {
        0 => None,
        1 => Some("1 small piece goes with the garment nearest to it.".to_owned()),
        count => Some(format!("{count} small pieces go with the garment nearest to them.")),
    });
    Ok(named(groups.drafts, source))
}

#[derive(Default)]
struct Groups {
    drafts: Vec<Draft>,
    joined: usize,
}

impl Groups {
    fn add_mesh(&mut self, soup: &Soup, name: &str, pieces: Vec<&Component>, largest: f32) {
        let is_large = |piece: &&Component| piece.area >= LARGE_SHARE * largest;
        let (mut large, small): (Vec<&Component>, Vec<&Component>) =
            pieces.iter().copied().partition(is_large);
        if large.is_empty() || large.len() > MOST_PER_MESH {
            let mut faces: Vec<u32> = pieces.iter().flat_map(|piece| &piece.faces).copied().collect();
            faces.sort_unstable();
            self.drafts.push(Draft { name: name.to_owned(), faces });
            return;
        }
        large.sort_by(|a, b| b.area.total_cmp(&a.area));
        let first = self.drafts.len();
        self.drafts.extend(
            large.into_iter().map(|piece| Draft { name: name.to_owned(), faces: piece.faces.clone() }),
        );
        let own = first..self.drafts.len();
        self.join(soup, &small, own);
    }

    /// Gives each piece to that of the drafts in `among` to which most of its points are nearest: a tie whose tip
    /// touches the waistband goes with the shirt that it lies on.
    fn join(&mut self, soup: &Soup, pieces: &[&Component], among: std::ops::Range<usize>) {
        let Some(first) =
            self.drafts.get(among.clone()).filter(|drafts| !drafts.is_empty()).map(|_| among.start)
        else {
            return;
        };
        let mut points: Vec<Vec3> = Vec::new();
        let mut owners: Vec<usize> = Vec::new();
        for (index, draft) in self.drafts.iter().enumerate().take(among.end).skip(first) {
            for face in draft.faces.iter().filter_map(|&face| soup.faces.get(face as usize)) {
                points.extend(soup.corners(face));
                owners.resize(points.len(), index);
            }
        }
        let tree = if among.len() > 1 { PointTree::new(&points, |_| true) } else { None };
        for (position, piece) in pieces.iter().enumerate() {
            let tree = tree.as_ref().filter(|_| position < MOST_SEARCHED);
            let mut votes: BTreeMap<usize, (usize, f32)> = BTreeMap::new();
            for hit in
                piece.samples(soup, SAMPLES).into_iter().filter_map(|sample| Some(tree?.nearest(sample)))
            {
                let Some(owner) = owners.get(hit.index as usize) else { continue };
                let (count, away) = votes.entry(*owner).or_default();
                (*count, *away) = (*count + 1, *away + hit.distance);
            }
            let most = votes.into_iter().max_by(|(_, a), (_, b)| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
            let owner = most.map_or(first, |(owner, _)| owner);
            if let Some(draft) = self.drafts.get_mut(owner) {
                draft.faces.extend(&piece.faces);
            }
        }
        for draft in &mut self.drafts {
            draft.faces.sort_unstable();
        }
        self.joined += pieces.len();
    }
}

/// Gives every draft a name of its own: `shirt`, `shirt-2`, …
fn named(mut drafts: Vec<Draft>, source: &OutfitSource) -> Vec<Draft> {
    let mut taken: HashSet<String> = HashSet::from([BODY_NODE.to_owned()]);
    let from_file: HashSet<String> = drafts.iter().map(|draft| cleaned(&draft.name)).collect();
    for draft in &mut drafts {
        let mut base = cleaned(&draft.name);
        if base.is_empty() {
            base = source
                .name
                .as_deref()
                .map(cleaned)
                .filter(|name| !name.is_empty())
                .unwrap_or("garment".into());
        }
        let mut name = base.clone();
        let mut number = 2;
        // A mesh that is called shirt-2 keeps that name, whatever shirt falls into.
        while taken.contains(&name) || (name != base && from_file.contains(&name)) {
            name = format!("{base}-{number}");
            number += 1;
        }
        taken.insert(name.clone());
        draft.name = name;
    }
    drafts
}

fn cleaned(name: &str) -> String {
    let visible: String = name.chars().filter(|c| !c.is_control()).take(LONGEST_NAME).collect();
    visible.trim().to_owned()
}
