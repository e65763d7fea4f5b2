/**
 * Splits a program's text into statements: where each begins and ends, its depth, and which block it opens or
 * ends. No side effects.
 */

export interface Statement {
  /** First and last line, counted from 1. */
  line: number;
  endLine: number;
  depth: number;
  /** First word in lower case; '#' for a line that is only a comment. */
  word: string;
  /** The statement without its comment, with its lines joined by blanks. */
  text: string;
  comment: string;
  opens: boolean;
  /** For `else`, `elif`, `on error`: ends one part of a block and begins the next. */
  middle: boolean;
  closes: boolean;
  /** Last line of the block that it opens; `endLine` if it opens none. */
  blockEnd: number;
}

const kOpeners = new Set(['while', 'for', 'if', 'func', 'try', 'task', 'together', 'when', 'trap', 'every', 'lock', 'test']);
const kCloser = /^end[a-z]*$/;

/** The positions in the text outside of quotes and back-quotes. */
function* unquoted(text: string): Generator<number> {
  let quote = '';
  for (let i = 0; i < text.length; ++i) {
    const c = text[i]!;
    if (quote) {
      if (c === '\\' && quote === '"') ++i;
      else if (c === quote) quote = '';
    } else if (c === '"' || c === '`') quote = c;
    else yield i;
  }
}
const depth = (c: string) => ('([{'.includes(c) ? 1 : ')]}'.includes(c) ? -1 : 0);

/**
 * The part of a line before its comment, and the comment without the '#'. A '#' in quotes is not a comment.
 */
export function splitComment(line: string): [string, string] {
  for (const i of unquoted(line)) if (line[i] === '#') return [line.slice(0, i), line.slice(i + 1).trim()];
  return [line, ''];
}

/** The number of brackets that the text leaves open; ignores quoted texts. */
function openBrackets(text: string): number {
  let open = 0;
  for (const i of unquoted(text)) open += depth(text[i]!);
  return open;
}

export function firstWord(text: string): string {
  return (/^[A-Za-z_]\w*/.exec(text)?.[0] ?? '').toLowerCase();
}

function role(text: string, word: string): { opens: boolean; middle: boolean; closes: boolean } {
  const closes = kCloser.test(word);
  const middle = word === 'else' || word === 'elif' || (word === 'on' && /^on\s+error\b/i.test(text));
  const hanging = !middle && /\belse$/i.test(text);
  const opens = !closes && !middle && (kOpeners.has(word) || hanging || (word === 'on' && /^on\s+stop\b/i.test(text)));
  return { opens, middle, closes };
}

export function statementsOf(text: string): Statement[] {
  const lines = text.split('\n');
  const out: Statement[] = [];
  const open: Statement[] = [];
  for (let i = 0; i < lines.length; ++i) {
    const first = i;
    let [code, comment] = splitComment(lines[i]!);
    code = code.trim();
    while (code !== '' && i + 1 < lines.length && (openBrackets(code) > 0 || code.endsWith(','))) {
      const [next, more] = splitComment(lines[++i]!);
      code = `${code} ${next.trim()}`.trim();
      comment = [comment, more].filter(Boolean).join(' ');
    }
    if (code === '' && comment === '' && !lines[first]!.trim().startsWith('#')) continue;
    const word = code === '' ? '#' : firstWord(code);
    const what = role(code, word);
    if (what.closes) {
      const opener = open.pop();
      if (opener) opener.blockEnd = i + 1;
    }
    const depth = Math.max(0, open.length - (what.middle ? 1 : 0));
    const statement: Statement = {
      line: first + 1, endLine: i + 1, depth, word, text: code, comment, ...what, blockEnd: i + 1,
    };
    out.push(statement);
    if (what.opens) open.push(statement);
  }
  for (const opener of open) opener.blockEnd = lines.length;
  return out;
}

// --- parsing and writing moves

export const kMoveWords = ['moveto', 'movej', 'movel', 'movec'];
/** Statements with velocities instead of a target. They have the clauses of moves. */
export const kSpeedWords = ['speedj', 'speedl'];
export const kMotionWords = [...kMoveWords, ...kSpeedWords, 'drive', 'turn'];
export const kClauses = [
  'robot', 'tool', 'frame', 'payload', 'near', 'around', 'speed', 'accel', 'blend', 'duration', 'exact', 'smooth', 'touch', 'until', 'at',
];

export interface Clause {
  word: string;
  value: string;
}
export interface Move {
  word: string;
  via: string;
  target: string;
  clauses: Clause[];
}

/** The positions in the text outside of brackets and quotes. */
function* topLevel(text: string): Generator<number> {
  let open = 0;
  for (const i of unquoted(text)) {
    const more = depth(text[i]!);
    open += more;
    if (more === 0 && open === 0) yield i;
  }
}

/** Splits the text at commas outside of brackets. */
export function splitTop(text: string): string[] {
  const out: string[] = [];
  let from = 0;
  for (const i of topLevel(text))
    if (text[i] === ',') {
      out.push(text.slice(from, i).trim());
      from = i + 1;
    }
  out.push(text.slice(from).trim());
  return out;
}

export function parseMove(text: string, words: readonly string[] = kMoveWords): Move | null {
  const word = firstWord(text);
  if (!words.includes(word)) return null;
  const rest = text.slice(word.length).trim();
  const starts: { at: number; word: string }[] = [];
  for (const i of topLevel(rest)) {
    if (i === 0 || /[\w.]/.test(rest[i - 1]!)) continue;
    const found = firstWord(rest.slice(i));
    if (!kClauses.includes(found)) continue;
    const before = starts[starts.length - 1];
    if (before && /^(until|at)$/.test(before.word) && rest.slice(before.at, i).trim().toLowerCase() === before.word) continue;
    starts.push({ at: i, word: found });
  }
  const trim = (part: string) => part.trim().replace(/,$/, '').trim();
  const clauses = starts.map((start, k) => ({
    word: start.word,
    value: trim(rest.slice(start.at + start.word.length, starts[k + 1]?.at ?? rest.length)),
  }));
  const places = trim(rest.slice(0, starts[0]?.at ?? rest.length));
  if (word !== 'movec') return { word, via: '', target: places, clauses };
  const [via = '', ...end] = splitTop(places);
  return { word, via, target: end.join(', '), clauses };
}

export function writeMove(move: Move): string {
  const places = move.word === 'movec' ? `${move.via}, ${move.target}` : move.target;
  const clauses = move.clauses.map((c) => (c.value ? `${c.word} ${c.value}` : c.word));
  return `${move.word} ${[places, ...clauses].join(', ')}`;
}

/** The clause's value; null if the clause is missing, '' if it has no value. */
export function clauseOf(move: Move, word: string): string | null {
  return move.clauses.find((each) => each.word === word)?.value ?? null;
}
export function withClause(move: Move, word: string, value: string | null): Move {
  const others = move.clauses.filter((each) => each.word !== word);
  if (value === null) return { ...move, clauses: others };
  const at = move.clauses.findIndex((each) => each.word === word);
  const next = { word, value };
  if (at < 0) return { ...move, clauses: [...others.filter((c) => c.word !== 'until'), next, ...others.filter((c) => c.word === 'until')] };
  return { ...move, clauses: move.clauses.map((each, i) => (i === at ? next : each)) };
}
