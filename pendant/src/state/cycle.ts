/** Cycle times as the cell reports them, independent of what this page has missed. */
import { computed, effect, signal } from '@preact/signals';
import { status } from './cell';

/** Duration of the last complete pass, s; NaN before the first. */
export const lastCycle = computed(() => status.value?.program?.lastPass ?? NaN);
/** Mean of the last passes that this page has seen, s. */
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
