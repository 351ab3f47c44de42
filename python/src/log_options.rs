//! How a log is to be read, by the keywords of its constructors.

use std::collections::BTreeMap;

use pyo3::prelude::*;
use touchcal::contact::{AngleUnit, Detection, Load, LoadFrame, LoadOn, TorqueOf};
use touchcal::io::contact_log::Options;

use crate::error::{optional_argument, unexpected};
use crate::list_of::ListOf;

/// Largest motion (rad, or m) between two contacts that is taken for one in these units: contacts
/// of one log rarely lie 20° apart, and 1 is meant in degrees.
const MOST_APART: f64 = 0.35;
/// What rows are contacts: threshold and release (N), debounce (rows), and how far apart (rad or
/// m).
pub type Chosen = (Option<f64>, Option<f64>, usize, Option<f64>);

/// What the wrench says of the load: `load_on`, `load_frame` and `load_lag`.
pub type LoadWords<'a> = (Option<&'a str>, Option<&'a str>, Option<f64>);

/// The options of a log, for the keywords of its constructors.
pub fn options(
    unit: Option<&str>,
    joints: Option<&Bound<'_, PyAny>>,
    columns: Option<BTreeMap<String, String>>,
    (threshold, release, debounce, apart): Chosen,
    (load, tau_joint): (LoadWords<'_>, Option<&str>),
) -> PyResult<Options> {
    let unit = match unit {
        None => AngleUnit::Undeclared,
        Some("rad") => AngleUnit::Radian,
        Some("deg") => AngleUnit::Degree,
        Some(other) => return Err(unexpected("unit", "\"rad\" or \"deg\"", format!("{other:?}"))),
    };
    let positive = |what: &str, value: Option<f64>| match value.filter(|value| !(*value > 0.0 && value.is_finite())) {
        Some(bad) => Err(unexpected(what, "a positive number", format!("{bad}"))),
        None => Ok(()),
    };
    positive("force_threshold", threshold)?;
    positive("release", release)?;
    positive("apart", apart)?;
    if let Some(apart) = apart.filter(|apart| *apart > MOST_APART) {
        let expected = format!("at most {MOST_APART} rad or m; of degrees, math.radians(degrees)");
        return Err(unexpected("apart", &expected, format!("{apart}")));
    }
    if threshold.is_none() && (release.is_some() || debounce != 1) {
        return Err(unexpected("contacts", "`force_threshold`", "`release` or `debounce` without it"));
    }
    if debounce == 0 {
        return Err(unexpected("debounce", "at least 1 row", "0"));
    }
    if let (Some(threshold), Some(release)) = (threshold, release)
        && release > threshold
    {
        return Err(unexpected("release", format!("at most force_threshold ({threshold})"), format!("{release}")));
    }
    let detection = threshold.map(|threshold| Detection { threshold, release: release.unwrap_or(threshold), debounce });
    let load = self::load(load)?;
    let joint_torques = match tau_joint {
        None => None,
        Some(_) if load.is_some() => return Err(unexpected("tau_joint", "`tau_joint` or `load_on`", "both")),
        Some("load") => Some(TorqueOf::Load),
        Some("motor") => Some(TorqueOf::Motor),
        Some(other) => return Err(unexpected("tau_joint", "\"load\" or \"motor\"", format!("{other:?}"))),
    };
    let joints = optional_argument::<ListOf<String>>(joints, "joints")?.map(|joints| joints.0);
    let columns = columns.unwrap_or_default();
    Ok(Options { unit, joints, columns, detection, apart, load, joint_torques, ..Options::default() })
}

/// The load that they say.
fn load((on, frame, lag): LoadWords<'_>) -> PyResult<Option<Load>> {
    let on = match on {
        None if frame.is_some() => return Err(unexpected("load_frame", "`load_on`", "`load_frame` without it")),
        None if lag.is_some() => return Err(unexpected("load_lag", "`load_on`", "`load_lag` without it")),
        None => return Ok(None),
        Some("tool") => LoadOn::Tool,
        Some("fixture") => LoadOn::Fixture,
        Some(other) => return Err(unexpected("load_on", "\"tool\" or \"fixture\"", format!("{other:?}"))),
    };
    let frame = match frame {
        None | Some("tip") => LoadFrame::Tip,
        Some("base") => LoadFrame::Base,
        Some(other) => return Err(unexpected("load_frame", "\"tip\" or \"base\"", format!("{other:?}"))),
    };
    let lag = lag.unwrap_or(0.0);
    if !(lag >= 0.0 && lag.is_finite()) {
        return Err(unexpected("load_lag", "a number of rows, at least 0", format!("{lag}")));
    }
    Ok(Some(Load { on, frame, lag }))
}
