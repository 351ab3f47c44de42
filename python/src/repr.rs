//! Values as representations show them: in mm and degrees, with four significant digits.

use touchcal::parameter::Unit;
use touchcal::se3::Pose;

/// A number with four significant digits.
pub fn number(value: f64) -> String {
    let rounded = format!("{value:.3e}").parse().unwrap_or(value);
    format!("{rounded:?}")
}

/// A value (SI) in the unit for people, and its standard deviation where it has one.
pub fn quantity(unit: Unit, value: f64, sigma: Option<f64>) -> String {
    let (factor, symbol, _) = unit.in_user_units();
    let deviation = sigma.map_or_else(String::new, |sigma| format!(" ± {}", number(factor * sigma)));
    format!("{}{deviation} {symbol}", number(factor * value))
}

/// A length (m).
pub fn length(value: f64) -> String {
    quantity(Unit::Meter, value, None)
}

/// An angle (rad).
pub fn angle(value: f64) -> String {
    quantity(Unit::Radian, value, None)
}

/// A place and the angle of a rotation.
pub fn pose(pose: &Pose) -> String {
    let [x, y, z] = [0, 1, 2].map(|k| number(1e3 * pose.translation.vector[k]));
    format!("({x}, {y}, {z}) mm, rotated by {}", angle(pose.rotation.angle()))
}
