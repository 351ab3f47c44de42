//! The two ROS 2 messages that are read, in CDR (OMG Common Data Representation, as DDS writes it).

use crate::se3::Wrench;

/// A message's stamp (ns), none where it has not been set, and what else it says.
pub(super) struct Stamped<T> {
    pub(super) stamp: Option<i64>,
    pub(super) body: T,
}

/// What a message lacks.
pub(super) type Broken = &'static str;

/// `sensor_msgs/msg/JointState`: calls `joint` with every joint's name and position (rad or m), and
/// with its effort (N m or N) where the message has one for each joint.
pub(super) fn joint_state(
    message: &[u8],
    mut joint: impl FnMut(&[u8], f64, Option<f64>),
) -> Result<Stamped<()>, Broken> {
    let mut names = Reader::new(message)?;
    let stamp = names.header()?;
    let count = names.u32()?;
    let mut positions = names.clone();
    for _ in 0..count {
        positions.text()?;
    }
    if positions.u32()? != count {
        return Err("a position for each name");
    }
    let mut efforts = positions.clone();
    efforts.pass_over(count);
    let velocities = efforts.u32().unwrap_or(0);
    efforts.pass_over(velocities);
    let has_efforts = efforts.u32().is_ok_and(|efforts| efforts == count);
    for _ in 0..count {
        let position = positions.f64()?;
        let effort = if has_efforts { Some(efforts.f64()?) } else { None };
        joint(names.text()?, position, effort);
    }
    Ok(Stamped { stamp, body: () })
}

/// `geometry_msgs/msg/WrenchStamped`.
pub(super) fn wrench(message: &[u8]) -> Result<Stamped<Wrench>, Broken> {
    let mut reader = Reader::new(message)?;
    let stamp = reader.header()?;
    let mut wrench = [0.0; 6];
    for component in &mut wrench {
        *component = reader.f64()?;
    }
    if wrench.iter().any(|component| !component.is_finite()) {
        return Err("finite forces and torques");
    }
    Ok(Stamped { stamp, body: wrench })
}

#[derive(Clone)]
struct Reader<'m> {
    /// What follows the four bytes that say how it is encoded.
    bytes: &'m [u8],
    at: usize,
    little_endian: bool,
    /// Greatest alignment: 8, in the second version 4.
    alignment: usize,
}

impl<'m> Reader<'m> {
    fn new(message: &'m [u8]) -> Result<Self, Broken> {
        let (little_endian, alignment) = match message {
            [0, 0, _, _, ..] => (false, 8),
            [0, 1, _, _, ..] => (true, 8),
            [0, 6, _, _, ..] => (false, 4),
            [0, 7, _, _, ..] => (true, 4),
            _ => return Err("plain CDR"),
        };
        Ok(Reader { bytes: &message[4..], at: 0, little_endian, alignment })
    }

    /// A `std_msgs/msg/Header`; its stamp (ns) unless it is zero.
    fn header(&mut self) -> Result<Option<i64>, Broken> {
        let seconds = i64::from(self.u32()?.cast_signed());
        let stamp = seconds * 1_000_000_000 + i64::from(self.u32()?);
        self.text()?;
        Ok((stamp != 0).then_some(stamp))
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Broken> {
        let start = self.at.next_multiple_of(N.min(self.alignment));
        let array = self.bytes.get(start..).and_then(|rest| rest.first_chunk()).ok_or("a whole message")?;
        self.at = start + N;
        Ok(*array)
    }

    fn u32(&mut self) -> Result<u32, Broken> {
        let bytes = self.array()?;
        Ok(if self.little_endian { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) })
    }

    fn f64(&mut self) -> Result<f64, Broken> {
        let bytes = self.array()?;
        Ok(if self.little_endian { f64::from_le_bytes(bytes) } else { f64::from_be_bytes(bytes) })
    }

    /// Passes over so many numbers.
    fn pass_over(&mut self, numbers: u32) {
        if numbers > 0 {
            self.at = self.at.next_multiple_of(self.alignment.min(8)).saturating_add(8 * numbers as usize);
        }
    }

    /// A string without the zero at its end.
    fn text(&mut self) -> Result<&'m [u8], Broken> {
        let length = self.u32()? as usize;
        let text = self.bytes.get(self.at..).and_then(|rest| rest.get(..length)).ok_or("a whole message")?;
        self.at += length;
        Ok(text.strip_suffix(&[0]).unwrap_or(text))
    }
}
