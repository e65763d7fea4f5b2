// Who only watches may type into the editor: nothing is asked of the cell until the page has control.
import { beforeEach, expect, it, vi } from 'vitest';

vi.stubGlobal('navigator', { language: 'en', userAgent: '' });
vi.useFakeTimers();
const sent: [string, Record<string, unknown>][] = [];
const { mayProgram, connected, status } = await vi.hoisted(async () => {
  const { signal } = await import('@preact/signals');
  return { mayProgram: signal(false), connected: signal(true), status: signal(null) };
});
vi.mock('../src/state/cell', async (original) => ({
  ...(await original<object>()),
  mayProgram,
  connected,
  status,
  request: async (name: string, args: Record<string, unknown>) => {
    sent.push([name, args]);
    return name === 'files.read' ? { text: 'wait 1s\n', hash: 'h' } : name === 'program.edited' ? { breakpoints: [] } : {};
  },
}));
const doc = await import('../src/pages/program/documents');
const drafts = () => sent.filter(([name]) => name === 'files.draft').map(([, args]) => args.text);

beforeEach(async () => {
  mayProgram.value = false;
  await doc.openFile('a.script');
  sent.length = 0;
});

it('keeps what a viewer types in this browser, and sends it when the page has control', async () => {
  for (const text of ['wait 2s\n', 'wait 3s\n', 'wait 4s\n']) {
    doc.edit(text);
    await vi.advanceTimersByTimeAsync(2000);
  }
  expect(sent).toEqual([]);
  expect(doc.draftState.value).toBe('here');
  mayProgram.value = true;
  await vi.advanceTimersByTimeAsync(0);
  expect(drafts()).toEqual(['wait 4s\n']);
  expect(doc.draftState.value).toBe('kept');
});

it('asks nothing of the cell either when the text is as it was', async () => {
  doc.edit('wait 2s\n');
  doc.edit('wait 1s\n');
  await vi.advanceTimersByTimeAsync(2000);
  expect(sent).toEqual([]);
});
