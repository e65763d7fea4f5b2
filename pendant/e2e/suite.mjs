// What the files of cases share: one cell, one browser, one page; each case begins where the one before has left them.
import { after, before, test as run } from 'node:test';
import { launch, picture, screen } from './browser.mjs';
import { Cell, until, Watcher } from './cell.mjs';

/** `chain`: where a case has failed there is nothing for the next to begin with. `skip`: why none is run, or false. */
export function suite({ example = 'pick_and_place', options = [], change = () => undefined, chain = false, skip = false } = {}) {
  const at = { cell: new Cell(example, options), chrome: null, page: null, watcher: null, commanded: 0 };
  let failed = false;
  before(async () => {
    if (skip) return;
    change(at.cell.folder);
    at.chrome = await launch();
    at.commanded = Date.now();
    await at.cell.start();
    at.watcher = await new Watcher(at.cell).start();
  }, { timeout: 180_000 });
  after(async () => {
    at.watcher?.end();
    await at.chrome?.end();
    await at.cell.end();
  });

  /** A machine that stands still for a moment has the cell hold, as it should; a person resumes. */
  at.goOn = async () => {
    const { state, cause } = at.watcher.events.status ?? {};
    if (at.page && state === 'held' && /^wall time/.test(cause)) await at.bar().getByRole('button', { name: 'Resume' }).click({ timeout: 5000 }).catch(() => undefined);
  };
  at.bar = () => at.page.getByRole('contentinfo');
  /** The page of `link`, which the cases use from now on. */
  at.open = async (link = at.cell.link, settings = {}) => (at.page = await screen(at.chrome.browser, link, settings));

  /** A case; a picture of the page where it fails, and what the cell said last. */
  const test = (name, body, timeout = 300_000) =>
    run(name, { timeout, skip }, async (t) => {
      if (failed && chain) return t.skip('a case before has failed');
      try {
        await at.goOn();
        await body(t);
      } catch (error) {
        failed = true;
        if (at.page) await picture(at.page, name.replace(/\W+/g, '-'));
        t.diagnostic(at.cell.output.split('\n').slice(-12).join('\n'));
        throw error;
      }
    });

  /** A busy machine may hold the cell more than once. */
  const running = async () => {
    const { state } = at.watcher.events.status ?? {};
    if (state === 'held') await at.bar().getByRole('button', { name: 'Resume' }).click({ timeout: 5000 }).catch(() => undefined);
    return state === 'running';
  };

  /** Holds something down until `seen`; pressed anew where the machine stood still for so long that the motion was ended for it. */
  const hold = async ({ down, up }, seen, what) => {
    for (let left = 3; ; --left) {
      await up();
      await until(running, 60, 'running');
      await down();
      try {
        return await until(seen, 5, what);
      } catch (error) {
        await up();
        if (left === 0) throw error;
      }
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
      since = at.watcher.speed() < 0.002 ? (since ?? at.watcher.time) : null;
      return since !== null && at.watcher.time > since + 0.2;
    }, 20, 'standing');
  };
  /** Goes to the place that the dialog Go to names, pressed anew where the machine stood still, until it says that it is there. */
  const arrive = async () => {
    const dialog = at.page.getByRole('dialog', { name: 'Go to' });
    const told = dialog.getByRole('status');
    for (let left = 5; ; --left) {
      await told.getByText(/\(about \d|^Arrived$/).waitFor();
      if ((await told.innerText()) === 'Arrived') return;
      await until(running, 60, 'running');
      await dialog.getByRole('button', { name: /^(Hold to move there|Moving)/ }).hover();
      await at.page.mouse.down();
      try {
        return await told.getByText('Arrived').waitFor({ timeout: 15_000 });
      } catch (error) {
        if (left === 0) throw error;
      } finally {
        await at.page.mouse.up();
        await atRest();
      }
    }
  };
  /** Ends the program of the cell, by the page. */
  const endProgram = async () => {
    await at.page.getByRole('navigation', { name: 'Pages' }).getByRole('link', { name: 'Run' }).click();
    await at.page.getByRole('button', { name: /^(End program|Start)$/ }).first().waitFor();
    if (!at.watcher.events.status?.program?.ended) {
      await at.page.getByRole('button', { name: 'End program' }).click();
      await at.page.getByRole('dialog').getByRole('button', { name: 'End program' }).click();
      await until(() => at.watcher.events.status?.program?.ended, 30, 'the end of the program');
    }
    await atRest();
  };
  return { at, test, arrive, atRest, endProgram, hold, holdKey };
}
