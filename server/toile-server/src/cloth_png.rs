//! Cloth images as PNG: panels side by side, offsets along the pattern's u and v and off the skin as red, green and blue.

use std::io::Cursor;

use image::{ImageBuffer, ImageError, ImageFormat, Rgb, Rgba};
use toile_drape::methods::ClothImages;

/// Offset in metres that is full red, green or blue in 16 bits; none at all is the middle, and the way back is black.
pub const FULL: f32 = 0.25;
/// The same in the preview, which is for looking at.
const FULL_PREVIEW: f32 = 0.08;

/// Every number as it is: 16 bits a channel.
///
/// # Errors
/// When the images are not as large as they say.
pub fn exact(cloth: &ClothImages) -> Result<Vec<u8>, ImageError> {
    let level = |offset: f32| (unit(offset, FULL) * f32::from(u16::MAX)).round() as u16;
    let (width, height) = extent(cloth);
    let at = |x, y| Rgb(offset(cloth, x, y).map(level));
    encode(&ImageBuffer::<Rgb<u16>, Vec<u16>>::from_fn(width, height, at).into())
}

/// For people: 8 bits a channel, transparent off the cloth.
///
/// # Errors
/// When the images are not as large as they say.
pub fn preview(cloth: &ClothImages) -> Result<Vec<u8>, ImageError> {
    let level = |offset: f32| (unit(offset, FULL_PREVIEW) * 255.0).round() as u8;
    let (width, height) = extent(cloth);
    let side = cloth.side as u32;
    let pixel = |x: u32, y: u32| {
        let [r, g, b] = offset(cloth, x, y).map(level);
        let index = ((x / side) * side * side + y * side + x % side) as usize;
        Rgba([r, g, b, if cloth.mask.get(index).is_some_and(|on| *on) { 255 } else { 0 }])
    };
    encode(&ImageBuffer::<Rgba<u8>, Vec<u8>>::from_fn(width, height, pixel).into())
}

fn unit(offset: f32, full: f32) -> f32 {
    (0.5 + 0.5 * offset / full).clamp(0.0, 1.0)
}

fn extent(cloth: &ClothImages) -> (u32, u32) {
    let side = cloth.side.max(1);
    ((cloth.mask.len() / side) as u32, side as u32)
}

/// Metres along u, v and off the skin.
fn offset(cloth: &ClothImages, x: u32, y: u32) -> [f32; 3] {
    let (side, x, y) = (cloth.side, x as usize, y as usize);
    let first = 3 * (x / side) * side * side + y * side + x % side;
    [0, 1, 2].map(|channel| cloth.values.get(first + channel * side * side).copied().unwrap_or_default())
}

fn encode(picture: &image::DynamicImage) -> Result<Vec<u8>, ImageError> {
    let mut out = Cursor::new(Vec::new());
    picture.write_to(&mut out, ImageFormat::Png)?;
    Ok(out.into_inner())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn offsets_come_back_from_sixteen_bits_and_the_preview_is_clear_off_the_cloth() {
        let values: Vec<f32> = (0..24).map(|k| 0.01 * k as f32 - 0.1).collect();
        let mask = [true, true, false, true, true, true, true, true].to_vec();
        let cloth = ClothImages { garment: "tee".into(), side: 2, values: values.clone(), mask };
        let read = image::load_from_memory(&exact(&cloth).unwrap()).unwrap().into_rgb16();
        assert_eq!(read.dimensions(), (4, 2));
        let back = |x, y, c: usize| 2.0 * FULL * (f32::from(read.get_pixel(x, y).0[c]) / 65535.0 - 0.5);
        // Panel 1, row 1, column 0, off the skin.
        assert!((back(2, 1, 2) - values[12 + 8 + 2]).abs() < 1e-5);
        assert!((back(1, 0, 0) - values[1]).abs() < 1e-5);
        let seen = image::load_from_memory(&preview(&cloth).unwrap()).unwrap().into_rgba8();
        assert_eq!(seen.get_pixel(0, 1).0[3], 0);
        assert_eq!(seen.get_pixel(1, 1).0[3], 255);
    }
}
