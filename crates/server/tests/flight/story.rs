//! The fictitious flight of the fixture: its events and decisions, as a list in order of time.

/// One event.
pub enum Entry {
    Created {
        task: u64,
        parent: Option<u64>,
        tag: String,
        goal: String,
        place: String,
        text: String,
    },
    Selected {
        task: u64,
        method: String,
        text: String,
    },
    Transition {
        task: u64,
        from: &'static str,
        to: &'static str,
        outcome: Option<&'static str>,
        text: String,
        place: String,
    },
    Other {
        kind: &'static str,
        task: Option<u64>,
        subject: String,
        text: String,
    },
    Target {
        target: String,
        state: &'static str,
        detail: String,
    },
}

/// Position sample of the aircraft.
#[derive(Clone)]
pub struct Sample {
    pub t_ns: i64,
    pub latitude_deg: f64,
    pub longitude_deg: f64,
    pub altitude_m: f64,
    pub heading_deg: f64,
    pub roll_deg: f64,
    pub ground_speed_mps: f64,
    pub fuel_kg: f64,
}

/// A fire.
pub struct Target {
    pub id: String,
    pub name: String,
    pub latitude_deg: f64,
    pub longitude_deg: f64,
    pub value: f64,
}

/// A whole flight.
pub struct Story {
    pub targets: Vec<Target>,
    pub entries: Vec<(i64, Entry)>,
    pub samples: Vec<Sample>,
}

/// The mission's procedures, to which the places in the record refer.
pub const PDL: &str = r#";; western-states: map the fires of one night.

(procedure
  (index (fly-mission ?plan))
  (profile flight-path)
  (step s1 (take-off))
  (step s2 (survey ?plan) (waitfor ?s1))
  (step s3 (land edwards) (waitfor ?s2))
  (step watch (maintain-safety) (waitfor ?s1))
  (step t (terminate) (waitfor ?s3)))

(procedure
  (index (maintain-safety))
  (step link (keep-communication))
  (step fuel (watch-fuel :reserve 250 kg))
  (step levels (keep-wings-level)
        (waitfor (:episode violation
                   :measurement (roll-angle aircraft-1 = ?roll)
                   :test (> (abs ?roll) 3 deg)
                   :duration 5 s))
        (respond)))

(procedure
  (index (observe ?fire))
  (step go (fly-to ?fire))
  (step scan (scan-lines ?fire) (waitfor ?go))
  (step send (send-images ?fire) (waitfor ?scan))
  (step t (terminate) (waitfor ?send)))

(procedure
  (index (scan-lines ?fire))
  (profile flight-path line-scanner)
  (step line (fly-line ?line)
        (forall ?line in (lines ?fire)))
  (step t (terminate) (waitfor ?line)))

(primitive
  (index (fly-line ?line))
  (profile flight-path)
  (restart-when (resumed))
  (on-start (command `(fly-line ,?line))))
"#;

const FIRES: [(&str, f64, f64, f64, usize); 10] = [
    ("Zaca", 34.716, -119.783, 5.0, 4),
    ("Lick", 37.15, -121.45, 3.5, 2),
    ("Moonlight", 40.24, -120.85, 5.0, 3),
    ("Elk Complex", 41.80, -123.40, 3.0, 2),
    ("GW", 44.36, -121.60, 2.5, 2),
    ("Domke Lake", 48.18, -120.60, 4.0, 2),
    ("Cascade Complex", 44.50, -115.60, 6.0, 5),
    ("Castle Rock", 43.71, -114.45, 4.5, 3),
    ("Murphy Complex", 42.00, -115.20, 5.5, 3),
    ("Butler 2", 34.27, -116.98, 5.2, 2),
];
const EDWARDS: (f64, f64) = (34.905, -117.884);
const METRES_PER_DEGREE: f64 = 111_195.0;
const STEP_S: f64 = 15.0;
const SECOND: f64 = 1e9;

impl Story {
    /// Returns a long flight over ten fires: smoke hides one, one line is flown again, one link is lost.
    pub fn western_states() -> Story {
        let mut teller = Teller::new();
        teller.fly();
        let mut story = teller.story;
        story.entries.sort_by_key(|(t_ns, _)| *t_ns);
        story
    }

    /// Returns mission time of the last sample.
    pub fn end_ns(&self) -> i64 {
        self.samples.last().map_or(0, |sample| sample.t_ns)
    }
}

struct Teller {
    story: Story,
    now: Sample,
    next_task: u64,
}

impl Teller {
    fn new() -> Teller {
        let now = Sample {
            t_ns: 0,
            latitude_deg: EDWARDS.0,
            longitude_deg: EDWARDS.1,
            altitude_m: 702.0,
            heading_deg: 240.0,
            roll_deg: 0.0,
            ground_speed_mps: 0.0,
            fuel_kg: 1_770.0,
        };
        let targets = FIRES.iter().map(|&(name, latitude_deg, longitude_deg, value, _)| Target {
            id: name.to_lowercase().replace(' ', "-"),
            name: name.into(),
            latitude_deg,
            longitude_deg,
            value,
        });
        let story = Story { targets: targets.collect(), entries: Vec::new(), samples: vec![now.clone()] };
        Teller { story, now, next_task: 1 }
    }

    fn fly(&mut self) {
        let root = self.create(None, "root", "(fly-mission plan-7)", 3);
        self.start(root, "procedure fly-mission");
        for index in 0..FIRES.len() {
            self.target(index, "planned", "in the plan of 2-Opt");
        }
        let takeoff = self.create(Some(root), "s1", "(take-off)", 6);
        let survey = self.create(Some(root), "s2", "(survey plan-7)", 7);
        let land = self.create(Some(root), "s3", "(land edwards)", 8);
        let watch = self.create(Some(root), "watch", "(maintain-safety)", 9);
        self.start(takeoff, "primitive take-off");
        self.fly_to(EDWARDS.0 - 0.1, EDWARDS.1 - 0.25, 3_000.0);
        self.end(takeoff, "success", "the vehicle finished command 1");
        self.start(watch, "procedure maintain-safety");
        let link = self.create(Some(watch), "link", "(keep-communication)", 14);
        let fuel = self.create(Some(watch), "fuel", "(watch-fuel :reserve 250 kg)", 15);
        let levels = self.create(Some(watch), "levels", "(keep-wings-level)", 16);
        self.start(link, "primitive keep-communication");
        self.start(fuel, "primitive watch-fuel");
        self.start(survey, "plan of 2-Opt");
        self.other("solve", Some(survey), "(survey plan-7)", "2-Opt was asked: no procedure or primitive matches");
        for index in 0..FIRES.len() {
            self.observe(survey, index);
        }
        self.end(survey, "success", "all of its steps have ended");
        self.start(land, "primitive land");
        self.fly_to(EDWARDS.0, EDWARDS.1, 702.0);
        self.end(land, "success", "the vehicle finished command 88");
        self.transition(levels, "pending", "terminated", Some("cut"), "T1 above it ended", 16);
        for task in [link, fuel, watch] {
            self.end(task, "cut", "T1 above it ended");
        }
        self.end(root, "success", "all of its steps have ended");
    }

    fn observe(&mut self, survey: u64, index: usize) {
        let (name, latitude, longitude, _, lines) = FIRES[index];
        let observe =
            self.create(Some(survey), &format!("visit-{}", index + 1), &format!("(observe {})", id(name)), 23);
        self.start(observe, "procedure observe");
        let go = self.create(Some(observe), "go", &format!("(fly-to {})", id(name)), 25);
        let scan = self.create(Some(observe), "scan", &format!("(scan-lines {})", id(name)), 26);
        let send = self.create(Some(observe), "send", &format!("(send-images {})", id(name)), 27);
        self.start(go, "primitive fly-to");
        let half = 0.16;
        self.fly_to(latitude - half, longitude - half, 7_010.0);
        self.end(go, "success", "the vehicle finished command 5");
        if name == "GW" {
            self.target(index, "skipped", "cloud over the whole area at arrival");
            self.end(scan, "failure", "its subtask failed: (cloud-cover gw) = 0.94");
            self.end(send, "cut", "its parent ended");
            self.end(observe, "failure", "its subtask failed");
            return;
        }
        self.target(index, "observing", &format!("{lines} lines"));
        self.start(scan, "procedure scan-lines");
        for line in 0..lines {
            self.line(scan, index, line, lines, half);
        }
        self.end(scan, "success", &format!("all {lines} items of its forall have ended"));
        self.start(send, "primitive send-images");
        self.target(index, "observed", &format!("{lines} lines, coverage 0.9{index}"));
        self.end(send, "success", "the vehicle finished command 9");
        self.end(observe, "success", "all of its steps have ended");
    }

    fn line(&mut self, scan: u64, index: usize, line: usize, lines: usize, half: f64) {
        let (name, latitude, longitude, ..) = FIRES[index];
        let row = latitude - half + 2.0 * half * line as f64 / (lines.max(2) - 1) as f64;
        let (start, end) = if line.is_multiple_of(2) { (-half, half) } else { (half, -half) };
        let task = self.create(Some(scan), "line", &format!("(fly-line ({} {}))", id(name), line + 1), 33);
        self.fly_to(row, longitude + start, 7_010.0);
        self.start(task, "primitive fly-line");
        if name == "Moonlight" && line == 1 {
            self.fly_to(row, longitude, 7_010.0);
            self.refly(task, row, longitude + start);
        }
        self.fly_to(row, longitude + end, 7_010.0);
        self.end(task, "success", "the vehicle finished its line");
    }

    fn refly(&mut self, line: u64, latitude: f64, longitude: f64) {
        let keep = self.create(Some(line), "levels", "(fly-again segment-12)", 16);
        self.other(
            "satisfied",
            Some(keep),
            "waitfor",
            "(roll-angle aircraft-1) = 7.2deg for 5.5 s, 11 samples: longer than 5 s",
        );
        self.start(keep, "primitive fly-again");
        let text = format!("T{keep} outranks it on flight-path (priority 7 > 3)");
        self.transition(line, "ongoing", "interrupted", None, &text, 16);
        self.fly_to(latitude, longitude, 7_010.0);
        self.end(keep, "success", "the vehicle finished command 31");
        self.transition(line, "interrupted", "ongoing", None, "it was granted flight-path", 40);
    }

    /// Flies straight to a point in steps, climbing or sinking towards the altitude, with a bank at the start.
    fn fly_to(&mut self, latitude: f64, longitude: f64, altitude_m: f64) {
        for step in 0..100_000 {
            let shrink = (self.now.latitude_deg.to_radians()).cos();
            let north = (latitude - self.now.latitude_deg) * METRES_PER_DEGREE;
            let east = (longitude - self.now.longitude_deg) * METRES_PER_DEGREE * shrink;
            let distance = north.hypot(east);
            let heading = east.atan2(north).to_degrees().rem_euclid(360.0);
            let turn = (heading - self.now.heading_deg + 540.0).rem_euclid(360.0) - 180.0;
            let speed = 88.0 + 9.0 * (heading.to_radians() + 0.6).cos();
            let leg = (speed * STEP_S).min(distance);
            self.now.t_ns += (STEP_S * SECOND) as i64;
            self.now.latitude_deg += leg * heading.to_radians().cos() / METRES_PER_DEGREE;
            self.now.longitude_deg += leg * heading.to_radians().sin() / METRES_PER_DEGREE / shrink;
            let climb = (altitude_m - self.now.altitude_m).clamp(-4.0 * STEP_S, 5.0 * STEP_S);
            self.now.altitude_m += climb;
            self.now.heading_deg = heading;
            self.now.roll_deg = if step < 2 { (turn / 4.0).clamp(-20.0, 20.0) } else { 0.4 * (step as f64).sin() };
            self.now.ground_speed_mps = speed;
            self.now.fuel_kg -= STEP_S * (0.021 + climb.max(0.0) * 0.0004);
            self.story.samples.push(self.now.clone());
            if leg >= distance {
                return;
            }
        }
    }

    fn tell(&mut self, entry: Entry) {
        self.story.entries.push((self.now.t_ns, entry));
    }

    fn create(&mut self, parent: Option<u64>, tag: &str, goal: &str, line: u32) -> u64 {
        let task = self.next_task;
        self.next_task += 1;
        let text = match parent {
            Some(parent) => format!("T{parent} started and has this step"),
            None => "it is the agent's initial task".into(),
        };
        self.tell(Entry::Created { task, parent, tag: tag.into(), goal: goal.into(), place: place(line), text });
        task
    }

    fn start(&mut self, task: u64, method: &str) {
        self.transition(task, "pending", "enabled", None, "its preconditions hold", 3);
        self.tell(Entry::Selected { task, method: method.into(), text: "it is the only match".into() });
        self.transition(task, "enabled", "ongoing", None, "it needs no resources", 3);
    }

    fn end(&mut self, task: u64, outcome: &'static str, text: &str) {
        self.transition(task, "ongoing", "terminated", Some(outcome), text, 3);
    }

    fn transition(
        &mut self,
        task: u64,
        from: &'static str,
        to: &'static str,
        outcome: Option<&'static str>,
        text: &str,
        line: u32,
    ) {
        self.tell(Entry::Transition { task, from, to, outcome, text: text.into(), place: place(line) });
    }

    fn other(&mut self, kind: &'static str, task: Option<u64>, subject: &str, text: &str) {
        self.tell(Entry::Other { kind, task, subject: subject.into(), text: text.into() });
    }

    fn target(&mut self, index: usize, state: &'static str, detail: &str) {
        let target = id(FIRES[index].0);
        self.tell(Entry::Target { target, state, detail: detail.into() });
    }
}

fn id(name: &str) -> String {
    name.to_lowercase().replace(' ', "-")
}

fn place(line: u32) -> String {
    format!("western-states.pdl:{line}:3")
}
