//! Dynamics (stub).
