//! Sensors: line scanners, frame cameras, video cameras and gimbals, as plain figures with derived quantities.
//!
//! Angles across the track are measured from the sensor's vertical axis, positive to the right. Heights are above the
//! ground point that is seen. Bound: every function is O(1), or O(scan rates).

pub mod camera;
pub mod frame;
pub mod gimbal;
pub mod scanner;
pub mod video;

pub use camera::{CameraSetting, ExposureMotion};
pub use frame::FrameCamera;
pub use gimbal::{Gimbal, GimbalAngles, PointingTolerance};
pub use scanner::{LineScanner, RateLimits, RollLimits, ScannerMode};
pub use video::VideoCamera;
