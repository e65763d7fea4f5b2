import { describe, expect, it } from 'vitest';
import { linesIn } from '../src/pages/run/here';
import { readStatus } from '../src/wire/read';

const at = (file: string, line: number) => ({ file: `/cells/a/${file}`, line });
const program = (file: string, line: number, more = {}) =>
  readStatus({ state: 'running', program: { name: 'a.script', state: 'running', where: at(file, line), ended: false, paused: false, ...more } }, 1).program;
const task = (file: string, line: number, calls = [at(file, line)], state = 'running') => ({ state, where: at(file, line), calls });

describe('the current lines of a text', () => {
  it('are that of the program', () => {
    expect(linesIn('a.script', program('a.script', 7), [task('a.script', 6)])).toEqual([7]);
  });
  it('are empty before the program begins and after it ends', () => {
    expect(linesIn('a.script', program('a.script', 7, { ended: true }), [])).toEqual([]);
    expect(linesIn('a.script', program('a.script', 7, { state: 'ready' }), [])).toEqual([]);
  });
  it('are the call while the program is in a file that it includes', () => {
    const inside = task('grippers.script', 31, [at('a.script', 12), at('grippers.script', 31)]);
    expect(linesIn('a.script', program('grippers.script', 31), [inside])).toEqual([12]);
    expect(linesIn('grippers.script', program('grippers.script', 31), [inside])).toEqual([31]);
    expect(linesIn('a.script', program('grippers.script', 31), [])).toEqual([]);
  });
  it('are those of all tasks that go on', () => {
    const tasks = [task('a.script', 40, undefined, 'waiting'), task('a.script', 12), task('a.script', 5, undefined, 'finished')];
    expect(linesIn('a.script', program('a.script', 40), tasks)).toEqual([12, 40]);
  });
});
