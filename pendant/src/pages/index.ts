/** The pages, in their order. Each page is loaded when it is first opened. */
import type { ComponentType } from 'preact';
import type { Key } from '../i18n';
import type { IconName } from '../ui/Icon';

export interface Page {
  id: string;
  label: Key;
  icon: IconName;
  load: () => Promise<{ default: ComponentType }>;
  /** The page of the documentation about this page, below /help/. */
  help: string;
}

export const pages: Page[] = [
  { id: 'run', label: 'nav.run', icon: 'run', load: () => import('./run'), help: 'pendant.html#what-is-where' },
  { id: 'move', label: 'nav.move', icon: 'move', load: () => import('./move'), help: 'pendant.html#moving-by-hand' },
  { id: 'program', label: 'nav.program', icon: 'program', load: () => import('./program'), help: 'language.html' },
  { id: 'points', label: 'nav.points', icon: 'points', load: () => import('./points'), help: 'pendant.html#points-and-programs' },
  { id: 'signals', label: 'nav.signals', icon: 'signals', load: () => import('./signals'), help: 'links.html' },
  { id: 'plots', label: 'nav.plots', icon: 'plots', load: () => import('./plots'), help: 'recording.html' },
  { id: 'health', label: 'nav.health', icon: 'health', load: () => import('./health'), help: 'when-it-does-not-work.html' },
  { id: 'cell', label: 'nav.cell', icon: 'cell', load: () => import('./cell'), help: 'pendant.html#projects' },
];
