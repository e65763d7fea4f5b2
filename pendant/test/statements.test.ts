import { describe, expect, it } from 'vitest';
import { appendStatement, copyStatement, freeName, insertAfter, moveStatement, removeStatement, replaceStatement } from '../src/pages/program/edits';
import { clauseOf, parseMove, splitComment, splitTop, statementsOf, withClause, writeMove } from '../src/pages/program/statements';

const text = `# a job
load cycledata
while Repeat
  movel Pick, speed 50%   # down
  if Held
    set A = true
  else
    wait 1s
  end
end
movej Home
`;
const at = (line: number, of = text) => statementsOf(of).find((each) => each.line === line)!;

describe('statementsOf', () => {
  it('tells depth, blocks and parts of blocks', () => {
    expect(statementsOf(text).map((s) => [s.line, s.depth, s.word])).toEqual([
      [1, 0, '#'], [2, 0, 'load'], [3, 0, 'while'], [4, 1, 'movel'], [5, 1, 'if'], [6, 2, 'set'], [7, 1, 'else'],
      [8, 2, 'wait'], [9, 1, 'end'], [10, 0, 'end'], [11, 0, 'movej'],
    ]);
    expect(at(3).blockEnd).toBe(10);
    expect(at(5).blockEnd).toBe(9);
    expect([at(7).middle, at(9).closes, at(4).comment]).toEqual([true, true, 'down']);
  });
  it('joins lines that go on', () => {
    const [only] = statementsOf('movej [A,\n  B], # both\n  blend 5mm');
    expect([only!.line, only!.endLine, only!.text, only!.comment]).toEqual([1, 3, 'movej [A, B], blend 5mm', 'both']);
  });
  it('knows the blocks that hang behind a wait or a move, and of errors', () => {
    const words = statementsOf('try\n wait C timeout 2s else\n  log("no")\n end\non error e\n retry 2\nend\non stop\n set A = 1\nendon');
    expect(words.map((s) => s.depth)).toEqual([0, 1, 2, 1, 0, 1, 0, 0, 1, 0]);
  });
  it('takes the thesis’s form without blanks', () =>
    expect(statementsOf('while Repeat\nmoveto p0\nendwhile').map((s) => s.depth)).toEqual([0, 1, 0]));
  it('lives with blocks that are not ended, and ends without a block', () => {
    expect(statementsOf('while A\nmovej P')[0]!.blockEnd).toBe(2);
    expect(statementsOf('end\nmovej P').map((s) => s.depth)).toEqual([0, 0]);
  });
});

describe('splitComment', () => {
  it('does not cut quotes', () => expect(splitComment('log("#1") # it')).toEqual(['log("#1") ', 'it']));
  it('lets a back-quoted name be', () => expect(splitComment('movej `a#b`')).toEqual(['movej `a#b`', '']));
});

describe('parseMove', () => {
  it('takes target and clauses apart and puts them together again', () => {
    const line = 'movel offset(Pick, z = 20mm), speed 50%, blend 5mm, exact';
    const move = parseMove(line)!;
    expect(move.target).toBe('offset(Pick, z = 20mm)');
    expect(move.clauses).toEqual([{ word: 'speed', value: '50%' }, { word: 'blend', value: '5mm' }, { word: 'exact', value: '' }]);
    expect(writeMove(move)).toBe(line);
  });
  it('reads clauses without commas, and a point that is called as a clause', () => {
    expect(parseMove('movej speed speed 10%')).toEqual({ word: 'movej', via: '', target: 'speed', clauses: [{ word: 'speed', value: '10%' }] });
  });
  it('knows both places of an arc', () => {
    const move = parseMove('movec Edge, Corner, speed 1m/s')!;
    expect([move.via, move.target]).toEqual(['Edge', 'Corner']);
    expect(writeMove(move)).toBe('movec Edge, Corner, speed 1m/s');
  });
  it('keeps what happens on the way', () => {
    const line = 'movel P, at end - 30mm set Open = true';
    expect(writeMove(parseMove(line)!)).toBe(line);
  });
  it('changes one clause', () => {
    const move = parseMove('movel P, speed 50%')!;
    expect(writeMove(withClause(move, 'speed', '20%'))).toBe('movel P, speed 20%');
    expect(writeMove(withClause(move, 'blend', '5mm'))).toBe('movel P, speed 50%, blend 5mm');
    expect(writeMove(withClause(move, 'speed', null))).toBe('movel P');
    expect(clauseOf(move, 'blend')).toBeNull();
  });
  it('is nothing for another statement', () => expect(parseMove('wait 1s')).toBeNull());
  it('splits at commas of its own level only', () => expect(splitTop('a(b, c), "x, y", d')).toEqual(['a(b, c)', '"x, y"', 'd']));
});

describe('edits', () => {
  it('replace a statement, its blanks and comment stay', () =>
    expect(replaceStatement(text, at(4), 'movel Place').text.split('\n')[3]).toBe('  movel Place  # down'));
  it('insert behind, and inside of what opens a block', () => {
    expect(insertAfter(text, at(4), 'wait 2s').text.split('\n')[4]).toBe('  wait 2s');
    expect(insertAfter(text, at(3), 'wait 2s').text.split('\n')[3]).toBe('  wait 2s');
    expect(insertAfter(text, at(7), 'wait 2s').text.split('\n')[7]).toBe('    wait 2s');
    expect(insertAfter(text, null, 'wait 2s').text.split('\n')[1]).toBe('wait 2s');
    expect(insertAfter('', null, 'wait 2s')).toEqual({ text: 'wait 2s\n', line: 1 });
  });
  it('append at the end', () => expect(appendStatement('movej A\n\n', 'movej B')).toEqual({ text: 'movej A\nmovej B\n', line: 2 }));
  it('remove a block whole, or only what it is made of', () => {
    expect(removeStatement(text, at(5))).not.toContain('wait 1s');
    const kept = removeStatement(text, at(5), true).split('\n');
    expect(kept.slice(3, 7)).toEqual(['  movel Pick, speed 50%   # down', '  set A = true', '  wait 1s', 'end']);
  });
  it('copy a block', () => {
    const made = copyStatement(text, at(5));
    expect(made.line).toBe(10);
    expect(statementsOf(made.text).filter((s) => s.word === 'if').length).toBe(2);
  });
  it('move a statement into a block and out of it', () => {
    const up = moveStatement(text, at(11), -1)!;
    expect(up.text.split('\n').slice(8, 11)).toEqual(['  end', '  movej Home', 'end']);
    const out = moveStatement(up.text, at(up.line, up.text), 1)!;
    expect(out.text).toBe(text);
  });
  it('move a block with all in it', () => {
    const up = moveStatement(text, at(5), -1)!;
    expect(up.line).toBe(4);
    expect(up.text.split('\n')[8]).toBe('  movel Pick, speed 50%   # down');
    expect(moveStatement(up.text, at(4, up.text), 1)!.text).toBe(text);
  });
  it('have nowhere to go at the ends', () => {
    expect(moveStatement(text, at(1), -1)).toBeNull();
    expect(moveStatement(text, at(11), 1)).toBeNull();
  });
  it('find a free name', () => expect(freeName('P', ['p1', 'P2', 'Home'])).toBe('P3'));
});
