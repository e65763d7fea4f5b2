/**
 * The actions that are possible now. Bar, strip, Run, Program and Move draw their keys only from this. No
 * side effects.
 */
import type {Key} from '../i18n';
import type {Status, Why} from '../wire/types';

/**
 * '' if the action is possible; else the reason, for the text below the key: a text of the page, or the
 * cell's reason.
 */
export type Blocked = ''|Key|Why;
export const canBe = (blocked: Blocked): boolean => blocked === '';

export type Next = 'pause'|'resume'|'recover'|'arm'|'activate';

export interface Ways {
  /** The main key at the right of the bar: the next step from the present state. */
  next: Next;
  /** The reason for that key. */
  nextBlocked: Blocked;
  /** Beside Activate: a held motion may continue without the device. Null: no motion is held. */
  resumesToo: Blocked|null;
  /**
   * Beside Resume: forget the rest of the motion, or accept a displacement of the robot. Null: there is
   * nothing to forget.
   */
  discard: Blocked|null;
  /** Which of the two `discard` applies to. */
  discards: 'motion'|'push';
  back: Blocked;
  start: Blocked;
  step: Blocked;
  /** Steps into and out of calls; only while the program is paused. */
  stepInto: Blocked;
  end: Blocked;
  /** A program is running: started and not ended. Its keys replace Start. */
  going: boolean;
  /** For each robot. */
  jog: (robot: string) => Blocked;
}

export interface Seen {
  status: Status|null;
  /** The page is connected and has control. */
  mayMove: boolean;
  /** A pause or step was requested and has not happened yet. */
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
  /** The first reason. Without control nothing is possible in any state. */
  const blocked = (...reasons: (Blocked|null|undefined|false)[]): Blocked =>
      none || (mayMove ? reasons.find((each): each is Blocked => !!each) || '' : 'why.control');

  const runs = state === 'running';
  const paused = going && program.paused;
  /** Something can be paused, whatever else is missing. */
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
  // A held program resumes with its step. So the cause of the hold does not block the step; what blocks
  // Resume does.
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
        held && next === 'activate' && 'why.activateFirst',  // Resume alone would not be enough
        cannot.program, unarmed && 'why.armFirst', state !== 'running' && 'why.resumeFirst', now?.moving && 'why.moving'),
    step,
    stepInto: step || (program?.paused ? '' : 'why.pauseFirst'),
    end: blocked(!going && 'why.noProgram'),
    going,
    jog: (robot) => blocked(now?.cannotJog[robot]),
  };
}
