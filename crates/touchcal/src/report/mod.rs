//! A calibration as a page to look at: one HTML file that needs nothing else, in which numbers
//! become pictures.
//!
//! Everything counted is counted here, over all contacts; the page draws and words it, and shows SI
//! as millimetres and degrees. What it draws of single contacts is thinned to [`MOST_DRAWN`], so
//! the page of a million contacts is as small as that of three thousand. The same calibration gives
//! the same bytes.
//!
//! The data travel as JSON in a script element that is no script, in which `<` is written `\u003c`:
//! no name that was read from a file can end it. The page puts names into text nodes only, and its
//! policy (`Content-Security-Policy`) lets it load nothing from anywhere.

mod contacts;
mod content;
mod parameters;
mod scene;

pub use contacts::MOST_DRAWN;
pub use content::{Advice, Input};
#[cfg(feature = "mcap")]
pub(crate) use scene::{places, positions};

use crate::estimate::{Estimate, Problem, Progress, Score};
use content::Content;

/// What a report tells of.
#[derive(Clone, Copy, Debug)]
pub struct Report<'a> {
    /// What was asked.
    pub problem: &'a Problem,
    /// What came out.
    pub estimate: &'a Estimate,
    /// How well the nominal arm explains the contacts: [`evaluate`](crate::estimate::evaluate) of
    /// the problem.
    pub prefit: &'a Score,
    /// The estimation's steps, as its observer saw them.
    pub steps: &'a [Progress],
    /// What a user should know, the estimate's warnings and any others.
    pub warnings: &'a [Advice],
    /// Files that were read.
    pub inputs: &'a [Input],
}

/// Where the template wants its parts.
const PARTS: [(&str, &str); 6] = [
    ("/*page.css*/", include_str!("page.css")),
    ("/*plot.js*/", include_str!("vendor/plot.min.js")),
    ("/*three.js*/", include_str!("vendor/three.min.js")),
    ("/*text.js*/", include_str!("text.js")),
    ("/*charts.js*/", include_str!("charts.js")),
    ("/*arm.js*/", include_str!("arm.js")),
];

impl Report<'_> {
    /// The page.
    ///
    /// # Errors
    /// If the data cannot be said in JSON, which no calibration's are known to do: numbers that are
    /// not finite become null.
    pub fn html(&self) -> serde_json::Result<String> {
        let data = serde_json::to_string(&Content::new(self))?.replace('<', "\\u003c");
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
        Ok(page)
    }
}
