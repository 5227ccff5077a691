//! The network against naive twins and against another program (extremitypathfinder).

use super::*;
use crate::plane::{self, Point};
use proptest::prelude::*;

const ALL_DAY: (f64, f64) = (0.0, 100_000.0);

fn p(x: f64, y: f64) -> Point {
    Point { x, y }
}

fn zone(name: &str, corners: &[(f64, f64)]) -> PlaneZone {
    let corners = corners.iter().map(|(x, y)| p(*x, *y)).collect();
    PlaneZone { name: name.to_string(), corners, ..PlaneZone::default() }
}

fn square(x: f64, y: f64, side: f64) -> PlaneZone {
    zone("square", &[(x, y), (x + side, y), (x + side, y + side), (x, y + side)])
}

/// Returns a network in which lengths are times: one unit per second.
fn still(zones: &[PlaneZone], margin: f64) -> Network {
    Network::on_plane(zones, (margin, 0.0), Air::still(1.0), ALL_DAY).unwrap()
}

fn time_s(network: &mut Network, from: Point, to: Point, depart_s: f64) -> Option<f64> {
    let (from, to) = (network.add_point(from).unwrap(), network.add_point(to).unwrap());
    network.trip(from, to, depart_s).ok().map(|trip| trip.arrive_s - depart_s)
}

mod golden {
    use super::*;

    struct World {
        zones: Vec<PlaneZone>,
        places: Vec<Point>,
        ways: Vec<(usize, usize, Option<f64>)>,
    }

    fn worlds() -> Vec<World> {
        let mut worlds: Vec<World> = Vec::new();
        for line in include_str!("golden/extremity.txt").lines() {
            let mut words = line.split(' ');
            let kind = words.next().unwrap();
            if kind == "world" {
                worlds.push(World { zones: Vec::new(), places: Vec::new(), ways: Vec::new() });
                continue;
            }
            let world = worlds.last_mut().unwrap();
            let words: Vec<&str> = words.collect();
            if kind == "way" {
                world.ways.push((words[0].parse().unwrap(), words[1].parse().unwrap(), words[2].parse().ok()));
                continue;
            }
            let numbers: Vec<f64> = words.iter().map(|word| word.parse().unwrap()).collect();
            let corners: Vec<(f64, f64)> = numbers.chunks(2).map(|pair| (pair[0], pair[1])).collect();
            match kind {
                "boundary" => world.zones.push(PlaneZone { keep_in: true, ..zone("boundary", &corners) }),
                "hole" => world.zones.push(zone("hole", &corners)),
                "place" => world.places.push(p(corners[0].0, corners[0].1)),
                other => panic!("{other}"),
            }
        }
        worlds
    }

    #[test]
    fn shortest_ways_agree_with_extremitypathfinder() {
        let mut compared = 0;
        for (number, world) in worlds().iter().enumerate() {
            let mut network = still(&world.zones, 0.0);
            let places: Vec<EndpointId> = world.places.iter().map(|place| network.add_point(*place).unwrap()).collect();
            for (from, to, length) in &world.ways {
                for (from, to) in [(*from, *to), (*to, *from)] {
                    let ours = network.trip(places[from], places[to], 0.0).ok().map(|trip| trip.arrive_s);
                    let agrees = match (ours, length) {
                        (Some(ours), Some(length)) => (ours - length).abs() <= 1e-9 * (1.0 + length),
                        (ours, length) => ours.is_none() && length.is_none(),
                    };
                    assert!(agrees, "world {number}, {from} to {to}: {ours:?}, the peer {length:?}");
                    compared += 1;
                }
            }
        }
        assert!(compared > 1000, "{compared}");
    }
}

/// Random worlds with overlapping, touching and nested polygons, on a coarse grid of coordinates so that corners and edges
/// fall together.
mod random {
    use super::*;
    use crate::travel::solid::Solid;

    #[derive(Clone, Debug)]
    struct Worlds {
        zones: Vec<PlaneZone>,
        places: Vec<Point>,
    }

    fn polygon() -> impl Strategy<Value = Vec<(f64, f64)>> {
        let corner = (1i32..7, 0.3..1.0f64);
        let shape = (3usize..8, prop::collection::vec(corner, 8), 0i32..50, 0i32..50, 2i32..14, any::<bool>());
        shape.prop_map(|(count, corners, x, y, size, whole)| {
            let corners = corners.into_iter().take(count).enumerate().map(|(index, (_, share))| {
                let angle = (index as f64 + 0.3 * share) * std::f64::consts::TAU / count as f64;
                let radius = f64::from(size) * share;
                (f64::from(x) + radius * libm::cos(angle), f64::from(y) + radius * libm::sin(angle))
            });
            corners.map(|(x, y)| if whole { (x.round(), y.round()) } else { (x, y) }).collect()
        })
    }

    fn worlds(zones: usize) -> impl Strategy<Value = Worlds> {
        let made = (polygon(), prop::option::of((0i32..100, 1i32..60)));
        let place = (-5i32..56, -5i32..56);
        (prop::collection::vec(made, 0..zones), prop::collection::vec(place, 2..6)).prop_map(|(zones, places)| {
            let zones = zones.into_iter().map(|(corners, active)| PlaneZone {
                active_s: active.map(|(from, lasts)| (f64::from(from), f64::from(from + lasts))).into_iter().collect(),
                ..zone("z", &corners)
            });
            // No two corners at one place and no self-crossing polygon: such zones are rejected earlier.
            let zones = zones.filter(|zone| {
                Solid::new(&zone.corners).is_some_and(|solid| solid.corners().len() == zone.corners.len())
                    && crossing(&zone.corners).is_none()
            });
            let places = places.into_iter().map(|(x, y)| p(f64::from(x), f64::from(y))).collect();
            Worlds { zones: zones.collect(), places }
        })
    }

    /// Returns the number of an active zone that contains the point or is closer to it than `margin`, by another method: the angle under
    /// which the outline is seen.
    fn entered(zones: &[PlaneZone], point: Point, time_s: f64, margin: f64) -> Option<usize> {
        zones.iter().position(|zone| {
            let active = |(from, until): &(f64, f64)| from + 1e-4 < time_s && time_s < until - 1e-4;
            if !zone.active_s.is_empty() && !zone.active_s.iter().any(active) {
                return false;
            }
            let edge = plane::segment_to_edges(point, point, &zone.corners);
            if edge < margin - 1e-6 {
                return true;
            }
            let seen: f64 = plane::edges(&zone.corners)
                .map(|(a, b)| (a.minus(point), b.minus(point)))
                .map(|(a, b)| libm::atan2(a.cross(b), a.dot(b)))
                .sum();
            edge > 1e-6 && seen.abs() > 3.0
        })
    }

    /// Flies a trip in short steps and returns the first place and time at which a zone is entered, with the zone's number.
    fn first_entry(world: &Worlds, network: &mut Network, trip: Trip, margin: f64) -> Option<(Point, f64, usize)> {
        let points = network.points(trip.way);
        let speed = network.length_of(trip.way) / (trip.arrive_s - trip.depart_s);
        let mut now_s = trip.depart_s;
        for (from, to) in points.iter().zip(points.iter().skip(1)) {
            let along = to.minus(*from);
            let steps = 60;
            for step in 0..=steps {
                let share = f64::from(step) / f64::from(steps);
                let (here, at_s) = (from.plus(share, along), now_s + share * along.length() / speed);
                if let Some(zone) = entered(&world.zones, here, at_s, margin) {
                    return Some((here, at_s, zone));
                }
            }
            now_s += along.length() / speed;
        }
        None
    }

    /// Returns the shortest lengths from the first place by brute force: every corner and place sees every other that no zone hides.
    fn brute(world: &Worlds) -> Vec<f64> {
        let solids: Vec<Solid> = world.zones.iter().filter_map(|zone| Solid::new(&zone.corners)).collect();
        let mut points = world.places.clone();
        points.extend(world.zones.iter().flat_map(|zone| zone.corners.iter().copied()));
        let clear = |a: Point, b: Point| {
            solids.iter().all(|solid| {
                // Divides the leg at every crossing with every edge, found one at a time, and tests the midpoints.
                let along = b.minus(a);
                let mut cuts = vec![0.0, 1.0];
                for (c, d) in plane::edges(solid.corners()) {
                    let edge = d.minus(c);
                    cuts.push((c.minus(a).cross(edge) / along.cross(edge)).clamp(0.0, 1.0));
                    cuts.push((c.minus(a).dot(along) / along.dot(along)).clamp(0.0, 1.0));
                }
                cuts.retain(|cut| cut.is_finite());
                cuts.sort_by(f64::total_cmp);
                let mut pieces = cuts.iter().zip(cuts.iter().skip(1)).filter(|(s, t)| **t - **s > 1e-9);
                !pieces.any(|(s, t)| {
                    let middle = a.plus(0.5 * (s + t), along);
                    plane::inside(middle, solid.corners()) && solid.distance(middle) > 1e-9
                })
            })
        };
        let mut lengths = vec![f64::INFINITY; points.len()];
        let held = solids.iter().any(|solid| solid.holds(points[0]));
        lengths[0] = if held { f64::INFINITY } else { 0.0 };
        let mut settled = vec![false; points.len()];
        while let Some(here) =
            (0..points.len()).filter(|i| !settled[*i]).min_by(|i, j| lengths[*i].total_cmp(&lengths[*j]))
        {
            settled[here] = true;
            for next in 0..points.len() {
                let length = lengths[here] + points[next].minus(points[here]).length();
                if length < lengths[next] && clear(points[here], points[next]) {
                    lengths[next] = length;
                }
            }
        }
        lengths
    }

    proptest! {
        #[test]
        fn ways_are_as_short_as_by_brute_force(world in worlds(7)) {
            let zones: Vec<PlaneZone> =
                world.zones.iter().cloned().map(|zone| PlaneZone { active_s: Vec::new(), ..zone }).collect();
            let world = Worlds { zones: zones.clone(), ..world };
            let lengths = brute(&world);
            let mut network = still(&zones, 0.0);
            let places: Vec<EndpointId> = world.places.iter().map(|place| network.add_point(*place).unwrap()).collect();
            for (number, to) in places.iter().enumerate().skip(1) {
                let ours = network.trip(places[0], *to, 0.0).map_or(f64::INFINITY, |trip| trip.arrive_s);
                let close = (ours - lengths[number]).abs() <= 1e-6 || ours == lengths[number];
                prop_assert!(close, "to {number}: ours {ours}, by brute force {}", lengths[number]);
            }
        }

        #[test]
        fn no_way_enters_a_zone_or_its_margin(world in worlds(9), margin in 0.0..3.0f64, depart_s in 0.0..150.0f64) {
            let margin = if margin < 1.0 { 0.0 } else { margin };
            let mut network = still(&world.zones, margin);
            let places: Vec<EndpointId> = world.places.iter().map(|place| network.add_point(*place).unwrap()).collect();
            for from in &places {
                for to in &places {
                    let Ok(trip) = network.trip(*from, *to, depart_s) else { continue };
                    prop_assert!(trip.depart_s >= depart_s && trip.arrive_s >= trip.depart_s);
                    // Ends closer than the margin keep their distance.
                    let ends = [*from, *to].map(|place| world.places[place.0]);
                    let nearest = world.zones.iter().flat_map(|zone| {
                        ends.map(|end| plane::segment_to_edges(end, end, &zone.corners))
                    });
                    let margin = nearest.fold(margin, f64::min);
                    let entry = first_entry(&world, &mut network, trip, margin);
                    prop_assert!(entry.is_none(), "{entry:?} {:?} {trip:?}", network.points(trip.way));
                }
            }
        }

        #[test]
        fn no_way_with_wide_turns_enters_a_zone_or_its_margin(
            world in worlds(7), margin in 0.0..3.0f64, depart_s in 0.0..150.0f64, radius in 0.5..4.0f64,
            tracks in prop::collection::vec(prop::option::of(0.0..std::f64::consts::TAU), 6),
            wind in (-4.0..4.0f64, -4.0..4.0f64, 0.0..150.0f64),
        ) {
            let margin = if margin < 1.0 { 0.0 } else { margin };
            let air = super::gust(wind.0, wind.1, wind.2);
            let mut network = Network::on_plane(&world.zones, (margin, radius), air, ALL_DAY).unwrap();
            let places: Vec<EndpointId> = world.places.iter().map(|place| network.add_point(*place).unwrap()).collect();
            for (place, track) in places.iter().zip(&tracks) {
                network.head(*place, *track);
            }
            for from in &places {
                for to in &places {
                    let Ok(trip) = network.trip(*from, *to, depart_s) else { continue };
                    let points = network.path_points(trip.way, trip.depart_s);
                    prop_assert!(points.first() == Some(&world.places[from.0]) && points.last() == Some(&world.places[to.0]));
                    // The path begins and ends in the required direction, within the precision of a chord of a turn.
                    let off = |along: Point, place: &EndpointId| {
                        let bearing = libm::atan2(along.x, along.y);
                        tracks[place.0].filter(|_| along.length() > 0.0).map_or(0.0, |track| {
                            let apart = (bearing - track).rem_euclid(std::f64::consts::TAU);
                            apart.min(std::f64::consts::TAU - apart)
                        })
                    };
                    if let [first, second, ..] = points[..] {
                        prop_assert!(off(second.minus(first), from) < 0.12, "{points:?}");
                        let (last, before) = (points[points.len() - 1], points[points.len() - 2]);
                        prop_assert!(off(last.minus(before), to) < 0.12, "{points:?}");
                    }
                    let ends = [*from, *to].map(|place| world.places[place.0]);
                    let nearest = world.zones.iter().flat_map(|zone| {
                        ends.map(|end| plane::segment_to_edges(end, end, &zone.corners))
                    });
                    let margin = nearest.fold(margin, f64::min);
                    // The time of passage is ignored: zones with times count during the whole flight.
                    let during = |zone: &&PlaneZone| {
                        let meets = |(shut_s, open_s): &(f64, f64)| *shut_s + 1e-4 < trip.depart_s && trip.arrive_s + 1e-4 < *open_s;
                        zone.active_s.is_empty() || zone.active_s.iter().any(meets)
                    };
                    let zones: Vec<PlaneZone> = world.zones.iter().filter(during).cloned()
                        .map(|zone| PlaneZone { active_s: Vec::new(), ..zone }).collect();
                    for pair in points.windows(2) {
                        for step in 0..=12 {
                            let here = pair[0].plus(f64::from(step) / 12.0, pair[1].minus(pair[0]));
                            let entry = entered(&zones, here, 0.0, margin - 1e-9);
                            prop_assert!(entry.is_none(), "{here:?} in {entry:?} of {points:?}");
                        }
                    }
                }
            }
        }

        #[test]
        fn leaving_later_with_wide_turns_is_never_being_there_earlier(
            world in worlds(6), wind in (-4.0..4.0f64, -4.0..4.0f64, 10.0..80.0f64), radius in 0.5..4.0f64,
            departs in prop::collection::vec(0.0..200.0f64, 2..12), track in prop::option::of(0.0..std::f64::consts::TAU),
        ) {
            let air = super::gust(wind.0, wind.1, wind.2);
            let mut network = Network::on_plane(&world.zones, (0.0, radius), air, ALL_DAY).unwrap();
            let places: Vec<EndpointId> = world.places.iter().map(|place| network.add_point(*place).unwrap()).collect();
            places.iter().for_each(|place| network.head(*place, track));
            let outside = |place: &Point| world.zones.iter().all(|zone| !plane::inside(*place, &zone.corners));
            if !outside(&world.places[0]) {
                return Ok(());
            }
            let mut departs = departs;
            departs.sort_by(f64::total_cmp);
            for to in &places[1..] {
                let arrive: Vec<f64> = departs.iter()
                    .map(|depart_s| network.trip(places[0], *to, *depart_s).map_or(f64::INFINITY, |trip| trip.arrive_s))
                    .collect();
                for (early, late) in arrive.iter().zip(arrive.iter().skip(1)) {
                    prop_assert!(*late >= early - 1e-5, "{departs:?} {arrive:?}");
                }
            }
        }

        #[test]
        fn leaving_later_is_never_being_there_earlier(
            world in worlds(7), wind in (-0.8..0.8f64, -0.8..0.8f64, 10.0..80.0f64),
            departs in prop::collection::vec(0.0..200.0f64, 2..20),
        ) {
            let air = super::gust(wind.0, wind.1, wind.2);
            let mut network = Network::on_plane(&world.zones, (0.0, 0.0), air, ALL_DAY).unwrap();
            let places: Vec<EndpointId> = world.places.iter().map(|place| network.add_point(*place).unwrap()).collect();
            let mut departs = departs;
            departs.sort_by(f64::total_cmp);
            // A place that is closed at some time does not permit holding: a vehicle that leaves later may arrive from elsewhere.
            let outside = |place: &Point| world.zones.iter().all(|zone| !plane::inside(*place, &zone.corners));
            if !outside(&world.places[0]) {
                return Ok(());
            }
            for to in &places[1..] {
                let arrive: Vec<f64> = departs.iter()
                    .map(|depart_s| network.trip(places[0], *to, *depart_s).map_or(f64::INFINITY, |trip| trip.arrive_s))
                    .collect();
                for (early, late) in arrive.iter().zip(arrive.iter().skip(1)) {
                    prop_assert!(*late >= early - 1e-5, "{departs:?} {arrive:?}");
                }
            }
        }
    }
}

/// Returns wind until a time, then none.
fn gust(east_mps: f64, north_mps: f64, until_s: f64) -> Air {
    let layer = apex_model::problem::WindLayer {
        area: None,
        altitude_m_min: 0.0,
        altitude_m_max: 1e4,
        from_s: -1.0,
        until_s,
        wind_east_mps: east_mps,
        wind_north_mps: north_mps,
        edr: 0.0,
    };
    let field = apex_model::problem::WindField { layers: vec![layer], blend: false };
    Air::new(&field, 100.0, 10.0, 0.0, ALL_DAY.1)
}

#[test]
fn a_zone_that_shuts_is_flown_through_before_around_while_and_waited_for_at_its_end() {
    let wall = PlaneZone {
        active_s: vec![(100.0, 200.0)],
        ..zone("wall", &[(40.0, -300.0), (60.0, -300.0), (60.0, 300.0), (40.0, 300.0)])
    };
    let mut network = still(&[wall], 0.0);
    let (from, to) = (network.add_point(p(0.0, 0.0)).unwrap(), network.add_point(p(100.0, 0.0)).unwrap());
    let mut at = |depart_s: f64| network.trip(from, to, depart_s).map(|trip| (trip.depart_s, trip.arrive_s)).unwrap();
    assert_eq!(at(0.0), (0.0, 100.0));
    assert_eq!(at(40.0), (40.0, 140.0), "out of it as it shuts");
    let (depart_s, arrive_s) = at(41.0);
    assert!((depart_s - 160.0).abs() < 1e-5 && (arrive_s - 260.0).abs() < 1e-5, "held, at its edge as it opens");
    assert_eq!(at(500.0), (500.0, 600.0));
}

#[test]
fn wind_makes_ways_and_times_differ_by_direction() {
    let zones = [square(40.0, -10.0, 20.0)];
    let mut network = Network::on_plane(&zones, (1.0, 0.0), gust(5.0, 1.0, 1e9), ALL_DAY).unwrap();
    let places = [network.add_point(p(0.0, 0.0)).unwrap(), network.add_point(p(100.0, 0.0)).unwrap()];
    let matrix = network.matrix(&places, &places, 0.0);
    let time = |from: usize, to: usize| matrix[from][to].unwrap().arrive_s;
    assert_eq!((time(0, 0), time(1, 1)), (0.0, 0.0));
    assert!(time(0, 1) < 8.0 && time(1, 0) > 20.0, "{} {}", time(0, 1), time(1, 0));
}

#[test]
fn a_vehicle_with_wide_turns_bends_farther_out_and_can_fly_every_bend() {
    let zones = [square(40.0, -10.0, 20.0)];
    let length = |turn_radius: f64| {
        let mut network = Network::on_plane(&zones, (1.0, turn_radius), Air::still(1.0), ALL_DAY).unwrap();
        let places = [network.add_point(p(0.0, 1.0)).unwrap(), network.add_point(p(100.0, 1.0)).unwrap()];
        let trip = network.trip(places[0], places[1], 0.0).unwrap();
        let points = network.points(trip.way);
        let turn = |at: usize| {
            let (into, out) = (points[at].minus(points[at - 1]), points[at + 1].minus(points[at]));
            libm::atan2(into.cross(out), into.dot(out)).abs()
        };
        // An arc of the radius touches both legs of a bend at this distance from it.
        let taken = |at: usize| {
            let inner = (1..points.len() - 1).contains(&at);
            if inner { turn_radius * libm::tan(0.5 * turn(at)) } else { 0.0 }
        };
        for at in 0..points.len() - 1 {
            let leg = points[at + 1].minus(points[at]).length();
            assert!(leg >= taken(at) + taken(at + 1) - 1e-6, "leg {at} of {points:?} is too short");
        }
        trip.arrive_s
    };
    assert!(length(8.0) > length(0.0) + 0.5);
}

#[test]
fn a_vehicle_inside_a_zone_gets_the_reason() {
    let mut network = still(&[square(0.0, 0.0, 10.0)], 0.0);
    let (inside, outside) = (network.add_point(p(5.0, 5.0)).unwrap(), network.add_point(p(50.0, 5.0)).unwrap());
    assert_eq!(network.trip(outside, inside, 0.0), Err(TravelError::Inside("square".into())));
    assert_eq!(network.trip(inside, outside, 0.0), Err(TravelError::Inside("square".into())));
    let ring = [
        zone("n", &[(-20.0, 20.0), (30.0, 20.0), (30.0, 30.0), (-20.0, 30.0)]),
        zone("s", &[(-20.0, -20.0), (30.0, -20.0), (30.0, -10.0), (-20.0, -10.0)]),
        zone("w", &[(-20.0, -15.0), (-10.0, -15.0), (-10.0, 25.0), (-20.0, 25.0)]),
        zone("e", &[(20.0, -15.0), (30.0, -15.0), (30.0, 25.0), (20.0, 25.0)]),
    ];
    assert_eq!(time_s(&mut still(&ring, 0.0), p(0.0, 0.0), p(100.0, 0.0), 0.0), None);
    assert_eq!(still(&ring, 0.0).add_point(p(f64::NAN, 0.0)), Err(TravelError::TooFar));
    let line = Network::on_plane(&[zone("R-9", &[(0.0, 0.0), (1.0, 1.0)])], (0.0, 0.0), Air::still(1.0), ALL_DAY);
    assert!(line.unwrap_err().contains("R-9"));
}
