//! Pictures of materials: PNG and JPEG, decoded once to be sure of them, kept as they came.

use std::io::Cursor;

use gltf::json::{Index, image as json_image};
use image::{ImageFormat, ImageReader, Limits};
use toile_drape::outfit::Picture;

use super::ReadError;
use super::document::{Document, decode_data_uri};

const MAX_SIDE: u32 = 8192;
const MAX_DECODED_BYTES: u64 = 256 * 1024 * 1024;
/// Pixels over all pictures of a file: one picture of the largest size.
const MAX_PIXELS: u64 = MAX_SIDE as u64 * MAX_SIDE as u64;

/// Reads each picture of a file at most once.
#[derive(Debug)]
pub(super) struct PictureReader<'a, 'd> {
    document: &'a Document<'d>,
    known: Vec<Option<Option<Picture>>>,
    pixels: u64,
}

impl<'a, 'd> PictureReader<'a, 'd> {
    pub(super) fn new(document: &'a Document<'d>) -> Self {
        Self { document, known: vec![None; document.root.images.len()], pixels: 0 }
    }

    /// The picture, or none (and a note) where it cannot be shown.
    pub(super) fn read(
        &mut self,
        index: Index<json_image::Image>,
        notes: &mut Vec<String>,
    ) -> Result<Option<Picture>, ReadError> {
        let position = index.value();
        if let Some(Some(known)) = self.known.get(position) {
            return Ok(known.clone());
        }
        let Some(image) = self.document.root.images.get(position) else {
            notes.push(format!(
                "A texture refers to image {position}, which does not exist; it was left out."
            ));
            return Ok(None);
        };
        let picture = match self.decode(image, position)? {
            Ok(picture) => Some(picture),
            Err(reason) => {
                notes.push(format!("Image {position} was left out: {reason}."));
                None
            }
        };
        if let Some(slot) = self.known.get_mut(position) {
            *slot = Some(picture.clone());
        }
        Ok(picture)
    }

    /// The outer error refuses the file, the inner one leaves the picture out.
    fn decode(
        &mut self,
        image: &json_image::Image,
        position: usize,
    ) -> Result<Result<Picture, String>, ReadError> {
        let bytes = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => decode_data_uri(uri, &format!("images[{position}]"))?,
            (None, Some(view)) => self.document.view(view)?.0.to_vec(),
            (None, None) => return Ok(Err("it has no data".into())),
        };
        let (format, mime_type) = match image::guess_format(&bytes) {
            Ok(ImageFormat::Png) => (ImageFormat::Png, "image/png"),
            Ok(ImageFormat::Jpeg) => (ImageFormat::Jpeg, "image/jpeg"),
            _ => return Ok(Err("it is neither PNG nor JPEG".into())),
        };
        let size = ImageReader::with_format(Cursor::new(&bytes), format).into_dimensions();
        let (width, height) = match size {
            Ok(size) => size,
            Err(error) => return Ok(Err(error.to_string())),
        };
        self.spend(width, height)?;
        let mut reader = ImageReader::with_format(Cursor::new(&bytes), format);
        let mut limits = Limits::default();
        limits.max_image_width = Some(MAX_SIDE);
        limits.max_image_height = Some(MAX_SIDE);
        limits.max_alloc = Some(MAX_DECODED_BYTES);
        reader.limits(limits);
        let decoded = reader.decode().map_err(|error| error.to_string());
        Ok(decoded.map(|_| Picture { mime_type: mime_type.to_owned(), bytes }))
    }

    fn spend(&mut self, width: u32, height: u32) -> Result<(), ReadError> {
        if width.max(height) > MAX_SIDE {
            let what = format!("an image of {width} × {height} pixels");
            return Err(ReadError::TooLarge { what, limit: MAX_SIDE as usize });
        }
        self.pixels += u64::from(width) * u64::from(height);
        if self.pixels > MAX_PIXELS {
            let what = format!("images of more than {MAX_PIXELS} pixels together");
            return Err(ReadError::TooLarge { what, limit: MAX_PIXELS as usize });
        }
        Ok(())
    }
}
