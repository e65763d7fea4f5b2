// Files that are dropped on the page.
import { describe, expect, it, vi } from 'vitest';

const handlers: Record<string, (event: unknown) => void> = {};
vi.stubGlobal('navigator', { language: 'en', userAgent: '' });
const captures: string[] = [];
vi.stubGlobal('addEventListener', (name: string, what: (event: unknown) => void, options?: { capture?: boolean }) => {
  handlers[name] = what;
  if (options?.capture) captures.push(name);
});
const addMeshes = vi.fn(() => Promise.resolve());
vi.mock('../src/pages/cell/AddMesh', () => ({ addMeshes }));
const { startDrops } = await import('../src/shell/drops');
const { toasts } = await import('../src/state/toasts');
const state = await import('../src/state/cell');

startDrops();
const event = (files: unknown[]) => ({ dataTransfer: { types: files.length ? ['Files'] : ['text/plain'], files }, preventDefault: vi.fn(), stopPropagation: vi.fn() });

describe('a file that is dropped on the page', () => {
  it('never makes the browser leave it, whoever drops it', () => {
    for (const name of ['dragover', 'drop']) {
      const dropped = event([{ name: 'a.stl' }]);
      handlers[name]!(dropped);
      expect(dropped.preventDefault).toHaveBeenCalled();
    }
    expect(addMeshes).not.toHaveBeenCalled();
    expect(toasts.value.map((each) => each.text)).toEqual(['You only watch. Take control first.']);
  });
  it('is not inserted into the text of a program', () => {
    const dropped = event([{ name: 'a.stl' }]);
    handlers.drop!(dropped);
    expect(dropped.stopPropagation).toHaveBeenCalled();
    expect(captures).toEqual(['drop']);
  });
  it('is no file where it is a text', () => {
    for (const name of ['dragover', 'drop']) {
      const dropped = event([]);
      handlers[name]!(dropped);
      expect(dropped.preventDefault).not.toHaveBeenCalled();
    }
  });
  it('becomes a thing of the scene where one may', async () => {
    vi.spyOn(state.mayProgram, 'value', 'get').mockReturnValue(true);
    const files = [{ name: 'a.stl' }];
    handlers.drop!(event(files));
    await vi.waitFor(() => expect(addMeshes).toHaveBeenCalledWith(files), 20_000);
  });
});
