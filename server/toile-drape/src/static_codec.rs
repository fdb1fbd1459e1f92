//! The stored form of a static pass: named tensors (safetensors), checked on reading.

use std::borrow::Cow;
use std::collections::HashMap;

use bytemuck::Pod;
use glam::Vec3;
use safetensors::{Dtype, SafeTensors, View};
use toile_geometry::mesh::Adjacency;

use crate::binding::{CANDIDATES, SHAPE_SUPPORTS};
use crate::error::DrapeError;
use crate::fitted::FittedShapes;
use crate::graph::{Links, NEIGHBOURS, SUPPORTS};
use crate::layers::{LAYER_CANDIDATES, LayerContacts};
use crate::methods::deepsd::BASIS;
use crate::outfit::Outfit;
use crate::push_out::followers;
use crate::repair::garment_of_vertex;
use crate::settle::SettleTables;
use crate::static_pass::{NodeRig, Rig, StaticPass};

struct Column<'a> {
    dtype: Dtype,
    shape: [usize; 1],
    bytes: &'a [u8],
}

impl View for &Column<'_> {
    fn dtype(&self) -> Dtype {
        self.dtype
    }
    fn shape(&self) -> &[usize] {
        &self.shape
    }
    fn data(&self) -> Cow<'_, [u8]> {
        Cow::Borrowed(self.bytes)
    }
    fn data_len(&self) -> usize {
        self.bytes.len()
    }
}

fn floats(values: &[f32]) -> Column<'_> {
    Column { dtype: Dtype::F32, shape: [values.len()], bytes: bytemuck::cast_slice(values) }
}

fn indices(values: &[u32]) -> Column<'_> {
    Column { dtype: Dtype::U32, shape: [values.len()], bytes: bytemuck::cast_slice(values) }
}

fn small(values: &[u8]) -> Column<'_> {
    Column { dtype: Dtype::U8, shape: [values.len()], bytes: values }
}

impl StaticPass {
    /// The stored form.
    ///
    /// # Errors
    /// When the container cannot be written.
    pub fn to_bytes(&self) -> Result<Vec<u8>, DrapeError> {
        serialized(&self.columns(), None)
    }

    /// The stored form for others: also the `triangles` (T, 3) of the outfit and the `garment` of each vertex, innermost
    /// first, uint32, the hash of the `networks` in hexadecimal, uint8, its `positions` before any repair, what is
    /// drawn (the vertex of each of `drawn_vertices`, `drawn_triangles` and `uvs` over them, empty where there are
    /// none), and in the file's metadata as `static` the `key` of this static pass.
    ///
    /// # Errors
    /// When the container cannot be written.
    pub fn to_tensors(&self, outfit: &Outfit, key: &str, networks: &str) -> Result<Vec<u8>, DrapeError> {
        let garment = garment_of_vertex(outfit);
        let mut columns = self.columns();
        columns.push(("triangles", indices(outfit.triangles.as_flattened())));
        columns.push(("garment", indices(&garment)));
        columns.push(("networks", small(networks.as_bytes())));
        columns.push(("positions", floats(bytemuck::cast_slice(&outfit.positions))));
        columns.push(("drawn_vertices", indices(&outfit.surface.vertex_of)));
        columns.push(("drawn_triangles", indices(outfit.surface.triangles.as_flattened())));
        columns.push(("uvs", floats(bytemuck::cast_slice(&outfit.surface.uvs))));
        // One entry: several would come in any order.
        serialized(&columns, Some(HashMap::from([("static".to_owned(), key.to_owned())])))
    }

    fn columns(&self) -> Vec<(&'static str, Column<'_>)> {
        let (rig, settle) = (&self.rig, &self.settle);
        vec![
            ("rest", floats(bytemuck::cast_slice(&self.rest))),
            ("clearance", floats(&self.clearance)),
            ("joints", small(rig.joints.as_flattened())),
            ("weights", floats(rig.weights.as_flattened())),
            ("prior_joints", small(rig.prior_joints.as_flattened())),
            ("prior_weights", floats(rig.prior_weights.as_flattened())),
            ("basis", floats(&rig.basis)),
            ("descriptors", floats(&rig.descriptors)),
            ("node_positions", floats(bytemuck::cast_slice(&self.nodes.positions))),
            ("node_garment", indices(&self.nodes.garment)),
            ("node_joints", small(self.nodes.joints.as_flattened())),
            ("node_weights", floats(self.nodes.weights.as_flattened())),
            ("vertex_from_node", indices(&self.vertex_from_node.index)),
            ("vertex_from_node_weight", floats(&self.vertex_from_node.weight)),
            ("near", indices(&self.near.index)),
            ("near_weight", floats(&self.near.weight)),
            ("candidates", indices(&self.candidates)),
            ("shape", indices(&self.shape.index)),
            ("shape_weight", floats(&self.shape.weight)),
            ("layer_outer", indices(&self.layers.outer)),
            ("layer_inner", indices(&self.layers.inner)),
            ("layer_gap", floats(&self.layers.gap)),
            ("flutes", floats(&settle.flutes)),
            ("around", indices(settle.around.as_flattened())),
            ("pairs", indices(settle.pairs.as_flattened())),
            ("cluster_of", indices(&settle.cluster_of)),
            ("cluster_pairs", indices(settle.cluster_pairs.as_flattened())),
            ("node_from_cluster", indices(&settle.node_from_cluster.index)),
            ("node_from_cluster_weight", floats(&settle.node_from_cluster.weight)),
            ("edges", indices(self.edges.as_flattened())),
        ]
    }

    /// Reads the stored form back.
    ///
    /// # Errors
    /// When a tensor is missing, of another type or size, or points outside the outfit.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, DrapeError> {
        let file = Stored(SafeTensors::deserialize(bytes).map_err(|e| DrapeError::Stored(e.to_string()))?);
        let edges = as_rows::<u32, 2>(file.column("edges", Dtype::U32)?);
        let rest = file.points("rest")?;
        let (vertex_from_node, near) =
            (file.links("vertex_from_node", SUPPORTS)?, file.links("near", NEIGHBOURS)?);
        let both = edges.iter().flat_map(|[a, b]| [(*a, *b), (*b, *a)]).collect();
        let out = Self {
            clearance: file.floats("clearance")?,
            rig: file.rig()?,
            nodes: file.nodes()?,
            followers: followers(&vertex_from_node, near.len()),
            vertex_from_node,
            near,
            candidates: file.column("candidates", Dtype::U32)?,
            shape: file.links("shape", SHAPE_SUPPORTS)?,
            layers: LayerContacts {
                outer: file.column("layer_outer", Dtype::U32)?,
                inner: file.column("layer_inner", Dtype::U32)?,
                gap: file.floats("layer_gap")?,
            },
            settle: file.settle()?,
            ring: Adjacency::from_pairs(rest.len(), both),
            edges,
            fitted_shapes: FittedShapes::default(),
            rest,
        };
        out.checked()
    }

    fn checked(self) -> Result<Self, DrapeError> {
        let (n, nodes, rig, settle) = (self.rest.len(), self.near.len(), &self.rig, &self.settle);
        let sizes = self.clearance.len() == n
            && [rig.joints.len(), rig.weights.len(), rig.prior_joints.len(), rig.prior_weights.len()]
                == [n; 4]
            && [self.nodes.positions.len(), self.nodes.garment.len()] == [nodes; 2]
            && [self.nodes.joints.len(), self.nodes.weights.len()] == [nodes; 2]
            && rig.basis.len() == 3 * BASIS * nodes
            && self.vertex_from_node.len() == n
            && self.shape.len() == nodes
            && [settle.flutes.len(), settle.around.len(), settle.cluster_of.len()] == [nodes; 3]
            && settle.node_from_cluster.len() == nodes
            && self.candidates.len() == CANDIDATES * nodes
            && self.layers.inner.len() == LAYER_CANDIDATES * self.layers.outer.len()
            && self.layers.gap.len() == self.layers.outer.len();
        let clusters = settle.cluster_of.iter().max().map_or(0, |c| *c as usize + 1);
        let below = |list: &[u32], limit: usize| list.iter().all(|&i| (i as usize) < limit);
        let inside = below(self.edges.as_flattened(), n)
            && below(&self.layers.outer, n)
            && below(&self.layers.inner, n)
            && below(&self.vertex_from_node.index, nodes)
            && below(&self.near.index, nodes)
            && below(settle.around.as_flattened(), nodes)
            && below(settle.pairs.as_flattened(), nodes)
            && below(&settle.cluster_of, nodes)
            && below(settle.cluster_pairs.as_flattened(), clusters)
            && below(&settle.node_from_cluster.index, clusters);
        if sizes && inside {
            Ok(self)
        } else {
            Err(DrapeError::Stored("tables do not fit together".to_owned()))
        }
    }
}

fn serialized(
    columns: &[(&'static str, Column<'_>)],
    metadata: Option<HashMap<String, String>>,
) -> Result<Vec<u8>, DrapeError> {
    let views = columns.iter().map(|(name, column)| (*name, column));
    safetensors::serialize(views, metadata).map_err(|e| DrapeError::Stored(e.to_string()))
}

struct Stored<'a>(SafeTensors<'a>);

impl Stored<'_> {
    fn column<T: Pod>(&self, name: &str, dtype: Dtype) -> Result<Vec<T>, DrapeError> {
        let view = self.0.tensor(name).map_err(|e| DrapeError::Stored(format!("{name}: {e}")))?;
        if view.dtype() != dtype || !view.data().len().is_multiple_of(size_of::<T>()) {
            return Err(DrapeError::Stored(format!("{name} is not {dtype:?}")));
        }
        Ok(bytemuck::allocation::pod_collect_to_vec(view.data()))
    }

    fn floats(&self, name: &str) -> Result<Vec<f32>, DrapeError> {
        self.column(name, Dtype::F32)
    }

    fn links(&self, name: &str, width: usize) -> Result<Links, DrapeError> {
        let index: Vec<u32> = self.column(name, Dtype::U32)?;
        let weight = self.floats(&format!("{name}_weight"))?;
        if index.len() != weight.len() || !index.len().is_multiple_of(width) {
            return Err(DrapeError::Stored(format!("{name} is not {width} wide")));
        }
        Ok(Links { width, index, weight })
    }

    fn points(&self, name: &str) -> Result<Vec<Vec3>, DrapeError> {
        Ok(as_rows::<f32, 3>(self.floats(name)?).into_iter().map(Vec3::from_array).collect())
    }

    fn nodes(&self) -> Result<NodeRig, DrapeError> {
        Ok(NodeRig {
            positions: self.points("node_positions")?,
            garment: self.column("node_garment", Dtype::U32)?,
            joints: as_rows(self.column("node_joints", Dtype::U8)?),
            weights: as_rows(self.floats("node_weights")?),
        })
    }

    fn settle(&self) -> Result<SettleTables, DrapeError> {
        Ok(SettleTables {
            flutes: self.floats("flutes")?,
            around: as_rows(self.column("around", Dtype::U32)?),
            pairs: as_rows(self.column("pairs", Dtype::U32)?),
            cluster_of: self.column("cluster_of", Dtype::U32)?,
            cluster_pairs: as_rows(self.column("cluster_pairs", Dtype::U32)?),
            node_from_cluster: self.links("node_from_cluster", SUPPORTS)?,
        })
    }

    fn rig(&self) -> Result<Rig, DrapeError> {
        Ok(Rig {
            joints: as_rows(self.column("joints", Dtype::U8)?),
            weights: as_rows(self.floats("weights")?),
            prior_joints: as_rows(self.column("prior_joints", Dtype::U8)?),
            prior_weights: as_rows(self.floats("prior_weights")?),
            basis: self.floats("basis")?,
            descriptors: self.floats("descriptors")?,
        })
    }
}

fn as_rows<T: Copy, const W: usize>(values: Vec<T>) -> Vec<[T; W]> {
    values.as_chunks::<W>().0.to_vec()
}
