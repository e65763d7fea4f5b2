/** The last minutes of every field, in a ring buffer of rows. No side effects. */

export interface Slice {
  times: number[];
  columns: (number | null)[][];
}

export class History {
  private names: string[] = [];
  private places = new Map<string, number>();
  private readonly times: Float64Array;
  private rows: Float32Array[] = [];
  private next = 0;
  private count = 0;

  /** `most`: number of rows that are kept. */
  constructor(private readonly most: number) {
    this.times = new Float64Array(most);
  }

  /** Changes the names. The history of removed names is dropped. */
  setNames(names: string[]): void {
    if (names.length === this.names.length && names.every((name, i) => name === this.names[i])) return;
    const before = this.places;
    const rows = this.rows;
    this.names = [...names];
    this.places = new Map(names.map((name, i) => [name, i]));
    this.rows = names.map((name) => rows[before.get(name) ?? -1] ?? new Float32Array(this.most).fill(NaN));
  }

  push(time: number, value: (name: string, place: number) => number): void {
    const last = this.count > 0 ? this.times[(this.next + this.most - 1) % this.most]! : -Infinity;
    if (time <= last) {
      if (time > last - 1) return;
      // The cell has restarted.
      this.clear();
    }
    this.times[this.next] = time;
    this.names.forEach((name, i) => (this.rows[i]![this.next] = value(name, i)));
    this.next = (this.next + 1) % this.most;
    this.count = Math.min(this.count + 1, this.most);
  }

  clear(): void {
    this.next = 0;
    this.count = 0;
    for (const row of this.rows) row.fill(NaN);
  }

  get newest(): number {
    return this.count > 0 ? this.times[(this.next + this.most - 1) % this.most]! : NaN;
  }
  get oldest(): number {
    return this.count > 0 ? this.times[(this.next + this.most - this.count) % this.most]! : NaN;
  }

  /**
   * The rows between two times, and one row beyond each end, so that lines reach the edge. Null where nothing
   * was measured.
   */
  slice(from: number, to: number, names: string[]): Slice {
    const places = names.map((name) => this.places.get(name) ?? -1);
    const times: number[] = [];
    const columns: (number | null)[][] = names.map(() => []);
    const first = Math.max(0, this.find(from) - 1);
    for (let i = first; i < this.count; ++i) {
      const at = this.place(i);
      const time = this.times[at]!;
      times.push(time);
      places.forEach((place, k) => {
        const value = place >= 0 ? this.rows[place]![at]! : NaN;
        columns[k]!.push(Number.isFinite(value) ? value : null);
      });
      if (time > to) break;
    }
    return { times, columns };
  }

  /**
   * The values at that time: from the last row that is not later, if it is at most `longest` s older. Null if
   * nothing was measured.
   */
  at(time: number, names: string[], longest = 0.5): (number | null)[] {
    const after = this.find(time);
    const exact = after < this.count && this.times[this.place(after)] === time;
    const row = exact ? after : after - 1;
    if (row < 0 || time - this.times[this.place(row)]! > longest) return names.map(() => null);
    return names.map((name) => {
      const value = this.rows[this.places.get(name) ?? -1]?.[this.place(row)] ?? NaN;
      return Number.isFinite(value) ? value : null;
    });
  }

  /** The index of a row in the ring. */
  private place(row: number): number {
    return (this.next + this.most - this.count + row) % this.most;
  }

  /** The index of the first row that is not before `time`. */
  private find(time: number): number {
    let low = 0;
    let high = this.count;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.times[this.place(middle)]! < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }
}

const quoted = (text: string) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);

/** Comma-separated values, one column per name. A value that was not measured is empty. */
export function csv(slice: Slice, titles: string[]): string {
  const head = ['time [s]', ...titles].map(quoted).join(',');
  const rows = slice.times.map((time, i) => [time.toFixed(6), ...slice.columns.map((column) => column[i] ?? '')].join(','));
  return [head, ...rows, ''].join('\n');
}
