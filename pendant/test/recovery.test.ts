// The latest refusal of a recovery is shown until all hardware is active.
import { beforeEach, expect, it, vi } from 'vitest';
import type { Status } from '../src/wire/types';

vi.stubGlobal('navigator', { language: 'en', userAgent: '' });
let answer: () => unknown;
let opensCell: () => void = () => undefined;
vi.mock('../src/state/cell', async (original) => ({ ...(await original<object>()), request: async () => answer(), complain: () => undefined, onEvent: (_: string, take: () => void) => (opensCell = take) }));
const { status } = await import('../src/state/cell');
const { lastRefusal, recoverHardware } = await import('../src/state/recovery');

const refuses = (what: string) => () => {
  throw Object.assign(new Error(what), { problem: { code: 'component-failed', what } });
};
const inactive = (...names: string[]) => (status.value = { inactive: names } as unknown as Status);

beforeEach(() => {
  inactive('arm');
  lastRefusal.value = null;
});

it('is kept, and replaced by the next one', async () => {
  answer = refuses('the fence is open');
  expect(await recoverHardware({ controllers: true })).toBeNull();
  expect(lastRefusal.value?.what).toBe('the fence is open');
  answer = refuses('it is switched off');
  await recoverHardware({ controllers: true });
  expect(lastRefusal.value?.what).toBe('it is switched off');
});

it('is forgotten when the hardware comes back, here or by another screen', async () => {
  answer = refuses('the fence is open');
  await recoverHardware({ controllers: true });
  answer = () => ({ name: 'arm', state: 'active', fallen: [], next: '' });
  expect(await recoverHardware({ controllers: true })).toMatchObject({ state: 'active' });
  expect(lastRefusal.value).toBeNull();
  answer = refuses('the fence is open');
  await recoverHardware({ controllers: true });
  inactive('arm', 'other');
  expect(lastRefusal.value).not.toBeNull();
  inactive();
  expect(lastRefusal.value).toBeNull();
});

it('is not said of the next cell', async () => {
  answer = refuses('the fence is open');
  await recoverHardware({ controllers: true });
  opensCell();
  expect(lastRefusal.value).toBeNull();
});
