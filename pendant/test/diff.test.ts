import { describe, expect, it } from 'vitest';
import { diff, merged } from '../src/pages/program/diff';

describe('diff', () => {
  const mine = 'a\nb\nc\nd';
  const theirs = 'a\nx\nc\nd\ne';
  it('shows what differs, between what does not', () =>
    expect(diff(mine, theirs).map((h) => [h.same, h.a.join(''), h.b.join(''), h.aLine, h.bLine])).toEqual([
      [true, 'a', 'a', 1, 1], [false, 'b', 'x', 2, 2], [true, 'cd', 'cd', 3, 3], [false, '', 'e', 5, 5],
    ]));
  it('takes either side, hunk by hunk', () => {
    const hunks = diff(mine, theirs);
    expect(merged(hunks, ['a', 'a'])).toBe(mine);
    expect(merged(hunks, ['b', 'b'])).toBe(theirs);
    expect(merged(hunks, ['a', 'b'])).toBe('a\nb\nc\nd\ne');
  });
  it('gives both texts back whatever they are', () => {
    let seed = 7;
    const random = (n: number) => (seed = (seed * 1103515245 + 12345) % 2147483648) % n;
    for (let round = 0; round < 200; ++round) {
      const make = () => Array.from({ length: random(12) }, () => 'abcd'[random(4)]).join('\n');
      const [a, b] = [make(), make()];
      const hunks = diff(a, b);
      const changes = hunks.filter((h) => !h.same).length;
      expect(merged(hunks, Array(changes).fill('a'))).toBe(a);
      expect(merged(hunks, Array(changes).fill('b'))).toBe(b);
    }
  });
});
