/** Keys that work on every page. Escape stops if anything is running, before any other handler sees it. */
import {pages} from '../pages';
import {pauseOrGoOn, somethingGoesOn, stop} from '../state/actions';

import {go} from './route';

export function startKeys(): void {
  addEventListener('keydown', take, { capture: true });
}

function take(event: KeyboardEvent): void {
  if (event.key === 'Escape') {
    if (!somethingGoesOn()) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (!event.repeat) void stop();
    return;
  }
  if (event.key === 'F8' && !event.repeat) {
    event.preventDefault();
    pauseOrGoOn();
    return;
  }
  const page = event.altKey && !event.ctrlKey && !event.metaKey ? /^Digit([1-8])$/.exec(event.code) : null;
  if (page) {
    event.preventDefault();
    go(pages[Number(page[1]) - 1]!.id);
  }
}
