//! The stored form of a hero's tables (safetensors), checked on reading.

use glam::Vec3;
use safetensors::tensor::{Dtype, SafeTensors};

use super::decoder::{Decoder, Layer};
use super::{Filter, Hero, SIDE, Site, by_cell};
use crate::error::DrapeError;
use crate::reference::GARMENT_JOINTS;

impl Hero {
    /// Reads a hero's tables and weights and checks that nothing points outside of them or of a body of `vertices`.
    ///
    /// # Errors
    /// When the file is not such tables.
    pub fn from_safetensors(bytes: &[u8], vertices: usize) -> Result<Self, DrapeError> {
        let file = Tables(SafeTensors::deserialize(bytes).map_err(|e| DrapeError::Stored(e.to_string()))?);
        let rest = file.points("rest")?;
        let (images, mask) = file.mask()?;
        let sites = file.sites(rest.len(), vertices, mask.len())?;
        let filter = Filter { mean: file.points("filter_mean")?, components: file.points("filter")? };
        if filter.mean.len() != sites.len() || !filter.components.len().is_multiple_of(sites.len()) {
            return Err(DrapeError::Stored("the filter is not of the sites".to_owned()));
        }
        let (joints, sees_legs) = (file.joints()?, file.data("legs", Dtype::U8)?.1 == [1]);
        let decoder = Decoder::read(|w, b| file.layer(w, b), 9 * joints.len(), images)?;
        let cells = by_cell(&rest);
        Ok(Self { mask, sees_legs, decoder, rest, cells, joints, sites, filter })
    }
}

/// Numbers of things and their weights.
type Weighted = Vec<(usize, f32)>;

fn unfit() -> DrapeError {
    DrapeError::Stored("the tables of the sites do not fit each other".to_owned())
}

struct Tables<'a>(SafeTensors<'a>);

impl Tables<'_> {
    fn data(&self, name: &str, dtype: Dtype) -> Result<(Vec<usize>, &[u8]), DrapeError> {
        let tensor = self.0.tensor(name).map_err(|e| DrapeError::Stored(format!("{name}: {e}")))?;
        if tensor.dtype() != dtype {
            return Err(DrapeError::Stored(format!("{name} is {:?}, not {dtype:?}", tensor.dtype())));
        }
        let bytes = self.0.tensor(name).map(|t| t.data()).map_err(|e| DrapeError::Stored(e.to_string()))?;
        Ok((tensor.shape().to_vec(), bytes))
    }

    fn floats<const N: usize>(&self, name: &str) -> Result<Vec<[f32; N]>, DrapeError> {
        let (_, bytes) = self.data(name, Dtype::F32)?;
        let values: Vec<f32> = bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        if !values.len().is_multiple_of(N) || values.iter().any(|v| !v.is_finite()) {
            return Err(DrapeError::Stored(format!("{name} does not hold rows of {N} finite numbers")));
        }
        Ok(values.as_chunks::<N>().0.to_vec())
    }

    fn points(&self, name: &str) -> Result<Vec<Vec3>, DrapeError> {
        Ok(self.floats::<3>(name)?.into_iter().map(Vec3::from_array).collect())
    }

    /// The sites of a garment of `own` vertices on a body of `body`, in images of `pixels`.
    fn sites(&self, own: usize, body: usize, pixels: usize) -> Result<Vec<Site>, DrapeError> {
        let (vertex, pixel) = (self.indices("vertex", own)?, self.indices("pixel", pixels)?);
        let (share, pixel_weight) = (self.floats::<1>("share")?, self.floats::<4>("pixel_weight")?);
        let count = vertex.len();
        let corners = self.weighted("corner", "corner_weight", (count, body))?;
        let along = self.weighted("around", "along", (count, count))?;
        let pixel = pixel.as_chunks::<4>().0;
        if count == 0 || [pixel.len(), share.len(), pixel_weight.len()] != [count; 3] {
            return Err(unfit());
        }
        let lists = corners.into_iter().zip(along);
        let site = |(k, (corners, along)): (usize, (Weighted, Weighted))| Site {
            vertex: vertex[k],
            share: share[k][0],
            corners,
            along,
            pixel: pixel[k],
            pixel_weight: pixel_weight[k],
        };
        Ok(lists.enumerate().map(site).collect())
    }

    /// For each of `count` sites what it is made of below `limit`, and the weights, those of 0 left out.
    fn weighted(
        &self,
        indices: &str,
        weights: &str,
        (count, limit): (usize, usize),
    ) -> Result<Vec<Weighted>, DrapeError> {
        let (index, weight) = (self.indices(indices, limit)?, self.floats::<1>(weights)?);
        let wide = weight.len() / count.max(1);
        if wide == 0 || weight.len() != wide * count || index.len() != weight.len() {
            return Err(unfit());
        }
        let pairs = index.into_iter().zip(weight.into_iter().map(|[w]| w)).collect::<Weighted>();
        let used = |row: &[(usize, f32)]| row.iter().copied().filter(|(_, w)| *w != 0.0).collect();
        Ok(pairs.chunks_exact(wide).map(used).collect())
    }

    fn integers(&self, name: &str) -> Result<Vec<i32>, DrapeError> {
        let (_, bytes) = self.data(name, Dtype::I32)?;
        Ok(bytes.as_chunks::<4>().0.iter().map(|b| i32::from_le_bytes(*b)).collect())
    }

    fn indices(&self, name: &str, limit: usize) -> Result<Vec<usize>, DrapeError> {
        let outside = || DrapeError::Stored(format!("{name} points outside of its table"));
        let inside = |i: i32| usize::try_from(i).ok().filter(|i| *i < limit).ok_or_else(outside);
        self.integers(name)?.into_iter().map(inside).collect()
    }

    fn joints(&self) -> Result<Vec<(Option<usize>, usize)>, DrapeError> {
        let pairs = self.integers("joints")?;
        let (pairs, rest) = pairs.as_chunks::<2>();
        let joint = |i: i32| usize::try_from(i).ok().filter(|joint| *joint < GARMENT_JOINTS);
        let known = |[of, to]: &[i32; 2]| match of {
            -1 => Some((None, joint(*to)?)),
            of => Some((Some(joint(*of)?), joint(*to)?)),
        };
        let pairs = pairs.iter().map(known).collect::<Option<Vec<_>>>();
        match pairs.filter(|pairs| rest.is_empty() && (1..=GARMENT_JOINTS).contains(&pairs.len())) {
            Some(pairs) => Ok(pairs),
            None => Err(DrapeError::Stored("joints are not pairs of joints".to_owned())),
        }
    }

    /// Images and the mask.
    fn mask(&self) -> Result<(usize, Vec<bool>), DrapeError> {
        let (shape, bytes) = self.data("mask", Dtype::U8)?;
        match *shape.as_slice() {
            [images, SIDE, SIDE] if images > 0 => Ok((images, bytes.iter().map(|b| *b != 0).collect())),
            _ => Err(DrapeError::Stored(format!("mask is not (images, {SIDE}, {SIDE})"))),
        }
    }

    /// A layer of the decoder, by the names of its weight and bias.
    fn layer(&self, weight: &str, bias: &str) -> Result<Layer, DrapeError> {
        let (shape, _) = self.data(weight, Dtype::F32)?;
        let of_rank_four = || DrapeError::Stored(format!("{weight} is not of rank 4"));
        let shape: [usize; 4] = shape.try_into().map_err(|_| of_rank_four())?;
        let (weight, bias) = (self.floats::<1>(weight)?, self.floats::<1>(bias)?);
        Ok(Layer { shape, weight: weight.as_flattened().to_vec(), bias: bias.as_flattened().to_vec() })
    }
}
