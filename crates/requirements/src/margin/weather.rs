//! Icing, turbulence, wind.

/// Lowest and highest temperature, in degrees Celsius, at which ice forms in cloud or humid air.
pub const ICING_C: (f64, f64) = (-20.0, 0.0);
/// Relative humidity above which air counts as cloud.
pub const ICING_HUMIDITY: f64 = 0.9;

/// Returns true if ice forms: the temperature is within [`ICING_C`], in cloud or with a relative humidity (0 to 1) above
/// [`ICING_HUMIDITY`].
pub fn is_icing(temperature_c: f64, in_cloud: bool, relative_humidity: f64) -> bool {
    (ICING_C.0..=ICING_C.1).contains(&temperature_c) && (in_cloud || relative_humidity > ICING_HUMIDITY)
}

/// Returns the margin in seconds: icing may last `allowed_s`.
pub fn icing_s(exposed_s: f64, allowed_s: f64) -> f64 {
    allowed_s - exposed_s
}

/// Returns the margin in m^(2/3)/s: eddy dissipation rate (cube root) below the limit.
pub fn turbulence_edr(edr: f64, edr_max: f64) -> f64 {
    edr_max - edr
}

/// Returns the margin in m/s: wind below the limit. `error_mps` widens a forecast by its standard deviation.
pub fn wind_mps(wind_mps: f64, error_mps: f64, wind_mps_max: f64) -> f64 {
    wind_mps_max - wind_mps - error_mps
}
