//! Boxes on shelves in the unit square.

use glam::{Vec2, Vec2Swizzles};

/// Empty space around every box, of the square's side: two texels of 256.
pub(super) const GUTTER: f32 = 1.0 / 128.0;
/// The square grows by this factor until all fit, at most so often.
const GROWTH: f32 = 1.02;
const TRIES: usize = 400;

/// A box in the unit square.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Box2 {
    pub(super) low: Vec2,
    pub(super) high: Vec2,
}

/// Where a box went.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    pub(super) bounds: Box2,
    /// Unit squares a metre.
    scale: f32,
    /// Whether its width stands upright.
    turned: bool,
}

impl Place {
    /// From metres within the box to the unit square.
    pub(super) fn put(&self, inside: Vec2) -> Vec2 {
        self.bounds.low + self.scale * if self.turned { inside.yx() } else { inside }
    }
}

/// Lays boxes of these sizes (metres) side by side, as large as shelves allow. Nothing when gutters leave no room.
pub(super) fn pack(sizes: &[Vec2]) -> Option<Vec<Place>> {
    let turned: Vec<bool> = sizes.iter().map(|size| size.x > size.y).collect();
    let upright: Vec<Vec2> = sizes.iter().zip(&turned).map(|(s, t)| if *t { s.yx() } else { *s }).collect();
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    let height = |index: &usize| upright.get(*index).map_or(0.0, |size| size.y);
    order.sort_by(|a, b| height(b).total_cmp(&height(a)));
    let area: f32 = upright.iter().map(|size| size.x * size.y).sum();
    let largest = upright.iter().fold(0.0_f32, |most, size| most.max(size.x).max(size.y));
    let mut side = area.sqrt().max(largest);
    if !(side > 0.0 && side.is_finite()) {
        return None;
    }
    for _ in 0..TRIES {
        let boxes: Vec<Vec2> = upright.iter().map(|size| *size / side).collect();
        if let Some(corners) = on_shelves(&boxes, &order) {
            let place = |((low, size), turned): ((&Vec2, &Vec2), &bool)| {
                let bounds = Box2 { low: *low, high: *low + *size };
                Place { bounds, scale: 1.0 / side, turned: *turned }
            };
            return Some(corners.iter().zip(&boxes).zip(&turned).map(place).collect());
        }
        side *= GROWTH;
    }
    None
}

/// Low corners of boxes put on shelves of the unit square in this order, or nothing when they do not fit.
fn on_shelves(boxes: &[Vec2], order: &[usize]) -> Option<Vec<Vec2>> {
    let mut corners = vec![Vec2::ZERO; boxes.len()];
    let (mut next, mut shelf) = (Vec2::ZERO, 0.0_f32);
    for &index in order {
        let size = boxes.get(index)? + Vec2::splat(2.0 * GUTTER);
        if next.x + size.x > 1.0 {
            next = Vec2::new(0.0, next.y + shelf);
            shelf = 0.0;
        }
        if size.x > 1.0 || next.y + size.y > 1.0 {
            return None;
        }
        *corners.get_mut(index)? = next + Vec2::splat(GUTTER);
        next.x += size.x;
        shelf = shelf.max(size.y);
    }
    Some(corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_lie_apart_within_the_square_to_one_scale() {
        let sizes: Vec<Vec2> =
            (1..40_u16).map(|k| Vec2::new(f32::from(k % 7 + 1), f32::from(k % 5 + 1)) * 0.03).collect();
        let places = pack(&sizes).unwrap();
        for (index, (place, size)) in places.iter().zip(&sizes).enumerate() {
            let Box2 { low, high } = place.bounds;
            assert!(low.min_element() >= GUTTER - 1e-6 && high.max_element() <= 1.0 - GUTTER + 1e-6);
            assert!((place.put(*size) - high).length() < 1e-5, "the far corner is the box's");
            for other in places.iter().skip(index + 1) {
                let apart = (other.bounds.low - high).max(low - other.bounds.high).max_element();
                assert!(apart > 1.9 * GUTTER, "box {index} and another are {apart} apart");
            }
        }
        let filled: f32 = sizes.iter().map(|s| s.x * s.y).sum::<f32>() * places[0].scale.powi(2);
        assert!(filled > 0.5, "only {filled} of the square is used");
    }

    #[test]
    fn nothing_and_what_is_endless_do_not_fit() {
        assert!(pack(&[]).is_none() && pack(&[Vec2::ZERO]).is_none());
        assert!(pack(&[Vec2::new(f32::INFINITY, 1.0)]).is_none());
        assert!(pack(&vec![Vec2::splat(0.1); 5000]).is_none());
    }
}
