//! Promises of the node.
