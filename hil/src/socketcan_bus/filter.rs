//! Which frames the kernel lets through to us.

use socketcan::CanFilter;
use tactus_common::can::ID_MAX;
use tactus_common::cyphal::NodeId;

/// Lets data frames with 29-bit identifiers through whose identifier agrees with `id` in the bits of `mask`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IdFilter {
    /// The wanted bits.
    pub id: u32,
    /// Which bits count.
    pub mask: u32,
}

impl IdFilter {
    /// Frames of this node: the source is in the seven lowest bits.
    pub const fn from_node(node: NodeId) -> Self {
        Self { id: node.get() as u32, mask: 0x7f }
    }
}

impl From<IdFilter> for CanFilter {
    fn from(filter: IdFilter) -> Self {
        // These two bits: 29 bits long; no remote frame.
        let flags = libc::CAN_EFF_FLAG | libc::CAN_RTR_FLAG;
        Self::new(filter.id & ID_MAX | libc::CAN_EFF_FLAG, filter.mask & ID_MAX | flags)
    }
}
