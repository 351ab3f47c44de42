//! Rows of numbers in named columns, from memory or from a file that holds no text.

use super::layout::{Holds, Layout};
use super::options::Options;
use super::rows::{LogRows, RowSink};
use crate::contact::Row;
use crate::io::base::error::{IoError, Place, shown_number};
use crate::robot::Robot;

/// Takes rows one after the other, each by the numbers in the columns that are used.
pub(super) struct NumberRows<'a> {
    file: &'a str,
    place: fn(&str, u64) -> Place,
    robot: &'a Robot,
    options: &'a Options,
    layout: Layout,
    row: Row,
    rows: LogRows<'a>,
}

impl<'a> NumberRows<'a> {
    /// The columns of these `names`; `place` is that of a row, by its number.
    pub(super) fn new(
        names: &[&[u8]],
        (file, place): (&'a str, fn(&str, u64) -> Place),
        (robot, options): (&'a Robot, &'a Options),
        sink: &'a mut dyn RowSink,
    ) -> Result<Self, IoError> {
        let layout = Layout::named(names, Place::file(file), robot, options)?;
        let rows = LogRows::of(&layout, (file, place), (robot, options), sink);
        Ok(NumberRows { file, place, robot, options, layout, row: Row::new(robot.dof()), rows })
    }

    /// Index and name of each column that is used.
    pub(super) fn used(&self) -> impl Iterator<Item = (usize, &str)> {
        self.layout.used.iter().map(|(column, _, name)| (*column, name.as_str()))
    }

    /// Takes the next row: `value(k)` is its number in the column that is `k`-th among those used.
    pub(super) fn take(&mut self, value: impl Fn(usize) -> f64) -> Result<(), IoError> {
        let number = self.rows.count() + 1;
        for (k, (_, holds, name)) in self.layout.used.iter().enumerate() {
            let value = value(k);
            match holds {
                Holds::Joint(joint) if value.is_finite() => self.row.q[*joint] = value * self.layout.scale[*joint],
                Holds::Wrench(k) if value.is_finite() => self.row.wrench[*k] = value,
                Holds::Torque(joint) if value.is_finite() => self.row.set_torque(*joint, value),
                Holds::Temperature if value.is_finite() => self.row.temperature = Some(value),
                Holds::Target(k, unit) if value.is_finite() => {
                    self.row.place.get_or_insert_default()[*k] = value * unit.in_metres();
                }
                Holds::Normal(k) if value.is_finite() => self.row.normal.get_or_insert_default()[*k] = value,
                Holds::Contact if value == 0.0 || value == 1.0 => self.row.flag = value == 1.0,
                _ => {
                    let place = (self.place)(self.file, number).field(format!("column {name}"));
                    let expected = holds.expected(self.robot, self.options);
                    return Err(IoError::unexpected(place, expected, shown_number(value)));
                }
            }
        }
        self.rows.take(number, &self.row)
    }

    /// The verdict over all rows.
    pub(super) fn finish(self) -> Result<(), IoError> {
        if self.rows.count() == 0 {
            return Err(IoError::unexpected(Place::file(self.file), "rows of joint positions", "none"));
        }
        self.rows.finish()
    }
}
