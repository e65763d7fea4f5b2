/** The requests that the cell supports. The page does not offer anything else. */
import { effect, signal } from '@preact/signals';
import { connected, fetchJson } from './cell';

const known = signal<ReadonlySet<string> | null>(null);

effect(() => {
  if (!connected.value || known.peek()) return;
  fetchJson<{ request?: string; name?: string }[]>('/api/requests').then(
    (table) => (known.value = new Set(table.map((each) => each.request ?? each.name ?? ''))),
    () => undefined,
  );
});

/** True if the request is supported, or if the list is not known yet. */
export const able = (request: string): boolean => known.value === null || known.value.size === 0 || known.value.has(request);
