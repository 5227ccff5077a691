//! A window of time on a number of pixels.

/// A window of time on a number of pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub(super) from_ns: i64,
    pub(super) to_ns: i64,
    /// Nothing later is known.
    pub(super) at_ns: i64,
    pub(super) pixels: usize,
}

impl Window {
    /// Returns the end of the known part of the window.
    pub(super) fn known_ns(self) -> i64 {
        self.to_ns.min(self.at_ns)
    }

    /// Nanoseconds of a pixel, at least 1.
    pub(super) fn pixel_ns(self) -> i64 {
        let pixels = i64::try_from(self.pixels).unwrap_or(i64::MAX);
        self.to_ns.saturating_sub(self.from_ns).saturating_add(pixels - 1).checked_div(pixels).unwrap_or(1).max(1)
    }

    /// Returns the pixel of an instant in the window.
    pub(super) fn pixel(self, at_ns: i64) -> usize {
        let pixel = at_ns.saturating_sub(self.from_ns).checked_div(self.pixel_ns()).unwrap_or(0);
        usize::try_from(pixel).unwrap_or(0).min(self.pixels - 1)
    }

    /// Returns the start of a pixel, in nanoseconds of mission time.
    pub(super) fn start_ns(self, pixel: usize) -> i64 {
        let pixel = i64::try_from(pixel).unwrap_or(i64::MAX);
        self.from_ns.saturating_add(self.pixel_ns().saturating_mul(pixel))
    }
}
