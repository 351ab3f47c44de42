//! The contact manifold of a hole as a projection: onto recorded poses, or by a network that
//! learned it.

use std::sync::Arc;

use toml::Spanned;

use super::context::{Allowed, Context, DEG, MM};
use super::schema::{FixtureToml, ManifoldToml, Number, Text};
use crate::io::base::bytes::Input;
use crate::io::base::error::IoError;
use crate::io::manifold::manifold_file;
#[cfg(feature = "learned")]
use crate::io::manifold::weights_file::WeightsFile;
use crate::manifold::coordinates::Metric;
use crate::manifold::{ContactManifold, NearestSample, Projected};

/// Most neighbours of a projection.
const MOST_NEIGHBOURS: f64 = 1000.0;

/// Refuses keys of another manifold than the fixture's.
pub(super) fn check_keys(fixture: &FixtureToml, name: &str, context: &Context<'_>) -> Result<(), IoError> {
    let text = |value: &Option<Text>, key| value.as_ref().map(|value| (value.span(), key));
    let number = |value: &Option<Number>, key| value.as_ref().map(|value| (value.span(), key));
    let chosen = fixture.manifold.as_ref().map_or(ManifoldToml::Exact, |manifold| *manifold.get_ref());
    let of_nearest = text(&fixture.samples, "samples")
        .or(number(&fixture.neighbours, "neighbours"))
        .or(number(&fixture.mm_per_deg, "mm_per_deg"));
    let of_learned = text(&fixture.weights, "weights");
    let foreign = [
        (of_nearest, ManifoldToml::Nearest, "`manifold = \"nearest\"`"),
        (of_learned, ManifoldToml::Learned, "`manifold = \"learned\"`"),
    ];
    for (key, manifold, expected) in foreign {
        if let Some((span, key)) = key.filter(|_| manifold != chosen) {
            return Err(IoError::unexpected(context.place(span, name), expected, format!("`{key}` without it")));
        }
    }
    Ok(())
}

/// Touch as distance from the nearest of recorded poses.
pub(super) fn nearest(
    fixture: &Spanned<FixtureToml>,
    context: &Context<'_>,
    inputs: &mut Vec<Input>,
) -> Result<Box<dyn ContactManifold>, IoError> {
    let table = fixture.get_ref();
    let name = format!("fixture `{}`", table.name.get_ref());
    let Some(samples) = &table.samples else {
        let expected = "`samples`, a manifold or file of poses to be nearest to";
        return Err(IoError::unexpected(context.place(fixture.span(), name), expected, "none"));
    };
    let field = format!("{name}, mm_per_deg");
    let length = context.number(table.mm_per_deg.as_ref(), MM / DEG, Allowed::Positive, &field)?;
    let field = format!("{name}, neighbours");
    let neighbours = context.whole(table.neighbours.as_ref(), MOST_NEIGHBOURS, &field)?.unwrap_or(1);
    let (samples, thinned_in, input) =
        manifold_file::read_samples(&context.path(samples, &format!("{name}, samples"))?)?;
    inputs.push(input);
    let given = length.map(|metres_per_radian| Metric { metres_per_radian });
    let metric = given.or(thinned_in).unwrap_or(Metric::MILLIMETRE_PER_DEGREE);
    Ok(Box::new(Projected(Arc::new(NearestSample::new(samples, metric).with_neighbours(neighbours)))))
}

/// Touch as distance from where a network projects: not in this build.
#[cfg(not(feature = "learned"))]
pub(super) fn learned(
    fixture: &Spanned<FixtureToml>,
    context: &Context<'_>,
    _: &mut Vec<Input>,
) -> Result<Box<dyn ContactManifold>, IoError> {
    let name = format!("fixture `{}`", fixture.get_ref().name.get_ref());
    let expected = "a manifold of this build, which lacks the feature `learned`";
    Err(IoError::unexpected(context.place(fixture.span(), name), expected, "`manifold = \"learned\"`"))
}

/// Touch as distance from where a network projects.
#[cfg(feature = "learned")]
pub(super) fn learned(
    fixture: &Spanned<FixtureToml>,
    context: &Context<'_>,
    inputs: &mut Vec<Input>,
) -> Result<Box<dyn ContactManifold>, IoError> {
    let table = fixture.get_ref();
    let name = format!("fixture `{}`", table.name.get_ref());
    let Some(weights) = &table.weights else {
        let expected = "`weights`, a network from `touchcal train`";
        return Err(IoError::unexpected(context.place(fixture.span(), name), expected, "none"));
    };
    let (file, input) = WeightsFile::read_file(&context.path(weights, &format!("{name}, weights"))?)?;
    inputs.push(input);
    Ok(Box::new(Projected(Arc::new(file.projection))))
}
