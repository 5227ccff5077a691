//! Monitors against their definition.
