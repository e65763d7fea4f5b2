/** Values of the robot that the pages show: each robot of each cell has its own. */
import { signal } from '@preact/signals';
import { cell, robot } from '../../state/cell';

/** Another model under the same name is another robot. */
const whose = () => JSON.stringify([cell.value?.folder, robot.value?.name, robot.value?.id]);

/** To be used as a signal. */
export function ofRobot<T>(first: T): { value: T } {
  const all = signal<Record<string, T>>({});
  return {
    get value() {
      return all.value[whose()] ?? first;
    },
    set value(now: T) {
      all.value = { ...all.peek(), [whose()]: now };
    },
  };
}
