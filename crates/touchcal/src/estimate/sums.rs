//! What contacts and known distances add to normal equations and to statistics.

use super::loss::Loss;
use super::normal::NormalEquations;
use super::rows::{At, ContactRows, Rung};
use super::statistics::Statistics;
use super::walls::Said;
use crate::manifold::Rows;
use crate::robot::Column;
use crate::se3::{self, Pose, Twist};

/// How contacts enter the normal equations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    /// Which rows each gives.
    pub rung: Rung,
    /// How often each counts.
    pub share: f64,
}

impl At<'_> {
    /// Adds contacts of one fixture as they were logged; each one's squared norm and number of rows.
    pub fn add_logged(
        &self,
        batch: &[usize],
        entry: Entry,
        into: &mut ContactRows,
        normal: &mut NormalEquations,
    ) -> Vec<(f64, usize)> {
        let Some(&first) = batch.first() else { return Vec::new() };
        let contacts = &self.system.problem.contacts;
        let f = contacts.fixture(first);
        if entry.rung == Rung::Walls && self.system.problem.fixtures[f].manifold.has_interference() {
            let each = batch.iter().map(|&i| {
                self.contact(i, entry.rung, into);
                (self.add(i, entry, into, normal), into.len())
            });
            return each.collect();
        }
        let poses: Vec<Pose> = batch.iter().map(|&i| self.pose(i, &mut into.q)).collect();
        let mut looks = vec![Rows::new(); batch.len()];
        self.look(f, &poses, entry.rung, &mut looks);
        let each = batch.iter().zip(looks).map(|(&i, look)| {
            let fixture_from_tool = self.locate(i, into);
            into.rows = look;
            self.whitened(i, &fixture_from_tool, entry.rung, into);
            (self.add(i, entry, into, normal), into.len())
        });
        each.collect()
    }

    /// Adds whitened rows of contact `i`; returns their squared norm.
    pub fn add(&self, i: usize, entry: Entry, rows: &ContactRows, normal: &mut NormalEquations) -> f64 {
        let Entry { rung, share } = entry;
        let seen = &self.system.seen[self.system.problem.contacts.fixture(i)];
        if let Some(said) = &rows.said {
            let jacobian = &rows.jacobian[..rows.len() * seen.len()];
            normal.add_form(seen, jacobian, |r| share * said.slope[r], |r, s| share * said.complete[(r, s)]);
            normal.cost += 2.0 * share * said.cost;
            normal.squares += share * said.squares;
            normal.rows += share * said.touched.sum();
            return said.squares;
        }
        let loss = match rung {
            Rung::Envelope => Loss::Squared,
            Rung::Residual(loss) => loss,
            Rung::Walls => self.system.problem.loss,
        };
        let squared = rows.squared();
        let weight = share * loss.weight(squared);
        for r in 0..rows.len() {
            let jacobian = &rows.jacobian[r * seen.len()..(r + 1) * seen.len()];
            normal.add_row(seen, jacobian, rows.residual[r], weight);
        }
        normal.cost += share * loss.cost(squared);
        normal.squares += weight * squared;
        normal.rows += weight * rows.len() as f64;
        squared
    }

    /// Adds what contact `i` says of its walls to statistics; of contacts without walls, what their residual says with the problem's loss.
    pub fn add_to(&self, statistics: &mut Statistics, i: usize, into: &mut ContactRows) {
        self.contact(i, Rung::Walls, into);
        let f = self.system.problem.contacts.fixture(i);
        let seen = &self.system.seen[f];
        let jacobian = &into.jacobian[..into.len() * seen.len()];
        let Some(said) = &into.said else {
            let (loss, squared) = (self.system.problem.loss, into.squared());
            let (weight, weight_slope) = (loss.weight(squared), loss.weight_slope(squared));
            let slope = |r: usize| weight * into.residual[r];
            statistics.derivatives.cost += loss.cost(squared);
            let complete = |r: usize, s: usize| if r == s { weight } else { 0.0 };
            if into.for_covariance {
                let observed =
                    |r: usize, s: usize| complete(r, s) + 2.0 * weight_slope * into.residual[r] * into.residual[s];
                statistics.derivatives.add_form(seen, jacobian, slope, observed);
                statistics.squares_of_slope.add_form(seen, jacobian, slope, |r, s| slope(r) * slope(s));
            } else {
                statistics.derivatives.add_form(seen, jacobian, slope, complete);
            }
            return;
        };
        let curvature = if into.for_covariance { &said.observed } else { &said.complete };
        statistics.derivatives.add_form(seen, jacobian, |r| said.slope[r], |r, s| curvature[(r, s)]);
        statistics.derivatives.cost += 2.0 * said.cost;
        let (region, surfaces) = self.region(f, &into.rows);
        if into.for_covariance {
            self.add_odds(statistics, (f, region), into, said);
        }
        let tally = &mut statistics.tallies[f][region];
        tally.touching += said.touching;
        tally.not_touching += if into.len() > 0 { 1.0 - said.touching } else { 0.0 };
        for (k, &surface) in into.rows.surfaces().iter().enumerate() {
            tally.walls[surface % surfaces] += 1.0;
            tally.touched[surface % surfaces] += said.touched[k];
        }
        statistics.squares += said.squares;
        statistics.deviations += said.deviations;
    }

    /// Adds the slope of what a contact with a region of fixture `f` says, squared, and what it says of how often walls are touched: `ln κ_j` are parameters too, after all
    /// others.
    fn add_odds(&self, statistics: &mut Statistics, (f, region): (usize, usize), of: &ContactRows, said: &Said) {
        let (seen, odds) = (&self.system.seen[f], &self.system.odds[f][region]);
        let first = self.system.odds_column(f, region);
        let surface = |wall: usize| of.rows.surfaces()[wall] % odds.another.len();
        let along = |row: usize, column: usize| of.jacobian[row * seen.len() + column];
        let rows = of.len();
        let walls = (0..rows).map(|wall| (first + surface(wall), odds.share[surface(wall)] - said.touched[wall]));
        let parameters = seen
            .iter()
            .enumerate()
            .map(|(column, &k)| (k, (0..rows).map(|row| said.slope[row] * along(row, column)).sum()));
        let slope: Vec<(usize, f64)> = parameters.chain(walls).collect();
        let squares = &mut statistics.squares_of_slope;
        for &(b, right) in &slope {
            squares.gradient[b] += right;
            slope.iter().filter(|(a, _)| *a <= b).for_each(|&(a, left)| squares.information[(a, b)] += left * right);
        }
        let observed = &mut statistics.derivatives.information;
        for wall in 0..rows {
            let b = first + surface(wall);
            for (column, &k) in seen.iter().enumerate() {
                observed[(k, b)] +=
                    (0..rows).map(|row| said.slope_by_odds[(row, wall)] * along(row, column)).sum::<f64>();
            }
            for other in (0..rows).filter(|&other| first + surface(other) <= b) {
                observed[(first + surface(other), b)] -= said.touched_together[(other, wall)];
            }
        }
    }

    /// Known distances between fixtures' origins.
    pub fn add_distances(&self, normal: &mut NormalEquations) {
        for distance in &self.system.problem.distances {
            let (a, b) = distance.between;
            let span = self.fixtures[b].base_from_fixture.translation.vector
                - self.fixtures[a].base_from_fixture.translation.vector;
            let length = span.norm();
            let along = span / length.max(f64::MIN_POSITIVE);
            let mut index = Vec::new();
            let mut jacobian = Vec::new();
            for (k, parameter) in self.system.parameters.iter().enumerate() {
                if let Column::Fixture(f, component) = parameter.column
                    && (f == a || f == b)
                {
                    let fixture = &self.fixtures[f];
                    let local: Twist = fixture.right_jacobian.column(component).into();
                    let moved = fixture.base_from_fixture.rotation * se3::linear(&local);
                    index.push(k);
                    jacobian.push(along.dot(&moved) * if f == b { 1.0 } else { -1.0 } / distance.sigma);
                }
            }
            let residual = (length - distance.distance) / distance.sigma;
            normal.add_row(&index, &jacobian, residual, 1.0);
            normal.cost += residual * residual;
        }
    }
}
