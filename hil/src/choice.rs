//! What people choose of a connection, by the names that every program of Tactus gives it.

use clap::ValueEnum;
use tactus_common::can::Mtu;

/// Format of the frames.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum CanFormat {
    /// CAN 2.0, 8 bytes a frame.
    Classic,
    /// CAN FD, 64 bytes a frame.
    Fd,
}

impl From<CanFormat> for Mtu {
    fn from(format: CanFormat) -> Self {
        match format {
            CanFormat::Classic => Self::Classic,
            CanFormat::Fd => Self::Fd,
        }
    }
}

impl From<Mtu> for CanFormat {
    fn from(mtu: Mtu) -> Self {
        match mtu {
            Mtu::Classic => Self::Classic,
            Mtu::Fd => Self::Fd,
        }
    }
}

/// What makes the ticks come.
#[derive(ValueEnum, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pace {
    /// World and controller wait for one another; silence is 2 s.
    #[default]
    Lockstep,
    /// The clock: a tick every 2 ms, whether the controller has answered or not; silence is 20 periods.
    Realtime,
}

/// The name by which a value is chosen on a command line.
pub fn name(value: &impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_command_line_and_formats_those_of_the_bus() {
        assert_eq!([name(&Pace::Lockstep), name(&Pace::Realtime)], ["lockstep", "realtime"]);
        for mtu in Mtu::ALL {
            assert_eq!(Mtu::from(CanFormat::from(mtu)), mtu);
        }
        assert_eq!([name(&CanFormat::Classic), name(&CanFormat::Fd)], ["classic", "fd"]);
    }
}
