//! The shape basis, compact: 16-bit, blocks that are all zero left out.

/// Values a block: 64 vertices. Its accumulator stays in the first-level cache.
const BLOCK: usize = 192;

/// A basis of vertex positions over shape coefficients, quantised to 16 bits a value.
#[derive(Debug, Default)]
pub struct ShapeBasis {
    /// Metres of one step, per coefficient.
    steps: Vec<f32>,
    blocks: Vec<Block>,
    packed: Vec<i16>,
}

/// A run of `BLOCK` values, and which coefficients move any of them.
#[derive(Debug)]
struct Block {
    coefficients: Vec<u16>,
    start: usize,
}

impl ShapeBasis {
    /// Packs dense rows: `values` is (coefficients, vertices × 3), `steps` one per coefficient.
    ///
    /// `None` when the sizes do not fit each other.
    #[must_use]
    pub fn pack(values: &[i16], steps: Vec<f32>) -> Option<Self> {
        let width = values.len().checked_div(steps.len())?;
        if width * steps.len() != values.len() || steps.len() > usize::from(u16::MAX) {
            return None;
        }
        let mut out = Self { steps, ..Self::default() };
        for from in (0..width).step_by(BLOCK) {
            let to = (from + BLOCK).min(width);
            let mut block = Block { coefficients: Vec::new(), start: out.packed.len() };
            for (k, row) in (0_u16..).zip(values.chunks_exact(width)) {
                if row[from..to].iter().any(|&v| v != 0) {
                    block.coefficients.push(k);
                    out.packed.extend_from_slice(&row[from..to]);
                    out.packed.resize(block.start + block.coefficients.len() * BLOCK, 0);
                }
            }
            out.blocks.push(block);
        }
        out.packed.shrink_to_fit();
        Some(out)
    }

    /// Adds coefficients × basis to `out` (x, y, z, x, …), metres.
    pub fn accumulate(&self, coefficients: &[f32], out: &mut [f32]) {
        let scaled: Vec<f32> = coefficients.iter().zip(&self.steps).map(|(c, step)| c * step).collect();
        for (block, out) in self.blocks.iter().zip(out.chunks_mut(BLOCK)) {
            for (&k, row) in block.coefficients.iter().zip(self.rows(block)) {
                let scale = scaled.get(usize::from(k)).copied().unwrap_or(0.0);
                if scale != 0.0 {
                    out.iter_mut().zip(row).for_each(|(o, &v)| *o += scale * f32::from(v));
                }
            }
        }
    }

    /// One row of values for each coefficient of a block.
    fn rows(&self, block: &Block) -> &[[i16; BLOCK]] {
        self.packed.get(block.start..).unwrap_or(&[]).as_chunks().0
    }

    /// How vertex `v` moves with every coefficient, metres, (coefficients,).
    #[must_use]
    pub fn of_vertex(&self, v: usize) -> Vec<[f32; 3]> {
        let mut out = vec![[0.0; 3]; self.steps.len()];
        let (index, offset) = (v * 3 / BLOCK, v * 3 % BLOCK);
        let Some(block) = self.blocks.get(index) else { return out };
        for (&k, row) in block.coefficients.iter().zip(self.rows(block)) {
            let k = usize::from(k);
            if let (Some(out), Some(&step)) = (out.get_mut(k), self.steps.get(k)) {
                *out = [0, 1, 2].map(|axis| f32::from(row[offset + axis]) * step);
            }
        }
        out
    }

    /// Number of coefficients.
    #[must_use]
    pub fn coefficient_count(&self) -> usize {
        self.steps.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 3 coefficients over 100 vertices; the second touches vertex 90 alone.
    fn sample() -> (Vec<i16>, Vec<f32>) {
        let mut values = vec![0_i16; 900];
        for (i, v) in values.iter_mut().enumerate() {
            *v = if i / 300 == 1 { 0 } else { (i * 37 % 201) as i16 - 100 };
        }
        values[300 + 271] = 7;
        (values, vec![0.5, 0.25, 0.125])
    }

    #[test]
    fn a_packed_basis_sums_as_the_dense_one_and_drops_empty_blocks() {
        let (values, steps) = sample();
        let basis = ShapeBasis::pack(&values, steps.clone()).unwrap();
        assert_eq!(basis.packed.len(), 5 * BLOCK);
        let mut out = vec![1.0; 300];
        basis.accumulate(&[1.0, 2.0, -3.0], &mut out);
        for (i, o) in out.iter().enumerate() {
            let at = |k: usize| f32::from(values[k * 300 + i]) * steps[k];
            assert_eq!(*o, 1.0 + at(0) + 2.0 * at(1) - 3.0 * at(2), "value {i}");
        }
        assert_eq!(basis.of_vertex(90)[1], [0.0, 7.0 * 0.25, 0.0]);
    }

    #[test]
    fn sizes_that_do_not_fit_are_refused() {
        assert!(ShapeBasis::pack(&[0; 10], vec![1.0; 3]).is_none());
        assert!(ShapeBasis::pack(&[0; 10], Vec::new()).is_none());
    }
}
