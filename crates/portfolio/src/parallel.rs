//! Independent tasks on several threads: results are in the order of the tasks, whatever the order of execution.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::channel;

/// Runs `task` for each number below `count` on `threads` threads; `done` is called on this thread after each task.
///
/// # Errors
/// The error of the first task (by number) that failed; no further task is started afterwards.
pub fn each<T: Send>(
    threads: usize,
    count: usize,
    task: impl Fn(usize) -> Result<T, String> + Sync,
    mut done: impl FnMut(),
) -> Result<Vec<T>, String> {
    let (next, failed) = (AtomicUsize::new(0), AtomicBool::new(false));
    let mut results: Vec<Option<Result<T, String>>> = (0..count).map(|_| None).collect();
    std::thread::scope(|scope| {
        let (sender, receiver) = channel();
        for _ in 0..threads {
            let (sender, next, failed, task) = (sender.clone(), &next, &failed, &task);
            scope.spawn(move || {
                while !failed.load(Ordering::Relaxed) {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= count {
                        break;
                    }
                    let result = task(number);
                    failed.fetch_or(result.is_err(), Ordering::Relaxed);
                    if sender.send((number, result)).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        for (number, result) in receiver {
            if let Some(slot) = results.get_mut(number) {
                *slot = Some(result);
            }
            done();
        }
    });
    // Tasks begin in order of their numbers, so every task before the first failed one has run.
    results.into_iter().flatten().collect()
}

/// Returns the results of `task` for each number below `count`, in their order, computed on all processors.
pub fn on_all_processors<T: Send>(count: usize, task: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(count);
    if threads < 2 {
        return (0..count).map(task).collect();
    }
    // A task that cannot fail leaves none out.
    each(threads, count, |number| Ok(task(number)), || ()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::{each, on_all_processors};

    #[test]
    fn results_of_all_processors_come_in_the_order_of_the_numbers() {
        for count in [0, 1, 2, 3, 50] {
            let squares: Vec<usize> = (0..count).map(|number| number * number).collect();
            assert_eq!(on_all_processors(count, |number| number * number), squares);
        }
    }

    #[test]
    fn results_and_the_first_failure_come_in_the_order_of_the_tasks() {
        let mut calls = 0;
        assert_eq!(each(3, 5, |number| Ok(number * number), || calls += 1), Ok(vec![0, 1, 4, 9, 16]));
        assert_eq!(calls, 5);
        let odd = |number: usize| if number % 2 == 1 { Err(number.to_string()) } else { Ok(number) };
        assert_eq!(each(4, 9, odd, || ()), Err("1".to_string()));
    }
}
