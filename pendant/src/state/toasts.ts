import { signal } from '@preact/signals';

export interface Toast {
  id: number;
  kind: 'ok' | 'info' | 'warning' | 'error';
  text: string;
  detail?: string;
}

export const toasts = signal<Toast[]>([]);
const kMost = 4;
const kShownMs = { ok: 3500, info: 5000, warning: 7000, error: 12_000 };
let next = 1;

/** Shows a message for some seconds. An identical message is not shown twice. */
export function toast(what: Omit<Toast, 'id'>): void {
  const same = toasts.value.find((each) => each.text === what.text && each.kind === what.kind);
  const id = same?.id ?? next++;
  if (!same) toasts.value = [...toasts.value, { ...what, id }].slice(-kMost);
  setTimeout(() => dismiss(id), kShownMs[what.kind]);
}

export function dismiss(id: number): void {
  toasts.value = toasts.value.filter((each) => each.id !== id);
}
