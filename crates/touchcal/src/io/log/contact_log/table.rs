//! A whole log, of whatever format, to be written in another: joint positions in rad and m under
//! the joints' names, the wrench, joint torques and the flag.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;

use super::joints::{NORMAL, TARGET, WRENCH, torque_names};
use super::layout::Holds;
use super::options::Options;
use super::reader::{log_in, read_into};
use super::rows::RowSink;
use crate::contact::{LogFull, MAX_CONTACTS, Row};
use crate::io::base::atomic;
use crate::io::base::error::{IoError, Place};
use crate::robot::Robot;

/// All rows of a log, in contact or not, in rad, m, N and N m.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LogTable {
    joints: Vec<String>,
    /// Names of the columns of joint torques, if there are any.
    torques: Vec<String>,
    /// What follows the joints in a row.
    extras: Vec<Holds>,
    values: Vec<f64>,
    notes: Vec<String>,
}

impl LogTable {
    /// Reads all rows of a log of any format, or of the only file in a bag's folder.
    /// [`Options::detection`], [`Options::apart`] and [`Options::fixture`] are ignored; the
    /// wrenches of a bag are read if [`Options::wrench_topic`] or [`Options::load`] is given.
    /// Wrenches and joint torques are kept as measured; a bag's efforts are left out.
    ///
    /// # Errors
    /// As [`read_file`](super::read_file), with [`MAX_CONTACTS`] as the largest number of rows.
    pub fn read_file(path: &Path, robot: &Robot, options: &Options) -> Result<LogTable, IoError> {
        let joints = robot.moving().map(|joint| joint.name.clone()).collect();
        let torques = robot.moving().map(|joint| torque_names(&joint.name, 0)[0].clone()).collect();
        let mut table = LogTable { joints, torques, ..LogTable::default() };
        let options = Options { detection: None, joint_torques: None, keeps_joint_torques: true, ..options.clone() };
        read_into(&log_in(path)?, robot, &options, &mut table)?;
        Ok(table)
    }

    /// Writes the log in the format of the file name's ending, in any case: `.csv`, `.csv.gz`, or
    /// `.parquet` (cargo feature `parquet`). Missing folders are made, an existing file is
    /// replaced.
    ///
    /// # Errors
    /// [`IoError`] if the name has another ending, or the file cannot be written; `path` is then as
    /// it was.
    pub fn write_file(&self, path: &Path) -> Result<(), IoError> {
        let name = path.display().to_string();
        let failed = |source| IoError::file(path, "write", source);
        let lower = name.to_ascii_lowercase();
        if lower.ends_with(".csv") {
            atomic::write_by(path, |file| self.write_csv(file).map_err(failed))
        } else if lower.ends_with(".csv.gz") {
            atomic::write_by(path, |file| {
                let mut packed = GzEncoder::new(file, Compression::default());
                self.write_csv(&mut packed).and_then(|()| packed.finish().map(drop)).map_err(failed)
            })
        } else if lower.ends_with(".parquet") && cfg!(feature = "parquet") {
            atomic::write_by(path, |file| self.write_parquet(file, &name))
        } else {
            let formats = if cfg!(feature = "parquet") { ".csv, .csv.gz or .parquet" } else { ".csv or .csv.gz" };
            Err(IoError::unexpected(Place::file(name), format!("a name that ends in {formats}"), "another"))
        }
    }

    /// Names of the columns: the moving joints in the order of the chain, base first, then those of
    /// `fx` … `tz`, `tau_` and a joint's name, and `contact` that the log has, in the order of its
    /// columns.
    pub fn columns(&self) -> Vec<&str> {
        let extra = |holds: &Holds| match holds {
            Holds::Wrench(k) => WRENCH[*k],
            Holds::Temperature => "temperature_c",
            Holds::Target(k, _) => TARGET[*k][0],
            Holds::Normal(k) => NORMAL[*k],
            Holds::Torque(joint) => self.torques.get(*joint).map_or("", String::as_str),
            Holds::Contact | Holds::Joint(_) => "contact",
        };
        self.joints.iter().map(String::as_str).chain(self.extras.iter().map(extra)).collect()
    }

    /// The rows in the order of the log, one number for each of [`columns`](LogTable::columns):
    /// rad, or m for a prismatic joint; N and N m; the contact flag 0 or 1.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.values.chunks_exact((self.joints.len() + self.extras.len()).max(1))
    }

    /// Assumptions made in reading, such as a guessed unit, each with the file's name, in the order
    /// in which they were made; empty if there were none.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    fn write_csv(&self, into: impl Write) -> std::io::Result<()> {
        let mut into = BufWriter::new(into);
        // A joint's name may hold whatever XML allows.
        let quoted = self
            .columns()
            .into_iter()
            .map(|name| if name.contains(',') { format!("\"{name}\"") } else { name.to_owned() });
        writeln!(into, "{}", quoted.collect::<Vec<_>>().join(","))?;
        for row in self.rows() {
            for (k, value) in row.iter().enumerate() {
                let comma = if k == 0 { "" } else { "," };
                write!(into, "{comma}{value}")?;
            }
            writeln!(into)?;
        }
        into.flush()
    }

    #[cfg(feature = "parquet")]
    fn write_parquet(&self, file: &mut File, name: &str) -> Result<(), IoError> {
        super::parquet::write(file, &self.columns(), self.rows())
            .map_err(|error| IoError::syntax(Place::file(name), error.to_string()))
    }

    #[cfg(not(feature = "parquet"))]
    fn write_parquet(&self, _: &mut File, _: &str) -> Result<(), IoError> {
        Ok(())
    }
}

impl RowSink for LogTable {
    fn set_extras(&mut self, extras: &[Holds]) {
        self.extras = extras.to_vec();
    }

    fn push(&mut self, _: u64, row: &Row) -> Result<(), LogFull> {
        if self.rows().len() >= MAX_CONTACTS {
            return Err(LogFull);
        }
        self.values.extend_from_slice(&row.q);
        let extra = |holds: &Holds| match holds {
            Holds::Wrench(k) => row.wrench[*k],
            Holds::Temperature => row.temperature.unwrap_or(f64::NAN),
            Holds::Target(k, _) => row.place.map_or(f64::NAN, |place| place[*k]),
            Holds::Normal(k) => row.normal.map_or(f64::NAN, |normal| normal[*k]),
            Holds::Torque(joint) => row.torques.get(*joint).copied().unwrap_or(f64::NAN),
            Holds::Contact | Holds::Joint(_) => f64::from(u8::from(row.flag)),
        };
        self.values.extend(self.extras.iter().map(extra));
        Ok(())
    }

    fn rescale(&mut self, scale: &[f64]) {
        for row in self.values.chunks_exact_mut((self.joints.len() + self.extras.len()).max(1)) {
            row.iter_mut().zip(scale).for_each(|(q, scale)| *q *= scale);
        }
    }

    fn note(&mut self, file: &str, note: &str) {
        self.notes.push(format!("{file}: {note}"));
    }

    fn finish(&mut self, _: u64) {}
}
