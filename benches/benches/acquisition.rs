//! Synthesis of manoeuvres from data-acquisition goals: one target (bar: 50 ms), and forty (bar: 1 s of processor time), for points, lines
//! and fields of several vehicles.
#![allow(missing_docs, reason = "criterion's macros make public items")]
#![allow(clippy::panic, reason = "a measurement stops at an unexpected result")]

use apex_mission::Mission;
use apex_mission::acquisition::synthesised;
use apex_model::quantity::Dimension;
use apex_model::value::Value;
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::path::Path;

const TARGETS: usize = 40;
/// Metres in a degree of latitude, and of longitude, at the places of the fields.
const DEGREE_M: (f64, f64) = (111_034.0, 85_395.0);

/// Forty targets of one kind for one vehicle.
struct TargetSeries {
    name: &'static str,
    model: &'static str,
    wind_mps: f64,
    /// Half the side of a field, or of a line; 0 for a point.
    half_m: f64,
    is_line: bool,
    /// Distance between the middles of neighbours.
    apart_m: f64,
    pixel_m: f64,
    coverage: f64,
}

const ROWS: [TargetSeries; 6] = [
    TargetSeries { name: "points-rmax", half_m: 0.0, pixel_m: 0.1, ..FIELDS },
    TargetSeries { name: "lines-rmax", half_m: 100.0, is_line: true, ..FIELDS },
    FIELDS,
    TargetSeries { name: "fields-rmax-wind-5cm", wind_mps: 5.0, pixel_m: 0.05, ..FIELDS },
    TargetSeries { name: "fields-quadrotor", model: "quadrotor", pixel_m: 0.02, ..FIELDS },
    TargetSeries {
        name: "fields-fixed-wing",
        model: "fixed-wing-mapper",
        half_m: 150.0,
        apart_m: 500.0,
        pixel_m: 0.1,
        coverage: 0.95,
        ..FIELDS
    },
];

/// Fields of 80 x 80 m at 20 cm.
const FIELDS: TargetSeries = TargetSeries {
    name: "fields-rmax",
    model: "rmax",
    wind_mps: 0.0,
    half_m: 40.0,
    is_line: false,
    apart_m: 200.0,
    pixel_m: 0.2,
    coverage: 0.0,
};

impl TargetSeries {
    fn geometry(&self, index: usize) -> String {
        let (east_m, north_m) = (200.0 + self.apart_m * (index % 8) as f64, self.apart_m * (index / 8) as f64);
        let corner = |x: f64, y: f64| {
            let (east_m, north_m) = (east_m + x * self.half_m, north_m + y * self.half_m);
            format!("[{:.7}, {:.7}]", -100.0 + east_m / DEGREE_M.1, 40.0 + north_m / DEGREE_M.0)
        };
        if self.half_m == 0.0 {
            return format!(r#"{{"type": "Point", "coordinates": {}}}"#, corner(0.0, 0.0));
        }
        if self.is_line {
            let ends = format!("{}, {}", corner(-1.0, -0.3), corner(1.0, 0.3));
            return format!(r#"{{"type": "LineString", "coordinates": [{ends}]}}"#);
        }
        let ring = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)].map(|(x, y)| corner(x, y));
        format!(r#"{{"type": "Polygon", "coordinates": [[{}]]}}"#, ring.join(", "))
    }

    fn mission(&self) -> Mission {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("acquisition-{}", self.name));
        let write = |name: &str, text: &str| {
            std::fs::write(folder.join(name), text).unwrap_or_else(|error| panic!("{name} is not written: {error}"));
        };
        std::fs::create_dir_all(&folder).unwrap_or_else(|error| panic!("no folder for missions: {error}"));
        let target = |index: usize| {
            let properties = format!(r#"{{"id": "t{index}", "kind": "inspection", "value": 100, "resolution_m": 5}}"#);
            format!(r#"{{"type": "Feature", "properties": {properties}, "geometry": {}}}"#, self.geometry(index))
        };
        let pad = r#"{"type": "Feature", "properties": {"id": "pad", "kind": "base"}, "geometry": {"type": "Point", "coordinates": [-100, 40]}}"#;
        let all: Vec<String> = std::iter::once(pad.to_string()).chain((0..TARGETS).map(target)).collect();
        write("targets.geojson", &format!(r#"{{"type": "FeatureCollection", "features": [{}]}}"#, all.join(",\n")));
        let air = format!("0,9000,250,{},0.02", self.wind_mps);
        write("winds.csv", &format!("altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,edr\n{air}\n"));
        let program = format!(
            r#"(defapplication "Acquisition"
  :type native-sim
  :libraries ("vehicle" "aerial-observation" "manoeuvres")
  :vehicle (sim :model {} :at pad)
  :start "2026-06-01T17:00:00Z"
  :duration 4h
  :targets "targets.geojson"
  :forecast "winds.csv"
  :agents ((agent uav-1 :initial-task (wait 1s))))"#,
            self.model
        );
        write("mission.pdl", &program);
        Mission::load(&folder).unwrap_or_else(|error| panic!("{error:?}"))
    }

    fn goal(&self, index: usize) -> Value {
        let word = Value::symbol;
        let resolution = Value::measured(self.pixel_m, Dimension::LENGTH);
        let head = [word("acquire"), word(&format!("t{index}")), word(":resolution"), resolution];
        Value::list(head.into_iter().chain([word(":coverage"), Value::Real(self.coverage)]))
    }
}

fn synthesis(criterion: &mut Criterion) {
    let solve = |mission: &Mission, goal: &Value| {
        synthesised(mission, goal, 0.0).unwrap_or_else(|why| panic!("{goal}: {why}")).len()
    };
    let mut group = criterion.benchmark_group("acquisition");
    group.sample_size(10);
    for row in &ROWS {
        let mission = row.mission();
        let goals: Vec<Value> = (0..TARGETS).map(|index| row.goal(index)).collect();
        for count in [1, TARGETS] {
            group.bench_with_input(BenchmarkId::new(row.name, count), &count, |bencher, count| {
                bencher.iter(|| goals.iter().take(*count).map(|goal| solve(&mission, black_box(goal))).sum::<usize>());
            });
        }
    }
    group.finish();
}

criterion_group!(benches, synthesis);
criterion_main!(benches);
