// A frame and a tool from places that are touched, the robot moved between them by the page, and used by a program.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { go, picture } from './browser.mjs';
import { until } from './cell.mjs';
import { suite } from './suite.mjs';

const { at, test, atRest } = suite({
  lines: true,
  example: 'r6bot',
  change: (folder) => {
    writeFileSync(join(folder, 'cell.yaml'), 'polyarm: cell/1\nrobots:\n  arm: {model: universal_robots/ur5e, hardware: mock}\nprogram: job\n');
    writeFileSync(join(folder, 'work.data'), 'Name: PointFile\nText: places\n');
    writeFileSync(join(folder, 'places.points'), 'Pose: RPY\nName: Cup\nPoint: 0, 0, 0.1, 0, 0, 0; frame = "tool0"\nName: Rest\nPoint: 0.4, 0.1, 0.3, 3.14159, 0, 0\n');
    writeFileSync(join(folder, 'job.script'), 'load work\nmovej joints(0deg, -70deg, 100deg, -120deg, -90deg, 0deg)\n');
  },
  chain: true,
});
let page;
const button = (name, on = page) => on.getByRole('button', { name, exact: true });
const said = (text) => page.getByRole('region', { name: 'Messages' }).getByText(text).first().waitFor();
const tcp = (axis) => at.watcher.value(`arm/tcp/${axis}`);
/** By steps of 10 mm along an axis of the base. */
const step = async (axis, key, times) => {
  for (let i = 0; i < times; ++i) {
    const before = tcp(axis);
    await button(key).click();
    await until(() => Math.abs(tcp(axis) - before) > 0.0095, 30, `a step along ${axis}`);
    await atRest();
  }
};

test('a frame is taught from three places, the robot moved between them', async () => {
  page = await at.open();
  await page.getByRole('button', { name: /^In control/ }).waitFor();
  await until(() => at.watcher.events.status?.program?.ended, 90, 'the end of the program');
  await go(page, 'Points');
  await button('Teach a frame').click();
  const wizard = page.getByRole('dialog', { name: 'Teach a frame' });
  await button('Take origin', wizard).click();
  await button('Take again', wizard).waitFor();
  await picture(page, 'frame-1');
  const origin = ['x', 'y', 'z'].map(tcp);
  await button('Move the robot', wizard).click();
  await page.getByText('1 of 3 touched').waitFor();
  await page.getByRole('radiogroup', { name: 'Move in' }).getByText('Base').click();
  const steps = page.getByRole('combobox', { name: 'Step' });
  await steps.selectOption({ label: (await steps.getByRole('option').allTextContents()).findLast((each) => /^10 mm/.test(each)) });
  await picture(page, 'frame-2');
  await step('x', 'X plus', 3);
  await button('Touch here').click();
  await button('Take a place on the x axis', wizard).click();
  await button('Move the robot', wizard).click();
  await step('y', 'Y plus', 3);
  await button('Touch here').click();
  await button('Take a place on the side of y', wizard).click();
  await wizard.getByRole('region', { name: 'Result' }).getByText(/30\.0 mm/).first().waitFor();
  await picture(page, 'frame-3');
  await wizard.getByRole('textbox', { name: 'Name of the frame' }).fill('Bench');
  await button('Save frame', wizard).click();
  await said(/Bench/);
  assert.match(readFileSync(join(at.cell.folder, 'places.points'), 'utf8') + readFileSync(join(at.cell.folder, 'work.data'), 'utf8'), /Name: Bench/);
  at.origin = origin;
});

test('the frame that was saved leads a program', async () => {
  await at.watcher.request('program').catch(() => undefined);
  writeFileSync(join(at.cell.folder, 'job.script'), 'load work\nuse frame Bench\nmovel pose(0mm, 0mm, 0mm, 180deg, 0deg, -90deg)\n');
  await go(page, 'Program');
  await button('Start').click();
  await until(() => Math.hypot(...['x', 'y', 'z'].map((axis, i) => tcp(axis) - at.origin[i])) < 0.002, 60, 'the TCP at the origin of the frame');
  assert.deepEqual(page.problems, []);
});

test('a tool stands among the tools, and is no place to go to', async () => {
  await go(page, 'Points');
  const tools = page.getByRole('region', { name: 'Tools' });
  await tools.getByRole('button', { name: /^Cup/ }).click();
  await page.getByText('A tool: the pose of its TCP on the flange.').waitFor();
  assert.equal(await tools.getByRole('listitem').count(), 1);
  assert.equal(await button('Re-teach position').count(), 0);
  await picture(page, 'tool');
  await page.getByRole('button', { name: /^Rest/ }).click();
  await button('Re-teach position').waitFor();
});
