//! What crosses the wire (see `docs/protocol.md`).
