//! Encoder offsets in the transmissions of ros2_control. Its `SimpleTransmission` makes positions
//! of joints from those of actuators: `joint = actuator / mechanical_reduction + offset`
//! (`transmission_interface/simple_transmission.hpp` of ros2_control).

use roxmltree::Node;

use super::document::{children, parse, place, robot_element};
use super::edit::{Edit, FILE, apply, slice};
use super::numbers::written;
use crate::io::base::error::{IoError, Place, quoted, shown_name};

/// The transmission that has an offset, as `<plugin>` names it.
const SIMPLE: &str = "transmission_interface/SimpleTransmission";
/// The element that has it.
const OFFSET: &str = "offset";

/// The URDF `text`, of whose `SimpleTransmission`s in `<ros2_control>` the offset of each of these
/// `joints` is less by `b` (rad, or m for a prismatic joint): where joints had the position `q`,
/// they have the position `q − b` then. Every other byte stays as it is.
///
/// # Errors
/// [`IoError`] if the text is no URDF, if a joint has no such transmission, or several, or if an
/// offset is no number.
pub fn with_transmission_offsets<'j>(
    text: &str,
    joints: impl IntoIterator<Item = (&'j str, f64)>,
) -> Result<String, IoError> {
    let document = parse(text, FILE)?;
    let robot = robot_element(&document, FILE)?;
    let edit = |(name, b): (&str, f64)| {
        let joint = transmitted(&robot, name)?;
        let element = children(&joint, OFFSET).next();
        let former = element.as_ref().map_or(Ok(0.0), number)?;
        let offset = format!("<{OFFSET}>{}</{OFFSET}>", written([former - b]));
        Ok(match element {
            Some(element) => Edit { range: element.range(), with: offset },
            None => appended(&joint, offset),
        })
    };
    let edits: Result<Vec<Edit>, IoError> = joints.into_iter().map(edit).collect();
    Ok(apply(text, edits?))
}

/// The one `<joint>` of that name in a `SimpleTransmission`.
fn transmitted<'a, 't>(robot: &Node<'a, 't>, name: &str) -> Result<Node<'a, 't>, IoError> {
    let systems = children(robot, "ros2_control");
    let transmissions = systems.flat_map(|system| children(&system, "transmission").collect::<Vec<_>>());
    let is_simple = |transmission: &Node<'_, '_>| {
        children(transmission, "plugin").any(|plugin| plugin.text().is_some_and(|text| text.trim() == SIMPLE))
    };
    let joints = transmissions.filter(is_simple).flat_map(|each| children(&each, "joint").collect::<Vec<_>>());
    let found: Vec<Node<'a, 't>> = joints.filter(|joint| joint.attribute("name") == Some(name)).collect();
    match found[..] {
        [joint] => Ok(joint),
        _ => {
            let expected =
                format!("a <transmission> of {SIMPLE} in <ros2_control> with the joint `{}`", shown_name(name));
            let found = if found.is_empty() { "none".to_owned() } else { format!("{}", found.len()) };
            Err(IoError::unexpected(Place::file(FILE), expected, found))
        }
    }
}

/// The number that an element contains.
fn number(element: &Node<'_, '_>) -> Result<f64, IoError> {
    let text = element.text().unwrap_or_default().trim();
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(IoError::unexpected(place(element, FILE), "a finite number in <offset>", quoted(text))),
    }
}

/// Puts something at the end of an element's content.
fn appended(element: &Node<'_, '_>, what: String) -> Edit {
    let text = element.document().input_text();
    let range = element.range();
    let whole = slice(text, range.clone());
    match whole.strip_suffix("/>") {
        Some(tag) if !element.has_children() => {
            let name = element.tag_name().name();
            Edit { range: range.start + tag.len()..range.end, with: format!(">{what}</{name}>") }
        }
        _ => Edit::insert(whole.rfind("</").map_or(range.end, |length| range.start + length), what),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn urdf(joints: &str) -> String {
        format!(
            "<robot name='r'><ros2_control name='s' type='system'><joint name='a'/>\
             <transmission name='t'><plugin> {SIMPLE} </plugin>{joints}</transmission>\
             <transmission name='d'><plugin>transmission_interface/DifferentialTransmission</plugin><joint name='c'/></transmission>\
             </ros2_control><transmission><plugin>{SIMPLE}</plugin><joint name='e'/></transmission></robot>"
        )
    }

    #[test]
    fn offsets_are_less_and_all_else_is_kept() {
        let before = urdf(
            "<joint name='a' role='joint1'><mechanical_reduction>50</mechanical_reduction><offset> 0.5 </offset></joint>\
             <joint name='b' role=\"joint2\" /><joint name='f'><mechanical_reduction>2</mechanical_reduction></joint>",
        );
        let after = with_transmission_offsets(&before, [("a", 0.25), ("b", -0.125), ("f", 1.0)]).unwrap();
        let expected = before
            .replace("<offset> 0.5 </offset>", "<offset>0.25</offset>")
            .replace("role=\"joint2\" />", "role=\"joint2\" ><offset>0.125</offset></joint>")
            .replace(
                "<mechanical_reduction>2</mechanical_reduction>",
                "<mechanical_reduction>2</mechanical_reduction><offset>-1</offset>",
            );
        assert_eq!(after, expected);
        assert_eq!(with_transmission_offsets(&before, [("a", 0.0)]).unwrap(), before.replace(" 0.5 ", "0.5"));
    }

    #[test]
    fn joints_without_one_simple_transmission_are_refused() {
        let refused =
            |joints: &str, name: &str| with_transmission_offsets(&urdf(joints), [(name, 0.1)]).unwrap_err().to_string();
        // Of another kind, outside of ros2_control, and none.
        for name in ["c", "e", "x"] {
            let error = refused("<joint name='a'/>", name);
            assert!(error.contains(&format!("with the joint `{name}`, found none")), "{error}");
        }
        assert!(refused("<joint name='a'/><joint name='a'/>", "a").contains("found 2"));
        let error = refused("<joint name='a'><offset>half</offset></joint>", "a");
        assert!(error.contains("expected a finite number in <offset>, found \"half\""), "{error}");
    }
}
