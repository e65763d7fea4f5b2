import type { move as en } from '../en/move';

export const move: Record<keyof typeof en, string> = {};
