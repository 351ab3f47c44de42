//! Bounds on the structure of XML, checked before it is parsed.

use quick_xml::Reader;
use quick_xml::events::Event;

use super::error::{IoError, Place};

/// Most attributes of an element, declarations of namespaces in a file, and elements within each
/// other. Robots and drawings have some dozens of each; the time of the parser, or of what follows,
/// grows with their square.
const MAX_ATTRIBUTES: usize = 1000;
const MAX_NAMESPACES: usize = 1000;
const MAX_DEPTH: usize = 200;

/// Refuses text with more attributes, namespaces or depth than any robot or drawing has. Text that
/// is not well-formed is left to the parser.
pub(crate) fn check_structure(text: &str, file: &str) -> Result<(), IoError> {
    let mut reader = Reader::from_str(text);
    let (mut depth, mut namespaces) = (0_usize, 0);
    loop {
        let start = reader.buffer_position() as usize;
        let Ok(event) = reader.read_event() else { return Ok(()) };
        let element = match &event {
            Event::Start(element) | Event::Empty(element) => element,
            Event::End(_) => {
                depth = depth.saturating_sub(1);
                continue;
            }
            Event::DocType(declarations) if has_markup(declarations.as_bytes()) => {
                let place = Place::file(file).at_byte(text, start);
                return Err(IoError::unexpected(place, "entities without elements", "some with"));
            }
            Event::Eof => return Ok(()),
            _ => continue,
        };
        depth += usize::from(matches!(event, Event::Start(_)));
        let mut attributes = 0;
        for attribute in element.attributes().with_checks(false).flatten().take(MAX_ATTRIBUTES + 1) {
            attributes += 1;
            namespaces += usize::from(attribute.key.as_namespace_binding().is_some());
        }
        let bounds = [
            (attributes, MAX_ATTRIBUTES, "attributes of an element"),
            (namespaces, MAX_NAMESPACES, "declarations of namespaces"),
            (depth, MAX_DEPTH, "elements within each other"),
        ];
        if let Some((_, most, of)) = bounds.iter().find(|(found, most, _)| found > most) {
            let place = Place::file(file).at_byte(text, start);
            return Err(IoError::unexpected(place, format!("at most {most} {of}"), "more"));
        }
    }
}

/// Whether entities may have elements, which count where the entities are named.
fn has_markup(declarations: &[u8]) -> bool {
    let begins = |pair: &[u8]| pair[0] == b'<' && pair[1] != b'!' && pair[1] != b'?' || pair == b"&#";
    declarations.windows(2).any(begins)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn structure_beyond_any_robot_is_refused() {
        let nested = |depth: usize| format!("<r>\n{}{}</r>", "<g>".repeat(depth), "</g>".repeat(depth));
        let attributes = |count: usize, name: &str| {
            let each: Vec<String> = (0..count).map(|k| format!(" {name}{k}='http://a/{k}>'")).collect();
            format!("<!-- <r> --><r>\n<a{}/></r>", each.concat())
        };
        let message = |text: &str| check_structure(text, "f").map_err(|error| error.to_string());
        assert_eq!(message(&nested(MAX_DEPTH - 1)), Ok(()));
        let expected = "f:2:598: expected at most 200 elements within each other, found more";
        assert_eq!(message(&nested(MAX_DEPTH)), Err(expected.to_owned()));
        assert_eq!(message(&attributes(MAX_ATTRIBUTES, "b")), Ok(()));
        let expected = "f:2:1: expected at most 1000 attributes of an element, found more";
        assert_eq!(message(&attributes(MAX_ATTRIBUTES + 1, "b")), Err(expected.to_owned()));
        let expected = "f:4:1: expected at most 1000 declarations of namespaces, found more";
        let declared = attributes(600, "xmlns:b");
        let entity = |value: &str| format!("<!DOCTYPE r [<!ENTITY e \"{value}\">]><r>&e;</r>");
        assert_eq!(message(&entity("http://a")), Ok(()));
        for value in ["<g/>", "&#60;g/>"] {
            assert_eq!(
                message(&entity(value)),
                Err("f:1:1: expected entities without elements, found some with".to_owned())
            );
        }
        let twice = format!("<s>\n{declared}{declared}</s>");
        assert_eq!(message(&twice), Err(expected.to_owned()));
    }
}
