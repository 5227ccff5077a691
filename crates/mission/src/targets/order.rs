//! The order that targets require by `after`.

/// Returns the ids from a target through those that it comes after, back to itself; `None` if it does not come after itself. `after`
/// returns the ids that a target names.
pub(super) fn circle(id: &str, after: impl Fn(&str) -> Vec<String>) -> Option<Vec<String>> {
    let mut paths = vec![vec![id.to_string()]];
    let mut seen: Vec<String> = Vec::new();
    while let Some(path) = paths.pop() {
        for before in after(path.last()?) {
            let longer = [path.as_slice(), std::slice::from_ref(&before)].concat();
            if before == id {
                return Some(longer);
            }
            if !seen.contains(&before) {
                seen.push(before);
                paths.push(longer);
            }
        }
    }
    None
}
