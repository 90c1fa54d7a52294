//! Promises of the controller.
