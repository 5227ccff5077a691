//! Downlink of pictures: processing on board, a store, and a link whose rate falls with its signal level.
//!
//! A command may order that its pictures stay on board, or how they are sent. Pictures are sent in the order in which they were taken.
//! Bound: O(1) for each step and picture.

use super::DownlinkSpec;
use apex_model::value::Value;
use std::collections::VecDeque;

/// Signal level below which nothing is transmitted.
const LEVEL_MIN: f64 = 0.1;

/// Name of the line scanner in messages.
pub(crate) const SCANNER: &str = "scanner";

/// Handling of the images of one command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum DataOrder {
    /// They stay in the store until the landing.
    Store,
    /// They are sent as they are.
    Stream,
    /// Each is processed for a time, and a product is sent that has this share of its size.
    Process { delay_s: f64, share: f64 },
}

/// Outcome of storing an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stored {
    /// It is sent when its turn comes.
    Queued,
    /// It stays on board until the landing.
    Kept,
    /// It did not fit into the store.
    Lost,
}

impl Stored {
    /// Returns the head of the message about an image that will not arrive before the landing.
    pub(crate) fn message(self) -> Option<&'static str> {
        match self {
            Stored::Queued => None,
            Stored::Kept => Some("image-kept"),
            Stored::Lost => Some("image-lost"),
        }
    }
}

/// One picture, or line of a scanner, in the store.
#[derive(Clone, Debug)]
struct Queued {
    /// Camera and target as in the message about the delivered picture.
    camera: String,
    target: Value,
    ready_s: f64,
    left_mbit: f64,
}

/// The store and the link.
#[derive(Clone, Debug)]
pub(crate) struct Downlink {
    pub(crate) spec: DownlinkSpec,
    queue: VecDeque<Queued>,
    /// Size of the images that stay on board.
    kept_mbit: f64,
    is_scanning: bool,
    /// Handling of the lines of the scanner.
    pub(crate) scanner_order: Option<DataOrder>,
}

/// A picture that has arrived.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Delivered {
    pub(crate) camera: String,
    pub(crate) target: Value,
}

impl Downlink {
    pub(crate) fn new(spec: DownlinkSpec) -> Downlink {
        Downlink { spec, queue: VecDeque::new(), kept_mbit: 0.0, is_scanning: false, scanner_order: None }
    }

    /// Returns the used capacity of the store.
    pub(crate) fn used_mbit(&self) -> f64 {
        self.kept_mbit + self.queue.iter().map(|queued| queued.left_mbit).sum::<f64>()
    }

    /// Adds a picture to the store, to be handled as ordered, otherwise as the world states.
    pub(crate) fn store(&mut self, camera: &str, target: Value, order: Option<DataOrder>, now_s: f64) -> Stored {
        let size_mbit = self.spec.picture_mbit;
        if self.used_mbit() + size_mbit > self.spec.store_mbit {
            return Stored::Lost;
        }
        let (delay_s, share) = match order {
            None => (self.spec.processing_s, 1.0),
            Some(DataOrder::Stream) => (0.0, 1.0),
            Some(DataOrder::Process { delay_s, share }) => (delay_s, share),
            Some(DataOrder::Store) => {
                self.kept_mbit += size_mbit;
                return Stored::Kept;
            }
        };
        let (ready_s, left_mbit) = (now_s + delay_s, share * size_mbit);
        self.queue.push_back(Queued { camera: camera.to_owned(), target, ready_s, left_mbit });
        Stored::Queued
    }

    /// Observes the scanner; adds the image of a line to the store when it ends. Returns its outcome; `None` without an image.
    pub(crate) fn scan(&mut self, is_scanning: bool, now_s: f64) -> Option<Stored> {
        let was_scanning = std::mem::replace(&mut self.is_scanning, is_scanning);
        let has_ended = was_scanning && !is_scanning;
        has_ended.then(|| self.store(SCANNER, Value::symbol("line"), self.scanner_order, now_s))
    }

    /// Empties the store: all images are read after a landing.
    pub(crate) fn read_out(&mut self) {
        self.queue.clear();
        self.kept_mbit = 0.0;
    }

    /// Transmits during the `dt` seconds that end now; returns the pictures that have been delivered completely.
    pub(crate) fn send(&mut self, level: f64, now_s: f64, dt: f64) -> Vec<Delivered> {
        let mut budget = if level < LEVEL_MIN { 0.0 } else { self.spec.rate_mbit_s * level.min(1.0) * dt };
        let mut arrived = Vec::new();
        while let Some(first) = self.queue.front_mut().filter(|first| first.ready_s <= now_s && budget > 0.0) {
            let sent = first.left_mbit.min(budget);
            first.left_mbit -= sent;
            budget -= sent;
            if first.left_mbit > 0.0 {
                break;
            }
            if let Some(Queued { camera, target, .. }) = self.queue.pop_front() {
                arrived.push(Delivered { camera, target });
            }
        }
        arrived
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn downlink() -> Downlink {
        let over = "radio".to_owned();
        Downlink::new(DownlinkSpec { over, rate_mbit_s: 2.0, picture_mbit: 40.0, store_mbit: 100.0, processing_s: 5.0 })
    }

    #[test]
    fn a_picture_takes_processing_and_its_size_over_the_rate() {
        let mut link = downlink();
        assert_eq!(link.store("camera-1", Value::symbol("barn"), None, 0.0), Stored::Queued);
        let arrivals: Vec<i32> = (1..60).filter(|s| !link.send(1.0, f64::from(*s), 1.0).is_empty()).collect();
        assert_eq!(arrivals, [24], "5 s of processing, 20 s of sending; the second that ends at 5 s counts");
    }

    #[test]
    fn a_line_of_the_scanner_is_one_image_that_leaves_when_the_line_ends() {
        let mut link = downlink();
        let mut arrivals = Vec::new();
        for second in 0..60 {
            assert_ne!(link.scan((10..20).contains(&second), f64::from(second)), Some(Stored::Lost));
            arrivals.extend(link.send(1.0, f64::from(second), 1.0).into_iter().map(|image| (second, image.camera)));
        }
        assert_eq!(arrivals, [(44, "scanner".to_string())], "the end at 20 s, 5 s of processing, 20 s of sending");
    }

    #[test]
    fn a_weak_link_sends_less_and_a_full_store_loses() {
        let mut link = downlink();
        let stored = [1, 2, 3].map(|_| link.store("camera-1", Value::nil(), None, 0.0));
        assert_eq!(stored, [Stored::Queued, Stored::Queued, Stored::Lost]);
        assert!(link.send(0.05, 100.0, 50.0).is_empty());
        assert_eq!(link.used_mbit(), 80.0);
        assert_eq!(link.send(0.5, 150.0, 50.0).len(), 1);
        assert!((link.used_mbit() - 30.0).abs() < 1e-9);
    }

    #[test]
    fn pictures_are_handled_as_their_command_orders() {
        let process = DataOrder::Process { delay_s: 2.0, share: 0.1 };
        // Its 4 Mbit leave in the seconds that end at 2 s and at 3 s: the second in which a picture becomes ready counts.
        for (order, arrives_s) in [(DataOrder::Stream, Some(20)), (process, Some(3)), (DataOrder::Store, None)] {
            let mut link = downlink();
            let expected = if order == DataOrder::Store { Stored::Kept } else { Stored::Queued };
            assert_eq!(link.store("camera-1", Value::symbol("barn"), Some(order), 0.0), expected);
            let arrival_s = (1..60).find(|s| !link.send(1.0, f64::from(*s), 1.0).is_empty());
            assert_eq!(arrival_s, arrives_s, "{order:?}");
            let used_mbit = if order == DataOrder::Store { 40.0 } else { 0.0 };
            assert_eq!(link.used_mbit(), used_mbit, "{order:?}");
            link.read_out();
            assert_eq!(link.used_mbit(), 0.0, "{order:?}");
        }
    }
}
