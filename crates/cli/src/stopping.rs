//! Ctrl-C and SIGTERM: end a flight in an orderly way, with its report and its record.

use apex_runtime::Control;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver};

/// Exit code of a program that Ctrl-C ends: 128 and the number of the signal.
pub const INTERRUPTED: i32 = 130;

/// Calls `stop` at the first Ctrl-C or SIGTERM; the second ends the program at once. If a program that embeds this command has its own
/// handler, that handler stays.
pub fn at_signal(stop: impl Fn() + Send + 'static) {
    let again = AtomicBool::new(false);
    // Only one handler is possible, and the first one stays.
    let _ = ctrlc::set_handler(move || {
        if again.swap(true, Ordering::Relaxed) {
            std::process::exit(INTERRUPTED);
        }
        stop();
    });
}

/// Returns a channel that ends the flight cleanly on Ctrl-C and SIGTERM.
pub fn controls() -> Receiver<Control> {
    let (say, controls) = mpsc::channel();
    // The receiver exists, because it is returned.
    say.send(Control::Quiet).unwrap_or_default();
    at_signal(move || {
        if say.send(Control::Stop).is_err() {
            std::process::exit(INTERRUPTED);
        }
    });
    controls
}
