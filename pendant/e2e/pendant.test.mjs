// The page in a browser against a running cell. Each test begins where the one before has left the cell.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { join } from 'node:path';
import { go, screen, state, stopKey } from './browser.mjs';
import { until, Watcher } from './cell.mjs';
import { suite } from './suite.mjs';

/** A program that moves without end; its first line is a remark. */
const endless = (folder) => {
  const file = join(folder, 'cell.yaml');
  writeFileSync(file, readFileSync(file, 'utf8').replace(/^program:.*$/m, 'program: endless.script').replace(/^plc:.*\n/m, ''));
  writeFileSync(join(folder, 'endless.script'), '# to and fro\nload PAPpoints\nwhile true\n  moveto PrePick\n  moveto PrePlace\nend\n');
};
const { at, test, atRest, endProgram, holdKey } = suite({ change: endless });
const { cell } = at;
let page;

const inControl = (on) => on.getByRole('button', { name: /^In control/ });
const watching = (on) => on.getByRole('button', { name: /^(Watching|No control)/ });
/** The robot goes at so much, rad/s, at least. */
const moving = (speed) => until(() => at.watcher.speed() > speed, 90, 'motion of the robot');
const running = () => until(() => state(page).getByText(/^Program/).isVisible(), 90, 'a program that runs');
const joint = (name) => `arm/${name}_joint/position`;
test('opens, has control and shows the robot moving', async (t) => {
  const began = Date.now();
  page = await at.open();
  await inControl(page).waitFor();
  await running();
  const view = page.getByRole('region', { name: 'Robot view' });
  await view.getByRole('button', { name: 'Views' }).waitFor();
  await moving(0.05);
  const first = await view.screenshot();
  await until(async () => !first.equals(await view.screenshot()), 60, 'another picture');
  t.diagnostic(`robot seen moving ${Date.now() - at.commanded} ms after the command, ${Date.now() - began} ms after the page was asked for`);
  assert.equal(new URL(page.url()).searchParams.get('token'), null, 'the token stays in the address');
  assert.deepEqual(page.problems, []);
});

test('stops in the middle of a motion, by key and by button, and goes on', async () => {
  for (const stop of [() => stopKey(page).click(), () => page.keyboard.press('Escape')]) {
    await moving(0.1);
    await stop();
    await state(page).getByText('Held').waitFor();
    await atRest();
    const where = at.watcher.value(joint('shoulder_pan'));
    await page.getByRole('contentinfo').getByRole('button', { name: 'Resume' }).click();
    await running();
    assert.ok(Math.abs(where) < 7);
  }
});

test('sets the speed of everything, and tells it', async () => {
  const slider = page.getByRole('contentinfo').getByRole('slider', { name: 'Speed' });
  await slider.focus();
  await page.keyboard.press('Home');
  await until(() => at.watcher.events.status?.override === 0, 30, 'an override of 0 %');
  await atRest();
  await page.keyboard.press('End');
  await until(() => at.watcher.events.status?.override === 100, 30, 'an override of 100 %');
});

test('ends the program after a question, and starts it anew from its beginning', async () => {
  await endProgram();
  await page.getByRole('button', { name: 'Start' }).click();
  await running();
  await endProgram();
  await page.getByRole('button', { name: 'Start' }).waitFor();
});

test('jogs while a key is held, and stops when it is let go', async (t) => {
  await go(page, 'Move');
  const before = at.watcher.value(joint('shoulder_pan'));
  const tcp = page.getByRole('region', { name: 'TCP position' });
  const shown = await tcp.innerText();
  await holdKey(page.getByRole('button', { name: 'shoulder pan plus' }), () => at.watcher.speed() > 0.001, 'the first motion');
  t.diagnostic(`jog: ${Date.now() - at.pressed} ms from the press to the first frame with motion (frames come every 17 ms)`);
  await holdKey(page.getByRole('button', { name: 'shoulder pan plus' }), () => at.watcher.value(joint('shoulder_pan')) > before + 0.02, 'motion upwards');
  await page.mouse.up();
  await atRest();
  await until(async () => (await tcp.innerText()) !== shown, 30, 'another place of the TCP');
  const after = at.watcher.value(joint('shoulder_pan'));
  const from = at.watcher.time;
  await until(() => at.watcher.time > from + 0.5, 30, 'half a second');
  assert.ok(Math.abs(at.watcher.value(joint('shoulder_pan')) - after) < 1e-3, 'it stands');
  await page.getByRole('button', { name: 'shoulder pan minus' }).focus();
  await page.keyboard.down('Space');
  await until(() => at.watcher.value(joint('shoulder_pan')) < after - 0.01, 30, 'motion downwards');
  await page.keyboard.up('Space');
  await atRest();
});

test('jogs the TCP straight along an axis of the base', async () => {
  await page.getByRole('radiogroup', { name: 'Move in' }).getByText('Base').click();
  const [x, y, z] = ['x', 'y', 'z'].map((axis) => at.watcher.value(`arm/tcp/${axis}`));
  await holdKey(page.getByRole('button', { name: 'Z plus', exact: true }), () => at.watcher.value('arm/tcp/z') > z + 0.01, 'the TCP going up');
  await page.mouse.up();
  await atRest();
  assert.ok(Math.abs(at.watcher.value('arm/tcp/x') - x) < 1e-3 && Math.abs(at.watcher.value('arm/tcp/y') - y) < 1e-3, 'only up');
});

test('jogs by a step of what it says', async () => {
  const z = at.watcher.value('arm/tcp/z');
  await page.getByLabel('Step').selectOption({ label: '10 mm · 5°' });
  await page.getByRole('button', { name: 'Z minus', exact: true }).click();
  await until(() => Math.abs(at.watcher.value('arm/tcp/z') - (z - 0.01)) < 2e-4, 30, '10 mm down');
  await page.getByLabel('Step').selectOption({ label: 'While held' });
});

test('stops when the window loses the focus', async () => {
  await holdKey(page.getByRole('button', { name: 'Z plus', exact: true }), () => at.watcher.speed() > 0.01, 'motion');
  await page.evaluate(() => dispatchEvent(new Event('blur')));
  await atRest();
  const from = at.watcher.time;
  await until(() => at.watcher.time > from + 0.4, 30, 'a moment');
  assert.ok(at.watcher.speed() < 0.002, 'it stays where it is, though the key is still down');
  await page.mouse.up();
});

/** Another screen, which is closed whatever becomes of the case; then the first one has control again. */
async function withAnother(what) {
  const other = await screen(at.chrome.browser, cell.link);
  try {
    await what(other);
    assert.deepEqual(other.problems, []);
  } finally {
    await other.context().close();
  }
  await page.getByRole('main').getByRole('button', { name: 'Take control' }).click();
  await inControl(page).waitFor();
}

test('gives control to another screen that asks for it', () =>
  withAnother(async (other) => {
    await watching(other).click();
    const dialog = other.getByRole('dialog', { name: 'Who has control' });
    const asked = page.getByRole('dialog', { name: /asks for control$/ });
    // Who has not answered within 10 s has given it, too; a busy machine takes longer to press.
    await dialog.getByRole('button', { name: 'Take control' }).click();
    await asked.getByRole('button', { name: 'Give control' }).click({ timeout: 15_000 }).catch(() => undefined);
    await inControl(other).waitFor();
    await watching(page).waitFor();
    assert.ok(await page.getByRole('button', { name: 'Z plus', exact: true }).isDisabled(), 'who watches cannot jog');
    assert.ok(await stopKey(page).isEnabled(), 'who watches can stop');
  }));

test('loses control to another screen where nobody answers', () =>
  withAnother(async (other) => {
    await watching(other).click();
    const asked = page.getByRole('dialog', { name: /asks for control$/ });
    await other.getByRole('dialog', { name: 'Who has control' }).getByRole('button', { name: 'Take control' }).click();
    await inControl(other).waitFor();
    await watching(page).waitFor();
    await asked.waitFor({ state: 'detached' });
  }));

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
  at.watcher.end();
  await cell.kill();
  await page.getByRole('alert').getByText('Reconnecting…').waitFor();
  assert.ok(await page.getByRole('button', { name: 'Z plus', exact: true }).isDisabled(), 'nothing can be jogged');
  await cell.start();
  at.watcher = await new Watcher(cell).start();
  await inControl(page).waitFor();
  await state(page).getByText(/^(Program|Ready|Moving|Held)/).waitFor();
  await page.getByRole('alert').getByText('Reconnecting…').waitFor({ state: 'detached' });
});

test('shows the robot without WebGL, too', async () => {
  const plain = await screen(at.chrome.browser, cell.link, {
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
  await until(async () => !first.equals(await view.screenshot()), 60, 'another picture');
  await plain.context().close();
});

test('comes to rest within 250 ms when the browser is killed while it jogs', async (t) => {
  await endProgram();
  const full = page.getByRole('contentinfo').getByRole('button', { name: 'Full speed' });
  if (await full.isVisible()) await full.click();
  await page.getByRole('contentinfo').getByRole('button', { name: 'Reduced speed' }).waitFor();
  await go(page, 'Move');
  await page.getByRole('radiogroup', { name: 'Move in' }).getByText('Joints').click();
  await atRest();
  await page.getByRole('slider', { name: 'Jog speed' }).focus();
  await page.keyboard.press('End');
  await holdKey(page.getByRole('button', { name: 'shoulder pan plus' }), () => at.watcher.speed() > 0.05, 'motion');
  const killed = at.watcher.time;
  at.chrome.kill();
  await until(() => at.watcher.time > killed + 1, 30, 'a second');
  const moving = at.watcher.frames.filter((frame) => frame.time > killed && at.watcher.speed(frame) > 0.005);
  const stood = moving.length ? moving.at(-1).time - killed : 0;
  t.diagnostic(`killed while jogging: standing after ${Math.round(1000 * stood)} ms of cell time (frames come every 17 ms)`);
  assert.ok(stood <= 0.25, `it stood ${Math.round(1000 * stood)} ms after the kill`);
  assert.ok(await until(() => at.watcher.events.status?.holder === null, 30, 'nobody having control'));
});
