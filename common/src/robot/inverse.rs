//! Inverse (stub).
