/** Pure: the loop whose passes are counted. */
export interface Loop {
  line: number;
  source: string;
}

/** The first `while` of a program's text that has a condition; null without one. */
export function outermostLoop(text: string): Loop | null {
  const lines = text.split('\n');
  for (const [i, each] of lines.entries()) {
    const found = /^\s*(while\s+[^#]*[^#\s])\s*(#.*)?$/.exec(each);
    if (found) return { line: i + 1, source: found[1]! };
  }
  return null;
}
