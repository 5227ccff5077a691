//! An engine that stops between fields of very different elevation.

use crate::harness::{collection, feature, fly, point};

/// The nearest field lies on a mesa, too high to be reached, so the aircraft glides to a lower one farther away.
#[test]
fn a_glide_leads_to_a_field_that_is_low_enough() {
    let base = feature(r#""id": "home", "kind": "base", "elevation_m": 700"#, &point(-117.9, 34.9));
    let fields = "id,name,kind,latitude_deg,longitude_deg,elevation_m\n\
                  mesa,Mesa,landing-place,35.19,-116.9,4300\n\
                  plain,Plain,landing-place,34.45,-116.9,100\n";
    let program = "(defapplication \"Glide\" :type native-sim :libraries (\"vehicle\" \"aerial-observation\" \"contingencies\")\n \
         :vehicle (sim :model predator-b :at home) :duration 3h :targets \"t.geojson\" :airfields \"fields.csv\" :world \"world.json\"\n \
         :agents ((agent uav-1 :initial-task (fly the mission))))\n\
         (procedure (index (fly the mission))\n\
           (step up (take off to 6000m))\n\
           (step cross (fly to (34.9 -116.3 6000)) (waitfor (end ?up)))\n\
           (step safe (guard against contingencies))\n\
           (step finish (terminate) (waitfor (end ?cross))))\n";
    let world = r#"{"format": "apex-world-1", "faults": [{"fault": "engine", "at_s": 1800}]}"#;
    let flown = fly(program, &[("t.geojson", &collection(&[base])), ("fields.csv", fields), ("world.json", world)]);
    assert_eq!(flown.said("crashed"), [], "{}", flown.text());
    let (_, latitude, longitude, _) = flown.track().pop().unwrap();
    assert!((latitude - 34.45).abs() < 0.03 && (longitude + 116.9).abs() < 0.03, "{latitude} {longitude}");
    assert!(flown.text().contains("the engine has stopped: gliding to plain"), "{}", flown.text());
}
