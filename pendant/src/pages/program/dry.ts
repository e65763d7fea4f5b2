/** The dry run: the server runs the program without a robot. Its problems by line, and its paths. */
import { signal } from '@preact/signals';
import { complain, stream } from '../../state/cell';
import { type DryPath, dryPaths, problemsIn3d } from '../../state/preview';
import { problemLine } from '../../i18n/told';
import type { Problem } from './documents';

export interface DryResult {
  problems: Problem[];
  moves: number;
  reached: { file: string; line: number } | null;
  seconds: number | null;
  paths: DryPath[];
}
export type DryState =
  | { kind: 'none' }
  | { kind: 'runs'; line: number; moves: number; stop: () => void }
  | { kind: 'done'; file: string; text: string; result: DryResult };

export const dry = signal<DryState>({ kind: 'none' });

export async function dryRun(file: string, text: string): Promise<void> {
  forgetDry();
  try {
    const asked = stream('program.dry', { name: file, text }, () => undefined);
    const stop = () => {
      asked.stop();
      dry.value = { kind: 'none' };
    };
    dry.value = { kind: 'runs', line: 0, moves: 0, stop };
    const result = (await asked.done) as unknown as DryResult;
    dry.value = { kind: 'done', file, text, result };
    dryPaths.value = result.paths ?? [];
    problemsIn3d.value = result.problems.map((each) => ({ line: each.line, text: problemLine(each), robot: '', at: endOf(result, each.line) }));
  } catch (error) {
    dry.value = { kind: 'none' };
    complain(error);
  }
}

/** The place of a problem in the picture: the end of the last possible move before the line. */
function endOf(result: DryResult, line: number) {
  const before = (result.paths ?? []).filter((path) => path.line <= line && path.points.length > 0);
  const last = before[before.length - 1];
  return last ? last.points[last.points.length - 1]! : null;
}

export function forgetDry(): void {
  const now = dry.peek();
  if (now.kind === 'runs') now.stop();
  dry.value = { kind: 'none' };
  dryPaths.value = [];
  problemsIn3d.value = [];
}
