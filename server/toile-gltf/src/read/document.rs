//! The JSON of a glTF file, checked before anything is read through it, and its buffers.

use std::borrow::Cow;

use base64::Engine;
use gltf::json::{Index, Root, buffer};

use super::container::Container;
use super::{Format, ReadError, node};

const MAX_NODES: usize = 4096;
const MAX_IMAGES: usize = 64;
const MAX_BUFFERS: usize = 64;

/// Required extensions that do not keep us from reading positions, UVs and triangles.
const HARMLESS_EXTENSIONS: [&str; 3] =
    ["KHR_mesh_quantization", "KHR_texture_transform", "KHR_lights_punctual"];

/// A parsed file; its buffers are there after [`Document::with_buffers`].
#[derive(Debug)]
pub(super) struct Document<'a> {
    pub(super) root: Root,
    binary: Option<&'a [u8]>,
    buffers: Vec<Option<Cow<'a, [u8]>>>,
}

impl<'a> Document<'a> {
    /// Parses and checks the JSON.
    pub(super) fn open(bytes: &'a [u8], format: Format) -> Result<Self, ReadError> {
        let container = Container::open(bytes, format)?;
        let root = parse(container.json)?;
        check_version(&root)?;
        check_extensions(&root)?;
        check_counts(&root)?;
        check_references(&root)?;
        node::check_tree(&root)?;
        Ok(Self { root, binary: container.binary, buffers: Vec::new() })
    }

    /// Decodes `data:` buffers and attaches the binary chunk.
    pub(super) fn with_buffers(mut self) -> Result<Self, ReadError> {
        for (index, buffer) in self.root.buffers.iter().enumerate() {
            let data = match &buffer.uri {
                Some(uri) => Some(Cow::Owned(decode_data_uri(uri, &format!("buffers[{index}]"))?)),
                None => self.binary.filter(|_| index == 0).map(Cow::Borrowed),
            };
            if let Some(data) = &data {
                check_buffer_length(index, buffer, data.len())?;
            }
            self.buffers.push(data);
        }
        Ok(self)
    }

    /// The bytes of a buffer view and its stride.
    pub(super) fn view(&self, index: Index<buffer::View>) -> Result<(&[u8], Option<usize>), ReadError> {
        let invalid =
            |what: &str| ReadError::InvalidAccessor(format!("bufferViews[{}] {what}", index.value()));
        let view = self.root.buffer_views.get(index.value()).ok_or_else(|| invalid("does not exist"))?;
        let data = self.buffers.get(view.buffer.value()).and_then(Option::as_deref);
        let data = data.ok_or_else(|| invalid("has no buffer with data"))?;
        let start = usize::try_from(view.byte_offset.map_or(0, |offset| offset.0)).ok();
        let length = usize::try_from(view.byte_length.0).ok();
        let range = start.zip(length).and_then(|(start, length)| Some(start..start.checked_add(length)?));
        let bytes =
            range.and_then(|range| data.get(range)).ok_or_else(|| invalid("reaches beyond its buffer"))?;
        Ok((bytes, view.byte_stride.map(|stride| stride.0)))
    }

    /// Name of the scene that is shown, if it has one.
    pub(super) fn scene_name(&self) -> Option<String> {
        let index = self.root.scene.map_or(0, |scene| scene.value());
        self.root.scenes.get(index)?.name.clone()
    }
}

fn parse(json: &[u8]) -> Result<Root, ReadError> {
    Root::from_slice(json).map_err(|error| {
        if error.is_eof() {
            ReadError::Truncated(format!("its JSON is incomplete ({error})"))
        } else {
            ReadError::NotAMesh(format!("its JSON is not glTF 2.0 ({error})"))
        }
    })
}

fn check_version(root: &Root) -> Result<(), ReadError> {
    let version = &root.asset.version;
    if version.split('.').next() == Some("2") {
        return Ok(());
    }
    Err(ReadError::NotAMesh(format!("it is glTF {version:.20}, and only glTF 2 can be read")))
}

fn check_extensions(root: &Root) -> Result<(), ReadError> {
    let unsupported = root
        .extensions_required
        .iter()
        .find(|name| !name.starts_with("KHR_materials_") && !HARMLESS_EXTENSIONS.contains(&name.as_str()));
    match unsupported {
        Some(name) => Err(ReadError::UnsupportedExtension(name.chars().take(80).collect())),
        None => Ok(()),
    }
}

fn check_counts(root: &Root) -> Result<(), ReadError> {
    let counts = [
        (root.nodes.len(), "nodes", MAX_NODES),
        (root.images.len(), "images", MAX_IMAGES),
        (root.buffers.len(), "buffers", MAX_BUFFERS),
    ];
    match counts.into_iter().find(|(count, _, limit)| count > limit) {
        Some((count, what, limit)) => Err(ReadError::too_large(count, what, limit)),
        None => Ok(()),
    }
}

fn check_references(root: &Root) -> Result<(), ReadError> {
    let buffers = root.buffers.iter().map(|buffer| buffer.uri.as_deref()).enumerate();
    let images = root.images.iter().map(|image| image.uri.as_deref()).enumerate();
    let named = buffers.map(|(i, uri)| ("buffers", i, uri)).chain(images.map(|(i, uri)| ("images", i, uri)));
    for (list, index, uri) in named {
        if uri.is_some_and(|uri| !is_data_uri(uri)) {
            return Err(ReadError::ExternalUri { what: format!("{list}[{index}]") });
        }
    }
    Ok(())
}

fn is_data_uri(uri: &str) -> bool {
    uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:"))
}

/// Decodes `data:<type>;base64,<data>`; `what` names the object that holds it.
pub(super) fn decode_data_uri(uri: &str, what: &str) -> Result<Vec<u8>, ReadError> {
    let payload = uri.split_once(',').filter(|(head, _)| head.to_ascii_lowercase().ends_with(";base64"));
    let Some((_, payload)) = payload.filter(|_| is_data_uri(uri)) else {
        return Err(ReadError::NotAMesh(format!("the data URI of {what} is not base64")));
    };
    let engine = base64::engine::general_purpose::GeneralPurpose::new(
        &base64::alphabet::STANDARD,
        base64::engine::GeneralPurposeConfig::new()
            .with_decode_padding_mode(base64::engine::DecodePaddingMode::Indifferent),
    );
    engine
        .decode(payload.trim())
        .map_err(|error| ReadError::NotAMesh(format!("the data URI of {what}: {error}")))
}

fn check_buffer_length(index: usize, buffer: &buffer::Buffer, available: usize) -> Result<(), ReadError> {
    let stated = buffer.byte_length.0;
    if usize::try_from(stated).is_ok_and(|stated| stated <= available) {
        return Ok(());
    }
    Err(ReadError::Truncated(format!("buffers[{index}] states {stated} bytes, there are {available}")))
}
