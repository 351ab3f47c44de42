//! The solver against the certified nonlinear least-squares problems of NIST's Statistical
//! Reference Datasets, from both starting points.
//!
//! Source: National Institute of Standards and Technology,
//! <https://www.itl.nist.gov/div898/strd/nls/nls_main.shtml>; data, starting and certified values
//! are in `tests/nist`, as published (works of the US government, in the public domain).
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test reports by panicking and printing")]

use std::f64::consts::PI;
use std::ops::ControlFlow;

use nalgebra::DVector;

use super::{LevenbergMarquardtOptions, minimize};
use crate::solver::{FreeParameters, NormalEquations, Termination};

/// Digits that must be reached: normal equations square the condition number, so that up to half of
/// a number's sixteen may be lost.
const DIGITS: f64 = 7.0;
const CERTIFIED: f64 = 11.0;
/// Starts so far off that the search ends where the model is flat: a better start is the caller's
/// to find.
const LOST: [(&str, usize); 2] = [("MGH17", 1), ("Eckerle4", 1)];
/// To the end: 1e-9 of a standard deviation.
const TO_THE_END: LevenbergMarquardtOptions =
    LevenbergMarquardtOptions { max_iterations: 2000, decrement: 1e-18, gradient_test_below: 0.03 };

/// A model's value for parameters and predictors.
type Model = fn(&[f64], &[f64]) -> f64;

struct Certified {
    name: &'static str,
    model: Model,
    starts: [Vec<f64>; 2],
    parameters: Vec<f64>,
    deviations: Vec<f64>,
    /// Residual standard deviation: the noise declared to the solver.
    noise: f64,
    /// Response and predictors.
    data: Vec<Vec<f64>>,
}

fn numbers(line: &str) -> Vec<f64> {
    line.split_whitespace().filter_map(|word| word.parse().ok()).collect()
}

impl Certified {
    fn new(name: &'static str, text: &str, model: Model) -> Self {
        // Rows `b1 = start1 start2 certified deviation`; a text may say more before.
        let is_parameter =
            |line: &&str| line.trim_start().starts_with('b') && line.contains('=') && numbers(line).len() == 4;
        let rows: Vec<Vec<f64>> = text.lines().filter(is_parameter).map(numbers).collect();
        let column = |k: usize| rows.iter().map(|row| row[k]).collect();
        let noise = text.lines().find_map(|line| line.strip_prefix("Residual Standard Deviation:")).unwrap();
        let (_, data) = text.rsplit_once("Data:").unwrap();
        Certified {
            name,
            model,
            starts: [column(0), column(1)],
            parameters: column(2),
            deviations: column(3),
            noise: noise.trim().parse().unwrap(),
            data: data.lines().skip(1).map(numbers).filter(|row| !row.is_empty()).collect(),
        }
    }

    /// Rows `(f(b) − y)/σ`, their derivatives by the five-point rule.
    fn linearize(&self, b: &DVector<f64>) -> NormalEquations {
        let index: Vec<usize> = (0..b.len()).collect();
        let mut normal = NormalEquations::new(b.len());
        for row in &self.data {
            let at = |k: usize, by: f64| {
                let mut moved = b.as_slice().to_vec();
                moved[k] += by;
                (self.model)(&moved, &row[1..]) / self.noise
            };
            let slope = |k: usize| {
                let h = 1e-4 * b[k].abs().max(1e-12);
                (8.0 * (at(k, h) - at(k, -h)) - (at(k, 2.0 * h) - at(k, -2.0 * h))) / (12.0 * h)
            };
            let jacobian: Vec<f64> = index.iter().map(|&k| slope(k)).collect();
            let residual = at(0, 0.0) - row[0] / self.noise;
            normal.add_row(&index, &jacobian, residual, 1.0);
            normal.cost += residual * residual;
            normal.rows += 1.0;
        }
        normal.complete()
    }

    /// Digits of the worst parameter and of the worst standard deviation, and how the search ended.
    fn solve(&self, start: &[f64]) -> (f64, f64, Termination) {
        let start = DVector::from_column_slice(start);
        let mut watch = |_, _| ControlFlow::Continue(());
        let minimum =
            minimize(|b| self.linearize(b), start.clone(), &FreeParameters::new(start.abs()), TO_THE_END, &mut watch);
        let normal = self.linearize(&minimum.theta);
        let variance = normal.cost / (self.data.len() - self.parameters.len()) as f64;
        let scale = minimum.theta.abs();
        let inverse = normal.damped(&FreeParameters::new(scale.clone()), 0.0).map(|factored| {
            let unit = |k: usize| DVector::from_fn(scale.len(), |i, _| f64::from(u8::from(i == k)));
            (0..scale.len()).map(|k| (variance * -factored.step(&unit(k))[k]).sqrt()).collect::<Vec<f64>>()
        });
        let deviations = inverse.unwrap_or_else(|| vec![f64::NAN; scale.len()]);
        let (parameters, termination) = (minimum.theta.as_slice(), minimum.termination);
        (digits(parameters, &self.parameters), digits(&deviations, &self.deviations), termination)
    }
}

/// Digits in which the worst value agrees with the certified one (log relative error); none where
/// it is not a number.
fn digits(found: &[f64], certified: &[f64]) -> f64 {
    let each = found.iter().zip(certified).map(|(found, certified)| -((found - certified) / certified).abs().log10());
    each.fold(CERTIFIED, |least, digits| if digits.is_nan() { 0.0 } else { least.min(digits) }).max(0.0)
}

/// Reads a problem's file and pairs it with its model.
macro_rules! certified {
    ($name:literal, $model:expr) => {
        Certified::new($name, include_str!(concat!("../../../tests/nist/", $name, ".dat")), $model)
    };
}

fn bell(height: f64, x: f64, middle: f64, width: f64) -> f64 {
    height * (-((x - middle) / width).powi(2)).exp()
}

fn gauss(b: &[f64], x: &[f64]) -> f64 {
    b[0] * (-b[1] * x[0]).exp() + bell(b[2], x[0], b[3], b[4]) + bell(b[5], x[0], b[6], b[7])
}

fn lanczos(b: &[f64], x: &[f64]) -> f64 {
    b.chunks(2).map(|b| b[0] * (-b[1] * x[0]).exp()).sum()
}

fn chwirut(b: &[f64], x: &[f64]) -> f64 {
    (-b[0] * x[0]).exp() / (b[1] + b[2] * x[0])
}

fn approach(b: &[f64], x: &[f64]) -> f64 {
    b[0] * (1.0 - (-b[1] * x[0]).exp())
}

/// Polynomials with `upper` and then the other coefficients, the lower one beginning with 1.
fn rational(b: &[f64], x: f64, upper: usize) -> f64 {
    let horner = |b: &[f64]| b.iter().rev().fold(0.0, |sum, b| sum * x + b);
    horner(&b[..upper]) / (1.0 + x * horner(&b[upper..]))
}

fn wave(cosine: f64, sine: f64, turns: f64) -> f64 {
    cosine * (2.0 * PI * turns).cos() + sine * (2.0 * PI * turns).sin()
}

fn problems() -> Vec<Certified> {
    let mut nelson = certified!("Nelson", |b, x| b[0] - b[1] * x[0] * (-b[2] * x[1]).exp());
    nelson.data.iter_mut().for_each(|row| row[0] = row[0].ln());
    vec![
        // Lower difficulty.
        certified!("Misra1a", approach),
        certified!("Chwirut2", chwirut),
        certified!("Chwirut1", chwirut),
        certified!("Lanczos3", lanczos),
        certified!("Gauss1", gauss),
        certified!("Gauss2", gauss),
        certified!("DanWood", |b, x| b[0] * x[0].powf(b[1])),
        certified!("Misra1b", |b, x| b[0] * (1.0 - (1.0 + b[1] * x[0] / 2.0).powi(-2))),
        // Average.
        certified!("Kirby2", |b, x| rational(b, x[0], 3)),
        certified!("Hahn1", |b, x| rational(b, x[0], 4)),
        nelson,
        certified!("MGH17", |b, x| b[0] + b[1] * (-x[0] * b[3]).exp() + b[2] * (-x[0] * b[4]).exp()),
        certified!("Lanczos1", lanczos),
        certified!("Lanczos2", lanczos),
        certified!("Gauss3", gauss),
        certified!("Misra1c", |b, x| b[0] * (1.0 - (1.0 + 2.0 * b[1] * x[0]).powf(-0.5))),
        certified!("Misra1d", |b, x| b[0] * b[1] * x[0] / (1.0 + b[1] * x[0])),
        certified!("Roszman1", |b, x| b[0] - b[1] * x[0] - (b[2] / (x[0] - b[3])).atan() / PI),
        certified!("ENSO", |b, x| {
            let x = x[0];
            b[0] + wave(b[1], b[2], x / 12.0) + wave(b[4], b[5], x / b[3]) + wave(b[7], b[8], x / b[6])
        }),
        // Higher.
        certified!("MGH09", |b, x| b[0] * (x[0] * x[0] + x[0] * b[1]) / (x[0] * x[0] + x[0] * b[2] + b[3])),
        certified!("Thurber", |b, x| rational(b, x[0], 4)),
        certified!("BoxBOD", approach),
        certified!("Rat42", |b, x| b[0] / (1.0 + (b[1] - b[2] * x[0]).exp())),
        certified!("MGH10", |b, x| b[0] * (b[1] / (x[0] + b[2])).exp()),
        certified!("Eckerle4", |b, x| b[0] / b[1] * (-0.5 * ((x[0] - b[2]) / b[1]).powi(2)).exp()),
        certified!("Rat43", |b, x| b[0] / (1.0 + (b[1] - b[2] * x[0]).exp()).powf(1.0 / b[3])),
        certified!("Bennett5", |b, x| b[0] * (b[1] + x[0]).powf(-1.0 / b[2])),
    ]
}

#[test]
fn certified_values_are_found_from_both_starts() {
    let mut missed = Vec::new();
    for problem in problems() {
        for (number, start) in problem.starts.iter().enumerate() {
            let (parameters, deviations, end) = problem.solve(start);
            let (name, number, looks) = (problem.name, number + 1, end.iterations);
            // `scripts/validate` reads this line.
            println!(
                "validate: {name}, start {number} | digits {parameters:.1} | deviations {deviations:.1} | looks {looks} | limit {DIGITS}"
            );
            if parameters < DIGITS {
                missed.push((name, number));
            }
        }
    }
    assert_eq!(missed, LOST);
}
