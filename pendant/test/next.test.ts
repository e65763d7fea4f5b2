// What the page says comes next: of a fault, and of a program that waits for the robot to be armed.
import { expect, it, vi } from 'vitest';

vi.stubGlobal('navigator', { language: 'en', userAgent: '' });
vi.stubGlobal('location', { hash: '' });
vi.stubGlobal('addEventListener', () => undefined);
vi.stubGlobal('document', { addEventListener: () => undefined });
const { link, status, youHold } = await import('../src/state/cell');
const { readStatus } = await import('../src/wire/read');
const { afterFault } = await import('../src/shell/AlarmStrip');
const { programWord } = await import('../src/pages/run/Now');

const told = (more: object) => {
  [link.value, youHold.value] = ['open', true];
  status.value = readStatus({ event: 'status', standing: true, holder: { client: 1, name: '' }, ...more }, 1);
};
const moved = { code: 'moved-while-held', what: 'own', facts: { joint: 'arm/elbow_joint', moved_rad: 0.1 } };

it('does not ask for Resume while the robot stands elsewhere', () => {
  told({ state: 'held', motion_left: false, can: { resume: null } });
  expect(afterFault()).toBe('Press Resume');
  told({ state: 'held', motion_left: false, can: { resume: moved } });
  expect(afterFault()).toMatch(/^arm\/elbow_joint was moved by .+Stay here/);
});

it('does not call a program running that waits until the robot is armed', () => {
  const program = { file: '/cells/a/job.script', state: 'running', line: 1 };
  told({ state: 'running', simulated: false, armed: false, program });
  expect(programWord().text).toBe('waits until armed');
  told({ state: 'running', simulated: false, armed: true, program });
  expect(programWord().text).toBe('running');
});
