//! The framing of a GLB: header and chunk lengths (glTF 2.0, chapter 4).

use super::{Format, ReadError};

const JSON_CHUNK: u32 = 0x4E4F_534A;
const BINARY_CHUNK: u32 = 0x004E_4942;

/// The parts of a glTF file.
#[derive(Debug)]
pub(super) struct Container<'a> {
    pub(super) json: &'a [u8],
    pub(super) binary: Option<&'a [u8]>,
}

impl<'a> Container<'a> {
    pub(super) fn open(bytes: &'a [u8], format: Format) -> Result<Self, ReadError> {
        match format {
            Format::Glb => Self::open_glb(bytes),
            Format::Gltf | Format::Obj => {
                Ok(Self { json: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), binary: None })
            }
        }
    }

    fn open_glb(bytes: &'a [u8]) -> Result<Self, ReadError> {
        let (magic, version, length) = match (bytes.get(..4), word(bytes, 4), word(bytes, 8)) {
            (Some(magic), Some(version), Some(length)) => (magic, version, length as usize),
            _ => return Err(ReadError::Truncated("its header is incomplete".into())),
        };
        if magic != b"glTF" || version != 2 {
            return Err(ReadError::NotAMesh(format!(
                "it is not a GLB of version 2 (found version {version})"
            )));
        }
        if length > bytes.len() {
            let message = format!("its header states {length} bytes, there are {}", bytes.len());
            return Err(ReadError::Truncated(message));
        }
        if length < bytes.len() {
            let message = format!("its header states {length} bytes, but there are {}", bytes.len());
            return Err(ReadError::NotAMesh(message));
        }
        let mut rest = bytes.get(12..).unwrap_or_default();
        let json = next_chunk(&mut rest)?.filter(|chunk| chunk.kind == JSON_CHUNK);
        let Some(json) = json else { return Err(ReadError::NotAMesh("its first chunk is not JSON".into())) };
        let mut binary = None;
        while let Some(chunk) = next_chunk(&mut rest)? {
            if chunk.kind == BINARY_CHUNK && binary.is_none() {
                binary = Some(chunk.data);
            }
        }
        Ok(Self { json: json.data, binary })
    }
}

struct Chunk<'a> {
    kind: u32,
    data: &'a [u8],
}

/// Takes a chunk off the front; none at the end.
fn next_chunk<'a>(rest: &mut &'a [u8]) -> Result<Option<Chunk<'a>>, ReadError> {
    if rest.is_empty() {
        return Ok(None);
    }
    let (Some(length), Some(kind)) = (word(rest, 0), word(rest, 4)) else {
        return Err(ReadError::Truncated("a chunk header is incomplete".into()));
    };
    let body = rest.get(8..).unwrap_or_default();
    let Some((data, after)) = body.split_at_checked(length as usize) else {
        return Err(ReadError::Truncated(format!("a chunk states {length} bytes, there are {}", body.len())));
    };
    *rest = after;
    Ok(Some(Chunk { kind, data }))
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..)?.first_chunk().map(|word| u32::from_le_bytes(*word))
}
