//! Groups of contacts that are left out together.

use nalgebra::Vector3;

use crate::contact::ContactLog;
use crate::estimate::model::CalibrationModel;
use crate::estimate::problem::Problem;

/// Least number of groups, and of fixtures or placements that are groups.
const LEAST: usize = 3;
/// Most regions, and least number of contacts of each.
const MOST_REGIONS: usize = 8;
const CONTACTS_PER_REGION: usize = 5;
/// Least number of regions, a power of two as all numbers of regions are.
const LEAST_REGIONS: usize = 4;

/// What the groups of contacts are that are left out, each once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GroupKind {
    /// Placements ([`Fixture::placement`](crate::estimate::Fixture::placement)), where contacts are
    /// of three or more.
    Placements,
    /// Fixtures, where contacts are of three or more.
    Fixtures,
    /// Regions of the workspace with as many contacts each: positions of the tool by the nominal
    /// arm are divided at their median along the axis of base along which they spread most, and
    /// both halves again.
    Regions,
}

impl GroupKind {
    /// Name in files: `placements`, `fixtures`, `regions`.
    pub fn name(self) -> &'static str {
        match self {
            GroupKind::Placements => "placements",
            GroupKind::Fixtures => "fixtures",
            GroupKind::Regions => "regions",
        }
    }
}

/// The groups of a problem's contacts.
pub(super) struct Groups {
    pub kind: GroupKind,
    /// Name of each group, of a region its number from 1.
    pub names: Vec<String>,
    /// The group of each contact.
    pub of_contact: Vec<usize>,
}

impl Groups {
    /// `None` if contacts are too few for four regions.
    pub fn new(problem: &Problem) -> Option<Groups> {
        let contacts = &problem.contacts;
        let fixtures = (0..contacts.len()).map(|i| &problem.fixtures[contacts.fixture(i)]);
        let placements: Vec<&str> = fixtures.clone().map(|fixture| fixture.placement.as_str()).collect();
        let fixtures: Vec<&str> = fixtures.map(|fixture| fixture.name.as_str()).collect();
        let of_names = by_name(GroupKind::Placements, &placements).or_else(|| by_name(GroupKind::Fixtures, &fixtures));
        of_names.or_else(|| regions(problem))
    }

    /// The contacts of `log`, the problem's, that are of group `g`, or all others, and `keep`.
    pub fn contacts(&self, log: &ContactLog, keep: impl Fn(usize, usize) -> bool) -> ContactLog {
        log.filtered(|i| keep(i, self.of_contact[i]))
    }
}

/// Least number of contacts that can be divided into regions.
pub(super) const LEAST_CONTACTS: usize = LEAST_REGIONS * CONTACTS_PER_REGION;

/// A group for each name, in the order of their first contact; `None` if there are too few.
fn by_name(kind: GroupKind, names: &[&str]) -> Option<Groups> {
    let mut groups: Vec<String> = Vec::new();
    let of_contact = names.iter().map(|name| {
        groups.iter().position(|known| known == name).unwrap_or_else(|| {
            groups.push((*name).to_owned());
            groups.len() - 1
        })
    });
    let of_contact = of_contact.collect();
    (groups.len() >= LEAST).then_some(Groups { kind, names: groups, of_contact })
}

fn regions(problem: &Problem) -> Option<Groups> {
    let (model, contacts) = (CalibrationModel::new(problem), &problem.contacts);
    if contacts.len() < LEAST_CONTACTS {
        return None;
    }
    let position = |i| {
        model.kinematics.pose_under(contacts.q(i), contacts.load_on_joints(i, &contacts.load(i))).translation.vector
    };
    let positions: Vec<Vector3<f64>> = (0..contacts.len()).map(position).collect();
    let mut parts = vec![(0..contacts.len()).collect::<Vec<usize>>()];
    while parts.len() < MOST_REGIONS && contacts.len() >= 2 * parts.len() * CONTACTS_PER_REGION {
        parts = parts.into_iter().flat_map(|part| halves(part, &positions)).collect();
    }
    let mut of_contact = vec![0; contacts.len()];
    for (g, part) in parts.iter().enumerate() {
        part.iter().for_each(|&i| of_contact[i] = g);
    }
    let names = (1..=parts.len()).map(|number| number.to_string()).collect();
    Some(Groups { kind: GroupKind::Regions, names, of_contact })
}

/// Both halves of a part, on either side of the median along the axis on which positions spread
/// most.
fn halves(mut part: Vec<usize>, positions: &[Vector3<f64>]) -> [Vec<usize>; 2] {
    let mean = part.iter().map(|&i| positions[i]).sum::<Vector3<f64>>() / part.len().max(1) as f64;
    let spread: Vector3<f64> = part.iter().map(|&i| (positions[i] - mean).component_mul(&(positions[i] - mean))).sum();
    let axis = spread.imax();
    part.sort_by(|&a, &b| positions[a][axis].total_cmp(&positions[b][axis]).then(a.cmp(&b)));
    let rest = part.split_off(part.len() / 2);
    [part, rest]
}
