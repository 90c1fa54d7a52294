//! The published examples, round trips, and frames of any content.

mod round_trip;
mod vectors;
