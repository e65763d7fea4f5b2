import { describe, expect, it } from 'vitest';
import { readAlarm, readCell, readJog, readNear, readPart, readPlans, readScene, readStatus } from '../src/wire/read';

const identity = [0, 0, 0, 1];

describe('readStatus', () => {
  const event = {
    state: 'held',
    cause: 'a stop was requested',
    standing: true,
    armed: true,
    simulated: true,
    profile: 'reduced',
    override: 40,
    allowed: 100,
    holder: { client: 3, name: 'Tablet' },
    clients: 2,
    program: { file: '/cells/a/a.script', name: 'a.script', state: 'running', where: { file: 'a.script', line: 7 }, source: 'moveto p0', passes: 2, paused: false, ended: false, problem: null },
    jogged: ['arm'],
  };
  it('tells who holds control from who reads it', () => {
    expect(readStatus(event, 3).youHold).toBe(true);
    expect(readStatus(event, 4).youHold).toBe(false);
    expect(readStatus({ ...event, holder: null }, 3).youHold).toBe(false);
  });
  it('reads state, speed and program', () => {
    const got = readStatus(event, 3);
    expect([got.state, got.moving, got.override, got.jogged]).toEqual(['held', false, 40, ['arm']]);
    expect(got.program).toMatchObject({ file: 'a.script', line: 7, lineFile: 'a.script', passes: 2, ended: false, problem: '' });
  });
  it('has no cause where nothing is the matter, and no program between cells', () => {
    expect(readStatus({ ...event, cause: 'nothing' }, 3).cause).toBe('');
    const none = readStatus({ event: 'status', cell: null, state: 'no cell' }, 3);
    expect([none.state, none.program, none.moving]).toEqual(['no cell', null, false]);
  });
});

describe('readCell', () => {
  it('takes joints without limits as free', () => {
    const joint = { name: 'wheel', interface: 'base/wheel', type: 'continuous', lower: null, upper: null, velocity: null, unit: 'rad' };
    const cell = readCell({ name: 'c', robots: [{ name: 'base', joints: [joint] }] });
    expect([cell.robots[0]!.joints[0]!.lower, cell.robots[0]!.joints[0]!.upper]).toEqual([-Infinity, Infinity]);
  });
});

describe('readScene', () => {
  const scene = readScene({
    floor: -0.75,
    fixtures: [{ name: 'door', pose: { p: [1, 0, 0], q: identity }, mover: 'gate', visuals: [{ shape: 'box' }] }],
    parts: [{ name: 'cube', pose: { p: [0, 1, 0], q: identity }, visuals: [] }],
    bins: [{ name: 'tray', lower: [0, 0, 0], upper: [2, 4, 6] }],
    movers: [{ name: 'gate', axis: [0, 0, 1], interface: 'scene/gate/position' }],
  });
  it('has every thing once, and parts that move', () => {
    expect(scene.things.map((thing) => [thing.name, thing.kind, thing.moving ?? false])).toEqual([
      ['door', 'fixture', false],
      ['cube', 'part', true],
      ['tray', 'bin', false],
    ]);
    expect(scene.floor).toBe(-0.75);
  });
  it('puts a region’s box around its middle', () => {
    const tray = scene.things[2]!;
    expect([tray.p, tray.visuals[0]!.size]).toEqual([[1, 2, 3], [2, 4, 6]]);
  });
  it('knows what a mover carries', () => {
    expect(scene.things[0]!.mover).toBe(scene.movers[0]!.name);
    expect(scene.movers[0]!.field).toBe('scene/gate/position');
  });
  it('is empty where nothing is said', () => expect(readScene({})).toEqual({ floor: null, things: [], movers: [] }));
});

describe('events', () => {
  it('tell parts that are held or gone', () => {
    expect(readPart({ name: 'cube', p: [0, 0, 0], q: identity, in_world: false, held_by: null })).toMatchObject({ here: false, heldBy: '' });
    expect(readPart({ name: 'cube', p: [0, 0, 0], q: identity, in_world: true, held_by: 'arm' })).toMatchObject({ here: true, heldBy: 'arm' });
  });
  it('tell where an alarm comes from', () => {
    const alarm = { number: 2, time: 1, code: 'x', what: 'broke', where: { file: 'a.script', line: 3, column: 0 }, advice: 'mend', severity: 'warning' };
    expect(readAlarm(alarm)).toMatchObject({ where: 'a.script:3', severity: 'warning' });
    expect(readAlarm({ ...alarm, where: { file: '', line: 0 } }).where).toBe('');
  });
  it('tell what a jog is held back by, and that it is over', () => {
    expect(readJog({jog: 3, robot: 'arm', over: true, why: 'lost', text: '', which: 'elbow'}))
        .toEqual({jog: 3, robot: 'arm', over: true, why: 'lost', text: '', which: 'elbow'});
  });
});

describe('contacts of a status', () => {
  const told = {
    state: 'held',
    cause: 'x',
    cause_code: 'contact',
    contacts: {
      checked: true,
      touching: true,
      unchecked: ['a mesh', 3],
      unchecked_why: [{code: 'fixture-without-body', facts: {fixture: 'table'}}],
      list: [
        {a: 'arm/hand', b: 'table', depth: 0.002, position: [1, 2, 3], now: true},
        {a: 'arm/hand', position: ['no']}
      ]
    },
    can: {
      resume: {code: 'in-contact', what: 'no'},
      back: null,
      jog: {arm: {code: 'motion-held', what: 'no'}, other: null}
    }
  };
  it('are read with pair, depth and place', () => {
    const status = readStatus(told, 1);
    expect(status.causeCode).toBe('contact');
    expect(status.contacts).toMatchObject({
      checked: true,
      touching: true,
      unchecked: [{what: 'a mesh', code: 'fixture-without-body', facts: {fixture: 'table'}}]
    });
    expect(status.contacts.list[0]).toMatchObject({ a: 'arm/hand', b: 'table', depth: 0.002, at: [1, 2, 3], now: true });
    expect(status.contacts.list[1]).toMatchObject({ b: '', at: null, now: false });
    expect(Object.keys(status.cannot)).toEqual(['resume']);
    expect(Object.keys(status.cannotJog)).toEqual(['arm']);
  });
  it('are none where a server tells none', () => {
    for (const contacts of [undefined, null, 3, []]) expect(readStatus({ contacts }, 1).contacts).toEqual({ checked: true, touching: false, unchecked: [], list: [] });
  });
});

describe('readNear', () => {
  const near = { a: 'arm/forearm', b: 'fixture wall', distance: 0.012, kept: null, on_a: [0, 0, 1], on_b: [0, 0.012, 1], pace: 0.4 };
  it('reads what is nearest to each robot', () => {
    const { arm } = readNear({ robots: { arm: near } });
    expect(arm).toMatchObject({ a: 'arm/forearm', b: 'fixture wall', distance: 0.012, onB: [0, 0.012, 1], pace: 0.4 });
    expect(arm!.kept).toBeNaN();
    expect(readNear({})).toEqual({});
  });
  it('reads the distances along a path, which come later than the path', () => {
    const path = [[0, 0, 0], [0, 0, 1]];
    expect(readPlans({ plans: { arm: { path } } }).arm!.clear).toEqual([]);
    expect(readPlans({ plans: { arm: { path, clear: [0.1, 0.02] } } }).arm!.clear).toEqual([0.1, 0.02]);
  });
});
