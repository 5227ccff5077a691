//! Random missions with random failures: tours with guards, and surveillance by planners.

use crate::draws::Draws;
use std::fmt::Write;
use std::path::Path;

/// A vehicle with its working altitude, greatest distance of work and duration of the mission.
struct Craft {
    model: &'static str,
    altitude_m: f64,
    reach_km: f64,
    hours: f64,
    camera: bool,
}

const CRAFT: [Craft; 4] = [
    Craft { model: "predator-b", altitude_m: 4_500.0, reach_km: 120.0, hours: 4.0, camera: true },
    Craft { model: "global-hawk", altitude_m: 12_000.0, reach_km: 250.0, hours: 4.0, camera: false },
    Craft { model: "fixed-wing-mapper", altitude_m: 400.0, reach_km: 3.0, hours: 1.0, camera: false },
    Craft { model: "rmax", altitude_m: 100.0, reach_km: 2.0, hours: 1.0, camera: true },
];

const HOME: (f64, f64) = (40.0, -115.0);
const KM_PER_DEG: f64 = 111.2;

/// Writes the mission of a seed into a folder.
pub(crate) fn write(seed: u64, folder: &Path) {
    let mut draws = Draws::new(seed);
    let craft = &CRAFT[draws.below(CRAFT.len() as u64) as usize];
    let places: Vec<(f64, f64)> = (0..2 + draws.below(5)).map(|_| place(&mut draws, craft.reach_km)).collect();
    let planned = draws.happens(0.35);
    let put = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    let zones = zones(&mut draws, craft, &places);
    put("mission.pdl", &program(&mut draws, craft, &places, (planned, zones.is_some())));
    put("places.geojson", &targets(&mut draws, craft, &places));
    put("winds.csv", &winds(&mut draws, craft));
    if let Some(zones) = zones {
        put("zones.geojson", &zones);
    }
    put("world.json", &world(&mut draws, craft));
    put("scenario.jsonl", &scenario(&mut draws, craft));
}

fn place(draws: &mut Draws, reach_km: f64) -> (f64, f64) {
    let (angle, far_km) = (draws.between(0.0, std::f64::consts::TAU), reach_km * draws.between(0.2, 1.0));
    let latitude = HOME.0 + far_km * libm::sin(angle) / KM_PER_DEG;
    (latitude, HOME.1 + far_km * libm::cos(angle) / (KM_PER_DEG * 0.766))
}

fn feature(id: &str, kind: &str, (latitude, longitude): (f64, f64), more: &str) -> String {
    format!(
        "{{\"type\": \"Feature\", \"properties\": {{\"id\": \"{id}\", \"kind\": \"{kind}\"{more}}}, \"geometry\": \
         {{\"type\": \"Point\", \"coordinates\": [{longitude:.5}, {latitude:.5}]}}}}"
    )
}

fn targets(draws: &mut Draws, craft: &Craft, places: &[(f64, f64)]) -> String {
    let mut features = vec![feature("home", "base", HOME, "")];
    if draws.happens(0.7) {
        features.push(feature("field", "base", place(draws, 0.8 * craft.reach_km), ""));
    }
    for (index, at) in places.iter().enumerate() {
        let rate = draws.between(0.05, 0.8);
        features.push(feature(&format!("site-{index}"), "structure", *at, &format!(", \"rate_per_h\": {rate:.3}")));
    }
    format!("{{\"type\": \"FeatureCollection\", \"features\": [\n{}\n]}}\n", features.join(",\n"))
}

/// In most missions there is a zone to avoid, away from the airfield and from the places of work, so that every place can be reached.
fn zones(draws: &mut Draws, craft: &Craft, places: &[(f64, f64)]) -> Option<String> {
    let half_km = 0.06 * craft.reach_km;
    let is_free = |at: &(f64, f64)| {
        let far = |place: &(f64, f64)| {
            let (north_km, east_km) = ((place.0 - at.0) * KM_PER_DEG, (place.1 - at.1) * KM_PER_DEG * 0.766);
            north_km.abs().max(east_km.abs()) > 4.0 * half_km
        };
        far(&HOME) && places.iter().all(far)
    };
    let at = (0..20).map(|_| place(draws, craft.reach_km)).find(is_free);
    let (latitude, longitude) = at.filter(|_| draws.happens(0.6))?;
    let (north, east) = (half_km / KM_PER_DEG, half_km / KM_PER_DEG / 0.766);
    let corner = |n: f64, e: f64| format!("[{:.5}, {:.5}]", longitude + e * east, latitude + n * north);
    let ring =
        [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)].join(", ");
    Some(format!(
        "{{\"type\": \"FeatureCollection\", \"features\": [{{\"type\": \"Feature\", \
         \"properties\": {{\"id\": \"r-1\", \"kind\": \"restricted\"}}, \
         \"geometry\": {{\"type\": \"Polygon\", \"coordinates\": [[{ring}]]}}}}]}}\n"
    ))
}

fn winds(draws: &mut Draws, craft: &Craft) -> String {
    let speed = draws.between(0.0, if craft.reach_km > 50.0 { 18.0 } else { 5.0 });
    let (from, edr) = (draws.between(0.0, 359.0), draws.between(0.0, 0.25));
    format!("altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,edr\n0,25000,{from:.0},{speed:.1},{edr:.2}\n")
}

/// Returns a world for a mission that ships: failures that any vehicle can have.
pub(crate) fn shipped_world(seed: u64, hours: f64, is_far: bool) -> String {
    let faults = vehicle_faults(&mut Draws::new(seed), hours, is_far);
    format!("{{\"format\": \"apex-world-1\", \"faults\": [\n{}\n]}}\n", faults.join(",\n"))
}

/// Failures of engine, energy, power, navigation, acknowledgements and readings, a few in each flight.
fn vehicle_faults(draws: &mut Draws, hours: f64, is_far: bool) -> Vec<String> {
    let per_flight = 0.5 / hours;
    let mut faults = Vec::new();
    let plain = ["engine", "payload-power", "navigation", "acknowledgements", "leak"];
    let variables =
        ["altitude", "location", "true-airspeed", "heading", "fuel", "battery-charge", "ground-speed", "roll-angle"];
    for fault in plain {
        let rate = per_flight * if fault == "engine" { 0.3 } else { 1.0 };
        let by = match fault {
            "leak" => format!(", \"by\": {:.1}", if is_far { draws.between(5.0, 80.0) } else { 0.5 }),
            "navigation" if draws.happens(0.5) => format!(", \"by\": {:.1}", draws.between(-8.0, 8.0)),
            _ => String::new(),
        };
        faults.push(format!(
            "{{\"fault\": \"{fault}\"{by}, \"rate_per_h\": {rate:.4}, \"for_s\": {:.0}}}",
            draws.between(5.0, 900.0)
        ));
    }
    for fault in ["freeze", "silence", "bias"] {
        let of = draws.one(&variables).unwrap_or("altitude");
        let by = if fault == "bias" { format!(", \"by\": {:.3}", draws.between(-0.2, 40.0)) } else { String::new() };
        let for_s = draws.between(5.0, 600.0);
        // A location has no number to which a bias is added: such a world is refused.
        if (fault, of) == ("bias", "location") {
            continue;
        }
        faults.push(format!(
            "{{\"fault\": \"{fault}\", \"of\": \"{of}\"{by}, \"rate_per_h\": {:.4}, \"for_s\": {for_s:.0}}}",
            2.0 * per_flight,
        ));
    }
    faults
}

/// Failures of all kinds; weather in some.
fn world(draws: &mut Draws, craft: &Craft) -> String {
    let per_flight = 0.5 / craft.hours;
    let mut faults = vehicle_faults(draws, craft.hours, craft.reach_km > 50.0);
    faults.push(format!(
        "{{\"fault\": \"modem\", \"of\": \"radio\", \"rate_per_h\": {per_flight:.4}, \"for_s\": {:.0}}}",
        draws.between(10.0, 900.0)
    ));
    if craft.camera {
        for fault in ["gimbal", "sensor", "cooling"] {
            faults.push(format!(
                "{{\"fault\": \"{fault}\", \"of\": \"camera-1\", \"rate_per_h\": {per_flight:.4}, \"for_s\": {:.0}}}",
                draws.between(10.0, 1_800.0)
            ));
        }
    }
    let mut text = format!("{{\"format\": \"apex-world-1\", \"faults\": [\n{}\n]", faults.join(",\n"));
    if draws.happens(0.5) {
        let at = place(draws, craft.reach_km);
        let _ = write!(
            text,
            ", \"storms\": [{{\"latitude_deg\": {:.4}, \"longitude_deg\": {:.4}, \"radius_m\": {:.0}}}]",
            at.0,
            at.1,
            craft.reach_km * 100.0
        );
    }
    if draws.happens(0.5) {
        let at = place(draws, craft.reach_km);
        let (base, top) = (craft.altitude_m * 0.8, craft.altitude_m * 1.2);
        let _ = write!(
            text,
            ", \"clouds\": [{{\"latitude_deg\": {:.4}, \"longitude_deg\": {:.4}, \"radius_m\": {:.0}, \"base_m\": {base:.0}, \"top_m\": {top:.0}, \"cover\": 0.6}}]",
            at.0,
            at.1,
            craft.reach_km * 300.0
        );
    }
    if draws.happens(0.5) {
        text.push_str(", \"wind_error\": {\"sigma_mps\": 1.0}");
    }
    if draws.happens(0.5) {
        text.push_str(", \"ignitions\": {\"detection\": 0.8}");
    }
    text.push_str("}\n");
    text
}

/// Messages of operators: answers, instructions, leases, cancelled targets.
fn scenario(draws: &mut Draws, craft: &Craft) -> String {
    let mut lines: Vec<(f64, &str)> = Vec::new();
    for event in [
        "(instruction resume)",
        "(instruction go-home)",
        "(lease-renewed pilot)",
        "(target-gone site-0)",
        "(new-likelihood site-1 2)",
        "(nonsense without a receiver)",
    ] {
        if draws.happens(0.3) {
            lines.push((draws.between(10.0, craft.hours * 3_600.0), event));
        }
    }
    lines.sort_by(|a, b| a.0.total_cmp(&b.0));
    lines.iter().map(|(t_s, event)| format!("{{\"t\": {t_s:.1}, \"event\": \"{event}\"}}\n")).collect()
}

/// Steps of a tour: circles, pictures and flights to the places.
fn tour(draws: &mut Draws, craft: &Craft, places: &[(f64, f64)]) -> String {
    let altitude = craft.altitude_m;
    let mut tour = String::new();
    for (index, (latitude, longitude)) in places.iter().enumerate() {
        let at = format!("({latitude:.5} {longitude:.5} {altitude:.0})");
        let step = match draws.below(4) {
            0 => format!("(loiter at {at} for {:.0}min)", draws.between(1.0, 8.0)),
            1 if craft.camera => format!("(picture site-{index} from {at})"),
            _ => format!("(fly to {at})"),
        };
        let _ = write!(tour, "\n  (step go-{index} {step} (on-failure (inform (skipped site-{index}))))");
    }
    tour
}

fn program(draws: &mut Draws, craft: &Craft, places: &[(f64, f64)], (planned, zoned): (bool, bool)) -> String {
    let altitude = craft.altitude_m;
    let work = if planned {
        "(step work (patrol the sites) (waitfor (end ?up)) (restart-when (new plan)) (on-failure (inform (survey-impossible))))\n\
         (step plan (keep planning (patrol the sites)))\n\
         (step clock (wait CLOCK))\n\
         (step home (return to home at ALTITUDE) (waitfor (end ?clock)) (priority 10) (on-failure (land or hold)))"
            .replace("CLOCK", &format!("{:.0}min", craft.hours * 40.0))
            .replace("ALTITUDE", &format!("{altitude:.0}m"))
    } else {
        format!(
            "(step work (tour) (waitfor (end ?up)) (on-failure (inform (tour-failed))))\n\
             (step home (return to home at {altitude:.0}m) (waitfor (end ?work)) (on-failure (land or hold)))"
        )
    };
    let tour = tour(draws, craft, places);
    let camera = if craft.camera {
        // A failed action of a camera ends no flight.
        "(step heat (guard camera-1 against heat) (on-failure (inform (skipped heat))))
  (step sun (guard camera-1 against the sun) (on-failure (inform (skipped sun))))"
    } else {
        ""
    };
    format!(
        r#"(defapplication "Faults"
  :type native-sim
  :libraries ("vehicle" "aerial-observation" "contingencies" "replanning")
  :vehicle (sim :model {model} :at home)
  :start "2026-06-01T18:00:00Z"
  :duration {minutes:.0}min
  :end-margin 5min
  :targets "places.geojson"
  {airspace}
  :forecast "winds.csv"
  :scenario "scenario.jsonl"
  :world "world.json"
  :modems ((radio :station home :full-level {full:.0}km))
  :agents ((agent uav-1 :initial-task (fly the mission))))
(solver SOLVER (index (patrol the sites)) :budget 20ms)
(procedure
  (index (fly the mission))
  (step up (take off to {altitude:.0}m) (on-failure (inform (skipped take-off))))
  (step touch (keep in touch over radio))
  (step guard (guard the flight))
  (step contingencies (guard against contingencies))
  (step lease (guard the lease of pilot for {lease:.0}min))
  {camera}
  {work}
  (step finish (terminate) (waitfor (end ?home))))
(procedure :sequential (index (tour)) {tour})
(procedure :sequential
  (index (picture ?site from ?place))
  (step go (fly to ?place))
  (step on (power-up camera-1))
  (step aim (orient camera-1 to ?site))
  (step click (take-picture camera-1))
  (step rest (rest camera-1)))
"#,
        model = craft.model,
        minutes = craft.hours * 60.0,
        airspace = if zoned { ":airspace \"zones.geojson\"" } else { "" },
        full = craft.reach_km * 0.7,
        lease = draws.between(0.5, 2.0) * craft.hours * 60.0,
    )
    .replace("SOLVER", if draws.happens(0.3) { "faulty" } else { "auto" })
}
