/**
 * State frames: u8 kind · u8 0 · u16 layout id · u32 sequence · f64 cell time (s) · f32 × fields,
 * little-endian.
 */

export const kStateFrame = 1;
const kHeader = 16;

export interface Frame {
  layout: number;
  sequence: number;
  /** Cell time, s. */
  time: number;
  values: Float32Array;
}

const bigEndianHost = new Uint8Array(new Uint16Array([1]).buffer)[0] === 0;

/** Parses a frame. The result may refer to `buffer`. Null if it is not a state frame. */
export function parseFrame(buffer: ArrayBuffer): Frame | null {
  if (buffer.byteLength < kHeader || (buffer.byteLength - kHeader) % 4 !== 0) return null;
  const head = new DataView(buffer);
  if (head.getUint8(0) !== kStateFrame) return null;
  let values = new Float32Array(buffer, kHeader);
  if (bigEndianHost) values = Float32Array.from(values, (_, i) => head.getFloat32(kHeader + 4 * i, true));
  return { layout: head.getUint16(2, true), sequence: head.getUint32(4, true), time: head.getFloat64(8, true), values };
}

/** True if `sequence` is later than `last`, also across the 32-bit overflow. */
export function isLater(sequence: number, last: number): boolean {
  return ((sequence - last) | 0) > 0;
}

export interface Field {
  name: string;
  unit: string;
}

/** Maps the names of fields to their indices in a frame. */
export class Layout {
  private readonly places = new Map<string, number>();
  constructor(
    readonly id: number,
    readonly fields: readonly Field[],
  ) {
    fields.forEach((field, i) => this.places.set(field.name, i));
  }
  /** The index of a field; -1 if it does not exist. */
  place(name: string): number {
    return this.places.get(name) ?? -1;
  }
}
