/** Which requests the cell knows: what it cannot do is not offered. */
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

/** True where nobody knows yet. */
export const able = (request: string): boolean => known.value === null || known.value.size === 0 || known.value.has(request);
