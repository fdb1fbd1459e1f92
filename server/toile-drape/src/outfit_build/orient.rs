//! Winding: neighbours agree, and faces look away from the body.

use super::faces::{Side, sides};
use super::placement::Placement;
use super::weld::Soup;
use crate::outfit::Report;

/// A vote weaker than this share of the patch's area leaves the file's own winding.
const LEAST_MAJORITY: f32 = 0.05;

/// Two faces over an edge of exactly two, and whether one must turn for them to agree.
#[derive(Clone, Copy, Debug)]
struct Hinge {
    other: u32,
    turns: bool,
}

/// Turns faces so that each patch is wound one way: a closed patch outwards, an open one away from the skin.
pub(super) fn orient(soup: &mut Soup, placement: &Placement, report: &mut Report) {
    let sides = sides(soup);
    let hinges = hinges(&sides, soup.faces.len());
    let is_open = open_faces(&sides, soup.faces.len());
    let mut turned: Vec<Option<bool>> = vec![None; soup.faces.len()];
    for start in 0..soup.faces.len() {
        if turned.get(start).copied().flatten().is_none() {
            let patch = spread(start as u32, &hinges, &mut turned);
            if should_turn(&patch, &turned, soup, placement, &is_open) {
                for &face in &patch {
                    if let Some(Some(flag)) = turned.get_mut(face as usize) {
                        *flag = !*flag;
                    }
                }
            }
        }
    }
    for (face, _) in soup.faces.iter_mut().zip(&turned).filter(|(_, turn)| **turn == Some(true)) {
        face.drawn.swap(1, 2);
        face.welded.swap(1, 2);
        report.flipped_normals += 1;
    }
}

fn hinges(sides: &[Side], faces: usize) -> Vec<Vec<Hinge>> {
    let mut hinges = vec![Vec::new(); faces];
    for pair in sides.chunk_by(|a, b| a.edge == b.edge) {
        if let [a, b] = pair {
            let turns = a.ascending == b.ascending;
            for (from, to) in [(a, b), (b, a)] {
                if let Some(list) = hinges.get_mut(from.face as usize) {
                    list.push(Hinge { other: to.face, turns });
                }
            }
        }
    }
    hinges
}

/// Faces with a side that is not shared by exactly two.
fn open_faces(sides: &[Side], faces: usize) -> Vec<bool> {
    let mut open = vec![false; faces];
    for side in sides.chunk_by(|a, b| a.edge == b.edge).filter(|edge| edge.len() != 2).flatten() {
        if let Some(flag) = open.get_mut(side.face as usize) {
            *flag = true;
        }
    }
    open
}

/// The faces that hang together with `start`, each marked as turned or not so that all agree with it.
fn spread(start: u32, hinges: &[Vec<Hinge>], turned: &mut [Option<bool>]) -> Vec<u32> {
    let mut patch = Vec::new();
    let mut stack = vec![(start, false)];
    while let Some((face, turn)) = stack.pop() {
        let Some(mark) = turned.get_mut(face as usize).filter(|mark| mark.is_none()) else { continue };
        *mark = Some(turn);
        patch.push(face);
        let around = hinges.get(face as usize).into_iter().flatten();
        stack.extend(around.map(|hinge| (hinge.other, turn != hinge.turns)));
    }
    patch
}

fn should_turn(
    patch: &[u32],
    turned: &[Option<bool>],
    soup: &Soup,
    placement: &Placement,
    is_open: &[bool],
) -> bool {
    let is_closed = !patch.iter().any(|&face| is_open.get(face as usize).copied().unwrap_or(true));
    let (mut vote, mut volume, mut area, mut kept) = (0.0_f32, 0.0_f32, 0.0_f32, 0.0_f32);
    let middle = patch
        .first()
        .and_then(|&face| soup.faces.get(face as usize))
        .map_or(glam::Vec3::ZERO, |f| soup.corners(f)[0]);
    for &index in patch {
        let Some(face) = soup.faces.get(index as usize) else { continue };
        let turns = turned.get(index as usize).copied().flatten().unwrap_or(false);
        let normal = if turns { -soup.area_vector(face) } else { soup.area_vector(face) };
        let size = normal.length();
        vote += normal.dot(placement.outward(face).normalize_or_zero());
        volume += (soup.corners(face)[0] - middle).dot(normal);
        area += size;
        kept += if turns { -size } else { size };
    }
    if is_closed {
        return volume < 0.0;
    }
    if vote.abs() > LEAST_MAJORITY * area { vote < 0.0 } else { kept < 0.0 }
}
