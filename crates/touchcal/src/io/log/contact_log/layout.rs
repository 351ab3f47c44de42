//! Which column of a log holds what.

use super::joints::{NORMAL, TARGET, WRENCH, check_renames, joint_order, scale, torque_names};
use super::kuka;
use super::options::{Options, TargetColumns};
use crate::contact::AngleUnit;
use crate::io::base::csv::{Separator, hint, names, same, shown_names};
use crate::io::base::error::{IoError, Place, quoted};
use crate::io::base::suggest::{did_you_mean, list};
use crate::robot::{JointKind, Robot};

/// What a column holds; the discriminant of a joint is its place in the chain's order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Holds {
    /// Position of a moving joint.
    Joint(usize),
    /// Force component 0…2, torque component 3…5.
    Wrench(usize),
    /// Torque about a moving joint, or force of a prismatic one.
    Torque(usize),
    /// Contact flag.
    Contact,
    /// Temperature of the arm.
    Temperature,
    /// Coordinate 0…2 of the target, in mm or in m.
    Target(usize, LengthUnit),
    /// Component 0…2 of the normal at the target.
    Normal(usize),
}

/// Unit of a target's coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LengthUnit {
    Metre,
    Millimetre,
}

impl LengthUnit {
    /// The unit in metres.
    pub(crate) fn in_metres(self) -> f64 {
        match self {
            LengthUnit::Metre => 1.0,
            LengthUnit::Millimetre => 1e-3,
        }
    }
}

impl Holds {
    /// What is expected there, in words.
    pub(crate) fn expected(self, robot: &Robot, options: &Options) -> &'static str {
        let prismatic = |joint| robot.moving().nth(joint).is_some_and(|joint| joint.kind == JointKind::Prismatic);
        match self {
            Holds::Joint(joint) if prismatic(joint) => "a number in metres",
            Holds::Joint(_) if options.unit == AngleUnit::Degree => "a number in degrees",
            Holds::Joint(_) => "a number in radians",
            Holds::Wrench(0..3) => "a number in N",
            Holds::Wrench(_) => "a number in Nm",
            Holds::Torque(joint) if prismatic(joint) => "a number in N",
            Holds::Torque(_) => "a number in Nm",
            Holds::Contact => "0, 1, true or false",
            Holds::Temperature => "a number in degrees Celsius",
            Holds::Target(_, LengthUnit::Metre) => "a number in metres",
            Holds::Target(_, LengthUnit::Millimetre) => "a number in millimetres",
            Holds::Normal(_) => "a number",
        }
    }
}

/// Layout of a log.
#[derive(Debug)]
pub(crate) struct Layout {
    /// Number of columns of every row.
    pub(crate) columns: usize,
    /// Used columns in ascending order: index in the row, meaning, name.
    pub(crate) used: Vec<(usize, Holds, String)>,
    /// For each moving joint, what to multiply its column with to get rad or m.
    pub(crate) scale: Vec<f64>,
    /// Whether the first line is a header.
    pub(crate) has_header: bool,
    /// Whether joints are named as KUKA's recorder does.
    pub(crate) from_recorder: bool,
    pub(crate) separator: Separator,
}

impl Layout {
    /// Understands the first line of a file.
    pub(crate) fn of(first: &[u8], place: Place, robot: &Robot, options: &Options) -> Result<Layout, IoError> {
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
        check_wrench(&used, options, place.clone(), || "no header".to_owned())?;
        let missing = match (options.targets, options.joint_torques) {
            (Some(_), _) => Some("targets"),
            (None, Some(_)) => Some("joint torques"),
            (None, None) => None,
        };
        if let Some(missing) = missing {
            let expected = format!("a header, or `header`, with the columns of {missing}");
            return Err(IoError::unexpected(place, expected, "no header"));
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
    pub(crate) fn named(cells: &[&[u8]], place: Place, robot: &Robot, options: &Options) -> Result<Layout, IoError> {
        let order = joint_order(&place.file, robot, options)?;
        let used = by_name(cells, &place, robot, options, &order)?;
        check_wrench(&used, options, place, || names(cells))?;
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
    pub(crate) fn joint_names(&self, dof: usize) -> Vec<String> {
        let name = |joint| self.used.iter().find(|(_, holds, _)| *holds == Holds::Joint(joint));
        (0..dof).map(|joint| name(joint).map_or(String::new(), |(_, _, name)| name.clone())).collect()
    }
}

/// Checks that columns have as much of a wrench as is needed.
fn check_wrench(
    used: &[(usize, Holds, String)],
    options: &Options,
    place: Place,
    found: impl Fn() -> String,
) -> Result<(), IoError> {
    if (0..options.wrench_parts()).all(|k| used.iter().any(|(_, holds, _)| *holds == Holds::Wrench(k))) {
        return Ok(());
    }
    let expected = match options.load {
        Some(_) => "columns fx, fy, fz, tx, ty and tz, which a load needs, or their names in `columns`",
        None => "columns fx, fy and fz, which a force threshold needs, or their names in `columns`",
    };
    Err(IoError::unexpected(place, expected, found()))
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
            let expected =
                format!("a column for every joint: `{}` or `{numbered}`, or its name in `columns`", joint.name);
            let near = match hint(cells) {
                "" => misspelt(&joint.name, &numbered, &header, robot),
                hint => hint.to_owned(),
            };
            let found = format!("{}{near}", names(cells));
            return Err(IoError::unexpected(place.clone(), expected, found));
        };
        used.push((column, Holds::Joint(index), header[column].to_owned()));
    }
    for (k, name) in WRENCH.iter().enumerate() {
        used.extend(search.column(name)?.map(|column| (column, Holds::Wrench(k), (*name).to_owned())));
    }
    used.extend(search.column("contact")?.map(|column| (column, Holds::Contact, "contact".to_owned())));
    used.extend(search.targets()?);
    used.extend(search.torques(robot, order)?);
    if let Some(name) = &options.temperature {
        let found = || format!("{}{}", shown_names(&header), did_you_mean(name, header.iter().copied()));
        // The time may be `t`.
        let exactly = header.iter().position(|column| column.trim() == name);
        let column = exactly.or_else(|| header.iter().position(|column| same(column, name)));
        let column = column.ok_or_else(|| IoError::unexpected(place.clone(), format!("column `{name}`"), found()))?;
        used.push((column, Holds::Temperature, name.clone()));
    }
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

/// The first column that is no joint's and looks like this joint's with a typing error.
fn misspelt(joint: &str, numbered: &str, header: &[&str], robot: &Robot) -> String {
    let known = |name: &str| {
        let number = (1..=robot.dof()).any(|number| same(&format!("q{number}"), name));
        number || robot.moving().any(|joint| same(&joint.name, name))
    };
    let near = header.iter().map(|name| name.trim()).filter(|name| !known(name)).find_map(|name| {
        let hint = did_you_mean(name, [joint, numbered]);
        (!hint.is_empty()).then(|| format!(" ({}{hint})", quoted(name)))
    });
    near.unwrap_or_default()
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
    /// The columns of targets, as far as the options ask for them.
    fn targets(&self) -> Result<Vec<(usize, Holds, String)>, IoError> {
        let mut used = Vec::new();
        let Some(asked) = self.options.targets else { return Ok(used) };
        let missing = |expected: String| IoError::unexpected(self.place.clone(), expected, shown_names(self.header));
        for (k, [metres, millimetres]) in TARGET.into_iter().enumerate() {
            let column = match self.column(millimetres)? {
                Some(column) => Some((column, LengthUnit::Millimetre)),
                None => self.column(metres)?.map(|column| (column, LengthUnit::Metre)),
            };
            let expected = || format!("a column `{millimetres}` or `{metres}` of the target, or its name in `columns`");
            let (column, unit) = column.ok_or_else(|| missing(expected()))?;
            used.push((column, Holds::Target(k, unit), self.header[column].to_owned()));
        }
        if asked == TargetColumns::WithNormal {
            for (k, name) in NORMAL.into_iter().enumerate() {
                let expected = || format!("a column `{name}` of the surface's normal, or its name in `columns`");
                let column = self.column(name)?.ok_or_else(|| missing(expected()))?;
                used.push((column, Holds::Normal(k), self.header[column].to_owned()));
            }
        }
        Ok(used)
    }

    /// The columns of joint torques, if the options ask for them.
    fn torques(&self, robot: &Robot, order: &[usize]) -> Result<Vec<(usize, Holds, String)>, IoError> {
        let mut used = Vec::new();
        if !self.options.finds_joint_torques() {
            return Ok(used);
        }
        for (index, joint) in robot.moving().enumerate() {
            let number = 1 + order.iter().position(|at| *at == index).unwrap_or(index);
            let [named, numbered] = torque_names(&joint.name, number);
            let column = match self.column(&named)? {
                Some(column) => Some(column),
                None => self.column(&numbered)?,
            };
            let Some(column) = column else {
                if self.options.joint_torques.is_none() {
                    return Ok(Vec::new());
                }
                let expected = format!(
                    "a column of the torque about every joint: `{named}` or `{numbered}`, or its name in `columns`"
                );
                return Err(IoError::unexpected(self.place.clone(), expected, shown_names(self.header)));
            };
            used.push((column, Holds::Torque(index), self.header[column].to_owned()));
        }
        Ok(used)
    }

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
                let found = format!("{}{}", shown_names(self.header), did_you_mean(name, self.header.iter().copied()));
                Err(IoError::unexpected(self.place.clone(), expected, found))
            }
            (column, _) => Ok(column),
        }
    }
}

fn number(cell: &[u8]) -> Option<f64> {
    std::str::from_utf8(cell).ok()?.parse().ok()
}
