//! Where contacts put the fixtures.

use nalgebra::{DMatrix, DVector, Matrix3, Matrix3xX, Vector3};

use super::prediction_model::PredictionModel;
use crate::estimate::model::{CalibrationModel, LinearizationPoint, Objective, contact_caches, contact_equations};
use crate::estimate::result::Scatter;
use crate::manifold::ResidualKind;
use crate::parameter::ParameterId;
use crate::solver::{FreeParameters, Loss, NormalEquations};

/// Gauss–Newton steps to where contacts put the fixtures; sockets need one.
const STEPS: usize = 4;

/// The origin of a fixture, located by contacts with it.
pub(super) struct FixtureLocation {
    /// In base (m).
    pub origin: Vector3<f64>,
    /// Covariance (m²) in base, by the noise of its contacts.
    pub noise: Matrix3<f64>,
    /// Derivative by the parameters of the arm (3 rows, in base).
    pub sensitivity: Matrix3xX<f64>,
}

/// Locations of the fixtures; `None` where contacts do not locate the origin. `scatter` is that of
/// each: where it is more than predicted, so is the noise of the location.
pub(super) fn locations(prediction: &PredictionModel<'_>, scatter: &[Option<Scatter>]) -> Vec<Option<FixtureLocation>> {
    let model = &prediction.model;
    let mut theta = prediction.theta.clone();
    let mut caches = contact_caches(model);
    let blocks: Vec<FixtureBlock> = (0..scatter.len()).map(|f| FixtureBlock::new(model, f)).collect();
    let mut equations = NormalEquations::new(theta.len());
    for _ in 0..STEPS {
        equations = contact_equations(model, &theta, (Objective::Residual(Loss::Squared), 1), &mut caches).complete();
        for block in &blocks {
            let step = block.inverse(&equations) * block.of(&equations.gradient);
            block.indices.iter().zip(step.iter()).for_each(|(&k, step)| theta[k] -= step);
        }
    }
    let point = LinearizationPoint::new(model, &theta);
    let each = blocks.iter().zip(scatter).enumerate().map(|(f, (block, scatter))| {
        let scatter = scatter.filter(|_| block.is_located())?;
        // The least of several gaps is biased.
        let is_biased = model.problem.fixtures[f].manifold.residual_kind() == ResidualKind::LeastGap;
        let inflation = if is_biased { model.problem.options.contact_mode.least_gap_inflation } else { 1.0 };
        Some(block.location(&equations, &point, f, inflation * scatter.ratio().max(1.0)))
    });
    each.collect()
}

/// The parameters of one fixture: those of its place, then its gap bias.
struct FixtureBlock {
    indices: Vec<usize>,
    /// Components of the place's twist.
    components: Vec<usize>,
    free: FreeParameters,
}

impl FixtureBlock {
    fn new(model: &CalibrationModel<'_>, f: usize) -> Self {
        let parameters = &model.layout.parameters;
        let of = |wanted: &dyn Fn(ParameterId) -> Option<usize>| -> Vec<(usize, usize)> {
            (0..parameters.len()).filter_map(|k| Some((k, wanted(parameters[k].id)?))).collect()
        };
        let mut place = of(&|id| if let ParameterId::Fixture(of, k) = id { (of == f).then_some(k) } else { None });
        place.sort_by_key(|&(_, component)| component);
        let bias = of(&|id| (id == ParameterId::GapBias(f)).then_some(0));
        let has_point = !matches!(
            model.problem.fixtures[f].manifold.residual_kind(),
            ResidualKind::ProjectionError | ResidualKind::Unmodeled
        );
        let components = place.iter().map(|&(_, component)| component).filter(|_| has_point).collect();
        let indices: Vec<usize> = place.iter().chain(&bias).map(|&(k, _)| k).collect();
        let scale = indices.iter().map(|&k| parameters[k].prior_sigma().unwrap_or(parameters[k].scale));
        let free = FreeParameters::new(DVector::from_iterator(indices.len(), scale));
        FixtureBlock { indices, components, free }
    }

    /// Whether the origin is located: contacts depend on it in all directions.
    fn is_located(&self) -> bool {
        self.components.starts_with(&[0, 1, 2])
    }

    fn of(&self, vector: &DVector<f64>) -> DVector<f64> {
        vector.select_rows(&self.indices)
    }

    /// Covariance of the block by the noise of its contacts. What they do not determine stays
    /// within its plausible size.
    fn inverse(&self, equations: &NormalEquations) -> DMatrix<f64> {
        let mut information = equations.information.select_rows(&self.indices).select_columns(&self.indices);
        for (k, scale) in self.free.scale().iter().enumerate() {
            information[(k, k)] += scale.powi(-2);
        }
        self.free.covariance(&information)
    }

    /// The location of fixture `f`, whose noise is `factor` times that declared.
    fn location(
        &self,
        equations: &NormalEquations,
        point: &LinearizationPoint<'_>,
        f: usize,
        factor: f64,
    ) -> FixtureLocation {
        let inverse = self.inverse(equations);
        let mut coupling = equations.information.select_rows(&self.indices);
        self.indices.iter().for_each(|&k| coupling.column_mut(k).fill(0.0));
        let place = &point.fixtures[f].base_from_fixture;
        let rotation = place.rotation.to_rotation_matrix().into_inner();
        let local = inverse.fixed_view::<3, 3>(0, 0);
        FixtureLocation {
            origin: place.translation.vector,
            noise: rotation * local * rotation.transpose() * factor.powi(2),
            sensitivity: -(rotation * (inverse * coupling).fixed_rows::<3>(0)),
        }
    }
}
