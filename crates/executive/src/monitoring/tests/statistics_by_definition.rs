//! Statistics and trends against their definition, evaluated at every tick over all samples in exact arithmetic.

use super::traces::{as_truth, instants, tell, traces, valid};
use super::*;
use proptest::prelude::*;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Mean,
    Count,
    Variance,
    Sum,
    Difference,
    Least,
    Greatest,
    Median,
    Rate,
    Step,
    Frequency,
    HeldMean,
    HeldVariance,
    HeldDeviation,
}

const KINDS: [(Kind, &str); 14] = [
    (Kind::Mean, "mean"),
    (Kind::Count, "count"),
    (Kind::Variance, "variance"),
    (Kind::Sum, "sum"),
    (Kind::Difference, "difference"),
    (Kind::Least, "min"),
    (Kind::Greatest, "max"),
    (Kind::Median, "median"),
    (Kind::Rate, "rate"),
    (Kind::Step, "step"),
    (Kind::Frequency, "frequency"),
    (Kind::HeldMean, "time-weighted-mean"),
    (Kind::HeldVariance, "time-weighted-variance"),
    (Kind::HeldDeviation, "time-weighted-stddev"),
];

/// `(:episode (a uav) [:value (>= 5)] :quality G [:timing (:duration (>= D))] :stats (:KIND (REL LIMIT)))`
#[derive(Clone, Copy, Debug)]
struct Wanted {
    kind: (Kind, &'static str),
    value: bool,
    gap: Option<i64>,
    duration: i64,
    above: bool,
    limit: i64,
}

/// Numerator and denominator of a fraction; the denominator is positive.
type Fraction = (i128, i128);

impl Wanted {
    fn limit(self) -> Fraction {
        let scale = match self.kind.0 {
            // Scaled to seconds: the trace counts nanoseconds.
            Kind::Rate | Kind::Frequency => 100_000_000,
            _ => 1,
        };
        // The limit has a fraction that no statistic reaches exactly, so that rounding cannot decide.
        (i128::from(self.limit * scale) * 1000 + 123, 1000)
    }

    fn condition(self) -> ConditionKind {
        let (numerator, denominator) = self.limit();
        let limit = numerator as f64 / denominator as f64;
        let limit = match self.kind.0 {
            Kind::Frequency => Value::measured(limit, apex_model::quantity::Dimension::FREQUENCY),
            Kind::Rate => Value::measured(limit, apex_model::quantity::Dimension::FREQUENCY),
            _ => Value::Real(limit),
        };
        let relation = if self.above { Relation::Greater } else { Relation::Less };
        let wanted = vec![(Symbol::new(self.kind.1), vec![compare(relation, constant(limit))])];
        let value = if self.value { vec![compare(Relation::GreaterOrEqual, int(5))] } else { vec![] };
        let duration =
            if self.duration > 0 { vec![compare(Relation::GreaterOrEqual, span(self.duration))] } else { vec![] };
        let mut episode = episode(uav("a"), value, self.gap, duration);
        if matches!(self.kind.0, Kind::Rate | Kind::Step | Kind::Frequency) {
            episode.trend = wanted;
        } else {
            episode.stats = wanted;
        }
        ConditionKind::Episode(Arc::new(episode))
    }

    fn satisfied(self, (numerator, denominator): Fraction) -> bool {
        let (limit, scale) = self.limit();
        let (left, right) = (numerator * scale, limit * denominator);
        if self.above { left > right } else { left < right }
    }

    /// Returns the truth for the numbers in the interval that ends at `end`; `None` if it is undefined.
    fn holds(self, samples: &[(i64, i64)], before: Option<i64>, from: i64, end: i64) -> Option<bool> {
        let count = samples.len() as i128;
        let values = || samples.iter().map(|(_, value)| i128::from(*value));
        let first = samples.first()?;
        let sum: i128 = values().sum();
        let value = match self.kind.0 {
            Kind::Mean => (sum, count),
            Kind::Count => (count, 1),
            Kind::Sum => (sum, 1),
            Kind::Variance => (count * values().map(|value| value * value).sum::<i128>() - sum * sum, count * count),
            Kind::Difference => (values().max()? - values().min()?, 1),
            Kind::Least => (values().min()?, 1),
            Kind::Greatest => (values().max()?, 1),
            Kind::Median => {
                let mut sorted: Vec<i128> = values().collect();
                sorted.sort_unstable();
                (sorted[(sorted.len() - 1) / 2] + sorted[sorted.len() / 2], 2)
            }
            Kind::Rate => {
                let times = || samples.iter().map(|(at, _)| i128::from(*at));
                let all: i128 = times().sum();
                let spread = count * times().map(|at| at * at).sum::<i128>() - all * all;
                let common = count * times().zip(values()).map(|(at, value)| at * value).sum::<i128>() - all * sum;
                if spread == 0 {
                    return None;
                }
                (common * 1_000_000_000, spread)
            }
            Kind::Step => {
                let steps: Vec<i128> = samples.windows(2).map(|two| i128::from(two[1].1 - two[0].1)).collect();
                return (!steps.is_empty()).then(|| steps.iter().all(|step| self.satisfied((*step, 1))));
            }
            Kind::Frequency => {
                let span = i128::from(samples.last()?.0 - first.0);
                if span == 0 {
                    return None;
                }
                ((count - 1) * 1_000_000_000, span)
            }
            Kind::HeldMean | Kind::HeldVariance | Kind::HeldDeviation => {
                let next = |index: usize| samples.get(index + 1).map_or(end, |next| next.0);
                let held =
                    |(index, sample): (usize, &(i64, i64))| (i128::from(next(index) - sample.0), i128::from(sample.1));
                let edge = before.map(|before| (i128::from(first.0 - from), i128::from(before)));
                let weights: Vec<(i128, i128)> = samples.iter().enumerate().map(held).chain(edge).collect();
                let sum = |power: u32| weights.iter().map(|(time, value)| time * value.pow(power)).sum::<i128>();
                let (time, area, squares) = (sum(0), sum(1), sum(2));
                if time == 0 {
                    return None;
                }
                let variance = (squares * time - area * area, time * time);
                match self.kind.0 {
                    Kind::HeldMean => (area, time),
                    Kind::HeldVariance => variance,
                    // The deviation is compared by its square.
                    _ => {
                        let (limit, scale) = self.limit();
                        let more = limit < 0 || variance.0 * scale * scale > limit * limit * variance.1;
                        return Some(more == self.above);
                    }
                }
            }
        };
        Some(self.satisfied(value))
    }

    fn slides(self) -> bool {
        !self.value && self.duration > 0
    }

    /// Returns the run up to the newest of `samples`, which are all up to some instant.
    fn run(self, samples: &[(i64, i64)]) -> &[(i64, i64)] {
        let ok = |value: i64| !self.value || value >= 5;
        let mut start = samples.len();
        while start > 0 && ok(samples[start - 1].1) {
            let joined =
                samples.get(start).is_none_or(|next| self.gap.is_none_or(|gap| next.0 - samples[start - 1].0 <= gap));
            if !joined {
                break;
            }
            start -= 1;
        }
        &samples[start..]
    }

    /// Returns interval and truth by the definition at instant `end`; the outer `None` means not long enough.
    fn at(self, samples: &[(i64, i64)], end: i64) -> Option<Option<((i64, i64), bool)>> {
        let known: Vec<(i64, i64)> = samples.iter().copied().filter(|(at, _)| *at <= end).collect();
        let run = self.run(&known);
        let start = run.first()?.0;
        if end - start < self.duration {
            return None;
        }
        let from = if self.slides() { end - self.duration } else { start };
        let inside: Vec<(i64, i64)> = run.iter().copied().filter(|(at, _)| *at >= from).collect();
        let before = run.iter().rev().find(|(at, _)| *at < from).map(|(_, value)| *value);
        let interval = (inside.first().map_or(0, |sample| sample.0), inside.last().map_or(0, |sample| sample.0));
        Some(self.holds(&inside, before, from, end).map(|holds| (interval, holds)))
    }

    /// Returns the instants up to `now` at which the statistic is evaluated, in order.
    fn ends(self, samples: &[(i64, i64)], now: i64) -> Vec<i64> {
        let Some(first) = samples.first() else { return Vec::new() };
        (first.0..=now)
            .filter(|end| {
                let newest = samples.iter().map(|(at, _)| *at).rfind(|at| at <= end).unwrap();
                newest == *end || self.gap.is_some_and(|gap| end - newest <= gap)
            })
            .collect()
    }

    fn result(self, samples: &[(i64, i64)], now: i64) -> Option<(i64, i64, i64)> {
        self.ends(samples, now).into_iter().find_map(|end| match self.at(samples, end) {
            Some(Some(((first, last), true))) => Some((first, last, end)),
            _ => None,
        })
    }

    fn truth(self, samples: &[(i64, i64)], now: i64) -> Truth {
        if self.result(samples, now).is_some() {
            return Truth::True;
        }
        let Some((newest, value)) = samples.last() else { return Truth::Unknown };
        if self.gap.is_some_and(|gap| now - newest > gap) {
            return Truth::Unknown;
        }
        if self.value && *value < 5 {
            return Truth::False;
        }
        let last = *self.ends(samples, now).last().unwrap();
        if matches!(self.at(samples, last), Some(Some(_))) {
            return Truth::False;
        }
        let last_low = samples.iter().rposition(|(_, value)| self.value && *value < 5);
        // A run that follows a gap may have begun in it.
        let since_low = &samples[last_low.unwrap_or(0)..];
        let cut = since_low.windows(2).any(|pair| self.gap.is_some_and(|gap| pair[1].0 - pair[0].0 > gap));
        Truth::of(false, last_low.is_none() || cut)
    }
}

fn wanted() -> impl Strategy<Value = Wanted> {
    let parts = (0..KINDS.len(), any::<bool>(), proptest::option::of(1..8_i64), 0..12_i64, any::<bool>(), -3..14_i64);
    parts.prop_map(|(kind, value, gap, duration, above, limit)| Wanted {
        kind: KINDS[kind],
        value,
        gap,
        duration,
        above,
        limit,
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1_000))]

    #[test]
    fn statistics_agree_with_the_definition_at_every_instant(trace in traces(12, 9), wanted in wanted(), rest in 0..15_i64) {
        let mut world = World::new(&condition(wanted.condition()));
        let mut seen = Vec::new();
        let mut groups = instants(&trace).into_iter().peekable();
        while let Some(group) = groups.next() {
            tell(&mut world, group);
            seen.extend_from_slice(group);
            let next = groups.peek().map_or(group[0].0 + rest, |next| next[0].0);
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
    fn results_of_statistics_do_not_depend_on_batches(trace in traces(12, 9), wanted in wanted(), rest in 0..15_i64, cuts in proptest::collection::vec(any::<bool>(), 24)) {
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
    fn wakes_of_statistics_come_exactly_when_time_alone_decides(trace in traces(12, 9), wanted in wanted()) {
        let mut world = World::new(&condition(wanted.condition()));
        let mut first = None;
        let groups = instants(&trace);
        for (index, group) in groups.iter().enumerate() {
            tell(&mut world, group);
            let mut now = group[0].0;
            let until = groups.get(index + 1).map_or(i64::MAX, |next| next[0].0);
            while now < until && first.is_none() {
                first = world.answer(now).map(|(_, _, known)| (now, known));
                match next_wake(&world.monitor) {
                    Some((wake, _)) if wake.0 < until => {
                        prop_assert!(wake.0 > now, "a wake at {} asked at {}", wake.0, now);
                        now = wake.0;
                    }
                    _ => break,
                }
            }
        }
        let last = trace.last().map_or(0, |last| last.0);
        let expected = wanted.result(&valid(&trace), last + 40).map(|(_, _, known)| (known, known));
        prop_assert_eq!(first, expected);
    }

    #[test]
    fn late_numbers_lead_to_the_same_result_as_timely_ones(trace in traces(12, 9), wanted in wanted(), order in proptest::collection::vec(0..9_i64, 24)) {
        let samples = valid(&trace);
        let mut arrivals: Vec<(i64, i64, i64)> = samples.iter().zip(&order).map(|((at, value), delay)| (at + delay, *at, *value)).collect();
        arrivals.sort();
        let mut world = World::in_view(&condition(wanted.condition()), late_view("a", 9));
        for (_, at, value) in arrivals {
            world.sample("a", "uav", Value::Integer(value), at);
        }
        let end = world.view.now.0 + 3;
        prop_assert_eq!(world.answer(end), wanted.result(&samples, end));
    }

    #[test]
    fn a_monitor_made_later_finds_the_same(trace in traces(12, 9), wanted in wanted(), rest in 0..15_i64) {
        let end = trace.last().map_or(0, |last| last.0) + rest;
        let wanted_condition = condition(wanted.condition());
        let mut world = World::new(&wanted_condition);
        world.view.histories.require_lookback(&Symbol::new("a"), Duration::MAX);
        tell(&mut world, &trace);
        world.view.now = Time(end);
        world.monitor = create(&wanted_condition, Window::from(Time(0)), &world.view).unwrap();
        let found = world.answer(end).map(|(first, last, _)| (first, last));
        prop_assert_eq!(found, wanted.result(&valid(&trace), end).map(|(first, last, _)| (first, last)));
    }
}
