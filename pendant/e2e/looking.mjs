// Curves read at the cursor, looked into and taken along; language and colours changed while the page is open.
import assert from 'node:assert/strict';
import { readFileSync, statSync } from 'node:fs';
import { join } from 'node:path';
import { go, picture } from './browser.mjs';
import { until } from './cell.mjs';
import { suite } from './suite.mjs';

const { at, test } = suite();
let page;
const main = () => page.getByRole('main');
const button = (name, on = page) => on.getByRole('button', { name, exact: true });
const value = async (name) => Number((await main().getByRole('status', { name, exact: true }).innerText()).replace('−', '-').replace(',', '.').split(' ')[0]);
// As the page names curves; their signals are arm/elbow_joint/position and …/command_position.
const kMeasured = 'elbow, measured';
const kCommanded = 'elbow, commanded';

test('shows a joint as commanded and as measured while it moves, and what both were at the cursor', async () => {
  page = await at.open();
  await page.getByRole('button', { name: /^In control/ }).waitFor();
  await go(page, 'Plots');
  await button('Choose curves').click();
  await page.getByRole('dialog').getByRole('button', { name: 'elbow', exact: true }).click();
  await page.getByRole('dialog').getByRole('button', { name: 'Close' }).click();
  const picture1 = main().getByRole('img', { name: new RegExp(kMeasured) });
  await picture1.waitFor();
  // Enough of it to look into: some seconds in which the joint was moved.
  const first = await value(kMeasured);
  await until(async () => Math.abs((await value(kMeasured)) - first) > 5, 120, 'the joint moving');
  const from = at.watcher.time;
  await until(() => at.watcher.time > from + 3, 60, 'some seconds');
  await button('Freeze').click();
  await button('Follow').waitFor();
  const box = await picture1.boundingBox();
  const seen = [];
  for (let i = 0; i <= 20; ++i) {
    await page.mouse.move(box.x + 90 + ((box.width - 110) * i) / 20, box.y + box.height / 2);
    await page.waitForTimeout(150);
    const told = [await value(kMeasured), await value(kCommanded)];
    if (told.every(Number.isFinite)) seen.push(told);
  }
  await picture(page, 'cursor');
  const measured = seen.map(([each]) => each);
  assert.ok(Math.max(...measured) - Math.min(...measured) > 3, `${measured} are not other values at other places`);
  for (const [is, asked] of seen) assert.ok(Math.abs(is - asked) < 3, `${is} measured, ${asked} commanded`);
});

test('zooms by dragging and exports what is shown', async () => {
  const canvas = main().getByRole('img', { name: new RegExp(kMeasured) });
  const rows = async () => {
    const [download] = await Promise.all([page.waitForEvent('download'), button('Export CSV').click()]);
    const file = join(at.cell.home, 'curves.csv');
    await download.saveAs(file);
    return readFileSync(file, 'utf8').trim().split('\n');
  };
  const all = await rows();
  assert.match(all[0], /^time \[s\],arm\/elbow_joint\/position \[°\],arm\/elbow_joint\/command_position \[°\]$/);
  const box = await canvas.boundingBox();
  await page.mouse.move(box.x + box.width * 0.6, box.y + 80);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width * 0.7, box.y + 80, { steps: 5 });
  await page.mouse.move(box.x + box.width * 0.8, box.y + 80, { steps: 5 });
  await page.mouse.up();
  await page.waitForTimeout(300);
  await picture(page, 'zoomed');
  const part = await rows();
  const span = (lines) => Number(lines.at(-1).split(',')[0]) - Number(lines[1].split(',')[0]);
  // A fifth of the width is dragged over, of which there may not be curves everywhere yet.
  assert.ok(span(part) > 0.5 && span(part) < span(all) - 1, `${span(part)} of ${span(all)} s`);
  for (const line of part.slice(1)) assert.equal(line.split(',').length, 3);
  await button('Zoom in').click();
  const less = await rows();
  assert.ok(span(less) < 0.7 * span(part), `${span(less)} of ${span(part)} s`);
});

test('records the cell, and says where the recording is', async () => {
  await button('Record').click();
  await main().getByText(/^Recording .+\.mcap: /).waitFor();
  await button('Stop recording').click();
  const told = page.getByRole('region', { name: 'Messages' });
  await told.getByText(/^Recorded .+\.mcap: \d/).waitFor();
  const name = /Recorded (.+\.mcap):/.exec(await told.innerText())[1];
  assert.ok(statSync(join(at.cell.folder, '.state/recordings', name)).size > 0);
  await button('Record').waitFor();
});

test('changes language and colours at once, and keeps both', async () => {
  await page.getByRole('button', { name: 'Settings', exact: true }).click();
  const dialog = page.getByRole('dialog');
  const back = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const dark = await back();
  await dialog.getByText('Light', { exact: true }).click();
  await until(async () => (await back()) !== dark, 10, 'another background');
  await dialog.getByRole('combobox', { name: 'Language' }).selectOption('es');
  await dialog.getByText('Claro', { exact: true }).waitFor();
  await page.getByRole('link', { name: 'Ejecutar' }).waitFor({ state: 'attached' });
  assert.equal(await page.evaluate(() => document.documentElement.lang), 'es');
  await dialog.getByRole('button', { name: 'Cerrar', exact: true }).click();
  await page.reload();
  await page.getByRole('link', { name: 'Ejecutar' }).waitFor();
  assert.notEqual(await back(), dark);
  // Names of files, tags and interfaces are nobody's language; what the page says itself is.
  const english = /\b(the|is|are|was|with|world|number|boolean|none|of)\b/i;
  for (const name of ['Mover', 'Puntos', 'Señales', 'Gráficas', 'Diagnóstico', 'Celda']) {
    await page.getByRole('link', { name, exact: true }).click();
    await page.getByRole('main', { name, exact: true }).waitFor();
    await page.getByRole('main').getByText('Cargando…').first().waitFor({ state: 'detached' });
    if (name === 'Mover') await page.getByRole('radiogroup', { name: 'Mover en' }).getByText('Mundo', { exact: true }).click();
    await picture(page, `es-${name}`);
    assert.doesNotMatch(await page.getByRole('main').innerText(), english, name);
  }
  assert.deepEqual(page.problems, []);
});
