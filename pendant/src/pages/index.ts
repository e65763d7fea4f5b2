/** The pages, in their order. A page is loaded when it is first opened. */
import type { ComponentType } from 'preact';
import type { Key } from '../i18n';
import type { IconName } from '../ui/Icon';

export interface Page {
  id: string;
  label: Key;
  icon: IconName;
  load: () => Promise<{ default: ComponentType }>;
}

export const pages: Page[] = [
  { id: 'run', label: 'nav.run', icon: 'run', load: () => import('./run') },
  { id: 'move', label: 'nav.move', icon: 'move', load: () => import('./move') },
  { id: 'program', label: 'nav.program', icon: 'program', load: () => import('./program') },
  { id: 'points', label: 'nav.points', icon: 'points', load: () => import('./points') },
  { id: 'signals', label: 'nav.signals', icon: 'signals', load: () => import('./signals') },
  { id: 'plots', label: 'nav.plots', icon: 'plots', load: () => import('./plots') },
  { id: 'health', label: 'nav.health', icon: 'health', load: () => import('./health') },
  { id: 'cell', label: 'nav.cell', icon: 'cell', load: () => import('./cell') },
];
