//! The order that targets require by `after`.

use super::{Target, TargetKind};

/// Returns the ids from a target through the targets that it comes after, back to itself; `None` if it does not come after itself.
pub(super) fn circle_of_order(targets: &[Target], id: &str) -> Option<Vec<String>> {
    let mut paths = vec![vec![id.to_string()]];
    let mut seen: Vec<String> = Vec::new();
    while let Some(path) = paths.pop() {
        let last = path.last()?;
        let before = targets.iter().filter(|target| target.id == *last).filter_map(|target| match &target.kind {
            TargetKind::Fire(fire) => Some(&fire.wanted.after),
            _ => None,
        });
        for need in before.flatten() {
            let longer = [path.as_slice(), std::slice::from_ref(&need.target)].concat();
            if need.target == id {
                return Some(longer);
            }
            if !seen.contains(&need.target) {
                seen.push(need.target.clone());
                paths.push(longer);
            }
        }
    }
    None
}
