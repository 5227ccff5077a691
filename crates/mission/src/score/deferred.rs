//! The observations of a flight, accumulated later than they are made: the samples of a scanner are handed over in parts to a thread,
//! because marking the cells of a swath takes a sixteenth of the time of a simulated flight, and the cells are rarely read.
//!
//! A reader waits until all samples are in the observations. So it receives what it would receive without the thread.

use crate::ground::MissionGround;
use apex_observation::assess::Product;
use apex_observation::flown::{FlightSample, FlownObservation, SensorState};
use std::sync::mpsc;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};
use std::thread::{self, JoinHandle};

/// Number of additions that are handed over together.
const PART: usize = 1024;

/// A frequent addition to the observations.
pub(super) enum Addition {
    Sample(FlightSample),
    Sensor(SensorState),
    Product(Product),
}

/// Additions that are not in the observations yet.
#[derive(Default)]
struct Behind {
    waiting: Vec<Addition>,
    thread: Option<JoinHandle<()>>,
}

/// Observations that a separate thread accumulates, so that they lag behind the flight until they are read.
pub(super) struct DeferredObservation {
    observation: Arc<RwLock<FlownObservation>>,
    behind: Mutex<Behind>,
    ground: MissionGround,
    part: usize,
}

impl DeferredObservation {
    pub(super) fn new(observation: FlownObservation, ground: MissionGround) -> DeferredObservation {
        DeferredObservation::in_parts_of(PART, observation, ground)
    }

    fn in_parts_of(part: usize, observation: FlownObservation, ground: MissionGround) -> DeferredObservation {
        let observation = Arc::new(RwLock::new(observation));
        DeferredObservation { observation, behind: Mutex::default(), ground, part }
    }

    /// Adds `addition`; the observations contain it when they are read next.
    pub(super) fn add(&mut self, addition: Addition) {
        let behind = self.behind.get_mut().unwrap_or_else(PoisonError::into_inner);
        behind.waiting.push(addition);
        if behind.waiting.len() >= self.part {
            behind.settle_thread();
            let (give, take) = mpsc::channel::<Vec<Addition>>();
            let (observation, ground) = (Arc::clone(&self.observation), self.ground.clone());
            let work = move || take.iter().for_each(|part| add_all(&mut write(&observation), part, &ground));
            // Without a thread the additions wait for their reader.
            if let Ok(thread) = thread::Builder::new().name("observations".into()).spawn(work) {
                give.send(std::mem::take(&mut behind.waiting)).ok();
                behind.thread = Some(thread);
            }
        }
    }

    /// Returns the observations up to now. Readers may be several, also on one thread.
    pub(super) fn now(&self) -> RwLockReadGuard<'_, FlownObservation> {
        self.settle();
        self.observation.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes the observations, after all that was added before.
    pub(super) fn change<T>(&mut self, act: impl FnOnce(&mut FlownObservation, &MissionGround) -> T) -> T {
        self.settle();
        act(&mut write(&self.observation), &self.ground)
    }

    fn settle(&self) {
        let mut behind: MutexGuard<'_, Behind> = self.behind.lock().unwrap_or_else(PoisonError::into_inner);
        behind.settle_thread();
        if !behind.waiting.is_empty() {
            add_all(&mut write(&self.observation), std::mem::take(&mut behind.waiting), &self.ground);
        }
    }
}

impl Behind {
    /// Waits for the thread; a panic of it continues here.
    fn settle_thread(&mut self) {
        if let Some(Err(panic)) = self.thread.take().map(JoinHandle::join) {
            std::panic::resume_unwind(panic);
        }
    }
}

impl Clone for DeferredObservation {
    fn clone(&self) -> DeferredObservation {
        DeferredObservation::in_parts_of(self.part, self.now().clone(), self.ground.clone())
    }
}

fn write(observation: &RwLock<FlownObservation>) -> RwLockWriteGuard<'_, FlownObservation> {
    observation.write().unwrap_or_else(PoisonError::into_inner)
}

fn add_all(observation: &mut FlownObservation, additions: Vec<Addition>, ground: &MissionGround) {
    for addition in additions {
        match addition {
            Addition::Sample(sample) => observation.sample(sample, ground),
            Addition::Sensor(state) => observation.sensor(state),
            Addition::Product(product) => observation.product(product),
        }
    }
}
