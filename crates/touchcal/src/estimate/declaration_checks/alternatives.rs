//! Mistakes of kind that a problem may have, and the problem without them.

use std::collections::BTreeSet;

use nalgebra::{UnitQuaternion, Vector3};

use crate::contact::ContactLog;
use crate::estimate::problem::{Distance, Problem};
use crate::estimate::result::{DeclarationMistake, DeclaredLength};
use crate::manifold::Shape;
use crate::robot::{JointKind, Robot};
use crate::se3::Pose;

/// True over declared lengths where metres, millimetres or inches were declared for each other.
const UNIT_FACTORS: [f64; 4] = [1e3, 1e-3, 25.4, 1.0 / 25.4];
/// Shortest distances (m) of a tool from the tip link, of fixtures from each other, and of a
/// fixture from base: the arm stands there.
const MIN_TOOL: f64 = 1e-3;
const MIN_DISTANCE: f64 = 1e-3;
const MIN_PLACE: f64 = 0.05;
/// Most depth of a hole over the length of its peg (1).
const DEPTH_PER_LENGTH: f64 = 2.0;
/// Least angle (rad) of a rotation whose unit may be wrong.
const MIN_ANGLE: f64 = 0.05;
/// Share of contacts with a joint beyond a turn from which positions may be degrees.
const BEYOND_A_TURN: f64 = 0.05;

/// Most fixtures with contacts of which two may be exchanged: each pair takes a coarse fit.
const MAX_EXCHANGED: usize = 16;

/// The mistakes without which the declarations of `problem` would be possible: lengths within the
/// arm's reach, joints within a turn. Other arms than that of the problem are not among them.
pub(super) fn possible_mistakes(problem: &Problem) -> Vec<DeclarationMistake> {
    let mut mistakes = length_units(problem);
    mistakes.extend(depth_units(problem));
    mistakes.extend(tool_mistakes(problem));
    mistakes.extend(rotation_units(problem));
    mistakes.extend(angle_units(problem));
    mistakes.extend(joint_mistakes(&problem.robot));
    mistakes.extend(fixture_exchanges(problem));
    mistakes
}

/// Sum of the lengths (m) of the arm.
fn reach(robot: &Robot) -> f64 {
    robot.joints().iter().map(|joint| joint.parent_from_joint.translation.vector.norm()).sum()
}

fn length_units(problem: &Problem) -> Vec<DeclarationMistake> {
    let reach = reach(&problem.robot);
    let tool = problem.tool.tip_from_tool.translation.vector.norm();
    let places: Vec<(&str, f64)> = problem
        .fixtures
        .iter()
        .filter_map(|fixture| Some((fixture.name.as_str(), fixture.base_from_fixture?.translation.vector.norm())))
        .collect();
    let is_place = |length: f64| (MIN_PLACE..2.0 * reach).contains(&length);
    let is_distance = |length: f64| (MIN_DISTANCE..2.0 * reach).contains(&length);
    let mut mistakes = Vec::new();
    for factor in UNIT_FACTORS {
        let mut add = |of: DeclaredLength| mistakes.push(DeclarationMistake::LengthUnit { of, factor });
        let is_tool = tool > 0.0 && (MIN_TOOL..reach).contains(&(factor * tool));
        let are_places = !places.is_empty() && places.iter().all(|(_, length)| is_place(factor * length));
        let are_distances = !problem.distances.is_empty()
            && problem.distances.iter().all(|distance| is_distance(factor * distance.distance));
        if is_tool {
            add(DeclaredLength::Tool);
        }
        // One alone where it is impossible as declared: the arm's base is there, or it is out of
        // reach.
        let alone = places.iter().filter(|(_, length)| !is_place(*length) && is_place(factor * length));
        alone.for_each(|(name, _)| add(DeclaredLength::Fixture((*name).to_owned())));
        if are_places && places.len() > 1 {
            add(DeclaredLength::Fixtures);
        }
        let possible = problem.distances.iter().filter(|distance| is_distance(factor * distance.distance));
        possible.for_each(|distance| add(DeclaredLength::Distance(names(problem, distance))));
        if are_distances && problem.distances.len() > 1 {
            add(DeclaredLength::Distances);
        }
        let kinds = [is_tool, are_places, are_distances].into_iter().filter(|is| *is).count();
        if kinds > 1 {
            add(DeclaredLength::All);
        }
    }
    mistakes
}

/// Depths of holes in another unit. A hole that is too deep fits anything, so the unit is in doubt
/// only where the hole is deeper than declared, and no deeper than its peg reaches.
fn depth_units(problem: &Problem) -> Vec<DeclarationMistake> {
    let mut mistakes = Vec::new();
    for fixture in &problem.fixtures {
        let sketch = fixture.manifold.sketch();
        let (Shape::Prism { to: length, .. }, Shape::Prism { from, to, .. }) = (&sketch.tool, &sketch.fixture) else {
            continue;
        };
        let is_possible = |factor: f64| factor > 1.0 && factor * (to - from) < DEPTH_PER_LENGTH * length;
        for factor in UNIT_FACTORS.into_iter().filter(|factor| is_possible(*factor)) {
            if fixture.manifold.with_scaled_depth(factor).is_some() {
                let of = DeclaredLength::Depth(fixture.name.clone());
                mistakes.push(DeclarationMistake::LengthUnit { of, factor });
            }
        }
    }
    mistakes
}

fn names(problem: &Problem, distance: &Distance) -> [String; 2] {
    [distance.between.0, distance.between.1].map(|f| problem.fixtures[f].name.clone())
}

fn tool_mistakes(problem: &Problem) -> Vec<DeclarationMistake> {
    let tool = problem.tool.tip_from_tool;
    let is_seen = |k: usize| problem.fixtures.iter().any(|fixture| fixture.manifold.tool_directions().contains(&k));
    let mut mistakes = Vec::new();
    if tool.translation.vector.norm() > 0.0 {
        mistakes.push(DeclarationMistake::ToolOpposite);
    }
    if (3..6).any(is_seen) {
        let turns = |axis| (1..4).map(move |quarters| DeclarationMistake::ToolTurned { axis, quarters });
        mistakes.extend((0..3).flat_map(turns));
    }
    if tool.rotation.angle() > 0.0 {
        mistakes.push(DeclarationMistake::ToolInverted);
    }
    if problem.fixtures.iter().any(|fixture| fixture.base_from_fixture.is_some()) {
        mistakes.push(DeclarationMistake::FixturesInverted);
    }
    mistakes
}

/// Rotations of tool and fixtures whose angles would be possible as radians.
fn rotation_units(problem: &Problem) -> Vec<DeclarationMistake> {
    let of_tool =
        is_possible_in_radians(&problem.tool.tip_from_tool).then_some(DeclarationMistake::ToolRotationInRadians);
    let placed = problem
        .fixtures
        .iter()
        .filter(|fixture| fixture.base_from_fixture.as_ref().is_some_and(is_possible_in_radians));
    let of_fixtures =
        placed.map(|fixture| DeclarationMistake::FixtureRotationInRadians { fixture: fixture.name.clone() });
    of_tool.into_iter().chain(of_fixtures).collect()
}

/// Whether the roll, pitch and yaw of a pose, taken as degrees, may be radians: of half a turn at
/// most, and not all zero.
fn is_possible_in_radians(pose: &Pose) -> bool {
    let largest = roll_pitch_yaw_in_radians(pose).into_iter().fold(0.0, |most: f64, angle| most.max(angle.abs()));
    (MIN_ANGLE..=1.01 * std::f64::consts::PI).contains(&largest)
}

/// The angles that were meant (rad) where they were given in radians and taken as degrees.
fn roll_pitch_yaw_in_radians(pose: &Pose) -> [f64; 3] {
    let (roll, pitch, yaw) = pose.rotation.euler_angles();
    [roll, pitch, yaw].map(f64::to_degrees)
}

/// The pose with the rotation that was meant.
fn turned_in_radians(pose: &Pose) -> Pose {
    let [roll, pitch, yaw] = roll_pitch_yaw_in_radians(pose);
    Pose::from_parts(pose.translation, UnitQuaternion::from_euler_angles(roll, pitch, yaw))
}

/// A wrong unit of the joint positions. Positions that are too small fit anything, and so the unit
/// is in doubt only where positions are impossible as they are, or are so in no other unit.
fn angle_units(problem: &Problem) -> Vec<DeclarationMistake> {
    let contacts = &problem.contacts;
    let farthest = |i: usize| {
        let turning = problem.robot.moving().zip(contacts.q(i)).filter(|(joint, _)| joint.kind != JointKind::Prismatic);
        turning.map(|(_, q)| q.abs()).fold(0.0, f64::max)
    };
    let beyond = |limit: f64| (0..contacts.len()).filter(|&i| farthest(i) > limit).count() as f64;
    let most = BEYOND_A_TURN * contacts.len() as f64;
    let mut mistakes = Vec::new();
    if beyond(std::f64::consts::TAU) > most {
        mistakes.push(DeclarationMistake::DegreesAsRadians);
    } else if beyond(std::f64::consts::TAU.to_radians()) <= most {
        mistakes.push(DeclarationMistake::RadiansAsDegrees);
    }
    mistakes
}

fn joint_mistakes(robot: &Robot) -> Vec<DeclarationMistake> {
    let names: Vec<String> = robot.moving().map(|joint| joint.name.clone()).collect();
    let mut mistakes = Vec::new();
    for (i, first) in names.iter().enumerate() {
        mistakes.push(DeclarationMistake::JointSign { joint: first.clone() });
        let pair = |second: &String| DeclarationMistake::JointsExchanged { joints: [first.clone(), second.clone()] };
        mistakes.extend(names[i + 1..].iter().map(pair));
    }
    if names.len() > 2 {
        mistakes.push(DeclarationMistake::JointsReversed);
    }
    if names.len() > 1 {
        mistakes.push(DeclarationMistake::AllJointSigns);
    }
    mistakes
}

/// Pairs of fixtures of which each may have the other's contacts.
fn fixture_exchanges(problem: &Problem) -> Vec<DeclarationMistake> {
    let contacts = &problem.contacts;
    let touched: BTreeSet<usize> = (0..contacts.len()).map(|i| contacts.fixture(i)).collect();
    if touched.len() > MAX_EXCHANGED {
        return Vec::new();
    }
    let name = |f: usize| problem.fixtures[f].name.clone();
    let with = |first: usize| {
        let exchanged = move |second: usize| DeclarationMistake::FixturesExchanged {
            fixtures: [first, second].map(name),
            or: Vec::new(),
        };
        touched.range(first + 1..).copied().map(exchanged)
    };
    touched.iter().copied().flat_map(with).collect()
}

/// The problem as it would be without `mistake`; arms are as they were.
pub(super) fn without_mistake(problem: &Problem, mistake: &DeclarationMistake) -> Problem {
    let mut corrected = problem.clone();
    let tool = &mut corrected.tool.tip_from_tool;
    match mistake {
        DeclarationMistake::LengthUnit { of, factor } => scale_lengths(&mut corrected, of, *factor),
        DeclarationMistake::ToolOpposite => tool.translation.vector.neg_mut(),
        DeclarationMistake::ToolTurned { axis, quarters } => {
            let axis = [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()][*axis];
            let angle = f64::from(*quarters) * std::f64::consts::FRAC_PI_2;
            tool.rotation *= UnitQuaternion::from_axis_angle(&axis, angle);
        }
        DeclarationMistake::ToolRotationInRadians => *tool = turned_in_radians(tool),
        DeclarationMistake::FixtureRotationInRadians { fixture } => {
            places(&mut corrected)
                .filter(|(name, _)| name == fixture)
                .for_each(|(_, place)| *place = turned_in_radians(place));
        }
        DeclarationMistake::ToolInverted => *tool = tool.inverse(),
        DeclarationMistake::FixturesExchanged { fixtures: [a, b], .. } => {
            let index = |name: &String| problem.fixtures.iter().position(|fixture| fixture.name == *name);
            if let (Some(a), Some(b)) = (index(a), index(b)) {
                corrected.contacts = problem.contacts.with_fixtures(|f| match f {
                    _ if f == a => b,
                    _ if f == b => a,
                    _ => f,
                });
            }
        }
        DeclarationMistake::FixturesInverted => places(&mut corrected).for_each(|(_, place)| *place = place.inverse()),
        _ => corrected.contacts = with_positions(problem, mistake),
    }
    corrected
}

/// Declared places of fixtures, with the fixtures' names.
fn places(problem: &mut Problem) -> impl Iterator<Item = (&str, &mut Pose)> {
    problem.fixtures.iter_mut().filter_map(|fixture| Some((fixture.name.as_str(), fixture.base_from_fixture.as_mut()?)))
}

fn scale_lengths(problem: &mut Problem, of: &DeclaredLength, factor: f64) {
    let is_all = *of == DeclaredLength::All;
    if is_all || *of == DeclaredLength::Tool {
        problem.tool.tip_from_tool.translation.vector *= factor;
    }
    let is_meant = |name: &str| match of {
        DeclaredLength::Fixture(meant) => name == meant,
        _ => is_all || *of == DeclaredLength::Fixtures,
    };
    places(problem).filter(|(name, _)| is_meant(name)).for_each(|(_, place)| place.translation.vector *= factor);
    if let DeclaredLength::Depth(meant) = of {
        for fixture in problem.fixtures.iter_mut().filter(|fixture| fixture.name == *meant) {
            fixture.manifold = fixture.manifold.with_scaled_depth(factor).unwrap_or_else(|| fixture.manifold.clone());
        }
    }
    let between: Vec<[String; 2]> = problem.distances.iter().map(|distance| names(problem, distance)).collect();
    for (distance, between) in problem.distances.iter_mut().zip(between) {
        let is_meant = match of {
            DeclaredLength::Distance(meant) => between == *meant,
            _ => is_all || *of == DeclaredLength::Distances,
        };
        distance.distance *= if is_meant { factor } else { 1.0 };
    }
}

fn with_positions(problem: &Problem, mistake: &DeclarationMistake) -> ContactLog {
    let turns: Vec<bool> = problem.robot.moving().map(|joint| joint.kind != JointKind::Prismatic).collect();
    let index = |name: &str| problem.robot.moving().position(|joint| joint.name == name).unwrap_or(0);
    let converted = |q: &mut [f64], convert: fn(f64) -> f64| {
        q.iter_mut().zip(&turns).filter(|(_, turns)| **turns).for_each(|(q, _)| *q = convert(*q));
    };
    problem.contacts.with_positions(|_, q| match mistake {
        DeclarationMistake::DegreesAsRadians => converted(q, f64::to_radians),
        DeclarationMistake::RadiansAsDegrees => converted(q, f64::to_degrees),
        DeclarationMistake::JointsExchanged { joints: [a, b] } => q.swap(index(a), index(b)),
        DeclarationMistake::JointsReversed => q.reverse(),
        DeclarationMistake::JointSign { joint } => q[index(joint)] *= -1.0,
        DeclarationMistake::AllJointSigns => q.iter_mut().for_each(|q| *q = -*q),
        _ => {}
    })
}
