/** Finds the loop whose passes are counted. No side effects. */
import { statementsOf } from '../program/statements';

export interface Loop {
  line: number;
  source: string;
}

/**
 * The first `while` outside of functions; null for a text without one. Also null if something else can end it in
 * its first pass, so that its condition need not be the reason.
 */
export function outermostLoop(text: string): Loop | null {
  const all = statementsOf(text);
  const functions = all.filter((each) => each.word === 'func');
  const loop = all.find((each) => each.word === 'while' && !functions.some((func) => each.line > func.line && each.line <= func.blockEnd));
  if (!loop || !/^while\s+\S/i.test(loop.text) || /^while\s+true$/i.test(loop.text)) return null;
  const leaves = all.some((each) => ['break', 'stop', 'return'].includes(each.word) && each.line > loop.line && each.line <= loop.blockEnd);
  return leaves ? null : { line: loop.line, source: loop.text };
}
