//! How well an arm explains contacts, beside how well it should.

use serde::{Deserialize, Serialize};

use super::score::Score;
use super::status::Severity;

/// An arm on contacts that need not be those of its calibration: distances found, and distances
/// predicted from noise and from what the calibration leaves uncertain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// Distances (m) of the contacts from their manifolds.
    pub score: Score,
    /// Scatter of all contacts; `None` without contacts, or if a fixture's cannot be predicted.
    pub scatter: Option<Scatter>,
    /// Scatter of the contacts with each fixture, in the order of
    /// [`Problem::fixtures`](crate::estimate::Problem::fixtures); `None` without contacts, for a
    /// projection, from which no uncertainty follows, and for a place that nothing bounds.
    pub per_fixture: Vec<Option<Scatter>>,
    /// Distances between fixtures, first those that are declared as distances, then those of
    /// declared places.
    pub distances: Vec<FixtureDistance>,
    /// The strain common to all distances; `None` of fewer than two.
    pub common_strain: Option<CommonStrain>,
    /// What is found and cannot be chance; empty if the uncertainty of the arm is not known.
    pub contradictions: Vec<Contradiction>,
}

impl Evaluation {
    /// Whether contacts agree with what is predicted but for chance; `None` if nothing is. Where
    /// the uncertainty of the arm is not known, nothing disagrees.
    pub fn agrees(&self) -> Option<bool> {
        let is_predicted = self.scatter.is_some() || !self.distances.is_empty();
        is_predicted.then_some(self.contradictions.is_empty())
    }
}

/// Scatter of contacts: root mean square distances from their manifolds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scatter {
    /// Found (m).
    pub found: f64,
    /// Predicted (m): root of the expected mean square.
    pub predicted: f64,
    /// Range of [`Scatter::ratio`] (1) that holds 99.9 % of what chance makes if the prediction is
    /// right; of single fixtures so that all hold it together (Bonferroni).
    pub by_chance: [f64; 2],
}

impl Scatter {
    /// Scatter found over predicted (1).
    pub fn ratio(&self) -> f64 {
        self.found / self.predicted.max(f64::MIN_POSITIVE)
    }

    /// Whether more is found than chance makes.
    pub fn is_exceeded(&self) -> bool {
        self.ratio() > self.by_chance[1]
    }
}

/// What declares the distance of two fixtures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum DistanceSource {
    /// A distance: an entry of [`Problem::distances`](crate::estimate::Problem::distances).
    Distance,
    /// The nominal places of both fixtures in base.
    Places,
}

impl DistanceSource {
    /// Name in files: `distance`, `places`.
    pub fn name(self) -> &'static str {
        match self {
            DistanceSource::Distance => "distance",
            DistanceSource::Places => "places",
        }
    }
}

/// The distance between the origins of two fixtures, located by contacts with them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FixtureDistance {
    /// Names of the fixtures.
    pub between: [String; 2],
    /// What declares the distance.
    pub source: DistanceSource,
    /// Declared (m).
    pub declared: f64,
    /// Found by the arm (m).
    pub found: f64,
    /// Standard deviation of the difference (m): of the declared distance, of the calibrated arm
    /// and of the noise of the contacts together.
    pub sigma: f64,
}

impl FixtureDistance {
    /// Distance found minus declared (m).
    pub fn difference(&self) -> f64 {
        self.found - self.declared
    }

    /// The difference in its standard deviations (1).
    pub fn deviations(&self) -> f64 {
        self.difference() / self.sigma.max(f64::MIN_POSITIVE)
    }
}

/// A strain common to all distances between fixtures: found over declared distance, minus one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CommonStrain {
    /// Weighted mean of the distances' strains (1).
    pub strain: f64,
    /// Its standard deviation (1), with the errors that the distances share.
    pub sigma: f64,
}

impl CommonStrain {
    /// The strain in its standard deviations (1).
    pub fn deviations(&self) -> f64 {
        self.strain / self.sigma.max(f64::MIN_POSITIVE)
    }
}

/// What contacts say against the uncertainty that a calibration reports, beyond chance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Contradiction {
    /// Contacts scatter more than predicted.
    Scatter {
        /// Name of the fixture; `None` for all contacts together.
        fixture: Option<String>,
        /// Scatter found over predicted (1).
        ratio: f64,
        /// Largest such ratio by chance (1), see [`Scatter::by_chance`].
        limit: f64,
    },
    /// Two fixtures are at another distance than declared.
    Distance {
        /// Names of the fixtures.
        between: [String; 2],
        /// Distance found minus declared (m).
        difference: f64,
        /// The same in standard deviations (1).
        deviations: f64,
    },
    /// All distances between fixtures are off by the same factor.
    CommonStrain {
        /// Distances found over declared, minus one (1).
        strain: f64,
        /// The same in standard deviations (1).
        deviations: f64,
    },
}

impl Contradiction {
    /// Name of the variant in files: `scatter`, `distance`, `common_strain`.
    pub fn kind(&self) -> &'static str {
        match self {
            Contradiction::Scatter { .. } => "scatter",
            Contradiction::Distance { .. } => "distance",
            Contradiction::CommonStrain { .. } => "common_strain",
        }
    }

    /// The contradiction in one English sentence without a full stop, lengths in mm.
    pub fn message(&self) -> String {
        match self {
            Contradiction::Scatter { fixture, ratio, limit } => {
                let with = fixture.as_ref().map_or_else(String::new, |name| format!(" with `{name}`"));
                format!("contacts{with} scatter {ratio:.2} times as much as predicted; by chance at most {limit:.2}")
            }
            Contradiction::Distance { between: [a, b], difference, deviations } => {
                let (millimetres, side) = (1e3 * difference.abs(), if *difference > 0.0 { "more" } else { "less" });
                let deviations = deviations.abs();
                format!(
                    "`{a}` and `{b}` are {millimetres:.3} mm {side} apart than declared, {deviations:.1} standard deviations"
                )
            }
            Contradiction::CommonStrain { strain, deviations } => {
                let (percent, side) = (100.0 * strain.abs(), if *strain > 0.0 { "longer" } else { "shorter" });
                let deviations = deviations.abs();
                format!(
                    "all distances of fixtures are {percent:.2} % {side} than declared, {deviations:.1} standard deviations"
                )
            }
        }
    }

    /// What it means for the use of the calibration: worth knowing.
    pub fn severity(&self) -> Severity {
        Severity::Caution
    }

    /// A remedy in one English sentence without a full stop.
    pub fn advice(&self) -> &'static str {
        match self {
            Contradiction::Scatter { .. } => {
                "check the declared noise, the force threshold and the places of these contacts; if they are right, the arm is off by more here than its calibration says: calibrate with contacts like these too, or estimate more parameters"
            }
            Contradiction::Distance { .. } => {
                "check which fixture each log belongs to, and measure this distance again; if both are right, a distance or a place that the calibration was given is wrong"
            }
            Contradiction::CommonStrain { .. } => {
                "measure these distances again, and those that the calibration was given, which make the scale of the arm; check their units"
            }
        }
    }
}
