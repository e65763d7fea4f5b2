import type { en } from '../en';
import { cell } from './cell';
import { calibrate } from './calibrate';
import {codes} from './codes';
import { device } from './device';
import { health } from './health';
import { move } from './move';
import { program } from './program';
import { plots } from './plots';
import { points } from './points';
import { signals } from './signals';
import { run } from './run';
import { shell } from './shell';
import { told } from './told';
import { view } from './view';

export const es: Record<keyof typeof en, string> = {
  ...shell,
  ...run,
  ...move,
  ...view,
  ...program,
  ...points,
  ...calibrate,
  ...signals,
  ...plots,
  ...health,
  ...cell,
  ...told,
  ...device,
  ...codes
};
