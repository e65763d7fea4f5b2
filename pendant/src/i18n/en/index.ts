import { move } from './move';
import { run } from './run';
import { shell } from './shell';
import { view } from './view';

export const en = { ...shell, ...run, ...move, ...view };
