//! Numbers in few bytes: fixed steps in 16 or 24 bits, little-endian.

/// Angle resolution on the wire: 1 microradian in 24 bits, so +-8.38 rad.
pub(super) const ANGLE_LSB_RAD: f32 = 1e-6;
/// Arm torque resolution: 1/256 Nm in 16 bits, so +-128 Nm (J2's mechanical limit is 109.5).
pub(super) const ARM_TORQUE_LSB_NM: f32 = 1.0 / 256.0;
/// Hand effort resolution: 1 mNm in 16 bits, so +-32.7 Nm.
pub(super) const EFFORT_LSB_NM: f32 = 1e-3;
/// Fingertip torque resolution: 50 uNm in 16 bits, so +-1.64 Nm (the strain gauge ends at 1.14).
pub(super) const TIP_LSB_NM: f32 = 5e-5;
/// Hand command value resolution: 1e-6 rad, rad/s or Nm in 24 bits, so +-8.38.
pub(super) const HAND_VALUE_LSB: f32 = 1e-6;

const I24_MAX: f32 = 8_388_607.0;

/// Nearest multiple of `lsb`, saturated to 24 bits, little-endian. NaN packs as 0.
pub(super) fn pack_i24(value: f32, lsb: f32) -> [u8; 3] {
    let counts = libm::roundf(value / lsb).clamp(-I24_MAX, I24_MAX) as i32;
    let [a, b, c, _] = counts.to_le_bytes();
    [a, b, c]
}

pub(super) fn unpack_i24(raw: [u8; 3], lsb: f32) -> f32 {
    let sign = if raw[2] & 0x80 != 0 { 0xff } else { 0 };
    i32::from_le_bytes([raw[0], raw[1], raw[2], sign]) as f32 * lsb
}

pub(super) fn pack_i16(value: f32, lsb: f32) -> [u8; 2] {
    (libm::roundf(value / lsb).clamp(-32_767.0, 32_767.0) as i16).to_le_bytes()
}

pub(super) fn unpack_i16(raw: [u8; 2], lsb: f32) -> f32 {
    f32::from(i16::from_le_bytes(raw)) * lsb
}
