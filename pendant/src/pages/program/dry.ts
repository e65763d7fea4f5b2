/** The dry run: the server runs the program without a robot. Its problems by line, and its paths. */
import { signal } from '@preact/signals';
import { complain, stream } from '../../state/cell';
import { type DryPath, dryPaths, problemsIn3d } from '../../state/preview';
import type { Key } from '../../i18n';
import { ownWords, problemLine } from '../../i18n/told';
import type { RehearsedContacts } from '../../wire/requests';
import type { Problem } from './documents';

export interface DryResult {
  problems: Problem[];
  moves: number;
  reached: { file: string; line: number } | null;
  seconds: number | null;
  paths: DryPath[];
  /** Whether contacts were looked for, and how far. */
  contacts?: RehearsedContacts;
}

export interface DryWords {
  title: Key;
  /** Seconds up to which contacts were looked for; null: to the end. */
  until: number | null;
  /** Why nothing looked for contacts; '' if something did. */
  unchecked: string;
}

/** What a dry run has found. It is not called good where nothing looked for contacts. */
export function dryWords({ problems, moves, contacts }: Pick<DryResult, 'problems' | 'moves' | 'contacts'>): DryWords {
  const errors = problems.filter((each) => each.severity === 'error');
  const has = (code: string) => errors.some((each) => each.code === code);
  const blind = contacts?.checked === false;
  const title: Key =
    errors.length === 0
      ? blind ? 'program.dryBlind' : 'program.dryGood'
      : has('contact') ? 'program.dryContact' : has('guard') ? 'program.dryNear' : moves === 0 ? 'program.dryNothing' : 'program.dryBad';
  return {
    title,
    until: contacts?.checked && !contacts.whole ? contacts.seconds : null,
    unchecked: blind ? contacts!.unchecked.map(ownWords).filter(Boolean).join(' · ') : '',
  };
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
