//! A URDF as a macro of xacro, for the description of a cell with several arms.

use std::collections::HashSet;
use std::ops::Range;

use roxmltree::Node;

use super::document::{XACRO, children, parse, robot_element};
use super::edit::{Edit, FILE, apply, name_end, slice, value_range};
use crate::io::base::error::IoError;

/// What stands before names.
const PREFIX: &str = "${prefix}";
/// A dollar sign that xacro leaves in place before another one.
const DOLLAR: &str = "${&apos;$&apos;}";
/// Elements of xacro itself, which no macro can be named after.
const RESERVED: [&str; 10] =
    ["arg", "attribute", "call", "element", "if", "include", "insert_block", "macro", "property", "unless"];

/// The URDF `text` as a file of xacro that defines a macro: it is named after the robot, with `_`
/// for all but ASCII letters, digits and `_`, and has a parameter `prefix`, empty unless given.
///
/// The prefix goes before the names of links, joints, materials, transmissions, systems of
/// ros2_control and sensors, of what transmissions and systems contain (joints, actuators, sensors,
/// `gpio`), and before references to links and joints: attributes `link`, `joint` and `reference`,
/// the parameter `mimic` of ros2_control, and elements within `<gazebo>` whose whole text is such a
/// name. Other mentions, such as a frame in the settings of a plugin, are left. Dollar signs that
/// xacro would evaluate are escaped. Every other byte stays as it is.
///
/// # Errors
/// [`IoError`] if the text is no URDF or has unexpanded xacro.
pub fn xacro_macro(text: &str) -> Result<String, IoError> {
    let document = parse(text, FILE)?;
    let robot = robot_element(&document, FILE)?;
    let names = |tag| children(&robot, tag).filter_map(|node| node.attribute("name"));
    let names: HashSet<&str> = names("link").chain(names("joint")).collect();
    let mut edits = frame(&robot, text);
    for element in robot.descendants().filter(Node::is_element) {
        let top = element.ancestors().find(|node| node.parent_element() == Some(robot));
        let top = top.map_or("", |node| node.tag_name().name());
        for attribute in element.attributes() {
            let range = value_range(&element, &attribute, text)?;
            let refers =
                || ["link", "joint", "reference"].contains(&attribute.name()) && names.contains(attribute.value());
            let is_name =
                attribute.name() == "name" && !attribute.value().is_empty() && has_prefixed_name(&element, top);
            if is_name || refers() {
                edits.push(Edit::insert(range.start, PREFIX));
            }
            escape(text, range, &mut edits);
        }
        let is_mimic = top == "ros2_control" && element.attribute("name") == Some("mimic");
        if top == "gazebo" || is_mimic {
            edits.extend(reference_in_text(&element, &names, text));
        }
    }
    for range in character_data(text) {
        escape(text, range, &mut edits);
    }
    Ok(apply(text, edits))
}

/// The edits that make the content of the robot the body of a macro.
fn frame(robot: &Node<'_, '_>, text: &str) -> Vec<Edit> {
    let Range { start, end } = robot.range();
    let name = macro_name(robot.attribute("name").unwrap_or_default());
    let begin = format!(
        "\n<xacro:macro name=\"{name}\" params=\"prefix:=''\">\n<!-- Include this file, and call the macro: <xacro:{name} prefix=\"left_\"/> -->"
    );
    let body_end = slice(text, start..end).rfind("</").map_or(end, |length| start + length);
    let mut edits = vec![Edit::insert(tag_end(text, start), begin), Edit::insert(body_end, "</xacro:macro>\n")];
    if !robot.namespaces().any(|namespace| namespace.name() == Some("xacro")) {
        edits.push(Edit::insert(name_end(robot, text), format!(" xmlns:xacro=\"{XACRO}\"")));
    }
    edits
}

/// A robot's name as that of a macro.
fn macro_name(robot: &str) -> String {
    let name: String = robot.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let is_good = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') && !RESERVED.contains(&&*name);
    if is_good { name } else { format!("robot_{name}") }
}

/// Whether the `name` of an element is to be unique in a cell; `top` is the child of the robot that
/// contains it or is it.
fn has_prefixed_name(element: &Node<'_, '_>, top: &str) -> bool {
    let tag = element.tag_name().name();
    let is_top = element.parent_element().is_some_and(|parent| parent == element.document().root_element());
    match top {
        _ if is_top => ["link", "joint", "material", "transmission", "ros2_control", "sensor"].contains(&tag),
        "link" => tag == "material",
        "transmission" | "ros2_control" => {
            tag.to_ascii_lowercase().ends_with("joint") || ["actuator", "sensor", "gpio"].contains(&tag)
        }
        _ => false,
    }
}

/// The prefix of a link or joint whose name is all that the element contains.
fn reference_in_text(element: &Node<'_, '_>, names: &HashSet<&str>, text: &str) -> Option<Edit> {
    let only = element.first_child().filter(|child| child.is_text() && child.next_sibling().is_none())?;
    let is_reference = only.text().is_some_and(|name| names.contains(name.trim()));
    let raw = slice(text, only.range());
    let begins = raw.len() - raw.trim_start().len();
    // xacro leaves CDATA as it is.
    let is_plain = !slice(text, element.range()).contains("<![CDATA[");
    (is_reference && is_plain).then(|| Edit::insert(only.range().start + begins, PREFIX))
}

/// Escapes the dollar signs in a range of the text that xacro would evaluate: a run of them before
/// a brace or parenthesis takes one more, and xacro refuses other runs of more than one.
fn escape(text: &str, range: Range<usize>, edits: &mut Vec<Edit>) {
    let raw = slice(text, range.clone());
    let mut at = 0;
    while at < raw.len() {
        let start = at;
        let mut count = 0;
        while let Some(length) = begins_with(slice(raw, at..raw.len()), &['$']) {
            (at, count) = (at + length, count + 1);
        }
        if count == 0 {
            at += slice(raw, at..raw.len()).chars().next().map_or(1, char::len_utf8);
            continue;
        }
        let with = match begins_with(slice(raw, at..raw.len()), &['{', '(']) {
            Some(_) => "$".repeat(count + 1),
            None if count > 1 => DOLLAR.repeat(count - 1) + "$",
            None => continue,
        };
        edits.push(Edit { range: range.start + start..range.start + at, with });
    }
}

/// Bytes that the first character takes, as itself or by its number, if it is one of `characters`.
fn begins_with(raw: &str, characters: &[char]) -> Option<usize> {
    if raw.starts_with(characters) {
        return Some(1);
    }
    let digits = raw.strip_prefix("&#")?.split_once(';')?.0;
    let code = match digits.strip_prefix('x') {
        Some(hexadecimal) => u32::from_str_radix(hexadecimal, 16).ok()?,
        None => digits.parse().ok()?,
    };
    char::from_u32(code).filter(|c| characters.contains(c)).map(|_| digits.len() + 3)
}

/// The ranges of text between tags, of well-formed XML: without comments and CDATA, which xacro
/// leaves as they are.
fn character_data(text: &str) -> Vec<Range<usize>> {
    const CLOSED: [(&str, &str); 3] = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")];
    let mut ranges = Vec::new();
    let mut at = 0;
    while let Some(length) = slice(text, at..text.len()).find('<') {
        let start = at + length;
        ranges.push(at..start);
        let rest = slice(text, start..text.len());
        let closing = CLOSED.iter().find(|(opening, _)| rest.starts_with(opening));
        at = match closing {
            Some((opening, closing)) => {
                let inside = slice(rest, opening.len()..rest.len());
                inside.find(closing).map_or(text.len(), |end| start + opening.len() + end + closing.len())
            }
            None => tag_end(text, start),
        };
    }
    ranges
}

/// Where the tag that begins at `start` ends.
fn tag_end(text: &str, start: usize) -> usize {
    let mut quote = None;
    for (k, c) in slice(text, start..text.len()).char_indices() {
        match (quote, c) {
            (None, '>') => return start + k + 1,
            (None, '"' | '\'') => quote = Some(c),
            (Some(opening), c) if c == opening => quote = None,
            _ => {}
        }
    }
    text.len()
}
