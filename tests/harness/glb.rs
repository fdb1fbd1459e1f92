//! Looking into GLBs.

use serde_json::Value;

const JSON_CHUNK: u32 = 0x4e4f_534a;
const BINARY_CHUNK: u32 = 0x004e_4942;

/// A GLB, taken apart.
#[derive(Clone, Debug)]
pub struct Glb {
    /// The JSON chunk.
    pub json: Value,
    binary: Vec<u8>,
}

impl Glb {
    /// Takes a GLB apart.
    #[track_caller]
    pub fn parse(bytes: &[u8]) -> Self {
        assert_eq!(&bytes[..4], b"glTF", "not a GLB");
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
        assert_eq!(word(8) as usize, bytes.len(), "the length in the header is wrong");
        let json_length = word(12) as usize;
        assert_eq!(word(16), JSON_CHUNK);
        let json = serde_json::from_slice(&bytes[20..20 + json_length]).expect("JSON");
        assert_eq!(word(24 + json_length), BINARY_CHUNK);
        Self { json, binary: bytes[28 + json_length..].to_vec() }
    }

    /// Names of the nodes, in order.
    pub fn nodes(&self) -> Vec<String> {
        let nodes = self.json["nodes"].as_array().expect("nodes");
        nodes.iter().map(|node| node["name"].as_str().unwrap_or("").to_owned()).collect()
    }

    /// The first primitive of a node's mesh.
    #[track_caller]
    pub fn primitive(&self, node: &str) -> &Value {
        let nodes = self.json["nodes"].as_array().expect("nodes");
        let found = nodes.iter().find(|candidate| candidate["name"] == node);
        let mesh = found.unwrap_or_else(|| panic!("no node {node}: {:?}", self.nodes()))["mesh"].as_u64();
        &self.json["meshes"][mesh.expect("a mesh") as usize]["primitives"][0]
    }

    /// Whether a node's mesh has this attribute.
    pub fn has_attribute(&self, node: &str, name: &str) -> bool {
        self.primitive(node)["attributes"].get(name).is_some()
    }

    /// Positions of a node's mesh.
    #[track_caller]
    pub fn positions(&self, node: &str) -> Vec<[f32; 3]> {
        let values = self.floats(self.primitive(node)["attributes"]["POSITION"].as_u64().expect("positions"));
        values.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect()
    }

    /// Values of an attribute of a node's mesh.
    #[track_caller]
    pub fn attribute(&self, node: &str, name: &str) -> Vec<f32> {
        self.floats(self.primitive(node)["attributes"][name].as_u64().expect("an attribute"))
    }

    /// Bytes of the indices of a node's mesh.
    pub fn index_bytes(&self, node: &str) -> Vec<u8> {
        self.view(self.primitive(node)["indices"].as_u64().expect("indices")).to_vec()
    }

    /// Triangles of a node's mesh.
    #[track_caller]
    pub fn triangles(&self, node: &str) -> Vec<[u32; 3]> {
        let accessor = self.primitive(node)["indices"].as_u64().expect("indices");
        let width = if self.json["accessors"][accessor as usize]["componentType"] == 5123 { 2 } else { 4 };
        let bytes = self.index_bytes(node);
        let index = |b: &[u8]| b.iter().rev().fold(0, |sum, byte| sum << 8 | u32::from(*byte));
        let all: Vec<u32> = bytes.chunks_exact(width).map(index).collect();
        all.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect()
    }

    fn floats(&self, accessor: u64) -> Vec<f32> {
        let described = &self.json["accessors"][accessor as usize];
        assert_eq!(described["componentType"], 5126, "not floats");
        let width = match described["type"].as_str() {
            Some("SCALAR") => 1,
            Some("VEC2") => 2,
            Some("VEC4") => 4,
            _ => 3,
        };
        let count = described["count"].as_u64().expect("a count") as usize;
        let stride = self.stride(described).unwrap_or(4 * width);
        let elements = self.view(accessor).chunks(stride).take(count);
        let values = elements.flat_map(|element| element[..4 * width].chunks_exact(4));
        values.map(|b| f32::from_le_bytes(b.try_into().expect("four bytes"))).collect()
    }

    fn stride(&self, accessor: &Value) -> Option<usize> {
        let view = &self.json["bufferViews"][accessor["bufferView"].as_u64()? as usize];
        view["byteStride"].as_u64().map(|stride| stride as usize)
    }

    fn view(&self, accessor: u64) -> &[u8] {
        let described = &self.json["accessors"][accessor as usize];
        let view = &self.json["bufferViews"][described["bufferView"].as_u64().expect("a view") as usize];
        let offset = |value: &Value| value["byteOffset"].as_u64().unwrap_or(0) as usize;
        let start = offset(view);
        &self.binary
            [start + offset(described)..start + view["byteLength"].as_u64().expect("a length") as usize]
    }
}

/// Frames JSON and binary as a GLB.
pub fn glb_of_json(json: &Value, binary: &[u8]) -> Vec<u8> {
    let padded = |bytes: &[u8], fill: u8| {
        let mut bytes = bytes.to_vec();
        bytes.resize(bytes.len().next_multiple_of(4), fill);
        bytes
    };
    let (json, binary) = (padded(json.to_string().as_bytes(), b' '), padded(binary, 0));
    let words = |words: &[u32]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
    let length = 28 + json.len() + binary.len();
    let head = words(&[u32::from_le_bytes(*b"glTF"), 2, length as u32, json.len() as u32, JSON_CHUNK]);
    [head, json, words(&[binary.len() as u32, BINARY_CHUNK]), binary].concat()
}
