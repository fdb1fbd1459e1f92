//! A hero's network: a pose to cloth images by transpose convolutions (Jin et al. 2020, section 7). The graph is the same
//! for all; what they learned goes in with the pose.

use crate::error::DrapeError;
use crate::methods::deepsd::only;
use crate::network::{Networks, TensorRef};

/// The graph of `model/export_pixel.py`.
const GRAPH: &str = "pixel_cloth/decoder";
/// Transpose convolutions: the first makes 4 x 4 pixels, every other one doubles the side.
const LAYERS: usize = 7;
/// Pixels of a filter's side.
const KERNEL: usize = 4;
/// Pixels of an image's side.
pub const SIDE: usize = KERNEL << (LAYERS - 1);
/// Multiplications of a pose that are bearable: a fifth of a second.
const MOST_WORK: usize = 2_000_000_000;
const WEIGHTS: [&str; LAYERS] = ["weight0", "weight1", "weight2", "weight3", "weight4", "weight5", "weight6"];
const BIASES: [&str; LAYERS] = ["bias0", "bias1", "bias2", "bias3", "bias4", "bias5", "bias6"];

/// One transpose convolution, batch normalisation folded in.
#[derive(Debug)]
pub struct Layer {
    /// Channels in and out, rows and columns of the filters.
    pub shape: [usize; 4],
    /// In this shape.
    pub weight: Vec<f32>,
    /// One a channel out.
    pub bias: Vec<f32>,
}

/// The layers in order.
#[derive(Debug)]
pub struct Decoder(Vec<Layer>);

impl Decoder {
    /// Reads the layers by the names of their weights and biases, for `numbers` of a pose and so many `images`.
    ///
    /// # Errors
    /// When a layer does not follow from the one before, or the whole would take too long.
    pub fn read(
        layer: impl Fn(&str, &str) -> Result<Layer, DrapeError>,
        numbers: usize,
        images: usize,
    ) -> Result<Self, DrapeError> {
        let layers = WEIGHTS.iter().zip(BIASES).map(|(w, b)| layer(w, b)).collect::<Result<Vec<_>, _>>()?;
        let (mut inlet, mut work, mut area) = (numbers, 0_usize, KERNEL * KERNEL);
        for (index, Layer { shape: [from, to, rows, columns], weight, bias }) in layers.iter().enumerate() {
            let size = from * to * KERNEL * KERNEL;
            if [*from, *rows, *columns, weight.len(), bias.len()] != [inlet, KERNEL, KERNEL, size, *to] {
                return Err(DrapeError::Stored(format!("layer {index} does not follow from the one before")));
            }
            // Each of the first's filters is used once, each of the others' at every pixel that comes in.
            work = work.saturating_add(size.saturating_mul(if index == 0 { 1 } else { area }));
            area *= if index == 0 { 1 } else { 4 };
            inlet = *to;
        }
        if inlet != 3 * images || work > MOST_WORK {
            let reason = format!("{inlet} channels for {images} images, or too many weights");
            return Err(DrapeError::Stored(reason));
        }
        Ok(Self(layers))
    }

    /// Bytes in memory.
    pub fn byte_size(&self) -> usize {
        self.0.iter().map(|layer| size_of::<f32>() * (layer.weight.len() + layer.bias.len())).sum()
    }

    /// Cloth images of a pose, m: (images, 3, SIDE, SIDE), row-major.
    ///
    /// # Errors
    /// When the network fails.
    pub fn images(&self, pose: &[f32], networks: &mut dyn Networks) -> Result<Vec<f32>, DrapeError> {
        let pose_shape = [1, pose.len()];
        let biases: Vec<[usize; 1]> = self.0.iter().map(|layer| [layer.bias.len()]).collect();
        let mut inputs = vec![("pose", TensorRef::F32(&pose_shape, pose))];
        for (index, (layer, bias_shape)) in self.0.iter().zip(&biases).enumerate() {
            let names = WEIGHTS.get(index).zip(BIASES.get(index));
            inputs.extend(names.into_iter().flat_map(|(weight, bias)| {
                let weight = (*weight, TensorRef::F32(&layer.shape, &layer.weight));
                [weight, (*bias, TensorRef::F32(bias_shape, &layer.bias))]
            }));
        }
        let channels = biases.last().map_or(0, |[channels]| *channels);
        only(GRAPH, networks.run(GRAPH, &inputs)?, channels * SIDE * SIDE)
    }
}
