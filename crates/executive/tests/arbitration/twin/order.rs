//! Order of tasks in the naive twin: precedence by rank with inherited priority, and the order in which holders yield.

use super::Twin;

impl Twin {
    /// Returns true if `a` precedes `b` by its rank.
    pub(super) fn goes_before(&self, a: usize, b: usize) -> bool {
        !self.related(a, b) && self.share(a, b) && self.before_by_rank(a, b) == Some(true)
    }

    /// Returns the greatest priority of the task and of all tasks that it precedes.
    pub(super) fn weight(&self, task: usize, all: &[usize]) -> f64 {
        let mut behind = vec![task];
        while let Some(more) = all
            .iter()
            .find(|each| !behind.contains(each) && behind.iter().any(|ahead| self.goes_before(*ahead, **each)))
        {
            behind.push(*more);
        }
        behind.into_iter().map(|each| self.priority(each)).fold(f64::MIN, f64::max)
    }

    /// Returns the tasks in the order of arbitration: repeatedly the best remaining task, after all remaining tasks that precede it.
    pub(super) fn order(&self, mut left: Vec<usize>) -> Vec<usize> {
        let all = left.clone();
        let better = |a: usize, b: usize| if self.key(b, &all) < self.key(a, &all) { b } else { a };
        let mut order = Vec::new();
        while let Some(mut next) = left.iter().copied().reduce(better) {
            while let Some(ahead) = left.iter().copied().filter(|each| self.goes_before(*each, next)).reduce(better) {
                next = ahead;
            }
            left.retain(|each| *each != next);
            order.push(next);
        }
        order
    }

    /// Orders holders by the order in which they yield: first tasks that precede no other one by rank, then those with the lowest
    /// defence, then the one that began last.
    pub(super) fn weakest_first(&self, mut holders: Vec<usize>, defence: &impl Fn(usize) -> f64) -> Vec<usize> {
        let mut ordered = Vec::new();
        while !holders.is_empty() {
            let weaker = |a: usize, b: usize| {
                let order = defence(a).total_cmp(&defence(b));
                order.then((self.since[b], self.born[b]).cmp(&(self.since[a], self.born[a]))).is_lt()
            };
            let beats_none =
                |task: &usize| holders.iter().all(|other| self.before_by_rank(*task, *other) != Some(true));
            let mut candidates: Vec<usize> = holders.iter().copied().filter(beats_none).collect();
            if candidates.is_empty() {
                candidates.clone_from(&holders);
            }
            let weakest = candidates.into_iter().reduce(|a, b| if weaker(b, a) { b } else { a });
            ordered.extend(weakest);
            holders.retain(|each| Some(*each) != weakest);
        }
        ordered
    }
}
