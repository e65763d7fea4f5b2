/**
 * What a person can do now. Bar, strip, Run, Program and Move draw their keys from this and from nothing
 * else. Pure.
 */
import type {Key} from '../i18n';
import type {Status, Why} from '../wire/types';

/**
 * '' where it can be done; else why not, for the text below the key: a text of the page, or what the cell
 * says.
 */
export type Blocked = ''|Key|Why;
export const canBe = (blocked: Blocked): boolean => blocked === '';

export type Next = 'pause'|'resume'|'recover'|'arm'|'activate';

export interface Ways {
  /** The one key at the right of the bar: what leads on from here. */
  next: Next;
  /** For that key. */
  nextBlocked: Blocked;
  /** Beside Activate: what is held may go on without the device. Null: it is not held. */
  resumesToo: Blocked|null;
  /**
   * Beside Resume: forget the rest of the motion, or what moved the robot meanwhile. Null: there is nothing
   * to forget.
   */
  discard: Blocked|null;
  /** Which of both discard is about. */
  discards: 'motion'|'push';
  back: Blocked;
  start: Blocked;
  step: Blocked;
  /** Into and out of calls: of a paused program alone. */
  stepInto: Blocked;
  end: Blocked;
  /** A program is under way: begun and not ended. Its keys are shown in place of Start. */
  going: boolean;
  /** Of each robot. */
  jog: (robot: string) => Blocked;
}

export interface Seen {
  status: Status|null;
  /** Connected, and this page has control. */
  mayMove: boolean;
  /** A pause or step was asked for and is not there yet. */
  pausing: boolean;
}

export function waysOf({status, mayMove, pausing}: Seen): Ways {
  const now = status;
  const state = now?.state ?? 'no cell';
  const program = now?.program ?? null;
  const going = !!program && !program.ended && !program.ready;
  const held = state === 'held';
  const unarmed = !!now && !now.simulated && !now.armed;
  const cannot = now?.cannot ?? {};
  const none: Blocked = !now ? 'why.offline' : state === 'no cell' ? 'why.noCell' : '';
  /** The first reason there is; who has no control cannot do it in any state. */
  const blocked = (...reasons: (Blocked|null|undefined|false)[]): Blocked =>
      none || (mayMove ? reasons.find((each): each is Blocked => !!each) || '' : 'why.control');

  const runs = state === 'running';
  const paused = going && program.paused;
  /** Something is there to be paused, whatever else is wanting. */
  const goesOn = runs && (now!.moving || (going && !paused));
  const wanting = (held || runs) && !goesOn;
  const next: Next = state === 'fault'    ? 'recover' :
      unarmed && (held || runs)           ? 'arm' :
      wanting && now!.inactive.length > 0 ? 'activate' :
      held || (runs && paused && !goesOn) ? 'resume' :
                                            'pause';
  const resume = blocked(held && cannot.resume);
  const nextBlocked: Blocked = next === 'pause' ? none || (state === 'stopping' ? 'why.stopping' : '') :
      next === 'resume'                         ? resume :
                                                  blocked();

  const pushed = cannot.resume?.code === 'moved-while-held';
  const forgets = held && !now!.moving && (now!.motionLeft || pushed);
  const statement = program && cannot.program;
  // A held program goes on with its step: what holds the cell is no reason against it, what hinders Resume
  // is.
  const against = held ? (cannot.resume ?? (unarmed && 'why.armFirst')) : statement;
  const step = blocked(!going && 'why.noProgram', pausing && 'state.pausing', against);
  return {
    next,
    nextBlocked,
    resumesToo: held && next === 'activate' ? resume : null,
    discard: forgets && next !== 'activate' ? blocked(cannot.discard) : null,
    discards: now?.motionLeft ? 'motion' : 'push',
    back: blocked(!held && 'why.resumeFirst', !now?.motionLeft && 'why.noMotion', cannot.back),
    start: blocked(
        cannot.program, unarmed && 'why.armFirst', state !== 'running' && 'why.resumeFirst',
        now?.moving && 'why.moving'),
    step,
    stepInto: step || (program?.paused ? '' : 'why.pauseFirst'),
    end: blocked(!going && 'why.noProgram'),
    going,
    jog: (robot) => blocked(now?.cannotJog[robot]),
  };
}
