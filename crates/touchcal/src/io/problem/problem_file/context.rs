//! The file being read: places in it, and its numbers in SI units.

use std::ops::Range;
use std::path::{Path, PathBuf};

use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use toml::Spanned;

use super::schema::{Number, PoseToml, Text};
use crate::io::base::error::{IoError, Place, quoted, shown_number};
use crate::io::base::suggest::did_you_mean;
use crate::se3::Pose;

/// Largest problem file read (bytes), 4 MiB.
pub const MAX_BYTES: u64 = 4 << 20;
pub(crate) const MM: f64 = 1e-3;
pub(crate) const DEG: f64 = std::f64::consts::PI / 180.0;
/// Largest magnitude of any number: a kilometre in mm, and more than any angle, force or ratio.
pub(crate) const LARGEST: f64 = 1e6;
/// How far a quaternion's norm may be from 1 (rounded digits) before it is taken for a mistake.
const NORM_TOLERANCE: f64 = 1e-3;

/// What a number may be.
#[derive(Clone, Copy)]
pub(crate) enum Allowed {
    Positive,
    NotNegative,
}

pub(crate) struct Context<'a> {
    pub(crate) text: &'a str,
    pub(crate) file: &'a str,
    pub(crate) folder: &'a Path,
}

impl Context<'_> {
    pub(crate) fn place(&self, span: Range<usize>, field: impl Into<String>) -> Place {
        Place::file(self.file).at_byte(self.text, span.start).field(field)
    }

    /// The path that a value names.
    pub(crate) fn path(&self, name: &Text, field: &str) -> Result<PathBuf, IoError> {
        let path = self.folder.join(name.get_ref());
        if path.exists() {
            return Ok(path);
        }
        let found = format!("{}, which does not exist ({})", quoted(name.get_ref()), path.display());
        Err(IoError::unexpected(self.place(name.span(), field), "a file", found))
    }

    /// The error of a parser.
    pub(crate) fn syntax(&self, error: &toml::de::Error) -> IoError {
        let place = match error.span() {
            Some(span) => {
                let place = Place::file(self.file).at_byte(self.text, span.start);
                match key_before(self.text, span.start) {
                    Some(key) => place.field(key),
                    None => place,
                }
            }
            None => Place::file(self.file),
        };
        let mut message = error.message().trim().replace('\n', "; ");
        let invalid = message.strip_prefix("invalid type: ").or_else(|| message.strip_prefix("invalid "));
        if let Some((found, expected)) = invalid.and_then(|found| found.split_once(", expected ")) {
            return IoError::unexpected(place, type_in_words(expected), found_in_words(found));
        }
        let mut names = message.split('`').skip(1).step_by(2);
        if let (true, Some(unknown)) = (message.starts_with("unknown"), names.next()) {
            let hint = did_you_mean(unknown, names);
            message.push_str(&hint);
        }
        IoError::syntax(place, message)
    }

    /// A number times `unit`, if it is there.
    pub(crate) fn number(
        &self,
        number: Option<&Number>,
        unit: f64,
        allowed: Allowed,
        field: &str,
    ) -> Result<Option<f64>, IoError> {
        let Some(number) = number else { return Ok(None) };
        let value = *number.get_ref();
        let (fits, expected) = match allowed {
            Allowed::Positive => (value > 0.0, "a positive number"),
            Allowed::NotNegative => (value >= 0.0, "a number of at least 0"),
        };
        if fits && value <= LARGEST {
            return Ok(Some(value * unit));
        }
        let expected = format!("{expected}, at most {LARGEST}");
        Err(IoError::unexpected(self.place(number.span(), field), expected, shown_number(value)))
    }

    /// A number that must be there.
    pub(crate) fn required(
        &self,
        number: Option<&Number>,
        unit: f64,
        span: Range<usize>,
        field: &str,
    ) -> Result<f64, IoError> {
        self.number(number, unit, Allowed::Positive, field)?
            .ok_or_else(|| IoError::unexpected(self.place(span, field), "a positive number", "none"))
    }

    /// A whole number from 1 to `most`, if it is there.
    pub(crate) fn whole(&self, number: Option<&Number>, most: f64, field: &str) -> Result<Option<usize>, IoError> {
        let Some(number) = number else { return Ok(None) };
        let value = *number.get_ref();
        if value.fract() != 0.0 || !(1.0..=most).contains(&value) {
            let place = self.place(number.span(), field);
            return Err(IoError::unexpected(place, format!("a whole number from 1 to {most}"), shown_number(value)));
        }
        Ok(Some(value as usize))
    }

    /// Three numbers of any sign.
    pub(crate) fn vector(&self, vector: &Spanned<[f64; 3]>, field: &str) -> Result<[f64; 3], IoError> {
        match vector.get_ref().iter().find(|v| v.is_nan() || v.abs() > LARGEST) {
            None => Ok(*vector.get_ref()),
            Some(bad) => {
                let expected = format!("numbers within ±{LARGEST}");
                Err(IoError::unexpected(self.place(vector.span(), field), expected, shown_number(*bad)))
            }
        }
    }

    /// A pose; absent parts are zero.
    pub(crate) fn pose(&self, pose: Option<&Spanned<PoseToml>>, field: &str) -> Result<Option<Pose>, IoError> {
        let Some(pose) = pose else { return Ok(None) };
        let PoseToml { xyz_mm, quat_wxyz, rpy_deg } = pose.get_ref();
        let at = |part: &str| self.place(pose.span(), format!("{field}.{part}"));
        let finite = |numbers: &[f64], part: &str| match numbers.iter().find(|v| v.is_nan() || v.abs() > LARGEST) {
            Some(bad) => Err(IoError::unexpected(at(part), format!("numbers within ±{LARGEST}"), shown_number(*bad))),
            None => Ok(()),
        };
        finite(xyz_mm, "xyz_mm")?;
        let rotation = match (quat_wxyz, rpy_deg) {
            (Some(_), Some(_)) => {
                return Err(IoError::unexpected(at("rpy_deg"), "quat_wxyz or rpy_deg", "both"));
            }
            (None, None) => UnitQuaternion::identity(),
            (None, Some(rpy)) => {
                finite(rpy, "rpy_deg")?;
                UnitQuaternion::from_euler_angles(rpy[0] * DEG, rpy[1] * DEG, rpy[2] * DEG)
            }
            (Some(wxyz), None) => {
                finite(wxyz, "quat_wxyz")?;
                let quaternion = Quaternion::new(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
                let norm = quaternion.norm();
                if (norm - 1.0).abs() > NORM_TOLERANCE {
                    return Err(IoError::unexpected(at("quat_wxyz"), "a quaternion of norm 1", format!("norm {norm}")));
                }
                UnitQuaternion::from_quaternion(quaternion)
            }
        };
        let translation = Translation3::new(xyz_mm[0] * MM, xyz_mm[1] * MM, xyz_mm[2] * MM);
        Ok(Some(Pose::from_parts(translation, rotation)))
    }
}

/// The key of the value that begins at a byte, where both are in one line.
fn key_before(text: &str, at: usize) -> Option<&str> {
    let line = text.get(..at)?.rsplit('\n').next()?;
    let key = line.split_once('=')?.0.trim();
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
    (!key.is_empty() && key.chars().all(is_plain)).then_some(key)
}

/// What a parser expects, in the words of the format.
fn type_in_words(expected: &str) -> String {
    match expected {
        "f64" => "a number",
        "i64" | "u64" | "usize" => "a whole number",
        "a boolean" => "true or false",
        "a string" => "a text in quotes",
        "a sequence" => "a list in brackets (of tables: [[name]])",
        "a map" => "a table",
        _ if expected.starts_with("struct ") => "a table",
        _ => return expected.replace("an array of length", "a list of length"),
    }
    .to_owned()
}

/// What a parser found, in the words of the format.
fn found_in_words(found: &str) -> String {
    match found.split_once(' ') {
        None if found == "sequence" => "a list".to_owned(),
        None if found == "map" => "a table".to_owned(),
        Some(("string", text)) => format!("the text {text}"),
        Some(("integer" | "floating", number)) => {
            format!("the number {}", number.trim_start_matches("point ").trim_matches('`'))
        }
        Some(("boolean", value)) => value.trim_matches('`').to_owned(),
        _ => found.to_owned(),
    }
}
