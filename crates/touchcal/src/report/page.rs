//! The page's template with its style, scripts and data put in.

/// A page without its parts.
#[derive(Clone, Copy)]
pub(super) enum Template {
    /// Of a calibration.
    Calibration,
    /// Of an evaluation.
    Evaluation,
}

/// Marks in the templates, and what stands in their place.
const PARTS: [(&str, &str); 8] = [
    ("/*page.css*/", include_str!("page.css")),
    ("/*plot.js*/", include_str!("vendor/plot.min.js")),
    ("/*three.js*/", include_str!("vendor/three.min.js")),
    ("/*elements.js*/", include_str!("elements.js")),
    ("/*text.js*/", include_str!("text.js")),
    ("/*evaluation.js*/", include_str!("evaluation.js")),
    ("/*charts.js*/", include_str!("charts.js")),
    ("/*arm.js*/", include_str!("arm.js")),
];

/// The page that shows `data`, JSON.
///
/// `<` is written `\u003c`: no text that was read from a file can end the element that holds it.
pub(super) fn page(template: Template, data: &str) -> String {
    let data = data.replace('<', "\\u003c");
    let mut page = String::new();
    let mut rest = match template {
        Template::Calibration => include_str!("page.html"),
        Template::Evaluation => include_str!("evaluation.html"),
    };
    let parts = PARTS.into_iter().chain([("/*data*/", data.as_str())]);
    let mut parts: Vec<(usize, &str, &str)> =
        parts.filter_map(|(mark, part)| Some((rest.find(mark)?, mark, part))).collect();
    parts.sort_unstable_by_key(|(at, ..)| *at);
    // One pass from front to back: what a part contains is never taken for a mark.
    for (_, mark, part) in parts {
        if let Some((before, after)) = rest.split_once(mark) {
            page.push_str(before);
            page.push_str(part);
            rest = after;
        }
    }
    page.push_str(rest);
    page
}
