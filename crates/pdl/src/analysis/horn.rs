//! Horn clauses: nodes that become true when enough of their premises are. Least solution, in linear time.

/// A node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct HornAtom(u32);

/// Nodes with the number of premises that they still need, and the conclusions of each premise.
#[derive(Default)]
pub(crate) struct Horn {
    needs: Vec<u32>,
    rules: Vec<(u32, u32)>,
}

impl Horn {
    /// Returns a node that is true from the start.
    pub(crate) fn fact(&mut self) -> HornAtom {
        self.node(0)
    }

    /// Returns a node that is true if one of its premises is; without premises it is false.
    pub(crate) fn any(&mut self) -> HornAtom {
        self.node(1)
    }

    /// Returns a node that is true when `count` premises are.
    pub(crate) fn all(&mut self, count: usize) -> HornAtom {
        self.node(u32::try_from(count).unwrap_or(u32::MAX))
    }

    fn node(&mut self, needs: u32) -> HornAtom {
        self.needs.push(needs);
        HornAtom(u32::try_from(self.needs.len() - 1).unwrap_or(u32::MAX))
    }

    /// Adds the rule that `premise` serves `conclusion`.
    pub(crate) fn rule(&mut self, premise: HornAtom, conclusion: HornAtom) {
        self.rules.push((premise.0, conclusion.0));
    }

    /// Solves the clauses.
    pub(crate) fn solve(mut self) -> Solution {
        let (first, served) = self.by_premise();
        let mut is_true: Vec<bool> = self.needs.iter().map(|needs| *needs == 0).collect();
        let mut open: Vec<u32> =
            (0..).zip(&is_true).filter_map(|(node, is_true): (u32, _)| is_true.then_some(node)).collect();
        while let Some(node) = open.pop() {
            let node = index(node);
            let (Some(from), Some(to)) = (first.get(node), first.get(node + 1)) else { continue };
            for conclusion in served.get(index(*from)..index(*to)).unwrap_or_default() {
                let at = index(*conclusion);
                let (Some(needs), Some(known)) = (self.needs.get_mut(at), is_true.get_mut(at)) else { continue };
                *needs = needs.saturating_sub(1);
                if *needs == 0 && !*known {
                    *known = true;
                    open.push(*conclusion);
                }
            }
        }
        Solution(is_true)
    }

    /// Returns the conclusions of the rules, grouped by premise, and the index at which each group begins, with one more entry than there
    /// are nodes.
    fn by_premise(&self) -> (Vec<u32>, Vec<u32>) {
        // Counts are stored one index later, so that their prefix sums are the beginnings of the groups.
        let mut first = vec![0_u32; self.needs.len() + 1];
        for (premise, _) in &self.rules {
            if let Some(count) = first.get_mut(index(*premise) + 1) {
                *count += 1;
            }
        }
        let mut total = 0;
        for count in &mut first {
            total += *count;
            *count = total;
        }
        let mut next = first.clone();
        let mut served = vec![0; self.rules.len()];
        for (premise, conclusion) in &self.rules {
            let Some(place) = next.get_mut(index(*premise)) else { continue };
            if let Some(entry) = served.get_mut(index(*place)) {
                *entry = *conclusion;
            }
            *place += 1;
        }
        (first, served)
    }
}

fn index(number: u32) -> usize {
    usize::try_from(number).unwrap_or(usize::MAX)
}

/// True nodes of a solved [`Horn`].
pub(crate) struct Solution(Vec<bool>);

impl Solution {
    /// Returns true if `node` is true.
    pub(crate) fn holds(&self, node: HornAtom) -> bool {
        self.0.get(index(node.0)).copied().unwrap_or(false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Solves the clauses as they are defined: applies every rule until nothing changes.
    fn naive(needs: &[u32], rules: &[(u32, u32)]) -> Vec<bool> {
        let mut is_true: Vec<bool> = needs.iter().map(|needs| *needs == 0).collect();
        loop {
            let met = |node: usize, is_true: &[bool]| {
                rules.iter().filter(|(from, to)| *to as usize == node && is_true[*from as usize]).count()
            };
            let next: Vec<bool> =
                needs.iter().enumerate().map(|(node, needs)| met(node, &is_true) >= *needs as usize).collect();
            if next == is_true {
                return is_true;
            }
            is_true = next;
        }
    }

    proptest! {
        #[test]
        fn solving_equals_the_definition(
            needs in prop::collection::vec(0u32..3, 1..12),
            pairs in prop::collection::vec((0u32..12, 0u32..12), 0..40),
        ) {
            let count = u32::try_from(needs.len()).unwrap_or(1);
            let rules: Vec<(u32, u32)> = pairs.iter().map(|(a, b)| (a % count, b % count)).collect();
            let expected = naive(&needs, &rules);
            let solution = Horn { needs, rules }.solve();
            prop_assert_eq!(solution.0, expected);
        }
    }
}
