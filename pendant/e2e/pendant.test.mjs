// The page in a browser against a running cell. Each test begins where the one before has left the cell.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { createRequire } from 'node:module';
import { after, before, test as run } from 'node:test';
import { go, launch, picture, screen, state, stopKey } from './browser.mjs';
import { Cell, until, Watcher } from './cell.mjs';

const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const cell = new Cell('pick_and_place');
let chrome, page, watcher, commanded;

before(async () => {
  chrome = await launch();
  commanded = Date.now();
  await cell.start();
  watcher = await new Watcher(cell).start();
}, { timeout: 180_000 });
after(async () => {
  watcher?.end();
  await chrome?.end();
  await cell.end();
});
/** A case with at most a minute; a picture of the page where it fails, and what the cell said last. */
function test(name, body, timeout = 300_000) {
  run(name, { timeout }, async (t) => {
    try {
      await goOn();
      await body(t);
    } catch (error) {
      await picture(page, name.replace(/\W+/g, '-'));
      t.diagnostic(cell.output.split('\n').slice(-12).join('\n'));
      throw error;
    }
  });
}

/** A machine that stands still for half a second has the cell hold, as it should; the tests go on. */
async function goOn() {
  const { state, cause } = watcher.events.status ?? {};
  if (page && state === 'held' && /^wall time/.test(cause)) await page.getByRole('contentinfo').getByRole('button', { name: 'Resume' }).click();
}

const inControl = (on) => on.getByRole('button', { name: /^In control/ });
const watching = (on) => on.getByRole('button', { name: /^(Watching|No control)/ });
const joint = (name) => `arm/${name}_joint/position`;
/** Holds a key down until `seen`; pressed anew where the machine stood still for so long that the motion was ended for it. */
let pressed = 0;
async function holdKey(button, seen, what) {
  for (let left = 3; ; --left) {
    if (watcher.events.status?.state === 'held') {
      await page.getByRole('contentinfo').getByRole('button', { name: 'Resume' }).click();
      await until(() => watcher.events.status?.state === 'running', 10, 'running');
    }
    await page.mouse.up();
    await button.hover();
    pressed = Date.now();
    await page.mouse.down();
    try {
      return await until(seen, 5, what);
    } catch (error) {
      await page.mouse.up();
      if (left === 0) throw error;
    }
  }
}
const atRest = () => until(() => watcher.speed() < 0.002, 10, 'standing');

test('opens, has control and shows the robot moving', async (t) => {
  const began = Date.now();
  page = await screen(chrome.browser, cell.link);
  await inControl(page).waitFor();
  await state(page).getByText(/^Program/).waitFor();
  const view = page.getByRole('region', { name: 'Robot view' });
  await view.getByRole('button', { name: 'Views' }).waitFor();
  await until(() => watcher.speed() > 0.05, 15, 'motion of the robot');
  const first = await view.screenshot();
  await until(async () => (await goOn(), !first.equals(await view.screenshot())), 20, 'another picture');
  t.diagnostic(`robot seen moving ${Date.now() - commanded} ms after the command, ${Date.now() - began} ms after the page was asked for`);
  assert.equal(new URL(page.url()).searchParams.get('token'), null, 'the token stays in the address');
  assert.deepEqual(page.problems, []);
});

test('stops in the middle of a motion, by key and by button, and goes on', async () => {
  for (const stop of [() => stopKey(page).click(), () => page.keyboard.press('Escape')]) {
    await until(() => watcher.speed() > 0.1, 20, 'motion');
    await stop();
    await state(page).getByText('Held').waitFor();
    await atRest();
    const where = watcher.value(joint('shoulder_pan'));
    await page.getByRole('contentinfo').getByRole('button', { name: 'Resume' }).click();
    await state(page).getByText(/^Program/).waitFor();
    assert.ok(Math.abs(where) < 7);
  }
});

test('sets the speed of everything, and tells it', async () => {
  const slider = page.getByRole('contentinfo').getByRole('slider', { name: 'Speed' });
  await slider.focus();
  await page.keyboard.press('Home');
  await until(() => watcher.events.status?.override === 0, 10, 'an override of 0 %');
  await atRest();
  await page.keyboard.press('End');
  await until(() => watcher.events.status?.override === 100, 10, 'an override of 100 %');
});

test('ends the program after a question', async () => {
  await go(page, 'Run');
  await page.getByRole('button', { name: 'End program' }).click();
  await page.getByRole('dialog').getByRole('button', { name: 'End program' }).click();
  await until(() => watcher.events.status?.program?.ended, 15, 'the end of the program');
  await page.getByRole('button', { name: 'Start' }).waitFor();
  await atRest();
});

test('jogs while a key is held, and stops when it is let go', async (t) => {
  await go(page, 'Move');
  const before = watcher.value(joint('shoulder_pan'));
  await holdKey(page.getByRole('button', { name: 'shoulder pan plus' }), () => watcher.speed() > 0.001, 'the first motion');
  t.diagnostic(`jog: ${Date.now() - pressed} ms from the press to the first frame with motion (frames come every 17 ms)`);
  await holdKey(page.getByRole('button', { name: 'shoulder pan plus' }), () => watcher.value(joint('shoulder_pan')) > before + 0.02, 'motion upwards');
  await page.mouse.up();
  await atRest();
  const after = watcher.value(joint('shoulder_pan'));
  const from = watcher.time;
  await until(() => watcher.time > from + 0.5, 10, 'half a second');
  assert.ok(Math.abs(watcher.value(joint('shoulder_pan')) - after) < 1e-3, 'it stands');
  await page.getByRole('button', { name: 'shoulder pan minus' }).focus();
  await page.keyboard.down('Space');
  await until(() => watcher.value(joint('shoulder_pan')) < after - 0.01, 10, 'motion downwards');
  await page.keyboard.up('Space');
  await atRest();
});

test('jogs the TCP straight along an axis of the base', async () => {
  await page.getByRole('radiogroup', { name: 'Move in' }).getByText('Base').click();
  const [x, y, z] = ['x', 'y', 'z'].map((axis) => watcher.value(`arm/tcp/${axis}`));
  await holdKey(page.getByRole('button', { name: 'Z plus', exact: true }), () => watcher.value('arm/tcp/z') > z + 0.01, 'the TCP going up');
  await page.mouse.up();
  await atRest();
  assert.ok(Math.abs(watcher.value('arm/tcp/x') - x) < 1e-3 && Math.abs(watcher.value('arm/tcp/y') - y) < 1e-3, 'only up');
});

test('jogs by a step of what it says', async () => {
  const z = watcher.value('arm/tcp/z');
  await page.getByLabel('Step').selectOption({ label: '10 mm · 5°' });
  await page.getByRole('button', { name: 'Z minus', exact: true }).click();
  await until(() => Math.abs(watcher.value('arm/tcp/z') - (z - 0.01)) < 2e-4, 10, '10 mm down');
  await page.getByLabel('Step').selectOption({ label: 'While held' });
});

test('stops when the window loses the focus', async () => {
  await holdKey(page.getByRole('button', { name: 'Z plus', exact: true }), () => watcher.speed() > 0.01, 'motion');
  await page.evaluate(() => dispatchEvent(new Event('blur')));
  await atRest();
  const from = watcher.time;
  await until(() => watcher.time > from + 0.4, 10, 'a moment');
  assert.ok(watcher.speed() < 0.002, 'it stays where it is, though the key is still down');
  await page.mouse.up();
});

test('gives control to another screen that asks for it', async () => {
  const other = await screen(chrome.browser, cell.link);
  await watching(other).click();
  const dialog = other.getByRole('dialog', { name: 'Who has control' });
  await dialog.getByRole('button', { name: 'Take control' }).click();
  const question = page.getByRole('dialog', { name: /asks for control$/ });
  await question.getByRole('button', { name: 'Give control' }).click();
  await inControl(other).waitFor();
  await watching(page).waitFor();
  assert.ok(await page.getByRole('button', { name: 'Z plus', exact: true }).isDisabled(), 'who watches cannot jog');
  assert.ok(await stopKey(page).isEnabled(), 'who watches can stop');
  assert.deepEqual(other.problems, []);
  await other.context().close();
  await page.getByRole('main').getByRole('button', { name: 'Take control' }).click();
  await inControl(page).waitFor();
});

test('loses control to another screen where nobody answers', async () => {
  const other = await screen(chrome.browser, cell.link);
  await watching(other).click();
  await other.getByRole('dialog', { name: 'Who has control' }).getByRole('button', { name: 'Take control' }).click();
  await page.getByRole('dialog', { name: /asks for control$/ }).waitFor();
  await inControl(other).waitFor();
  await watching(page).waitFor();
  await page.getByRole('dialog', { name: /asks for control$/ }).waitFor({ state: 'detached' });
  await other.context().close();
  await page.getByRole('main').getByRole('button', { name: 'Take control' }).click();
  await inControl(page).waitFor();
});

test('a page from elsewhere cannot reach the cell, though the browser has its cookie', async () => {
  const elsewhere = createServer((_, answer) => answer.setHeader('Content-Type', 'text/html').end('<title>Elsewhere</title>'));
  await new Promise((done) => elsewhere.listen(0, '127.0.0.1', done));
  const foreign = await page.context().newPage();
  try {
    await foreign.goto(`http://localhost:${elsewhere.address().port}/`);
    const tried = await foreign.evaluate(async (host) => {
      const socket = new WebSocket(`ws://${host}/ws`);
      const opened = await new Promise((done) => {
        socket.onopen = () => done(true);
        socket.onerror = socket.onclose = () => done(false);
      });
      const read = await fetch(`http://${host}/api/cell`, { credentials: 'include' }).then(() => true, () => false);
      const wrote = await fetch(`http://${host}/api/project.zip?name=x`, { method: 'PUT', credentials: 'include', body: 'x' }).then(() => true, () => false);
      return { opened, read, wrote };
    }, new URL(cell.link).host);
    assert.deepEqual(tried, { opened: false, read: false, wrote: false });
  } finally {
    await foreign.close();
    elsewhere.close();
  }
});

test('comes back after the server was killed and started again', async () => {
  watcher.end();
  await cell.kill();
  await page.getByRole('alert').getByText('No connection to the cell').waitFor();
  assert.ok(await page.getByRole('button', { name: 'Z plus', exact: true }).isDisabled(), 'nothing can be jogged');
  await cell.start();
  watcher = await new Watcher(cell).start();
  await inControl(page).waitFor();
  await state(page).getByText(/^(Program|Ready|Moving)/).waitFor();
  await page.getByRole('alert').getByText('No connection to the cell').waitFor({ state: 'detached' });
});

test('has nothing serious for axe to find, on any page, light and dark', async () => {
  const found = [];
  for (const colorScheme of ['dark', 'light']) {
    await page.emulateMedia({ colorScheme });
    for (const name of ['Run', 'Move', 'Program', 'Points', 'Signals', 'Plots', 'Health', 'Cell']) {
      await go(page, name);
      await page.getByRole('main', { name }).waitFor();
      await page.getByRole('main').getByText('Loading…').waitFor({ state: 'detached', timeout: 2000 }).catch(() => undefined);
      found.push(...(await serious(page, `${name}, ${colorScheme}`, colorScheme === 'dark' ? undefined : ['color-contrast'])));
    }
    await page.getByRole('button', { name: 'Settings' }).click();
    found.push(...(await serious(page, `Settings, ${colorScheme}`)));
    await page.getByRole('dialog').getByRole('button', { name: 'Close' }).click();
  }
  assert.deepEqual(found, []);
});

/** What axe finds, by all its rules or by some. */
async function serious(on, where, rules) {
  if (!(await on.evaluate(() => 'axe' in globalThis))) await on.evaluate(axe);
  const { violations } = await on.evaluate(
    (only) => globalThis.axe.run({ resultTypes: ['violations'], ...(only && { runOnly: only }) }),
    rules,
  );
  return violations
    .filter((each) => ['serious', 'critical'].includes(each.impact))
    .map((each) => `${where}: ${each.id}: ${each.nodes.map((node) => node.target.join(' ')).join(', ')}`);
}

test('fits a small tablet and a phone, with Stop in reach', async () => {
  for (const [width, height] of [[1024, 600], [390, 844]]) {
    await page.setViewportSize({ width, height });
    for (const name of ['Run', 'Move']) {
      await go(page, name);
      const wide = await page.evaluate(() => document.documentElement.scrollWidth);
      assert.ok(wide <= width, `${name} is ${wide} px wide on ${width}`);
      const box = await stopKey(page).boundingBox();
      assert.ok(box.y + box.height <= height && box.x + box.width <= width && box.height >= 44, `Stop is in reach on ${width}`);
      const small = await page.evaluate(() =>
        [...document.querySelectorAll('button, a[href], select')]
          .map((each) => [each.getAttribute('aria-label') ?? each.textContent, each.getBoundingClientRect()])
          .filter(([, box]) => box.width > 0 && box.bottom > 0 && (box.width < 43.5 || box.height < 41.5))
          .map(([label, box]) => `${label} ${Math.round(box.width)}×${Math.round(box.height)}`),
      );
      assert.deepEqual(small, [], `${name} on ${width}`);
    }
  }
  await page.setViewportSize({ width: 1280, height: 800 });
});

test('shows the robot without WebGL, too', async () => {
  const plain = await screen(chrome.browser, cell.link, {
    before: () => {
      const get = HTMLCanvasElement.prototype.getContext;
      HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
        return kind.startsWith('webgl') ? null : get.call(this, kind, ...rest);
      };
    },
  });
  await plain.getByText('Simple view: this browser has no WebGL.').waitFor();
  const view = plain.getByRole('img', { name: /^The robot/ });
  const first = await view.screenshot();
  await until(async () => (await goOn(), !first.equals(await view.screenshot())), 20, 'another picture');
  await plain.context().close();
});

test('speaks Spanish', async () => {
  const spanish = await screen(chrome.browser, cell.link, { locale: 'es-ES' });
  await spanish.getByRole('button', { name: /^Parar .*parada por software, no es una parada de emergencia$/ }).waitFor();
  assert.equal(await spanish.evaluate(() => document.documentElement.lang), 'es');
  await spanish.context().close();
});

test('comes to rest within 250 ms when the browser is killed while it jogs', async (t) => {
  await go(page, 'Run');
  await page.getByRole('button', { name: /^(End program|Start)$/ }).first().waitFor();
  if (!watcher.events.status?.program?.ended) {
    await page.getByRole('button', { name: 'End program' }).click();
    await page.getByRole('dialog').getByRole('button', { name: 'End program' }).click();
    await until(() => watcher.events.status?.program?.ended, 15, 'the end of the program');
  }
  const full = page.getByRole('contentinfo').getByRole('button', { name: 'Full speed' });
  if (await full.isVisible()) await full.click();
  await page.getByRole('contentinfo').getByRole('button', { name: 'Reduced speed' }).waitFor();
  await go(page, 'Move');
  await page.getByRole('radiogroup', { name: 'Move in' }).getByText('Joints').click();
  await atRest();
  await page.getByRole('slider', { name: 'Jog speed' }).focus();
  await page.keyboard.press('End');
  await holdKey(page.getByRole('button', { name: 'shoulder pan plus' }), () => watcher.speed() > 0.05, 'motion');
  const killed = watcher.time;
  chrome.kill();
  await until(() => watcher.time > killed + 1, 15, 'a second');
  const moving = watcher.frames.filter((frame) => frame.time > killed && watcher.speed(frame) > 0.005);
  const stood = moving.length ? moving.at(-1).time - killed : 0;
  t.diagnostic(`killed while jogging: standing after ${Math.round(1000 * stood)} ms of cell time (frames come every 17 ms)`);
  assert.ok(stood <= 0.25, `it stood ${Math.round(1000 * stood)} ms after the kill`);
  assert.ok(await until(() => watcher.events.status?.holder === null, 10, 'nobody having control'));
});
