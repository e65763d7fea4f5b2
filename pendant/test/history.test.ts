import { describe, expect, it } from 'vitest';
import { csv, History } from '../src/pages/plots/history';

function filled(most: number, rows: number) {
  const history = new History(most);
  history.setNames(['a', 'b']);
  for (let i = 0; i < rows; ++i) history.push(i, (_, place) => (place === 0 ? i : 10 * i));
  return history;
}

describe('History', () => {
  it('keeps the newest rows', () => {
    const history = filled(4, 10);
    expect([history.oldest, history.newest]).toEqual([6, 9]);
    expect(history.slice(0, 100, ['b', 'a'])).toEqual({ times: [6, 7, 8, 9], columns: [[60, 70, 80, 90], [6, 7, 8, 9]] });
  });
  it('gives one row beyond each end', () =>
    expect(filled(100, 10).slice(3.5, 5.5, ['a']).times).toEqual([3, 4, 5, 6]));
  it('has nothing of a name that it does not know', () => expect(filled(4, 2).slice(0, 9, ['c']).columns).toEqual([[null, null]]));
  it('keeps what stays when names come and go', () => {
    const history = filled(10, 3);
    history.setNames(['b', 'c']);
    history.push(3, () => 7);
    expect(history.slice(0, 9, ['b', 'c']).columns).toEqual([[0, 10, 20, 7], [null, null, null, 7]]);
  });
  it('passes over a row that is not later, and forgets all when the cell begins anew', () => {
    const history = filled(10, 5);
    history.push(4, () => 99);
    expect(history.newest).toBe(4);
    expect(history.slice(4, 4, ['a']).columns[0]).toEqual([3, 4]);
    history.push(0.5, () => 1);
    expect(history.slice(0, 9, ['a'])).toEqual({ times: [0.5], columns: [[1]] });
  });
  it('says what was at a time, and nothing of times before the first row or in a gap', () => {
    const history = filled(100, 10);
    expect(history.at(4, ['a', 'b'])).toEqual([4, 40]);
    expect(history.at(4.3, ['b', 'c'])).toEqual([40, null]);
    expect(history.at(-0.1, ['a'])).toEqual([null]);
    expect(history.at(4.8, ['a'])).toEqual([null]);
    expect(history.at(9.2, ['a'])).toEqual([9]);
    expect(new History(4).at(NaN, ['a'])).toEqual([null]);
  });
  it('is written as a table', () =>
    expect(csv({ times: [0.5], columns: [[1.25], [null]] }, ['x [rad]', 'say "y", z'])).toBe('time [s],x [rad],"say ""y"", z"\n0.500000,1.25,\n'));
});
