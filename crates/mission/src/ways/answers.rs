//! The host functions about paths: convert PDL values to requests, and paths to options of a command.

use super::areas::avoided_areas;
use super::landing::on_line;
use super::landing_places;
use super::limits::Limits;
use super::segment::{Segment, SegmentWay};
use super::wait::PlannedStart;
use super::{Broken, Request, Way, time_limits};
use crate::wind_error::WindError;
use apex_geo::geodesy;
use apex_geo::location::Location;
use apex_geo::wind::{self, Wind};
use apex_model::host::HostFunctions;
use apex_model::problem::Position;
use apex_model::quantity::Dimension;
use apex_model::time::Duration;
use apex_model::value::Value;
use std::borrow::Cow;
use std::sync::Arc;

type Body = fn(&Limits, &[Value]) -> Result<Value, String>;

/// Names, least and greatest numbers of arguments. The last argument is optional: a list of areas to avoid, as `(weak-link-areas AIRCRAFT)`
/// and `(storm-areas AIRCRAFT)` return them; storm areas hold for a time. For landing places, the argument before it is the time.
const FUNCTIONS: [(&str, usize, usize, Body); 12] = [
    ("way-to", 5, 6, to_place),
    ("way-to-circle", 5, 6, to_circle),
    ("way-to-line", 6, 7, to_line),
    ("way-to-landing", 4, 5, to_landing),
    ("way-to-climb", 4, 4, to_climb),
    ("way-to-segment", 6, 8, to_segment),
    ("time-before-line", 6, 6, before_line),
    ("time-on-circle", 7, 7, on_circle),
    ("landing-place-near", 2, 4, landing_places::near),
    ("landing-place-in-glide", 3, 4, landing_places::in_glide),
    ("landing-place-zones", 2, 2, landing_places::zones),
    ("forecast-error", 4, 4, forecast_error),
];

/// A vehicle is on a line, and flies on along it, within this distance across it and past its beginning, in seconds at cruise speed, and
/// this angle to its course. From elsewhere it flies round to the lead-in, as plans count: pictures that begin next to or past the beginning
/// miss the target. Autopilots join lines within the same limits (docs/reference/simulator.md).
const ON_LINE_ACROSS_S: f64 = 0.75;
const ON_LINE_PAST_S: f64 = 1.0;
const ON_LINE_DEG: f64 = 5.0;
/// The same where an interrupted line is resumed: another join takes minutes.
const RESUMED_ACROSS_S: f64 = 1.26;
const RESUMED_PAST_S: f64 = 3.15;
/// Ways to a circle end this many radii from its middle.
const CIRCLE_ENTRY: f64 = 2.0;

/// Replaces the functions that know no limits by functions with the limits of the mission.
pub(crate) fn register(limits: Limits, functions: &mut HostFunctions) {
    let limits = Arc::new(limits);
    for (name, least, most, body) in FUNCTIONS {
        let limits = Arc::clone(&limits);
        let function = move |arguments: &[Value]| {
            if !(least..=most).contains(&arguments.len()) {
                let wanted = if least == most { least.to_string() } else { format!("{least} or {most}") };
                return Err(format!("`{name}` takes {wanted} arguments and was given {}", arguments.len()));
            }
            let of_body = match name {
                "landing-place-near" => least + 1,
                "way-to-segment" => most,
                way if way.starts_with("way-to") => least,
                _ => most,
            };
            let (arguments, areas) = arguments.split_at(of_body.min(arguments.len()));
            let (weak, storms) = areas.first().map(avoided_areas).unwrap_or_default();
            let limits = limits.with_areas(weak, storms);
            body(&limits, arguments).map_err(|reason| format!("`{name}`: {reason}"))
        };
        functions.register(name, Arc::new(function));
    }
    time_limits::register(limits, functions);
}

/// Evaluates `(forecast-error LOCATION TIME SPEED DIRECTION)`: length of the difference between a measured wind and the forecast for its
/// place and time (since the start of the mission); nil without a location.
fn forecast_error(limits: &Limits, arguments: &[Value]) -> Result<Value, String> {
    let [location, time, speed, direction] = arguments else { return Err("a measured wind is missing".to_string()) };
    if !location.is_true() {
        return Ok(Value::nil());
    }
    let place = Location::of(location)?;
    let time_s = number(time, "time")?;
    let measured = measured_wind(speed, direction)?;
    let forecast = wind::at(&limits.wind, place.position, place.altitude_m.unwrap_or(0.0), time_s);
    let (east_mps, north_mps) = (measured.east_mps - forecast.east_mps, measured.north_mps - forecast.north_mps);
    Ok(Value::measured(libm::hypot(east_mps, north_mps), Dimension::SPEED))
}

fn number(value: &Value, what: &str) -> Result<f64, String> {
    let number = value.as_number().map(|(si, _)| si).filter(|si| si.is_finite());
    number.ok_or_else(|| format!("the {what} must be a number; got {value}"))
}

/// Returns a measured wind from its speed and the direction from which it blows.
fn measured_wind(speed: &Value, direction: &Value) -> Result<Wind, String> {
    let (speed_mps, from_rad) = (number(speed, "speed")?, number(direction, "direction")?);
    Ok(Wind { east_mps: -speed_mps * libm::sin(from_rad), north_mps: -speed_mps * libm::cos(from_rad), edr: 0.0 })
}

/// Returns the limits with the forecast as corrected by the wind that is measured at the beginning of the request; unchanged if none is.
fn in_measured_wind<'a>(limits: &'a Limits, request: &Request, measured: &[Value]) -> Result<Cow<'a, Limits>, String> {
    let [speed, direction] = measured else { return Ok(Cow::Borrowed(limits)) };
    if !speed.is_true() || !direction.is_true() {
        return Ok(Cow::Borrowed(limits));
    }
    let forecast = wind::at(&limits.wind, request.from, request.from_altitude_m, request.at_s);
    let mut error = WindError::default();
    error.take(measured_wind(speed, direction)?, forecast, request.at_s);
    Ok(match error.field(&limits.wind, request.at_s) {
        Some(wind) => Cow::Owned(limits.in_wind(wind)),
        None => Cow::Borrowed(limits),
    })
}

/// Like [`start_of`]; `None` also if the mission has no limits on paths.
fn start(limits: &Limits, arguments: &[Value]) -> Result<Option<Request>, String> {
    if limits.are_none() && !limits.has_weak() {
        return Ok(None);
    }
    let request = start_of(arguments)?;
    Ok(request.map(|request| Request {
        from_track_rad: request.from_track_rad.filter(|_| limits.turn_radius_m > 0.0),
        ..request
    }))
}

/// Returns a request from the position of the vehicle; `None` if it is unknown.
fn start_of(arguments: &[Value]) -> Result<Option<Request>, String> {
    let [here, track, met, ..] = arguments else { return Err("the vehicle's location is missing".to_string()) };
    if !here.is_true() {
        return Ok(None);
    }
    let place = Location::of(here)?;
    let angle = |value: &Value| match value.as_number() {
        Some((radians, Dimension::ANGLE)) if radians.is_finite() => Ok(radians),
        Some((degrees, Dimension::NONE)) if degrees.is_finite() => Ok(degrees.to_radians()),
        _ => Err(format!("the track must be an angle; got {value}")),
    };
    let track_rad = if track.is_true() { Some(angle(track)?) } else { None };
    let at_s = match met.as_number() {
        Some((seconds, Dimension::TIME | Dimension::NONE)) if seconds.is_finite() => seconds,
        _ => return Err(format!("the time must be a duration since the mission's start; got {met}")),
    };
    let from_altitude_m = place.altitude_m.unwrap_or(0.0);
    Ok(Some(Request {
        from: place.position,
        from_altitude_m,
        from_track_rad: track_rad,
        at_s,
        to: place.position,
        to_altitude_m: from_altitude_m,
        to_track_rad: None,
        circle_radius_m: 0.0,
        stay_s: 0.0,
    }))
}

/// Returns a location, or a place by its name, with its altitude if the location states one.
fn spot(limits: &Limits, value: &Value) -> Result<(Position, Option<f64>), String> {
    let name = match value {
        Value::Symbol(symbol) => Some(symbol.folded().to_string()),
        Value::Text(text) => Some(text.to_lowercase()),
        _ => None,
    };
    match name {
        Some(name) => {
            let place = limits.place(&name).map(|(position, _)| (position, None));
            place.ok_or_else(|| format!("no place is called `{name}`"))
        }
        None => Location::of(value).map(|place| (place.position, place.altitude_m)),
    }
}

fn length(value: &Value) -> Result<Option<f64>, String> {
    match value.as_number() {
        _ if !value.is_true() => Ok(None),
        Some((metres, Dimension::LENGTH | Dimension::NONE)) if metres.is_finite() => Ok(Some(metres)),
        _ => Err(format!("expected a length for the altitude, found {value}")),
    }
}

/// Evaluates `(way-to HERE TRACK MET PLACE ALTITUDE)`.
fn to_place(limits: &Limits, arguments: &[Value]) -> Result<Value, String> {
    let Some(request) = start(limits, arguments)? else { return Ok(Value::nil()) };
    let [.., place, altitude] = arguments else { return Ok(Value::nil()) };
    // No path for an invalid place: the vehicle refuses the command and states the reason.
    let Ok((to, stated_m)) = spot(limits, place) else { return Ok(Value::nil()) };
    let altitude_m = length(altitude)?.or(stated_m);
    // An aircraft that was low for its landing must climb before it continues.
    let least_m = limits.elevation_m_at(to) + limits.ground_margin_m;
    let wished_m = altitude_m.unwrap_or(request.from_altitude_m);
    let is_too_low = limits.turn_radius_m > 0.0 && wished_m < least_m;
    let request = Request { to, to_altitude_m: if is_too_low { least_m } else { wished_m }, ..request };
    let altitude = is_too_low.then(|| (":altitude", Value::measured(least_m, Dimension::LENGTH)));
    Ok(with_option(answer(limits.best_way(&request), None), altitude))
}

/// Returns an answer whose command has one more option.
fn with_option(answer: Value, option: Option<(&str, Value)>) -> Value {
    let Some((name, value)) = option else { return answer };
    let items = answer.as_list().unwrap_or_default();
    let options = items.first().and_then(Value::as_list).unwrap_or_default();
    let stated = [Value::symbol(name), value];
    let options = Value::list(options.iter().cloned().chain(stated));
    Value::list(std::iter::once(options).chain(items.iter().skip(1).cloned()))
}

/// Evaluates `(way-to-circle HERE TRACK MET PLACE TIME)`: TIME is the duration of circling there, or nil. If the circle does not fit, it
/// is flown around the nearest place where it does (`:centre`).
fn to_circle(limits: &Limits, arguments: &[Value]) -> Result<Value, String> {
    let Some(request) = start(limits, arguments)? else { return Ok(Value::nil()) };
    let [.., place, time] = arguments else { return Ok(Value::nil()) };
    let Ok((to, stated_m)) = spot(limits, place) else { return Ok(Value::nil()) };
    let stay_s = match time.as_number() {
        Some((seconds, Dimension::TIME)) if seconds.is_finite() => seconds.max(0.0),
        _ => (limits.end_s - request.at_s).max(0.0),
    };
    let to_altitude_m = stated_m.unwrap_or(request.from_altitude_m);
    let request = Request { to, to_altitude_m, stay_s, ..request };
    let (centre, shut_by) = limits.circle_centre(&request);
    let radius_m = limits.circle_radius_m();
    let request = Request { to: centre, circle_radius_m: radius_m, ..request };
    let mut way = limits.best_way(&request).map(|mut way| {
        // The vehicle turns onto the circle from outside of it.
        let near = |there: &Position| geodesy::distance_m(*there, centre) < CIRCLE_ENTRY * radius_m;
        while way.via.last().is_some_and(near) {
            way.via.pop();
        }
        way
    });
    if let Some(name) = shut_by {
        let straight = Way {
            via: Vec::new(),
            altitude_m: to_altitude_m,
            hold_s: 0.0,
            hold_around: None,
            time_s: 0.0,
            broken: None,
        };
        let broken = Some(Broken::one(name, "no place within reach has room for a circle"));
        way = Some(Way { broken, ..way.unwrap_or(straight) });
    }
    let moved = (centre != to).then(|| shown(centre, to_altitude_m));
    Ok(with_option(answer(way, None), moved.map(|centre| (":centre", centre))))
}

/// Evaluates `(way-to-line HERE TRACK MET FROM TO LEFT)`: LEFT is the point at which the vehicle left the line before, or nil.
fn to_line(limits: &Limits, arguments: &[Value]) -> Result<Value, String> {
    let is_fixed_wing = limits.turn_radius_m > 0.0;
    // A fixed wing turns onto lines as planned, also if nothing limits its ways.
    let request = if is_fixed_wing { start_of(arguments)? } else { start(limits, arguments)? };
    let Some(request) = request else { return Ok(Value::nil()) };
    let [.., from, to, left] = arguments else { return Ok(Value::nil()) };
    let ends = spot(limits, from).ok().zip(spot(limits, to).ok());
    let Some(((begin, begin_m), (end, end_m))) = ends else { return Ok(Value::nil()) };
    let length_m = geodesy::distance_m(begin, end);
    if length_m < 1.0 {
        return Ok(Value::nil());
    }
    let begin_along_m = if left.is_true() {
        let (along_m, across_m) = geodesy::along_cross_track_m(begin, end, Location::of(left)?.position);
        // A vehicle that was not on the line had not begun it.
        if across_m.abs() <= RESUMED_PAST_S * limits.true_airspeed_mps { along_m.clamp(0.0, length_m) } else { 0.0 }
    } else {
        0.0
    };
    let (along_m, across_m) = geodesy::along_cross_track_m(begin, end, request.from);
    let lead_m = limits.lead_in_s * (limits.true_airspeed_mps + limits.wind_mps_max());
    let course_deg = on_line(begin, end, along_m).1;
    let off_deg = request.from_track_rad.map_or(0.0, |track| geodesy::wrap_180(track.to_degrees() - course_deg).abs());
    let (across_s, past_s) =
        if begin_along_m > 0.0 { (RESUMED_ACROSS_S, RESUMED_PAST_S) } else { (ON_LINE_ACROSS_S, ON_LINE_PAST_S) };
    let is_on_line = across_m.abs() <= across_s * limits.true_airspeed_mps
        && off_deg <= ON_LINE_DEG
        && (begin_along_m - lead_m..=begin_along_m + past_s * limits.true_airspeed_mps).contains(&along_m);
    let altitude_m = begin_m.or(end_m).unwrap_or(request.from_altitude_m);
    if is_on_line {
        return Ok(Value::nil());
    }
    let (gate, gate_deg) = on_line(begin, end, if is_fixed_wing { begin_along_m - lead_m } else { begin_along_m });
    let request = Request {
        to: gate,
        to_altitude_m: altitude_m,
        to_track_rad: is_fixed_wing.then(|| gate_deg.to_radians()),
        ..request
    };
    // A line is joined as the plan assumes, by turns in the wind: an autopilot's own join ignores the wind and may circle.
    let way = match is_fixed_wing {
        true => limits.turning_way(&request).or_else(|| limits.open_way(&request)),
        false => limits.best_way(&request),
    };
    let way = way.map(|mut way| {
        if is_fixed_wing {
            way.via.push(gate);
        }
        way
    });
    Ok(answer(way, None))
}

/// Evaluates `(way-to-landing HERE TRACK MET PLACE)`.
fn to_landing(limits: &Limits, arguments: &[Value]) -> Result<Value, String> {
    let Some(request) = start(limits, arguments)? else { return Ok(Value::nil()) };
    let [.., place] = arguments else { return Ok(Value::nil()) };
    let Ok((to, _)) = spot(limits, place) else { return Ok(Value::nil()) };
    let landing = limits.landing(&Request { to, to_altitude_m: limits.elevation_m_at(to), ..request });
    Ok(answer(landing.way, landing.course_deg))
}

/// Evaluates `(way-to-climb HERE HEADING MET ALTITUDE)` for a vehicle that is about to take off: `:centre` of the circle on which it
/// climbs, or nil for a circle where it begins to turn. A take-off whose climb meets the ground is an error, so that the vehicle stays
/// there.
fn to_climb(limits: &Limits, arguments: &[Value]) -> Result<Value, String> {
    let Some(request) = start(limits, arguments)? else { return Ok(Value::nil()) };
    let [.., altitude] = arguments else { return Ok(Value::nil()) };
    let Some(altitude_m) = length(altitude)? else { return Ok(Value::nil()) };
    let climb = Request { to_altitude_m: altitude_m, ..request };
    if let Some(reason) = limits.closed_take_off(&climb) {
        return Err(reason);
    }
    Ok(match limits.climb_circle(&climb) {
        Ok(centre) => centre.map_or_else(Value::nil, |centre| {
            Value::list([Value::list([Value::symbol(":centre"), shown(centre, altitude_m)])])
        }),
        Err(broken) => with_broken(Value::nil(), &broken),
    })
}

/// Evaluates `(way-to-segment HERE TRACK MET FROM TO END)`: returns `(A B OPTIONS)`, the ends of the segment in the order in which it is
/// flown again fastest, followed by the line to END. If that cannot be computed, returns `(FROM TO)`.
fn to_segment(limits: &Limits, arguments: &[Value]) -> Result<Value, String> {
    let [_, _, _, from, to, end, measured @ ..] = arguments else {
        return Err("an end of the segment is missing".to_string());
    };
    let as_it_is = Value::list([from.clone(), to.clone()]);
    let Some(request) = start_of(arguments)? else { return Ok(as_it_is) };
    let ends = spot(limits, from).ok().zip(spot(limits, to).ok()).zip(spot(limits, end).ok());
    let Some((((begin, begin_m), (until, _)), (line_end, _))) = ends else { return Ok(as_it_is) };
    let altitude_m = begin_m.unwrap_or(request.from_altitude_m);
    let segment = Segment { begin, until, line_end, altitude_m };
    let limits = in_measured_wind(limits, &request, measured)?;
    let Some(SegmentWay { is_reversed, way, .. }) = limits.segment_again(&request, &segment) else {
        return Ok(as_it_is);
    };
    let (first, second) = if is_reversed { (to, from) } else { (from, to) };
    let told = answer(Some(way), None);
    let told = told.as_list().unwrap_or_default();
    Ok(Value::list([first.clone(), second.clone()].into_iter().chain(told.iter().cloned())))
}

/// Evaluates `(time-before-line HERE TRACK MET FROM TO TIME)`: the time that is left if the vehicle flies to the lead-in before the line
/// now, which is to begin at TIME since the mission's start; nil if that is not known.
fn before_line(limits: &Limits, arguments: &[Value]) -> Result<Value, String> {
    let Some((request, start)) = start_of_line(limits, arguments, 3)? else { return Ok(Value::nil()) };
    let spare_s = limits.spare_s(&request, &start);
    Ok(spare_s.map_or_else(Value::nil, |spare_s| Value::measured(spare_s, Dimension::TIME)))
}

/// Evaluates `(time-on-circle HERE TRACK MET PLACE FROM TO TIME)`: how long a vehicle that circles PLACE stays on the circle, so that the
/// lead-in before the line begins at TIME; nil if it does not circle there.
fn on_circle(limits: &Limits, arguments: &[Value]) -> Result<Value, String> {
    let Some((request, start)) = start_of_line(limits, arguments, 4)? else { return Ok(Value::nil()) };
    let Some((place, stated_m)) = arguments.get(3).and_then(|place| spot(limits, place).ok()) else {
        return Ok(Value::nil());
    };
    let to_altitude_m = stated_m.unwrap_or(request.from_altitude_m);
    let stay_s = (start.begin_s - request.at_s).max(0.0);
    let (centre, _) = limits.circle_centre(&Request { to: place, to_altitude_m, stay_s, ..request });
    let stay_s = limits.circling_s(&request, centre, &start);
    Ok(stay_s.map_or_else(Value::nil, |stay_s| Value::Duration(Duration::from_seconds(stay_s))))
}

/// Returns the vehicle's position and the line in the arguments `FROM TO TIME` from index `first` on; `None` if a position is not known.
fn start_of_line(
    limits: &Limits,
    arguments: &[Value],
    first: usize,
) -> Result<Option<(Request, PlannedStart)>, String> {
    let Some(request) = start_of(arguments)? else { return Ok(None) };
    let [from, to, time] = arguments.get(first..).unwrap_or_default() else {
        return Err("a line and the instant at which it begins are missing".to_string());
    };
    let ends = spot(limits, from).ok().zip(spot(limits, to).ok());
    let Some(((from, from_m), (to, to_m))) = ends else { return Ok(None) };
    let begin_s = match time.as_number() {
        Some((seconds, Dimension::TIME | Dimension::NONE)) if seconds.is_finite() => seconds,
        _ => return Err(format!("the time must be a duration since the mission's start; got {time}")),
    };
    let altitude_m = from_m.or(to_m).unwrap_or(request.from_altitude_m);
    let known = geodesy::distance_m(from, to) >= 1.0;
    Ok(known.then_some((request, PlannedStart { from, to, altitude_m, begin_s })))
}

/// Returns `(OPTIONS)` or `(OPTIONS NAMES WHY)`: options of the command, and the requirements that must be violated; nil for the straight
/// path.
fn answer(way: Option<Way>, course_deg: Option<f64>) -> Value {
    let mut options = Vec::new();
    if let Some(course_deg) = course_deg {
        options.extend([Value::symbol(":course"), Value::measured(course_deg.to_radians(), Dimension::ANGLE)]);
    }
    let mut broken = None;
    if let Some(Way { via, altitude_m, hold_s, hold_around, broken: found, .. }) = way {
        if hold_s > 0.0 {
            options.extend([Value::symbol(":hold"), Value::Duration(Duration::from_seconds(libm::ceil(hold_s)))]);
        }
        if let Some(centre) = hold_around {
            options.extend([Value::symbol(":hold-around"), shown(centre, altitude_m)]);
        }
        if !via.is_empty() {
            let places = via.into_iter().map(|position| shown(position, altitude_m));
            options.extend([Value::symbol(":via"), Value::list(places)]);
        }
        broken = found;
    }
    match broken {
        Some(broken) => with_broken(Value::list(options), &broken),
        None if options.is_empty() => Value::nil(),
        None => Value::list([Value::list(options)]),
    }
}

/// Returns `(OPTIONS NAMES WHY)`.
fn with_broken(options: Value, Broken { names, why }: &Broken) -> Value {
    Value::list([options, Value::list(names.iter().map(|name| Value::text(name))), Value::text(why)])
}

/// Returns a place on a way, to a decimetre.
fn shown(position: Position, altitude_m: f64) -> Value {
    let round = |number: f64, per: f64| Value::Real(libm::round(number * per) / per);
    Value::list([round(position.latitude_deg, 1e6), round(position.longitude_deg, 1e6), round(altitude_m, 1.0)])
}
