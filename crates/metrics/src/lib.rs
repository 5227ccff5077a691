//! apex-metrics
