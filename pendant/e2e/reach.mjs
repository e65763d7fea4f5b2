// What a cell wants to reach is shown before it is opened, with a yes and a no; a cell that cannot be built is left again.
import assert from 'node:assert/strict';
import { existsSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { go, picture, screen, state } from './browser.mjs';
import { suite } from './suite.mjs';

const kSignals = "polyarm: signals/1\nlinks:\n  broker: {mqtt: client, host: 192.0.2.7, beyond_loopback: true, on_loss: go_on, tags: {A: {topic: a, direction: in}}}\n";
/** Beside the cell: one that wants more than its folder, and one that cannot be built. */
const others = (folder) => {
  const cell = (name, more) => {
    mkdirSync(join(folder, '..', name));
    writeFileSync(join(folder, '..', name, 'cell.yaml'), `polyarm: cell/1\nrobots:\n  arm: {model: universal_robots/ur3, hardware: mock}\n${more}`);
  };
  cell('theirs', 'signals: signals.yaml\nplugins: [native]\n');
  writeFileSync(join(folder, '../theirs/signals.yaml'), kSignals);
  cell('broken', 'program: nowhere.script\n');
};
const { at, test, endProgram } = suite({ lines: true, change: others, chain: true });
const { cell } = at;
const approved = join(cell.home, 'config/polyarm/approved');
let page;
const button = (name, on = page) => on.getByRole('button', { name, exact: true });
const project = (name, on = page) => on.getByRole('main').getByRole('button', { name });
const tab = (name, on = page) => on.getByRole('radiogroup', { name: 'Shown' }).getByText(name, { exact: true }).click();

test('what a cell wants to reach is shown before it is opened; no leaves all as it is', async () => {
  page = await at.open();
  await page.getByRole('button', { name: /^In control/ }).waitFor();
  await endProgram();
  await go(page, 'Cell');
  await tab('Projects');
  await project(/theirs/).click();
  const dialog = page.getByRole('dialog', { name: 'Open theirs?' });
  await dialog.getByRole('list', { name: 'Access outside the folder' }).getByText('Host: 192.0.2.7').waitFor();
  await picture(page, 'reach');
  await page.setViewportSize({ width: 390, height: 844 });
  await picture(page, 'reach-390');
  await page.setViewportSize({ width: 1280, height: 800 });
  await button('Cancel', dialog).click();
  await page.getByRole('banner').getByText('pick_and_place').waitFor();
  assert.ok(!existsSync(approved), 'nothing is remembered');
});

test('who only watches sees it and cannot allow it', async () => {
  const other = await screen(at.chrome.browser, cell.link);
  try {
    await go(other, 'Cell');
    await tab('Projects', other);
    assert.ok(await project(/theirs/, other).isDisabled());
  } finally {
    await other.context().close();
  }
});

test('yes allows the host for this cell, and opens it', async () => {
  await project(/theirs/).click();
  await button('Allow and open', page.getByRole('dialog')).click();
  await page.getByRole('banner').getByText('theirs').waitFor();
  assert.match(readFileSync(approved, 'utf8'), /^host\t.*theirs\t192\.0\.2\.7$/m);
  await state(page).getByText('Ready', { exact: true }).waitFor();
});

test('a cell that cannot be built says so, and another one can be opened', async () => {
  await project(/broken/).click();
  await page.getByRole('dialog').getByText('It accesses nothing outside its folder.').waitFor();
  await page.getByRole('dialog').getByRole('button', { name: 'Open', exact: true }).click();
  await state(page).getByText('No cell runs').waitFor();
  await go(page, 'Run');
  await button('Start the cell again', page.getByRole('main')).waitFor();
  await button('Open a project', page.getByRole('main')).click();
  await tab('Cell');
  await page.getByRole('main').getByText('No cell is open').waitFor();
  assert.ok(await button('Pause').isDisabled(), 'there is nothing to pause');
  assert.equal(await page.getByRole('banner').getByText('theirs').count(), 0, 'the cell before is not named');
  await picture(page, 'no-cell');
  await button('Open a project').click();
  await project(/^theirs/).click();
  await page.getByRole('dialog').getByText('Allowed', { exact: true }).waitFor();
  await page.getByRole('dialog').getByRole('button', { name: 'Open', exact: true }).click();
  await page.getByRole('banner').getByText('theirs').waitFor();
  await state(page).getByText('Ready', { exact: true }).waitFor();
});
