//! Flights of a scanner over fires, as recorded measurements, against closed forms and against a witness that samples points.

#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::float_arithmetic,
    reason = "a test stops at an unexpected result"
)]

use apex_mission::Mission;
use apex_mission::deliberation::{MissionDeliberator, PlanningResources};
use apex_mission::report::{MissionValue, report};
use apex_mission::score::{FlightScore, FlownScore, ScoredLook};
use apex_mission::situation::Situation;
use apex_model::because::{Because, Cause};
use apex_model::effect::{Decision, DecisionKind, Effect, SolveRequest, SolveRequestId};
use apex_model::event::{Batch, Event, EventKind, SolverReport, StateVariable};
use apex_model::quantity::{Quantity, UNITS};
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_observation::result::LossCause;
use apex_runtime::ports::{CancelToken, Deliberator};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::path::Path;
use std::sync::Arc;

/// Latitude of the fires: near Zaca.
const LATITUDE_DEG: f64 = 34.7;
const LONGITUDE_DEG: f64 = -119.8;
const RADIUS_M: f64 = 6_371_008.8;
/// Half of the scanner's field of view, its pixel, and the height of the lines above ground.
const HALF_FIELD_RAD: f64 = 43.0 * std::f64::consts::PI / 180.0;
const PIXEL_RAD: f64 = 1.25e-3;
const HEIGHT_M: f64 = 6_000.0;
/// Mission times of 13:27 local time on 8 September 2007, and of midnight before; mission time 0 is 18:00 local on the 7th.
const AFTERNOON_S: f64 = 19.45 * 3600.0;
const MIDNIGHT_S: f64 = 6.0 * 3600.0;

/// One line: offset north of the fires' middle, its start and end east of it, its beginning in time, and its roll by distance flown.
struct Line {
    north_m: f64,
    from_m: f64,
    to_m: f64,
    begin_s: f64,
    height_m: f64,
    roll_deg: fn(f64) -> f64,
    /// Without attitude in the record.
    bare: bool,
}

impl Line {
    fn new(north_m: f64, from_m: f64, to_m: f64, begin_s: f64) -> Line {
        Line { north_m, from_m, to_m, begin_s, height_m: HEIGHT_M, roll_deg: |_| 0.0, bare: false }
    }
}

const SPEED_MPS: f64 = 100.0;

fn position(east_m: f64, north_m: f64) -> (f64, f64) {
    let latitude_deg = LATITUDE_DEG + (north_m / RADIUS_M).to_degrees();
    (latitude_deg, LONGITUDE_DEG + (east_m / RADIUS_M / libm::cos(LATITUDE_DEG.to_radians())).to_degrees())
}

/// A box around the middle, `[west, east]` by `[south, north]`, as coordinates of GeoJSON.
fn box_of(east_m: [f64; 2], north_m: [f64; 2]) -> String {
    let corners = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)].map(|(e, n)| {
        let (latitude_deg, longitude_deg) = position(east_m[e], north_m[n]);
        format!("[{longitude_deg:.8}, {latitude_deg:.8}]")
    });
    format!("[[{}]]", corners.join(", "))
}

fn fire(id: &str, ground: &str, properties: &str) -> String {
    format!(
        r#"{{"type": "Feature", "geometry": {{"type": "Polygon", "coordinates": {ground}}},
            "properties": {{"id": "{id}", "kind": "fire", {properties}}}}}"#
    )
}

/// Returns the mission `western-states` with these fires instead.
fn mission(fires: &[String]) -> Result<Mission, String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions/western-states");
    let mission = Mission::load(&folder).unwrap();
    let mut data: Vec<_> = mission.data.iter().cloned().collect();
    let text = format!(r#"{{"type": "FeatureCollection", "features": [{}]}}"#, fires.join(", "));
    data.iter_mut().find(|(name, _)| name == "fires.geojson").unwrap().1 = text.into_bytes();
    Mission::from_sources(&mission.library.sources, data).map_err(|error| {
        let parts = [error.place, Some(error.message), error.reason, error.help];
        parts.into_iter().flatten().collect::<Vec<_>>().join(": ")
    })
}

fn measured(attribute: &str, value: Value) -> EventKind {
    EventKind::Measurement(StateVariable::new(Symbol::new(attribute), Value::symbol("aircraft-1")), value)
}

fn of_unit(number: f64, unit: &str) -> Value {
    let unit = UNITS.iter().find(|known| known.name == unit).unwrap();
    Value::Quantity(Quantity::of(number, unit))
}

/// Returns the batches of a flight along the lines, one every 0.2 s.
fn batches(lines: &[Line]) -> Vec<Batch> {
    let mut batches = Vec::new();
    let mut sequence = 0;
    let mut batch = |at_s: f64, kinds: Vec<EventKind>| {
        let at = Time::from_seconds(at_s);
        let event = |kind| {
            sequence += 1;
            Event { sequence, at, kind }
        };
        batches.push(Batch { now: at, events: kinds.into_iter().map(event).collect() });
    };
    for line in lines {
        let count = ((line.to_m - line.from_m).abs() / SPEED_MPS / 0.2).round() as usize;
        let heading_deg = if line.to_m > line.from_m { 90.0 } else { 270.0 };
        for step in 0..=count {
            let flown_m = step as f64 * 0.2 * SPEED_MPS;
            let east_m = line.from_m + (line.to_m - line.from_m).signum() * flown_m;
            let (latitude_deg, longitude_deg) = position(east_m, line.north_m);
            let place = [latitude_deg, longitude_deg, line.height_m].map(Value::Real);
            let mut kinds =
                vec![measured("location", Value::list(place)), measured("ground-speed", of_unit(SPEED_MPS, "m/s"))];
            if !line.bare {
                kinds.push(measured("heading", of_unit(heading_deg, "deg")));
                kinds.push(measured("roll-angle", of_unit((line.roll_deg)(flown_m), "deg")));
                kinds.push(measured("pitch-angle", of_unit(0.0, "deg")));
            }
            if step == 0 {
                kinds.push(measured("scanner-state", Value::symbol("on")));
            } else if step == count {
                kinds.push(measured("scanner-state", Value::symbol("off")));
            }
            batch(line.begin_s + step as f64 * 0.2, kinds);
        }
    }
    batches
}

fn flown(mission: &Mission, lines: &[Line]) -> FlightScore {
    let mut score = FlownScore::new(mission).unwrap().unwrap();
    batches(lines).iter().for_each(|batch| score.observe(batch));
    let end = (Time::from_seconds(AFTERNOON_S), "it is over".to_string());
    match report(mission, &Situation::default(), Ok(&score), end).value {
        MissionValue::Score(score) => score,
        MissionValue::Ignorance(_, _) | MissionValue::None => panic!("of another kind"),
    }
}

fn look<'s>(score: &'s FlightScore, id: &str) -> &'s ScoredLook {
    score.looks.iter().find(|look| look.id == id).unwrap()
}

fn near(found: f64, wanted: f64, within: f64) {
    assert!((found - wanted).abs() <= within, "{found} instead of {wanted}");
}

/// 10 by 8 km, seen from two lines 4 km apart.
fn two_lines(begin_s: f64) -> [Line; 2] {
    [Line::new(-2_000.0, -5_500.0, 5_500.0, begin_s), Line::new(2_000.0, 5_500.0, -5_500.0, begin_s + 400.0)]
}

const GROUND: ([f64; 2], [f64; 2]) = ([-5_000.0, 5_000.0], [-4_000.0, 4_000.0]);

#[test]
fn a_night_fire_seen_by_day_is_worth_nothing() {
    let ground = box_of(GROUND.0, GROUND.1);
    let wanted = r#""value": 100, "resolution_m": 10, "light": "night""#;
    let mission = mission(&[fire("here", &ground, wanted)]).unwrap();
    let by_day = flown(&mission, &two_lines(AFTERNOON_S));
    let seen = &look(&by_day, "here").flown;
    assert_eq!((seen.points, by_day.benefits), (0.0, 0.0));
    near(seen.factors.coverage, 1.0, 1e-9);
    let lost = seen.losses.iter().find(|loss| loss.cause == LossCause::NoLight).unwrap();
    near(lost.points, 100.0, 0.5);
    let by_night = flown(&mission, &two_lines(MIDNIGHT_S));
    near(by_night.benefits, 100.0, 0.5);
    assert!(by_night.score < by_night.benefits, "personnel costs");
}

#[test]
fn one_line_over_300_000_acres_sees_a_fifth_of_them() {
    let side_m = (300_000.0 * 4_046.856_422_4f64).sqrt();
    let half = [-0.5 * side_m, 0.5 * side_m];
    let mission = mission(&[fire("large", &box_of(half, half), r#""value": 100, "resolution_m": 20"#)]).unwrap();
    for height_m in [6_000.0, 5_330.0] {
        let line = Line { height_m, ..Line::new(0.0, -11_000.0, 11_000.0, MIDNIGHT_S) };
        let score = flown(&mission, &[line]);
        let share = 22_000.0 * 2.0 * height_m * libm::tan(HALF_FIELD_RAD) / (side_m * side_m);
        let seen = &look(&score, "large").flown;
        near(seen.factors.coverage, share, 0.003);
        near(score.benefits, 100.0 * share, 0.3);
    }
}

#[test]
fn what_is_seen_in_the_wrong_order_is_worth_the_discount() {
    let north = box_of([-5_000.0, 5_000.0], [16_000.0, 24_000.0]);
    let south = box_of(GROUND.0, GROUND.1);
    for (early, worth) in [("", 0.0), (r#", "early_factor": 0.5"#, 50.0)] {
        let first = fire("first", &north, r#""value": 10, "resolution_m": 20"#);
        let later = fire("later", &south, &format!(r#""value": 100, "resolution_m": 20, "after": ["first"]{early}"#));
        let mission = mission(&[first, later]).unwrap();
        let after = |begin_s: f64| Line::new(20_000.0, -5_500.0, 5_500.0, begin_s);
        let [a, b] = two_lines(MIDNIGHT_S);
        let wrong = flown(&mission, &[a, b, after(MIDNIGHT_S + 900.0)]);
        near(look(&wrong, "later").flown.points, worth, 0.5);
        let [a, b] = two_lines(MIDNIGHT_S);
        let right = flown(&mission, &[after(MIDNIGHT_S - 900.0), a, b]);
        near(look(&right, "later").flown.points, 100.0, 0.5);
    }
}

#[test]
fn attitude_that_is_not_recorded_is_not_known_and_never_1() {
    let ground = box_of(GROUND.0, GROUND.1);
    let mission = mission(&[fire("here", &ground, r#""value": 100, "resolution_m": 10"#)]).unwrap();
    let lines = two_lines(MIDNIGHT_S).map(|line| Line { bare: true, ..line });
    let mut score = FlownScore::new(&mission).unwrap().unwrap();
    batches(&lines).iter().for_each(|batch| score.observe(batch));
    let end = (Time::from_seconds(AFTERNOON_S), "it is over".to_string());
    let told = report(&mission, &Situation::default(), Ok(&score), end);
    let MissionValue::Score(value) = &told.value else { panic!("of another kind") };
    assert_eq!(look(value, "here").flown.points, 0.0);
    assert!(told.text().contains("not known"), "{}", told.text());
    let clarity = &told.json()["score"]["targets"][0]["clarity"];
    assert!(clarity["factor"].is_null(), "{clarity}");
}

#[test]
fn a_look_by_night_and_one_by_day_are_worth_what_each_is() {
    let ground = box_of(GROUND.0, GROUND.1);
    let looks = r#""resolution_m": 10, "looks": [{"id": "night", "value": 60, "light": "night"}, {"id": "day", "value": 40, "light": "day"}]"#;
    let mission = mission(&[fire("here", &ground, looks)]).unwrap();
    let mut lines: Vec<Line> = two_lines(MIDNIGHT_S).into();
    let only_night = flown(&mission, &lines);
    near(look(&only_night, "here/night").flown.points, 60.0, 0.3);
    near(only_night.benefits, 60.0, 0.3);
    lines.push(Line::new(-2_000.0, -5_500.0, 5_500.0, AFTERNOON_S));
    let both = flown(&mission, &lines);
    near(look(&both, "here/night").flown.points, 60.0, 0.3);
    let by_day = &look(&both, "here/day").flown;
    // The field of view reaches 5.6 km to the side of the line: the northernmost 0.4 km are not seen.
    near(by_day.factors.coverage, (2_000.0 + HEIGHT_M * libm::tan(HALF_FIELD_RAD)) / 8_000.0, 0.005);
}

/// Scores a target by sampling its points: for each point the best of all samples of 0.2 s from which it is seen.
fn witness(ground: ([f64; 2], [f64; 2]), wanted_m: f64, lines: &[Line]) -> f64 {
    const POINTS: u32 = 1_500;
    let mut generator = ChaCha8Rng::seed_from_u64(12_345);
    let mut draw =
        |[low, high]: [f64; 2]| low + (high - low) * (generator.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let mut sum = 0.0;
    for _ in 0..POINTS {
        let (east_m, north_m) = (draw(ground.0), draw(ground.1));
        let mut best: f64 = 0.0;
        for line in lines {
            // Wings level: the sample abeam. A rolled scanner sees the same cross-track plane, tilted.
            let sense = (line.to_m - line.from_m).signum();
            let flown_m = sense * (east_m - line.from_m);
            if !(0.0..=(line.to_m - line.from_m).abs()).contains(&flown_m) {
                continue;
            }
            let roll_deg = (line.roll_deg)(flown_m);
            // Right of the track is positive; a roll to the right moves the sight line to the left.
            let right_m = sense * (line.north_m - north_m);
            let off_rad = libm::atan(right_m / line.height_m);
            let scan_rad = off_rad + roll_deg.to_radians();
            if scan_rad.abs() > HALF_FIELD_RAD || roll_deg.abs() > 3.0 {
                continue;
            }
            let pixel_m = PIXEL_RAD * line.height_m / (libm::cos(off_rad) * libm::cos(off_rad));
            best = best.max(((2.0 * wanted_m - pixel_m) / wanted_m).clamp(0.0, 1.0));
        }
        sum += best;
    }
    sum / f64::from(POINTS)
}

#[test]
fn points_seen_one_by_one_agree_with_the_score() {
    let ground = box_of(GROUND.0, GROUND.1);
    let flights: [fn(f64) -> f64; 3] = [
        |_| 0.0,
        |flown_m| 2.5 * libm::sin(flown_m / 900.0),
        |flown_m| if (3_000.0..4_000.0).contains(&flown_m) { 4.0 } else { 1.5 * libm::cos(flown_m / 700.0) },
    ];
    for (number, roll_deg) in flights.into_iter().enumerate() {
        for wanted_m in [6.0, 10.0] {
            let properties = format!(r#""value": 100, "resolution_m": {wanted_m}"#);
            let mission = mission(&[fire("here", &ground, &properties)]).unwrap();
            let lines = || two_lines(MIDNIGHT_S).map(|line| Line { roll_deg, ..line });
            let score = flown(&mission, &lines());
            let witnessed = 100.0 * witness(GROUND, wanted_m, &lines());
            println!("flight {number}, {wanted_m} m: {:.2}, by points {witnessed:.2}", score.benefits);
            near(score.benefits, witnessed, 1.5);
        }
    }
}

#[test]
fn shaking_wings_shift_lines_although_they_stay_level() {
    let mission = mission(&[fire("here", &box_of(GROUND.0, GROUND.1), r#""value": 100, "resolution_m": 20"#)]).unwrap();
    // 9 degrees a second at 25 lines a second: 5 pixels, of which 2 count in full and 6 not at all.
    let roll_deg = |flown_m: f64| if (flown_m / SPEED_MPS / 0.2).round() % 2.0 == 0.0 { 0.9 } else { -0.9 };
    let score = flown(&mission, &two_lines(MIDNIGHT_S).map(|line| Line { roll_deg, ..line }));
    near(look(&score, "here").flown.factors.clarity, (6.0 - 9f64.to_radians() / (25.0 * PIXEL_RAD)) / 4.0, 0.01);
}

#[test]
fn targets_that_are_impossible_are_refused_by_name() {
    let ground = box_of(GROUND.0, GROUND.1);
    let refused = |properties: &str| mission(&[fire("here", &ground, properties)]).unwrap_err();
    for (properties, words) in [
        (r#""windows_h": [[30, 35]]"#, "lies outside of the mission"),
        (r#""value": -3"#, "`value` is -3"),
        (r#""light": "dusk""#, "unknown `light`"),
        (r#""resolution_m": 0"#, "`resolution_m` is 0"),
        (r#""light": "day", "sun_deg_max": -6"#, "`sun_deg_max` has no meaning"),
        (r#""must_cost": 3"#, "`must_cost` without `must`"),
        (r#""falls": "linear""#, "`falls` without `falls_over_h`"),
        (r#""latency_min": [60, 10]"#, "`latency_min` is [60,10]"),
        (r#""looks": [{"id": "night"}]"#, "a look without `value`"),
        (r#""looks": [{"id": "night", "value": 1, "colour": 3}]"#, "unknown property `colour`"),
        (r#""looks": [{"id": "a", "value": 1}, {"id": "a", "value": 2}]"#, "which another has"),
        (r#""value": 2, "looks": [{"id": "a", "value": 1}]"#, "`value` has no meaning together with `looks`"),
        (r#""overpass": {"tle": ["1", "2"]}"#, "not an orbit"),
        (r#""overpass": {"omm": {"EPOCH": "2007-09-07T00:00:00"}}"#, "not an orbit"),
        (
            r#""overpass": {"tle": ["1 00005U 58002B   00179.78495062  .00000023  00000-0  28098-4 0  4753", "2 00005  34.2682 348.7242 1859667 331.7664  19.3264 10.82419157413667"]}"#,
            "not of the time of the mission",
        ),
        (r#""perimeter_width_m": 300"#, "`perimeter_width_m` has no meaning"),
        (r#""early_factor": 0.5"#, "`early_factor` without `after`"),
    ] {
        let told = refused(properties);
        assert!(told.contains(words), "{properties}: {told}");
        assert!(told.contains("fires.geojson: feature 1 `here"), "{told}");
    }
}

/// Adds a measured turbulence of zero, so that predictions are those of the closed forms.
fn calm(batch: &mut Batch) {
    let kind = measured("edr", Value::Real(0.0));
    batch.events.push(Event { sequence: 0, at: batch.now, kind });
}

/// Returns the decision about 1 km that lost its data on the last line, if another fire can be observed until `until_h`: true if it is
/// flown again, the gain, the price, and the text.
fn weighed(lines: &[Line], until_h: f64) -> (bool, f64, f64, String) {
    let here = fire("here", &box_of(GROUND.0, GROUND.1), r#""value": 100, "resolution_m": 10"#);
    let wanted = format!(r#""value": 5, "resolution_m": 10, "windows_h": [[0, {until_h}]]"#);
    let next = fire("next", &box_of([35_000.0, 45_000.0], GROUND.1), &wanted);
    let mission = Arc::new(mission(&[here, next]).unwrap());
    let mut deliberator =
        MissionDeliberator::new(Arc::clone(&mission), PlanningResources::of(&Arc::new(apex_solvers::shipped())));
    adopt_plan(&mut deliberator, lines[0].begin_s - 600.0);
    let lost_s = lines.last().unwrap().begin_s + 60.0;
    let mut batches = batches(lines);
    batches.retain(|batch| batch.now.seconds() <= lost_s);
    let line = lines.last().unwrap();
    let (end, sign) = (batches.len() - 1, (line.to_m - line.from_m).signum());
    let place = |east_m: f64| {
        let (latitude_deg, longitude_deg) = position(east_m, line.north_m);
        Value::list([latitude_deg, longitude_deg, line.height_m].map(Value::Real))
    };
    let lost = Value::list([
        Value::symbol("segment-lost"),
        Value::symbol("here"),
        place(line.from_m + sign * 5_000.0),
        place(line.from_m + sign * 6_000.0),
        place(line.to_m),
    ]);
    let said = [Effect::Inform { form: lost, task: TaskId(1) }];
    for (number, batch) in batches.iter_mut().enumerate() {
        calm(batch);
        deliberator.observe(0, batch, if number == end { &said } else { &[] });
        let derived = deliberator.derive();
        let answer = derived.iter().find_map(|input| match &input.kind {
            EventKind::Occurrence(form) => {
                form.as_list().filter(|items| items[0].as_symbol().is_some_and(|head| head.is("segment-weighed")))
            }
            _ => None,
        });
        if let Some([_, target, _, _, verdict, gain, price, Value::Text(text)]) = answer {
            assert_eq!((number, target.to_string().as_str()), (end, "here"));
            let number = |value: &Value| value.as_number().unwrap().0;
            return (verdict.as_symbol().unwrap().is("again"), number(gain), number(price), text.to_string());
        }
    }
    panic!("no answer");
}

/// Lets the deliberator adopt the plan for the fires, as the executive would.
fn adopt_plan(deliberator: &mut MissionDeliberator, at_s: f64) {
    let now = Time::from_seconds(at_s);
    let (latitude_deg, longitude_deg) = position(-20_000.0, 0.0);
    let place = measured("location", Value::list([latitude_deg, longitude_deg, 7_000.0].map(Value::Real)));
    let step = |kinds: Vec<EventKind>, effects: &[Effect], deliberator: &mut MissionDeliberator| {
        let events = kinds.into_iter().map(|kind| Event { sequence: 0, at: now, kind }).collect();
        deliberator.observe(0, &Batch { now, events }, effects);
    };
    let goal = Value::list(["map", "the", "fires"].map(Value::symbol));
    let (request, solver) = (SolveRequestId(1), Symbol::new("auto"));
    let budget = Some(apex_model::time::Duration::from_seconds(0.2));
    let request = SolveRequest { request, task: TaskId(1), goal, solver, budget, is_failure_handled: false };
    step(vec![place], &[Effect::Solve(request.clone())], deliberator);
    let answer = deliberator.pose(&request, now).job.run(&CancelToken::new()).result.unwrap();
    let kind = DecisionKind::ProcedureAdded { request: request.request, summary: "a".into(), pdl: "b".into() };
    let because = Because::new(Cause::PlanArrived { request: request.request, solver: Symbol::new("auto") }, None);
    let adopted = Effect::Decided(Decision { task: None, kind, because });
    let reported = EventKind::SolverReported(request.request, SolverReport::Plan(answer));
    step(vec![reported], &[adopted], deliberator);
    assert!(deliberator.situation().plan.is_some());
}

/// Returns a kilometre with a low wing, between 5 and 6 km of the line.
fn low_wing(flown_m: f64) -> f64 {
    if (5_000.0..6_000.0).contains(&flown_m) { 5.0 } else { 0.0 }
}

#[test]
fn a_segment_is_flown_again_where_it_is_worth_more_than_what_it_displaces() {
    let begin_s = MIDNIGHT_S;
    // One line over the middle: no other line sees the segment, a tenth of the fire.
    let alone = [Line { roll_deg: low_wing, ..Line::new(0.0, -5_500.0, 5_500.0, begin_s) }];
    // Two overlapping lines: the other one has seen most of the segment.
    let [first, second] = two_lines(begin_s);
    let overlapped = [first, Line { roll_deg: low_wing, ..second }];
    // The other fire can wait: its time is free.
    let (again, gain, price, words) = weighed(&alone, 23.0);
    assert!(again && price < 0.5, "{words}");
    near(gain, 9.9, 0.2);
    let (again, gain, price, words) = weighed(&overlapped, 23.0);
    assert!(again && price < 0.5, "{words}");
    near(gain, 1.0, 0.1);
    // Its window closes: the segment that another line has seen is left, the only observation of a tenth of the fire is not.
    let (again, gain, price, words) = weighed(&overlapped, 6.3);
    assert!(!again && words.ends_with("(one target is left out: next)"), "{words}");
    near(gain, 1.0, 0.1);
    near(price, 5.0, 0.3);
    let (again, gain, price, words) = weighed(&alone, 6.2);
    assert!(again && price > 1.0, "{words}");
    near(gain, 9.9, 0.2);
}
