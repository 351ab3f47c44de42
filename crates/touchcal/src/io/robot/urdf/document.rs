//! A URDF as XML: well-formed, a robot, and not xacro.

use roxmltree::{Document, Error, Node, ParsingOptions};

use crate::io::base::error::{IoError, Place, quoted};
use crate::io::base::xml::check_structure;

/// Most XML nodes accepted. A large robot has tens of thousands; each takes some 100 bytes of
/// memory.
const MAX_NODES: u32 = 10_000_000;
/// Largest coordinate (m), angle (rad), mass (kg) or compliance (rad/(N m)), far beyond those of
/// any arm.
pub(super) const LARGEST: f64 = 1e3;
/// Namespaces of xacro, old and new, begin so.
pub(super) const XACRO: &str = "http://www.ros.org/wiki/xacro";
/// How to get rid of xacro.
const EXPAND: &str = "xacro, which must be expanded first: run `xacro file.xacro > file.urdf`";

/// Parses the XML.
pub(super) fn parse<'t>(text: &'t str, file: &str) -> Result<Document<'t>, IoError> {
    check_structure(text, file)?;
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).map_err(|error| {
        let position = error.pos();
        let place = Place {
            file: file.to_owned(),
            line: Some(u64::from(position.row)),
            column: Some(u64::from(position.col)),
            field: None,
        };
        match error {
            Error::UnknownNamespace(prefix, _) if prefix == "xacro" => IoError::unexpected(place, "plain URDF", EXPAND),
            error => IoError::syntax(place, format!("not well-formed XML: {error}")),
        }
    })
}

/// The `<robot>` element.
pub(super) fn robot_element<'a, 't>(document: &'a Document<'t>, file: &str) -> Result<Node<'a, 't>, IoError> {
    let root = document.root_element();
    if let Some(macro_use) = document.descendants().find(|node| is_xacro(node)) {
        return Err(IoError::unexpected(place(&macro_use, file), "plain URDF", EXPAND));
    }
    if root.tag_name().name() != "robot" {
        let found = format!("<{}>", root.tag_name().name());
        return Err(IoError::unexpected(place(&root, file), "URDF, whose outermost element is <robot>", found));
    }
    Ok(root)
}

fn is_xacro(node: &Node<'_, '_>) -> bool {
    node.is_element() && node.tag_name().namespace().is_some_and(|uri| uri.trim_end_matches('/').ends_with("xacro"))
        || node.is_element() && node.tag_name().namespace().is_some_and(|uri| uri.starts_with(XACRO))
}

/// Where an element begins.
pub(super) fn place(node: &Node<'_, '_>, file: &str) -> Place {
    Place::file(file).at_byte(node.document().input_text(), node.range().start)
}

/// The first child element of that name.
pub(super) fn child<'a, 't>(node: &Node<'a, 't>, name: &str) -> Option<Node<'a, 't>> {
    children(node, name).next()
}

/// All child elements of that name.
pub(super) fn children<'a, 't, 'n>(
    node: &Node<'a, 't>,
    name: &'n str,
) -> impl Iterator<Item = Node<'a, 't>> + use<'a, 't, 'n> {
    node.children().filter(move |child| child.is_element() && child.tag_name().name() == name)
}

/// An attribute that must be there.
pub(super) fn attribute<'a>(node: &Node<'a, '_>, name: &str, file: &str) -> Result<&'a str, IoError> {
    let expected = || format!("attribute `{name}` of <{}>", node.tag_name().name());
    let Some(value) = node.attribute(name) else {
        return Err(IoError::unexpected(place(node, file), expected(), "none"));
    };
    match value.chars().find(|c| c.is_control()) {
        Some(control) => {
            let expected = format!("{} without control characters", expected());
            Err(IoError::unexpected(place(node, file), expected, format!("{control:?}")))
        }
        None => Ok(value),
    }
}

/// The numbers of an attribute, or nothing if it is absent; none may be larger than `largest`.
pub(super) fn numbers<const N: usize>(
    node: &Node<'_, '_>,
    (name, largest): (&str, f64),
    place: impl FnOnce() -> Place,
) -> Result<Option<[f64; N]>, IoError> {
    let Some(text) = node.attribute(name) else { return Ok(None) };
    let mut numbers = [0.0; N];
    let mut words = text.split_ascii_whitespace();
    let complete = numbers.iter_mut().all(|number| match words.next().and_then(|word| word.parse::<f64>().ok()) {
        Some(value) if value.is_finite() => {
            *number = value;
            true
        }
        _ => false,
    });
    if complete && words.next().is_none() {
        if numbers.iter().all(|number| number.abs() <= largest) {
            return Ok(Some(numbers));
        }
        return Err(IoError::unexpected(place(), format!("numbers within ±{largest} in `{name}`"), quoted(text)));
    }
    let expected = match N {
        1 => format!("a finite number in `{name}`"),
        _ => format!("{N} finite numbers in `{name}`"),
    };
    let found = if text.contains("${") { format!("{}: {EXPAND}", quoted(text)) } else { quoted(text) };
    Err(IoError::unexpected(place(), expected, found))
}
