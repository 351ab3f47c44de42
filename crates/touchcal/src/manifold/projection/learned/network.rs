//! A perceptron of many layers in single precision, and its derivatives.

use nalgebra::{DMatrixView, DMatrixViewMut, Dyn};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

/// Rows of a batch that are worked on together, and rows of weights that are. Work is divided by
/// these and not by the number of threads, so that results don't depend on it; 128 is where the
/// product of matrices comes near its best speed.
pub(super) const CHUNK: usize = 128;

/// A view of a matrix with arbitrary strides.
type View<'v> = DMatrixView<'v, f32, Dyn, Dyn>;
type ViewMut<'v> = DMatrixViewMut<'v, f32, Dyn, Dyn>;

/// nalgebra multiplies matrices of which a dimension is at most this without blocking. There
/// nalgebra 0.35 takes a left factor whose columns are not contiguous for a longer one.
const UNBLOCKED: usize = 5;

/// The transpose of a row-major matrix: `rows × columns`, its columns contiguous.
fn transposed(values: &[f32], rows: usize, columns: usize) -> View<'_> {
    View::from_slice_with_strides(values, rows, columns, 1, rows)
}

/// The same, to be written to.
fn transposed_mut(values: &mut [f32], rows: usize, columns: usize) -> ViewMut<'_> {
    ViewMut::from_slice_with_strides_mut(values, rows, columns, 1, rows)
}

/// A fully connected layer `y = W x + b`: weights `W` (outputs × inputs) and biases `b`, in single
/// precision.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Layer {
    inputs: usize,
    weights: Vec<f32>,
    bias: Vec<f32>,
}

/// A multilayer perceptron in single precision: one [`Layer`] or more with `max(0, ·)` (ReLU)
/// between them, none after the last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Network {
    layers: Vec<Layer>,
}

/// Why layers cannot be combined into a network, or a network into a projection.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NetworkError {
    /// No layers, or one without inputs or outputs.
    #[error("expected layers with inputs and outputs, found none")]
    Empty,
    /// The number of weights does not match the layer's inputs and outputs, or the number of inputs
    /// is not that of outputs of the layer before, or inputs or outputs of the network do not suit
    /// its use ([`LearnedProjection`](super::LearnedProjection)).
    #[error("layer {layer}: expected {expected} {what}, found {found}")]
    Shape {
        /// Index of the layer, 0 for the first.
        layer: usize,
        /// What was counted: "weights", "inputs" or "outputs".
        what: &'static str,
        /// Required number.
        expected: usize,
        /// Actual number.
        found: usize,
    },
    /// A weight or bias that is NaN or infinite.
    #[error("layer {layer}: expected finite weights, found {value}")]
    NotFinite {
        /// Index of the layer, 0 for the first.
        layer: usize,
        /// The weight or bias as found, as text.
        value: String,
    },
}

impl Layer {
    /// A layer of `inputs` inputs and as many outputs as `bias` has entries. `weights` is
    /// row-major: `inputs` numbers for each output, one output after another. The lengths are
    /// checked by [`Network::new`], not here.
    pub fn new(inputs: usize, weights: Vec<f32>, bias: Vec<f32>) -> Layer {
        Layer { inputs, weights, bias }
    }

    pub(super) fn zeros(inputs: usize, outputs: usize) -> Layer {
        Layer { inputs, weights: vec![0.0; inputs * outputs], bias: vec![0.0; outputs] }
    }

    /// Number of inputs, the columns of `W`.
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// Number of outputs, the rows of `W`.
    pub fn outputs(&self) -> usize {
        self.bias.len()
    }

    /// Weights `W`, row-major: `inputs` numbers for each output, one output after another.
    pub fn weights(&self) -> &[f32] {
        &self.weights
    }

    /// Biases `b`, one for each output.
    pub fn bias(&self) -> &[f32] {
        &self.bias
    }

    pub(super) fn parts_mut(&mut self) -> (&mut [f32], &mut [f32]) {
        (&mut self.weights, &mut self.bias)
    }

    fn check(&self, layer: usize) -> Result<(), NetworkError> {
        if self.inputs == 0 || self.bias.is_empty() {
            return Err(NetworkError::Empty);
        }
        let (expected, found) = (self.inputs.saturating_mul(self.bias.len()), self.weights.len());
        if found != expected {
            return Err(NetworkError::Shape { layer, what: "weights", expected, found });
        }
        match self.weights.iter().chain(&self.bias).find(|value| !value.is_finite()) {
            Some(value) => Err(NetworkError::NotFinite { layer, value: value.to_string() }),
            None => Ok(()),
        }
    }

    fn forward(&self, rows: usize, x: &[f32], y: &mut [f32], rectify: bool) {
        let (inputs, outputs) = (self.inputs, self.outputs());
        let (x, mut sum) = (transposed(x, inputs, rows), transposed_mut(y, outputs, rows));
        if rows.min(inputs).min(outputs) > UNBLOCKED {
            sum.gemm(1.0, &View::from_slice_with_strides(&self.weights, outputs, inputs, inputs, 1), &x, 0.0);
        } else {
            sum.gemm_tr(1.0, &transposed(&self.weights, inputs, outputs), &x, 0.0);
        }
        let least = if rectify { 0.0 } else { f32::NEG_INFINITY };
        for row in y.chunks_exact_mut(self.outputs()) {
            for (y, b) in row.iter_mut().zip(&self.bias) {
                let sum = *y + b;
                // Unlike `max`, this keeps what is no number.
                *y = if sum < least { least } else { sum };
            }
        }
    }

    /// `∂/∂x` from `∂/∂y`.
    fn backward(&self, rows: usize, by_y: &[f32], by_x: &mut [f32]) {
        let (inputs, outputs) = (self.inputs, self.outputs());
        let weights = transposed(&self.weights, inputs, outputs);
        transposed_mut(by_x, inputs, rows).gemm(1.0, &weights, &transposed(by_y, outputs, rows), 0.0);
    }
}

/// Matrices of some rows, one for the input and one for the output of each layer: values, or
/// derivatives by them.
#[derive(Clone, Debug, Default)]
pub(super) struct Stack {
    rows: usize,
    at: Vec<Vec<f32>>,
}

impl Stack {
    /// Makes room for `rows` of this network. What the matrices hold is left as it is.
    pub fn reset(&mut self, network: &Network, rows: usize) {
        self.rows = rows;
        self.at.resize(network.layers.len() + 1, Vec::new());
        for (values, width) in self.at.iter_mut().zip(network.widths()) {
            values.resize(rows * width, 0.0);
        }
    }

    /// Number of values in a row of layer `l`.
    fn width(&self, l: usize) -> usize {
        self.at[l].len() / self.rows.max(1)
    }

    /// Values of the network's input, one row after another.
    pub fn first_mut(&mut self) -> &mut [f32] {
        self.at.first_mut().map_or(&mut [], Vec::as_mut_slice)
    }

    /// Values of the network's input, one row after another.
    pub fn first(&self) -> &[f32] {
        self.at.first().map_or(&[], Vec::as_slice)
    }

    /// Values of the network's output, one row after another.
    pub fn last_mut(&mut self) -> &mut [f32] {
        self.at.last_mut().map_or(&mut [], Vec::as_mut_slice)
    }

    /// Values of the network's output, one row after another.
    pub fn last(&self) -> &[f32] {
        self.at.last().map_or(&[], Vec::as_slice)
    }
}

/// Values and derivatives of some rows of a batch.
#[derive(Clone, Debug, Default)]
pub(super) struct Tape {
    /// Input of the network and outputs of the layers.
    pub values: Stack,
    /// Derivatives of the loss by these values.
    pub deltas: Stack,
}

/// How far back derivatives are asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Back {
    /// To the network's input.
    ToInput,
    /// To the outputs of the first layer: enough for the weights.
    ToWeights,
}

impl Network {
    /// A network of layers in order from input to output.
    ///
    /// # Errors
    /// [`NetworkError::Empty`] if there are no layers or one has no inputs or outputs,
    /// [`NetworkError::Shape`] if numbers of weights, inputs or outputs do not match,
    /// [`NetworkError::NotFinite`] if a weight or bias is not finite; of several, that of the first
    /// layer.
    pub fn new(layers: Vec<Layer>) -> Result<Network, NetworkError> {
        let mut outputs = layers.first().ok_or(NetworkError::Empty)?.inputs;
        for (k, layer) in layers.iter().enumerate() {
            layer.check(k)?;
            if layer.inputs != outputs {
                return Err(NetworkError::Shape { layer: k, what: "inputs", expected: outputs, found: layer.inputs });
            }
            outputs = layer.outputs();
        }
        Ok(Network { layers })
    }

    /// Random layers between these widths: number of inputs, of outputs of each hidden layer, of
    /// outputs; the same for the same `seed`. Weights are uniform about zero with variance
    /// `2 / inputs`, which keeps the size of values from layer to layer, in the last layer
    /// `1 / inputs`; biases are zero (He et al. 2015, arXiv 1502.01852).
    ///
    /// # Errors
    /// [`NetworkError::Empty`] if there are fewer than two widths, or one is zero.
    pub fn random(widths: &[usize], seed: u64) -> Result<Network, NetworkError> {
        let mut random = Pcg64::seed_from_u64(seed);
        let layers = widths.windows(2).enumerate().map(|(k, pair)| {
            let mut layer = Layer::zeros(pair[0], pair[1]);
            let gain = if k + 2 < widths.len() { 2.0 } else { 1.0 };
            let bound = (3.0 * gain / pair[0].max(1) as f32).sqrt();
            layer.weights.iter_mut().for_each(|w| *w = random.random_range(-bound..=bound));
            layer
        });
        Network::new(layers.collect())
    }

    /// The layers, from input to output; at least one.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    pub(super) fn layers_mut(&mut self) -> &mut [Layer] {
        &mut self.layers
    }

    /// Number of inputs of the network, then number of outputs of each layer: one more number than
    /// layers.
    pub fn widths(&self) -> impl Iterator<Item = usize> {
        self.layers.first().map(Layer::inputs).into_iter().chain(self.layers.iter().map(Layer::outputs))
    }

    /// Outputs of the network for a batch of inputs. `inputs` is row-major: one row of
    /// [`widths`](Network::widths)' first number per sample, one after another; so is the result
    /// with rows of the last number, empty for no inputs. Surplus numbers of an incomplete last row
    /// are ignored; rows with NaN give NaN.
    pub fn forward(&self, inputs: &[f32]) -> Vec<f32> {
        let width = self.layers.first().map_or(1, Layer::inputs);
        let mut values = Stack::default();
        let each = inputs.chunks(CHUNK * width).map(|chunk| {
            values.reset(self, chunk.len() / width);
            values.first_mut().copy_from_slice(&chunk[..chunk.len() / width * width]);
            self.run(&mut values);
            values.last().to_vec()
        });
        each.collect::<Vec<_>>().concat()
    }

    /// From `values`' inputs to its outputs.
    pub(super) fn run(&self, values: &mut Stack) {
        for (l, layer) in self.layers.iter().enumerate() {
            let (before, after) = values.at.split_at_mut(l + 1);
            layer.forward(values.rows, &before[l], &mut after[0], l + 1 < self.layers.len());
        }
    }

    /// Reverse mode: from derivatives by the outputs, in the last of `deltas`, to those by what
    /// comes before.
    pub(super) fn run_back(&self, values: &Stack, deltas: &mut Stack, back: Back) {
        let first = if back == Back::ToInput { 0 } else { 1 };
        for l in (first..self.layers.len()).rev() {
            let (before, after) = deltas.at.split_at_mut(l + 1);
            self.layers[l].backward(values.rows, &after[0], &mut before[l]);
            if l > 0 {
                // The slope of max(0, ·) at zero is taken as zero.
                before[l].iter_mut().zip(&values.at[l]).for_each(|(d, v)| *d = if *v > 0.0 { *d } else { 0.0 });
            }
        }
    }
}

/// The derivative by rows `first_row..` of the weights of layer `l`, as many as fit into
/// `gradient`.
pub(super) fn weight_gradient(tapes: &[Tape], l: usize, first_row: usize, gradient: &mut [f32]) {
    for (k, Tape { values, deltas }) in tapes.iter().enumerate() {
        let (inputs, outputs, batch) = (values.width(l), deltas.width(l + 1), values.rows);
        let rows = gradient.len() / inputs;
        let by_y = View::from_slice_with_strides(&deltas.at[l + 1][first_row..], rows, batch, 1, outputs);
        let x = View::from_slice_with_strides(&values.at[l], batch, inputs, inputs, 1);
        let mut sum = ViewMut::from_slice_with_strides_mut(gradient, rows, inputs, inputs, 1);
        sum.gemm(1.0, &by_y, &x, if k == 0 { 0.0 } else { 1.0 });
    }
}

/// The derivative by the biases of layer `l`.
pub(super) fn bias_gradient(tapes: &[Tape], l: usize) -> Vec<f32> {
    let width = tapes.first().map_or(1, |tape| tape.deltas.width(l + 1));
    let mut gradient = vec![0.0; width];
    for row in tapes.iter().flat_map(|tape| tape.deltas.at[l + 1].chunks_exact(width)) {
        gradient.iter_mut().zip(row).for_each(|(sum, d)| *sum += d);
    }
    gradient
}
