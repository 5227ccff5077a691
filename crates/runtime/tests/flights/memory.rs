//! The memory budget of an agent: a task that exceeds it fails with the limit as its cause, and a replay does the same.

use crate::support::{load, record};
use apex_runtime::program::NoDeliberator;
use apex_runtime::record::RecordReader;
use apex_runtime::replay::replay;
use apex_runtime::trace::{TraceFilter, TraceFormat, trace_record};

/// Returns the trace of a program as text; its record is replayed.
fn traced(pdl: &str) -> String {
    let flight = record(pdl, Vec::new(), &mut NoDeliberator, &mut []);
    let reader: RecordReader = flight.reader();
    assert_eq!(replay(&reader, &load).unwrap().difference, None);
    let trace = trace_record(&reader, Vec::new(), TraceFormat::Text, TraceFilter::default()).unwrap();
    String::from_utf8(trace).unwrap()
}

#[test]
fn more_tasks_than_the_budget_has_space_for_fail_what_makes_them() {
    let text = traced(
        "(agent pilot :limits (:memory-mebibytes 1))
         (procedure :sequential (index (do-domain))
           (step few (photograph ?site) (forall ?site in (range 300)))
           (step many (photograph ?site) (forall ?site in (range 3000)) (on-failure (print \"too many\")))
           (step last (print \"still here\")))
         (primitive (index (photograph ?site)) (duration 1s))",
    );
    let made = text.matches("created because").count();
    assert!(
        text.contains("the limit MEMORY_MEBIBYTES_MAX = 1 was reached"),
        "{}",
        text.chars().take(2_000).collect::<String>()
    );
    assert!(text.contains("prints too many") && text.contains("prints still here"));
    assert!((400..1_300).contains(&made), "{made} tasks were made");
}

#[test]
fn values_count_as_long_as_a_task_holds_them() {
    let lists = "(agent pilot :limits (:memory-mebibytes 1))
         (procedure :sequential (index (do-domain))
           (step keep (keep) (on-failure (print \"too large\")))
           (step last (print \"still here\")))
         (procedure :sequential (index (keep))
           (step a (wait) (select ?one (range 20000)))
           (step b (wait) (select ?two (range 20000)))
           (step c (wait) (select ?three (range 20000))))
         (primitive (index (wait)) (duration 1s))";
    let text = traced(lists);
    assert!(
        text.contains("the limit MEMORY_MEBIBYTES_MAX = 1 was reached"),
        "{}",
        text.chars().take(2_000).collect::<String>()
    );
    assert!(text.contains("prints too large") && text.contains("prints still here"));
    // The same lists in sequence, each in a procedure that ends, fit into the budget.
    let apart = lists.replace("(step a (wait) (select ?one (range 20000)))", "(step a (one))").replace(
        "(step b (wait) (select ?two (range 20000)))\n           (step c (wait) (select ?three (range 20000))))",
        "(step b (one)) (step c (one)))
         (procedure (index (one)) (step a (wait) (select ?list (range 20000))))",
    );
    assert!(!traced(&apart).contains("MEMORY_MEBIBYTES_MAX"));
}

#[test]
fn a_budget_may_be_larger_than_usual() {
    let text = traced(
        "(agent pilot :limits (:memory-mebibytes 4096))
         (procedure (index (do-domain)) (step a (print \"well\")))",
    );
    assert!(text.contains("prints well"), "{text}");
}
