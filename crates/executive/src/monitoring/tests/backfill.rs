//! Looking back as an episode index does leaves an episode in the same state as passing its samples one by one.

use super::*;
use crate::monitoring::episodes::episode;
use proptest::prelude::*;

proptest! {
    #[test]
    fn quick_looking_back_is_looking_back(
        mut samples in prop::collection::vec((0i64..60, 0i64..10, 0u8..12), 0..40),
        (start, later) in (0i64..20, 0i64..12),
        (least, duration) in (prop::option::of(0i64..8), 0i64..9),
        gap in prop::option::of(1i64..8),
        every in any::<bool>(),
    ) {
        samples.sort();
        let mut view = TestView::default();
        view.histories.require_lookback_of_all(Duration(1_000));
        for (number, (at, value, kind)) in samples.iter().enumerate() {
            // Occasionally a real, or a value that cannot be compared.
            let value = match kind {
                0 => Value::Real(*value as f64 + 0.5),
                1 => Value::symbol("odd"),
                _ => Value::Integer(*value),
            };
            let variable = StateVariable::new(Symbol::new("a"), Value::symbol("uav"));
            record_sample(&mut view.histories, &VariableIndex::new(&view.library), variable, value, Time(*at), number as u64);
        }
        view.now = Time(samples.last().map_or(0, |last| last.0) + later);
        let least = least.map(|least| compare(Relation::GreaterOrEqual, int(least)));
        let duration = vec![compare(Relation::Greater, span(duration))];
        let condition = Arc::new(super::episode(uav("a"), least.into_iter().collect(), gap, duration));
        let keep = if every { Keep::Every } else { Keep::First };
        let site = PartContext { window: Window::from(Time(start)), keep, place: Place::default() };
        let mut quick = episode::create(&condition, false, &view).unwrap();
        let mut slow = quick.clone();
        let (mut of_quick, mut of_slow) = (ConditionFaults::none(&view), ConditionFaults::none(&view));
        episode::backfill(&mut quick, site, &view, &mut of_quick);
        episode::backfill_with(|_, _, _, _, _| 0, &mut slow, site, &view, &mut of_slow);
        prop_assert_eq!(quick, slow);
        prop_assert_eq!(of_quick.list, of_slow.list);
    }
}
