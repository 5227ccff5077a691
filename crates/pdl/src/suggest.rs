//! "Did you mean": the nearest known name by edit distance.

/// Characters beyond which names are not compared: keeps a message cheap whatever the input.
const NAME_CHARACTERS_MAX: usize = 64;

/// The known name nearest to `name`, if it is near enough to be meant. Ties go to the first.
pub(crate) fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let wanted: Vec<char> = name.to_lowercase().chars().take(NAME_CHARACTERS_MAX + 1).collect();
    if wanted.is_empty() || wanted.len() > NAME_CHARACTERS_MAX {
        return None;
    }
    let allowed = (wanted.len() / 3).clamp(1, 4);
    let mut best: Option<(usize, &str)> = None;
    for candidate in known {
        let letters: Vec<char> = candidate.to_lowercase().chars().take(NAME_CHARACTERS_MAX + 1).collect();
        if letters.len().abs_diff(wanted.len()) > allowed {
            continue;
        }
        let distance = distance(&wanted, &letters);
        if distance > 0 && distance <= allowed && best.is_none_or(|(least, _)| distance < least) {
            best = Some((distance, candidate));
        }
    }
    best.map(|(_, candidate)| candidate)
}

/// `did you mean `x`?` for the nearest known name.
pub(crate) fn did_you_mean<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    nearest(name, known).map(|found| format!("did you mean `{found}`?"))
}

/// Edits (insert, delete, replace, swap of neighbours) that turn `a` into `b`.
fn distance(a: &[char], b: &[char]) -> usize {
    let mut before: Vec<usize> = Vec::new();
    let mut above: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut row = vec![i + 1];
        for (j, y) in b.iter().enumerate() {
            let up = above.get(j + 1).copied().unwrap_or(0);
            let diagonal = above.get(j).copied().unwrap_or(0);
            let left = row.last().copied().unwrap_or(0);
            let mut cost = (up + 1).min(left + 1).min(diagonal + usize::from(x != y));
            let swapped = i > 0 && j > 0 && a.get(i - 1) == Some(y) && b.get(j - 1) == Some(x);
            if swapped && x != y {
                cost = cost.min(before.get(j - 1).copied().unwrap_or(0) + 1);
            }
            row.push(cost);
        }
        before = std::mem::replace(&mut above, row);
    }
    above.last().copied().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_names_are_found_and_far_ones_are_not() {
        assert_eq!(nearest("witfor", ["waitfor", "select"]), Some("waitfor"));
        assert_eq!(nearest("wiatfor", ["select", "waitfor"]), Some("waitfor"));
        assert_eq!(nearest("camera", ["waitfor", "select"]), None);
        assert_eq!(nearest("", ["a"]), None);
    }
}
