//! The parameters of a problem in order, and which contacts depend on which.

use crate::estimate::options::EstimatorOptions;
use crate::estimate::problem::{PlacePrior, Problem, WrenchTolerance};
use crate::estimate::untouched::are_placed;
use crate::manifold::{AXIS_DIRECTIONS, ResidualKind};
use crate::parameter::{
    Parameter, ParameterId, Prior, directional_gap_bias, gap_bias, joint_drift, wrench_bias, wrench_scale,
};
use crate::robot::KinematicParameter;
use nalgebra::{DMatrix, DVector};

/// The parameters of a problem in order, and which contacts depend on which.
#[derive(Clone)]
pub(crate) struct ParameterLayout {
    /// All parameters: the arm's, drifts, the tool's, each fixture's, each gap bias and the
    /// wrench's.
    pub parameters: Vec<Parameter>,
    /// Index of each parameter among those of the kinematics; 0 for the others.
    pub kinematic_index: Vec<usize>,
    /// For each fixture, the indices of all parameters that its contacts depend on, ascending.
    pub dependencies: Vec<Vec<usize>>,
    /// Index of each fixture's placement, in the order of their first fixture.
    pub placement: Vec<usize>,
}

impl ParameterLayout {
    /// The parameters of `problem` in order.
    pub fn new(problem: &Problem) -> Self {
        let (placement_names, placement) = placements(problem);
        let parameters = all_parameters(problem, &placement_names);
        ParameterLayout::of(problem, parameters, placement)
    }

    /// These parameters and `more` behind them.
    pub fn extended(&self, problem: &Problem, more: impl IntoIterator<Item = Parameter>) -> Self {
        let parameters = self.parameters.iter().cloned().chain(more).collect();
        ParameterLayout::of(problem, parameters, self.placement.clone())
    }

    fn of(problem: &Problem, parameters: Vec<Parameter>, placement: Vec<usize>) -> Self {
        let mut kinematic_count = 0;
        let kinematic_index = parameters.iter().map(|parameter| {
            let index = kinematic_count;
            kinematic_count += usize::from(parameter.id.kinematic().is_some());
            index
        });
        let dependencies = (0..problem.fixtures.len()).map(|f| dependencies(&parameters, f, placement[f]));
        ParameterLayout {
            kinematic_index: kinematic_index.collect(),
            dependencies: dependencies.collect(),
            placement,
            parameters,
        }
    }

    /// Whether any parameter is of the measured wrench.
    pub fn has_wrench(&self) -> bool {
        let mut ids = self.parameters.iter().map(|parameter| parameter.id);
        ids.any(|id| matches!(id, ParameterId::WrenchBias(_) | ParameterId::WrenchScale))
    }

    /// Number of parameters.
    pub fn len(&self) -> usize {
        self.parameters.len()
    }

    /// The parameters of the kinematics, in order.
    pub fn kinematic(&self) -> Vec<KinematicParameter> {
        self.parameters.iter().filter_map(|parameter| parameter.id.kinematic()).collect()
    }

    /// Scale of every parameter, in its unit: its prior's standard deviation, else its plausible
    /// size.
    pub fn scale(&self) -> DVector<f64> {
        let each = self.parameters.iter().map(|parameter| parameter.prior_sigma().unwrap_or(parameter.scale));
        DVector::from_iterator(self.len(), each)
    }

    /// Sets the standard deviation (> 0, in the parameter's unit) of the prior of parameter number
    /// `k` of the layout; returns `|ln(new / old)|`.
    pub fn set_prior_sigma(&mut self, k: usize, sigma: f64) -> f64 {
        let prior = &mut self.parameters[k].prior;
        let before = prior.sigma();
        *prior = prior.with_sigma(sigma);
        before.map_or(0.0, |before| (sigma / before).ln().abs())
    }
}

/// Parameters whose priors share a standard deviation, a variance component.
pub(crate) struct PriorGroup {
    /// Indices of the group's parameters.
    pub members: Vec<usize>,
    /// Start of the standard deviation, and the number of observed values that it counts as.
    start: f64,
    strength: f64,
}

impl PriorGroup {
    /// The variance components of a layout; directional gap biases have groups of their own.
    pub fn variance_components(layout: &ParameterLayout) -> Vec<PriorGroup> {
        let mut names: Vec<&str> = Vec::new();
        let mut groups: Vec<PriorGroup> = Vec::new();
        for (k, parameter) in layout.parameters.iter().enumerate() {
            let Prior::VarianceComponent { sigma, group, strength } = parameter.prior else { continue };
            if let Some(g) = names.iter().position(|name| *name == group) {
                groups[g].members.push(k);
            } else {
                names.push(group);
                groups.push(PriorGroup { members: vec![k], start: sigma, strength });
            }
        }
        groups
    }

    /// The directional gap biases of each fixture that has any.
    pub fn directional_gap_biases(layout: &ParameterLayout, options: &EstimatorOptions) -> Vec<PriorGroup> {
        let options = &options.contact_mode;
        let (start, strength) = (options.directional_bias_sigma, options.directional_bias_strength);
        let fixtures = 0..layout.dependencies.len();
        let members = fixtures.map(|f| {
            let is_of_fixture =
                |k: &usize| matches!(layout.parameters[*k].id, ParameterId::DirectionalGapBias(of, _) if of == f);
            (0..layout.len()).filter(is_of_fixture).collect::<Vec<_>>()
        });
        let some = members.filter(|members| !members.is_empty());
        some.map(|members| PriorGroup { members, start, strength }).collect()
    }

    /// The maximisation step: the standard deviation with the greatest expected likelihood,
    /// `σ² = (Σ (xᵢ² + Sᵢᵢ) + n₀ b²) / (n + n₀)`, for a posterior with mean `x` (`theta`) and
    /// covariance `S` of all parameters (SI).
    pub fn m_step(&self, theta: &DVector<f64>, covariance: &DMatrix<f64>) -> f64 {
        let squares: f64 = self.members.iter().map(|&k| theta[k].powi(2) + covariance[(k, k)].max(0.0)).sum();
        let count = self.members.len() as f64 + self.strength;
        ((squares + self.strength * self.start.powi(2)) / count).sqrt()
    }
}

/// Number of parameters of a problem: those that it names, places, gap biases, and the wrench's.
pub(crate) fn parameter_count(problem: &Problem) -> usize {
    all_parameters(problem, &placements(problem).0).len()
}

/// Names of the placements in the order of their first fixture, and the placement of each fixture.
fn placements(problem: &Problem) -> (Vec<&str>, Vec<usize>) {
    let mut names: Vec<&str> = Vec::new();
    let mut index = Vec::with_capacity(problem.fixtures.len());
    for fixture in &problem.fixtures {
        let known = names.iter().position(|name| *name == fixture.placement);
        index.push(known.unwrap_or(names.len()));
        if known.is_none() {
            names.push(&fixture.placement);
        }
    }
    (names, index)
}

/// The arm's parameters, then the tool's, each fixture's, each gap bias and the wrench's.
fn all_parameters(problem: &Problem, placements: &[&str]) -> Vec<Parameter> {
    let mut parameters = problem.parameters.clone();
    // The drift of a single placement cannot be told from the offsets.
    if problem.joint_drift && placements.len() > 1 {
        for (p, name) in placements.iter().enumerate() {
            parameters.extend(joint_drift(&problem.robot, p, name));
        }
    }
    let tool_directions = tool_directions(problem);
    let of_tool = |k: usize| Parameter::twist("tool", ParameterId::tool(k), k);
    parameters.extend(place_parameters(problem.tool.prior, &tool_directions, of_tool));
    let are_placed = are_placed(problem);
    for (f, fixture) in problem.fixtures.iter().enumerate().filter(|(f, _)| are_placed[*f]) {
        let prefix = format!("fixture.{}", fixture.name);
        let of_fixture = |k: usize| Parameter::twist(&prefix, ParameterId::Fixture(f, k), k);
        parameters.extend(place_parameters(fixture.prior, fixture.manifold.fixture_directions(), of_fixture));
    }
    for (f, fixture) in problem.fixtures.iter().enumerate() {
        if fixture.manifold.residual_kind() == ResidualKind::LeastGap {
            let options = &problem.options;
            parameters.push(gap_bias(&fixture.name, f).with_sigma(options.search.gap_bias_sigma));
            let sigma = options.contact_mode.directional_bias_sigma;
            parameters
                .extend((0..AXIS_DIRECTIONS).map(|k| directional_gap_bias(&fixture.name, f, k).with_sigma(sigma)));
        }
    }
    if problem.deflects_under_loads() {
        let with_sigma = |(parameter, sigma): (Parameter, f64)| (sigma > 0.0).then(|| parameter.with_sigma(sigma));
        parameters.extend(wrench_parameters(problem.wrench).filter_map(with_sigma));
    }
    parameters
}

/// The parameters of the wrench, without prior, and their standard deviations in `tolerance`.
pub(super) fn wrench_parameters(tolerance: WrenchTolerance) -> impl Iterator<Item = (Parameter, f64)> {
    let WrenchTolerance { force, torque, scale, .. } = tolerance;
    let bias = (0..6).map(move |k| (wrench_bias(k), if k < 3 { force } else { torque }));
    bias.chain(std::iter::once((wrench_scale(), scale)))
}

/// Components of a twist on the tool's pose that change any contact, ascending.
pub(super) fn tool_directions(problem: &Problem) -> Vec<usize> {
    let each = problem.fixtures.iter().flat_map(|fixture| fixture.manifold.tool_directions().iter().copied());
    let mut directions: Vec<usize> = each.collect();
    directions.sort_unstable();
    directions.dedup();
    directions
}

/// The components of a twist that are to be estimated, with their priors.
fn place_parameters(prior: PlacePrior, directions: &[usize], parameter: impl Fn(usize) -> Parameter) -> Vec<Parameter> {
    let each = directions.iter().filter_map(|&k| match prior {
        PlacePrior::Fixed => None,
        PlacePrior::Flat => Some(parameter(k)),
        PlacePrior::Gaussian { sigma, sigma_angle } => {
            let sigma = if k < 3 { sigma } else { sigma_angle };
            (sigma > 0.0).then(|| parameter(k).with_sigma(sigma))
        }
    });
    each.collect()
}

/// Indices of the parameters that contacts with a fixture depend on.
fn dependencies(parameters: &[Parameter], fixture: usize, placement: usize) -> Vec<usize> {
    let depends = |id: ParameterId| match id {
        ParameterId::Fixture(f, _) | ParameterId::GapBias(f) | ParameterId::DirectionalGapBias(f, _) => f == fixture,
        ParameterId::EdgeRadius(f) => f == fixture,
        ParameterId::JointDrift(p, _) => p == placement,
        ParameterId::Kinematic(_) | ParameterId::JointTrend(_) => true,
        ParameterId::JointWalk(..) | ParameterId::EncoderError(..) => true,
        ParameterId::WrenchBias(_) | ParameterId::WrenchScale => true,
        ParameterId::Distance(_) => false,
    };
    (0..parameters.len()).filter(|&k| depends(parameters[k].id)).collect()
}
