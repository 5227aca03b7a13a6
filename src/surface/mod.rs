//! Deformed interfaces and contact as the tracer sees them.
