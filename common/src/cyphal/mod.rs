//! Cyphal/CAN 1.0 transport in fixed memory.
