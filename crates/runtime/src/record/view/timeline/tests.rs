//! The timeline against its naive twin: all intervals of a random flight, counted one by one.

use super::super::index::{Interval, TaskIndex};
use super::super::state::StateWord;
use super::bands::Bands;
use super::lanes::ROWS_MAX;
use super::pieces::Pieces;
use super::shapes::Bar;
use super::window::Window;
use super::{Timeline, draw};
use apex_model::task::TaskState;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A seeded generator: tests have no random source.
struct Dice(ChaCha8Rng);

impl Dice {
    fn below(&mut self, limit: u64) -> u64 {
        (self.0.next_u64() >> 33) % limit
    }
}

/// Returns a root with steps whose tasks repeat, run concurrently, or take no time.
fn flight(dice: &mut Dice) -> TaskIndex {
    let mut index = TaskIndex::default();
    index.insert(0, None, "root", &[(0, TaskState::Pending), (0, TaskState::Ongoing)]);
    for id in 1..1 + dice.below(120) {
        let parent = dice.below(id.min(4));
        let tag = format!("s{}", dice.below(5));
        let mut at_ns = i64::try_from(dice.below(9_000)).unwrap();
        let mut changes = vec![(at_ns, TaskState::Pending)];
        let short = dice.below(2) == 0;
        for _ in 0..dice.below(60) {
            at_ns += i64::try_from(dice.below(if short { 4 } else { 900 })).unwrap();
            let states = [
                TaskState::Pending,
                TaskState::Enabled,
                TaskState::Ongoing,
                TaskState::Interrupted,
                TaskState::Terminated,
            ];
            changes.push((at_ns, states[usize::try_from(dice.below(5)).unwrap()]));
        }
        index.insert(id, Some(parent), &tag, &changes);
    }
    index
}

/// Returns every interval that must be drawn.
fn naive(index: &TaskIndex, window: Window) -> Vec<Interval> {
    index.tasks().values().flat_map(|task| task.drawn(window.from_ns, window.known_ns())).collect()
}

fn counted(timeline: &Timeline) -> (usize, usize) {
    let bars = timeline.lanes.iter().flat_map(|lane| &lane.rows).map(Vec::len).sum();
    let bands = timeline.lanes.iter().flat_map(|lane| &lane.bands).chain(&timeline.more.bands);
    (bars, bands.map(|band| band.count).sum())
}

#[test]
fn every_interval_of_any_window_is_one_bar_or_counted_in_one_band() {
    let mut dice = Dice(ChaCha8Rng::seed_from_u64(7));
    for round in 0..300 {
        let index = flight(&mut dice);
        let mut number = |limit: u64| i64::try_from(dice.below(limit)).unwrap();
        let from_ns = number(9_000);
        let window = Window::new((from_ns, from_ns + number(9_000)), number(20_000), 1 + number(400) as usize);
        let timeline = draw(&index, window, 1 + number(12) as usize, None);
        let (bars, in_bands) = counted(&timeline);
        let every = naive(&index, window);
        assert_eq!(bars + in_bands, every.len(), "round {round}: {window:?}");
        let is_active = |interval: &&Interval| interval.state.0 != TaskState::Pending;
        let active_ns: i64 = every.iter().filter(is_active).map(|interval| interval.length_ns()).sum();
        let all = draw(&index, window, usize::MAX, None);
        assert_eq!(all.lanes.iter().map(|lane| lane.active_ns).sum::<i64>(), active_ns, "round {round}: {window:?}");
        let marks = timeline.lanes.iter().map(|lane| lane.bands.len() + lane.rows.iter().map(Vec::len).sum::<usize>());
        assert!(marks.min().is_none_or(|least| least > 0), "round {round}: a lane without a mark");
        let later = timeline.lanes.iter().flat_map(|lane| lane.rows.iter().flatten()).map(|bar| bar.to_ns);
        let bands = timeline.lanes.iter().flat_map(|lane| &lane.bands).chain(&timeline.more.bands);
        for band in bands.clone() {
            let start_ns = window.start_ns(band.pixel);
            let end_ns = window.start_ns(band.pixel + band.pixels).min(window.known_ns()).max(start_ns);
            assert_eq!((band.from_ns, band.to_ns), (start_ns, end_ns), "round {round}: pixels of {band:?}");
        }
        let latest = later.chain(bands.map(|band| band.to_ns)).max();
        assert!(latest.is_none_or(|latest| latest <= window.known_ns()), "round {round}: drawn beyond {window:?}");
    }
}

#[test]
fn bands_keep_the_shares_of_their_pixels() {
    let mut dice = Dice(ChaCha8Rng::seed_from_u64(11));
    for round in 0..200 {
        // One task that works in turns of about the same length, below a lane that is always shown.
        let mut index = TaskIndex::default();
        index.insert(0, None, "root", &[(0, TaskState::Ongoing)]);
        let (work, wait) = (1 + dice.below(30), 1 + dice.below(30));
        let mut at_ns = 0;
        let mut changes = Vec::new();
        for turn in 0..400 {
            let state = if turn % 2 == 0 { TaskState::Ongoing } else { TaskState::Pending };
            changes.push((at_ns, state));
            let length = if turn % 2 == 0 { work } else { wait };
            at_ns += i64::try_from(length + dice.below(1 + length / 4)).unwrap();
        }
        index.insert(1, Some(0), "turns", &changes);
        let window = Window::new((0, 9_000), 20_000, 1 + dice.below(60) as usize);
        let timeline = draw(&index, window, 1, None);
        let share = |pixel: usize| {
            let (from_ns, to_ns) = (window.start_ns(pixel), window.start_ns(pixel + 1));
            let drawn = index.get(1).unwrap().drawn(window.from_ns, window.known_ns());
            let ongoing = drawn.filter(|interval| interval.state.0 == TaskState::Ongoing);
            let inside = ongoing.map(|one| (one.to_ns.min(to_ns) - one.from_ns.max(from_ns)).max(0)).sum::<i64>();
            (inside as f64 / window.pixel_ns as f64).min(1.0)
        };
        for band in &timeline.more.bands {
            let shares: Vec<f64> = (band.pixel..band.pixel + band.pixels).map(share).collect();
            let mean = shares.iter().sum::<f64>() / shares.len() as f64;
            assert!((band.ongoing - mean).abs() < 1e-9, "round {round}: {band:?} {shares:?}");
            assert!(shares.iter().all(|one| (one - shares[0]).abs() < 0.0201), "round {round}: {band:?} {shares:?}");
            assert!(shares.iter().all(|one| (*one > 0.0) == (shares[0] > 0.0)), "round {round}: {band:?} {shares:?}");
        }
    }
}

#[test]
fn a_thousand_tasks_at_once_are_eight_rows_and_a_band() {
    let mut index = TaskIndex::default();
    index.insert(0, None, "root", &[(0, TaskState::Ongoing)]);
    for id in 1..=1_000 {
        index.insert(id, Some(0), "scan", &[(100, TaskState::Ongoing), (900, TaskState::Terminated)]);
    }
    let window = Window::new((0, 1_000), 1_000, 100);
    let timeline = draw(&index, window, 40, None);
    let scan = timeline.lanes.iter().find(|lane| lane.tag == "scan").unwrap();
    assert_eq!((scan.rows.len(), scan.tasks), (ROWS_MAX, 1_000));
    assert_eq!(scan.bands.iter().map(|band| band.count).sum::<usize>(), 992);
    assert_eq!((scan.bands.first().unwrap().from_ns, scan.bands.last().unwrap().to_ns), (100, 900));
    assert!(scan.bands.iter().all(|band| band.ongoing == 1.0));
}

#[test]
fn a_task_of_many_intervals_is_dense_from_afar_and_bars_from_near() {
    let mut index = TaskIndex::default();
    let changes: Vec<(i64, TaskState)> =
        (0..4_000).map(|n| (n * 5, if n % 2 == 0 { TaskState::Ongoing } else { TaskState::Pending })).collect();
    index.insert(0, None, "root", &changes);
    let window = |from_ns, to_ns| Window::new((from_ns, to_ns), 100_000, 100);
    let far = draw(&index, window(0, 20_000), 40, None);
    assert_eq!(counted(&far), (0, 4_000));
    assert!(far.lanes[0].bands.iter().all(|band| (band.ongoing - 0.5).abs() < 1e-9));
    // A hundred pixels that look the same are one band.
    assert_eq!(serde_json::to_string(&far.lanes[0].bands).unwrap(), "[[0,100,4000,500]]");
    let near = draw(&index, window(1_000, 1_020), 40, None);
    // The row in JSON is one run of bars.
    let lane = serde_json::to_value(&near.lanes[0]).unwrap();
    assert_eq!(lane["rows"], serde_json::json!([[[0, 1_000, 2, 5, 0, 5, 2, 5, 0, 5, 2, 0]]]));
    let near = draw(&index, window(1_000, 1_100), 40, None);
    assert_eq!(counted(&near).1, 0);
    assert_eq!(near.lanes[0].rows[0].first().map(|bar| bar.state), Some(StateWord(TaskState::Ongoing)));
}

#[test]
fn the_lane_of_a_chosen_task_and_those_above_it_have_a_place() {
    let mut index = TaskIndex::default();
    index.insert(0, None, "root", &[(0, TaskState::Ongoing)]);
    for id in 1..20 {
        let length = i64::try_from(id).unwrap() * 10;
        index.insert(id, Some(0), &format!("s{id}"), &[(0, TaskState::Ongoing), (length, TaskState::Terminated)]);
    }
    let window = Window::new((0, 1_000), 1_000, 100);
    let tags = |with| draw(&index, window, 2, with).lanes.into_iter().map(|lane| lane.tag).collect::<Vec<_>>();
    assert_eq!(tags(None), ["root", "s19"]);
    assert_eq!(tags(Some(3)), ["root", "s3"]);
    assert_eq!(draw(&index, window, 2, None).more.lanes, 18);
}

/// Reads the bars of a lane's row back from its JSON.
fn unpack(row: &serde_json::Value) -> Vec<Bar> {
    let mut bars = Vec::new();
    for run in row.as_array().unwrap() {
        let run: Vec<i64> = run.as_array().unwrap().iter().map(|one| one.as_i64().unwrap()).collect();
        let (head, spans) = run.split_at(2);
        let mut from_ns = head[1];
        for span in spans.chunks_exact(2) {
            let states = [TaskState::Pending, TaskState::Enabled, TaskState::Ongoing, TaskState::Interrupted];
            let state = StateWord(states[usize::try_from(span[0]).unwrap()]);
            bars.push(Bar { task: u64::try_from(head[0]).unwrap(), state, from_ns, to_ns: from_ns + span[1] });
            from_ns += span[1];
        }
    }
    bars
}

#[test]
fn the_runs_of_a_row_are_its_bars() {
    let mut dice = Dice(ChaCha8Rng::seed_from_u64(17));
    let mut bars = 0;
    for round in 0..100 {
        let index = flight(&mut dice);
        let window = Window::new((0, 9_000), 20_000, 1 + dice.below(400) as usize);
        for lane in draw(&index, window, usize::MAX, None).lanes {
            let json = serde_json::to_value(&lane).unwrap();
            let rows: Vec<Vec<Bar>> = json["rows"].as_array().unwrap().iter().map(unpack).collect();
            bars += rows.iter().map(Vec::len).sum::<usize>();
            assert_eq!(rows, lane.rows, "round {round}: {window:?}");
        }
    }
    assert!(bars > 10_000, "{bars}");
}

/// Returns a task that changes its state often, with some long stretches.
fn busy(dice: &mut Dice) -> TaskIndex {
    let mut index = TaskIndex::default();
    let mut at_ns = i64::try_from(dice.below(50)).unwrap();
    let mut changes = vec![(at_ns, TaskState::Pending)];
    let long = 1 + dice.below(200);
    for _ in 0..dice.below(2_500) {
        let step = if dice.below(long) == 0 { 900 } else { 5 };
        at_ns += i64::try_from(dice.below(step)).unwrap();
        let states = [TaskState::Pending, TaskState::Ongoing, TaskState::Terminated, TaskState::Interrupted];
        changes.push((at_ns, states[usize::try_from(dice.below(4)).unwrap()]));
    }
    index.insert(1, None, "busy", &changes);
    index
}

#[test]
fn sums_of_short_intervals_are_those_of_the_intervals_one_by_one() {
    let mut dice = Dice(ChaCha8Rng::seed_from_u64(13));
    let mut summed = 0;
    for round in 0..2_000 {
        let index = busy(&mut dice);
        let task = index.get(1).unwrap();
        let mut number = |limit: u64| i64::try_from(dice.below(limit)).unwrap();
        let from_ns = number(2_500);
        let window = Window::new((from_ns, from_ns + number(4_000)), number(6_000), 1 + number(150) as usize);
        let pieces = Pieces::of(task, window);
        summed += pieces.sums.len();
        let every = Pieces::expanded(task, window);
        let count = pieces.single.len() + pieces.sums.iter().map(|sum| sum.count).sum::<usize>();
        assert_eq!(count, every.single.len(), "round {round}: {window:?}");
        assert!(pieces.single.iter().all(|one| every.single.contains(one)), "round {round}: {window:?}");
        let span = every.single.first().zip(every.single.last()).map(|(first, last)| (first.from_ns, last.to_ns));
        assert_eq!(task.drawn_span(window.from_ns, window.known_ns()), span, "round {round}: {window:?}");
        let drawn = |pieces: Pieces| {
            let mut bands = Bands::new(window);
            bands.add_all(pieces);
            bands.finish()
        };
        assert_eq!(drawn(pieces), drawn(every), "round {round}: {window:?}");
    }
    assert!(summed > 5_000, "{summed}");
}
