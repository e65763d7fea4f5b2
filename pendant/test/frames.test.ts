import { describe, expect, it } from 'vitest';
import { isLater, Layout, parseFrame } from '../src/wire/frames';

function frame(values: number[], { kind = 1, layout = 3, sequence = 7, time = 12.5 } = {}): ArrayBuffer {
  const buffer = new ArrayBuffer(16 + 4 * values.length);
  const view = new DataView(buffer);
  view.setUint8(0, kind);
  view.setUint16(2, layout, true);
  view.setUint32(4, sequence, true);
  view.setFloat64(8, time, true);
  values.forEach((value, i) => view.setFloat32(16 + 4 * i, value, true));
  return buffer;
}

describe('parseFrame', () => {
  it('reads header and fields', () => {
    const got = parseFrame(frame([1.5, -2, NaN]))!;
    expect([got.layout, got.sequence, got.time]).toEqual([3, 7, 12.5]);
    expect([...got.values]).toEqual([1.5, -2, NaN]);
  });
  it('reads a frame without fields', () => expect(parseFrame(frame([]))!.values.length).toBe(0));
  it('knows no other kind', () => expect(parseFrame(frame([1], { kind: 2 }))).toBeNull());
  it('takes no part of a frame', () => {
    expect(parseFrame(frame([1]).slice(0, 18))).toBeNull();
    expect(parseFrame(new ArrayBuffer(7))).toBeNull();
  });
});

describe('isLater', () => {
  it('counts across the wrap', () => {
    expect(isLater(2, 1)).toBe(true);
    expect(isLater(1, 1)).toBe(false);
    expect(isLater(0, 0xffffffff)).toBe(true);
    expect(isLater(0xffffffff, 0)).toBe(false);
  });
});

describe('Layout', () => {
  it('finds fields by name', () => {
    const layout = new Layout(1, [
      { name: 'arm/tcp/x', unit: 'm' },
      { name: 'arm/tcp/y', unit: 'm' },
    ]);
    expect([layout.place('arm/tcp/y'), layout.place('arm/tcp/z')]).toEqual([1, -1]);
  });
});
