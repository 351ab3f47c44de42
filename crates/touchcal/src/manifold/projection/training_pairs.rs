//! Pairs to learn a projection from: a pose near the manifold, and its nearest sample.

use std::ops::Range;

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;

use super::coordinates::{Coordinates, coordinates, pose};
use super::nearest::NearestSample;
use super::projected::Projection;

/// Random numbers set aside for a pair, of which it uses seven.
const DRAWS: u128 = 8;

/// An endless list of pairs (input, target) from which a projection is learned; pair number `k`
/// depends on the bounds, `seed`, `k` and the projection alone.
///
/// Input: a random sample (all equally likely) composed on the right with an offset whose six
/// coordinates are uniform within ± their bound. Target: the projection of the input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrainingPairs {
    /// Largest offset in each coordinate `[x, y, z, α, β, γ]` (m, rad; finite, not negative), in
    /// the tool's frame.
    pub bounds: Coordinates,
    /// Seed of the random numbers (PCG64, O'Neill 2014).
    pub seed: u64,
}

impl TrainingPairs {
    /// Pairs with offsets within ±10 mm and ±10° (Negi, Manyar & Gupta 2025, arXiv 2506.17458).
    pub fn new(seed: u64) -> Self {
        const TURN: f64 = std::f64::consts::PI / 18.0;
        TrainingPairs { bounds: [0.01, 0.01, 0.01, TURN, TURN, TURN], seed }
    }

    /// Computes the pairs whose numbers lie in `range`, in parallel; replaces the contents of
    /// `inputs` and `targets`, one entry `[x, y, z, α, β, γ]` (m, rad) of `fixture_from_tool` per
    /// pair, in order. An empty range leaves both empty.
    pub fn fill(
        &self,
        projection: &NearestSample,
        range: Range<u64>,
        inputs: &mut Vec<Coordinates>,
        targets: &mut Vec<Coordinates>,
    ) {
        let samples = projection.samples().coordinates();
        // A parallel range of u64 has no known length.
        let count = usize::try_from(range.end.saturating_sub(range.start)).unwrap_or(usize::MAX);
        let each = (0..count).into_par_iter().with_min_len(64).map(|i| self.input(samples, range.start + i as u64));
        each.collect_into_vec(inputs);
        projection.project(inputs, targets);
    }

    /// Input number `k`.
    fn input(&self, samples: &[Coordinates], k: u64) -> Coordinates {
        let mut random = Pcg64::seed_from_u64(self.seed);
        random.advance(u128::from(k) * DRAWS);
        // The high half of the product is uniform below the length, up to one part in 2⁶⁴ / length.
        let index = (u128::from(random.next_u64()) * samples.len() as u128) >> 64;
        let offset = self.bounds.map(|bound| bound * (2.0 * unit(random.next_u64()) - 1.0));
        coordinates(&(pose(&samples[index as usize]) * pose(&offset)))
    }
}

/// A number of `[0, 1)` from 53 random bits.
fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1u64 << 53) as f64
}
