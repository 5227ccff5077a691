//! Who gets which resources: all claimants of all resources stand before the arbiter in every round.

use crate::agent::Agent;
use crate::program::Time;
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
    /// An ongoing task has it, and can lose it.
    Held,
    /// Given away in this round.
    Granted,
    /// Claimed by one who came before and was refused, and who cannot begin before this instant, if that is known.
    Awaited(Option<Time>),
}

/// Who lost against whom over what.
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
}

/// Who lost so often at one instant takes nothing from anybody before the next: rings of ranks and priorities end.
const LOSSES_MAX: usize = 2;

impl Agent<'_> {
    /// May the task work at all? Not under a suspended ancestor; and nothing begins below a task that does not work.
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

    pub(crate) fn contend_and_commit(&mut self) {
        let mut orphans = Vec::new();
        loop {
            let field = self.contend(&orphans);
            // Steps of a task that stops working do not begin, so they do not compete.
            let stops = |id: usize| field.displaced.iter().any(|loss| loss.loser == id) && !field.granted.contains(&id);
            let orphan =
                |id: &&usize| self.tasks[**id].state == State::Enabled && self.tasks[**id].parent.is_some_and(stops);
            let more: Vec<usize> = field.granted.iter().filter(orphan).copied().collect();
            if more.is_empty() {
                return self.commit(field);
            }
            orphans.extend(more);
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
        while let Some(next) = self.first(&claimants) {
            claimants.retain(|id| *id != next);
            let lost = self.place(&mut field, next);
            claimants.extend(lost);
        }
        field
    }

    fn commit(&mut self, mut field: Field) {
        // Ancestors stop before their descendants, as in a suspension.
        field.displaced.sort_by_key(|loss| (self.line(loss.loser).len(), loss.loser));
        for loss in &field.displaced {
            self.losses.push(loss.loser);
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
        self.resumed.clear();
    }

    /// Priority, then work that has begun, then written order among siblings and creation order among others.
    fn by_priority(&self, a: usize, b: usize) -> Ordering {
        let order = |id: usize| {
            let begun = matches!(self.tasks[id].state, State::Ongoing | State::Interrupted);
            let step = match self.tasks[id].origin {
                crate::task::Origin::Step(_, step) => step,
                _ => 0,
            };
            (!begun, self.tasks[id].parent.unwrap_or(id), step, id)
        };
        let (first, second) = (self.priority(a, self.now), self.priority(b, self.now));
        second.total_cmp(&first).then(order(a).cmp(&order(b)))
    }

    /// Who comes before the arbiter next: the first that no other claimant of something that it needs beats; where they
    /// beat one another in a ring, the one with the highest priority.
    fn first(&self, claimants: &[usize]) -> Option<usize> {
        let mut sorted = claimants.to_vec();
        sorted.sort_by(|a, b| self.by_priority(*a, *b));
        let share = |a: usize, b: usize| {
            let other = self.tasks[b].needs();
            self.tasks[a].needs().iter().any(|(name, _)| other.iter().any(|(each, _)| each == name))
        };
        let beats = |a: usize, b: usize| match self.ranks(a, b) {
            Some((first, second)) => first < second,
            None => self.by_priority(a, b) == Ordering::Less,
        };
        let beaten = |id: usize| {
            sorted
                .iter()
                .any(|other| *other != id && share(*other, id) && !self.are_related(*other, id) && beats(*other, id))
        };
        sorted.iter().find(|id| !beaten(**id)).or(sorted.first()).copied()
    }

    /// Gives the claimant all it needs, or nothing. Gives the holders that lost: as few as possible, and stronger ones
    /// only where the weaker ones do not suffice.
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
                if lacking(&losses).is_some() {
                    losses.insert(index, spared);
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

    /// The shares of a resource that count against the claimant when the losers are gone.
    fn present<'f>(&self, field: &'f Field, id: usize, resource: &str, losses: &[Loss]) -> Vec<&'f Share> {
        let counts = |share: &&Share| match share.right {
            Right::Held => losses.iter().all(|loss| loss.loser != share.task),
            Right::Granted => true,
            Right::Awaited(_) => !self.are_related(share.task, id) && !self.leaves_a_gap(id, share),
        };
        field.shares.iter().filter(|share| share.resource == resource).filter(counts).collect()
    }

    /// How much is used: what a task uses and what those below it use together count as the greater of both.
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

    /// All holders that the claimant beats, the weakest first: the higher rank, then who defends with less, then who has
    /// been at work for the shorter time.
    fn beaten(&self, field: &Field, id: usize) -> Vec<Loss> {
        let mut found: Vec<Loss> = Vec::new();
        if self.losses.iter().filter(|loser| **loser == id).count() >= LOSSES_MAX {
            return found;
        }
        for (resource, _) in self.tasks[id].needs() {
            for share in field.shares.iter().filter(|share| share.resource == resource && share.right == Right::Held) {
                let known = found.iter().any(|loss| loss.loser == share.task);
                if !known && !self.are_related(share.task, id) && self.wins(id, share.task) {
                    found.push(Loss { loser: share.task, winner: id, resource: resource.clone() });
                }
            }
        }
        let since = |id: usize| self.moves.iter().rev().find(|each| each.task == id).map_or(0, |each| each.at);
        found.sort_by(|a, b| {
            let (first, second) = (self.defence(a.loser, self.now), self.defence(b.loser, self.now));
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

    /// Does a claimant beat a holder?
    fn wins(&self, id: usize, holder: usize) -> bool {
        match self.ranks(id, holder) {
            Some((own, other)) => own < other,
            None => self.priority(id, self.now) > self.defence(holder, self.now),
        }
    }

    /// When one who is refused can begin at the earliest: when the weakest who has the resource is done, if that is known.
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
        let unbeaten = rivals.into_iter().filter(|share| share.right != Right::Held || !self.wins(id, share.task));
        let strength = |share: &Share| match self.ranks(id, share.task) {
            Some((_, other)) => other,
            None if share.right == Right::Held => self.defence(share.task, self.now),
            None => self.priority(share.task, self.now),
        };
        let has = |share: &Share| !matches!(share.right, Right::Awaited(_));
        let told = unbeaten.reduce(|a, b| match (has(a), has(b)) {
            (true, true) if strength(b) < strength(a) => b,
            (false, true) => b,
            _ => a,
        });
        let winner = &self.tasks[told.filter(|share| has(share))?.task];
        let expected = winner.choice.as_ref()?.expected?;
        Some(winner.started_at.unwrap_or(self.now) + expected)
    }

    /// One who was refused and cannot begin before this one is done leaves a gap for it.
    fn leaves_a_gap(&self, id: usize, share: &Share) -> bool {
        let expected = self.tasks[id].choice.as_ref().and_then(|choice| choice.expected);
        match (share.right, expected) {
            (Right::Awaited(Some(earliest)), Some(expected)) => self.now + expected <= earliest,
            _ => false,
        }
    }
}
