//! Single-visit problems for tests: fires of the western United States, and random ones by seed.

use crate::random::Generator;
use apex_model::problem::{
    AirspaceZone, FOREVER_S, LandingPlace, Manoeuvre, Position, QualityFactor, QualityFactors, SingleVisitProblem,
    SingleVisitTarget, SingleVisitVehicle, TimeWindow, WindField, WindLayer, ZoneKind,
};

const FIRES: &[(&str, f64, f64, f64)] = &[
    ("Zaca", 34.716, -119.783, 10.0),
    ("Lick", 37.15, -121.45, 7.0),
    ("Moonlight", 40.24, -120.85, 8.0),
    ("Butler 2", 34.27, -116.98, 5.0),
    ("Antelope Complex", 40.15, -120.55, 5.0),
    ("Elk Complex", 41.80, -123.40, 6.0),
    ("GW", 44.36, -121.60, 6.0),
    ("Egley Complex", 43.80, -119.50, 6.0),
    ("Domke Lake", 48.18, -120.60, 5.0),
    ("South Omak", 48.35, -119.45, 4.0),
    ("Castle Rock", 43.71, -114.45, 8.0),
    ("Cascade Complex", 44.50, -115.60, 9.0),
    ("East Zone Complex", 45.10, -115.60, 9.0),
    ("Murphy Complex", 42.00, -115.20, 4.0),
    ("Chippy Creek", 47.75, -114.80, 5.0),
    ("Jocko Lakes", 47.20, -113.70, 7.0),
    ("Ahorn", 47.65, -112.75, 5.0),
    ("WH Complex", 45.70, -110.00, 3.0),
    ("Columbine", 44.35, -110.00, 4.0),
    ("Milford Flat", 38.45, -112.95, 5.0),
];

/// Returns a coarse manoeuvre at one altitude, and a finer, slower one.
pub fn manoeuvres(position: Position) -> Vec<Manoeuvre> {
    let line = |azimuth_deg| apex_geo::geodesy::destination(position, azimuth_deg, 9_000.0);
    let lines = vec![(line(180.0), line(0.0))];
    let coarse = QualityFactor { factor: 0.8, cause: "6.9 m per pixel, 5.5 m wanted".to_string() };
    vec![
        Manoeuvre {
            name: "line-7000m".to_string(),
            altitude_m: 7000.0,
            lines: lines.clone(),
            entry: None,
            duration_s: 190.0,
            length_m: 18_000.0,
            quality: QualityFactors { resolution: coarse, ..QualityFactors::default() },
            pictures: None,
        },
        Manoeuvre {
            name: "line-5000m".to_string(),
            altitude_m: 5000.0,
            lines: vec![(line(180.0), line(0.0)), (line(5.0), line(175.0))],
            entry: None,
            duration_s: 560.0,
            length_m: 46_000.0,
            quality: QualityFactors::default(),
            pictures: None,
        },
    ]
}

/// Returns the fires of 2007 from Edwards in `endurance_s`, in a westerly wind.
pub fn western_states(endurance_s: f64) -> SingleVisitProblem {
    let target = |(name, latitude, longitude, value): &(&str, f64, f64, f64)| {
        let position = Position::new(*latitude, *longitude);
        SingleVisitTarget {
            name: (*name).to_string(),
            position,
            value: *value,
            manoeuvres: manoeuvres(position),
            ..SingleVisitTarget::default()
        }
    };
    SingleVisitProblem {
        targets: FIRES.iter().map(target).collect(),
        vehicle: SingleVisitVehicle {
            true_airspeed_mps: 95.0,
            cruise_altitude_m: 7000.0,
            climb_rate_mps: 5.0,
            descent_rate_mps: 5.0,
            fuel_kg: 1700.0,
            fuel_reserve_kg: 150.0,
            fuel_flow_kg_per_s: 0.02,
            endurance_s,
            endurance_reserve_s: 1800.0,
            endurance_limit: None,
            turn_radius_m: 0.0,
        },
        start: Position::new(34.905, -117.884),
        start_altitude_m: 700.0,
        base: Some(Position::new(34.905, -117.884)),
        // 2007-09-08T01:00Z, the evening of 7 September in California.
        zero_unix_s: 1_189_213_200.0,
        wind: WindField {
            layers: vec![WindLayer {
                area: None,
                altitude_m_min: 0.0,
                altitude_m_max: 20_000.0,
                from_s: 0.0,
                until_s: FOREVER_S,
                wind_east_mps: 18.0,
                wind_north_mps: 4.0,
                edr: 0.1,
            }],
            blend: false,
        },
        ..SingleVisitProblem::default()
    }
}

/// Returns a rectangle of restricted airspace.
pub fn restricted(name: &str, south: f64, north: f64, west: f64, east: f64) -> AirspaceZone {
    let corners = [(south, west), (south, east), (north, east), (north, west)];
    AirspaceZone {
        name: name.to_string(),
        kind: ZoneKind::Restricted,
        corners: corners.map(|(latitude, longitude)| Position::new(latitude, longitude)).to_vec(),
        altitude_m_min: 0.0,
        altitude_m_max: 12_000.0,
        active: TimeWindow::ALWAYS,
    }
}

/// Returns `count` random targets with windows, order, zones, landing places and a wind that changes: for the checker.
pub fn random(count: usize, seed: u64) -> SingleVisitProblem {
    let mut generator = Generator::new(seed);
    let mut problem = western_states(20_000.0 + 30_000.0 * generator.unit());
    problem.targets = (0..count)
        .map(|index| {
            let position = Position::new(34.0 + 8.0 * generator.unit(), -122.0 + 8.0 * generator.unit());
            let mut target = SingleVisitTarget {
                name: format!("T{index}"),
                position,
                value: 1.0 + 9.0 * generator.unit(),
                manoeuvres: manoeuvres(position),
                ..SingleVisitTarget::default()
            };
            if generator.below(3) == 0 {
                let from_s = 20_000.0 * generator.unit();
                target.windows = vec![TimeWindow { from_s, until_s: from_s + 12_000.0 * generator.unit() + 600.0 }];
            }
            if generator.below(4) == 0 {
                target.light = apex_model::problem::Light::Night;
            }
            if generator.below(4) == 0 {
                target.timing = vec![(0.0, 0.3), (10_000.0, 1.0), (20_000.0, 0.2)];
            }
            target
        })
        .collect();
    if count > 2 {
        problem.precedence = vec![("T0".to_string(), "T1".to_string())];
    }
    let (south, west) = (36.5 + generator.unit(), -119.5 + generator.unit());
    problem.zones = vec![restricted("R-1", south, south + 0.8, west, west + 1.2), {
        let mut later = restricted("TFR-2", south + 2.0, south + 2.5, west - 1.0, west);
        later.active = TimeWindow { from_s: 4_000.0, until_s: 15_000.0 };
        later
    }];
    problem.zone_margin_m = 2_000.0;
    problem.landing_places = (0..12)
        .map(|index| LandingPlace {
            name: format!("L{index}"),
            position: Position::new(34.0 + 8.0 * generator.unit(), -122.0 + 8.0 * generator.unit()),
        })
        .chain([LandingPlace { name: "Edwards".to_string(), position: problem.start }])
        .collect();
    problem.landing_distance_m_max = Some(260_000.0);
    let mut front = problem.wind.layers.clone();
    for layer in &mut front {
        (layer.from_s, layer.wind_east_mps, layer.wind_north_mps) = (9_000.0, -5.0, 14.0);
    }
    problem.wind.layers.extend(front);
    problem
}
