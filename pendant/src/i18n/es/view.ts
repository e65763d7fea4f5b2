import type { view as en } from '../en/view';

export const view: Record<keyof typeof en, string> = {};
