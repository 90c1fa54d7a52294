//! Promises of one touch.
