import { describe, expect, it, vi } from 'vitest';

vi.stubGlobal('navigator', { language: 'en', userAgent: '' });
const { contactWords, robotsInContact, touchOf } = await import('../src/shell/contact');

const touch = (b: string, now: boolean, depth = 0.0021) => ({ a: 'arm/wrist_3_link', b, depth, at: null, now, text: '' });
const contacts = (...list: ReturnType<typeof touch>[]) => ({ checked: true, touching: list.some((each) => each.now), unchecked: [], list });
const alarm = (code: string, facts: Record<string, string | number>) => ({ number: 1, time: 1, code, what: code, where: '', advice: '', facts, severity: 'error' as const });
const torque = alarm('collision-torque', { joint: 'arm/elbow_joint', torque: '52.3 Nm' });
const hit = alarm('contact', { a: 'arm/wrist_3_link', b: 'fixture table', depth_m: 0.001 });

describe('a stop after a contact', () => {
  it('names what touches now, else what touched last', () => {
    expect(contactWords(contacts(touch('tray', false), touch('fixture table', true)), [hit]).text).toBe('arm/wrist_3_link and table, 2.1 mm deep');
    expect(contactWords(contacts(touch('fixture table', false), touch('tray', false)), [hit]).text).toBe('arm/wrist_3_link and tray, 2.1 mm deep');
  });
  it('names the joint whose motor felt it, and not a contact from before', () => {
    expect(contactWords(contacts(), [torque])).toEqual({ text: '52.3 Nm act on arm/elbow_joint from outside', felt: true });
    expect(contactWords(contacts(touch('tray', false)), [hit, torque]).text).toMatch(/^52.3 Nm/);
  });
  it('is of the contact again once that is newer', () => {
    expect(contactWords(contacts(touch('tray', false)), [torque, hit])).toEqual({ text: 'arm/wrist_3_link and tray, 2.1 mm deep', felt: false });
    expect(contactWords(contacts(touch('tray', true)), [torque]).felt).toBe(false);
  });
  it('is of a robot only while its links or its part touch', () => {
    const list = [{ ...touch('fixture table', false), a: 'left/tool' }, { ...touch('part cube', true), a: 'left2/tool' }, { ...touch('right/elbow_link', true), a: 'the part held by up' }];
    expect(['left', 'left2', 'right', 'up'].map((name) => touchOf(name, list)?.b)).toEqual([undefined, 'part cube', 'right/elbow_link', 'right/elbow_link']);
  });
  it('is of the robots whose links or parts touch, and of no other', () => {
    const of = (a: string, b: string, now = true) => ({ ...contacts(), list: [{ ...touch(b, now), a }] });
    const names = ['left', 'left2', 'right'];
    expect(robotsInContact(of('left2/tool', 'fixture table'), [], names)).toEqual(['left2']);
    expect(robotsInContact(of('the part held by right', 'left/forearm_link', false), [hit], names)).toEqual(['left', 'right']);
    const pushed = alarm('collision-torque', { joint: 'right/elbow_joint', torque: '52.3 Nm' });
    expect(robotsInContact(of('left/tool', 'fixture table', false), [hit, pushed], names)).toEqual(['right']);
  });
});
