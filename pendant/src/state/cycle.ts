/** Cycle times as the cell tells them, whatever this page has slept through. */
import { computed, effect, signal } from '@preact/signals';
import { status } from './cell';

/** Of the newest whole pass, s; NaN before. */
export const lastCycle = computed(() => status.value?.program?.lastPass ?? NaN);
/** Mean of the last few that this page has seen, s. */
export const meanCycle = signal(NaN);

const kKept = 20;
let file = '';
let passes = -1;
let times: number[] = [];

effect(() => {
  const program = status.value?.program;
  if (!program || program.ended) return;
  if (program.file !== file || program.passes < passes) times = [];
  else if (program.passes === passes) return;
  [file, passes] = [program.file, program.passes];
  if (Number.isFinite(program.lastPass)) times = [...times, program.lastPass].slice(-kKept);
  meanCycle.value = times.length ? times.reduce((sum, each) => sum + each, 0) / times.length : NaN;
});
