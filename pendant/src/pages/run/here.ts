/** Where the tasks of a program are, for the text of one file. No side effects. */
import type { FileLine } from '../../wire/requests';
import type { ProgramStatus } from '../../wire/types';
import { sameFile } from '../program/sameFile';

/** A task as the event `program` sends it. */
export interface TaskPlace {
  state: string;
  where?: FileLine;
  /** The calls that led to the line, the outermost first. */
  calls?: FileLine[];
}

/** The line of `file` at which the task is, or from which it has called something in another file; 0: none. */
function lineIn(file: string, task: TaskPlace): number {
  const all = [...(task.calls ?? []), ...(task.where ? [task.where] : [])];
  return all.reverse().find((each) => sameFile(each.file, file))?.line ?? 0;
}

/** The lines of `file` at which a running program is. */
export function linesIn(file: string, program: ProgramStatus | null, tasks: readonly TaskPlace[]): number[] {
  if (!program || program.ended || program.ready) return [];
  const going = tasks.filter((each) => each.state === 'running' || each.state === 'waiting');
  // The status comes more often than the tasks, so it has the newest place of a single task.
  const now = { file: program.lineFile || program.file, line: program.line };
  if (going.length < 2 && sameFile(now.file, file)) return now.line > 0 ? [now.line] : [];
  return [...new Set(going.map((each) => lineIn(file, each)))].filter((line) => line > 0).sort((a, b) => a - b);
}
