//! A window of time on a number of pixels.

/// A window of time on a number of pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub(super) from_ns: i64,
    pub(super) to_ns: i64,
    /// End of the known time: nothing later is known.
    pub(super) at_ns: i64,
    pub(super) pixels: usize,
    /// Nanoseconds of a pixel, at least 1.
    pub(super) pixel_ns: i64,
}

impl Window {
    /// Returns the window `from_ns ..= to_ns` on at least one pixel.
    pub(super) fn new((from_ns, to_ns): (i64, i64), at_ns: i64, pixels: usize) -> Window {
        let count = i64::try_from(pixels).unwrap_or(i64::MAX).max(1);
        let pixel_ns = to_ns.saturating_sub(from_ns).saturating_add(count - 1) / count;
        Window { from_ns, to_ns, at_ns, pixels: pixels.max(1), pixel_ns: pixel_ns.max(1) }
    }

    /// Returns the end of the known part of the window.
    pub(super) fn known_ns(self) -> i64 {
        self.to_ns.min(self.at_ns)
    }

    /// Returns the pixel of an instant in the window.
    pub(super) fn pixel(self, at_ns: i64) -> usize {
        let pixel = at_ns.saturating_sub(self.from_ns).checked_div(self.pixel_ns).unwrap_or(0);
        usize::try_from(pixel).unwrap_or(0).min(self.pixels - 1)
    }

    /// Returns the end of a pixel, at which the next one begins; the last pixel has no end.
    pub(super) fn end_ns(self, pixel: usize) -> i64 {
        if pixel + 1 >= self.pixels { i64::MAX } else { self.start_ns(pixel + 1) }
    }

    /// Returns the start of a pixel, in nanoseconds of mission time.
    pub(super) fn start_ns(self, pixel: usize) -> i64 {
        let pixel = i64::try_from(pixel).unwrap_or(i64::MAX);
        self.from_ns.saturating_add(self.pixel_ns.saturating_mul(pixel))
    }
}
