//! Random missions over invented land: zones of all altitude bands and times, fires, recalls, new targets, lost links.

use std::fmt::Write;
use std::path::Path;

/// SplitMix64 (Steele, Lea, Flood 2014).
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Between two numbers.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn below(&mut self, count: u64) -> u64 {
        self.next() % count
    }
}

const KM_PER_DEG: f64 = 111.2;
const HOME: (f64, f64) = (40.0, -115.0);
/// Least distance of zones from home, to leave space for takeoff and landing.
const HOME_ROOM_KM: f64 = 40.0;

/// The files of a mission.
pub(crate) struct RandomMission {
    files: Vec<(&'static str, String)>,
}

fn collection(features: &[String]) -> String {
    format!("{{\"type\": \"FeatureCollection\", \"features\": [\n{}\n]}}\n", features.join(",\n"))
}

fn place(east_km: f64, north_km: f64) -> (f64, f64) {
    let latitude = HOME.0 + north_km / KM_PER_DEG;
    (latitude, HOME.1 + east_km / (KM_PER_DEG * cosine(latitude)))
}

fn cosine(latitude_deg: f64) -> f64 {
    libm::cos(latitude_deg.to_radians())
}

fn ring(corners: &[(f64, f64)]) -> String {
    let mut text = String::from("[[");
    for (index, (latitude, longitude)) in corners.iter().chain(corners.first()).enumerate() {
        let comma = if index > 0 { ", " } else { "" };
        write!(text, "{comma}[{longitude:.5}, {latitude:.5}]").unwrap();
    }
    text.push_str("]]");
    text
}

impl RandomMission {
    /// Returns the mission of a seed.
    pub(crate) fn new(seed: u64) -> RandomMission {
        let mut draws = Draws(seed.wrapping_mul(0x2545_F491_4F6C_DD1D));
        let zones = zones(&mut draws);
        let targets = targets(&mut draws);
        let airfields = [
            ("home", 0.0, 0.0),
            ("field-a", draws.between(-200.0, -80.0), draws.between(-150.0, 150.0)),
            ("field-b", draws.between(80.0, 200.0), draws.between(-150.0, 150.0)),
        ]
        .map(|(id, east_km, north_km)| {
            let (latitude, longitude) = place(east_km, north_km);
            format!(
                "{{\"type\": \"Feature\", \"properties\": {{\"id\": \"{id}\", \"kind\": \"base\", \"elevation_m\": 1200}}, \
                 \"geometry\": {{\"type\": \"Point\", \"coordinates\": [{longitude:.5}, {latitude:.5}]}}}}"
            )
        });
        let winds = format!(
            "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,turbulence\n0,6000,{:.0},{:.1},0.1\n6000,18000,{:.0},{:.1},0.1\n",
            draws.between(0.0, 359.0),
            draws.between(0.0, 12.0),
            draws.between(0.0, 359.0),
            draws.between(0.0, 22.0)
        );
        let reach_nm = draws.between(110.0, 180.0);
        let dropout_h = draws.between(1.0, 4.0);
        let program = PROGRAM
            .replace("REACH", &format!("{reach_nm:.0}nm"))
            .replace("DROPOUT", &format!("({dropout_h:.2}h {:.2}h)", dropout_h + draws.between(0.02, 0.2)))
            .replace("SEED", &seed.to_string());
        RandomMission {
            files: vec![
                ("mission.pdl", program),
                ("airspace.geojson", collection(&zones)),
                ("fires.geojson", collection(&targets)),
                ("airfields.geojson", collection(&airfields)),
                ("winds.csv", winds),
                ("scenario.jsonl", scenario(&mut draws)),
            ],
        }
    }

    /// Writes the mission into a folder.
    pub(crate) fn write(&self, folder: &Path) {
        for (name, text) in &self.files {
            std::fs::write(folder.join(name), text).unwrap();
        }
    }
}

const PROGRAM: &str = r#"(defapplication "Random"
  :type native-sim
  :libraries ("vehicle" "aerial-observation" "contingencies")
  :vehicle (sim :model predator-b :at home)
  :start "2007-09-08T01:00:00Z"
  :duration 9h
  :seed SEED
  :targets "fires.geojson"
  :airspace "airspace.geojson"
  :airfields "airfields.geojson"
  :forecast "winds.csv"
  :scenario "scenario.jsonl"
  :landing-distance REACH
  :modems ((satellite-link :dropouts (DROPOUT)))
  :agents ((agent aircraft-1 :initial-task (fly the mission))))

(solver auto (index (map the fires)) :budget 40ms)

(procedure
  (index (fly the mission))
  (step up (take off to 7000m))
  (step survey (map the fires)
    (waitfor (end ?up))
    (restart-when (new plan))
    (on-failure (inform (survey-impossible))))
  (step touch (keep in touch over satellite-link))
  (step replan (replan because ?what)
    (waitfor (:or (off-schedule ?what) (new-target ?what)))
    (responding)
    (on-failure (inform (no-better-plan ?what))))
  (step detour (fly to ?place) (waitfor (go-to ?place)) (priority 6) (repeating))
  (step early (return to ?field at 7000m) (waitfor (recall ?field)) (priority 9))
  (step stop (terminate) (waitfor (end ?early)))
  (step home (return to home at 7000m) (waitfor (end ?survey)))
  (step finish (terminate) (waitfor (end ?home))))

(procedure :sequential
  (index (replan because ?what))
  (step plan (plan (map the fires)))
  (step use (inform (new plan))))
"#;

fn zones(draws: &mut Draws) -> Vec<String> {
    let mut zones = Vec::new();
    for number in 0..3 + draws.below(6) {
        let radius_km = draws.between(8.0, 55.0);
        let (east_km, north_km) = loop {
            let (east_km, north_km) = (draws.between(-220.0, 220.0), draws.between(-180.0, 180.0));
            if (east_km * east_km + north_km * north_km).sqrt() > radius_km + HOME_ROOM_KM {
                break (east_km, north_km);
            }
        };
        let count = 3 + draws.below(5);
        let turn = draws.between(0.0, std::f64::consts::TAU);
        let corners: Vec<(f64, f64)> = (0..count)
            .map(|corner| {
                let angle = turn + std::f64::consts::TAU * corner as f64 / count as f64;
                let far_km = radius_km * draws.between(0.55, 1.0);
                place(east_km + far_km * libm::cos(angle), north_km + far_km * libm::sin(angle))
            })
            .collect();
        let band = [(0.0, 18_000.0), (0.0, 5_500.0), (9_500.0, 18_000.0), (6_500.0, 7_400.0)];
        let (low_m, high_m) = band.get(draws.below(4) as usize).copied().unwrap_or((0.0, 18_000.0));
        let from_h = draws.between(0.0, 6.0);
        let times = match draws.below(2) {
            0 => String::new(),
            _ => format!(", \"active_h\": [[{from_h:.2}, {:.2}]]", from_h + draws.between(0.3, 4.0)),
        };
        zones.push(format!(
            "{{\"type\": \"Feature\", \"properties\": {{\"id\": \"zone-{number}\", \"name\": \"Zone {number}\", \"kind\": \"restricted\", \
             \"altitude_m_min\": {low_m}, \"altitude_m_max\": {high_m}{times}}}, \"geometry\": {{\"type\": \"Polygon\", \
             \"coordinates\": {}}}}}",
            ring(&corners)
        ));
    }
    if draws.below(2) == 0 {
        let count = 5 + draws.below(4);
        let corners: Vec<(f64, f64)> = (0..count)
            .map(|corner| {
                let angle = std::f64::consts::TAU * corner as f64 / count as f64;
                let far_km = draws.between(170.0, 260.0);
                place(far_km * libm::cos(angle), far_km * libm::sin(angle))
            })
            .collect();
        zones.push(format!(
            "{{\"type\": \"Feature\", \"properties\": {{\"id\": \"area\", \"name\": \"Area\", \"kind\": \"permitted\"}}, \
             \"geometry\": {{\"type\": \"Polygon\", \"coordinates\": {}}}}}",
            ring(&corners)
        ));
    }
    zones
}

fn targets(draws: &mut Draws) -> Vec<String> {
    (0..5 + draws.below(5))
        .map(|number| {
            let (latitude, longitude) = place(draws.between(-170.0, 170.0), draws.between(-150.0, 150.0));
            let acres = draws.between(1_000.0, 12_000.0);
            let value = draws.between(20.0, 90.0);
            format!(
                "{{\"type\": \"Feature\", \"properties\": {{\"id\": \"fire-{number}\", \"kind\": \"fire\", \"acres\": {acres:.0}, \
                 \"value\": {value:.0}, \"resolution_m\": 10, \"elevation_m\": {:.0}}}, \"geometry\": {{\"type\": \"Point\", \
                 \"coordinates\": [{longitude:.5}, {latitude:.5}]}}}}",
                draws.between(900.0, 2_200.0)
            )
        })
        .collect()
}

fn scenario(draws: &mut Draws) -> String {
    let mut events: Vec<(f64, String)> = Vec::new();
    for _ in 0..draws.below(4) {
        events.push((draws.between(1_800.0, 15_000.0), "(off-schedule chance)".to_string()));
    }
    for _ in 0..draws.below(3) {
        let (latitude, longitude) = place(draws.between(-120.0, 120.0), draws.between(-100.0, 100.0));
        events.push((draws.between(2_000.0, 15_000.0), format!("(go-to ({latitude:.5} {longitude:.5}))")));
    }
    if draws.below(2) == 0 {
        let field = ["home", "field-a", "field-b"].get(draws.below(3) as usize).copied().unwrap_or("home");
        events.push((draws.between(3_000.0, 16_000.0), format!("(recall {field})")));
    }
    events.sort_by(|a, b| a.0.total_cmp(&b.0));
    let lines = events.iter().map(|(t_s, event)| format!("{{\"t\": {t_s:.3}, \"event\": \"{event}\"}}\n"));
    lines.collect()
}
