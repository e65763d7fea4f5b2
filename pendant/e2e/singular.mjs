// Arms that stretch out, turn their wrists into line or have a joint to spare: entering slows down and says so, leaving always works.
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { go, picture } from './browser.mjs';
import { until } from './cell.mjs';
import { suite } from './suite.mjs';

const kArms = { arm: 'universal_robots/ur5e', seven: 'franka/fer_panda' };
const cellOf = (folder) =>
  writeFileSync(join(folder, 'cell.yaml'), `polyarm: cell/1\nprofile: reduced\nrobots:\n  arm: {model: ${kArms.arm}, hardware: mock}\n  seven: {model: ${kArms.seven}, hardware: mock, at: [0, 2, 0]}\n`);
const { at, test, arrive, atRest, holdKey } = suite({ lines: true, example: null, change: cellOf });
let page;
const main = () => page.getByRole('main');
const button = (name) => page.getByRole('button', { name, exact: true });
const mode = (name) => page.getByRole('radiogroup', { name: 'Move in' }).getByText(name, { exact: true }).click();
const tcp = (robot) => ['x', 'y', 'z'].map((axis) => at.watcher.value(`${robot}/tcp/${axis}`));
const away = (robot, from) => Math.hypot(...tcp(robot).map((v, i) => v - from[i]));

/** Brings the joints there (rad), as a person does who types them in and holds the key. */
async function goTo(values) {
  await mode('Joints');
  await button('Go to…').click();
  const dialog = page.getByRole('dialog', { name: 'Go to' });
  await dialog.getByText('Joint values').click();
  for (const [name, value] of Object.entries(values)) await dialog.getByRole('textbox', { name, exact: true }).fill(String((value * 180) / Math.PI));
  await arrive();
  await dialog.getByRole('button', { name: 'Close' }).click();
}

/** In both directions along every axis: one of each pair leads out at least, and every way that is taken can be gone back. */
async function leaves(robot, keys) {
  const moved = {};
  for (const key of keys) {
    const from = tcp(robot);
    await button(key).hover();
    await page.mouse.down();
    const began = at.watcher.time;
    await until(() => away(robot, from) > 0.01 || at.watcher.time > began + 3, 60, 'three seconds');
    await page.mouse.up();
    await atRest();
    moved[key] = away(robot, from);
  }
  return moved;
}

test('says that a stretched arm stands in a singularity, and lets the TCP out of it', async () => {
  page = await at.open();
  await page.getByRole('button', { name: /^In control/ }).waitFor();
  await go(page, 'Move');
  await page.getByRole('radiogroup', { name: 'Robot' }).getByText('arm', { exact: true }).click();
  await page.getByRole('slider', { name: 'Jog speed' }).fill('100');
  await goTo({ 'shoulder pan': 0, 'shoulder lift': -0.5, elbow: 0, 'wrist 1': -1, 'wrist 2': -1.2, 'wrist 3': 0 });
  await mode('Base');
  await main().getByText(/^At a singularity/).waitFor();
  await picture(page, 'stretched');
  const moved = await leaves('arm', ['X plus', 'X minus', 'Z plus', 'Z minus']);
  assert.ok(Math.max(moved['X plus'], moved['X minus']) > 0.009, JSON.stringify(moved));
});

test('slows down on the way into a stretched elbow, says so, and goes back', async () => {
  await goTo({ 'shoulder pan': 0, 'shoulder lift': -0.8, elbow: 0.5, 'wrist 1': -1.2, 'wrist 2': -1.2, 'wrist 3': 0 });
  await mode('Base');
  const from = tcp('arm');
  const words = main().getByText(/^Held back by a singularity/);
  const out = Math.hypot(from[0], from[1]);
  await holdKey(button(Math.abs(from[0]) > Math.abs(from[1]) ? (from[0] > 0 ? 'X plus' : 'X minus') : from[1] > 0 ? 'Y plus' : 'Y minus'), () => words.isVisible(), 'what holds it back');
  await picture(page, 'entering');
  await page.mouse.up();
  await atRest();
  assert.ok(Math.hypot(...tcp('arm').slice(0, 2)) > out);
  const there = tcp('arm');
  await holdKey(button(Math.abs(from[0]) > Math.abs(from[1]) ? (from[0] > 0 ? 'X minus' : 'X plus') : from[1] > 0 ? 'Y minus' : 'Y plus'), () => away('arm', there) > 0.03, 'the way back');
  await page.mouse.up();
  await atRest();
});

test('leaves a wrist whose axes lie in line', async () => {
  await goTo({ 'shoulder pan': 0, 'shoulder lift': -1.2, elbow: 1.4, 'wrist 1': -1.2, 'wrist 2': 0, 'wrist 3': 0 });
  await mode('Tool');
  await main().getByText(/^At a singularity/).waitFor();
  const moved = await leaves('arm', ['X plus', 'X minus', 'Y plus', 'Y minus', 'Z plus', 'Z minus']);
  assert.ok(Object.values(moved).filter((way) => way > 0.009).length >= 4, JSON.stringify(moved));
});

test('moves an arm of seven joints by its keys, out of a stretched pose too', async () => {
  await page.getByRole('radiogroup', { name: 'Robot' }).getByText('seven', { exact: true }).click();
  await mode('Joints');
  assert.ok(await page.getByRole('group', { name: 'Jog keys' }).getByRole('button').count() >= 14);
  await button('Keyboard').click();
  await page.getByRole('button', { name: 'Keyboard', pressed: true }).waitFor();
  const seventh = () => at.watcher.value([...at.watcher.places.keys()].filter((name) => /^seven\/.*joint7\/position$/.test(name))[0]);
  const before = seventh();
  await page.keyboard.down('u');
  await until(() => seventh() > before + 0.03, 60, 'the seventh joint');
  await page.keyboard.up('u');
  await atRest();
  await button('Keyboard').click();
  await picture(page, 'seven');
  await mode('Base');
  const moved = await leaves('seven', ['X plus', 'X minus', 'Y plus', 'Y minus', 'Z plus', 'Z minus']);
  assert.ok(Object.values(moved).every((way) => way > 0.009), JSON.stringify(moved));
  assert.deepEqual(page.problems, []);
});
