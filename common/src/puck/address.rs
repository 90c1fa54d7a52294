//! Who sends to whom: the 11-bit identifier.
//!
//! Bit 10: the destination is a group. Bits 9-5: sender. Bits 4-0: destination.

use crate::can::BASE_ID_MAX;

const GROUP: u16 = 1 << 10;
const FIELD: u16 = 0x1f;

/// Number of a node, 0..31.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Node(u8);

impl Node {
    /// The host computer.
    pub const HOST: Self = Self(0);
    /// Motor pucks M1..M7 of the arm.
    pub const ARM: [Self; 7] = [Self(1), Self(2), Self(3), Self(4), Self(5), Self(6), Self(7)];
    /// Force/torque sensor at the wrist.
    pub const FORCE: Self = Self(8);
    /// Safety module.
    pub const SAFETY: Self = Self(10);
    /// Motor pucks of the hand: F1, F2, F3, spread. The last one also carries the palm's tactile pad.
    pub const HAND: [Self; 4] = [Self(11), Self(12), Self(13), Self(14)];

    /// `None` above 31.
    pub const fn new(number: u8) -> Option<Self> {
        if number as u16 <= FIELD { Some(Self(number)) } else { None }
    }

    /// The number.
    pub const fn get(self) -> u8 {
        self.0
    }

    /// 0..6 = M1..M7 if it is a puck of the arm.
    pub fn arm_motor(self) -> Option<usize> {
        Self::ARM.iter().position(|node| *node == self)
    }

    /// 0..3 = F1, F2, F3, spread if it is a puck of the hand.
    pub fn hand_motor(self) -> Option<usize> {
        Self::HAND.iter().position(|node| *node == self)
    }
}

/// Number of a group, 0..31.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Group(u8);

impl Group {
    /// Every puck except the safety module.
    pub const ALL_PUCKS: Self = Self(0);
    /// M1..M4: packed torques.
    pub const LOWER_ARM: Self = Self(1);
    /// M5..M7: packed torques.
    pub const WRIST: Self = Self(2);
    /// M1..M7.
    pub const ARM: Self = Self(4);
    /// F1, F2, F3, spread.
    pub const HAND: Self = Self(5);
    /// To here pucks send positions.
    pub const POSITION: Self = Self(3);
    /// To here pucks send the values of ordinary properties.
    pub const VALUE: Self = Self(6);
    /// To here pucks send the position of their second encoder alone.
    pub const SECONDARY: Self = Self(7);
    /// To here pucks send the ten strongest cells of a pad.
    pub const TACTILE_TOP: Self = Self(8);
    /// To here pucks send whole pads.
    pub const TACTILE_FULL: Self = Self(9);
    /// Force of the sensor at the wrist.
    pub const FORCE: Self = Self(10);
    /// Torque of the sensor at the wrist.
    pub const TORQUE: Self = Self(11);
    /// Acceleration of the sensor at the wrist.
    pub const ACCELERATION: Self = Self(12);

    /// `None` above 31.
    pub const fn new(number: u8) -> Option<Self> {
        if number as u16 <= FIELD { Some(Self(number)) } else { None }
    }

    /// The number.
    pub const fn get(self) -> u8 {
        self.0
    }
}

/// Where a frame goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Destination {
    /// To one node.
    Node(Node),
    /// To all nodes of a group.
    Group(Group),
}

impl From<Node> for Destination {
    fn from(node: Node) -> Self {
        Self::Node(node)
    }
}

impl From<Group> for Destination {
    fn from(group: Group) -> Self {
        Self::Group(group)
    }
}

/// Sender and destination. Every value has an identifier, every 11-bit identifier is one of these.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Address {
    /// The sender.
    pub from: Node,
    /// Where it goes.
    pub to: Destination,
}

impl Address {
    /// Reads an identifier; `None` above 11 bits.
    pub const fn parse(id: u32) -> Option<Self> {
        if id > BASE_ID_MAX as u32 {
            return None;
        }
        let low = (id as u16 & FIELD) as u8;
        let to = if id as u16 & GROUP != 0 { Destination::Group(Group(low)) } else { Destination::Node(Node(low)) };
        Some(Self { from: Node((id as u16 >> 5 & FIELD) as u8), to })
    }

    /// The identifier; [`Address::parse`] inverts it.
    pub const fn id(self) -> u16 {
        let to = match self.to {
            Destination::Node(node) => node.0 as u16,
            Destination::Group(group) => GROUP | group.0 as u16,
        };
        (self.from.0 as u16) << 5 | to
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_identifier_is_an_address_and_back() {
        for id in 0..=BASE_ID_MAX {
            assert_eq!(Address::parse(id.into()).map(Address::id), Some(id));
        }
        assert_eq!(Address::parse(u32::from(BASE_ID_MAX) + 1), None);
        assert_eq!((Node::new(32), Group::new(32)), (None, None));
    }

    #[test]
    fn pucks_answer_under_the_published_identifiers() {
        let id = |node: u8, to: Group| Address { from: Node(node), to: to.into() }.id();
        let expected = [
            (Group::POSITION, [0x423, 0x4e3, 0x563, 0x583, 0x5a3, 0x5c3]),
            (Group::VALUE, [0x426, 0x4e6, 0x566, 0x586, 0x5a6, 0x5c6]),
            (Group::SECONDARY, [0x427, 0x4e7, 0x567, 0x587, 0x5a7, 0x5c7]),
        ];
        for (group, ids) in expected {
            assert_eq!([1, 7, 11, 12, 13, 14].map(|node| id(node, group)), ids);
        }
        assert_eq!([11, 12, 13, 14].map(|node| id(node, Group::TACTILE_TOP)), [0x568, 0x588, 0x5a8, 0x5c8]);
        assert_eq!([11, 12, 13, 14].map(|node| id(node, Group::TACTILE_FULL)), [0x569, 0x589, 0x5a9, 0x5c9]);
        assert_eq!([Group::FORCE, Group::TORQUE, Group::ACCELERATION].map(|g| id(8, g)), [0x50a, 0x50b, 0x50c]);
        assert_eq!([(8, Group::VALUE), (10, Group::VALUE)].map(|(n, g)| id(n, g)), [0x506, 0x546]);
        assert_eq!(id(10, Group::ALL_PUCKS), 1344, "the safety module's own broadcast");
    }

    #[test]
    fn the_host_calls_a_puck_by_its_number_and_groups_from_0x400() {
        let host = |to| Address { from: Node::HOST, to }.id();
        assert_eq!(host(Node::HAND[0].into()), 0x00b);
        let groups = [Group::ALL_PUCKS, Group::LOWER_ARM, Group::WRIST, Group::ARM, Group::HAND];
        assert_eq!(groups.map(|g| host(g.into())), [0x400, 0x401, 0x402, 0x404, 0x405]);
    }
}
