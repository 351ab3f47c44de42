//! The page's template with its style, scripts and data put in.

/// Marks in the template, and what stands in their place.
const PARTS: [(&str, &str); 6] = [
    ("/*page.css*/", include_str!("page.css")),
    ("/*plot.js*/", include_str!("vendor/plot.min.js")),
    ("/*three.js*/", include_str!("vendor/three.min.js")),
    ("/*text.js*/", include_str!("text.js")),
    ("/*charts.js*/", include_str!("charts.js")),
    ("/*arm.js*/", include_str!("arm.js")),
];

/// The page that shows `data`, JSON.
///
/// `<` is written `\u003c`: no text that was read from a file can end the element that holds it.
pub(super) fn page(data: &str) -> String {
    let data = data.replace('<', "\\u003c");
    let mut page = String::new();
    let mut rest = include_str!("page.html");
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
