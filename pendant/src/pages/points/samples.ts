/** Values of the robot that the pages show: each robot of each cell has its own. */
import { signal } from '@preact/signals';
import { cell, robot } from '../../state/cell';

/** Another model under the same name is another robot. */
const whose = () => JSON.stringify([cell.value?.folder, robot.value?.name, robot.value?.id]);

/**
 * To be used as a signal: the value of the robot that the page shows. `mine()` stays with the robot shown at the call; what
 * waits for an answer of the cell uses it, because the page may show another robot meanwhile.
 */
export function ofRobot<T>(first: T): { value: T; mine: () => { value: T } } {
  const all = signal<Record<string, T>>({});
  const of = (key: () => string) => ({
    get value() {
      return all.value[key()] ?? first;
    },
    set value(now: T) {
      all.value = { ...all.peek(), [key()]: now };
    },
  });
  const mine = () => {
    const key = whose();
    return of(() => key);
  };
  return Object.assign(of(whose), { mine });
}
