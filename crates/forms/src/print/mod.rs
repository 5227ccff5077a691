//! The printer of PDL forms: converts parsed forms back to flat PDL text.

mod condition;
mod cyclic;
mod expression;
mod layout;
mod style;
mod value;

pub use expression::form_text;
pub use layout::{joined, list_text};
pub use style::Style;
