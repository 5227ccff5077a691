//! Allen relations of three parts, compared with a naive search over all triples of results.

use super::relations::{RELATIONS, Side, decided, related, traces};
use super::*;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    /// Results of the three parts arrive in any order; the naive search examines all triples.
    #[test]
    fn chains_relate_each_part_to_the_next(
        trace in traces(), more in traces(), which in 0..13_usize, least in 0..3_i64,
    ) {
        let relation = RELATIONS[which];
        let side = Side::Runs { gap: None, least };
        let parts = ["a", "b", "c"].map(|name| side.condition(name)).to_vec();
        let mut world = World::new(&related(relation, 0, parts));
        let mut all: Vec<(&str, i64, i64)> =
            trace.iter().map(|(first, at, value)| (if *first { "a" } else { "b" }, *at, *value)).collect();
        all.extend(more.iter().filter(|(first, ..)| *first).map(|(_, at, value)| ("c", *at, *value)));
        all.sort_by_key(|(_, at, _)| *at);
        let mut told = Vec::new();
        for group in all.chunk_by(|a, b| a.1 == b.1) {
            let now = group[0].1;
            for (name, at, value) in group {
                world.sample(name, "uav", Value::Integer(*value), *at);
            }
            told.extend_from_slice(group);
            let of = |name: &str| {
                let samples: Vec<(i64, i64)> =
                    told.iter().filter(|(each, ..)| *each == name).map(|(_, at, value)| (*at, *value)).collect();
                side.intervals(&samples, now)
            };
            let (a, b, c) = (of("a"), of("b"), of("c"));
            let mut triples = Vec::new();
            for middle in &b {
                for first in a.iter().filter(|first| !decided(relation, 0, &[**first], &[*middle], now).is_empty()) {
                    for last in c.iter().filter(|last| !decided(relation, 0, &[*middle], &[**last], now).is_empty()) {
                        triples.push([first.0, middle.0, last.0]);
                    }
                }
            }
            let expected = triples.iter().min().map(|triple| {
                let start = triple.iter().map(|each| each.0).min().unwrap();
                (start, triple.iter().map(|each| each.1).max().unwrap(), now)
            });
            let answer = world.answer(now);
            prop_assert_eq!(answer, expected, "{:?} at {}", relation, now);
            if answer.is_some() {
                break;
            }
        }
    }
}
