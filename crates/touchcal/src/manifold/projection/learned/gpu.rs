//! Training on a GPU, through burn: the same steps as [`Cpu`](super::cpu::Cpu)'s, as operations
//! on whole matrices.

use std::fmt::Debug;
use std::panic::catch_unwind;

use burn_tensor::backend::Backend;
use burn_tensor::{ElementConversion, Tensor, TensorData, activation};

use super::adam::{KEEP_FIRST, KEEP_SECOND, Step, TAKE_FIRST, TAKE_SECOND};
use super::checkpoint::Checkpoint;
use super::device::{Device, DeviceError};
use super::engine::Engine;
use super::network::Layer;
use super::pair_set::Batch;

/// What moves, on the device.
#[derive(Debug)]
struct Gpu<B: Backend> {
    device: Device,
    burn: B::Device,
    layers: Vec<Tensors<B>>,
    steps: u64,
}

/// A layer's weights (a row for each output) and biases (one row).
#[derive(Debug)]
struct Tensors<B: Backend> {
    weights: Moving<B>,
    bias: Moving<B>,
}

/// Numbers, their gradients' means and those of the gradients' squares.
#[derive(Debug)]
struct Moving<B: Backend> {
    value: Tensor<B, 2>,
    first: Tensor<B, 2>,
    second: Tensor<B, 2>,
}

/// Whether this build and this machine have the device.
pub(super) fn probe(device: Device) -> Result<(), DeviceError> {
    match device {
        #[cfg(feature = "cuda")]
        Device::Cuda => open::<burn_cuda::Cuda>(device).map(drop),
        #[cfg(feature = "wgpu")]
        Device::Wgpu => open::<burn_wgpu::Wgpu>(device).map(drop),
        _ => Err(DeviceError::NotBuilt { device }),
    }
}

/// Arithmetic on it, beginning with the weights and means of `state`.
pub(super) fn engine(device: Device, state: &Checkpoint) -> Result<Box<dyn Engine>, DeviceError> {
    match device {
        #[cfg(feature = "cuda")]
        Device::Cuda => Ok(Box::new(Gpu::<burn_cuda::Cuda>::new(device, state)?)),
        #[cfg(feature = "wgpu")]
        Device::Wgpu => Ok(Box::new(Gpu::<burn_wgpu::Wgpu>::new(device, state)?)),
        _ => Err(DeviceError::NotBuilt { device }),
    }
}

/// The first device of a backend, once it has added two numbers.
fn open<B: Backend>(device: Device) -> Result<B::Device, DeviceError> {
    // Where a library, a device or CUDA's headers are missing, burn panics in its first operation,
    // and cannot be asked before. It does so on a thread of its own; what reaches this one does not
    // say why.
    let added = catch_unwind(|| {
        let burn = B::Device::default();
        let one = || Tensor::<B, 1>::from_floats([1.0], &burn);
        (one() + one()).try_into_scalar().map(|two| (burn.clone(), two.elem::<f32>()))
    });
    match added {
        Ok(Ok((burn, 2.0))) => Ok(burn),
        Ok(Ok((_, two))) => Err(failed(device, format!("1 + 1 is {two}"))),
        Ok(Err(error)) => Err(failed(device, error)),
        Err(_) => Err(DeviceError::Unusable { device }),
    }
}

fn failed(device: Device, error: impl Debug) -> DeviceError {
    DeviceError::Failed { device, message: format!("{error:?}") }
}

impl<B: Backend> Moving<B> {
    fn new(burn: &B::Device, shape: [usize; 2], [value, first, second]: [&[f32]; 3]) -> Moving<B> {
        Moving { value: put(burn, shape, value), first: put(burn, shape, first), second: put(burn, shape, second) }
    }

    fn apply(&mut self, step: &Step, gradient: Tensor<B, 2>) {
        let squared = gradient.clone() * gradient.clone();
        self.first.inplace(|first| first * KEEP_FIRST + gradient * TAKE_FIRST);
        self.second.inplace(|second| second * KEEP_SECOND + squared * TAKE_SECOND);
        let change = self.first.clone() * step.rate / (self.second.clone().sqrt() + step.epsilon);
        self.value.inplace(|value| value - change);
    }

    fn read(&self, device: Device, into: [&mut [f32]; 3]) -> Result<(), DeviceError> {
        for (tensor, into) in [&self.value, &self.first, &self.second].into_iter().zip(into) {
            let numbers = tensor.clone().try_into_data().map_err(|error| failed(device, error))?;
            into.iter_mut().zip(numbers.iter::<f32>()).for_each(|(into, number)| *into = number);
        }
        Ok(())
    }
}

fn put<B: Backend>(burn: &B::Device, shape: [usize; 2], values: &[f32]) -> Tensor<B, 2> {
    Tensor::from_data(TensorData::new(values.to_vec(), shape), burn)
}

impl<B: Backend> Gpu<B> {
    fn new(device: Device, state: &Checkpoint) -> Result<Gpu<B>, DeviceError> {
        let burn = open::<B>(device)?;
        let Checkpoint { network, adam, .. } = state;
        let layers = network.layers().iter().zip(&adam.first).zip(&adam.second).map(|((value, first), second)| {
            let all = [value, first, second];
            let (inputs, outputs) = (value.inputs(), value.outputs());
            Tensors {
                weights: Moving::new(&burn, [outputs, inputs], all.map(Layer::weights)),
                bias: Moving::new(&burn, [1, outputs], all.map(Layer::bias)),
            }
        });
        Ok(Gpu { device, layers: layers.collect(), steps: adam.steps, burn })
    }

    /// The inputs of each layer, and the outputs' errors.
    fn forward(&self, batch: &Batch<'_>) -> (Vec<Tensor<B, 2>>, Tensor<B, 2>) {
        let shape = [batch.len(), 6];
        let mut x = put(&self.burn, shape, batch.inputs);
        let mut inputs = Vec::with_capacity(self.layers.len());
        for (l, layer) in self.layers.iter().enumerate() {
            inputs.push(x.clone());
            let y = x.matmul(layer.weights.value.clone().transpose()) + layer.bias.value.clone();
            x = if l + 1 < self.layers.len() { activation::relu(y) } else { y };
        }
        (inputs, x - put(&self.burn, shape, batch.targets))
    }

    fn mean_square(&self, error: Tensor<B, 2>) -> Result<f64, DeviceError> {
        let mean = (error.clone() * error).mean().try_into_scalar();
        mean.map(|mean| mean.elem()).map_err(|error| failed(self.device, error))
    }
}

impl<B: Backend> Engine for Gpu<B> {
    fn step(&mut self, _: &mut Checkpoint, batch: &Batch<'_>, rate: f64) -> Result<f64, DeviceError> {
        self.steps += 1;
        let step = Step::new(rate, self.steps);
        let (inputs, error) = self.forward(batch);
        // By the outputs of a layer, from the last to the first.
        let mut delta = error.clone() * batch.slope();
        for (l, (layer, x)) in self.layers.iter_mut().zip(inputs).enumerate().rev() {
            let by_weights = delta.clone().transpose().matmul(x.clone());
            let by_bias = delta.clone().sum_dim(0);
            if l > 0 {
                delta = delta.matmul(layer.weights.value.clone()).mask_fill(x.lower_equal_elem(0.0), 0.0);
            }
            layer.weights.apply(&step, by_weights);
            layer.bias.apply(&step, by_bias);
        }
        self.mean_square(error)
    }

    fn loss(&mut self, _: &Checkpoint, batch: &Batch<'_>) -> Result<f64, DeviceError> {
        self.mean_square(self.forward(batch).1)
    }

    fn read(&mut self, state: &mut Checkpoint) -> Result<(), DeviceError> {
        let Checkpoint { network, adam, .. } = state;
        let into = network.layers_mut().iter_mut().zip(&mut adam.first).zip(&mut adam.second);
        for (layer, ((value, first), second)) in self.layers.iter().zip(into) {
            let [value, first, second] = [value, first, second].map(Layer::parts_mut);
            layer.weights.read(self.device, [value.0, first.0, second.0])?;
            layer.bias.read(self.device, [value.1, first.1, second.1])?;
        }
        adam.steps = self.steps;
        Ok(())
    }
}
