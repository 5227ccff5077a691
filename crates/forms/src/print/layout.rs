//! Joining the parts of a form.

/// Returns `(head part..)`, with empty parts left out.
pub fn list_text(head: &str, parts: impl IntoIterator<Item = String>) -> String {
    let mut text = format!("({head}");
    for part in parts.into_iter().filter(|part| !part.is_empty()) {
        if text.len() > 1 {
            text.push(' ');
        }
        text.push_str(&part);
    }
    text.push(')');
    text
}

/// Returns the parts joined by blanks.
pub fn joined(parts: impl IntoIterator<Item = String>) -> String {
    parts.into_iter().collect::<Vec<_>>().join(" ")
}
