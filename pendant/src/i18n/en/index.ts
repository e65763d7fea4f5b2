import {cell} from './cell';
import {calibrate} from './calibrate';
import {codes} from './codes';
import {device} from './device';
import {health} from './health';
import {move} from './move';
import {plots} from './plots';
import {points} from './points';
import {program} from './program';
import {run} from './run';
import {shell} from './shell';
import {signals} from './signals';
import {told} from './told';
import {view} from './view';

export const en = {
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
