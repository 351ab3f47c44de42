//! Contact logs in ROS 2 bags (MCAP, cargo feature `mcap`): `sensor_msgs/msg/JointState`, and where
//! contact is detected by force, or the load counts, `geometry_msgs/msg/WrenchStamped`, both in
//! CDR; chunks as they are or packed by lz4 or zstd.
//!
//! A row is a joint state; the wrench at its time is on the line between the wrenches before and
//! after it. Times are those of the headers, where they are set, else when a message was recorded.
//! The file is read once, from its beginning to its end, message by message.

mod cdr;
mod records;
mod together;

use std::collections::HashMap;
use std::io::Read;

use self::records::Visit;
use self::together::{State, Together};
use super::joints::{joint_names, scale};
use super::layout::Holds;
use super::options::Options;
use super::rows::{LogRows, RowSink};
use crate::contact::Row;
use crate::io::base::error::{IoError, Place, caught, quoted};
use crate::io::base::suggest::{did_you_mean, list};
use crate::robot::Robot;

/// Most topics or joints that a message lists, and most bytes of one.
const MOST_TOPICS: usize = 1000;
const LONGEST_TOPIC: usize = 1000;

/// What a topic is read for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Joints,
    Wrench,
}

/// What a row holds beside joint positions.
const WRENCH_PARTS: [Holds; 6] =
    [Holds::Wrench(0), Holds::Wrench(1), Holds::Wrench(2), Holds::Wrench(3), Holds::Wrench(4), Holds::Wrench(5)];

impl Kind {
    const ALL: [Kind; 2] = [Kind::Joints, Kind::Wrench];

    fn schema(self) -> &'static str {
        match self {
            Kind::Joints => "sensor_msgs/msg/JointState",
            Kind::Wrench => "geometry_msgs/msg/WrenchStamped",
        }
    }

    /// How a problem names the topic.
    fn key(self) -> &'static str {
        match self {
            Kind::Joints => "joint_topic",
            Kind::Wrench => "wrench_topic",
        }
    }
}

/// Passes the rows of a bag to `sink`; `file` is its name for messages and provenance.
pub(super) fn read(
    content: impl Read,
    file: &str,
    robot: &Robot,
    options: &Options,
    sink: &mut dyn RowSink,
) -> Result<(), IoError> {
    if options.targets.is_some() {
        let expected = "a table (CSV or Parquet), which has columns of targets";
        return Err(IoError::unexpected(Place::file(file), expected, "a bag"));
    }
    if options.temperature.is_some() {
        let expected = "a table (CSV or Parquet), which has a column of the temperature";
        return Err(IoError::unexpected(Place::file(file).field("temperature"), expected, "a bag"));
    }
    let names = joint_names(file, robot, options)?;
    let with_wrench = options.wrench_parts() > 0 || options.wrench_topic.is_some();
    let extras = if with_wrench { &WRENCH_PARTS[..] } else { &[] };
    let mut bag = Bag {
        file,
        joint: robot.moving().next().map_or("", |joint| joint.name.as_str()),
        options,
        with_wrench,
        scale: scale(robot, options),
        rows: LogRows::new((file, at), names.clone(), extras, (robot, options), sink),
        row: Row::new(robot.dof()),
        names,
        schemas: HashMap::new(),
        channels: HashMap::new(),
        topics: [options.joint_topic.clone(), options.wrench_topic.clone()],
        seen: Vec::new(),
        strangers: Vec::new(),
        counts: [0; 2],
        newest: [i64::MIN; 2],
        together: Together::default(),
    };
    caught(file, "MCAP", || records::read(content, file, &mut bag))?;
    bag.finish()
}

fn at(file: &str, number: u64) -> Place {
    Place::file(file).field(format!("joint state {number}"))
}

/// Names of a message's joints, for error messages.
fn joints_of(message: &[u8]) -> Vec<String> {
    let mut names = Vec::new();
    // It was read before.
    let _ = cdr::joint_state(message, |name, _, _| {
        if names.len() < MOST_TOPICS && name.len() <= LONGEST_TOPIC {
            names.push(String::from_utf8_lossy(name).into_owned());
        }
    });
    names
}

struct Bag<'a> {
    file: &'a str,
    /// The URDF's name of the first joint, as an example.
    joint: &'a str,
    options: &'a Options,
    /// Whether wrenches are read.
    with_wrench: bool,
    /// For each moving joint, its name in the bag, and what makes rad or m of its positions.
    names: Vec<String>,
    scale: Vec<f64>,
    rows: LogRows<'a>,
    row: Row,
    schemas: HashMap<u16, Option<Kind>>,
    channels: HashMap<u16, Kind>,
    /// By kind, the topic declared or found.
    topics: [Option<String>; 2],
    /// Topics of the bag, for messages.
    seen: Vec<String>,
    /// The first joints that are none of the arm's, for messages.
    strangers: Vec<String>,
    /// By kind, messages read, and the time of the last one (ns).
    counts: [u64; 2],
    newest: [i64; 2],
    together: Together,
}

impl Visit for Bag<'_> {
    fn schema(&mut self, id: u16, name: &str) {
        self.schemas.insert(id, Kind::ALL.into_iter().find(|kind| name == kind.schema()));
    }

    fn channel(&mut self, id: u16, schema: u16, topic: &str, encoding: &str) -> Result<(), IoError> {
        if self.seen.len() < MOST_TOPICS && topic.len() <= LONGEST_TOPIC && !self.seen.iter().any(|seen| seen == topic)
        {
            self.seen.push(topic.to_string());
        }
        let Some(kind) = self.schemas.get(&schema).copied().flatten() else { return Ok(()) };
        if kind == Kind::Wrench && !self.with_wrench {
            self.rows.declare_forces();
            return Ok(());
        }
        let declared = [&self.options.joint_topic, &self.options.wrench_topic][kind as usize];
        match &self.topics[kind as usize] {
            Some(chosen) if *chosen == topic => {}
            Some(_) if declared.is_some() => return Ok(()),
            Some(other) => {
                let expected = format!("one topic of type {}, or `{}`", kind.schema(), kind.key());
                let found = format!("{} and {}", quoted(other), quoted(topic));
                return Err(IoError::unexpected(Place::file(self.file), expected, found));
            }
            None => self.topics[kind as usize] = Some(topic.to_string()),
        }
        if encoding != "cdr" {
            let place = Place::file(self.file).field(format!("topic {topic}"));
            let found = quoted(encoding);
            return Err(IoError::unexpected(place, "messages encoded as cdr", found));
        }
        self.channels.insert(id, kind);
        Ok(())
    }

    fn message(&mut self, channel: u16, recorded: i64, data: &[u8]) -> Result<(), IoError> {
        match self.channels.get(&channel) {
            Some(Kind::Joints) => self.joint_state(recorded, data),
            Some(Kind::Wrench) => self.wrench(recorded, data),
            None => Ok(()),
        }
    }
}

impl Bag<'_> {
    fn joint_state(&mut self, recorded: i64, data: &[u8]) -> Result<(), IoError> {
        let mut found = 0;
        let mut repeated = false;
        self.row.q.fill(f64::NAN);
        self.row.torques.clear();
        let wants_torques = self.options.joint_torques.is_some();
        let stamped = cdr::joint_state(data, |name, position, effort| {
            if let Some(joint) = self.names.iter().position(|known| known.as_bytes() == name) {
                repeated |= !self.row.q[joint].is_nan();
                self.row.q[joint] = position * self.scale[joint];
                if wants_torques {
                    self.row.set_torque(joint, effort.unwrap_or(f64::NAN));
                }
                found += 1;
            }
        });
        let number = self.counts[0] + 1;
        let stamped = stamped.map_err(|expected| IoError::unexpected(at(self.file, number), expected, "another"))?;
        // A gripper's joints, say, may come on the same topic.
        if found == 0 {
            if self.strangers.is_empty() {
                self.strangers = joints_of(data);
            }
            return Ok(());
        }
        let bad = self.names.iter().zip(&self.row.q).find(|(_, q)| !q.is_finite());
        if let Some((name, _)) = bad.filter(|_| !repeated) {
            let expected = format!("finite positions of all joints ({})", list(self.names.iter().map(String::as_str)));
            let mut given = joints_of(data);
            given.retain(|given| !self.names.contains(given));
            let given = || given.iter().map(String::as_str);
            let others = given().next().map_or(String::new(), |_| format!(", but {}", list(given())));
            let found = format!("none of `{name}`{others}{}", did_you_mean(name, given()));
            return Err(IoError::unexpected(at(self.file, number), expected, found));
        }
        if repeated {
            return Err(IoError::unexpected(at(self.file, number), "each joint once", "one twice"));
        }
        if self.row.torques.iter().any(|torque| !torque.is_finite()) {
            let expected = "a finite effort of each joint, which `tau_joint` needs";
            return Err(IoError::unexpected(at(self.file, number), expected, "none"));
        }
        let time = self.time(Kind::Joints, stamped.stamp.unwrap_or(recorded))?;
        if !self.with_wrench {
            return self.rows.take(number, &self.row);
        }
        self.together.add_state(State { number, time, q: self.row.q.clone(), torques: self.row.torques.clone() });
        self.settle()
    }

    fn wrench(&mut self, recorded: i64, data: &[u8]) -> Result<(), IoError> {
        let stamped = cdr::wrench(data).map_err(|expected| {
            let place = Place::file(self.file).field(format!("wrench {}", self.counts[1] + 1));
            IoError::unexpected(place, expected, "another")
        })?;
        let time = self.time(Kind::Wrench, stamped.stamp.unwrap_or(recorded))?;
        self.together.add_wrench(time, stamped.body);
        self.settle()
    }

    /// Counts a message of that time, which must not be before the last one.
    fn time(&mut self, kind: Kind, time: i64) -> Result<i64, IoError> {
        let k = kind as usize;
        self.counts[k] += 1;
        if time < self.newest[k] {
            let topic = self.topics[k].as_deref().unwrap_or_default();
            let place = Place::file(self.file).field(format!("topic {topic}, message {}", self.counts[k]));
            let found = format!("{} ns before the last", self.newest[k].saturating_sub(time));
            return Err(IoError::unexpected(place, "messages in the order of time", found));
        }
        self.newest[k] = time;
        Ok(time)
    }

    fn settle(&mut self) -> Result<(), IoError> {
        while let Some((state, wrench)) = self.together.next() {
            self.row.q.clone_from(&state.q);
            self.row.torques.clone_from(&state.torques);
            self.row.wrench = wrench;
            self.rows.take(state.number, &self.row)?;
        }
        Ok(())
    }

    fn finish(mut self) -> Result<(), IoError> {
        let needed = if self.with_wrench { &Kind::ALL[..] } else { &Kind::ALL[..1] };
        for &kind in needed {
            if self.counts[kind as usize] == 0 {
                return Err(self.without(kind));
            }
        }
        if self.rows.count() == 0 {
            let expected = format!("wrenches within {} s of joint states", together::GAP as f64 / 1e9);
            return Err(IoError::unexpected(Place::file(self.file), expected, "none: are their clocks the same?"));
        }
        let alone = std::mem::take(&mut self.together).finish();
        if alone > 0 {
            let seconds = together::GAP as f64 / 1e9;
            self.rows.note(&format!(
                "{alone} joint states have no wrench within {seconds} s before and after, and are passed over"
            ));
        }
        self.rows.finish()
    }

    /// Nothing of a kind was read.
    fn without(&self, kind: Kind) -> IoError {
        if kind == Kind::Joints && !self.strangers.is_empty() {
            let topic = self.topics[0].as_deref().unwrap_or_default();
            let expected = format!("joint states of {} on {topic}", list(self.names.iter().map(String::as_str)));
            let found = format!(
                "those of {}; `columns = {{ {} = \"…\" }}` says what a joint is called here",
                list(self.strangers.iter().map(String::as_str)),
                self.joint
            );
            return IoError::unexpected(Place::file(self.file), expected, found);
        }
        let seen = || self.seen.iter().map(String::as_str);
        let joints = list(self.names.iter().map(String::as_str));
        let (topic, of) =
            (self.topics[kind as usize].as_deref(), if kind == Kind::Joints { joints } else { String::new() });
        let of = if of.is_empty() { of } else { format!(" of {of}") };
        let expected = match topic {
            Some(topic) => format!("messages of type {}{of} on {topic}", kind.schema()),
            None => format!("messages of type {}{of}", kind.schema()),
        };
        let detects = kind == Kind::Wrench && self.options.detection.is_some();
        let why = if detects { " for the force threshold" } else { "" };
        let expected = expected + why;
        let hint = topic.map_or(String::new(), |topic| did_you_mean(topic, seen().filter(|seen| *seen != topic)));
        IoError::unexpected(Place::file(self.file), expected, format!("topics {}{hint}", list(seen())))
    }
}
