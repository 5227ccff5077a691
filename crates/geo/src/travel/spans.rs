//! Intervals of a leg or of time: sorted, merged, without overlaps.

/// Beginning and end of an interval: of a leg in shares of its length, of time in seconds.
pub(crate) type Span = (f64, f64);

/// Sorts `spans` and merges those that overlap or touch within `gap`; empty intervals are dropped.
pub(crate) fn merged(mut spans: Vec<Span>, gap: f64) -> Vec<Span> {
    spans.retain(|(from, until)| until > from);
    spans.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut joined: Vec<Span> = Vec::with_capacity(spans.len());
    for (from, until) in spans {
        match joined.last_mut() {
            Some(last) if from <= last.1 + gap => last.1 = last.1.max(until),
            _ => joined.push((from, until)),
        }
    }
    joined
}

/// Returns the parts of `whole` that no span of the sorted, merged `taken` holds.
pub(crate) fn gaps(whole: Span, taken: &[Span]) -> Vec<Span> {
    let mut found = Vec::new();
    let mut from = whole.0;
    for (begin, end) in taken {
        if *begin > from {
            found.push((from, begin.min(whole.1)));
        }
        from = from.max(*end);
    }
    if from < whole.1 {
        found.push((from, whole.1));
    }
    found.retain(|(from, until)| until > from);
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_overlaps_is_joined_and_what_is_left_are_gaps() {
        let taken = merged(vec![(5.0, 6.0), (1.0, 2.0), (1.5, 3.0), (3.0, 3.5), (9.0, 9.0)], 0.0);
        assert_eq!(taken, [(1.0, 3.5), (5.0, 6.0)]);
        assert_eq!(gaps((0.0, 7.0), &taken), [(0.0, 1.0), (3.5, 5.0), (6.0, 7.0)]);
        assert_eq!(gaps((2.0, 3.0), &taken), []);
        assert_eq!(gaps((2.0, 3.0), &[]), [(2.0, 3.0)]);
    }
}
