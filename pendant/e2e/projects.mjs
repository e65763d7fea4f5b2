// What a person does with whole cells: one zip out and back in, under a name of its own; a copy; opening another.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { go, state } from './browser.mjs';
import { suite } from './suite.mjs';

const { at, test, endProgram } = suite({ lines: true, chain: true });
const { cell } = at;
const zip = join(cell.home, 'of-the-browser.zip');
let page;
const button = (name, on = page) => on.getByRole('button', { name, exact: true });
const said = (text) => page.getByRole('region', { name: 'Messages' }).getByText(text).first().waitFor();
const points = (project) => readFileSync(join(cell.home, project, 'PAPpoints.points'), 'utf8');
const project = (name) => page.getByRole('main').getByRole('button', { name });
const tab = (name) => page.getByRole('radiogroup', { name: 'Shown' }).getByText(name, { exact: true }).click();

/** Chooses the backup; the dialog that asks for a name. */
async function choose(name = 'pick_and_place (1).zip') {
  const asked = page.waitForEvent('filechooser');
  await button('Restore a backup').click();
  await (await asked).setFiles({ name, mimeType: 'application/zip', buffer: readFileSync(zip) });
  const dialog = page.getByRole('dialog', { name: 'Restore a backup' });
  await dialog.getByText(name).waitFor();
  return dialog;
}

test('backs the cell up as one zip that bears its name', async () => {
  page = await at.open();
  await page.getByRole('button', { name: /^In control/ }).waitFor();
  await endProgram();
  await go(page, 'Cell');
  await tab('Projects');
  const coming = page.waitForEvent('download');
  await page.getByRole('link', { name: 'Back up (zip)' }).click();
  const file = await coming;
  assert.equal(file.suggestedFilename(), 'pick_and_place.zip');
  await file.saveAs(zip);
});

test('restores it beside what has changed since, under a name that is free', async () => {
  const before = points('pick_and_place');
  await go(page, 'Points');
  await page.getByRole('region', { name: 'Teach a point' }).getByRole('textbox', { name: 'Name' }).fill('Later');
  await button('Teach').click();
  await said('Later is taught');
  await go(page, 'Cell');
  await tab('Projects');
  const dialog = await choose();
  const name = dialog.getByRole('textbox', { name: 'Name' });
  assert.equal(await name.inputValue(), 'pick_and_place2');
  await name.fill('pick_and_place');
  await dialog.getByText('A project of that name exists').waitFor();
  assert.ok(await button('Restore', dialog).isDisabled());
  await name.fill('as_before');
  await button('Restore', dialog).click();
  await said('as_before is restored as a new project');
  assert.equal(points('as_before'), before);
  assert.match(points('pick_and_place'), /^Name: Later$/m);
});

test('opens what was restored, and the same backup can be restored once more', async () => {
  await project(/^Pick and place \(as_before\)/).click();
  await page.getByRole('dialog').getByRole('button', { name: 'Open' }).click();
  await said('as_before is open');
  await page.getByRole('banner').getByText('as_before').waitFor();
  await state(page).getByText('Ready', { exact: true }).waitFor();
  const again = await choose();
  await button('Restore', again).click();
  await said('pick_and_place2 is restored as a new project');
  await go(page, 'Points');
  const list = page.getByRole('group', { name: 'Points' });
  await list.getByRole('button', { name: /^Pick / }).waitFor();
  await list.getByRole('button', { name: /^Later / }).waitFor({ state: 'detached' });
});

test('saves a copy under another name', async () => {
  await go(page, 'Cell');
  await tab('Projects');
  await button('Save as a new project').click();
  const dialog = page.getByRole('dialog', { name: 'Save as a new project' });
  await dialog.getByRole('textbox', { name: 'Name' }).fill('mine');
  await dialog.getByRole('button').last().click();
  await project(/^Pick and place \(mine\)/).waitFor();
  assert.equal(points('data/polyarm/cells/mine'), points('as_before'));
  assert.deepEqual(page.problems, []);
});
