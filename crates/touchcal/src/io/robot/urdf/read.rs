//! From URDF text to a chain.

use std::collections::{HashMap, HashSet};

use nalgebra::{Unit, Vector3};
use roxmltree::Node;

use super::document::{LARGEST, attribute, child, children, numbers, parse, place, robot_element};
use super::numbers::pose;
use super::weight::{BACKLASH, COMPLIANCE, backlash, compliance, has_measured_torque, inertia};
use crate::io::base::error::{IoError, Place, quoted};
use crate::io::base::suggest::{did_you_mean, list};
use crate::robot::{Joint, JointKind, Limits, Robot};
use crate::se3::Pose;

/// An axis shorter than this has no direction.
const SHORTEST_AXIS: f64 = 1e-9;
/// Longest chain (joints): far beyond any arm.
const LONGEST_CHAIN: usize = 1000;

/// The ends of the chain that is read from a URDF.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ends<'a> {
    /// Name of the link where the chain begins; `None`: the only link that is no joint's child, of
    /// which two are an error.
    pub base: Option<&'a str>,
    /// Name of the link where the chain ends, which must be below the base; `None`: the only link
    /// below the base that carries no other, of which two are an error.
    pub tip: Option<&'a str>,
}

/// The links and joints of a URDF, joined up.
struct Tree<'a, 't> {
    file: &'a str,
    robot: Node<'a, 't>,
    /// Names of links in the order of the file.
    links: Vec<&'a str>,
    /// By child link: the joint that carries it, and its parent link.
    above: HashMap<&'a str, (Node<'a, 't>, &'a str)>,
    /// By link: the links that joints from there carry.
    below: HashMap<&'a str, Vec<&'a str>>,
}

pub(super) fn robot(text: &str, file: &str, ends: Ends<'_>) -> Result<Robot, IoError> {
    let document = parse(text, file)?;
    let element = robot_element(&document, file)?;
    let tree = Tree::of(element, file)?;
    let base = tree.base(ends.base)?;
    let tip = tree.tip(base, ends.tip)?;
    let nodes = tree.between(base, tip)?;
    let joints = nodes.iter().map(|node| tree.joint(node)).collect::<Result<Vec<_>, _>>()?;
    let elements = nodes.iter().flat_map(|node| [COMPLIANCE, BACKLASH].map(|element| (node, element)));
    let measured = elements.map(|(node, element)| has_measured_torque(node, element, file));
    let measured = measured.collect::<Result<Vec<_>, _>>()?;
    let name = element.attribute("name").unwrap_or("robot");
    let robot =
        Robot::new(name, base, joints).map_err(|error| IoError::syntax(Place::file(file), error.to_string()))?;
    Ok(if measured.contains(&true) { robot.with_measured_torques() } else { robot })
}

impl<'a, 't> Tree<'a, 't> {
    fn of(robot: Node<'a, 't>, file: &'a str) -> Result<Self, IoError> {
        let mut tree = Tree { file, robot, links: Vec::new(), above: HashMap::new(), below: HashMap::new() };
        for link in children(&robot, "link") {
            let name = attribute(&link, "name", file)?;
            if tree.below.insert(name, Vec::new()).is_some() {
                return Err(IoError::unexpected(place(&link, file), "distinct link names", format!("`{name}` twice")));
            }
            tree.links.push(name);
        }
        let mut names = HashSet::new();
        for joint in children(&robot, "joint") {
            let name = attribute(&joint, "name", file)?;
            if !names.insert(name) {
                return Err(IoError::unexpected(
                    place(&joint, file),
                    "distinct joint names",
                    format!("`{name}` twice"),
                ));
            }
            tree.join(joint, name)?;
        }
        Ok(tree)
    }

    fn join(&mut self, joint: Node<'a, 't>, name: &str) -> Result<(), IoError> {
        let parent = self.end(&joint, name, "parent")?;
        let below = self.end(&joint, name, "child")?;
        self.below.entry(parent).or_default().push(below);
        if let Some((other, _)) = self.above.insert(below, (joint, parent)) {
            let found = format!("`{below}` below both `{}` and `{name}`", other.attribute("name").unwrap_or_default());
            return Err(IoError::unexpected(place(&joint, self.file), "each link to be the child of one joint", found));
        }
        Ok(())
    }

    /// The link that a joint names as its `parent` or `child`.
    fn end(&self, joint: &Node<'a, 't>, name: &str, which: &str) -> Result<&'a str, IoError> {
        let Some(node) = child(joint, which) else {
            let place = place(joint, self.file).field(format!("joint `{name}`"));
            return Err(IoError::unexpected(place, format!("a <{which} link=\"…\"/>"), "none"));
        };
        let link = attribute(&node, "link", self.file)?;
        self.known(link, || place(&node, self.file).field(format!("joint `{name}`")))
    }

    /// The name as the file spells it, if there is such a link.
    fn known(&self, link: &str, at: impl FnOnce() -> Place) -> Result<&'a str, IoError> {
        match self.below.get_key_value(link) {
            Some((known, _)) => Ok(known),
            None => {
                let found = format!("`{link}`{}", did_you_mean(link, self.links.iter().copied()));
                Err(IoError::unexpected(at(), format!("a link ({})", list(self.links.iter().copied())), found))
            }
        }
    }

    fn base(&self, wanted: Option<&str>) -> Result<&'a str, IoError> {
        if let Some(wanted) = wanted {
            return self.known(wanted, || Place::file(self.file).field("base link"));
        }
        let roots: Vec<&str> = self.links.iter().copied().filter(|link| !self.above.contains_key(link)).collect();
        match (roots.as_slice(), self.links.is_empty()) {
            ([root], _) => Ok(root),
            (_, true) => Err(IoError::unexpected(place(&self.robot, self.file), "links and joints", "no link")),
            ([], _) => {
                let found = "a closed loop: every link is some joint's child";
                Err(IoError::unexpected(place(&self.robot, self.file), "one root link", found))
            }
            (many, _) => {
                let found = format!(
                    "{} that are not connected: {}; choose one as `base`",
                    many.len(),
                    list(many.iter().copied())
                );
                Err(IoError::unexpected(place(&self.robot, self.file), "one root link", found))
            }
        }
    }

    fn tip(&self, base: &str, wanted: Option<&str>) -> Result<&'a str, IoError> {
        if let Some(wanted) = wanted {
            return self.known(wanted, || Place::file(self.file).field("tip link"));
        }
        match self.leaves_below(base).as_slice() {
            [leaf] => Ok(leaf),
            [] => {
                let expected = format!("a chain of joints below base link `{base}`");
                Err(IoError::unexpected(place(&self.robot, self.file), expected, "none"))
            }
            many => {
                // A tool often sits where the fingers of a gripper branch off.
                let advice = match self.forks_below(base).as_slice() {
                    [] => "; choose one as `tip`".to_owned(),
                    forks => format!(", which branch at {}; choose one of these as `tip`", list(forks.iter().copied())),
                };
                let found = format!("{}: {}{advice}", many.len(), list(many.iter().copied()));
                Err(IoError::unexpected(place(&self.robot, self.file), format!("one leaf link below `{base}`"), found))
            }
        }
    }

    /// The links below `base` that carry nothing more.
    fn leaves_below(&self, base: &str) -> Vec<&'a str> {
        self.links_below(base).into_iter().filter(|link| self.carried(link).is_empty()).collect()
    }

    /// The links below `base` that carry more than one.
    fn forks_below(&self, base: &str) -> Vec<&'a str> {
        self.links_below(base).into_iter().filter(|link| self.carried(link).len() > 1).collect()
    }

    fn carried(&self, link: &str) -> &[&'a str] {
        self.below.get(link).map_or(&[], Vec::as_slice)
    }

    /// The links below `base`, in the order of the joints.
    fn links_below(&self, base: &str) -> Vec<&'a str> {
        let mut links = Vec::new();
        // A loop through the base would come back to it, and only to it: every link has one parent.
        let mut waiting: Vec<&str> = self.carried(base).iter().rev().copied().collect();
        while let Some(link) = waiting.pop() {
            if link != base {
                links.push(link);
                waiting.extend(self.carried(link).iter().rev());
            }
        }
        links
    }

    /// The joints from base to tip.
    fn between(&self, base: &str, tip: &'a str) -> Result<Vec<Node<'a, 't>>, IoError> {
        let mut joints = Vec::new();
        let mut at = tip;
        while let Some((joint, parent)) = self.above.get(at).filter(|_| joints.len() <= LONGEST_CHAIN) {
            joints.push(*joint);
            if *parent == base {
                joints.reverse();
                return Ok(joints);
            }
            at = parent;
        }
        if joints.len() > LONGEST_CHAIN {
            let found = "a longer chain or a closed loop";
            return Err(IoError::unexpected(Place::file(self.file), format!("at most {LONGEST_CHAIN} joints"), found));
        }
        let expected = format!("tip link `{tip}` to hang below base link `{base}`");
        let found = if base == tip { "the same link" } else { "no chain of joints between them" };
        Err(IoError::unexpected(Place::file(self.file), expected, found))
    }

    /// A joint of the chain with the link it carries.
    fn joint(&self, node: &Node<'a, 't>) -> Result<Joint, IoError> {
        let file = self.file;
        let name = attribute(node, "name", file)?;
        let at = |node: &Node<'_, '_>| place(node, file).field(format!("joint `{name}`"));
        let kind = kind(node, file, &at)?;
        if let (Some(mimic), true) = (child(node, "mimic"), kind != JointKind::Fixed) {
            let found = "a <mimic> joint";
            return Err(IoError::unexpected(at(&mimic), "joints of the chain to move on their own", found));
        }
        let child_link = match child(node, "child") {
            Some(below) => attribute(&below, "link", file)?,
            None => "",
        };
        let link = children(&self.robot, "link").find(|link| link.attribute("name") == Some(child_link));
        Ok(Joint {
            name: name.to_owned(),
            child_link: child_link.to_owned(),
            kind,
            parent_from_joint: origin(node, file)?,
            axis: axis(node, kind, &at)?,
            limits: limits(node, kind, &at)?,
            compliance: compliance(node, kind, file)?,
            backlash: backlash(node, kind, file)?,
            inertia: link.map(|link| inertia(&link, file)).transpose()?.flatten(),
        })
    }
}

fn kind(node: &Node<'_, '_>, file: &str, at: &dyn Fn(&Node<'_, '_>) -> Place) -> Result<JointKind, IoError> {
    match attribute(node, "type", file)? {
        "fixed" => Ok(JointKind::Fixed),
        "revolute" => Ok(JointKind::Revolute),
        "continuous" => Ok(JointKind::Continuous),
        "prismatic" => Ok(JointKind::Prismatic),
        other => {
            let expected = "type `revolute`, `continuous`, `prismatic` or `fixed` in the chain";
            Err(IoError::unexpected(at(node), expected, quoted(other)))
        }
    }
}

/// The joint's origin; what is absent is zero.
pub(super) fn origin(joint: &Node<'_, '_>, file: &str) -> Result<Pose, IoError> {
    let Some(origin) = child(joint, "origin") else { return Ok(Pose::identity()) };
    let at = || place(&origin, file).field(format!("joint `{}`, origin", joint.attribute("name").unwrap_or_default()));
    let xyz = numbers::<3>(&origin, ("xyz", LARGEST), at)?.unwrap_or_default();
    let rpy = numbers::<3>(&origin, ("rpy", LARGEST), at)?.unwrap_or_default();
    Ok(pose(xyz, rpy))
}

fn axis(
    node: &Node<'_, '_>,
    kind: JointKind,
    at: &dyn Fn(&Node<'_, '_>) -> Place,
) -> Result<Unit<Vector3<f64>>, IoError> {
    let Some(axis) = child(node, "axis").filter(|_| kind != JointKind::Fixed) else { return Ok(Vector3::x_axis()) };
    let xyz = numbers::<3>(&axis, ("xyz", LARGEST), || at(&axis))?.unwrap_or([1.0, 0.0, 0.0]);
    Unit::try_new(Vector3::from(xyz), SHORTEST_AXIS).filter(|axis| axis.iter().all(|v| v.is_finite())).ok_or_else(
        || {
            IoError::unexpected(
                at(&axis),
                "an axis with a direction",
                quoted(axis.attribute("xyz").unwrap_or_default()),
            )
        },
    )
}

fn limits(
    node: &Node<'_, '_>,
    kind: JointKind,
    at: &dyn Fn(&Node<'_, '_>) -> Place,
) -> Result<Option<Limits>, IoError> {
    if matches!(kind, JointKind::Fixed | JointKind::Continuous) {
        return Ok(None);
    }
    let Some(limit) = child(node, "limit") else { return Ok(None) };
    let lower = numbers::<1>(&limit, ("lower", f64::MAX), || at(&limit))?;
    let upper = numbers::<1>(&limit, ("upper", f64::MAX), || at(&limit))?;
    if lower.is_none() && upper.is_none() {
        return Ok(None);
    }
    // URDF takes an absent one as zero.
    let ([lower], [upper]) = (lower.unwrap_or_default(), upper.unwrap_or_default());
    if lower > upper {
        return Err(IoError::unexpected(at(&limit), "lower limit ≤ upper limit", format!("{lower} and {upper}")));
    }
    // Files give joints without limits very large ones.
    Ok(Some(Limits { lower: lower.clamp(-LARGEST, LARGEST), upper: upper.clamp(-LARGEST, LARGEST) }))
}
