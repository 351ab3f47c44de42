//! Texts of warnings that depend on more than their kind, and those that are long.

use super::effect_test::OmittedEffect;
use super::evaluation::Contradiction;
use crate::parameter::Unit;

/// Remedies, in one English sentence without a full stop.
pub(super) const CORRELATED_ERRORS_ADVICE: &str = "an effect is not in the model: the tool's length or pose (or its standard deviation), the shapes of the parts, or joints that are compliant under the contact force";
pub(super) const FEW_CONTACTS_ADVICE: &str = "record longer, and move every joint as far as the hole allows";
pub(super) const NOT_TOUCHING_ADVICE: &str = "check the shapes of the parts; or the search ended in a wrong minimum: give the fixture's pose as well as it is known";
pub(super) const NO_LIKELIHOOD_ADVICE: &str =
    "record longer with the tool inside the hole, and give places that are declared exact a standard deviation";
pub(super) const COMMON_SCALE_ADVICE: &str =
    "measure the distances of fixtures again and check their unit, and that the robot description is of this arm";
pub(super) const HARMONICS_ADVICE: &str =
    "correct measured positions by `correction.json`, beside `calibrated.urdf`, before using them";
pub(super) const PREDICTION_ADVICE: &str =
    "record again with parts clamped and the arm at one temperature, or estimate what the model leaves out";
pub(super) const LOAD_NOT_BORNE_ADVICE: &str =
    "check the body and the frame of the load (`load_on`, `load_frame`), and the force sensor's zero";
pub(super) const DISTANCE_ADVICE: &str = "check the unit of the distance, and which log belongs to which fixture";
pub(super) const UNDETERMINED_ADVICE: &str =
    "touch more places, other kinds of fixtures, or fixtures whose place or spacing is known";
pub(super) const LITTLE_IMPROVEMENT_ADVICE: &str = "keep the nominal arm if such errors are small enough for the task; \
    else touch more places, give parameters priors of plausible width, or estimate fewer";
pub(super) const NOISE_EXCEEDED_ADVICE: &str =
    "check the noise values, the shapes of the parts, and whether more parameters should be free";
pub(super) const NOISE_CONTRADICTED_ADVICE: &str =
    "check the shapes of the parts and the nominal places; if contacts do scatter so much, declare that noise";
pub(super) const COMPETING_MINIMUM_ADVICE: &str =
    "record longer, with more motion of the tool and the elbow, or give priors";
pub(super) const MANY_REJECTED_ADVICE: &str = "check which fixture each log belongs to, the force threshold, the shapes of the parts, and the places of tool and fixtures";
pub(super) const IMPLAUSIBLE_ADVICE: &str = "check units, the robot description, and where the fixtures are";
pub(super) const TOOL_ADVICE: &str =
    "declare the tool at its estimated pose where the calibrated robot is used (TCP, cell description)";
pub(super) const COMPLIANCE_ADVICE: &str =
    "apply it in the arm's driver by `correction.json`, or calibrate without joint compliance and backlash";
pub(super) const AGAINST_TORQUE_ADVICE: &str =
    "check whether `tau_joint` is \"load\" or \"motor\", and the sign of the joint's column of torques";
pub(super) const NO_UNCERTAINTY_ADVICE: &str =
    "use the exact shapes of the parts and method = \"levenberg_marquardt\" to get standard deviations";
pub(super) const ORIGIN_ADVICE: &str = "draw outlines about the origin; ignore this if the frame is meant to be there";

/// Messages.
pub(super) const TOOL_MESSAGE: &str = "the calibrated robot description does not contain the tool's estimated pose";
pub(super) const COMPLIANCE_MESSAGE: &str =
    "only touchcal reads joint compliance and backlash from the calibrated robot description";

/// Message on a distance that the nominal arm contradicts, a declared and a measured distance (mm).
pub(super) fn distance_message([a, b]: &[String; 2], declared: f64, measured: f64) -> String {
    // Digits that a conversion of units adds are none that were declared.
    let declared = (1e6 * declared).round() / 1e6;
    format!("`{a}` and `{b}` are declared {declared} mm apart; by the nominal arm it is {measured:.1} mm")
}

/// Message on a tool's outline with its middle beside the origin (mm).
pub(super) fn origin_message([x, y]: [f64; 2]) -> String {
    format!("the tool's outline does not enclose the origin: its middle is at ({x:.1}, {y:.1}) mm")
}

/// Message on other minima: their number, the tool's distance (m) in that of least cost, and the
/// parameter that differs most there.
pub(super) fn competing_minimum_message(minima: usize, tool_distance: f64, parameter: &str) -> String {
    let minima = if minima == 1 { "another minimum".to_owned() } else { format!("{minima} other minima") };
    let millimetres = 1e3 * tool_distance;
    format!(
        "contacts do not rule out {minima}: in that of least cost the tool is {millimetres:.1} mm away, and `{parameter}` differs most"
    )
}

/// Message on the parameter that the coarse stage moved farthest, and its deviation (1) over the
/// standard deviation of its prior, or over its plausible size.
pub(super) fn contradiction_message(name: &str, deviations: f64, has_prior: bool) -> String {
    let scale = if has_prior { "prior standard deviations" } else { "times its plausible size" };
    format!(
        "contacts come near the fixtures only where `{name}` is off by {deviations:.0} {scale}, and do not fit there"
    )
}

pub(super) fn too_few_contacts_message(rows: usize, parameters: usize) -> String {
    format!("{rows} measured rows cannot determine {parameters} parameters")
}

/// Message on so few one-sided contacts.
pub(super) fn few_contacts_message(contacts: usize) -> String {
    format!(
        "only {contacts} contacts of a peg in its hole: errors are far beyond their standard deviations more often than \
         these say"
    )
}

/// Message on the standard deviations (mm) of distances between positions of the tool before and
/// after the calibration.
pub(super) fn arm_undetermined_message(before: f64, after: f64) -> String {
    let percent = if before > 0.0 { 100.0 * after / before } else { 0.0 };
    format!(
        "distances between positions of the tool remain {percent:.0} % as uncertain as before the calibration: \
         {after:.3} mm, without contacts {before:.3} mm"
    )
}

/// Message on the expected errors (mm) of distances with the calibrated and the nominal arm.
pub(super) fn little_improvement_message(distance: f64, nominal_distance: f64) -> String {
    format!(
        "the calibrated arm is expected to be hardly better than the nominal one: distances between two positions of \
         the tool are off by {distance:.3} mm, with the nominal arm by {nominal_distance:.3} mm"
    )
}

/// Message on a share (0 to 1) of the contacts with a fixture, or with all, that were rejected.
pub(super) fn many_rejected_message(fixture: Option<&str>, share: f64) -> String {
    let with = fixture.map_or_else(String::new, |name| format!(" with `{name}`"));
    format!("{:.0} % of the contacts{with} do not fit and were rejected", 100.0 * share)
}

pub(super) fn unobservable_message(names: &[String]) -> String {
    format!("the data do not determine these parameters, which are fixed at zero: {}", names.join(", "))
}

pub(super) fn few_informative_message(informative_fraction: f64, inflation: f64) -> String {
    let share = 100.0 * informative_fraction;
    format!("only {share:.0} % of the one-sided contacts are informative; intervals are scaled by {inflation}")
}

/// Message on a share (0 to 1) of contacts.
pub(super) fn load_not_borne_message(share: f64) -> String {
    format!("in {:.0} % of the contacts no surface near the tool bears the measured load", 100.0 * share)
}

pub(super) fn noise_contradicted_message(factor: f64, declared: bool) -> String {
    format!("contacts scatter {factor:.1} times more than the {} noise", noise_name(declared))
}

pub(super) fn little_motion_message(joint: &str, range: f64) -> String {
    format!("joint `{joint}` moved only {:.2}° in all contacts", range.to_degrees())
}

/// Message on a value (SI) that is too large.
pub(super) fn implausible_message(name: &str, value: f64, unit: Unit) -> String {
    let value = match unit {
        Unit::Meter => format!("{:.1} mm", 1e3 * value),
        Unit::Radian => format!("{:.2}°", value.to_degrees()),
        Unit::RadianPerNewtonMeter => format!("{:.1} µrad/(N m)", 1e6 * value),
        Unit::One | Unit::Newton | Unit::NewtonMeter => format!("{value:.3}"),
    };
    format!("`{name}` ended at {value}, too large for a calibration")
}

pub(super) fn symmetric_part_message(name: &str, angle: f64) -> String {
    format!("`{name}` is ambiguous: rotated by multiples of {:.0}° the part has the same shape", angle.to_degrees())
}

pub(super) fn far_from_prior_message(name: &str, deviations: f64) -> String {
    format!("`{name}` ended {deviations:.1} standard deviations from what was declared")
}

/// Message on a joint that deflects against its torque.
pub(super) fn against_torque_message(name: &str, deviations: f64) -> String {
    format!("`{name}` is below 0 by {:.0} standard deviations: no joint deflects against its torque", -deviations)
}

/// Message on contacts that were held out and contradict the calibration.
pub(super) fn held_out_message(contradiction: &Contradiction) -> String {
    format!("contacts that were held out contradict this calibration: {}", contradiction.message())
}

/// Message on contacts that scatter `factor` (1) times more than noise that is `declared`, or not.
pub(super) fn noise_message(factor: f64, declared: bool) -> String {
    format!(
        "contacts scatter {factor:.1} times more than the {} noise, which widens all intervals",
        noise_name(declared)
    )
}

fn noise_name(declared: bool) -> &'static str {
    if declared { "declared" } else { "assumed" }
}

/// Message on correlated contacts with this design effect (1).
pub(super) fn design_effect_message(d: f64) -> String {
    format!("contact errors are correlated (design effect {d:.0}: {d:.0} contacts count as one)")
}

/// Message on a mean gap at contact (m).
pub(super) fn not_touching_message(name: &str, gap: f64) -> String {
    let verb = if gap > 0.0 { "float" } else { "penetrate" };
    format!("`{name}`: parts {verb} by {:.2} mm on average at contact", 1e3 * gap.abs())
}

/// Message on a common strain (1) of all lengths of the arm, in its prior standard deviations.
pub(super) fn scale_message(strain: f64, deviations: f64) -> String {
    let (size, side) = (100.0 * strain.abs(), if strain > 0.0 { "longer" } else { "shorter" });
    format!(
        "all lengths of the arm would be {size:.2} % {side} than described, {deviations:.1} prior standard deviations"
    )
}

/// Message on stretches of the log that others do not predict: found over predicted scatter, and
/// factor of the standard deviations (1).
pub(super) fn prediction_message(ratio: f64, widening: f64) -> String {
    format!(
        "stretches of the log are {ratio:.1} times farther from what the others predict than expected; standard deviations are {widening:.1} times larger for that"
    )
}

/// Message on harmonics and gear ratios of encoders that move the tool by `displacement` (m).
pub(super) fn harmonics_message(displacement: f64) -> String {
    format!(
        "the calibrated robot description does not contain the encoders' harmonics and gear ratios, which move the tool by {:.3} mm",
        1e3 * displacement
    )
}

/// Advice on an estimate far from what was declared, for the parameter or distance of this name.
pub(super) fn far_from_prior_advice(name: &str) -> &'static str {
    match name.split('.').next() {
        Some("tool") => "measure the tool's pose again, and check its unit and axes",
        Some("fixture") => "measure the fixture's pose again, and check its unit and axes",
        Some("gap_bias") => "measure the clearance and the depth again, and check the outlines and their unit",
        Some("distance") => "measure the distance again, and check its unit and which log belongs to which fixture",
        Some("joint_trend") => {
            "encoders drift more than declared (encoder_trend_deg): let the arm warm up, or declare a larger drift"
        }
        Some("joint_walk") => {
            "encoders drift more than declared (encoder_walk_deg): let the arm warm up, or declare a larger drift"
        }
        _ => "check the nominal robot description, or give the parameter a larger standard deviation",
    }
}

/// Message on contacts that were measured by their distance from a projection.
pub(super) fn no_uncertainty_message() -> String {
    "neither distances from a projection nor the end of a gradient descent have a known distribution: there are no standard deviations".to_owned()
}

/// Message on an effect that the model leaves out, with the corrected p-value and how far (m) it
/// moves the tool; `is_widened` if standard deviations allow for that.
pub(super) fn omitted_effect_message(
    effect: &OmittedEffect,
    (p_value, displacement): (f64, f64),
    is_widened: bool,
) -> String {
    effect.message(p_value, displacement) + if is_widened { "; intervals are wider by that" } else { "" }
}
