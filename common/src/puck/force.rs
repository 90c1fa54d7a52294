//! The force/torque sensor at the wrist: three numbers of 16 bits a frame, low byte first.

/// Force units per newton.
pub const UNITS_PER_N: f32 = 256.0;
/// Torque units per newton-metre.
pub const UNITS_PER_NM: f32 = 4096.0;
/// Acceleration units per m/s^2.
pub const UNITS_PER_M_S2: f32 = 1024.0;

/// One frame of the sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Triple {
    /// x, y, z in the frame's units.
    pub xyz: [i16; 3],
    /// A seventh byte, where there is one. In torque frames bit 6 = saturated now (the values are not valid), bits 5-0 =
    /// gauges that saturated since the last tare.
    pub flags: Option<u8>,
}

impl Triple {
    /// x, y, z in SI units; `units` is one of this module's constants.
    pub fn scaled(&self, units: f32) -> [f32; 3] {
        self.xyz.map(|value| f32::from(value) / units)
    }

    /// The six bytes of x, y, z.
    pub fn pack(&self) -> [u8; 6] {
        let [[a, b], [c, d], [e, f]] = self.xyz.map(i16::to_le_bytes);
        [a, b, c, d, e, f]
    }

    /// Reads six or seven bytes; `None` for any other number.
    pub fn unpack(raw: &[u8]) -> Option<Self> {
        let (&[a, b, c, d, e, f], rest) = raw.split_first_chunk()?;
        let flags = match rest {
            [] => None,
            [flags] => Some(*flags),
            _ => return None,
        };
        Some(Self { xyz: [[a, b], [c, d], [e, f]].map(i16::from_le_bytes), flags })
    }
}
