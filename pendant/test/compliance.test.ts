import { describe, expect, it } from 'vitest';
import { parseCompliance, writeCompliance } from '../src/pages/program/compliance';

describe('comply()', () => {
  it('is read and written as it was', () => {
    for (const text of ['comply("z")', 'comply("x y rz", stiffness = 500)', 'comply("z", force = 20N, most = 2 * (10N + 5N), reach = 10mm)'])
      expect(writeCompliance(parseCompliance(text)!)).toBe(text);
  });
  it('keeps its form only where the form shows all of it', () => {
    for (const text of ['comply(axes)', 'comply("z", 20N)', 'comply("{a}")', 'stiff()', 'comply("z", unknown = 1)'])
      expect(parseCompliance(text)).toBeNull();
  });
});
