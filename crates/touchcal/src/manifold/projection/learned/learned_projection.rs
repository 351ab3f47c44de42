//! A trained network as a projection.

use nalgebra::Matrix6;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::network::{Back, CHUNK, Network, NetworkError, Stack};
use super::scaling::{Output, Scaling};
use crate::manifold::projection::coordinates::{Coordinates, Metric};
use crate::manifold::projection::projected::Projection;

/// Bytes of values that reverse mode holds at a time, if a chunk for each thread is not more. New
/// memory costs time too.
const MEMORY: usize = 8 << 20;
/// Width above which a layer's weights fill a core's cache.
const WIDE: usize = 1024;

/// A projection computed by a trained network, in single precision (Negi, Manyar & Gupta 2025,
/// arXiv 2506.17458). A pose that is not finite projects onto NaN. Angles of projected poses may
/// lie outside ±π.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LearnedProjection {
    network: Network,
    scaling: Scaling,
    bounds: [(f64, f64); 6],
}

impl LearnedProjection {
    /// A projection from a network of six inputs and six outputs, the scaling of both, and the
    /// least and greatest value, in this order, of each coordinate `[x, y, z, α, β, γ]` on the
    /// manifold it was trained for (m for 0–2, rad for 3–5). Scaling and bounds are not checked:
    /// scales must be positive, and no least value greater than the greatest.
    ///
    /// # Errors
    /// [`NetworkError::Shape`] if the network has not six inputs and six outputs.
    pub fn new(network: Network, scaling: Scaling, bounds: [(f64, f64); 6]) -> Result<Self, NetworkError> {
        let widths: Vec<usize> = network.widths().collect();
        for (layer, what, found) in [(0, "inputs", widths[0]), (widths.len() - 2, "outputs", widths[widths.len() - 1])]
        {
            if found != 6 {
                return Err(NetworkError::Shape { layer, what, expected: 6, found });
            }
        }
        Ok(LearnedProjection { network, scaling, bounds })
    }

    /// The trained network.
    pub fn network(&self) -> &Network {
        &self.network
    }

    /// Conversion between coordinates of poses and the network's inputs and outputs.
    pub fn scaling(&self) -> &Scaling {
        &self.scaling
    }

    /// The network's values for some poses.
    fn forward(&self, poses: &[Coordinates], values: &mut Stack) {
        values.reset(&self.network, poses.len());
        for (x, pose) in values.first_mut().chunks_exact_mut(6).zip(poses) {
            x.copy_from_slice(&self.scaling.input(pose));
        }
        self.network.run(values);
    }

    fn projected<'s>(&'s self, poses: &'s [Coordinates], values: &'s Stack) -> impl Iterator<Item = Coordinates> + 's {
        poses.iter().zip(values.last().chunks_exact(6)).map(|(pose, y)| self.scaling.projected(pose, y))
    }

    /// Derivatives by coordinates from those by the network's inputs; `direct` is what reaches them
    /// past the network.
    fn by_coordinates(&self, by_input: &[f32], direct: &Coordinates) -> Coordinates {
        let past = if self.scaling.output == Output::Correction { 1.0 } else { 0.0 };
        std::array::from_fn(|k| f64::from(by_input[k]) / self.scaling.input_scale[k] + past * direct[k])
    }

    /// `∂F/∂c` of poses whose values are known: as many passes back as there are outputs.
    fn jacobians(&self, values: &Stack, deltas: &mut Stack, jacobians: &mut [Matrix6<f64>]) {
        deltas.reset(&self.network, jacobians.len());
        let scale = self.scaling.output_scale();
        for (i, scale) in scale.into_iter().enumerate() {
            for delta in deltas.last_mut().chunks_exact_mut(6) {
                delta.fill(0.0);
                delta[i] = scale as f32;
            }
            self.network.run_back(values, deltas, Back::ToInput);
            let direct: Coordinates = std::array::from_fn(|k| f64::from(u8::from(k == i)));
            for (jacobian, by_input) in jacobians.iter_mut().zip(deltas.first().chunks_exact(6)) {
                jacobian.set_row(i, &self.by_coordinates(by_input, &direct).into());
            }
        }
    }

    /// Poses that one thread takes at a time. Each time wide layers are packed anew, which pays
    /// only for many.
    fn chunk(&self) -> usize {
        if self.network.widths().any(|width| width > WIDE) { 4 * CHUNK } else { CHUNK }
    }

    /// Poses whose values are held at a time: a chunk for each thread, or more where little memory
    /// is needed.
    fn held(&self) -> usize {
        let share = rayon::current_num_threads() * self.chunk();
        let bytes = size_of::<f32>() * self.network.widths().sum::<usize>() * share;
        (MEMORY / bytes).max(1) * share
    }
}

impl Projection for LearnedProjection {
    fn name(&self) -> &'static str {
        "learned projection"
    }

    fn metric(&self) -> Metric {
        self.scaling.metric
    }

    fn bounds(&self) -> [(f64, f64); 6] {
        self.bounds
    }

    fn project(&self, poses: &[Coordinates], projected: &mut Vec<Coordinates>) {
        projected.clear();
        projected.resize(poses.len(), [0.0; 6]);
        let chunk = self.chunk();
        let chunks = poses.par_chunks(chunk).zip(projected.par_chunks_mut(chunk));
        chunks.for_each_init(Stack::default, |values, (poses, projected)| {
            self.forward(poses, values);
            projected.iter_mut().zip(self.projected(poses, values)).for_each(|(into, each)| *into = each);
        });
    }

    fn linearize(&self, poses: &[Coordinates], projected: &mut Vec<Coordinates>, jacobians: &mut Vec<Matrix6<f64>>) {
        projected.clear();
        projected.resize(poses.len(), [0.0; 6]);
        jacobians.clear();
        jacobians.resize(poses.len(), Matrix6::zeros());
        let chunk = self.chunk();
        let chunks = poses.par_chunks(chunk).zip(projected.par_chunks_mut(chunk)).zip(jacobians.par_chunks_mut(chunk));
        chunks.for_each_init(<(Stack, Stack)>::default, |(values, deltas), ((poses, projected), jacobians)| {
            self.forward(poses, values);
            projected.iter_mut().zip(self.projected(poses, values)).for_each(|(into, each)| *into = each);
            self.jacobians(values, deltas, jacobians);
        });
    }

    fn pull_back(
        &self,
        poses: &[Coordinates],
        cotangent: &mut dyn FnMut(usize, &Coordinates) -> Coordinates,
        pulled: &mut Vec<Coordinates>,
    ) {
        pulled.clear();
        pulled.reserve(poses.len());
        let (chunk, scale) = (self.chunk(), self.scaling.output_scale());
        let (mut values, mut deltas) = (Vec::new(), Vec::new());
        for poses in poses.chunks(self.held()) {
            values.resize(poses.len().div_ceil(chunk), Stack::default());
            deltas.resize(values.len(), Stack::default());
            poses.par_chunks(chunk).zip(&mut values).for_each(|(poses, values)| self.forward(poses, values));
            let first = pulled.len();
            for (poses, values) in poses.chunks(chunk).zip(&values) {
                for onto in self.projected(poses, values) {
                    pulled.push(cotangent(pulled.len(), &onto));
                }
            }
            let chunks = pulled[first..].par_chunks_mut(chunk).zip(&values).zip(&mut deltas);
            chunks.for_each(|((pulled, values), deltas)| {
                deltas.reset(&self.network, pulled.len());
                for (delta, y) in deltas.last_mut().chunks_exact_mut(6).zip(&*pulled) {
                    delta.iter_mut().zip(y.iter().zip(scale)).for_each(|(d, (y, scale))| *d = (y * scale) as f32);
                }
                self.network.run_back(values, deltas, Back::ToInput);
                for (y, by_input) in pulled.iter_mut().zip(deltas.first().chunks_exact(6)) {
                    *y = self.by_coordinates(by_input, y);
                }
            });
        }
    }
}
