// An arm on a base that drives: both are moved by hand, the view and the frames go along, points go with the base, a program drives and picks.
import assert from 'node:assert/strict';
import { go, picture } from './browser.mjs';
import { until } from './cell.mjs';
import { suite } from './suite.mjs';

const { at, test, arrive, atRest, endProgram, holdKey } = suite({ example: 'carrier', chain: true });
let page;
const main = () => page.getByRole('main');
const button = (name, on = page) => on.getByRole('button', { name, exact: true });
const base = (axis) => at.watcher.value(`base/base/position.${axis}`);
const seat = (axis) => at.watcher.value(`arm/base/position.${axis}`);
const place = (of) => ['x', 'y', 'z'].map(of);
const away = (a, b) => Math.hypot(...a.map((v, i) => v - b[i]));
const robot = (name) => page.getByRole('radiogroup', { name: 'Robot' }).getByText(name, { exact: true }).click();
const stands = async () => {
  await atRest();
  const from = at.watcher.time;
  await until(() => at.watcher.time > from + 0.5, 60, 'a moment');
};

test('drives the base by its keys as long as they are held, and the arm goes along', async () => {
  page = await at.open();
  await page.getByRole('button', { name: /^In control/ }).waitFor();
  await endProgram();
  await go(page, 'Move');
  await robot('base');
  await page.getByRole('radiogroup', { name: 'Move in' }).getByText('Drive', { exact: true }).click();
  const view = page.getByRole('region', { name: 'Robot view' });
  const first = await view.screenshot();
  const [start, ahead] = [place(base), away(place(seat), place(base))];
  await holdKey(button('Ahead minus'), () => away(place(base), start) > 0.05, 'the base driving back');
  await page.mouse.up();
  await stands();
  const rest = place(base);
  await stands();
  assert.ok(away(place(base), rest) < 0.01, 'it stays');
  assert.ok(Math.abs(away(place(seat), place(base)) - ahead) < 0.005, 'the arm goes along');
  await until(async () => !first.equals(await view.screenshot()), 30, 'another picture');
  const heading = () => Math.atan2(seat('y') - base('y'), seat('x') - base('x'));
  const looked = heading();
  await holdKey(button('Left plus'), () => Math.sin(heading() - looked) > 0.1, 'the base turning to the left');
  await page.evaluate(() => dispatchEvent(new Event('blur')));
  await stands();
  await page.mouse.up();
  await picture(page, 'carrier-driven');
});

test('moves the arm that stands on it, and teaches a point that goes with it', async () => {
  await robot('arm');
  await page.getByRole('radiogroup', { name: 'Move in' }).getByText('Base', { exact: true }).click();
  const z = at.watcher.value('arm/tcp/z');
  await holdKey(button('Z plus'), () => at.watcher.value('arm/tcp/z') > z + 0.02, 'the TCP going up');
  await page.mouse.up();
  await atRest();
  await go(page, 'Points');
  await page.getByRole('textbox', { name: 'Name' }).first().fill('Here');
  await button('Teach').click();
  await page.getByRole('group', { name: 'Points' }).getByRole('button', { name: /^Here / }).waitFor();
  await picture(page, 'carrier-taught');
  const taught = ['x', 'y', 'z'].map((axis) => at.watcher.value(`arm/tcp/${axis}`));
  await go(page, 'Move');
  await holdKey(button('Z minus'), () => at.watcher.value('arm/tcp/z') < taught[2] - 0.02, 'the TCP going down');
  await page.mouse.up();
  await atRest();
  await robot('base');
  await page.getByRole('radiogroup', { name: 'Move in' }).getByText('Drive', { exact: true }).click();
  const start = place(base);
  await holdKey(button('Ahead plus'), () => away(place(base), start) > 0.03, 'the base driving on');
  await page.mouse.up();
  await stands();
  await robot('arm');
  await button('Go to…').click();
  const dialog = page.getByRole('dialog', { name: 'Go to' });
  await dialog.getByRole('combobox', { name: 'Point' }).selectOption('Here');
  await arrive();
  await button('Close', dialog).click();
  ['x', 'y', 'z'].forEach((axis, i) => assert.ok(Math.abs(at.watcher.value(`arm/tcp/${axis}`) - taught[i]) < 1e-3, 'as the arm has it in front of itself'));
});

test('runs the program that drives, picks and puts down', async () => {
  await go(page, 'Cell');
  await button('Reset the scene').click();
  await page.getByRole('dialog').getByRole('button', { name: 'Reset the scene' }).click();
  await page.getByRole('region', { name: 'Messages' }).getByText('The scene is as at the start').first().waitFor();
  await go(page, 'Run');
  await button('Start').click();
  await until(() => at.watcher.value('arm/tool/part_present') > 0.5, 120, 'a box in the cup');
  await until(() => base('y') > 0.9, 180, 'the base at the other table');
  await picture(page, 'carrier-there');
  await until(() => at.watcher.value('arm/tool/part_present') < 0.5, 120, 'the box put down');
  await endProgram();
  assert.deepEqual(page.problems, []);
});
