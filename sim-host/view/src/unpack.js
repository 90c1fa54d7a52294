// Numbers as the payload packs them: { kind, offset, scale, data }.

const KINDS = { u16: Uint16Array, u32: Uint32Array, f32: Float32Array };

/** The values, as floats, or as integers where they are counts. */
export function unpack(packed) {
  const bytes = Uint8Array.from(atob(packed.data), (c) => c.charCodeAt(0));
  const raw = new KINDS[packed.kind](bytes.buffer);
  return packed.kind === "u16" ? Float32Array.from(raw, (v) => packed.offset + packed.scale * v) : raw;
}
