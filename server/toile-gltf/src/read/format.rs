//! What kind of file was uploaded, from its first bytes and its name.

use super::ReadError;

/// Formats that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Binary glTF 2.0.
    Glb,
    /// glTF 2.0 JSON with embedded buffers.
    Gltf,
    /// Wavefront OBJ.
    Obj,
}

impl Format {
    /// Tells the format from the contents first and the file name second.
    ///
    /// # Errors
    /// [`ReadError::NotAMesh`] when the name promises a format that the contents do not keep,
    /// [`ReadError::UnsupportedMediaType`] when neither says that it is a mesh.
    pub fn sniff(bytes: &[u8], file_name: Option<&str>) -> Result<Self, ReadError> {
        if bytes.starts_with(b"glTF") {
            return Ok(Self::Glb);
        }
        if first_visible(bytes) == Some(b'{') {
            return Ok(Self::Gltf);
        }
        if looks_like_obj(bytes) {
            return Ok(Self::Obj);
        }
        let extension = file_name.and_then(|name| name.rsplit_once('.')).map(|(_, e)| e.to_ascii_lowercase());
        match extension.as_deref() {
            Some("glb") if is_prefix_of_magic(bytes) => {
                Err(ReadError::Truncated("its header is incomplete".into()))
            }
            Some("glb") => Err(ReadError::NotAMesh("it does not begin with \"glTF\" as a GLB does".into())),
            Some("gltf") => Err(ReadError::NotAMesh("it is not a JSON object as a glTF is".into())),
            Some("obj") => Err(ReadError::NotAMesh("it has no vertex lines as an OBJ has".into())),
            _ => Err(ReadError::UnsupportedMediaType),
        }
    }
}

fn is_prefix_of_magic(bytes: &[u8]) -> bool {
    b"glTF".starts_with(bytes)
}

fn first_visible(bytes: &[u8]) -> Option<u8> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    text.iter().copied().find(|b| !b.is_ascii_whitespace())
}

/// Whether the first lines that are not comments are OBJ statements.
fn looks_like_obj(bytes: &[u8]) -> bool {
    const STATEMENTS: [&[u8]; 8] = [b"v", b"vt", b"vn", b"o", b"g", b"mtllib", b"usemtl", b"s"];
    let head = bytes.get(..65_536).unwrap_or(bytes);
    if head.contains(&0) {
        return false;
    }
    let mut lines = head
        .split(|b| *b == b'\n')
        .map(|line| line.trim_ascii())
        .filter(|line| !line.is_empty() && !line.starts_with(b"#"));
    lines.next().is_some_and(|line| {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        words.next().is_some_and(|word| STATEMENTS.contains(&word)) && words.next().is_some()
    })
}
