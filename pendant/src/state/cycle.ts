/** Cycle times as this page has seen them: the program tells its passes, the frames the cell's time. */
import { effect, signal } from '@preact/signals';
import { status } from './cell';
import { cellTime } from './live';

/** Of the last whole pass that was seen, s; NaN before. */
export const lastCycle = signal(NaN);
/** Mean of the last few, s. */
export const meanCycle = signal(NaN);

const kKept = 20;
let file = '';
let passes = -1;
let began = NaN;
let times: number[] = [];

effect(() => {
  const program = status.value?.program;
  if (!program || program.ended) return;
  const now = cellTime.peek();
  if (program.file !== file || program.passes < passes) {
    [file, passes, began, times] = [program.file, program.passes, NaN, []];
    lastCycle.value = meanCycle.value = NaN;
    return;
  }
  if (program.passes === passes) return;
  if (Number.isFinite(began) && program.passes === passes + 1) {
    times = [...times, now - began].slice(-kKept);
    lastCycle.value = now - began;
    meanCycle.value = times.reduce((sum, each) => sum + each, 0) / times.length;
  }
  passes = program.passes;
  began = now;
});
