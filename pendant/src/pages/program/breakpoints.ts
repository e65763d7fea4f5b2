/**
 * Breakpoints of the open file. They move with their lines during editing, and the page reports their lines
 * to the cell.
 */
import { diff } from './diff';

/** Maps a line of the old text to the new text; 0: the line was removed. */
export type LineMap = (line: number) => number;

export interface BreakpointOptions {
  /**
   * Sends the present text and its breakpoints; without lines the cell finds them. Resolves with the lines.
   */
  tell: (name: string, text: string, lines?: number[]) => Promise<number[]>;
  toggle: (name: string, text: string, line: number, on: boolean) => Promise<number[]>;
  onLines: (lines: number[]) => void;
  /** ms after the last change. */
  wait?: number;
}

/**
 * Maps lines by what both texts have in common. A line that was moved is found again; a rewritten line is the
 * line in its place.
 */
export function lineMap(before: string, after: string): LineMap {
  const hunks = diff(before, after);
  const numbered = (lines: string[], from: number) => lines.map((text, i) => ({ text: text.trim(), line: from + i })).filter((each) => each.text !== '');
  const changed = hunks.filter((each) => !each.same);
  const free = changed.flatMap((each) => numbered(each.b, each.bLine));
  const moved = new Map<number, number>();
  for (const each of changed.flatMap((hunk) => numbered(hunk.a, hunk.aLine))) {
    const [found] = free.filter((one) => one.text === each.text).sort((a, b) => Math.abs(a.line - each.line) - Math.abs(b.line - each.line));
    if (!found) continue;
    moved.set(each.line, found.line);
    free.splice(free.indexOf(found), 1);
  }
  return (line) => {
    const hunk = hunks.find((each) => line >= each.aLine && line < each.aLine + each.a.length);
    if (!hunk) return 0;
    return moved.get(line) ?? (hunk.same || hunk.a.length === hunk.b.length ? hunk.bLine + line - hunk.aLine : 0);
  };
}

export class BreakpointKeeper {
  private name = '';
  private text = '';
  private lines: number[] = [];
  /** The lines that the cell reported last; null: none yet. */
  private told: number[] | null = null;
  private greeted = false;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private asking = 0;
  private opened = 0;

  constructor(private readonly options: BreakpointOptions) {}

  open(name: string, text: string, told: number[] | null): void {
    clearTimeout(this.timer);
    this.timer = undefined;
    ++this.opened;
    this.name = name;
    this.text = text;
    this.asking = 0;
    this.greeted = false;
    this.take(told ?? []);
    this.heard(told);
  }

  /**
   * Takes the breakpoints that the cell reports for this file. They may refer to another version of the text,
   * so the first time the page sends its own text.
   */
  heard(told: number[] | null): void {
    this.told = told;
    if (!told) this.greeted = false;
    if (!told || this.name === '') return;
    if (!this.greeted) {
      this.greeted = true;
      if (told.length > 0 && this.timer === undefined) return void this.ask(() => this.options.tell(this.name, this.text));
    }
    this.settle();
  }

  edited(text: string, map: LineMap = lineMap(this.text, text)): void {
    if (text === this.text) return;
    this.text = text;
    if (this.lines.length === 0 && !this.told?.length) return;
    this.take(this.lines.map(map).filter((line) => line > 0));
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      this.timer = undefined;
      void this.ask(() => this.options.tell(this.name, this.text, this.lines));
    }, this.options.wait ?? 300);
  }

  /** Sends the present text and lines again, when the page may. */
  retell(): void {
    if (this.name !== '' && this.timer === undefined) void this.ask(() => this.options.tell(this.name, this.text, this.lines));
  }

  async toggle(line: number): Promise<void> {
    const on = !this.lines.includes(line);
    this.take(on ? [...this.lines, line] : this.lines.filter((each) => each !== line));
    await this.ask(() => this.options.toggle(this.name, this.text, line, on));
  }

  private async ask(what: () => Promise<number[]>): Promise<void> {
    const opened = this.opened;
    ++this.asking;
    const answer = await what().catch(() => null);
    if (opened !== this.opened) return;
    --this.asking;
    if (answer) this.told = answer;
    this.settle();
  }

  /** If no request of this page is pending, the cell's breakpoints count. */
  private settle(): void {
    if (this.told && this.asking === 0 && this.timer === undefined) this.take(this.told);
  }

  private take(lines: number[]): void {
    this.lines = [...new Set(lines)].sort((a, b) => a - b);
    this.options.onLines(this.lines);
  }
}
