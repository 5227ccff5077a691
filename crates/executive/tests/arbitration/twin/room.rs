//! Free capacity: which claims fit together, which task keeps its place in the queue, and when a refused task can begin.

use super::{Awaited, State, Twin};

impl Twin {
    /// Returns the tasks that were refused before `task` and keep their place. Excluded are relatives and, if no task has to yield, tasks
    /// that cannot begin before `task` ends.
    pub(super) fn counts(&self, task: usize, awaited: &[Awaited], fills_gaps: bool) -> Vec<usize> {
        let done = self.nodes[task].expected.map(|expected| i64::from(self.now + expected));
        let in_gap = |each: &Awaited| fills_gaps && done.zip(each.earliest).is_some_and(|(done, begin)| done <= begin);
        awaited.iter().filter(|each| !self.related(task, each.task) && !in_gap(each)).map(|each| each.task).collect()
    }

    /// Returns the earliest instant at which a refused task can begin: the first end of a task that blocks the resource it lacks first,
    /// if all of these tasks state their ends.
    pub(super) fn earliest(
        &self,
        task: usize,
        working: &[usize],
        counts: &[usize],
        awaited: &[Awaited],
    ) -> Option<i64> {
        let uses = [working, counts].concat();
        let which = (0..4).find(|which| !self.fits(task, *which, &uses))?;
        let strangers: Vec<usize> =
            uses.iter().copied().filter(|each| self.needs[*each][which] > 0.0 && !self.related(task, *each)).collect();
        let all = self.used(&uses, which);
        let matters = |each: &usize| {
            let others: Vec<usize> = uses.iter().copied().filter(|other| other != each).collect();
            self.used(&others, which) + 1e-9 < all
        };
        let some: Vec<usize> = strangers.iter().copied().filter(matters).collect();
        let rivals = if some.is_empty() { strangers } else { some };
        let done = |rival: usize| match awaited.iter().find(|each| each.task == rival) {
            Some(waits) => waits.earliest,
            None => {
                let now = if self.states[rival] == State::Ongoing { self.now - self.since[rival] } else { 0 };
                let worked = i64::from(self.worked[rival] + now);
                Some(i64::from(self.now) + i64::from(self.nodes[rival].expected?) - worked)
            }
        };
        let ends: Option<Vec<i64>> = rivals.into_iter().map(done).collect();
        ends?.into_iter().min()
    }

    /// Returns true if the task's need of this resource fits, or stays within the share of its family.
    pub(super) fn fits(&self, task: usize, which: usize, uses: &[usize]) -> bool {
        let before = self.used(uses, which);
        let after = self.used(&[uses, &[task]].concat(), which);
        self.needs[task][which] == 0.0 || after <= self.totals[which] + 1e-9 || after <= before + 1e-9
    }

    /// Returns the used amount: a task and its descendants share one amount, unrelated uses add up.
    fn used(&self, users: &[usize], which: usize) -> f64 {
        let children =
            |parent: Option<usize>| (0..self.nodes.len()).filter(move |each| self.nodes[*each].parent == parent);
        fn family(twin: &Twin, users: &[usize], which: usize, task: usize) -> f64 {
            let own = if users.contains(&task) { twin.needs[task][which] } else { 0.0 };
            let below = (0..twin.nodes.len()).filter(|each| twin.nodes[*each].parent == Some(task));
            own.max(below.map(|each| family(twin, users, which, each)).sum())
        }
        children(None).map(|task| family(self, users, which, task)).sum()
    }
}
