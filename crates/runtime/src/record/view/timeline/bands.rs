//! Density bands: many intervals as a count and a share of ongoing time for each pixel.

use super::super::index::Interval;
use super::pieces::{Pieces, PixelSum};
use super::shapes::Band;
use super::window::Window;
use apex_model::task::TaskState;

/// Largest difference between the share of a band's first pixel and those of the others: a quarter of a pixel of height.
const SHARE_STEP: f64 = 0.02;

/// Intervals gathered by pixel.
pub(super) struct Bands {
    window: Window,
    /// All pixels of the window; `None` for a pixel without an interval.
    pixels: Vec<Option<Pixel>>,
}

#[derive(Clone, Copy, Default)]
struct Pixel {
    count: usize,
    ongoing_ns: i64,
}

impl Bands {
    pub(super) fn new(window: Window) -> Bands {
        Bands { window, pixels: vec![None; window.pixels] }
    }

    /// Adds an interval, which must lie in the window; it is counted in the pixel of its start. Bound: one entry for each pixel that it
    /// touches.
    pub(super) fn add(&mut self, interval: Interval) {
        let first = self.window.pixel(interval.from_ns);
        for at in first..=self.window.pixel(interval.to_ns) {
            let start_ns = self.window.start_ns(at);
            let end_ns = start_ns.saturating_add(self.window.pixel_ns);
            let inside_ns = interval.to_ns.min(end_ns).saturating_sub(interval.from_ns.max(start_ns));
            // An interval that ends at the beginning of a pixel does not touch it.
            if at > first && inside_ns <= 0 {
                continue;
            }
            let Some(pixel) = self.pixels.get_mut(at) else { continue };
            let pixel = pixel.get_or_insert_default();
            pixel.count += usize::from(at == first);
            if interval.state.0 == TaskState::Ongoing {
                pixel.ongoing_ns = pixel.ongoing_ns.saturating_add(inside_ns.max(0));
            }
        }
    }

    /// Adds short intervals by their sums.
    pub(super) fn add_sum(&mut self, sum: PixelSum) {
        let Some(pixel) = self.pixels.get_mut(sum.pixel) else { return };
        let pixel = pixel.get_or_insert_default();
        pixel.count += sum.count;
        pixel.ongoing_ns = pixel.ongoing_ns.saturating_add(sum.ongoing_ns);
    }

    /// Adds all intervals of a task.
    pub(super) fn add_all(&mut self, pieces: Pieces) {
        pieces.single.into_iter().for_each(|interval| self.add(interval));
        pieces.sums.into_iter().for_each(|sum| self.add_sum(sum));
    }

    /// Returns the bands in order of time; neighbouring pixels that only continue earlier intervals form one band.
    pub(super) fn finish(self) -> Vec<Band> {
        let pixel_ns = self.window.pixel_ns;
        let mut bands: Vec<Band> = Vec::new();
        // Share of the first pixel of the last band: all of its pixels look like it.
        let mut first_share = 0.0;
        for (at, pixel) in self.pixels.into_iter().enumerate().filter_map(|(at, pixel)| Some((at, pixel?))) {
            let from_ns = self.window.start_ns(at);
            let to_ns = from_ns.saturating_add(pixel_ns).min(self.window.known_ns()).max(from_ns);
            let ongoing = (pixel.ongoing_ns as f64 / pixel_ns as f64).min(1.0);
            match bands.last_mut() {
                Some(last) if last.to_ns == from_ns && look_the_same(first_share, ongoing) => {
                    let pixels = last.pixels as f64;
                    last.ongoing = (last.ongoing * pixels + ongoing) / (pixels + 1.0);
                    last.to_ns = to_ns;
                    last.pixels += 1;
                    last.count += pixel.count;
                }
                _ => {
                    first_share = ongoing;
                    bands.push(Band { from_ns, to_ns, pixel: at, pixels: 1, count: pixel.count, ongoing });
                }
            }
        }
        bands
    }
}

/// Returns true for shares of two pixels that are drawn with the same height: a lane has about eleven pixels.
fn look_the_same(first: f64, next: f64) -> bool {
    (first - next).abs() <= SHARE_STEP && (first > 0.0) == (next > 0.0)
}
