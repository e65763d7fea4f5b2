import { describe, expect, it } from 'vitest';
import { withLines } from '../src/state/log';

const lines = (from: number, to: number, process = 'a') =>
  Array.from({ length: to - from + 1 }, (_, i) => ({ number: from + i, time: from + i, level: 'info', text: `${process} ${from + i}` }));
const texts = (of: { text: string }[]) => of.map((each) => each.text);

describe('the log', () => {
  it('adds new lines', () => expect(texts(withLines(lines(1, 2), lines(3, 4)))).toEqual(['a 1', 'a 2', 'a 3', 'a 4']));
  it('takes a history that it knows only once', () => {
    expect(texts(withLines(lines(1, 3), lines(1, 5)))).toEqual(['a 1', 'a 2', 'a 3', 'a 4', 'a 5']);
    expect(texts(withLines(lines(1, 3), lines(2, 3)))).toEqual(['a 1', 'a 2', 'a 3']);
  });
  it('drops the lines of another process, whether it has said less or more', () => {
    for (const count of [1, 3, 5])
      expect(texts(withLines(lines(1, 3), lines(1, count, 'b')))).toEqual(texts(lines(1, count, 'b')));
  });
  it('takes the whole history where its beginning is not known', () => {
    expect(texts(withLines(lines(5, 6), lines(2, 6)))).toEqual(texts(lines(2, 6)));
  });
  it('keeps the newest lines', () => {
    const all = withLines(lines(1, 2000), lines(2001, 2100));
    expect([all.length, all[0]!.number]).toEqual([2000, 101]);
  });
});
