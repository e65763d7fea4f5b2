// A hardware component that fails again and again: what is said of it, and the ways back by the page alone.
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { go, picture, state } from './browser.mjs';
import { until } from './cell.mjs';
import { suite } from './suite.mjs';

const { at, test } = suite({
  lines: true,
  example: 'r6bot',
  change: (folder) => {
    writeFileSync(join(folder, 'cell.yaml'), 'polyarm: cell/1\nrobots:\n  arm: {model: r6bot.urdf, hardware: mock, parameters: {inject: read_error@25000}}\nprogram: job\n');
    writeFileSync(join(folder, 'job.script'), 'while true\n  wait 1s\nend\n');
  },
});
let page;
const main = () => page.getByRole('main');
const tab = (name) => main().getByRole('radiogroup').first().getByText(name).click();

test('a component that fails is said to have, where and why, with what to do', async () => {
  page = await at.open();
  await page.getByRole('button', { name: /^In control/ }).waitFor();
  await until(() => at.watcher.events.status?.state === 'fault', 150, 'the fault');
  await state(page).getByText('A hardware component failed').waitFor();
  await go(page, 'Health');
  await tab(/^Alarms/);
  await main().getByRole('heading', { name: /^A hardware component failed: R6Bot/ }).waitFor();
  await main().getByText(/Press Recover/).waitFor();
  await picture(page, 'failed');
});

test('it is recovered, its controllers start after a question, and the cell goes on', async () => {
  await tab('Hardware');
  await main().getByText('Failed: A hardware component failed').waitFor();
  assert.equal(await main().getByRole('button', { name: 'Activate' }).count(), 0);
  await main().getByRole('button', { name: 'Recover' }).click();
  const question = page.getByRole('dialog', { name: 'Start its controllers again?' });
  await question.getByText(/R6Bot is configured and activated again/).waitFor();
  await question.getByRole('button', { name: 'Start' }).click();
  await main().getByText(/^Failed: /).waitFor({ state: 'detached' });
  await at.bar().getByRole('button', { name: 'Recover' }).click();
  await at.bar().getByRole('button', { name: 'Resume' }).click();
  await state(page).getByText(/^(Ready|Program)/).waitFor();
  await tab('Controllers');
  await until(async () => (await main().getByText('Active', { exact: true }).count()) >= 2, 60, 'two active controllers');
  assert.deepEqual(page.problems, []);
});

test('the bar alone leads back, too: each step that comes next is its one key', async () => {
  const key = (name) => at.bar().getByRole('button', { name, exact: true });
  const strip = page.getByRole('alert', { name: 'Alarm' });
  await until(() => at.watcher.events.status?.state === 'fault', 150, 'the next fault');
  await go(page, 'Move');
  await main().getByText('Press Recover first: the cell is in a fault.').waitFor();
  await strip.getByText(/Press Recover/).waitFor();
  await key('Recover').click();
  await strip.getByText(/Press Activate, then Resume/).waitFor();
  assert.equal(await strip.getByText(/Press Recover/).count(), 0, 'what is done is not asked for again');
  await main().getByText('Activate the hardware first.').waitFor();
  await picture(page, 'recovered');
  await key('Activate').click();
  await page.getByRole('dialog').getByRole('button', { name: 'Activate' }).click();
  await key('Resume').click();
  await until(() => at.watcher.events.status?.state === 'running', 30, 'running');
  await until(() => at.watcher.events.status.inactive.length === 0, 30, 'everything active');
  await state(page).getByText(/^Program/).waitFor();
  await strip.waitFor({ state: 'detached' });
  assert.deepEqual(page.problems, []);
});
