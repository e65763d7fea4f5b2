/** Finds the loop whose passes are counted. No side effects. */
export interface Loop {
  line: number;
  source: string;
}

/** The first `while` with a condition in a program's text; null for a text without one. */
export function outermostLoop(text: string): Loop | null {
  const lines = text.split('\n');
  for (const [i, each] of lines.entries()) {
    const found = /^\s*(while\s+[^#]*[^#\s])\s*(#.*)?$/.exec(each);
    if (found) return { line: i + 1, source: found[1]! };
  }
  return null;
}
