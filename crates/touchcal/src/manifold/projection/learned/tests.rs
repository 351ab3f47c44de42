//! The network against the same formulas in double precision, and against differences.

use nalgebra::{Matrix6, Vector6};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::adam::AdamState;
use super::network::{Back, CHUNK, Layer, Network, Tape, bias_gradient, weight_gradient};
use super::{LearnedProjection, Output, Scaling};
use crate::manifold::Projection;
use crate::manifold::coordinates::{Coordinates, Metric};

/// More than one chunk, and one that is not full.
const ROWS: usize = 2 * CHUNK + 37;

/// A layer in double precision: rows of weights, biases.
type Wide = (Vec<Vec<f64>>, Vec<f64>);

fn wide(network: &Network) -> Vec<Wide> {
    let double = |values: &[f32]| values.iter().map(|w| f64::from(*w)).collect::<Vec<_>>();
    network.layers().iter().map(|l| (l.weights().chunks(l.inputs()).map(double).collect(), double(l.bias()))).collect()
}

fn forward(layers: &[Wide], x: &[f64]) -> Vec<f64> {
    let mut x = x.to_vec();
    for (k, (weights, bias)) in layers.iter().enumerate() {
        let y = weights.iter().zip(bias).map(|(row, b)| b + row.iter().zip(&x).map(|(w, x)| w * x).sum::<f64>());
        x = y.map(|y| if k + 1 < layers.len() { y.max(0.0) } else { y }).collect();
    }
    x
}

fn random(count: usize, seed: u64) -> Vec<f32> {
    let mut random = Pcg64::seed_from_u64(seed);
    (0..count).map(|_| random.random_range(-1.0..=1.0)).collect()
}

/// A network with biases too, so that they are tested.
fn network(widths: &[usize]) -> Network {
    let mut network = Network::random(widths, 5).unwrap();
    for (k, layer) in network.layers_mut().iter_mut().enumerate() {
        let (_, bias) = layer.parts_mut();
        bias.copy_from_slice(&random(bias.len(), k as u64));
    }
    network
}

/// Tapes of a forward pass, with `by_output` as derivatives by the output.
fn tapes(network: &Network, inputs: &[f32], by_output: &[f32]) -> Vec<Tape> {
    let chunks = inputs.chunks(6 * CHUNK).zip(by_output.chunks(6 * CHUNK));
    let each = chunks.map(|(inputs, by_output)| {
        let mut tape = Tape::default();
        tape.values.reset(network, inputs.len() / 6);
        tape.deltas.reset(network, inputs.len() / 6);
        tape.values.first_mut().copy_from_slice(inputs);
        network.run(&mut tape.values);
        tape.deltas.last_mut().copy_from_slice(by_output);
        network.run_back(&tape.values, &mut tape.deltas, Back::ToInput);
        tape
    });
    each.collect()
}

#[test]
fn values_are_those_of_double_precision() {
    for widths in [&[6, 6][..], &[6, 17, 6], &[6, 64, 33, 6], &[6, 200, 200, 200, 200, 6]] {
        let network = network(widths);
        let inputs = random(6 * ROWS, 9);
        let outputs = network.forward(&inputs);
        assert_eq!(outputs.len(), 6 * ROWS);
        let layers = wide(&network);
        for (x, y) in inputs.chunks(6).zip(outputs.chunks(6)) {
            let x: Vec<f64> = x.iter().map(|x| f64::from(*x)).collect();
            for (found, expected) in y.iter().zip(forward(&layers, &x)) {
                // A few hundred roundings of 6e-8.
                assert!((f64::from(*found) - expected).abs() < 1e-5 * (1.0 + expected.abs()), "{found} {expected}");
            }
        }
    }
}

#[test]
fn reverse_mode_is_the_slope_of_differences() {
    let network = network(&[6, 40, 130, 6]);
    let (inputs, by_output) = (random(6 * ROWS, 1), random(6 * ROWS, 2));
    let tapes = tapes(&network, &inputs, &by_output);
    let layers = wide(&network);
    let loss = |layers: &[Wide]| -> f64 {
        let rows = inputs.chunks(6).zip(by_output.chunks(6)).map(|(x, d)| {
            let x: Vec<f64> = x.iter().map(|x| f64::from(*x)).collect();
            forward(layers, &x).iter().zip(d).map(|(y, d)| y * f64::from(*d)).sum::<f64>()
        });
        rows.sum()
    };
    // Small, so that hardly any row crosses a kink, and those that do count for little.
    let h = 1e-7;
    let slope = |change: &dyn Fn(&mut Vec<Wide>, f64)| {
        let (mut ahead, mut behind) = (layers.clone(), layers.clone());
        change(&mut ahead, h);
        change(&mut behind, -h);
        (loss(&ahead) - loss(&behind)) / (2.0 * h)
    };
    for (l, layer) in network.layers().iter().enumerate() {
        let (inputs, outputs) = (layer.inputs(), layer.outputs());
        let mut gradient = vec![0.0; inputs * outputs];
        weight_gradient(&tapes, l, 0, &mut gradient);
        let size = gradient.iter().fold(0f32, |most, g| most.max(g.abs()));
        for k in (0..inputs * outputs).step_by(97) {
            let expected = slope(&|layers, h| layers[l].0[k / inputs][k % inputs] += h);
            assert!((f64::from(gradient[k]) - expected).abs() < 2e-6 * f64::from(size), "{l} {k} {expected}");
        }
        let gradient = bias_gradient(&tapes, l);
        for k in (0..outputs).step_by(7) {
            let expected = slope(&|layers, h| layers[l].1[k] += h);
            assert!((f64::from(gradient[k]) - expected).abs() < 1e-5 * (1.0 + expected.abs()), "{l} {k} {expected}");
        }
    }
}

#[test]
fn a_part_of_a_gradient_is_that_part() {
    let network = network(&[6, 300, 6]);
    let tapes = tapes(&network, &random(6 * ROWS, 1), &random(6 * ROWS, 2));
    let mut whole = vec![0.0; 300 * 6];
    weight_gradient(&tapes, 0, 0, &mut whole);
    let mut part = vec![0.0; 100 * 6];
    weight_gradient(&tapes, 0, 128, &mut part);
    let far = part.iter().zip(&whole[128 * 6..]).fold(0f32, |far, (a, b)| far.max((a - b).abs()));
    assert!(far < 1e-4, "{far}");
}

fn projection(output: Output) -> LearnedProjection {
    let scaling = Scaling {
        output,
        metric: Metric::MILLIMETRE_PER_DEGREE,
        input_centre: [0.001, -0.002, -0.01, 0.01, 0.02, 3.1],
        input_scale: [0.005, 0.006, 0.01, 0.1, 0.12, 0.11],
        output_centre: [0.0, 0.001, -0.015, 0.0, 0.01, 3.1],
        output_length: 0.004,
    };
    LearnedProjection::new(network(&[6, 50, 70, 6]), scaling, [(-1.0, 1.0); 6]).unwrap()
}

/// Poses around the scaling's centre; yaw reaches across half a turn.
fn poses(count: usize) -> Vec<Coordinates> {
    let scaling = *projection(Output::Pose).scaling();
    let numbers = random(6 * count, 3);
    let each = numbers
        .chunks(6)
        .map(|x| std::array::from_fn(|k| scaling.input_centre[k] + 1.7 * f64::from(x[k]) * scaling.input_scale[k]));
    each.collect()
}

/// `F` in double precision.
fn double(projection: &LearnedProjection, c: &Coordinates) -> Coordinates {
    let scaling = projection.scaling();
    let from = if scaling.output == Output::Pose { scaling.output_centre } else { *c };
    let x: Vec<f64> = (0..6).map(|k| (c[k] - scaling.input_centre[k]) / scaling.input_scale[k]).collect();
    let y = forward(&wide(projection.network()), &x);
    std::array::from_fn(|k| from[k] + y[k] * scaling.output_scale()[k])
}

#[test]
fn a_projection_and_its_derivatives_are_those_of_double_precision() {
    for output in [Output::Pose, Output::Correction] {
        let projection = projection(output);
        let poses = poses(ROWS);
        let (mut onto, mut again, mut jacobians, mut pulled) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        projection.project(&poses, &mut onto);
        projection.linearize(&poses, &mut again, &mut jacobians);
        assert_eq!(onto, again);
        let y = |i: usize| -> Coordinates { std::array::from_fn(|k| ((i * 7 + k * 5) % 11) as f64 - 5.0) };
        let mut called = Vec::new();
        let mut cotangent = |i: usize, at: &Coordinates| {
            called.push((i, *at));
            y(i)
        };
        projection.pull_back(&poses, &mut cotangent, &mut pulled);
        assert_eq!(called, onto.iter().copied().enumerate().collect::<Vec<_>>());
        let scale = projection.scaling().input_scale;
        for (i, pose) in poses.iter().enumerate() {
            let expected = double(&projection, pose);
            for k in 0..6 {
                assert!((onto[i][k] - expected[k]).abs() < 1e-5 * (0.01 + expected[k].abs()), "{k}");
            }
            let mut jacobian = Matrix6::zeros();
            for k in 0..6 {
                let (mut ahead, mut behind) = (*pose, *pose);
                // So small that none of these poses crosses a kink on the way.
                let h = 1e-8 * scale[k];
                ahead[k] += h;
                behind[k] -= h;
                let (ahead, behind) = (double(&projection, &ahead), double(&projection, &behind));
                for l in 0..6 {
                    jacobian[(l, k)] = (ahead[l] - behind[l]) / (2.0 * h);
                }
            }
            let size = jacobian.amax();
            assert!((jacobians[i] - jacobian).amax() < 3e-6 * size, "{i}: {}", (jacobians[i] - jacobian).amax() / size);
            let product = jacobians[i].transpose() * Vector6::from(y(i));
            assert!((product - Vector6::from(pulled[i])).amax() < 3e-5 * size, "{i}");
        }
    }
}

#[test]
fn a_pose_that_is_no_number_stays_one_and_spares_the_others() {
    let projection = projection(Output::Pose);
    let mut poses = poses(3);
    let mut expected = Vec::new();
    projection.project(&poses, &mut expected);
    poses[1][4] = f64::NAN;
    let mut onto = Vec::new();
    projection.project(&poses, &mut onto);
    assert!(onto[1].iter().all(|value| value.is_nan()));
    assert_eq!((onto[0], onto[2]), (expected[0], expected[2]));
    projection.project(&[], &mut onto);
    assert!(onto.is_empty());
}

#[test]
fn whole_turns_change_nothing() {
    let projection = projection(Output::Pose);
    let poses = poses(50);
    let turned: Vec<Coordinates> =
        poses.iter().map(|c| [c[0], c[1], c[2], c[3], c[4], c[5] - std::f64::consts::TAU]).collect();
    let (mut onto, mut again) = (Vec::new(), Vec::new());
    projection.project(&poses, &mut onto);
    projection.project(&turned, &mut again);
    for (a, b) in onto.iter().zip(&again) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-8));
    }
}

#[test]
fn adam_is_adam() {
    let mut network = network(&[6, 20, 6]);
    let mut adam = AdamState::new(&network);
    let (mut w, mut m, mut v) = (f64::from(network.layers()[0].weights()[9]), 0.0, 0.0);
    for t in 1..=50 {
        let tapes = tapes(&network, &random(6 * ROWS, t), &random(6 * ROWS, 100 + t));
        let mut gradient = vec![0.0; 120];
        weight_gradient(&tapes, 0, 0, &mut gradient);
        let g = f64::from(gradient[9]);
        m = 0.9 * m + 0.1 * g;
        v = 0.999 * v + 0.001 * g * g;
        let (corrected, square) = (m / (1.0 - 0.9f64.powi(t as i32)), v / (1.0 - 0.999f64.powi(t as i32)));
        w -= 1e-3 * corrected / (square.sqrt() + 1e-8);
        adam.step(&mut network, &tapes, 1e-3);
    }
    let found = f64::from(network.layers()[0].weights()[9]);
    assert!((found - w).abs() < 1e-6, "{found} {w}");
}

#[test]
fn shapes_that_do_not_fit_are_refused() {
    let layer = |inputs, weights: usize, outputs: usize| Layer::new(inputs, vec![0.5; weights], vec![0.0; outputs]);
    let message = |layers| Network::new(layers).unwrap_err().to_string();
    assert!(message(vec![]).contains("none"));
    assert!(message(vec![layer(6, 0, 0)]).contains("none"));
    assert_eq!(message(vec![layer(6, 11, 2)]), "layer 0: expected 12 weights, found 11");
    assert_eq!(message(vec![layer(6, 12, 2), layer(3, 18, 6)]), "layer 1: expected 2 inputs, found 3");
    let mut weights = vec![0.5; 12];
    weights[3] = f32::NAN;
    assert_eq!(message(vec![Layer::new(6, weights, vec![0.0; 2])]), "layer 0: expected finite weights, found NaN");
    assert!(Network::random(&[6], 1).is_err() && Network::random(&[6, 0, 6], 1).is_err());
    let five = Network::random(&[6, 8, 5], 1).unwrap();
    let refused = LearnedProjection::new(five, *projection(Output::Pose).scaling(), [(0.0, 0.0); 6]);
    assert_eq!(refused.unwrap_err().to_string(), "layer 1: expected 6 outputs, found 5");
}
