//! Memory of a waiting task, counted by the allocator: the state of the agent, without the library and effects.
#![allow(clippy::print_stdout, reason = "the table is what the program is for")]
#![allow(clippy::expect_used, reason = "a figure that cannot be kept must stop the measurement")]

use apex_benches::{Driven, WATCHERS, library, programs, rows};
use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Makes the program with a given number of waiting tasks.
type ProgramText = fn(usize) -> String;

fn main() {
    println!("| waiting | tasks | bytes a waiting task |\n|---|---|---|");
    let shapes: [(&str, ProgramText); 3] = [
        ("steps of one procedure, each for its own variable", programs::waiting),
        ("steps of one procedure, each for its own bound of one variable", programs::bounds),
        ("procedures of one step, each for its own variable", |count| WATCHERS.replace("COUNT", &count.to_string())),
    ];
    for (name, text) in shapes {
        let mut figures = Vec::new();
        for count in [100_usize, 1_000, 10_000, 100_000] {
            let text = text(count);
            let library = library(&text);
            let ready = Driven::ready(&library);
            let before = MEMORY.current_usage();
            let (driven, effects) = ready.begin();
            assert!(effects.len() > count, "not all tasks were made");
            drop(effects);
            let bytes = MEMORY.current_usage().saturating_sub(before);
            println!("| {name} | {count} | {} |", bytes / count);
            figures.push((count as u64, bytes as f64 / count as f64));
            drop(driven);
        }
        rows::keep("memory", name, &figures).expect("the row is written");
    }
}
