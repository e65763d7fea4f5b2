// What a person can do, in every state there can be: no dead end, never two keys that contradict each other.
import {describe, expect, it, vi} from 'vitest';

import {en} from '../src/i18n/en';
import {canBe, waysOf} from '../src/state/ways';
import {readStatus} from '../src/wire/read';

vi.stubGlobal('navigator', {language: 'en', userAgent: ''});
const {blockedWords} = await import('../src/shell/blocked');

const why = (code: string) => ({code, what: code, advice: ''});
/** As the server tells it, `cell::possible_now`: what can be follows from the state. */
function told({state, armed, real, program, inactive, touching, left, pushed, moving}: Combination) {
  const fault = state === 'fault' && why('fault');
  const stops = (state === 'stopping' || state === 'backing') && why('stopping');
  const jog = !armed ?
      why('disarmed') :
      fault || (state === 'stopping' && why('stopping')) || (inactive && why('not-active')) ||
          (state === 'running' && program === 'running' && why('program-runs')) ||
          (state === 'held' && left && why('motion-held')) || null;
  return readStatus(
      {
        state,
        standing: !moving,
        armed,
        simulated: !real,
        motion_left: left,
        inactive: inactive ? ['arm'] : [],
        contacts: {checked: true, touching, unchecked: [], list: []},
        program: program === 'none' ? null : {
          name: 'a.script',
          state: program === 'ready' ? 'ready' :
              program === 'ended'    ? 'finished' :
                                       'running',
          ended: program === 'ended',
          paused: program === 'paused'
        },
        can: {
          resume: fault || stops || (state === 'held' && touching && left && why('in-contact')) ||
              (state === 'held' && pushed && why('moved-while-held')) || null,
          discard: fault || stops || (state === 'running' && why('not-held')) || null,
          back: fault || stops || (state !== 'held' && why('wrong-state')) || null,
          recover: state === 'fault' ? null : why('no-fault'),
          program: !armed ? why('disarmed') : fault || stops || (state === 'held' && why('held')) || null,
          jog: {arm: jog},
        },
      },
      0,
  );
}

interface Combination {
  state: string;
  armed: boolean;
  real: boolean;
  program: string;
  inactive: boolean;
  touching: boolean;
  left: boolean;
  pushed: boolean;
  moving: boolean;
}
const both = [false, true];
const all: Combination[] = ['running', 'stopping', 'held', 'fault', 'backing'].flatMap(
    (state) => both.flatMap(
        (real) => (real ? both : [true])
                      .flatMap(
                          (armed) => ['none', 'ready', 'running', 'paused', 'ended'].flatMap(
                              (program) => both.flatMap(
                                  (inactive) => both.flatMap(
                                      (touching) => both.flatMap(
                                          (left) => both.flatMap((pushed) => both.map((moving) => ({
                                                                                        state,
                                                                                        armed,
                                                                                        real,
                                                                                        program,
                                                                                        inactive,
                                                                                        touching,
                                                                                        left,
                                                                                        pushed,
                                                                                        moving
                                                                                      })))))),
                              ),
                          )),
);
const say = (each: Combination) => JSON.stringify(each);
const seen = (each: Combination, mayMove = true, pausing = false) =>
    waysOf({status: told(each), mayMove, pausing});

describe('what a person can do', () => {
  it('is something in every state: none is a dead end', () => {
    for (const each of all) {
      if (each.state === 'stopping' || each.state === 'backing') continue;  // it ends by itself
      // The hand that pushes an arm lets go of it before anything else is done.
      if (each.moving && each.pushed) continue;
      const now = seen(each);
      const leads = canBe(now.nextBlocked) || (now.discard !== null && canBe(now.discard)) ||
          (each.state === 'held' && canBe(now.back)) || canBe(now.jog('arm'));
      expect(leads || each.moving, say(each)).toBe(true);
    }
  });

  it('is one key that leads on, and it does what the cell allows', () => {
    for (const each of all) {
      const now = seen(each);
      const status = told(each);
      if (now.next === 'resume' && canBe(now.nextBlocked) && each.state === 'held')
        expect(status.cannot.resume, say(each)).toBeUndefined();
      if (each.state === 'fault')
        expect(now.next, say(each)).toBe('recover');
      else if (!each.armed && each.state !== 'stopping' && each.state !== 'backing')
        expect(now.next, say(each)).toBe('arm');
      if (now.next === 'recover') expect(each.state).toBe('fault');
      if (now.next === 'pause') expect(each.state, say(each)).not.toBe('held');
    }
  });

  it('can be paused while something goes on, whatever device is not active; what stands is activated first',
     () => {
       const idle = {...all[0]!, inactive: true};
       expect(seen(idle).next).toBe('activate');
       expect(seen({...idle, moving: true}).next).toBe('pause');
       expect(seen({...idle, program: 'running'}).next).toBe('pause');
       expect(seen({...idle, program: 'paused'}).next).toBe('activate');
       const held = seen({...idle, state: 'held', moving: false});
       expect([held.next, held.resumesToo, held.discard]).toEqual(['activate', '', null]);
       expect(blockedWords(held.start)).toBe(en['why.activateFirst']);
       expect(blockedWords(seen({...idle, state: 'held', inactive: false}).start)).toBe(en['why.resumeFirst']);
     });

  it('never starts and steps at once, and starts only what the cell would start', () => {
    for (const each of all) {
      const now = seen(each);
      if (!now.going) expect(canBe(now.step) || canBe(now.stepInto) || canBe(now.end), say(each)).toBe(false);
      if (canBe(now.start))
        expect(told(each).cannot.program === undefined && each.state === 'running' && each.armed, say(each))
            .toBe(true);
      if (canBe(now.stepInto)) expect(canBe(now.step), say(each)).toBe(true);
      if (canBe(now.step))
        expect(each.armed && ['running', 'held'].includes(each.state), say(each)).toBe(true);
    }
  });

  it('says why each key is off, in words that the page has', () => {
    for (const each of all) {
      const now = seen(each);
      for (const blocked
               of [now.nextBlocked, now.discard ?? '', now.back, now.start, now.step, now.stepInto, now.end,
                   now.jog('arm')])
        if (typeof blocked === 'string' && blocked !== '') expect(blocked in en, blocked).toBe(true);
    }
    const started = (change: Partial<Combination>) => blockedWords(seen({...all[0]!, ...change}).start);
    expect(started({})).toBe('');
    expect(started({moving: true})).toBe('Wait until the robot is at rest.');
    expect(started({state: 'held'})).toBe('Press Resume first: the cell is held.');
    expect(started({state: 'fault'})).toBe('Press Recover first: the cell is in a fault.');
    expect(started({real: true, armed: false})).toBe('Compare and arm the robot first.');
    expect(blockedWords(seen({...all[0]!, state: 'held', left: true}).jog('arm')))
        .toBe('Resume or cancel the paused motion first.');
  });

  it('is only to pause for who has no control, and nothing without a cell or a connection', () => {
    for (const each of all) {
      const now = seen(each, false);
      for (const blocked
               of [now.discard ?? 'why.control', now.back, now.start, now.step, now.end, now.jog('arm')])
        expect(blocked, say(each)).toBe('why.control');
      if (now.next !== 'pause') expect(now.nextBlocked, say(each)).toBe('why.control');
    }
    for (const status of [null, readStatus({state: 'no cell'}, 0)]) {
      const now = waysOf({status, mayMove: false, pausing: false});
      for (const blocked of [now.nextBlocked, now.back, now.start, now.step, now.end, now.jog('arm')])
        expect(blocked).toBe(status ? 'why.noCell' : 'why.offline');
      expect(now.discard).toBe(null);
    }
  });

  it('lets what moved the robot while it was held be accepted, with or without a motion that is left', () => {
    const pushed = {...all[0]!, state: 'held', pushed: true, moving: false};
    for (const left of both) {
      const now = seen({...pushed, left});
      expect(canBe(now.nextBlocked)).toBe(false);
      expect(now.discard).toBe('');
      expect(now.discards).toBe(left ? 'motion' : 'push');
    }
  });

  it('says in one short line why a robot in forward mode is not jogged', () => {
    expect(blockedWords(why('forward-mode'))).toBe('Its own controller interpolates: jog it there, or move it by a program.');
  });

  it('does not step twice: while a pause comes, no step can be asked for', () => {
    const goes = {...all[0]!, program: 'running'};
    expect(canBe(seen(goes).step)).toBe(true);
    expect(seen(goes, true, true).step).toBe('state.pausing');
  });
});
