//! Episode indexes of a session. They watch threshold episodes and combinations of them while no result is to be reported, so that most
//! samples are compared in one pass and reach no monitor.

use super::scene::SessionState;
use super::watched::WatchedCondition;
use super::{MonitorResult, MonitorSession, ResultEvent, SessionError};
use crate::expression::arithmetic::with_unit;
use crate::expression::declared_unit::unit_of;
use crate::monitoring::episodes::{threshold_episode, threshold_formula};
use crate::monitoring::memory::{histories, retention};
use crate::monitoring::stimulus::Stimulus;
use crate::state::clause::MonitorId;
use crate::state::episode_index::{IndexedRun, LeafId, Taken, What};
use crate::state::histories::history::Sample;
use crate::state::monitor_set::MonitorIds;
use crate::state::monitors::monitor::Monitor;
use crate::state::wake::WakeKey;
use apex_model::agent_limits::Limit;
use apex_model::event::StateVariable;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;

impl MonitorSession {
    /// Records measurements of one variable as real numbers in the declared unit. The shorter of the two slices counts.
    pub fn samples(&mut self, variable: &StateVariable, instants: &[Time], values: &[f64]) {
        let length = instants.len().min(values.len());
        let (mut instants, mut values) =
            (instants.get(..length).unwrap_or_default(), values.get(..length).unwrap_or_default());
        while let (Some((at, later)), Some((value, rest))) = (instants.split_first(), values.split_first()) {
            self.sample(variable, Value::Real(*value), *at);
            (instants, values) = (later, rest);
            // The next sample has a later instant, so the present instant is over.
            if later.first().is_some_and(|next| *next > self.world.now) {
                self.end_instant();
            }
            // To report gaps, a session has to process every sample.
            while self.spacings.is_none() {
                let passed = self.pass_by(variable, instants, values);
                if passed == 0 {
                    break;
                }
                instants = instants.get(passed..).unwrap_or_default();
                values = values.get(passed..).unwrap_or_default();
            }
        }
    }

    /// Passes the stimulus to the index of its variable, and adds the monitors that must process it themselves to `found`. If its variable
    /// is `repeated` at its instant, these are all monitors, since the next sample may revoke its effect.
    pub(super) fn show_bank(&mut self, stimulus: &Stimulus, repeated: &[StateVariable], found: &mut MonitorIds) {
        let Stimulus::Sample { variable, value, at, newest, .. } = stimulus else { return };
        let Some(bank) = self.interests.episodes_mut(variable) else { return };
        // A sample from before the present instant may revoke decisions that the passing of time has caused since.
        let ordinary = *newest && *at >= self.world.now && !repeated.contains(variable);
        match bank.takes(*at, value).filter(|_| ordinary) {
            Some(number) => bank.sample(*at, number, &mut self.heard),
            None => {
                let mut taken = Taken::new();
                bank.take_all(&mut taken);
                found.extend(taken.iter().map(|(leaf, _)| leaf.monitor));
                self.stand_up(taken);
            }
        }
        self.refresh(variable);
    }

    /// Handles a wake of the condition, which begins now if it has not begun yet.
    pub(super) fn begin(&mut self, id: MonitorId) {
        let Some(watched) = self.watches.get_mut(id.0) else { return };
        watched.wake = None;
        self.touched.push(id);
        if watched.monitor.is_some() {
            return;
        }
        match watched.begin(&self.world) {
            Ok(()) => watched.file(&mut self.interests, id),
            Err(error) => {
                let at = self.world.now;
                self.watches.remove(id.0);
                self.trouble(SessionError { watch: Some(id), at, message: error.message, place: Some(error.place) });
            }
        }
    }

    /// Handles a wake of the index that holds `leaf`: one of its episodes is due.
    pub(super) fn wake_bank(&mut self, leaf: LeafId) {
        let watched = self.watches.get(leaf.monitor.0);
        let Some(variable) = watched.and_then(|watched| watched.variable_in_bank(leaf.leaf)).cloned() else { return };
        let Some(bank) = self.interests.episodes_mut(&variable) else { return };
        bank.wake = None;
        bank.pass_time(self.world.now, &mut self.heard);
        self.refresh(&variable);
    }

    /// Lets the monitors of `taken` process stimuli themselves again.
    fn stand_up(&mut self, taken: Taken) {
        for of_one in taken.chunk_by(|(one, _), (other, _)| one.monitor == other.monitor) {
            let Some((LeafId { monitor: id, .. }, first)) = of_one.first() else { continue };
            let Some(mut watched) = self.watches.lift(id.0) else { continue };
            if watched.leaves.is_some() {
                self.take_out_combination(*id, &mut watched, of_one);
            } else {
                watched.stand_up(first.clone());
            }
            watched.file(&mut self.interests, *id);
            self.watches.put(id.0, watched);
            self.touched.push(*id);
        }
    }

    /// Moves the leaves of a combination from their indexes back into its monitor; `taken` holds those that are removed already.
    fn take_out_combination(
        &mut self,
        id: MonitorId,
        watched: &mut WatchedCondition,
        taken: &[(LeafId, Option<IndexedRun>)],
    ) {
        let Some(mut leaves) = watched.leaves.take() else { return };
        let mut seen = Vec::new();
        for (leaf, variable) in (0..).zip(leaves.variables()) {
            let leaf = LeafId { monitor: id, leaf };
            if let Some((_, before)) = taken.iter().find(|(each, _)| *each == leaf) {
                seen.push(before.clone());
                continue;
            }
            seen.push(self.interests.episodes_mut(variable).and_then(|bank| bank.take(leaf)).flatten());
            self.refresh(variable);
        }
        if let Some(monitor) = &mut watched.monitor {
            threshold_formula::stand_up(monitor, &mut leaves, seen, &self.world);
        }
    }

    /// Reports the results of the indexes at the present instant, and marks combinations that may have results.
    pub(super) fn tell_heard(&mut self) {
        let mut heard = std::mem::take(&mut self.heard);
        heard.sort_by_key(|told| (told.leaf, told.what != What::Over));
        for told in heard.drain(..) {
            let id = told.leaf.monitor;
            let Some(watched) = self.watches.get_mut(id.0) else { continue };
            let WatchedCondition { monitor: Some(monitor), leaves, .. } = watched else { continue };
            if let Some(leaves) = leaves {
                if threshold_formula::told(monitor, leaves, told.leaf.leaf, &told, &self.world) {
                    self.touched.push(id);
                }
                continue;
            }
            let Some(mut result) = threshold_episode::told_result(monitor, &told) else { continue };
            let telling =
                if told.what == What::Over { ResultEvent::Closed } else { ResultEvent::Recognised { open: true } };
            if told.what == What::Found {
                result.recognised_at = self.world.now;
                watched.results += 1;
                watched.first.get_or_insert_with(|| result.clone());
            }
            let gaps = self.gaps_of(&result);
            self.results.push(MonitorResult { watch: id, telling, result, gaps });
        }
        self.heard = heard;
    }

    /// Copies the state of the condition's leaves from the indexes into its monitor. Returns true if the leaves stay in the indexes, as
    /// those of a combination do.
    pub(super) fn look_into_banks(&mut self, id: MonitorId, watched: &mut WatchedCondition) -> bool {
        let WatchedCondition { monitor: Some(monitor), leaves: Some(leaves), .. } = watched else {
            self.take_out_of_bank(id, watched);
            return false;
        };
        let seen = self.seen_by_banks(id, leaves);
        threshold_formula::stand_up(monitor, leaves, seen, &self.world);
        true
    }

    fn seen_by_banks(&self, id: MonitorId, leaves: &threshold_formula::Leaves) -> Vec<Option<IndexedRun>> {
        let seen = |(leaf, variable)| self.interests.episodes(variable)?.run_of(LeafId { monitor: id, leaf })?;
        (0..).zip(leaves.variables()).map(seen).collect()
    }

    /// Removes the condition's leaves from all indexes.
    pub(super) fn take_out_of_bank(&mut self, id: MonitorId, watched: &mut WatchedCondition) {
        if watched.leaves.is_some() {
            self.take_out_combination(id, watched, &[]);
            watched.file(&mut self.interests, id);
            return;
        }
        let variable = watched.monitor.as_ref().and_then(threshold_episode::variable).cloned();
        let Some(variable) = variable else { return };
        let bank = self.interests.episodes_mut(&variable);
        let Some(seen) = bank.and_then(|bank| bank.take(LeafId::whole(id))) else { return };
        watched.stand_up(seen);
        watched.file(&mut self.interests, id);
        self.refresh(&variable);
    }

    /// Moves a condition without unreported results into an index. Returns false if no index can watch it.
    pub(super) fn put_into_bank(&mut self, id: MonitorId, watched: &mut WatchedCondition) -> bool {
        // Reported results must be remembered as long as late samples can produce them again.
        if watched.lateness > Duration::ZERO || self.without_banks {
            return false;
        }
        let Some(monitor) = &mut watched.monitor else { return false };
        let Some(variable) = threshold_episode::variable(monitor).cloned() else {
            return self.put_combination_into_banks(id, watched);
        };
        let Some((wanted, run)) = threshold_episode::bankable(monitor, &self.world) else { return false };
        // An index reports the end of every result.
        if wanted.open.is_some() && !watched.told.awaits_end() {
            return false;
        }
        if !self.interests.bank(&variable, LeafId::whole(id), &wanted, run) {
            return false;
        }
        threshold_episode::lie_down(monitor);
        self.refresh(&variable);
        true
    }

    fn put_combination_into_banks(&mut self, id: MonitorId, watched: &mut WatchedCondition) -> bool {
        let Some(monitor) = &mut watched.monitor else { return false };
        let Some((leaves, bankables)) = threshold_formula::bankable(monitor, &self.world) else { return false };
        let each = (0..).zip(leaves.variables().zip(&bankables));
        let put_in = |(leaf, (variable, bankable)): (u32, (&StateVariable, &threshold_episode::Bankable<'_>))| {
            let leaf = LeafId { monitor: id, leaf };
            self.interests.bank(variable, leaf, &bankable.wanted, bankable.run)
        };
        let inside = each.map(put_in).take_while(|inside| *inside).count();
        let whole = inside == bankables.len();
        if whole {
            threshold_formula::lie_down(monitor);
        } else {
            // All leaves must be in indexes: a single one would miss the reports of the others.
            for (leaf, variable) in (0..).zip(leaves.variables()).take(inside) {
                self.interests.episodes_mut(variable).and_then(|bank| bank.take(LeafId { monitor: id, leaf }));
            }
            watched.file(&mut self.interests, id);
        }
        leaves.variables().for_each(|variable| self.refresh(variable));
        watched.leaves = whole.then_some(leaves);
        whole
    }

    /// Replaces the requested wake of an index by the one that it needs now; removes an empty index.
    fn refresh(&mut self, variable: &StateVariable) {
        let Some(bank) = self.interests.episodes_mut(variable) else { return };
        let due = bank.due();
        if bank.wake.map(|(wake, leaf)| (wake.at, leaf)) != due {
            if let Some((wake, leaf)) = bank.wake.take() {
                self.wakes.remove(&wake_of(wake.at, leaf));
            }
            bank.wake = due.map(|(at, leaf)| (WakeKey { at, number: 0 }, leaf));
            self.wakes.extend(due.map(|(at, leaf)| wake_of(at, leaf)));
        }
        if bank.is_empty() {
            self.interests.drop_empty_bank(variable);
        }
    }

    /// Returns the monitor in the state that it would have without an index.
    pub(super) fn as_told(&self, id: MonitorId, watched: &WatchedCondition) -> Option<Monitor> {
        let mut monitor = watched.monitor.clone()?;
        if let Some(mut leaves) = watched.leaves.clone() {
            let seen = self.seen_by_banks(id, &leaves);
            threshold_formula::stand_up(&mut monitor, &mut leaves, seen, &self.world);
            return Some(monitor);
        }
        let bank = threshold_episode::variable(&monitor).and_then(|variable| self.interests.episodes(variable));
        if let Some(seen) = bank.and_then(|bank| bank.run_of(LeafId::whole(id))) {
            threshold_episode::stand_up(&mut monitor, seen);
        }
        Some(monitor)
    }

    /// Processes consecutive samples of one variable, one per instant, up to the first one that a monitor must process itself. Returns
    /// their number. The last sample is left out, because the next stimulus may belong to its instant.
    pub(super) fn pass_by(&mut self, variable: &StateVariable, instants: &[Time], values: &[f64]) -> usize {
        if !self.stimuli.is_empty() || !self.touched.is_empty() {
            return 0;
        }
        let samples_max = self.world.limits.count(Limit::HistorySamples);
        let SessionState { library, index, histories, now, .. } = &mut self.world;
        let declaration = library.state_variables.get(&variable.attribute);
        let unit = unit_of(&variable.attribute, library);
        if declaration.and_then(retention::lateness).is_some() || !index.readers(&variable.attribute).is_empty() {
            return 0;
        }
        let Some(history) = histories.get_mut(variable) else { return 0 };
        let Some((thresholds, mut bank)) = self.interests.quiet_watchers(variable) else { return 0 };
        if let Some((wake, leaf)) = bank.as_mut().and_then(|bank| bank.wake.take()) {
            self.wakes.remove(&wake_of(wake.at, leaf));
        }
        let wake = self.wakes.first().map_or(Time::END, |(at, ..)| *at);
        let (mut found, mut count, mut overflowed) = (MonitorIds::new(), 0, None);
        for (pair, number) in instants.windows(2).zip(values) {
            let [at, next] = pair else { break };
            let alone = *at > *now && next > at && *at < wake && !number.is_nan();
            let value = unit.map_or(Value::Real(*number), |unit| with_unit(*number, unit));
            if let Some(thresholds) = thresholds {
                thresholds.of_value(&value, &mut found);
            }
            let exact = bank.as_ref().map(|bank| bank.takes(*at, &value));
            if !alone || !found.is_empty() || exact == Some(None) || history.newest().is_some_and(|last| last.at >= *at)
            {
                break;
            }
            self.arrivals += 1;
            let before = history.has_overflowed();
            history.record(Sample { at: *at, sequence: self.arrivals, value }, samples_max);
            *now = *at;
            count += 1;
            overflowed = overflowed.or((history.has_overflowed() && !before).then_some(*at));
            if let (Some(bank), Some(Some(number))) = (&mut bank, exact) {
                bank.sample(*at, number, &mut self.heard);
            }
            if !self.heard.is_empty() {
                break;
            }
        }
        if let Some(at) = overflowed {
            let message = histories::overflow_of_samples(variable, &self.world.limits);
            self.trouble(SessionError { watch: None, at, message, place: None });
        }
        self.refresh(variable);
        self.judge_touched();
        count
    }
}

/// Returns the wake that an episode index has requested, in the form of the session's queue.
fn wake_of(at: Time, leaf: LeafId) -> (Time, MonitorId, Option<u32>) {
    (at, leaf.monitor, Some(leaf.leaf))
}

/// Returns the variables with more than one sample.
pub(super) fn repeated(stimuli: &[Stimulus]) -> Vec<StateVariable> {
    if stimuli.len() < 2 {
        return Vec::new();
    }
    let of_samples = stimuli.iter().filter_map(|stimulus| match stimulus {
        Stimulus::Sample { variable, .. } => Some(variable),
        _ => None,
    });
    let mut variables: Vec<&StateVariable> = of_samples.collect();
    variables.sort_unstable();
    let mut repeated: Vec<StateVariable> = variables
        .windows(2)
        .filter_map(|pair| pair.first().filter(|first| pair.last() == Some(*first)).map(|first| (*first).clone()))
        .collect();
    repeated.dedup();
    repeated
}
