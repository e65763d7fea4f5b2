// What the files of cases share: one cell, one browser, one page; each case begins where the one before has left them.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test as run } from 'node:test';
import { launch, picture, screen } from './browser.mjs';
import { Cell, until, Watcher } from './cell.mjs';

/** The robot waits above the part, and is there however late the page opens. */
export const waitAboveThePart = (folder) => {
  const script = join(folder, 'PAPscript.script');
  writeFileSync(script, readFileSync(script, 'utf8').replace('moveto PrePick\nwait time 1\n', 'moveto PrePick\nwait time 600\n'));
};

/** `chain`: where a case has failed there is nothing for the next to begin with. `skip`: why none is run, or false. `lines`: for cases that
 * do not need the picture in 3D; the page then has no WebGL. */
export function suite({ example = 'pick_and_place', options = [], change = () => undefined, chain = false, skip = false, lines = false } = {}) {
  const at = { cell: new Cell(example, options), chrome: null, page: null, watcher: null, commanded: 0 };
  let failed = false;
  before(async () => {
    if (skip) return;
    change(at.cell.folder);
    at.chrome = await launch({ lines });
    at.commanded = Date.now();
    await at.cell.start();
    at.watcher = await new Watcher(at.cell).start();
  }, { timeout: 180_000 });
  after(async () => {
    at.watcher?.end();
    await at.chrome?.end();
    await at.cell.end();
  });

  at.bar = () => at.page.getByRole('contentinfo');
  /** The page of `link`, which the cases use from now on. */
  at.open = async (link = at.cell.link, settings = {}) => (at.page = await screen(at.chrome.browser, link, settings));

  /** A case; a picture of the page where it fails, and what the cell said last. A cell that stopped for the machine's sake fails it,
   * whatever the case itself would have seen. */
  const test = (name, body, timeout = 300_000) =>
    run(name, { timeout, skip }, async (t) => {
      if (failed && chain) return t.skip('a case before has failed');
      try {
        await body(t);
        assert.deepEqual(at.watcher.holds, [], 'the cell stopped by itself');
      } catch (error) {
        failed = true;
        if (at.page) await picture(at.page, name.replace(/\W+/g, '-'));
        t.diagnostic(at.cell.output.split('\n').slice(-12).join('\n'));
        throw error;
      }
    });

  /** Presses and holds something down until `seen`. The page lets go by itself where no sign of life reaches the cell for 120 ms, which a
   * machine with more to do than it can brings about, and says so: then, and only then, it is pressed anew. */
  const hold = async ({ down, up }, seen, what) => {
    const late = at.page.getByRole('region', { name: 'Messages' }).getByText(/^The motion ended: no heartbeat/);
    for (;;) {
      await down();
      let lost = false;
      await until(async () => (await seen()) || (lost = await late.isVisible()), 60, what);
      if (!lost) return;
      await up();
      await at.page.getByRole('region', { name: 'Messages' }).getByRole('button', { name: 'Dismiss' }).first().click();
      await late.waitFor({ state: 'detached' });
    }
  };
  /** The same of a key of the page. */
  const holdKey = (button, seen, what) => {
    const { page } = at;
    const down = async () => {
      await button.hover();
      at.pressed = Date.now();
      await page.mouse.down();
    };
    return hold({ down, up: () => page.mouse.up() }, seen, what);
  };

  /** For a fifth of a second: what a key that was just pressed begins may not be seen yet. */
  const atRest = async () => {
    let since = null;
    await until(() => {
      const moves = at.watcher.events.status?.standing === false || at.watcher.speed() > 0.002;
      since = moves ? null : (since ?? at.watcher.time);
      return since !== null && at.watcher.time > since + 0.2;
    }, 20, 'standing');
  };
  /** Goes to the place that the dialog Go to names, until it says that it is there. */
  const arrive = async () => {
    const dialog = at.page.getByRole('dialog', { name: 'Go to' });
    const told = dialog.getByRole('status');
    await told.getByText(/\(about \d|^Arrived$/).waitFor();
    const there = async () => (await told.innerText()) === 'Arrived';
    if (await there()) return;
    await holdKey(dialog.getByRole('button', { name: /^(Hold to move there|Moving)/ }), there, 'the place');
    await at.page.mouse.up();
    await atRest();
  };
  /** Ends the program of the cell, by the page. */
  const endProgram = async () => {
    await at.page.getByRole('navigation', { name: 'Pages' }).getByRole('link', { name: 'Run' }).click();
    await at.page.getByRole('button', { name: /^(End program|Start)$/ }).first().waitFor();
    const ended = () => at.watcher.events.status?.program?.ended;
    const button = (on) => on.getByRole('button', { name: 'End program' });
    // It may end by itself meanwhile, and takes its key along.
    const press = (on) => button(on).click({ timeout: 10_000 }).then(() => true, () => false);
    const end = async () => (await press(at.page)) && (await press(at.page.getByRole('dialog'))) && until(ended, 30, 'its end');
    await until(async () => ended() || end(), 90, 'the end of the program');
    await atRest();
  };
  return { at, test, arrive, atRest, endProgram, hold, holdKey };
}
