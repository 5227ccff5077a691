//! What follows from what: nodes that become true when enough of their premises are. Least solution, in linear time.

/// A node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Node(u32);

/// Nodes with the premises that they still need, and which premise serves which node.
#[derive(Default)]
pub(crate) struct Horn {
    needs: Vec<u32>,
    rules: Vec<(u32, u32)>,
}

impl Horn {
    /// A node that is true from the start.
    pub(crate) fn fact(&mut self) -> Node {
        self.node(0)
    }

    /// A node that is true when one of its premises is; without any it never is.
    pub(crate) fn any(&mut self) -> Node {
        self.node(1)
    }

    /// A node that is true when `count` premises are.
    pub(crate) fn all(&mut self, count: usize) -> Node {
        self.node(u32::try_from(count).unwrap_or(u32::MAX))
    }

    fn node(&mut self, needs: u32) -> Node {
        self.needs.push(needs);
        Node(u32::try_from(self.needs.len() - 1).unwrap_or(u32::MAX))
    }

    /// `premise` serves `conclusion`.
    pub(crate) fn rule(&mut self, premise: Node, conclusion: Node) {
        self.rules.push((premise.0, conclusion.0));
    }

    /// Which nodes are true.
    pub(crate) fn solve(mut self) -> Solution {
        self.rules.sort_unstable();
        let mut is_true: Vec<bool> = self.needs.iter().map(|needs| *needs == 0).collect();
        let mut open: Vec<u32> =
            (0..).zip(&is_true).filter_map(|(node, is_true): (u32, _)| is_true.then_some(node)).collect();
        while let Some(node) = open.pop() {
            let first = self.rules.partition_point(|(premise, _)| *premise < node);
            let served = self.rules.iter().skip(first).take_while(|(premise, _)| *premise == node);
            for (_, conclusion) in served {
                let index = usize::try_from(*conclusion).unwrap_or(usize::MAX);
                let (Some(needs), Some(known)) = (self.needs.get_mut(index), is_true.get_mut(index)) else { continue };
                *needs = needs.saturating_sub(1);
                if *needs == 0 && !*known {
                    *known = true;
                    open.push(*conclusion);
                }
            }
        }
        Solution(is_true)
    }
}

/// Which nodes of a solved [`Horn`] are true.
pub(crate) struct Solution(Vec<bool>);

impl Solution {
    /// Is `node` true?
    pub(crate) fn holds(&self, node: Node) -> bool {
        usize::try_from(node.0).ok().and_then(|index| self.0.get(index)).copied().unwrap_or(false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The definition: apply every rule until nothing changes.
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
