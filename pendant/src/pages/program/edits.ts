/** Edits a program's text by whole statements. No side effects: text in, text out. */
import { type Statement, statementsOf } from './statements';

export interface Edited {
  text: string;
  /** Line of the statement that was inserted or moved. */
  line: number;
}

const kIndent = '  ';
const blanks = (line: string) => /^\s*/.exec(line)![0];
const lastOf = (s: Statement) => (s.opens ? s.blockEnd : s.endLine);

/** Indents the lines so that the first one begins with `indent`. */
function indented(lines: string[], indent: string): string[] {
  const own = blanks(lines[0] ?? '');
  return lines.map((line) => {
    if (line.trim() === '') return line;
    return line.startsWith(own) ? indent + line.slice(own.length) : indent + line.trimStart();
  });
}

/**
 * The indentation of a statement after `before` (null: at the top), or inside the block that `before` opens.
 */
function indentBehind(lines: string[], before: Statement | null, inside: boolean): string {
  if (!before) return '';
  const own = blanks(lines[before.line - 1] ?? '');
  return inside ? own + kIndent : own;
}

export function replaceStatement(text: string, statement: Statement, now: string): Edited {
  const lines = text.split('\n');
  const indent = blanks(lines[statement.line - 1] ?? '');
  const comment = statement.comment && statement.word !== '#' ? `  # ${statement.comment}` : '';
  const put = now.split('\n').map((line) => indent + line);
  put[put.length - 1] += comment;
  lines.splice(statement.line - 1, statement.endLine - statement.line + 1, ...put);
  return { text: lines.join('\n'), line: statement.line };
}

/** Inserts `now` (one or more lines) after `after`, or inside it if it opens a block. Null: at the top. */
export function insertAfter(text: string, after: Statement | null, now: string): Edited {
  const lines = text.split('\n');
  const inside = after !== null && (after.opens || after.middle);
  const indent = indentBehind(lines, after, inside);
  const put = now.split('\n').map((line) => indent + line);
  const at = after ? after.endLine : firstPlace(lines);
  if (text.trim() === '') return { text: `${put.join('\n')}\n`, line: 1 };
  lines.splice(at, 0, ...put);
  return { text: lines.join('\n'), line: at + 1 };
}

/** The first line after the comments at the beginning of a program. */
function firstPlace(lines: string[]): number {
  let at = 0;
  while (at < lines.length && lines[at]!.trim().startsWith('#')) ++at;
  return at;
}

export function appendStatement(text: string, now: string): Edited {
  const body = text.replace(/\n+$/, '');
  const before = body === '' ? [] : body.split('\n');
  return { text: `${[...before, ...now.split('\n')].join('\n')}\n`, line: before.length + 1 };
}

/** Removes the statement with its block; with `keepInside` only the statement and the end of its block. */
export function removeStatement(text: string, statement: Statement, keepInside = false): string {
  const lines = text.split('\n');
  if (!statement.opens || !keepInside) {
    lines.splice(statement.line - 1, lastOf(statement) - statement.line + 1);
    return lines.join('\n');
  }
  const inner = statementsOf(text).filter((s) => s.line > statement.line && s.endLine <= statement.blockEnd);
  const gone = new Set<number>();
  const own = (s: Statement) => {
    for (let line = s.line; line <= s.endLine; ++line) gone.add(line);
  };
  own(statement);
  for (const each of inner) if ((each.closes || each.middle) && each.depth === statement.depth) own(each);
  return lines
    .map((line, i) => (i + 1 > statement.line && i + 1 < statement.blockEnd && line.startsWith(kIndent) ? line.slice(2) : line))
    .filter((_, i) => !gone.has(i + 1))
    .join('\n');
}

/** Inserts a copy of the statement, with its block, after it. */
export function copyStatement(text: string, statement: Statement): Edited {
  const lines = text.split('\n');
  const last = lastOf(statement);
  lines.splice(last, 0, ...lines.slice(statement.line - 1, last));
  return { text: lines.join('\n'), line: last + 1 };
}

/**
 * Moves the statement with its block by one place: up (-1) in front of the statement above, or down (1) after
 * the statement below. So it can enter a block at its beginning or end, and leave it. Null if it cannot move
 * further.
 */
export function moveStatement(text: string, statement: Statement, by: -1 | 1): Edited | null {
  const lines = text.split('\n');
  const all = statementsOf(text);
  const at = all.findIndex((each) => each.line === statement.line);
  if (at < 0) return null;
  const last = lastOf(statement);
  const other = by < 0 ? all[at - 1] : all.find((each) => each.line > last);
  if (!other) return null;
  const mine = lines.slice(statement.line - 1, last);
  const theirs = lines.slice(other.line - 1, other.endLine);
  if (by < 0) {
    const gap = lines.slice(other.endLine, statement.line - 1);
    lines.splice(other.line - 1, last - other.line + 1, ...mine, ...theirs, ...gap);
    return settle(lines, other.line, mine.length);
  }
  const gap = lines.slice(last, other.line - 1);
  lines.splice(statement.line - 1, other.endLine - statement.line + 1, ...gap, ...theirs, ...mine);
  return settle(lines, statement.line + gap.length + theirs.length, mine.length);
}

/** Indents the moved lines for their new place. */
function settle(lines: string[], line: number, count: number): Edited {
  const all = statementsOf(lines.join('\n'));
  const own = all.find((each) => each.line === line)!;
  const sibling = all.find((each) => each.depth === own.depth && each.line !== line && !each.closes && !each.middle &&
    sameBlock(all, own, each) && (each.line < line || each.line >= line + count));
  const parent = [...all].reverse().find((each) => each.line < line && each.depth < own.depth && (each.opens || each.middle));
  const indent = sibling ? blanks(lines[sibling.line - 1]!) : parent ? blanks(lines[parent.line - 1]!) + kIndent : '';
  lines.splice(line - 1, count, ...indented(lines.slice(line - 1, line - 1 + count), indent));
  return { text: lines.join('\n'), line };
}

/** True if both are in the same block, with no less deep statement between them. */
function sameBlock(all: Statement[], a: Statement, b: Statement): boolean {
  const [first, second] = a.line < b.line ? [a, b] : [b, a];
  return all.every((each) => each.line <= first.line || each.line >= second.line || each.depth >= a.depth);
}

/** The first unused name with this stem: P1, P2 … */
export function freeName(stem: string, taken: Iterable<string>): string {
  const names = new Set([...taken].map((name) => name.toLowerCase()));
  for (let i = 1; ; ++i) if (!names.has(`${stem}${i}`.toLowerCase())) return `${stem}${i}`;
}
