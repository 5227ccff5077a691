//! Arbitration of resources: all claimants of all resources compete in every round.

use crate::agent::Agent;
use crate::competition::Competition;
use crate::program::{Span, Time};
use crate::task::State;
use std::cmp::Ordering;

/// A share of a resource that counts against later claimants.
#[derive(Clone, PartialEq)]
struct Share {
    task: usize,
    resource: String,
    amount: f64,
    right: Right,
}

#[derive(Clone, Copy, PartialEq)]
enum Right {
    /// An ongoing task holds the share, and can lose it.
    Held,
    /// Granted to a claimant in this round.
    Granted,
    /// Claimed by an earlier claimant that was rejected and cannot begin before this instant, if that is known.
    Awaited(Option<Time>),
}

/// A lost conflict: loser, winner and resource.
#[derive(Clone)]
struct Loss {
    loser: usize,
    winner: usize,
    resource: String,
}

#[derive(Default)]
struct Field {
    shares: Vec<Share>,
    displaced: Vec<Loss>,
    granted: Vec<usize>,
    impossible: Vec<usize>,
    refused: Vec<usize>,
    /// All competitors, in the order in which the arbiter considers their claims.
    order: Vec<usize>,
}

impl Agent<'_> {
    /// Returns true if the task may work at all. It may not under a suspended ancestor, and no task begins below a task that does not work.
    pub(crate) fn is_eligible(&self, id: usize) -> bool {
        let task = &self.tasks[id];
        let starts = match task.state {
            State::Interrupted => true,
            State::Enabled => {
                let works =
                    |parent: usize| self.tasks[parent].state == State::Ongoing && !self.resuming.contains(&parent);
                (task.choice.is_some() || task.work.is_some()) && task.parent.is_none_or(works)
            }
            _ => false,
        };
        starts && !task.forgotten && !self.line(id).iter().any(|each| self.tasks[*each].suspended)
    }

    /// Arbitrates if the competition differs from the last one. The passing of time alone gives no task a resource: it only changes
    /// estimates of the earliest beginning.
    pub(crate) fn contend_and_commit(&mut self) {
        let competition = self.competition();
        if self.competed.as_ref() != Some(&competition) {
            self.competed = Some(competition);
            self.arbitrate();
        }
        self.resumed.clear();
    }

    fn competition(&self) -> Competition {
        let takes_part = |id: &usize| self.tasks[*id].state == State::Ongoing || self.is_eligible(*id);
        let ids: Vec<usize> = (0..self.tasks.len()).filter(takes_part).collect();
        let field = Field { order: ids.clone(), ..Field::default() };
        let mut strengths: Vec<(f64, bool, usize)> = Vec::new();
        for id in &ids {
            for claim in [self.priority(*id, self.now), self.weight(&field, *id)] {
                strengths.extend([(claim, false, *id), (claim + self.interrupt_cost(*id), true, *id)]);
            }
        }
        strengths.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut before = None;
        let order = strengths.into_iter().map(|(strength, defends, id)| {
            let equal = before.replace(strength) == Some(strength);
            (id, defends, equal)
        });
        let order = order.collect();
        let ranks = ids.iter().flat_map(|id| self.line(*id)).map(|id| (id, self.rank(id))).collect();
        let moved = |id: usize| self.moves.iter().filter(|each| each.task == id).count();
        let competitors = ids.iter().map(|id| (*id, moved(*id), self.tasks[*id].needs())).collect();
        Competition { competitors, order, ranks, totals: self.totals.clone() }
    }

    fn arbitrate(&mut self) {
        let mut orphans = Vec::new();
        loop {
            let field = self.contend(&orphans);
            // Steps of a task that stops working do not begin, so they do not compete.
            let stops = |id: usize| field.displaced.iter().any(|loss| loss.loser == id) && !field.granted.contains(&id);
            // A task without needs does not compete: whether it begins is decided once it is known which tasks stop.
            let competes = |id: usize| self.tasks[id].state == State::Enabled && !self.tasks[id].needs().is_empty();
            let orphan = |id: &&usize| competes(**id) && self.tasks[**id].parent.is_some_and(stops);
            let more: Vec<usize> = field.granted.iter().filter(orphan).copied().collect();
            let Some(last) = more.last().copied() else { return self.commit(field) };
            // A task whose parent stops only because of another orphan is decided once that orphan is gone.
            let only_for_orphan = |id: &usize| {
                let loss = field.displaced.iter().find(|loss| Some(loss.loser) == self.tasks[*id].parent);
                loss.is_some_and(|loss| more.contains(&loss.winner))
            };
            let certain: Vec<usize> = more.iter().filter(|id| !only_for_orphan(id)).copied().collect();
            // If each stops only because of another, the weakest of them stops.
            orphans.extend(if certain.is_empty() { vec![last] } else { certain });
        }
    }

    fn contend(&self, orphans: &[usize]) -> Field {
        let mut field = Field::default();
        for holder in self.ids(|task| task.state == State::Ongoing) {
            for (resource, amount) in self.tasks[holder].needs() {
                field.shares.push(Share { task: holder, resource, amount, right: Right::Held });
            }
        }
        let eligible = (0..self.tasks.len()).filter(|id| self.is_eligible(*id) && !orphans.contains(id));
        let mut claimants: Vec<usize> = eligible.collect();
        let holders = self.ids(|task| task.state == State::Ongoing);
        field.order = self.order(claimants.iter().copied().chain(holders).collect());
        while let Some(next) = field.order.iter().copied().find(|id| claimants.contains(id)) {
            claimants.retain(|id| *id != next);
            let lost = self.place(&mut field, next);
            claimants.extend(lost);
            if !field.granted.contains(&next) && !field.impossible.contains(&next) {
                field.refused.push(next);
            }
        }
        field
    }

    fn commit(&mut self, mut field: Field) {
        // Ancestors stop before their descendants, as in a suspension.
        field.displaced.sort_by_key(|loss| (self.line(loss.loser).len(), loss.loser));
        for loss in &field.displaced {
            self.stop(loss.loser, format!("outranked by T{} on {}", loss.winner, loss.resource));
        }
        for id in field.impossible {
            self.fail(id, "a resource is exhausted".into());
        }
        // Interrupted tasks come first, leaves before their ancestors; then new ones in written order.
        let mut granted = field.granted;
        granted.sort_by_key(|id| match self.tasks[*id].state {
            State::Interrupted => (0, usize::MAX - self.line(*id).len(), *id),
            _ => (1, 0, *id),
        });
        for id in granted {
            if self.is_eligible(id) {
                let reason = self.resumed.remove(&id).filter(|_| self.tasks[id].state == State::Interrupted);
                self.transition(id, State::Ongoing, None, reason.unwrap_or("granted".into()));
                self.starting.push(id);
            }
        }
        // A task that does not wait fails.
        let mut refused = field.refused;
        refused.sort_unstable();
        for id in refused {
            let refuses = self.tasks[id].choice.as_ref().is_some_and(|choice| choice.refuses);
            if refuses && self.tasks[id].state == State::Enabled {
                self.fail(id, "a resource is busy".into());
            }
        }
    }

    /// Compares by priority, then work that has begun, then written order among siblings and creation order among others.
    fn by_priority(&self, a: usize, b: usize, competitors: &[usize]) -> Ordering {
        let order = |id: usize| {
            let begun = self.goes_first(id, competitors);
            let step = match self.tasks[id].origin {
                crate::task::Origin::Step(_, step) => step,
                _ => 0,
            };
            // A repeated task that has had a turn comes after tasks that have not.
            let turn = self.line(id).into_iter().filter_map(|each| self.tasks[each].ended_before).max();
            (!begun, turn, self.tasks[id].parent.unwrap_or(id), step, id)
        };
        let (first, second) = (self.priority(a, self.now), self.priority(b, self.now));
        second.total_cmp(&first).then(order(a).cmp(&order(b)))
    }

    /// Returns true if, among equals, the task has precedence because its work has begun, and no task that has not begun outranks it.
    fn goes_first(&self, id: usize, competitors: &[usize]) -> bool {
        let mut ahead = competitors.iter().filter(|other| self.goes_before(**other, id));
        matches!(self.tasks[id].state, State::Ongoing | State::Interrupted)
            && ahead.all(|other| self.goes_first(*other, competitors))
    }

    /// Returns true if one task precedes the other by rank. Ranks apply only if both need the same resource.
    fn goes_before(&self, a: usize, b: usize) -> bool {
        let other = self.tasks[b].needs();
        let share = self.tasks[a].needs().iter().any(|(name, _)| other.iter().any(|(each, _)| each == name));
        share && !self.are_related(a, b) && self.ranks(a, b).is_some_and(|(first, second)| first < second)
    }

    /// Orders by priority, except that tasks with precedence by rank come first.
    fn order(&self, mut competitors: Vec<usize>) -> Vec<usize> {
        let all = competitors.clone();
        competitors.sort_by(|a, b| self.by_priority(*a, *b, &all));
        let mut order = Vec::new();
        for each in &competitors {
            self.put_in_order(*each, &competitors, &mut order);
        }
        order
    }

    fn put_in_order(&self, id: usize, competitors: &[usize], order: &mut Vec<usize>) {
        for other in competitors {
            if !order.contains(&id) && !order.contains(other) && self.goes_before(*other, id) {
                self.put_in_order(*other, competitors, order);
            }
        }
        if !order.contains(&id) {
            order.push(id);
        }
    }

    /// Returns the weight of a claimant: its weight or, if greater, the weight of a task that it precedes.
    fn weight(&self, field: &Field, id: usize) -> f64 {
        let mut counted = vec![id];
        let mut next = 0;
        while let Some(each) = counted.get(next).copied() {
            next += 1;
            let others = field.order.iter().filter(|other| !counted.contains(other) && self.goes_before(each, **other));
            let behind: Vec<usize> = others.copied().collect();
            counted.extend(behind);
        }
        counted.into_iter().map(|each| self.priority(each, self.now)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Returns the strength with which an ongoing task defends its resources.
    fn defence(&self, field: &Field, id: usize) -> f64 {
        self.weight(field, id) + self.interrupt_cost(id)
    }

    /// Gives the claimant all its needs or nothing. Returns the holders that lost: as few as possible, and stronger ones only if the
    /// weaker ones do not suffice.
    fn place(&self, field: &mut Field, id: usize) -> Vec<usize> {
        let needs = self.tasks[id].needs();
        let total = |resource: &String| self.totals.get(resource).copied().unwrap_or(1.0);
        if needs.iter().any(|(resource, amount)| *amount > total(resource)) {
            field.impossible.push(id);
            return Vec::new();
        }
        let lacking = |losses: &[Loss]| needs.iter().find(|need| !self.has_room(field, id, need, losses));
        let mut weakest_first = self.beaten(field, id).into_iter();
        let mut losses: Vec<Loss> = Vec::new();
        let mut refusal = None;
        while let Some((resource, _)) = lacking(&losses) {
            match weakest_first.next() {
                Some(loss) => losses.push(loss),
                None => {
                    refusal = Some(self.earliest(field, id, resource, &losses));
                    break;
                }
            }
        }
        let right = refusal.map_or(Right::Granted, Right::Awaited);
        if right == Right::Granted {
            for index in (0..losses.len()).rev() {
                let spared = losses.remove(index);
                if let Some((resource, _)) = lacking(&losses) {
                    // The loss concerns the amount that would be missing without it.
                    losses.insert(index, Loss { resource: resource.clone(), ..spared });
                }
            }
            let lost = |share: &Share| share.right == Right::Held && losses.iter().any(|loss| loss.loser == share.task);
            field.shares.retain(|share| !lost(share));
            field.granted.push(id);
        } else {
            losses.clear();
        }
        for (resource, amount) in needs {
            field.shares.push(Share { task: id, resource, amount, right });
        }
        let losers = losses.iter().map(|loss| loss.loser).collect();
        field.displaced.extend(losses);
        losers
    }

    /// Returns the shares of a resource that count against the claimant once the losers are gone.
    fn present<'f>(&self, field: &'f Field, id: usize, resource: &str, losses: &[Loss]) -> Vec<&'f Share> {
        let counts = |share: &&Share| match share.right {
            Right::Held => losses.iter().all(|loss| loss.loser != share.task),
            Right::Granted => true,
            // No task yields for the sake of a gap.
            Right::Awaited(_) => {
                !(self.are_related(share.task, id) || losses.is_empty() && self.leaves_a_gap(id, share))
            }
        };
        field.shares.iter().filter(|share| share.resource == resource).filter(counts).collect()
    }

    /// Returns the used amount: the greater of the task's own use and the sum of the tasks below it.
    fn used(&self, shares: &[(usize, f64)]) -> f64 {
        let above = |id: usize| {
            let holders = shares.iter().map(|(other, _)| *other).filter(|other| self.is_below(id, *other));
            holders.max_by_key(|other| self.line(*other).len())
        };
        let top = shares.iter().filter(|(id, _)| above(*id).is_none());
        top.map(|(id, amount)| {
            let inside: Vec<(usize, f64)> =
                shares.iter().copied().filter(|(other, _)| self.is_below(*other, *id)).collect();
            self.used(&inside).max(*amount)
        })
        .sum()
    }

    fn has_room(&self, field: &Field, id: usize, (resource, amount): &(String, f64), losses: &[Loss]) -> bool {
        const TOLERANCE: f64 = 1e-9;
        let total = self.totals.get(resource).copied().unwrap_or(1.0);
        let present = self.present(field, id, resource, losses);
        let mut shares: Vec<(usize, f64)> = present.iter().map(|share| (share.task, share.amount)).collect();
        let before = if shares.is_empty() { 0.0 } else { self.used(&shares) };
        shares.push((id, *amount));
        let after = self.used(&shares);
        after <= total + TOLERANCE || !present.is_empty() && after <= before + TOLERANCE
    }

    /// Returns all holders that the claimant beats, the weakest first: by rank, then by the strength of defence, then by the time for
    /// which they have worked.
    fn beaten(&self, field: &Field, id: usize) -> Vec<Loss> {
        let mut found: Vec<Loss> = Vec::new();
        for (resource, _) in self.tasks[id].needs() {
            for share in field.shares.iter().filter(|share| share.resource == resource && share.right == Right::Held) {
                let known = found.iter().any(|loss| loss.loser == share.task);
                if !known && !self.are_related(share.task, id) && self.wins(field, id, share.task) {
                    found.push(Loss { loser: share.task, winner: id, resource: resource.clone() });
                }
            }
        }
        let since = |id: usize| self.moves.iter().rev().find(|each| each.task == id).map_or(0, |each| each.at);
        found.sort_by(|a, b| {
            let (first, second) = (self.defence(field, a.loser), self.defence(field, b.loser));
            first.total_cmp(&second).then((since(b.loser), b.loser).cmp(&(since(a.loser), a.loser)))
        });
        let mut ordered = Vec::new();
        while !found.is_empty() {
            let beats = |a: &Loss, b: &Loss| self.ranks(a.loser, b.loser).is_some_and(|(first, second)| first < second);
            let weakest = found.iter().position(|loss| !found.iter().any(|other| beats(loss, other))).unwrap_or(0);
            ordered.push(found.remove(weakest));
        }
        ordered
    }

    /// Returns true if a claimant beats a holder.
    fn wins(&self, field: &Field, id: usize, holder: usize) -> bool {
        match self.ranks(id, holder) {
            Some((own, other)) => own < other,
            None => self.weight(field, id) > self.defence(field, holder),
        }
    }

    /// Returns the earliest instant at which a rejected claimant can begin: the first end of a conflicting task, if all their ends are
    /// known.
    fn earliest(&self, field: &Field, id: usize, resource: &str, losses: &[Loss]) -> Option<Time> {
        let present = self.present(field, id, resource, losses);
        let amounts = |shares: &[&Share]| shares.iter().map(|share| (share.task, share.amount)).collect::<Vec<_>>();
        let all = self.used(&amounts(&present));
        let matters = |share: &&&Share| {
            let others: Vec<&Share> = present.iter().copied().filter(|other| other.task != share.task).collect();
            self.used(&amounts(&others)) + 1e-9 < all
        };
        let strangers: Vec<&Share> =
            present.iter().copied().filter(|share| !self.are_related(share.task, id)).collect();
        let mattering: Vec<&Share> = strangers.iter().filter(matters).copied().collect();
        let rivals = if mattering.is_empty() { strangers } else { mattering };
        let done = |share: &Share| match share.right {
            Right::Awaited(earliest) => earliest,
            Right::Held | Right::Granted => {
                let expected = self.tasks[share.task].choice.as_ref()?.expected?;
                Some(self.now + expected - self.worked(share.task))
            }
        };
        let ends: Option<Vec<Time>> = rivals.into_iter().map(done).collect();
        ends?.into_iter().min()
    }

    /// Returns the time for which the task has been ongoing since it started.
    fn worked(&self, id: usize) -> Span {
        let Some(started) = self.tasks[id].started_at else { return 0 };
        let mut worked = 0;
        let mut since = None;
        for each in self.moves.iter().filter(|each| each.task == id && each.at >= started) {
            worked += since.take().map_or(0, |since| each.at - since);
            since = (each.to == State::Ongoing).then_some(each.at);
        }
        worked + since.map_or(0, |since| self.now - since)
    }

    /// Returns true if this task would end before the rejected claimant can begin, so that it may use the resource meanwhile.
    fn leaves_a_gap(&self, id: usize, share: &Share) -> bool {
        let expected = self.tasks[id].choice.as_ref().and_then(|choice| choice.expected);
        match (share.right, expected) {
            (Right::Awaited(Some(earliest)), Some(expected)) => self.now + expected <= earliest,
            _ => false,
        }
    }
}
