// From the simulation to an arm on its wire and back: the driver is the real one, and behind its line are servos of our own.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { existsSync, readFileSync, readlinkSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after } from 'node:test';
import { go, picture, screen, state, stopKey } from './browser.mjs';
import { until } from './cell.mjs';
import { suite } from './suite.mjs';

const servos = process.env.POLYARM_SERVOS;
let wire;
const onAWire = (folder) => {
  const line = join(folder, 'bus');
  wire = spawn(servos, [line], { stdio: ['pipe', 'ignore', 'inherit'] });
  for (let i = 0; i < 600 && !existsSync(line); ++i) Atomics.wait(new Int32Array(new SharedArrayBuffer(4)), 0, 0, 100);
  const file = join(folder, 'cell.yaml');
  const text = readFileSync(file, 'utf8').replace('hardware: mock', 'hardware: feetech').replace('/dev/ttyACM0', `${readlinkSync(line)}\n      answer_timeout_ms: 1000`);
  writeFileSync(file, text.replace(/^send:\n.*\n/m, ''));
  writeFileSync(join(folder, 'calibration.yaml'), 'polyarm: servo_calibration/1\nfamily: feetech\njoints:\n  wrist_roll: {id: 5, direction: -1}\n');
};
const { at, test, holdKey, atRest } = suite({ lines: true, example: 'so101', change: onAWire, chain: true, skip: servos ? false : 'no servos: POLYARM_SERVOS names none' });
after(() => wire?.stdin.end());

let page;
const button = (name, on = page) => on.getByRole('button', { name, exact: true });
const bar = () => page.getByRole('contentinfo');
const joint = () => at.watcher.value('arm/wrist_roll/position');
const mode = (name) => page.getByRole('radiogroup', { name: 'Simulate or connect' }).getByText(name);

test('what would be connected is shown, and comes up held and disarmed', async () => {
  page = await at.open();
  await button(/^In control/).waitFor();
  await go(page, 'Cell');
  await mode('Real robot').click();
  const dialog = page.getByRole('dialog', { name: 'Connect to the real robot?' });
  await dialog.getByText('feetech').first().waitFor();
  await dialog.getByText('present').waitFor();
  await picture(page, 'connecting');
  await button('Connect', dialog).click();
  await bar().getByText('Real robot', { exact: true }).waitFor();
  await state(page).getByText('Held').waitFor();
  await until(() => at.watcher.events.status?.simulated === false, 60, 'the real robot');
  const { state: word, armed } = at.watcher.events.status;
  assert.deepEqual([word, armed], ['held', false]);
  await picture(page, 'connected');
  const before = joint();
  await go(page, 'Move');
  const from = at.watcher.time;
  await until(() => at.watcher.time > from + 0.5, 60, 'half a second');
  assert.ok(Math.abs(joint() - before) < 1e-3, 'nothing moves');
});

test('Stop keeps its corner on a phone, too, whatever stands beside it', async () => {
  const corner = async () => Object.values(await stopKey(page).boundingBox()).map(Math.round).join();
  const places = new Set();
  for (const language of ['en-GB', 'es-ES']) {
    const phone = await screen(at.chrome.browser, at.cell.link, { viewport: { width: 390, height: 844 }, locale: language });
    try {
      const stop = phone.getByRole('button', { name: /^(Stop|Parar) / });
      await stop.waitFor();
      await phone.getByText(/^(Not armed|No habilitado)$/).first().waitFor();
      places.add(Object.values(await stop.boundingBox()).map(Math.round).join());
      const key = phone.getByRole('button', { name: /^(Compare and arm|Comparar y habilitar)$/ });
      assert.ok((await key.boundingBox()).width > 150, 'the key beside it is as wide as ever');
      assert.ok(await key.evaluate((each) => each.scrollWidth <= each.clientWidth), 'and its words fit');
    } finally {
      await phone.context().close();
    }
  }
  await page.setViewportSize({ width: 390, height: 844 });
  places.add(await corner());
  assert.equal(places.size, 1, [...places].join(' | '));
  const box = await stopKey(page).boundingBox();
  assert.equal(Math.round(box.x + box.width), 380, 'at the right');
  await page.setViewportSize({ width: 1280, height: 800 });
});

test('a person compares the joints, arms, resumes and moves it', async () => {
  await go(page, 'Cell');
  await button('Compare and arm', page.getByRole('main')).click();
  const dialog = page.getByRole('dialog', { name: 'Compare and arm' });
  await dialog.getByRole('rowheader').nth(5).waitFor();
  assert.equal(await dialog.getByRole('rowheader').count(), 6);
  await picture(page, 'comparing');
  await dialog.getByRole('button').last().click();
  await until(() => at.watcher.events.status?.armed, 60, 'armed');
  assert.equal(at.watcher.events.status.state, 'held', 'still held');
  await button('Resume', bar()).click();
  await until(() => at.watcher.events.status?.state === 'running', 60, 'running');
  await go(page, 'Move');
  await page.getByRole('radiogroup', { name: 'Move in' }).getByText('Joints').click();
  const before = joint();
  await holdKey(button('wrist roll plus'), () => Math.abs(joint() - before) > 0.05, 'the servo moving');
  await page.mouse.up();
  await atRest();
});

test('goes back to the simulation', async () => {
  await go(page, 'Cell');
  await mode('Simulation').click();
  await page.getByRole('dialog').getByRole('button').last().click();
  await until(() => at.watcher.events.status?.simulated, 60, 'the simulation');
  await bar().getByText('Simulation', { exact: true }).waitFor();
  assert.deepEqual(page.problems, []);
});
