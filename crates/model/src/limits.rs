//! Every limit of the core, with its reason. Loops over external input take their bound from here. An agent may lower some of them:
//! [`crate::agent_limits`].

/// Rounds of notice/enable/choose/contend/commit/act at one instant, except for those in which tasks only end: a chain of steps that take
/// no time is as long as the program states, and ends without intervention.
pub const CASCADE_ROUNDS_MAX: u32 = 10_000;
/// Nesting of lists in PDL text: deeper than any human writes, shallower than the stack.
pub const READ_DEPTH_MAX: usize = 256;
/// Bytes of one PDL source file: a thousand times the largest mission known.
pub const SOURCE_BYTES_MAX: usize = 16 << 20;
/// Nesting of expression evaluation (calls of `defun`s included).
pub const EVALUATION_DEPTH_MAX: u32 = 128;
/// Expression nodes evaluated for one clause.
pub const EVALUATION_STEPS_MAX: u64 = 1_000_000;
/// Steps of pattern matching with segments, which can backtrack.
pub const MATCH_STEPS_MAX: u64 = 10_000;
/// Nesting of tasks: a procedure that calls itself without bound ends here, with a cause.
pub const TASK_DEPTH_MAX: u32 = 200;
/// Tasks of one agent, with the ended ones that siblings may still refer to: 600 MB of them.
pub const TASKS_MAX: usize = 1_000_000;
/// Mebibytes that one agent may hold in tasks, monitors, values, histories and the decisions of one instant.
pub const MEMORY_MEBIBYTES_MAX: u64 = 1_024;
/// Items of one `forall`.
pub const FORALL_ITEMS_MAX: usize = 100_000;
/// Instances of a `repeating` step that start and end at one instant.
pub const REPETITIONS_PER_INSTANT_MAX: u32 = 1_000;
/// Instants within one second at which one step is repeated without an input from outside in between: ten times as fast as any
/// controller, and far slower than a repetition that waits for a nanosecond.
pub const REPETITIONS_PER_SECOND_MAX: u32 = 10_000;
/// Samples kept of one state variable, whatever conditions require: 20 hours of attitude at 5 Hz.
pub const HISTORY_SAMPLES_MAX: usize = 360_000;
/// Samples kept of a variable for which no condition or log clause requires more.
pub const HISTORY_SAMPLES_DEFAULT: usize = 2;
/// Events remembered for monitors created later in the same instant and for short look-backs.
pub const EVENT_HISTORY_MAX: usize = 1_000;
/// Events of one batch: the runtime splits larger ones.
pub const BATCH_EVENTS_MAX: usize = 100_000;
/// Characters of one printed text or one message.
pub const TEXT_CHARACTERS_MAX: usize = 65_536;
/// Items of a list that an expression makes.
pub const LIST_ITEMS_MAX: usize = 1_000_000;
/// Solver requests that may be open at one time.
pub const SOLVE_REQUESTS_MAX: usize = 64;
/// Seconds after which a command without an answer has failed, where the primitive gives no timeout.
pub const COMMAND_TIMEOUT_DEFAULT_S: i64 = 6 * 3600;
/// Seconds after which a request to a solver without an answer has failed, if no budget is stated.
pub const SOLVE_TIMEOUT_DEFAULT_S: i64 = 3600;
/// Seconds that a solver may answer later than its budget: a plan that is a little late is better than none.
pub const SOLVE_GRACE_S: i64 = 60;
/// Late samples of one variable kept for explanations: enough to show the pattern of a bad link.
pub const LATE_SAMPLES_MAX: usize = 64;
/// Results that one part of a condition remembers for combination with other parts; the oldest are dropped first.
pub const MONITOR_RESULTS_MAX: usize = 4_096;
/// Combinations of results tried for one composite condition at one instant.
pub const MONITOR_COMBINATIONS_MAX: u64 = 100_000;
/// Objects that one condition with an object variable follows.
pub const MONITOR_OBJECTS_MAX: usize = 10_000;
/// Values passed to a `:custom` trend: a list of them is made at every sample.
pub const CUSTOM_VALUES_MAX: usize = 10_000;
/// Numbers kept in order for the median of a run that has no end: a day of 10 Hz, 100 MB.
pub const MEDIAN_NUMBERS_MAX: u64 = 1_000_000;
/// Instants at which samples leave a sliding window that are examined before the next wake: the next sample mostly arrives first.
pub const WINDOW_FORESIGHT_MAX: usize = 4;
/// Evaluations of two changing priorities to find their crossing: about 30 halvings of each of 30 spans.
pub const PRIORITY_SEARCH_MAX: u32 = 2_000;
/// Milliseconds after which two priorities are compared again if their crossing cannot be computed.
pub const PRIORITY_LOOK_AGAIN_MS: i64 = 250;
/// Milliseconds between updates of a primitive whose `update` states no interval: as fast as a pilot corrects the controls.
pub const UPDATE_INTERVAL_DEFAULT_MS: i64 = 100;
/// Remembered spacings of samples of a variable, each shorter than the preceding one, with which a monitoring session finds the largest
/// gap of a result; samples at a steady rate need a few.
pub const SPACINGS_MAX: usize = 1_000;
/// Errors that a monitoring session keeps until the caller takes them.
pub const SESSION_TROUBLES_MAX: usize = 1_000;
