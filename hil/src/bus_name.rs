//! Names of live buses, as people give them on a command line.

use crate::bus::LiveBus;
use crate::slcan_bus::SlcanBus;
use crate::socketcan_bus::{IdFilter, SocketCanBus};
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;
use tactus_common::can::Mtu;
use tactus_common::cyphal::NodeId;

/// A bus outside this process.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BusName {
    /// A CAN interface of Linux.
    SocketCan(String),
    /// A serial line, pseudo terminal or Unix socket that speaks SLCAN.
    Slcan(PathBuf),
}

/// What a bus is called, for error messages and help.
pub const EXPECTED: &str = "socketcan:IFACE (a CAN interface), or slcan:PATH (a serial device or Unix socket)";

impl FromStr for BusName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            Some(("socketcan", iface)) if !iface.is_empty() => Ok(Self::SocketCan(iface.to_owned())),
            Some(("slcan", path)) if !path.is_empty() => Ok(Self::Slcan(path.into())),
            _ => Err(format!("'{text}' is no bus; expected: {EXPECTED}")),
        }
    }
}

impl fmt::Display for BusName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SocketCan(iface) => write!(f, "socketcan:{iface}"),
            Self::Slcan(path) => write!(f, "slcan:{}", path.display()),
        }
    }
}

impl BusName {
    /// Opens it, to send frames of format `mtu` (`None`: CAN FD where the bus carries it) and to receive what nodes in
    /// `sources` send.
    ///
    /// # Errors
    /// One line: what, where, what was expected.
    pub fn open(&self, mtu: Option<Mtu>, sources: &[NodeId]) -> std::io::Result<Box<dyn LiveBus>> {
        match self {
            Self::SocketCan(interface) => {
                let filters: Vec<_> = sources.iter().map(|source| IdFilter::from_node(*source)).collect();
                let bus = SocketCanBus::open(interface, mtu, &filters).map_err(std::io::Error::other)?;
                Ok(Box::new(bus))
            }
            Self::Slcan(path) if mtu == Some(Mtu::Fd) => Err(std::io::Error::other(format!(
                "SLCAN on {} has no CAN FD frames; expected: classic",
                path.display()
            ))),
            Self::Slcan(path) => Ok(Box::new(SlcanBus::open(path)?)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_and_shown_alike_and_what_is_no_bus_is_refused_with_what_was_expected() {
        for name in ["socketcan:vcan0", "slcan:/dev/ttyACM0"] {
            assert_eq!(name.parse::<BusName>().unwrap().to_string(), name);
        }
        for name in ["", "vcan0", "socketcan:", "slcan:", "usb:1"] {
            assert!(name.parse::<BusName>().unwrap_err().contains("expected: socketcan:IFACE"), "{name}");
        }
    }
}
