/**
 * True while the control loop of the cell stands still: the cell answers, but its time does not go on, for example because a
 * plugin does not return. No command reaches the robot then, and no stop takes effect.
 */
import { effect, signal } from '@preact/signals';
import { log, status } from './cell';
import { onFrame } from './live';

export const loopStands = signal(false);

const kLookMs = 500;
const kStandsMs = 1500;
/** Two in a row: the timer of a busy page comes before the frames that wait for it. */
const kLooks = 2;

let time = NaN;
let advancedAt = Infinity;
let looks = 0;

/** Until the time goes on for the first time, the loop of a new cell has not begun. */
function forget(): void {
  time = NaN;
  advancedAt = Infinity;
  looks = 0;
  loopStands.value = false;
}

onFrame((frame) => {
  if (frame.time === time) return;
  if (!Number.isNaN(time)) advancedAt = performance.now();
  time = frame.time;
  looks = 0;
  if (loopStands.peek()) loopStands.value = false;
});
setInterval(() => {
  looks = performance.now() - advancedAt > kStandsMs ? looks + 1 : 0;
  if (looks >= kLooks) loopStands.value = true;
}, kLookMs);
effect(() => {
  if (!status.value || status.value.state === 'no cell') forget();
});

/** What the loop waits for, as the cell has named it last; '' if it named nothing. */
export function waitsFor(): string {
  for (let i = log.value.length - 1; i >= 0; --i) {
    const line = log.value[i]!.text;
    if (!line.includes('the control loop does not run')) continue;
    return / waits for the (?:hardware component|controller) (.+?)(?:; |$)/.exec(line)?.[1] ?? '';
  }
  return '';
}
