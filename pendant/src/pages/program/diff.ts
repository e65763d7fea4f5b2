/** Two texts by lines: what both have, and where they differ. */

export interface Hunk {
  same: boolean;
  a: string[];
  b: string[];
  /** First line of each side, from 1. */
  aLine: number;
  bLine: number;
}

const kMostCells = 4_000_000;

/** The longest common run of lines decides; of very long texts only their common begin and end. */
export function diff(a: string, b: string): Hunk[] {
  const x = a.split('\n');
  const y = b.split('\n');
  let head = 0;
  while (head < x.length && head < y.length && x[head] === y[head]) ++head;
  let tail = 0;
  while (tail < x.length - head && tail < y.length - head && x[x.length - 1 - tail] === y[y.length - 1 - tail]) ++tail;
  const out: Hunk[] = [];
  const add = (same: boolean, i: number, iEnd: number, j: number, jEnd: number) => {
    if (i === iEnd && j === jEnd) return;
    const last = out[out.length - 1];
    if (last && last.same === same) {
      last.a.push(...x.slice(i, iEnd));
      last.b.push(...y.slice(j, jEnd));
    } else out.push({ same, a: x.slice(i, iEnd), b: y.slice(j, jEnd), aLine: i + 1, bLine: j + 1 });
  };
  add(true, 0, head, 0, head);
  middle(x.slice(head, x.length - tail), y.slice(head, y.length - tail), (same, i, iEnd, j, jEnd) =>
    add(same, head + i, head + iEnd, head + j, head + jEnd),
  );
  add(true, x.length - tail, x.length, y.length - tail, y.length);
  return out;
}

function middle(x: string[], y: string[], add: (same: boolean, i: number, iEnd: number, j: number, jEnd: number) => void): void {
  const n = x.length;
  const m = y.length;
  if (n === 0 || m === 0 || n * m > kMostCells) return add(false, 0, n, 0, m);
  const width = m + 1;
  const common = new Uint32Array((n + 1) * width);
  for (let i = n - 1; i >= 0; --i)
    for (let j = m - 1; j >= 0; --j)
      common[i * width + j] =
        x[i] === y[j]
          ? common[(i + 1) * width + j + 1]! + 1
          : Math.max(common[(i + 1) * width + j]!, common[i * width + j + 1]!);
  let i = 0;
  let j = 0;
  while (i < n || j < m) {
    if (i < n && j < m && x[i] === y[j]) {
      add(true, i, i + 1, j, j + 1);
      ++i;
      ++j;
    } else if (j === m || (i < n && common[(i + 1) * width + j]! >= common[i * width + j + 1]!)) {
      add(false, i, i + 1, j, j);
      ++i;
    } else {
      add(false, i, i, j, j + 1);
      ++j;
    }
  }
}

/** The text that takes side `a` or `b` of each hunk that differs, in their order. */
export function merged(hunks: Hunk[], choice: ('a' | 'b')[]): string {
  let next = 0;
  return hunks.flatMap((hunk) => (hunk.same || choice[next++] === 'a' ? hunk.a : hunk.b)).join('\n');
}
