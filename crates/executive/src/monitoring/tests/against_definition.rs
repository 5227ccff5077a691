//! Measurements and episodes of one variable, and their combinations, against the definition.

use super::traces::{Trace, as_truth, instants, tell, traces, valid};
use super::*;
use proptest::prelude::*;

/// An episode `value >= 5` with these bounds.
#[derive(Clone, Copy, Debug)]
struct Wanted {
    gap: Option<i64>,
    bound: Bound,
}

#[derive(Clone, Copy, Debug)]
enum Bound {
    None,
    AtLeast(i64),
    MoreThan(i64),
    LessThan(i64),
}

impl Wanted {
    fn condition(self) -> ConditionKind {
        let duration = match self.bound {
            Bound::None => vec![],
            Bound::AtLeast(least) => vec![compare(Relation::GreaterOrEqual, span(least))],
            Bound::MoreThan(least) => vec![compare(Relation::Greater, span(least))],
            Bound::LessThan(most) => vec![compare(Relation::Less, span(most))],
        };
        let value = vec![compare(Relation::GreaterOrEqual, int(5))];
        ConditionKind::Episode(Arc::new(episode(uav("a"), value, self.gap, duration)))
    }

    fn close(self, from: i64, to: i64) -> bool {
        self.gap.is_none_or(|gap| to - from <= gap)
    }

    /// Returns the maximal runs as (first, last, the next sample's instant) by the definition.
    fn runs(self, samples: &[(i64, i64)]) -> Vec<(i64, i64, Option<i64>)> {
        let mut runs: Vec<(i64, i64, Option<i64>)> = Vec::new();
        let mut open = false;
        for (at, value) in samples {
            if let Some(run) = runs.last_mut().filter(|_| open) {
                if *value >= 5 && self.close(run.1, *at) {
                    run.1 = *at;
                    continue;
                }
                run.2 = Some(*at);
            }
            open = *value >= 5;
            if open {
                runs.push((*at, *at, None));
            }
        }
        runs
    }

    /// Returns the earliest result up to `now`: interval and recognition.
    fn result(self, samples: &[(i64, i64)], now: i64) -> Option<(i64, i64, i64)> {
        let least = match self.bound {
            Bound::None => 0,
            Bound::AtLeast(least) => least,
            Bound::MoreThan(least) => least + 1,
            Bound::LessThan(most) => return self.result_when_over(samples, now, most),
        };
        self.runs(samples)
            .into_iter()
            .filter_map(|(first, last, next)| {
                let by_sample = samples.iter().map(|(at, _)| *at).find(|at| *at >= first + least && *at <= last);
                // Within the run the last value holds up to the next sample; after the run it holds for the length of the gap.
                let reached = first + least;
                let previous = samples.iter().map(|(at, _)| *at).rfind(|at| *at < reached)?.max(first);
                let licensed = self.gap.is_some_and(|gap| reached <= previous + gap)
                    && previous <= last
                    && (previous < last || next.is_none_or(|next| reached < next));
                let by_time = (licensed && reached <= now && least > 0).then_some((first, previous, reached));
                by_sample.map(|at| (first, at, at)).into_iter().chain(by_time).min_by_key(|(_, _, known)| *known)
            })
            .chain(self.runs(samples).into_iter().filter(|_| least == 0).map(|(first, ..)| (first, first, first)))
            .min_by_key(|(_, _, known)| *known)
    }

    fn result_when_over(self, samples: &[(i64, i64)], now: i64, most: i64) -> Option<(i64, i64, i64)> {
        self.runs(samples)
            .into_iter()
            .filter(|(first, last, _)| last - first < most)
            .filter_map(|(first, last, next)| {
                let silent = self.gap.map(|gap| last + gap + 1).filter(|known| *known <= now);
                let known = match (next, silent) {
                    (Some(next), Some(silent)) => next.min(silent),
                    (known, silent) => known.or(silent)?,
                };
                Some((first, last, known))
            })
            .min_by_key(|(_, _, known)| *known)
    }

    fn truth(self, samples: &[(i64, i64)], now: i64) -> Truth {
        if self.result(samples, now).is_some() {
            return Truth::True;
        }
        let Some((newest, _)) = samples.last() else { return Truth::Unknown };
        // Expected samples are missing, whatever the newest one says.
        if !self.close(*newest, now) {
            return Truth::Unknown;
        }
        let last_low = samples.iter().rposition(|(_, value)| *value < 5);
        if last_low.is_some_and(|index| index + 1 == samples.len()) {
            return Truth::False;
        }
        // A run that follows a gap may have begun in it.
        let since_low = &samples[last_low.unwrap_or(0)..];
        let gap = since_low.windows(2).any(|pair| !self.close(pair[0].0, pair[1].0));
        if last_low.is_none() || gap { Truth::Unknown } else { Truth::False }
    }
}

fn wanted() -> impl Strategy<Value = Wanted> {
    let bound = prop_oneof![
        Just(Bound::None),
        (1..12_i64).prop_map(Bound::AtLeast),
        (0..12_i64).prop_map(Bound::MoreThan),
        (1..12_i64).prop_map(Bound::LessThan),
    ];
    (proptest::option::of(1..6_i64), bound).prop_map(|(gap, bound)| Wanted { gap, bound })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3_000))]

    #[test]
    fn episodes_agree_with_the_definition_at_every_instant(trace in traces(10, 6), wanted in wanted(), rest in 0..15_i64) {
        let mut world = World::new(&condition(wanted.condition()));
        let mut seen = Vec::new();
        let mut groups = instants(&trace).into_iter().peekable();
        while let Some(group) = groups.next() {
            tell(&mut world, group);
            seen.extend_from_slice(group);
            let next = groups.peek().map_or(group[0].0 + rest, |next| next[0].0);
            // Every tick up to the next arrival is queried, so that the result does not depend on when time is advanced.
            for now in group[0].0..=next.max(group[0].0 + 1) - 1 {
                let samples = valid(&seen);
                let verdict = world.ask(now);
                prop_assert_eq!(as_truth(&verdict), wanted.truth(&samples, now), "at {} of {:?}", now, samples);
                if let Verdict::Satisfied(result) = verdict {
                    let answer = (result.interval.0.0, result.interval.1.0, result.recognised_at.0);
                    prop_assert_eq!(Some(answer), wanted.result(&samples, now), "at {} of {:?}", now, samples);
                }
            }
        }
    }

    #[test]
    fn results_do_not_depend_on_batches(trace in traces(10, 6), wanted in wanted(), rest in 0..15_i64, cuts in proptest::collection::vec(any::<bool>(), 24)) {
        let end = trace.last().map_or(0, |last| last.0) + rest;
        let mut whole = World::new(&condition(wanted.condition()));
        tell(&mut whole, &trace);
        let mut parts = World::new(&condition(wanted.condition()));
        for (group, cut) in instants(&trace).into_iter().zip(cuts) {
            tell(&mut parts, group);
            if cut {
                parts.ask(group[0].0);
            }
        }
        prop_assert_eq!(whole.answer(end), parts.answer(end));
        prop_assert_eq!(whole.answer(end), wanted.result(&valid(&trace), end));
    }

    #[test]
    fn wakes_come_exactly_when_time_alone_decides(trace in traces(10, 6), wanted in wanted()) {
        let mut world = World::new(&condition(wanted.condition()));
        let mut first = None;
        let groups = instants(&trace);
        for (index, group) in groups.iter().enumerate() {
            tell(&mut world, group);
            let mut now = group[0].0;
            let until = groups.get(index + 1).map_or(i64::MAX, |next| next[0].0);
            // The agent sleeps until the next arrival or wake, and evaluates at no other instant.
            while now < until && first.is_none() {
                first = world.answer(now).map(|(_, _, known)| (now, known));
                match world.wake() {
                    Some(wake) if wake.0 < until => {
                        prop_assert!(wake.0 > now, "a wake at {} asked at {}", wake.0, now);
                        now = wake.0;
                    }
                    _ => break,
                }
            }
        }
        let expected = wanted.result(&valid(&trace), i64::MAX / 2);
        if let (Some((asked, known)), Some((_, _, expected))) = (first, expected) {
            prop_assert_eq!((asked, known), (expected, expected));
        }
        let last = trace.last().map_or(0, |last| last.0);
        prop_assert!(first.is_some() || expected.is_none_or(|(_, _, known)| known > last), "{:?}", expected);
    }

    #[test]
    fn measurements_agree_with_the_definition(trace in traces(10, 6), limit in 0..10_i64, start in 0..20_i64) {
        let wanted = condition(ConditionKind::Measurement(Arc::new(measurement(uav("a"), vec![compare(Relation::Greater, int(limit))]))));
        // Half of the trace is history when the monitor is made.
        let (past, future): (Trace, Trace) = trace.iter().partition(|(at, _)| *at <= start);
        let mut world = World::new(&wanted);
        world.view.histories.require_lookback(&Symbol::new("a"), Duration::MAX);
        tell(&mut world, &past);
        world.view.now = Time(start);
        world.watch(&wanted, Window::from(Time(start)));
        let mut seen = past;
        let expected = |seen: &[(i64, Option<i64>)]| {
            valid(seen).into_iter().find(|(at, value)| *at >= start && *value > limit).map(|(at, _)| (at, at, at))
        };
        prop_assert_eq!(world.answer(start), expected(&seen));
        for group in instants(&future) {
            tell(&mut world, group);
            seen.extend_from_slice(group);
            prop_assert_eq!(world.answer(group[0].0), expected(&seen));
        }
    }

    #[test]
    fn late_samples_lead_to_the_same_result_as_timely_ones(trace in traces(10, 6), wanted in wanted(), order in proptest::collection::vec(0..9_i64, 24)) {
        // Arrivals are shuffled within nine ticks, the lateness of the variable.
        let samples = valid(&trace);
        let mut arrivals: Vec<(i64, i64, i64)> = samples.iter().zip(&order).map(|((at, value), delay)| (at + delay, *at, *value)).collect();
        arrivals.sort();
        let mut view = TestView::default();
        let declaration = apex_model::library::StateVariableDeclaration {
            unit: None,
            dimension: apex_model::quantity::Dimension::NONE,
            value_type: None,
            lateness: Some(Value::Duration(Duration(9))),
            rate_per_s: None,
            place: Place::default(),
        };
        view.library.state_variables.insert(Symbol::new("a"), declaration);
        prepare(&mut view.histories, &view.library, None);
        let mut world = World::in_view(&condition(wanted.condition()), view);
        for (_, at, value) in arrivals {
            world.sample("a", "uav", Value::Integer(value), at);
        }
        let end = world.view.now.0 + 3;
        prop_assert_eq!(world.answer(end), wanted.result(&samples, end));
    }

    #[test]
    fn logic_agrees_with_its_definition(trace in traces(10, 6), left in wanted(), right in wanted(), shape in 0..4_u8) {
        let parts = || vec![condition(left.condition()), condition(right.condition())];
        let not = |wanted: Wanted| condition(ConditionKind::Not(Box::new(condition(wanted.condition()))));
        let whole = condition(match shape {
            0 => ConditionKind::And(parts(), vec![]),
            1 => ConditionKind::Or(parts(), vec![]),
            2 => ConditionKind::Not(Box::new(condition(ConditionKind::Or(parts(), vec![])))),
            _ => ConditionKind::And(vec![condition(left.condition()), not(right)], vec![]),
        });
        let mut world = World::new(&whole);
        let mut seen = Vec::new();
        for group in instants(&trace) {
            tell(&mut world, group);
            seen.extend_from_slice(group);
            let (samples, now) = (valid(&seen), group[0].0);
            let (a, b) = (left.truth(&samples, now), right.truth(&samples, now));
            let expected = match shape {
                0 => a.min(b),
                1 => a.max(b),
                2 => a.max(b).negated(),
                _ => a.min(b.negated()),
            };
            let verdict = world.ask(now);
            prop_assert_eq!(as_truth(&verdict), expected);
            if let (Verdict::Satisfied(result), 0 | 1) = (verdict, shape) {
                let known = [left, right].map(|wanted| wanted.result(&samples, now).map(|(_, _, known)| known));
                let expected = if shape == 0 { known.into_iter().max() } else { known.into_iter().filter(Option::is_some).min() };
                prop_assert_eq!(Some(Some(result.recognised_at.0)), expected);
            }
        }
    }
}
