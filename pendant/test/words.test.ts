// What the page knows of the language, against the reference page, which a test of the parser compares with its own lists.
import { describe, expect, it, vi } from 'vitest';
import page from '../../docs/language-reference.md?raw';
import { knownWords } from '../src/pages/program/knownWords';
import { kClauses, kMotionWords, statementsOf } from '../src/pages/program/statements';

const section = (title: string) => new RegExp(`^## ${title}\\n([^]*?)(?=^## |$(?![^]))`, 'm').exec(page)?.[1] ?? '';
const bold = (title: string) => [...section(title).matchAll(/^\*\*(\w+)\*\* — `([^`]*)`/gm)].map((found) => ({ name: found[1]!, form: found[2]! }));
const names = (title: string) => bold(title).map((each) => each.name);
const known = (...roles: string[]) => knownWords.words.filter((each) => roles.includes(each.role)).map((each) => each.name);
const sorted = (list: string[]) => [...list].sort();

describe('the words that the page knows', () => {
  it('are those of the parser, each in its role', () => {
    expect(names('Statements').length).toBeGreaterThan(30);
    expect(sorted(known('statement'))).toEqual(sorted(names('Statements')));
    expect(sorted(known('branch'))).toEqual(sorted(names('Branches')));
    expect(sorted(known('clause'))).toEqual(sorted(names('Clauses of moves')));
    expect(sorted(known('reserved'))).toEqual(sorted(names('Reserved words')));
    const ends = [...section('Ends of blocks').matchAll(/`(\w+)`/g)].map((found) => found[1]!);
    expect(sorted(known('closer'))).toEqual(sorted([...new Set(ends)]));
  });
  it('are coloured as motions where they have clauses of moves', () => {
    const moving = bold('Statements').filter((each) => /\{clause\}/.test(each.form));
    expect(sorted(kMotionWords)).toEqual(sorted(moving.map((each) => each.name)));
  });
  it('have all functions', () => expect(sorted(knownWords.functions.map((each) => each.name))).toEqual(sorted(names('Functions'))));
  it('have all clauses of moves', () => expect(sorted(kClauses)).toEqual(sorted(names('Clauses of moves'))));
  it('open a block where their form ends one', () => {
    const opens = (line: string) => statementsOf(line)[0]!.opens;
    for (const { name, form } of bold('Statements').filter((each) => !/wait|meet|until/.test(each.name)))
      for (const each of form.split(/, (?=[a-z])/)) if (each.startsWith(name)) expect([each, opens(each.replace(/ ….*/, ''))]).toEqual([each, / end$/.test(each) || /^for /.test(each)]);
  });
  it('are said in words as steps', async () => {
    vi.stubGlobal('navigator', { language: 'en', userAgent: '' });
    const { kSaid, sentenceOf } = await import('../src/pages/program/sentence');
    const without = [...names('Statements'), ...names('Branches')].filter((each) => !kSaid.includes(each));
    expect(without).toEqual([]);
    const said = (line: string) => sentenceOf(statementsOf(line)[0]!);
    expect(said('speedl {z = -20mm/s}, duration 3s, until Contact')).toMatchObject({ text: 'Tool moves at {z = -20mm/s}', chips: ['duration 3s', 'until Contact'] });
    expect(said('speedj {elbow = 0.2rad/s}, duration 2s').text).toBe('Joints turn at {elbow = 0.2rad/s}');
  });
});
