//! Arrival of images on the ground, from the messages of the record.
//!
//! A picture is one image, a line of the scanner from its switching on to its switching off another. Images of a sensor arrive in the order
//! in which they were taken (`image-on-ground`); one that is lost (`image-lost`) or stays on board (`image-kept`) is the latest. Images that
//! have not arrived are read after the landing.

use apex_model::time::Time;
use apex_observation::assess::Product;
use std::collections::{BTreeMap, VecDeque};

/// Name of the line scanner in messages.
pub(super) const SCANNER: &str = "scanner";

/// Images that are still on board.
#[derive(Clone, Debug, Default)]
pub(super) struct Arrivals {
    /// Span of time of each image, by the name of its sensor in small letters.
    on_board: BTreeMap<String, VecDeque<(f64, f64)>>,
    /// Spans of images that stay on board until the landing.
    kept: Vec<(f64, f64)>,
    /// Instant at which the scanner was switched on.
    line_begin_s: Option<f64>,
    is_airborne: bool,
    /// True after a crash: images on board are then lost.
    has_crashed: bool,
}

impl Arrivals {
    /// Records a picture.
    pub(super) fn taken(&mut self, camera: &str, at: Time) {
        self.add(camera, (at.seconds(), at.seconds()));
    }

    /// Records that the scanner was switched on or off.
    pub(super) fn switched(&mut self, is_on: bool, at: Time) {
        let begin_s = std::mem::replace(&mut self.line_begin_s, is_on.then_some(at.seconds()));
        if let (Some(begin_s), false) = (begin_s, is_on) {
            self.add(SCANNER, (begin_s, at.seconds()));
        }
    }

    /// Records that the latest image of a sensor was lost.
    pub(super) fn lost(&mut self, sensor: &str) {
        if let Some(images) = self.on_board.get_mut(&sensor.to_lowercase()) {
            images.pop_back();
        }
    }

    /// Records that the latest image of a sensor stays on board until the landing.
    pub(super) fn kept(&mut self, sensor: &str) {
        let latest = self.on_board.get_mut(&sensor.to_lowercase()).and_then(VecDeque::pop_back);
        self.kept.extend(latest);
    }

    /// Returns the image of a sensor that has arrived; `None` for one that was not taken.
    pub(super) fn arrived(&mut self, sensor: &str, at: Time) -> Option<Product> {
        let (from_s, until_s) = self.on_board.get_mut(&sensor.to_lowercase())?.pop_front()?;
        Some(Product { from_s, until_s, on_ground_s: at.seconds() })
    }

    /// Records that the vehicle has crashed.
    pub(super) fn crashed(&mut self) {
        self.has_crashed = true;
    }

    /// Records whether the vehicle is on the ground; returns the images that are read there after a flight.
    pub(super) fn on_ground(&mut self, is_on_ground: bool, at: Time) -> Vec<Product> {
        let has_landed = is_on_ground && self.is_airborne && !self.has_crashed;
        self.is_airborne = !is_on_ground;
        if !has_landed {
            return Vec::new();
        }
        let read = |(from_s, until_s)| Product { from_s, until_s, on_ground_s: at.seconds() };
        let kept = std::mem::take(&mut self.kept);
        std::mem::take(&mut self.on_board).into_values().flatten().chain(kept).map(read).collect()
    }

    fn add(&mut self, sensor: &str, span_s: (f64, f64)) {
        self.on_board.entry(sensor.to_lowercase()).or_default().push_back(span_s);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(seconds: f64) -> Time {
        Time::from_seconds(seconds)
    }

    #[test]
    fn images_of_a_sensor_arrive_in_order_and_the_rest_is_read_after_the_landing() {
        let mut arrivals = Arrivals::default();
        assert_eq!(arrivals.on_ground(true, at(0.0)), [], "before the flight");
        assert_eq!(arrivals.on_ground(false, at(1.0)), []);
        arrivals.taken("Camera-1", at(10.0));
        arrivals.taken("camera-1", at(12.0));
        arrivals.lost("camera-1");
        arrivals.taken("camera-1", at(13.0));
        arrivals.kept("Camera-1");
        arrivals.taken("camera-1", at(14.0));
        arrivals.switched(true, at(20.0));
        arrivals.switched(false, at(80.0));
        let product = |from_s, until_s, on_ground_s| Product { from_s, until_s, on_ground_s };
        assert_eq!(arrivals.arrived("camera-1", at(30.0)), Some(product(10.0, 10.0, 30.0)));
        assert_eq!(arrivals.arrived("camera-2", at(31.0)), None);
        assert_eq!(
            arrivals.arrived("camera-1", at(32.0)),
            Some(product(14.0, 14.0, 32.0)),
            "not the one that stays on board"
        );
        let read = arrivals.on_ground(true, at(900.0));
        assert_eq!(read, [product(20.0, 80.0, 900.0), product(13.0, 13.0, 900.0)]);
        assert_eq!(arrivals.on_ground(true, at(901.0)), []);
    }
}
