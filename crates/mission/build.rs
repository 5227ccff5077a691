//! States the layout of the situation, which snapshots in a record have.

#[path = "../runtime/fingerprint.rs"]
mod fingerprint;

fn main() {
    let folders =
        ["src", "../model/src", "../geo/src", "../observation/src", "../requirements/src", "../diagnosis/src"];
    fingerprint::set("APEX_SITUATION_LAYOUT", &folders);
}
