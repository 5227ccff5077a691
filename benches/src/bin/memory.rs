//! What a waiting task takes of memory, counted by the allocator: the state of the agent, without library and effects.
#![allow(clippy::print_stdout, reason = "the table is what the program is for")]

use apex_benches::{Driven, WATCHERS, library, programs};
use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

fn main() {
    println!("| waiting | tasks | bytes a waiting task |\n|---|---|---|");
    for count in [100_usize, 1_000, 10_000, 100_000] {
        for (name, text) in [
            ("steps of one procedure, each for its own variable", programs::waiting(count)),
            ("steps of one procedure, each for its own bound of one variable", programs::bounds(count)),
            ("procedures of one step, each for its own variable", WATCHERS.replace("COUNT", &count.to_string())),
        ] {
            let library = library(&text);
            let ready = Driven::ready(&library);
            let before = MEMORY.current_usage();
            let (driven, effects) = ready.begin();
            assert!(effects.len() > count, "not all tasks were made");
            drop(effects);
            let bytes = MEMORY.current_usage().saturating_sub(before);
            println!("| {name} | {count} | {} |", bytes / count);
            drop(driven);
        }
    }
}
