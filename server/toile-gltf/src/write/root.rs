//! The JSON of a scene.

use serde_json::{Map, Value, json};

/// The JSON lists that nodes add to.
#[derive(Default)]
pub(super) struct SceneRoot {
    pub(super) nodes: Vec<Value>,
    pub(super) meshes: Vec<Value>,
    pub(super) materials: Vec<Value>,
    pub(super) images: Vec<Value>,
    pub(super) extensions: Vec<&'static str>,
    pub(super) animation: Option<Value>,
}

impl SceneRoot {
    pub(super) fn add_node(&mut self, name: &str, primitives: Vec<Value>, layer: Option<u32>) {
        let mut node = json!({"name": name, "mesh": self.meshes.len()});
        if let Some(layer) = layer {
            node["extras"] = json!({"layer": layer});
        }
        self.nodes.push(node);
        self.meshes.push(json!({"name": name, "primitives": primitives}));
    }

    pub(super) fn into_json(self, name: &str) -> Map<String, Value> {
        let mut root = Map::new();
        let mut put = |key: &str, value: Value| root.insert(key.to_owned(), value);
        let textures: Vec<Value> =
            (0..self.images.len()).map(|i| json!({"sampler": 0, "source": i})).collect();
        put("asset", json!({"version": "2.0", "generator": "toile"}));
        put("scene", json!(0));
        put("scenes", json!([{"name": name, "nodes": (0..self.nodes.len()).collect::<Vec<_>>()}]));
        put("nodes", self.nodes.into());
        put("meshes", self.meshes.into());
        put("materials", self.materials.into());
        if !textures.is_empty() {
            put("samplers", json!([{"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497}]));
            put("textures", textures.into());
            put("images", self.images.into());
        }
        if let Some(animation) = self.animation {
            put("animations", json!([animation]));
        }
        if !self.extensions.is_empty() {
            put("extensionsUsed", json!(self.extensions));
        }
        root
    }
}
