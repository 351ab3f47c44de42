//! Which column of a log holds what.

use super::kuka;
use super::lines::Separator;
use super::{AngleUnit, Options};
use crate::io::error::{IoError, Place, quoted};
use crate::io::suggest::{did_you_mean, list};
#[cfg(feature = "mcap")]
use crate::robot::Joint;
use crate::robot::{JointKind, Robot};

/// What a column holds; the discriminant of a joint is its place in the chain's order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::io) enum Holds {
    /// Position of a moving joint.
    Joint(usize),
    /// Force component 0…2, torque component 3…5.
    Wrench(usize),
    /// Contact flag.
    Contact,
}

/// Layout of a log.
#[derive(Debug)]
pub(in crate::io) struct Layout {
    /// Number of columns of every row.
    pub(in crate::io) columns: usize,
    /// Used columns in ascending order: index in the row, meaning, name.
    pub(in crate::io) used: Vec<(usize, Holds, String)>,
    /// For each moving joint, what to multiply its column with to get rad or m.
    pub(in crate::io) scale: Vec<f64>,
    /// Whether the first line is a header.
    pub(in crate::io) has_header: bool,
    /// Whether joints are named as KUKA's recorder does.
    pub(in crate::io) from_recorder: bool,
    pub(in crate::io) separator: Separator,
}

const WRENCH: [&str; 6] = ["fx", "fy", "fz", "tx", "ty", "tz"];

impl Layout {
    /// Understands the first line of a file.
    pub(super) fn of(first: &[u8], place: Place, robot: &Robot, options: &Options) -> Result<Layout, IoError> {
        if let Some(header) = &options.header {
            return Layout::declared(header, Separator::Comma.fields(first).count(), place, robot, options);
        }
        let (first, separator) = match first.strip_prefix(kuka::HEADER) {
            Some(names) => (names, Separator::Blanks),
            None => (first, Separator::Comma),
        };
        let cells: Vec<&[u8]> = separator.fields(first).collect();
        let numeric = cells.iter().filter(|cell| number(cell).is_some()).count();
        // Someone's header may hold a number, and a row a broken one: the majority decides.
        if 2 * numeric < cells.len() {
            return Ok(Layout { separator, ..Layout::named(&cells, place, robot, options)? });
        }
        let order = joint_order(&place.file, robot, options)?;
        let used = in_order(&cells, &place, robot, &order)?;
        if options.detection.is_some() {
            return Err(without_force(place, "no header".to_owned()));
        }
        Ok(Layout {
            columns: cells.len(),
            scale: scale(robot, options),
            has_header: false,
            from_recorder: false,
            separator,
            used,
        })
    }

    /// The layout of a file whose first line is a row of so many `columns`.
    fn declared(
        header: &[String],
        columns: usize,
        place: Place,
        robot: &Robot,
        options: &Options,
    ) -> Result<Layout, IoError> {
        if header.len() != columns {
            let expected = format!("{} columns, as `header` declares", header.len());
            return Err(IoError::unexpected(place, expected, format!("{columns}")));
        }
        let names: Vec<&[u8]> = header.iter().map(String::as_bytes).collect();
        let layout = Layout::named(&names, Place::file(place.file).field("header"), robot, options)?;
        Ok(Layout { has_header: false, ..layout })
    }

    /// Understands the names of columns.
    pub(in crate::io) fn named(
        cells: &[&[u8]],
        place: Place,
        robot: &Robot,
        options: &Options,
    ) -> Result<Layout, IoError> {
        let order = joint_order(&place.file, robot, options)?;
        let used = by_name(cells, &place, robot, options, &order)?;
        let has_force = (0..3).all(|k| used.iter().any(|(_, holds, _)| *holds == Holds::Wrench(k)));
        if options.detection.is_some() && !has_force {
            return Err(without_force(place, names(cells)));
        }
        let is_joint =
            |(_, holds, name): &(usize, Holds, String)| matches!(holds, Holds::Joint(_)) && kuka::usual(name).is_some();
        Ok(Layout {
            columns: cells.len(),
            scale: scale(robot, options),
            has_header: true,
            from_recorder: used.iter().any(is_joint),
            separator: Separator::Comma,
            used,
        })
    }

    /// The names of the joints' columns, in the chain's order.
    pub(in crate::io) fn joint_names(&self, dof: usize) -> Vec<String> {
        let name = |joint| self.used.iter().find(|(_, holds, _)| *holds == Holds::Joint(joint));
        (0..dof).map(|joint| name(joint).map_or(String::new(), |(_, _, name)| name.clone())).collect()
    }
}

fn without_force(place: Place, found: String) -> IoError {
    IoError::unexpected(place, "columns fx, fy and fz, which a force threshold needs", found)
}

/// For each moving joint, what to multiply its column with to get rad or m.
pub(in crate::io) fn scale(robot: &Robot, options: &Options) -> Vec<f64> {
    let degree = |kind| options.unit == AngleUnit::Degree && kind != JointKind::Prismatic;
    robot.moving().map(|joint| if degree(joint.kind) { std::f64::consts::PI / 180.0 } else { 1.0 }).collect()
}

/// For each of `q1`…`qn`, its place among the moving joints.
fn joint_order(file: &str, robot: &Robot, options: &Options) -> Result<Vec<usize>, IoError> {
    let Some(wanted) = &options.joints else { return Ok((0..robot.dof()).collect()) };
    let known: Vec<&str> = robot.moving().map(|joint| joint.name.as_str()).collect();
    let mut order = Vec::with_capacity(known.len());
    for name in wanted {
        let found = known.iter().position(|joint| joint == name);
        match found.filter(|index| !order.contains(index)) {
            Some(index) => order.push(index),
            None => {
                let found = match found {
                    Some(_) => format!("`{name}` twice"),
                    None => format!("`{name}`{}", did_you_mean(name, known.iter().copied())),
                };
                let expected = format!("a list of the moving joints ({})", list(known.iter().copied()));
                return Err(IoError::unexpected(Place::file(file).field("joints"), expected, found));
            }
        }
    }
    if order.len() != known.len() {
        let expected = format!("all {} moving joints ({})", known.len(), list(known.iter().copied()));
        return Err(IoError::unexpected(Place::file(file).field("joints"), expected, format!("{}", order.len())));
    }
    Ok(order)
}

/// The name that each moving joint goes by, where it must be the only one: that of [`Options::columns`], else its own.
#[cfg(feature = "mcap")]
pub(in crate::io) fn joint_names(file: &str, robot: &Robot, options: &Options) -> Result<Vec<String>, IoError> {
    let order = joint_order(file, robot, options)?;
    check_renames(file, robot, options)?;
    let renamed = |usual: &str| options.columns.iter().find(|(key, _)| same(key, usual)).map(|(_, name)| name.clone());
    let name = |(index, joint): (usize, &Joint)| {
        let number = 1 + order.iter().position(|at| *at == index).unwrap_or(index);
        renamed(&joint.name).or_else(|| renamed(&format!("q{number}"))).unwrap_or_else(|| joint.name.clone())
    };
    Ok(robot.moving().enumerate().map(name).collect())
}

/// Finds columns by their names.
fn by_name(
    cells: &[&[u8]],
    place: &Place,
    robot: &Robot,
    options: &Options,
    order: &[usize],
) -> Result<Vec<(usize, Holds, String)>, IoError> {
    let mut header = Vec::with_capacity(cells.len());
    for cell in cells {
        let name = std::str::from_utf8(cell).map_err(|_| {
            IoError::unexpected(place.clone(), "column names in UTF-8", quoted(&String::from_utf8_lossy(cell)))
        })?;
        header.push(name);
    }
    let search = Search { header: &header, place, options };
    check_renames(&place.file, robot, options)?;
    let mut used = Vec::new();
    for (index, joint) in robot.moving().enumerate() {
        let number = 1 + order.iter().position(|at| *at == index).unwrap_or(index);
        let numbered = format!("q{number}");
        let column = match search.column(&joint.name)? {
            Some(column) => Some(column),
            None => search.column(&numbered)?,
        };
        let Some(column) = column else {
            let expected = format!("a column for every joint: `{}` or `{numbered}`", joint.name);
            let found = format!("{}{}", names(cells), hint(cells));
            return Err(IoError::unexpected(place.clone(), expected, found));
        };
        used.push((column, Holds::Joint(index), header[column].to_owned()));
    }
    for (k, name) in WRENCH.iter().enumerate() {
        used.extend(search.column(name)?.map(|column| (column, Holds::Wrench(k), (*name).to_owned())));
    }
    used.extend(search.column("contact")?.map(|column| (column, Holds::Contact, "contact".to_owned())));
    used.sort_by_key(|(column, _, _)| *column);
    if let Some(pair) = used.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        return Err(IoError::unexpected(
            place.clone(),
            "a column for each purpose",
            format!("`{}` for two", pair[0].2),
        ));
    }
    Ok(used)
}

/// The columns of a file without header: joints in order, nothing else.
fn in_order(
    cells: &[&[u8]],
    place: &Place,
    robot: &Robot,
    order: &[usize],
) -> Result<Vec<(usize, Holds, String)>, IoError> {
    if cells.len() != order.len() {
        let joints = list(robot.moving().map(|joint| joint.name.as_str()));
        let expected = format!("{} columns, the joints in order ({joints}), or a header", order.len());
        let found = format!("{} columns{}", cells.len(), hint(cells));
        return Err(IoError::unexpected(place.clone(), expected, found));
    }
    Ok(order.iter().enumerate().map(|(k, joint)| (k, Holds::Joint(*joint), format!("q{}", k + 1))).collect())
}

struct Search<'a> {
    header: &'a [&'a str],
    place: &'a Place,
    options: &'a Options,
}

impl Search<'_> {
    /// The only column of that usual name, or of the name it goes by in this file.
    fn column(&self, usual: &str) -> Result<Option<usize>, IoError> {
        let renamed = self.options.columns.iter().find(|(key, _)| same(key, usual)).map(|(_, name)| name.as_str());
        let name = renamed.unwrap_or(usual);
        let recorded = |column: &str| renamed.is_none() && kuka::usual(column).is_some_and(|name| same(&name, usual));
        let is = |k: &usize| same(self.header[*k], name) || recorded(self.header[*k]);
        let mut columns = (0..self.header.len()).filter(is);
        match (columns.next(), columns.next()) {
            (Some(first), Some(second)) => {
                let found = format!("`{name}` twice (columns {} and {})", first + 1, second + 1);
                Err(IoError::unexpected(self.place.clone(), "distinct column names", found))
            }
            (None, _) if renamed.is_some() => {
                let expected = format!("column `{name}`, which holds `{usual}`");
                let found = format!("{}{}", shown(self.header), did_you_mean(name, self.header.iter().copied()));
                Err(IoError::unexpected(self.place.clone(), expected, found))
            }
            (column, _) => Ok(column),
        }
    }
}

/// Every key of the renames must be a usual name, or it would silently do nothing.
fn check_renames(file: &str, robot: &Robot, options: &Options) -> Result<(), IoError> {
    let numbered: Vec<String> = (1..=robot.dof()).map(|number| format!("q{number}")).collect();
    let joints = robot.moving().map(|joint| joint.name.as_str());
    let known: Vec<&str> = joints.chain(numbered.iter().map(String::as_str)).chain(WRENCH).chain(["contact"]).collect();
    match options.columns.keys().find(|key| !known.iter().any(|name| same(key, name))) {
        None => Ok(()),
        Some(key) => {
            let place = Place::file(file).field("columns");
            let expected = format!("a name to rename ({})", list(known.iter().copied()));
            Err(IoError::unexpected(place, expected, format!("`{key}`{}", did_you_mean(key, known))))
        }
    }
}

pub(in crate::io) fn same(a: &str, b: &str) -> bool {
    a.trim().eq_ignore_ascii_case(b.trim())
}

fn number(cell: &[u8]) -> Option<f64> {
    std::str::from_utf8(cell).ok()?.parse().ok()
}

pub(in crate::io) fn names(cells: &[&[u8]]) -> String {
    let names: Vec<_> = cells.iter().map(|cell| String::from_utf8_lossy(cell)).collect();
    shown(&names.iter().map(AsRef::as_ref).collect::<Vec<&str>>())
}

fn shown(header: &[&str]) -> String {
    format!("columns {}", quoted(&header.join(",")))
}

/// Other separators are a common mistake.
pub(in crate::io) fn hint(cells: &[&[u8]]) -> &'static str {
    match cells {
        [only] if only.contains(&b';') => " (fields are separated by `,`, not by `;`)",
        [only] if only.contains(&b'\t') => " (fields are separated by `,`, not by tabs)",
        [only] if only.contains(&b' ') => " (fields are separated by `,`, not by blanks)",
        _ => "",
    }
}
