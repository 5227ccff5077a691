//! Turn-limited paths against a search that uses neither tangents nor centres of circles.

use super::*;
use proptest::prelude::*;

/// Returns the smallest angle between two directions.
fn apart_rad(a: f64, b: f64) -> f64 {
    let apart = (a - b) - TAU * libm::round((a - b) / TAU);
    apart.abs().min(PI)
}

/// Returns the end of a flight of three parts, by summing arcs; angles and lengths through the air at speed 1.
fn flown(heading: f64, turns: [f64; 3], lengths: [f64; 3], radius: f64, wind: Point) -> Point {
    let (mut x, mut y, mut heading) = (0.0, 0.0, heading);
    for (turn, length) in turns.into_iter().zip(lengths) {
        let after = heading + turn * length / radius;
        if turn == 0.0 {
            x += length * libm::cos(heading);
            y += length * libm::sin(heading);
        } else {
            x += turn * radius * (libm::sin(after) - libm::sin(heading));
            y -= turn * radius * (libm::cos(after) - libm::cos(heading));
        }
        heading = after;
    }
    let time: f64 = lengths.iter().sum();
    Point { x: x + wind.x * time, y: y + wind.y * time }
}

/// Returns the fastest path from the origin by examining first turns: the last turn follows from the headings, and if the length of the
/// line (or the turn) in between can be chosen so that the lateral miss changes its sign, a path exists.
fn naive(to: Point, headings: (f64, f64), radius: f64, wind: Point) -> (f64, f64) {
    // The best path with a line, and the best of all.
    let (mut straight, mut best) = (f64::INFINITY, f64::INFINITY);
    let around = |angle: f64| angle.rem_euclid(TAU);
    for [first, between, last] in
        [[1.0, 0.0, 1.0], [-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, -1.0, 1.0], [-1.0, 1.0, -1.0]]
    {
        let last_turn = |t: f64, p: f64| around(last * (headings.1 - headings.0 - first * t - between * p));
        let miss = |t: f64, p: f64| {
            let middle = if between == 0.0 { p } else { radius * p };
            let lengths = [radius * t, middle, radius * last_turn(t, p)];
            let end = flown(headings.0, [first, between, last], lengths, radius, wind);
            (Point { x: end.x - to.x, y: end.y - to.y }, lengths.iter().sum::<f64>())
        };
        let (count, farthest) = (300, if between == 0.0 { 40.0 * radius } else { TAU });
        let starts = if between == 0.0 { 1 } else { 24 };
        for index in 0..count {
            for start in 0..starts {
                // Newton from a grid of starts, by differences.
                let mut t = TAU * index as f64 / count as f64;
                let mut p = if between == 0.0 { to.length() } else { TAU * (start as f64 + 0.5) / starts as f64 };
                for _ in 0..12 {
                    let (here, _) = miss(t, p);
                    let h = 1e-6;
                    let (by_t, by_p) = (miss(t + h, p).0, miss(t, p + h).0);
                    let (a, c) = ((by_t.x - here.x) / h, (by_t.y - here.y) / h);
                    let (b, d) = ((by_p.x - here.x) / h, (by_p.y - here.y) / h);
                    let determinant = a * d - b * c;
                    if determinant.abs() < 1e-9 || !here.x.is_finite() {
                        break;
                    }
                    t -= (d * here.x - b * here.y) / determinant;
                    p -= (a * here.y - c * here.x) / determinant;
                    if !(0.0..TAU + 1e-9).contains(&t) || !(-1e-9..farthest).contains(&p) {
                        break;
                    }
                }
                let (missed, length) = miss(t.max(0.0), p.max(0.0));
                if (0.0..TAU).contains(&t) && p >= 0.0 && missed.length() < 1e-6 * radius {
                    best = best.min(length);
                    if between == 0.0 {
                        straight = straight.min(length);
                    }
                }
            }
        }
    }
    (straight, best)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(debug_assertions) { 48 } else { 400 }))]
    #[test]
    fn no_turns_that_a_search_finds_are_faster(
        x in -9.0..9.0f64, y in -9.0..9.0f64, start in 0.0..TAU, end in 0.0..TAU, blows in 0.0..0.6f64, to in 0.0..TAU,
    ) {
        let wind_mps = Point { x: blows * libm::cos(to), y: blows * libm::sin(to) };
        let flyer = Flyer { true_airspeed_mps: 1.0, turn_radius_m: 1.0, wind_mps };
        // The search uses headings, the paths use tracks: those of the headings.
        let track = |heading: f64| angle(unit(heading).plus(1.0, wind_mps));
        let pose = |point: Point, heading: f64| Pose { point, track_rad: Some(track(heading)) };
        let there = Point { x, y };
        let paths = flyer.paths(pose(Point::default(), start), pose(there, end));
        let quickest = paths.first().unwrap();
        let (straight, twin) = naive(there, (start, end), 1.0, wind_mps);
        prop_assert!(quickest.time_s <= straight + 1e-4, "{} {straight}", quickest.time_s);
        // Between two examined instants, a path of three turns may become exact twice and stay unseen; the next exact path is then only a
        // little slower.
        prop_assert!(quickest.time_s <= twin + 0.1, "{} {twin}", quickest.time_s);
        // And it is a path.
        for path in &paths {
            let (point, heading) = path.at(path.time_s);
            prop_assert!(point.minus(there).length() < 1e-6, "{path:?} ends at {point:?}");
            prop_assert!(apart_rad(heading, end) < 1e-6);
        }
        prop_assert!(paths.windows(2).all(|pair| pair[0].time_s <= pair[1].time_s));
    }

    #[test]
    fn a_free_track_is_never_slower_than_a_given_one(
        x in -9.0..9.0f64, y in -9.0..9.0f64, start in 0.0..TAU, end in 0.0..TAU, blows in 0.0..0.5f64, to in 0.0..TAU,
    ) {
        let wind_mps = Point { x: blows * libm::cos(to), y: blows * libm::sin(to) };
        let flyer = Flyer { true_airspeed_mps: 1.0, turn_radius_m: 1.0, wind_mps };
        let there = Point { x, y };
        prop_assume!(there.length() > 4.0);
        let time = |start: Option<f64>, end: Option<f64>| {
            let from = Pose { point: Point::default(), track_rad: start };
            flyer.paths(from, Pose { point: there, track_rad: end }).first().map(|path| {
                assert!(path.at(path.time_s).0.minus(there).length() < 1e-6, "{path:?}");
                path.time_s
            })
        };
        let both = time(Some(start), Some(end)).unwrap();
        let (first, last, none) = (time(None, Some(end)).unwrap(), time(Some(start), None).unwrap(), time(None, None).unwrap());
        prop_assert!(first <= both + 1e-6 && last <= both + 1e-6 && none <= first + 1e-6 && none <= last + 1e-6);
    }

    #[test]
    fn points_are_as_near_to_the_path_as_they_should_be(
        x in -9.0..9.0f64, y in -9.0..9.0f64, start in 0.0..TAU, end in 0.0..TAU, blows in 0.0..0.5f64, to in 0.0..TAU,
    ) {
        let wind_mps = Point { x: blows * libm::cos(to), y: blows * libm::sin(to) };
        let flyer = Flyer { true_airspeed_mps: 1.0, turn_radius_m: 1.0, wind_mps };
        let pose = |point: Point, track: f64| Pose { point, track_rad: Some(track) };
        let path = flyer.paths(pose(Point::default(), start), pose(Point { x, y }, end))[0];
        let points = path.points(0.01);
        for step in 0..=500 {
            let here = path.at(path.time_s * f64::from(step) / 500.0).0;
            let pairs = points.windows(2).map(|pair| crate::plane::point_to_segment(here, pair[0], pair[1]));
            prop_assert!(pairs.fold(f64::INFINITY, f64::min) <= 0.01 + 1e-9);
        }
    }
}

#[test]
fn known_paths() {
    let flyer = Flyer { true_airspeed_mps: 10.0, turn_radius_m: 100.0, wind_mps: Point::default() };
    let pose = |x: f64, y: f64, track: f64| Pose { point: Point { x, y }, track_rad: Some(track) };
    let time = |from: Pose, to: Pose| flyer.paths(from, to)[0].time_s;
    assert!((time(pose(0.0, 0.0, 0.0), pose(1000.0, 0.0, 0.0)) - 100.0).abs() < 1e-9, "straight on");
    let half = time(pose(0.0, 0.0, 0.0), pose(0.0, 200.0, PI));
    assert!((half - 10.0 * PI).abs() < 1e-6, "half a circle: {half}");
    // Reversal on the spot: three turns of 60, 300 and 60 degrees.
    let about = time(pose(0.0, 0.0, 0.0), pose(0.0, 0.0, PI));
    assert!((about - 10.0 * (7.0 / 3.0) * PI).abs() < 1e-6, "{about}");
    let windy = Flyer { wind_mps: Point { x: 0.0, y: 20.0 }, ..flyer };
    assert_eq!(windy.paths(pose(0.0, 0.0, 0.0), pose(500.0, 0.0, 0.0)), Vec::new(), "no track against such a wind");
    assert!((turn_radius_m(95.0, 15.0_f64.to_radians()) - 3434.6).abs() < 1.0);
}

/// Returns the path of one type by examining every instant and treating all intervals alike.
fn by_every_instant(
    flyer: &Flyer,
    word: PathType,
    from: (Point, Option<f64>),
    to: (Point, Option<f64>),
) -> Option<(f64, [Part; 3])> {
    let (speed, radius, wind) = (flyer.true_airspeed_mps, flyer.turn_radius_m, flyer.wind_mps);
    let circle_s = TAU * radius / speed;
    let ends = PathEnds::new(word, radius, from, to.1);
    let look = |time_s: f64| {
        let (heading_rad, parts) = word.parts(&ends, to.0.plus(-time_s, wind))?;
        let length_m: f64 = parts.iter().map(|part| part.length_m).sum();
        Some(PathCandidate { time_s, missed_s: length_m / speed - time_s, heading_rad, parts })
    };
    let apart = to.0.minus(from.0);
    let track = unit(angle(apart));
    let direct_s = apart.length() / (speed * unit(flyer.heading_rad(angle(apart))?).dot(track) + wind.dot(track));
    let lasts_s = 3.0 * circle_s / (1.0 - wind.length() / speed);
    let count = (libm::ceil(lasts_s / circle_s) * INSTANTS_PER_CIRCLE).min(INSTANTS_MAX);
    let exact_s = EXACT * (circle_s + direct_s);
    let mut before = look(direct_s);
    for index in 1..=count as usize {
        let now_s = direct_s + lasts_s * index as f64 / count;
        let now = look(now_s);
        let since = match (before, now) {
            (None, Some(now)) => Some((now.outermost(now_s - lasts_s / count, &look), now)),
            (Some(before), None) => Some((before, before.outermost(now_s, &look))),
            (before, now) => before.zip(now),
        };
        if let Some((early, late)) = since {
            for (early, late) in PathCandidate::parted(early, late, &look, radius) {
                if (early.missed_s > 0.0) != (late.missed_s > 0.0) {
                    let above = early.missed_s > 0.0;
                    let (left, _) =
                        PathCandidate::narrowed(early, late, &look, |middle| (middle.missed_s > 0.0) == above);
                    if left.missed_s.abs() <= exact_s {
                        return Some((left.time_s + left.missed_s, left.parts));
                    }
                }
            }
            if early.missed_s.abs() <= exact_s {
                return Some((early.time_s + early.missed_s, early.parts));
            }
        }
        before = now;
    }
    None
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn intervals_without_a_solution_are_passed_over(
        x in -9.0..9.0_f64, y in -9.0..9.0_f64, start in -3.2..3.2_f64, end in -3.2..3.2_f64,
        wind_x in -0.9..0.9_f64, wind_y in -0.4..0.4_f64, scale in 1.0..900.0_f64, free in 0..4_usize,
    ) {
        let wind_mps = Point { x: wind_x, y: wind_y };
        prop_assume!(wind_mps.length() < 0.97 && wind_mps != Point::default());
        let flyer = Flyer { true_airspeed_mps: 1.0, turn_radius_m: scale, wind_mps };
        let (from, to) = (Point { x: 3.0, y: -4.0 }, Point { x: scale * x, y: scale * y });
        let (start, end) = (Some(start).filter(|_| free != 1), Some(end).filter(|_| free != 2));
        for word in words(start.is_some(), end.is_some()) {
            let pose = |point: Point, heading_rad: Option<f64>| (Pose { point, track_rad: None }, heading_rad);
            let found = PathSearch::new(&flyer, pose(from, start), pose(to, end)).path(word, f64::INFINITY);
            let found = found.map(|path| (path.time_s, path.parts));
            prop_assert_eq!(found, by_every_instant(&flyer, word, (from, start), (to, end)));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    /// Speeds, radii and distances as of aircraft: rounding is coarser there than near the origin.
    #[test]
    fn crossings_are_those_of_halving_whole_intervals(
        away in 0.0..60.0_f64, bearing in -3.2..3.2_f64, start in -3.2..3.2_f64, end in -3.2..3.2_f64,
        speed in 15.0..250.0_f64, roll in 0.2..0.7_f64, share in 0.0..0.95_f64, blows in -3.2..3.2_f64, free in 0..6_usize,
    ) {
        let wind_mps = Point::default().plus(share * speed, unit(blows));
        let flyer = Flyer { true_airspeed_mps: speed, turn_radius_m: turn_radius_m(speed, roll), wind_mps };
        let from = Point { x: -61_234.5, y: 7_890.1 };
        let to = from.plus(away * flyer.turn_radius_m, unit(bearing));
        let (start, end) = (Some(start).filter(|_| free != 1), Some(end).filter(|_| free != 2));
        for word in words(start.is_some(), end.is_some()) {
            let pose = |point: Point, heading_rad: Option<f64>| (Pose { point, track_rad: None }, heading_rad);
            let found = PathSearch::new(&flyer, pose(from, start), pose(to, end)).path(word, f64::INFINITY);
            let found = found.map(|path| (path.time_s.to_bits(), path.parts));
            let defined = by_every_instant(&flyer, word, (from, start), (to, end));
            prop_assert_eq!(found, defined.map(|(time_s, parts)| (time_s.to_bits(), parts)));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn the_fastest_path_is_the_first_of_all(
        x in -9.0..9.0_f64, y in -9.0..9.0_f64, start in -3.2..3.2_f64, end in -3.2..3.2_f64,
        wind_x in -0.6..0.6_f64, wind_y in -0.4..0.4_f64, free in 0..4_usize, tie in 0..4_usize,
    ) {
        // Turns to both sides are equally long if everything lies on one axis.
        let (y, start, end, wind_y) = if tie == 0 { (0.0, 0.0, 0.0, 0.0) } else { (y, start, end, wind_y) };
        let flyer = Flyer { true_airspeed_mps: 1.0, turn_radius_m: 1.0, wind_mps: Point { x: wind_x, y: wind_y } };
        let from = Pose { point: Point::default(), track_rad: Some(start).filter(|_| free != 1) };
        let to = Pose { point: Point { x, y }, track_rad: Some(end).filter(|_| free != 2) };
        let first = flyer.paths(from, to).first().copied();
        prop_assert_eq!(flyer.quickest(from, to), first);
    }
}
