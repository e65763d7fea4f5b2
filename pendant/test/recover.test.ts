// A failed component is brought back by one request, which starts the controllers that stopped with it or none.
import { beforeEach, expect, it, vi } from 'vitest';
import type { Question } from '../src/ui/Dialog';

vi.stubGlobal('navigator', { language: 'en', userAgent: '' });
const sent: unknown[][] = [];
let question: Question;
vi.mock('../src/ui/ask', () => ({ ask: (it: Question) => (question = it), open: () => undefined, close: () => undefined }));
vi.mock('../src/state/health', async (original) => ({ ...(await original<object>()), loadHealth: async () => undefined }));
vi.mock('../src/state/cell', async (original) => {
  const send = async (...args: unknown[]) => sent.push(args);
  return { ...(await original<object>()), request: send, attempt: send };
});
const { recover } = await import('../src/pages/health/Machines');

beforeEach(() => {
  sent.length = 0;
  recover('mock');
});

it('asks before it sends anything', () => expect([sent, question.text]).toEqual([[], expect.stringContaining('mock')]));

it('names the controllers that stopped with it', () => {
  recover('mock', ['follow', 'tail']);
  expect(question.text).toContain('follow, tail');
});

it('lets the cell start what stopped with the component', async () => {
  question.onYes();
  await vi.waitFor(() => expect(sent).toEqual([['hardware.recover', { name: 'mock', controllers: true }]]));
});

it('starts no controllers if the user does not want them', async () => {
  question.less!.onPick();
  await vi.waitFor(() => expect(sent).toEqual([['hardware.recover', { name: 'mock' }]]));
});
