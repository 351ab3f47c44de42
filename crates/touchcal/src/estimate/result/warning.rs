//! Warnings with their severity, message and advice.

use serde::{Deserialize, Serialize};

use super::declaration_mistake::{Agreement, DeclarationMistake};
use super::descent_failure::DescentFailure;
use super::effect_test::OmittedEffect;
use super::evaluation::Contradiction;
use super::status::Severity;
use super::warning_text as text;
use crate::parameter::Unit;
use crate::se3::Pose;

/// A defect of a problem or a result, with the numbers that it is inferred from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Warning {
    /// A gradient descent did not end at a minimum that contacts agree with.
    DescentFailed(DescentFailure),
    /// No contacts, or fewer measured rows than parameters without a prior.
    TooFewContacts {
        /// Number of residual rows and known distances.
        rows: usize,
        /// Number of parameters without a prior.
        parameters: usize,
    },
    /// A fixture without contacts.
    FixtureWithoutContacts {
        /// Name of the fixture.
        fixture: String,
    },
    /// The tool's outline does not enclose the origin of the tool's frame, for example where the
    /// origin of a drawing is a corner of the sheet.
    OriginOutsideTool {
        /// Middle `(x, y)` of the outline's bounding box in the tool's frame (m).
        middle: [f64; 2],
    },
    /// The distance of two sockets by the nominal arm contradicts the declared one by more than the
    /// threshold
    /// [`distance_contradiction`](crate::estimate::WarningThresholds::distance_contradiction).
    DistanceContradicted {
        /// Names of the fixtures, in the order in which the distance was declared.
        between: [String; 2],
        /// Declared distance (m).
        declared: f64,
        /// Distance by the nominal arm (m), from the mean tool positions of their contacts.
        measured: f64,
    },
    /// Parameters that neither data nor priors determine were fixed at zero.
    Unobservable {
        /// Names of the parameters, in the order in which they were fixed.
        names: Vec<String>,
    },
    /// Data and priors together leave the arm's geometry about as uncertain as it was.
    ArmUndetermined {
        /// Standard deviation (m) of distances between tool positions before the calibration: by
        /// priors, and plausible sizes of what has none.
        before: f64,
        /// Standard deviation (m) of these distances by contacts and priors.
        after: f64,
    },
    /// The calibrated arm is expected to be hardly better than the nominal one.
    LittleImprovement {
        /// Expected error (m) of distances between two positions of the tool.
        distance: f64,
        /// That of the nominal arm (m).
        nominal_distance: f64,
    },
    /// Contacts scatter more than the declared, assumed or estimated noise; intervals allow for it.
    NoiseExceeded {
        /// Measured over declared, assumed or estimated standard deviation (1).
        factor: f64,
        /// Whether the noise was declared.
        declared: bool,
    },
    /// Contacts scatter so much more than the declared or assumed noise that it is no noise.
    NoiseContradicted {
        /// Measured over declared or assumed standard deviation (1).
        factor: f64,
        /// Whether the noise was declared.
        declared: bool,
    },
    /// Errors of contacts close in the log are correlated; standard deviations allow for that.
    CorrelatedErrors {
        /// Design effect: number of contacts that carry the information of an independent one (1).
        design_effect: f64,
        /// Whether the result may be used.
        usable: bool,
    },
    /// The mean gap at contact with a fixture is larger than it can be for parts that touch.
    NotTouching {
        /// Name of the gap bias parameter.
        name: String,
        /// Mean gap (m), negative if parts penetrate.
        gap: f64,
    },
    /// Of so few (the number) one-sided contacts the likelihood is not normal about its maximum:
    /// errors are far beyond the standard deviations more often than these say.
    FewContacts(usize),
    /// Too few one-sided contacts are informative about which constraints are active; the least gap
    /// of each was used, whose bias exceeds the standard deviations.
    FewInformativeContacts {
        /// Share of the one-sided contacts that are informative, 0 to 1: the sum of the
        /// probabilities that they touch something, over their number.
        informative_fraction: f64,
        /// Factor by which the standard deviations were multiplied (1).
        inflation: f64,
        /// Whether the result may be used: there are some, and no place is declared exact.
        usable: bool,
    },
    /// In most contacts with a measured load no surface near the tool bears it.
    LoadNotBorne {
        /// Share of these contacts, 0 to 1.
        share: f64,
    },
    /// Searches ended in other minima, and contacts do not tell which one is right.
    CompetingMinimum {
        /// Number of other minima.
        minima: usize,
        /// Distance (m) between the tool's positions in that of least cost and in the result, root
        /// mean square over the poses of the task, or over the workspace.
        tool_distance: f64,
        /// Name of the parameter of arm or tool that differs most there.
        parameter: String,
    },
    /// Many contacts do not lie on their manifold.
    ManyRejected {
        /// Name of the fixture of these contacts; `None` if they are of all fixtures.
        fixture: Option<String>,
        /// Share of contacts, 0 to 1.
        share: f64,
        /// Whether the result may be used.
        usable: bool,
    },
    /// A joint hardly moved, so errors on both sides of it have similar effects.
    LittleJointMotion {
        /// Name of the joint.
        joint: String,
        /// Range of the joint's positions (rad, or m for a prismatic joint).
        range: f64,
    },
    /// A parameter of the arm ended at a value beyond any that a calibration corrects.
    Implausible {
        /// Name of the parameter.
        name: String,
        /// Estimate in the parameter's unit (SI).
        value: f64,
        /// That unit.
        unit: Unit,
    },
    /// Contacts come near the fixtures only with a parameter far from what is declared, and do not
    /// fit there either; there was no search from other starts.
    ContradictedDeclarations {
        /// Name of the parameter that deviates most in the coarse stage.
        name: String,
        /// Its deviation over its prior standard deviation, or over its plausible size (1).
        deviations: f64,
        /// Whether it has a prior.
        has_prior: bool,
    },
    /// Rotated by an angle, a part has the same shape, and no prior rules that rotation out.
    SymmetricPart {
        /// Name of the parameter: rotation of tool or fixture about its z axis.
        name: String,
        /// The angle (rad).
        angle: f64,
    },
    /// Contacts were measured by their distance from a projection, or the search was a gradient
    /// descent, from which no uncertainty follows.
    NoUncertainty,
    /// A parameter or a declared distance ended far from what was declared.
    FarFromPrior {
        /// Name of the parameter, or `distance.{fixture}.{fixture}`.
        name: String,
        /// Distance of the estimate from the declared value in prior standard deviations (1).
        deviations: f64,
        /// Whether the result may be used.
        usable: bool,
    },
    /// Lengths of the arm that are estimated one by one are all off by the same factor: a declared
    /// distance or its unit is wrong, or the description is of another arm.
    CommonScale {
        /// The common strain (1) that explains the estimated displacements of joint origins best.
        strain: f64,
        /// That strain in its prior standard deviations (1).
        deviations: f64,
        /// Whether the result may be used.
        usable: bool,
    },
    /// Contacts contradict that an effect which the model leaves out is zero.
    OmittedEffect {
        /// The effect.
        effect: OmittedEffect,
        /// Corrected probability that it is chance (0 to 1).
        p_value: f64,
        /// Root mean square motion (m) of the tool, in the task or workspace, if it were estimated.
        displacement: f64,
        /// Whether the result may be used: the tool stays in its 95 % region; sigmas are widened.
        usable: bool,
    },
    /// Stretches of the log are farther from what the others predict than is likely.
    PredictionContradicted {
        /// Scatter found over scatter predicted (1).
        ratio: f64,
        /// Factor by which standard deviations are larger for it (1).
        widening: f64,
        /// Whether the result may be used.
        usable: bool,
    },
    /// Contacts that were held out contradict the uncertainty that the calibration reports.
    HeldOutContradicted(Contradiction),
    /// The tool's pose was estimated, but the calibrated chain ends at the tip link.
    ToolNotInRobot {
        /// Estimated pose of the tool frame in the tip link's frame (m).
        tip_from_tool: Pose,
    },
    /// A joint deflects against its measured torque, significantly: the torque has the other sign.
    DeflectionAgainstTorque {
        /// Name of the parameter.
        name: String,
        /// Estimate over its standard deviation (1), below 0.
        deviations: f64,
    },
    /// The calibrated arm is compliant or has backlash, which other readers of its URDF ignore.
    ComplianceInRobot,
    /// Harmonics or gear ratios of the encoders were estimated; the calibrated arm lacks them.
    HarmonicsNotInRobot {
        /// Root mean square motion (m) of the tool by them, in the task or workspace.
        displacement: f64,
    },
    /// A declaration is wrong in kind: contacts agree with it but for that mistake.
    MistakenDeclaration {
        /// The mistake.
        mistake: DeclarationMistake,
        /// How well contacts agree with the declarations as they are.
        declared: Agreement,
        /// How well contacts agree with them without the mistake.
        corrected: Agreement,
    },
}

impl Warning {
    /// What the warning means for the use of the result; where it has `usable`, that decides.
    pub fn severity(&self) -> Severity {
        match self {
            Warning::DescentFailed(_)
            | Warning::TooFewContacts { .. }
            | Warning::ArmUndetermined { .. }
            | Warning::DistanceContradicted { .. }
            | Warning::Implausible { .. }
            | Warning::NoiseContradicted { .. }
            | Warning::NotTouching { .. }
            | Warning::LoadNotBorne { .. }
            | Warning::MistakenDeclaration { .. }
            | Warning::DeflectionAgainstTorque { .. }
            | Warning::ContradictedDeclarations { .. }
            | Warning::CompetingMinimum { .. } => Severity::Unusable,
            Warning::CorrelatedErrors { usable, .. }
            | Warning::ManyRejected { usable, .. }
            | Warning::FarFromPrior { usable, .. }
            | Warning::FewInformativeContacts { usable, .. }
            | Warning::CommonScale { usable, .. }
            | Warning::OmittedEffect { usable, .. }
            | Warning::PredictionContradicted { usable, .. } => match usable {
                true => Severity::Doubtful,
                false => Severity::Unusable,
            },
            Warning::FewContacts(_) | Warning::NoiseExceeded { .. } => Severity::Doubtful,
            Warning::NoUncertainty | Warning::HeldOutContradicted(_) => Severity::Doubtful,
            _ => Severity::Caution,
        }
    }

    /// Name of the variant in files, in snake case: `too_few_contacts`.
    pub fn kind(&self) -> &'static str {
        match self {
            Warning::DescentFailed(_) => DescentFailure::KIND,
            Warning::TooFewContacts { .. } => "too_few_contacts",
            Warning::FixtureWithoutContacts { .. } => "fixture_without_contacts",
            Warning::OriginOutsideTool { .. } => "origin_outside_tool",
            Warning::DistanceContradicted { .. } => "distance_contradicted",
            Warning::Unobservable { .. } => "unobservable",
            Warning::ArmUndetermined { .. } => "arm_undetermined",
            Warning::LittleImprovement { .. } => "little_improvement",
            Warning::NoiseExceeded { .. } => "noise_exceeded",
            Warning::NoiseContradicted { .. } => "noise_contradicted",
            Warning::CorrelatedErrors { .. } => "correlated_errors",
            Warning::NotTouching { .. } => "not_touching",
            Warning::FewContacts(_) => "few_contacts",
            Warning::FewInformativeContacts { .. } => "few_informative_contacts",
            Warning::LoadNotBorne { .. } => "load_not_borne",
            Warning::CompetingMinimum { .. } => "competing_minimum",
            Warning::ManyRejected { .. } => "many_rejected",
            Warning::LittleJointMotion { .. } => "little_joint_motion",
            Warning::Implausible { .. } => "implausible",
            Warning::ContradictedDeclarations { .. } => "contradicted_declarations",
            Warning::SymmetricPart { .. } => "symmetric_part",
            Warning::NoUncertainty => "no_uncertainty",
            Warning::FarFromPrior { .. } => "far_from_prior",
            Warning::CommonScale { .. } => "common_scale",
            Warning::OmittedEffect { .. } => "omitted_effect",
            Warning::PredictionContradicted { .. } => "prediction_contradicted",
            Warning::HeldOutContradicted(_) => "held_out_contradicted",
            Warning::ToolNotInRobot { .. } => "tool_not_in_robot",
            Warning::DeflectionAgainstTorque { .. } => "deflection_against_torque",
            Warning::ComplianceInRobot => "compliance_in_robot",
            Warning::HarmonicsNotInRobot { .. } => "harmonics_not_in_robot",
            Warning::MistakenDeclaration { .. } => "mistaken_declaration",
        }
    }

    /// The defect in one English sentence without a full stop, lengths in mm and angles in degrees.
    pub fn message(&self) -> String {
        let mm = |metres: &f64| 1e3 * metres;
        match self {
            Warning::DescentFailed(failure) => failure.message(),
            Warning::TooFewContacts { rows, parameters } => text::too_few_contacts_message(*rows, *parameters),
            Warning::FixtureWithoutContacts { fixture } => format!("fixture `{fixture}` has no contacts"),
            Warning::OriginOutsideTool { middle } => text::origin_message(middle.map(|x| mm(&x))),
            Warning::DistanceContradicted { between, declared, measured } => {
                text::distance_message(between, mm(declared), mm(measured))
            }
            Warning::Unobservable { names } => text::unobservable_message(names),
            Warning::ArmUndetermined { before, after } => text::arm_undetermined_message(mm(before), mm(after)),
            Warning::LittleImprovement { distance, nominal_distance } => {
                text::little_improvement_message(mm(distance), mm(nominal_distance))
            }
            Warning::NoiseExceeded { factor, declared } => text::noise_message(*factor, *declared),
            Warning::NoiseContradicted { factor, declared } => text::noise_contradicted_message(*factor, *declared),
            Warning::CorrelatedErrors { design_effect, .. } => text::design_effect_message(*design_effect),
            Warning::NotTouching { name, gap } => text::not_touching_message(name, *gap),
            Warning::FewContacts(contacts) => text::few_contacts_message(*contacts),
            Warning::FewInformativeContacts { informative_fraction, inflation, .. } => {
                text::few_informative_message(*informative_fraction, *inflation)
            }
            Warning::LoadNotBorne { share } => text::load_not_borne_message(*share),
            Warning::CompetingMinimum { minima, tool_distance, parameter } => {
                text::competing_minimum_message(*minima, *tool_distance, parameter)
            }
            Warning::ManyRejected { fixture, share, .. } => text::many_rejected_message(fixture.as_deref(), *share),
            Warning::LittleJointMotion { joint, range } => text::little_motion_message(joint, *range),
            Warning::Implausible { name, value, unit } => text::implausible_message(name, *value, *unit),
            Warning::ContradictedDeclarations { name, deviations, has_prior } => {
                text::contradiction_message(name, *deviations, *has_prior)
            }
            Warning::SymmetricPart { name, angle } => text::symmetric_part_message(name, *angle),
            Warning::NoUncertainty => text::no_uncertainty_message(),
            Warning::FarFromPrior { name, deviations, .. } => text::far_from_prior_message(name, *deviations),
            Warning::CommonScale { strain, deviations, .. } => text::scale_message(*strain, *deviations),
            Warning::OmittedEffect { effect, p_value, displacement, usable } => {
                text::omitted_effect_message(effect, (*p_value, *displacement), *usable)
            }
            Warning::PredictionContradicted { ratio, widening, .. } => text::prediction_message(*ratio, *widening),
            Warning::HeldOutContradicted(contradiction) => text::held_out_message(contradiction),
            Warning::ToolNotInRobot { .. } => text::TOOL_MESSAGE.to_owned(),
            Warning::DeflectionAgainstTorque { name, deviations } => text::against_torque_message(name, *deviations),
            Warning::ComplianceInRobot => text::COMPLIANCE_MESSAGE.to_owned(),
            Warning::HarmonicsNotInRobot { displacement } => text::harmonics_message(*displacement),
            Warning::MistakenDeclaration { mistake, declared, corrected } => mistake.message(declared, corrected),
        }
    }

    /// A remedy in one English sentence without a full stop.
    pub fn advice(&self) -> &'static str {
        match self {
            Warning::DescentFailed(failure) => failure.advice(),
            Warning::TooFewContacts { .. } => "record more contacts, or estimate fewer parameters",
            Warning::FixtureWithoutContacts { .. } => "check the force threshold, and which fixture the logs belong to",
            Warning::OriginOutsideTool { .. } => text::ORIGIN_ADVICE,
            Warning::DistanceContradicted { .. } => text::DISTANCE_ADVICE,
            Warning::Unobservable { .. } => "touch more fixtures or from other elbow positions, or give a prior",
            Warning::ArmUndetermined { .. } => text::UNDETERMINED_ADVICE,
            Warning::LittleImprovement { .. } => text::LITTLE_IMPROVEMENT_ADVICE,
            Warning::NoiseExceeded { .. } => text::NOISE_EXCEEDED_ADVICE,
            Warning::NoiseContradicted { .. } => text::NOISE_CONTRADICTED_ADVICE,
            Warning::CorrelatedErrors { .. } => text::CORRELATED_ERRORS_ADVICE,
            Warning::NotTouching { .. } => text::NOT_TOUCHING_ADVICE,
            Warning::FewContacts(_) => text::FEW_CONTACTS_ADVICE,
            Warning::FewInformativeContacts { usable: false, .. } => text::NO_LIKELIHOOD_ADVICE,
            Warning::FewInformativeContacts { .. } => "record longer with the tool inside the hole, not at its rim",
            Warning::LoadNotBorne { .. } => text::LOAD_NOT_BORNE_ADVICE,
            Warning::CompetingMinimum { .. } => text::COMPETING_MINIMUM_ADVICE,
            Warning::ManyRejected { .. } => text::MANY_REJECTED_ADVICE,
            Warning::LittleJointMotion { .. } => "move it more, to separate its errors from its neighbours'",
            Warning::Implausible { .. } | Warning::ContradictedDeclarations { .. } => text::IMPLAUSIBLE_ADVICE,
            Warning::SymmetricPart { .. } => "if the choice matters, declare a standard deviation of this rotation",
            Warning::NoUncertainty => text::NO_UNCERTAINTY_ADVICE,
            Warning::FarFromPrior { name, .. } => text::far_from_prior_advice(name),
            Warning::CommonScale { .. } => text::COMMON_SCALE_ADVICE,
            Warning::OmittedEffect { effect, .. } => effect.remedy(),
            Warning::PredictionContradicted { .. } => text::PREDICTION_ADVICE,
            Warning::HeldOutContradicted(contradiction) => contradiction.advice(),
            Warning::ToolNotInRobot { .. } => text::TOOL_ADVICE,
            Warning::DeflectionAgainstTorque { .. } => text::AGAINST_TORQUE_ADVICE,
            Warning::ComplianceInRobot => text::COMPLIANCE_ADVICE,
            Warning::HarmonicsNotInRobot { .. } => text::HARMONICS_ADVICE,
            Warning::MistakenDeclaration { mistake, .. } => mistake.remedy(),
        }
    }
}
