/** The log of the page, put together from the lines that the cell sends. */
import type { LogLine } from '../wire/types';

const kMost = 2000;
const isSame = (a: LogLine, b: LogLine) => a.time === b.time && a.text === b.text;

/**
 * The known lines and the new ones. After a reconnection the cell sends its history again; another process or
 * a new cell numbers its lines from the beginning, and then the known lines are dropped.
 */
export function withLines(known: LogLine[], lines: LogLine[]): LogLine[] {
  const first = lines[0], last = known[known.length - 1];
  if (!first) return known;
  if (!last || first.number > last.number) return [...known, ...lines].slice(-kMost);
  const before = known.find((each) => each.number === first.number);
  if (!before || !isSame(before, first)) return lines.slice(-kMost);
  return [...known, ...lines.filter((each) => each.number > last.number)].slice(-kMost);
}
