/** Changes of a program's text by whole statements. Pure: text in, text out. */
import { type Statement, statementsOf } from './statements';

export interface Edited {
  text: string;
  /** Line of the statement that was put or moved there. */
  line: number;
}

const kIndent = '  ';
const blanks = (line: string) => /^\s*/.exec(line)![0];
const lastOf = (s: Statement) => (s.opens ? s.blockEnd : s.endLine);

/** Lines `from` to `to` moved sideways so that the first begins with `indent`. */
function indented(lines: string[], indent: string): string[] {
  const own = blanks(lines[0] ?? '');
  return lines.map((line) => {
    if (line.trim() === '') return line;
    return line.startsWith(own) ? indent + line.slice(own.length) : indent + line.trimStart();
  });
}

/** How a statement is indented that comes behind `before` (null: at the top), inside of what that opens. */
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

/** Puts `now` (one or more lines) behind `after`; inside of it where it opens a block. Null: at the top. */
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

/** Behind the comments that a program begins with. */
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

/** Takes the statement away, with the block that it opens; with `keepInside` only its own lines and its end. */
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

/** Copies the statement, with its block, behind itself. */
export function copyStatement(text: string, statement: Statement): Edited {
  const lines = text.split('\n');
  const last = lastOf(statement);
  lines.splice(last, 0, ...lines.slice(statement.line - 1, last));
  return { text: lines.join('\n'), line: last + 1 };
}

/**
 * One place up (-1) or down (1), with its block: in front of the statement above, or behind the one below. So it goes
 * into a block at its begin or end, and out of it. Null where there is no further place.
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

/** Indents the moved lines as their new place asks. */
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

/** Are both in one block: does none that is less deep stand between them? */
function sameBlock(all: Statement[], a: Statement, b: Statement): boolean {
  const [first, second] = a.line < b.line ? [a, b] : [b, a];
  return all.every((each) => each.line <= first.line || each.line >= second.line || each.depth >= a.depth);
}

/** The next name of that kind that nobody has: P1, P2 … */
export function freeName(stem: string, taken: Iterable<string>): string {
  const names = new Set([...taken].map((name) => name.toLowerCase()));
  for (let i = 1; ; ++i) if (!names.has(`${stem}${i}`.toLowerCase())) return `${stem}${i}`;
}
