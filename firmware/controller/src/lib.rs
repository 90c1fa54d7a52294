//! placeholder
#![no_std]

pub mod belief;
pub mod error;
pub mod evidence;
pub mod optimise;
pub mod predict;
pub mod touch;
pub mod update;
