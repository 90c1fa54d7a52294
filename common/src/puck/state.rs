//! What the numbers of STAT, MODE, ROLE and CMD and the bits of the pendant mean.

macro_rules! numbers {
    ($(#[$doc:meta])* $name:ident { $($(#[$item:meta])* $variant:ident = $number:literal,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(i16)]
        pub enum $name { $($(#[$item])* $variant = $number,)* }

        impl $name {
            /// Every value.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            /// The number on the bus.
            pub const fn number(self) -> i16 {
                self as i16
            }

            /// `None` for a number without meaning.
            pub const fn from_number(number: i32) -> Option<Self> {
                match number {
                    $($number => Some(Self::$variant),)*
                    _ => None,
                }
            }
        }
    };
}

numbers! {
    /// STAT: what state the firmware is in. Setting it to `Ready` leaves the boot loader.
    Status {
        /// In the boot loader; knows the properties 0..7 alone.
        Reset = 0,
        /// Error.
        Error = 1,
        /// Works.
        Ready = 2,
    }
}

numbers! {
    /// MODE of a motor puck.
    Mode {
        /// Phases shorted: brakes by resistance, passes torques over.
        Idle = 0,
        /// Fixed duty cycle.
        Duty = 1,
        /// Obeys T.
        Torque = 2,
        /// Holds P.
        Position = 3,
        /// Moves the set-point by V counts each millisecond.
        Velocity = 4,
        /// Moves to E with MV and ACCEL.
        Trapezoidal = 5,
    }
}

numbers! {
    /// MODE of the safety module.
    SafetyMode {
        /// Pucks without power.
        EmergencyStop = 0,
        /// Pucks powered and idle.
        Idle = 1,
        /// Pucks obey torques.
        Active = 2,
    }
}

numbers! {
    /// CMD of a hand puck: the orders that are known to be used.
    HandOrder {
        /// Initialise: finds the stops and the origin of the encoder. Moves the finger.
        Initialise = 13,
        /// Close a step (DS).
        CloseStep = 14,
        /// Open a step (DS).
        OpenStep = 15,
        /// Close with torque.
        CloseTorque = 16,
        /// Open with torque.
        OpenTorque = 17,
        /// Close to CT.
        Close = 18,
        /// Move to DP.
        Move = 19,
        /// Open to OT.
        Open = 20,
        /// Stop.
        Terminate = 21,
    }
}

/// ROLE: what a puck is and what is fitted to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Role(pub u16);

impl Role {
    /// Motor of the arm, by [`Role::kind`].
    pub const ARM_MOTOR: u16 = 0;
    /// Safety module.
    pub const SAFETY: u16 = 2;
    /// Motor of the hand.
    pub const HAND_MOTOR: u16 = 5;
    /// Force/torque sensor.
    pub const FORCE: u16 = 6;
    /// Absolute encoder on the motor.
    pub const ABSOLUTE_ENCODER: u16 = 0x0100;
    /// Strain gauge (fingertip torque).
    pub const STRAIN_GAUGE: u16 = 0x0800;
    /// Tactile pad.
    pub const TACTILE: u16 = 0x1000;
    /// Encoder on the joint.
    pub const JOINT_ENCODER: u16 = 0x4000;

    /// The kind of puck, without what is fitted.
    pub const fn kind(self) -> u16 {
        self.0 & 0x1f
    }

    /// Is this fitted?
    pub const fn has(self, option: u16) -> bool {
        self.0 & option != 0
    }
}

/// One light of the pendant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Light {
    /// Safe.
    Green,
    /// Warning.
    Yellow,
    /// Fault.
    Red,
}

/// Button of the pendant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Button {
    /// Emergency stop is latched.
    EmergencyStop,
    /// Shift and activate.
    Activate,
    /// Shift and idle.
    Idle,
    /// None.
    None,
}

/// PEN of the safety module: buttons and lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pendant {
    /// Pressed button.
    pub button: Button,
    /// Activate lamp.
    pub activate_lamp: bool,
    /// Idle lamp.
    pub idle_lamp: bool,
    /// Seven segments: bits 0..6 = top, top right, bottom right, bottom, bottom left, top left, middle; `0x3f` shows 0.
    pub segments: u8,
    /// Velocity, torque, voltage, heartbeat, other.
    pub lights: [Light; 5],
}

impl Pendant {
    /// Reads the value of PEN; `None` unless exactly one colour of each light is on.
    pub fn parse(value: u32) -> Option<Self> {
        let mut lights = [Light::Green; 5];
        for (n, light) in lights.iter_mut().enumerate() {
            *light = match value >> (3 * n) & 7 {
                0b001 => Light::Green,
                0b010 => Light::Yellow,
                0b100 => Light::Red,
                _ => return None,
            };
        }
        let button = match value >> 26 & 3 {
            0b00 => Button::EmergencyStop,
            0b01 => Button::Activate,
            0b10 => Button::Idle,
            _ => Button::None,
        };
        Some(Self {
            button,
            activate_lamp: value >> 25 & 1 == 1,
            idle_lamp: value >> 24 & 1 == 1,
            segments: (value >> 16) as u8,
            lights,
        })
    }
}
