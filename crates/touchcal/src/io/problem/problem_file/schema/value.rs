//! Values with their place in the file.

use toml::Spanned;

/// A number with its place in the file.
pub(crate) type Number = Spanned<f64>;
/// A text with its place in the file.
pub(crate) type Text = Spanned<String>;
