// A program that asks: an answer belongs to the question that was shown, however often and whenever it is given.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { go, picture, state } from './browser.mjs';
import { until } from './cell.mjs';
import { suite } from './suite.mjs';

const programs = (folder) => {
  const file = join(folder, 'cell.yaml');
  writeFileSync(file, readFileSync(file, 'utf8').replace(/^program:.*$/m, 'program: asks.script').replace(/^plc:.*\n/m, ''));
  writeFileSync(join(folder, 'asks.script'), 'let n = ask("How many beads?", 2)\nwait user "Stand back"\nhold "look at bead {n}"\nwait 1s\nwait user "Last one"\n');
};
const { at, test } = suite({ lines: true, change: programs, chain: true });
let page;
const button = (name, on = page) => on.getByRole('button', { name, exact: true });
const question = () => page.getByRole('alert', { name: /^(The program asks|El programa pregunta)$/ });
const asks = (text) => question().getByText(text, { exact: true }).waitFor();

test('the default and a refused answer are explained', async () => {
  page = await at.open();
  await page.getByRole('button', { name: /^In control/ }).waitFor();
  await asks('How many beads?');
  await question().getByText('No text means 2').waitFor();
  await question().getByRole('textbox').fill('many');
  await button('Confirm', question()).click();
  await question().getByText('This answer does not fit. Write, for example, 2').waitFor();
});

test('an answer during a hold is taken once; the next question is not answered by it', async () => {
  await button('Pause', at.bar()).click();
  await state(page).getByText('Held').waitFor();
  await question().getByRole('textbox').fill('3');
  await button('Confirm', question()).click();
  await question().getByText('Answered. The program goes on after Resume.').waitFor();
  assert.ok(await button('Confirm', question()).isDisabled());
  await picture(page, 'answered');
  await button('Resume', at.bar()).click();
  await asks('Stand back');
});

test('two presses in a row answer one question', async () => {
  await until(() => button('Confirm', question()).isEnabled(), 10, 'the key');
  await button('Confirm', question()).dblclick();
  await state(page).getByText(/look at bead 3/).waitFor();
  await question().waitFor({ state: 'detached' });
});

test('the alarm of a hold that is over goes', async () => {
  const strip = page.getByRole('alert', { name: 'Alarm' });
  await strip.getByText(/The program holds the cell: look at bead 3/).waitFor();
  await go(page, 'Move');
  await strip.getByText(/Press Resume/).waitFor();
  await button('Resume', at.bar()).click();
  await asks('Last one');
  await strip.waitFor({ state: 'detached' });
  assert.deepEqual(page.problems, []);
});
