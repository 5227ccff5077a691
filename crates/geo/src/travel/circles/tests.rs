//! Circles against known values, against an exhaustive search, and flown in small steps.

use super::*;
use crate::travel::{Air, Circling, EndpointId, Network, PlaneZone};
use apex_model::problem::{WindField, WindLayer};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

const ALL_DAY: (f64, f64) = (0.0, 100_000.0);

fn p(x: f64, y: f64) -> Point {
    Point { x, y }
}

fn calm() -> Rounds {
    Rounds::new(1.0, 1.0, p(0.0, 0.0)).unwrap()
}

fn near(a: f64, b: f64, by: f64) -> bool {
    (a - b).abs() <= by
}

#[test]
fn a_passage_by_hand() {
    // On a left circle around the origin, headed away from the other circle: half a circle, then the distance of the places. A quarter of
    // a circle earlier, the same circle needs three quarters of a circle, so an opposite turn by a quarter is faster.
    let on = |track_rad: f64| On { centre: p(0.0, 0.0), sense: 1.0, track_rad };
    let there = End::Circle(p(100.0, 0.0));
    let s = |track_rad: f64, opposite: bool| calm().passage(on(track_rad), there, opposite).unwrap().time_s;
    assert!(near(s(PI, false), 100.0 + PI, 1e-6), "{}", s(PI, false));
    assert!(near(s(FRAC_PI_2, false), 100.0 + 1.5 * PI, 0.1));
    // The opposite circle lies 2 ahead, and is left after a quarter.
    assert!(near(s(FRAC_PI_2, true), 98.0 + FRAC_PI_2, 0.1), "{}", s(FRAC_PI_2, true));
    // To a place: the line touches the circle at the angle of a tangent.
    let place = calm().passage(on(0.0), End::Place(p(2.0, 0.0)), false).unwrap();
    assert!(near(place.time_s, libm::sqrt(3.0) + PI / 6.0, 1e-9), "{place:?}");
    assert_eq!(calm().passage(on(0.0), End::Place(p(0.5, 0.0)), false), None, "inside of its circle");
}

#[test]
fn the_worst_is_half_a_circle_where_the_opposite_turn_has_room_and_a_whole_one_else() {
    let worst = |opposite: bool| calm().worst(p(0.0, 0.0), End::Circle(p(1_000.0, 0.0)), opposite).unwrap();
    assert!(near(worst(true), 1_000.0 + PI, 0.04), "{}", worst(true));
    assert!(near(worst(false), 1_000.0 + TAU, 0.04), "{}", worst(false));
    assert_eq!(calm().worst(p(0.0, 0.0), End::Circle(p(0.0, 0.0)), true), Some(0.0), "there already");
}

#[test]
fn wind_makes_circles_wider_and_slower() {
    // At most 15 over ground at an airspeed of 10: the heading turns by the square of the ground speed.
    assert!(near(radius(100.0, 10.0, 15.0), 225.0, 1e-9));
    let (still, windy) = (Rounds::new(1.0, 1.0, p(0.0, 0.0)).unwrap(), Rounds::new(1.0, 1.0, p(0.3, 0.4)).unwrap());
    assert!(near(still.circle_s(), TAU, 1e-12) && windy.circle_s() > 1.2 * TAU);
    assert!(Rounds::new(1.0, 1.0, p(0.8, 0.6)).is_none(), "as strong as the vehicle is fast");
}

/// Flies `points` at `airspeed` in `wind` and returns the time and the greatest turn rate of the heading: headings are those whose air
/// velocity and wind add up to the chords.
fn flown(points: &[Point], airspeed: f64, wind: Point) -> (f64, f64) {
    let (mut time_s, mut most, mut before): (f64, f64, Option<(f64, f64)>) = (0.0, 0.0, None);
    for pair in points.windows(2) {
        let chord = pair[1].minus(pair[0]);
        let Some(along) = chord.unit().filter(|_| chord.length() > 1e-9) else { continue };
        let (with, across) = (wind.dot(along), along.cross(wind));
        let speed = libm::sqrt(airspeed * airspeed - across * across) + with;
        let lasts_s = chord.length() / speed;
        let air = chord.plus(-lasts_s, wind);
        let heading = libm::atan2(air.y, air.x);
        if let Some((last_rad, last_s)) = before {
            let turn = (heading - last_rad) - TAU * libm::round((heading - last_rad) / TAU);
            // A tangent's first chord turns by half of its angle; very short chords have no direction.
            let between_s = 0.5 * (lasts_s + last_s);
            if between_s > 1e-6 && turn.abs() > 1e-6 {
                most = f64::max(most, turn.abs() / between_s);
            }
        }
        before = Some((heading, lasts_s));
        time_s += lasts_s;
    }
    (time_s, most)
}

fn blowing(wind: Point, until_s: f64) -> Air {
    let layer = WindLayer {
        area: None,
        altitude_m_min: 0.0,
        altitude_m_max: 1e4,
        from_s: -1.0,
        until_s,
        wind_east_mps: wind.x,
        wind_north_mps: wind.y,
        edr: 0.0,
    };
    Air::new(&WindField { layers: vec![layer], blend: false }, 100.0, 10.0, 0.0, ALL_DAY.1)
}

fn winds() -> impl Strategy<Value = Point> {
    (0.0..6.0f64, 0.0..TAU).prop_map(|(speed, angle)| p(speed * libm::cos(angle), speed * libm::sin(angle)))
}

fn places() -> impl Strategy<Value = Vec<Point>> {
    prop::collection::vec((0.0..60.0f64, 0.0..60.0f64).prop_map(|(x, y)| p(x, y)), 4)
}

fn states() -> impl Strategy<Value = Circling> {
    (0.0..TAU, any::<bool>()).prop_map(|(bearing_rad, clockwise)| Circling { bearing_rad, clockwise })
}

fn zones() -> impl Strategy<Value = Vec<PlaneZone>> {
    let one = (0.0..60.0f64, 0.0..60.0f64, 1.0..12.0f64, 1.0..12.0f64).prop_map(|(x, y, wide, high)| PlaneZone {
        name: "zone".to_string(),
        corners: vec![p(x, y), p(x + wide, y), p(x + wide, y + high), p(x, y + high)],
        ..PlaneZone::default()
    });
    prop::collection::vec(one, 0..4)
}

fn network(zones: &[PlaneZone], margin: f64, turn: f64, air: Air, places: &[Point]) -> (Network, Vec<EndpointId>) {
    let mut network = Network::circling_on_plane(zones, (margin, turn), air, ALL_DAY, true).unwrap();
    let ids: Vec<EndpointId> = places.iter().map(|place| network.add_point(*place).unwrap()).collect();
    ids.iter().for_each(|place| network.circle(*place));
    (network, ids)
}

fn on_map(spots: Vec<(apex_model::problem::Position, Point)>) -> Vec<Point> {
    spots.into_iter().map(|(_, point)| point).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(debug_assertions) { 60 } else { 600 }))]

    #[test]
    fn the_worst_is_at_least_any_and_hardly_more_than_the_worst_tried(
        wind in winds(), distance in 0.0..60.0f64, opposite in any::<bool>(), track in prop::option::of(0.0..TAU),
    ) {
        let rounds = Rounds::new(2.0, 10.0, wind).unwrap();
        let end = match track {
            Some(track_rad) => End::Pose(p(distance, 0.0), track_rad),
            None => End::Circle(p(distance, 0.0)),
        };
        let worst_s = rounds.worst(p(0.0, 0.0), end, opposite).unwrap();
        // Tries 32 points of the circle and points just past each, then points at a smaller distance around the worst of these.
        let (mut tried_s, mut worst_at) = (0.0_f64, (1.0, 0.0));
        let mut attempt = |sense: f64, turned_rad: f64| {
            let on = On { centre: p(0.0, 0.0), sense, track_rad: sense * turned_rad };
            let time_s = rounds.passage(on, end, opposite).unwrap().time_s;
            if time_s > tried_s {
                (tried_s, worst_at) = (time_s, (sense, turned_rad));
            }
            worst_at
        };
        for index in 0..32 {
            for sense in [1.0, -1.0] {
                for past in [0.0, 1e-6, 0.011] {
                    attempt(sense, TAU * f64::from(index) / 32.0 + past);
                }
            }
        }
        let (sense, turned_rad) = attempt(1.0, 0.0);
        for step in -12..=12 {
            attempt(sense, turned_rad + TAU * f64::from(step) / (32.0 * 12.0));
        }
        prop_assert!(worst_s >= tried_s - 1e-9, "{worst_s} {tried_s}");
        // Near a pose the fastest flight may leave the circle at a point that `worst` does not evaluate: its result may then be too long.
        let share = if track.is_none() { 0.04 } else { 0.15 };
        let is_far = distance >= 8.0 || track.is_none();
        prop_assert!(!is_far || worst_s <= tried_s + share * rounds.circle_s(), "{worst_s} {tried_s}");
    }

    #[test]
    fn a_flight_that_turns_no_more_tightly_than_it_can_is_never_later_than_the_plan_says(
        places in places(), wind in winds(), turn in 0.3..3.0f64, first in states(), looks_s in prop::collection::vec(0.0..20.0f64, 4),
    ) {
        let (mut network, ids) = network(&[], 0.0, turn, blowing(wind, 1e9), &places);
        let mut there = first;
        for (leg, look_s) in ids.windows(2).zip(&looks_s) {
            // On the circle during the observation, then to the next circle.
            let (look, after) = network.circling_arc_spots(leg[0], there, (0.0, *look_s)).unwrap();
            let look = on_map(look);
            let (flown_s, rate) = flown(&look, 10.0, wind);
            let circle_s = Rounds::new(network.circle_radius_m(), 10.0, wind).unwrap().circle_s();
            let rounds = libm::floor(look_s / circle_s) - f64::from(u8::from(*look_s >= circle_s));
            prop_assert!(near(flown_s + rounds * circle_s, *look_s, 0.01), "looked for {flown_s} of {look_s}");
            prop_assert!(rate <= 10.0 / turn * 1.02, "turns at {rate} of {}", 10.0 / turn);
            let trip = network.trip(leg[0], leg[1], 0.0).unwrap();
            let (path, next) = network.circling_spots(trip.way, 0.0, Some(after)).unwrap();
            let path = on_map(path);
            prop_assert!(look.last().unwrap().minus(path[0]).length() < 1e-6, "begins where the look ended");
            let (flown_s, rate) = flown(&path, 10.0, wind);
            prop_assert!(flown_s <= trip.arrive_s + 1e-6, "{flown_s} {trip:?}");
            prop_assert!(rate <= 10.0 / turn * 1.02, "turns at {rate} of {}", 10.0 / turn);
            there = next.unwrap();
            let (end, circle) = (path[path.len() - 1], network.circle_radius_m());
            prop_assert!(near(end.minus(places[leg[1].0]).length(), circle, 1e-6), "on the circle");
        }
    }

    #[test]
    fn circles_and_the_ways_between_them_keep_out_of_zones(
        places in places(), zones in zones(), margin in 0.0..2.0f64, turn in 0.2..1.5f64, first in states(), look_s in 0.0..30.0f64,
        wind in winds(),
    ) {
        let (mut network, ids) = network(&zones, margin, turn, blowing(wind, 1e9), &places);
        for from in &ids {
            for to in ids.iter().filter(|to| *to != from) {
                let Ok(trip) = network.trip(*from, *to, 0.0) else { continue };
                let (look, after) = network.circling_arc_spots(*from, first, (0.0, look_s)).unwrap();
                let Some((path, next)) = network.circling_spots(trip.way, 0.0, Some(after)) else {
                    prop_assert!(false, "a way without a path");
                    continue;
                };
                let (looked, _) = network.circling_arc_spots(*to, next.unwrap(), (0.0, 60.0)).unwrap();
                let path = on_map(path);
                let (flown_s, _) = flown(&path, 10.0, wind);
                prop_assert!(flown_s <= trip.arrive_s + 1e-6, "{flown_s} {trip:?}");
                for point in on_map(look).into_iter().chain(path).chain(on_map(looked)) {
                    for zone in &zones {
                        let inside = crate::plane::inside(point, &zone.corners);
                        let apart = crate::plane::segment_to_edges(point, point, &zone.corners);
                        prop_assert!(!inside && apart >= margin - 1e-3, "{point:?} is {apart} from {zone:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn leaving_a_circle_later_is_never_being_there_earlier(
        places in places(), zones in zones(), wind in winds(), until_s in 1.0..20.0f64, departs in prop::collection::vec(0.0..30.0f64, 2..10),
    ) {
        let (mut network, ids) = network(&zones, 0.5, 0.5, blowing(wind, until_s), &places);
        let mut departs = departs;
        departs.sort_by(f64::total_cmp);
        for to in &ids[1..] {
            let mut arrive = |depart_s: &f64| network.trip(ids[0], *to, *depart_s).map_or(f64::INFINITY, |trip| trip.arrive_s);
            let arrive: Vec<f64> = departs.iter().map(&mut arrive).collect();
            prop_assert!(arrive.windows(2).all(|pair| pair[1] >= pair[0] - 1e-5), "{departs:?} {arrive:?}");
        }
    }
}
