/** Compares two texts by lines. */
import { Change, diff as compare } from '@codemirror/merge';

export interface Hunk {
  same: boolean;
  a: string[];
  b: string[];
  /** First line of each side, counted from 1. */
  aLine: number;
  bLine: number;
}

/**
 * The smallest set of changed lines, from CodeMirror's diff; an approximate set if the texts are very
 * different.
 */
export function diff(a: string, b: string): Hunk[] {
  const x = a.split('\n');
  const y = b.split('\n');
  const out: Hunk[] = [];
  const add = (same: boolean, i: number, iEnd: number, j: number, jEnd: number) => {
    if (i < iEnd || j < jEnd) out.push({ same, a: x.slice(i, iEnd), b: y.slice(j, jEnd), aLine: i + 1, bLine: j + 1 });
  };
  let i = 0;
  let j = 0;
  for (const change of changedLines(x, y)) {
    add(true, i, change.fromA, j, change.fromB);
    add(false, change.fromA, change.toA, change.fromB, change.toB);
    i = change.toA;
    j = change.toB;
  }
  add(true, i, x.length, j, y.length);
  return out;
}

const kMostDistinct = 0xd7ff; // number of characters before the surrogates

/**
 * CodeMirror's diff compares characters, so each distinct line becomes one character. Positions are line
 * numbers, from 0.
 */
function changedLines(x: string[], y: string[]): readonly Change[] {
  const known = new Map<string, string>();
  const character = (line: string) => {
    const found = known.get(line) ?? String.fromCharCode(known.size);
    known.set(line, found);
    return found;
  };
  const [one, other] = [x.map(character).join(''), y.map(character).join('')];
  if (known.size > kMostDistinct) return [new Change(0, x.length, 0, y.length)];
  return compare(one, other, { scanLimit: 5000, timeout: 500 });
}

/** The text that takes side `a` or `b` of each difference, in their order. */
export function merged(hunks: Hunk[], choice: ('a' | 'b')[]): string {
  let next = 0;
  return hunks.flatMap((hunk) => (hunk.same || choice[next++] === 'a' ? hunk.a : hunk.b)).join('\n');
}
