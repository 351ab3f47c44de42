//! How a log is to be read: what its table of `[[contacts]]` says, else `[log]`.

use toml::Spanned;

use super::context::{Allowed, Context, DEG};
use super::schema::{ContactsToml, LoadFrameToml, LoadOnToml, LogToml, TauJointToml, UnitToml};
use crate::contact::{AngleUnit, Detection, Load, LoadFrame, LoadOn, TorqueOf};
use crate::io::base::error::{IoError, shown_number};
use crate::io::log::contact_log::Options;

/// Most rows that a change of contact may be made to wait for.
const MAX_DEBOUNCE: i64 = 1_000_000;

/// The options of a log, but for its fixture and the order of the joints.
pub(super) fn options(table: &ContactsToml, log: &LogToml, context: &Context<'_>) -> Result<Options, IoError> {
    let keys = table.with(log);
    let apart = field("apart_deg", table.apart_deg.is_some());
    Ok(Options {
        unit: match keys.unit {
            None => AngleUnit::Undeclared,
            Some(UnitToml::Radian) => AngleUnit::Radian,
            Some(UnitToml::Degree) => AngleUnit::Degree,
        },
        detection: detection(table, &keys, context)?,
        apart: context.number(keys.apart_deg.as_ref(), DEG, Allowed::Positive, &apart)?,
        load: load(table, &keys, context)?,
        joint_torques: joint_torques(table, &keys, context)?,
        header: keys.header,
        temperature: keys.temperature,
        joint_topic: keys.joint_topic,
        wrench_topic: keys.wrench_topic,
        columns: keys.columns.unwrap_or_default(),
        ..Options::default()
    })
}

/// A key and its table, which is `[log]` where the table of the log does not have the key itself.
fn field(key: &str, is_own: bool) -> String {
    format!("{}, {key}", if is_own { "contacts" } else { "log" })
}

/// Which rows are contacts, by their force.
fn detection(table: &ContactsToml, keys: &LogToml, context: &Context<'_>) -> Result<Option<Detection>, IoError> {
    let positive = |number, key, is_own| context.number(number, 1.0, Allowed::Positive, &field(key, is_own));
    let threshold = positive(keys.force_threshold_n.as_ref(), "force_threshold_n", table.force_threshold_n.is_some())?;
    let release = positive(keys.release_n.as_ref(), "release_n", table.release_n.is_some())?;
    let debounce = keys.debounce.as_ref();
    if let Some(debounce) = debounce.filter(|debounce| !(1..=MAX_DEBOUNCE).contains(debounce.get_ref())) {
        let expected = format!("a number of rows from 1 to {MAX_DEBOUNCE}");
        let place = context.place(debounce.span(), field("debounce", table.debounce.is_some()));
        return Err(IoError::unexpected(place, expected, format!("{}", debounce.get_ref())));
    }
    let companion = keys.release_n.as_ref().map(Spanned::span).or(debounce.map(Spanned::span));
    if let (None, Some(span)) = (threshold, companion) {
        let found = "`release_n` or `debounce` without it";
        let own = table.release_n.is_some() || table.debounce.is_some();
        let place = context.place(span, if own { "contacts" } else { "log" });
        return Err(IoError::unexpected(place, "`force_threshold_n`", found));
    }
    if let (Some(threshold), Some(release), Some(number)) = (threshold, release, &keys.release_n)
        && release > threshold
    {
        let expected = format!("at most force_threshold_n ({threshold})");
        let place = context.place(number.span(), field("release_n", table.release_n.is_some()));
        return Err(IoError::unexpected(place, expected, shown_number(release)));
    }
    Ok(threshold.map(|threshold| Detection {
        threshold,
        release: release.unwrap_or(threshold),
        debounce: debounce.and_then(|debounce| usize::try_from(*debounce.get_ref()).ok()).unwrap_or(1),
    }))
}

/// What the wrench of a log says of the load on the arm.
fn load(table: &ContactsToml, keys: &LogToml, context: &Context<'_>) -> Result<Option<Load>, IoError> {
    let frame = match keys.load_frame.as_ref().map(|frame| *frame.get_ref()) {
        Some(LoadFrameToml::Base) => LoadFrame::Base,
        Some(LoadFrameToml::Tip) | None => LoadFrame::Tip,
    };
    let lag_field = field("load_lag_rows", table.load_lag_rows.is_some());
    let lag = context.number(keys.load_lag_rows.as_ref(), 1.0, Allowed::NotNegative, &lag_field)?.unwrap_or(0.0);
    let on = match keys.load_on {
        Some(LoadOnToml::Tool) => LoadOn::Tool,
        Some(LoadOnToml::Fixture) => LoadOn::Fixture,
        None => {
            let frame = keys.load_frame.as_ref().map(|frame| ("load_frame", frame.span(), table.load_frame.is_some()));
            let lag = keys.load_lag_rows.as_ref();
            let lag = lag.map(|lag| ("load_lag_rows", lag.span(), table.load_lag_rows.is_some()));
            let Some((key, span, is_own)) = frame.or(lag) else { return Ok(None) };
            let place = context.place(span, field(key, is_own));
            return Err(IoError::unexpected(place, "`load_on`", format!("`{key}` without it")));
        }
    };
    Ok(Some(Load { on, frame, lag }))
}

/// Whose torques the joint torques of a log are.
fn joint_torques(table: &ContactsToml, keys: &LogToml, context: &Context<'_>) -> Result<Option<TorqueOf>, IoError> {
    let Some(given) = &keys.tau_joint else { return Ok(None) };
    if keys.load_on.is_some() {
        let place = context.place(given.span(), field("tau_joint", table.tau_joint.is_some()));
        let found =
            "both: measured joint torques have the load in them, and what a peg rests on is then found from gaps alone";
        return Err(IoError::unexpected(place, "`tau_joint` or `load_on`", found));
    }
    Ok(Some(match given.get_ref() {
        TauJointToml::Load => TorqueOf::Load,
        TauJointToml::Motor => TorqueOf::Motor,
    }))
}
