//! Why an interface cannot be opened, in words that say what to do.

use socketcan::{CanFdSocket, Socket};
use std::fmt;
use std::io;

/// Error returned by [`super::SocketCanBus::open`].
#[derive(Debug)]
pub enum OpenError {
    /// The kernel has no CAN at all.
    NoCan,
    /// There is no interface of this name.
    NoInterface {
        /// The name.
        interface: String,
    },
    /// There is one, but not for CAN.
    NotCan {
        /// The name.
        interface: String,
    },
    /// It is down.
    Down {
        /// The name.
        interface: String,
    },
    /// It takes CAN 2.0 frames only, and CAN FD is asked for.
    Format {
        /// The name.
        interface: String,
    },
    /// The operating system refuses for another reason.
    System {
        /// The name.
        interface: String,
        /// What it says.
        error: io::Error,
    },
}

impl fmt::Display for OpenError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoCan => f.write_str(
                "this kernel has no CAN (load the module can_raw, or run the command with `cargo xtask vcan -- ...`)",
            ),
            Self::NoInterface { interface } => {
                write!(
                    f,
                    "no CAN interface {interface}; expected the name of one that `ip link show type can` or `type vcan` lists"
                )
            }
            Self::NotCan { interface } => {
                write!(f, "{interface} is no CAN interface; expected can0, vcan0 or the like")
            }
            Self::Down { interface } => {
                write!(f, "CAN interface {interface} is down; expected up: ip link set {interface} up")
            }
            Self::Format { interface } => {
                write!(
                    f,
                    "CAN interface {interface} takes no CAN FD frames; expected an MTU of 72, or the format classic"
                )
            }
            Self::System { interface, error } => write!(f, "cannot open CAN interface {interface}: {error}"),
        }
    }
}

impl std::error::Error for OpenError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::System { error, .. } => Some(error),
            Self::NoCan | Self::NoInterface { .. } | Self::NotCan { .. } | Self::Down { .. } | Self::Format { .. } => {
                None
            }
        }
    }
}

/// Interface 0 is every interface: only a kernel without CAN refuses it.
pub fn kernel_has_can() -> Result<(), OpenError> {
    match CanFdSocket::open_iface(0) {
        Err(error) if matches!(error.raw_os_error(), Some(libc::EAFNOSUPPORT | libc::EPROTONOSUPPORT)) => {
            Err(OpenError::NoCan)
        }
        // Any other trouble is met again, with the interface's name.
        Ok(_) | Err(_) => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_refusal_says_what_was_expected() {
        let interface = || "can7".to_owned();
        for (error, says) in [
            (OpenError::NoInterface { interface: interface() }, "no CAN interface can7; expected"),
            (OpenError::NotCan { interface: interface() }, "can7 is no CAN interface; expected"),
            (OpenError::Down { interface: interface() }, "can7 is down; expected up: ip link set can7 up"),
            (OpenError::Format { interface: interface() }, "can7 takes no CAN FD frames; expected an MTU of 72"),
            (OpenError::NoCan, "this kernel has no CAN"),
        ] {
            let line = error.to_string();
            assert!(line.contains(says), "{line}");
            assert!(!line.contains('\n'), "{line}");
        }
    }

    #[test]
    fn an_interface_that_does_not_exist_is_refused_on_any_kernel() {
        let error = super::super::SocketCanBus::open("nosuch0", None, &[]).unwrap_err();
        assert!(matches!(error, OpenError::NoCan | OpenError::NoInterface { .. }), "{error}");
    }
}
