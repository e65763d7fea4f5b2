// What Start begins on the Run page: the cell's program as it was saved last, or the one that is open on the Program page.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { go, picture } from './browser.mjs';
import { until } from './cell.mjs';
import { suite } from './suite.mjs';

/** A program that takes the first joint there, degrees. */
const kTo = (degrees) => `movej joints(${degrees}deg, -90deg, 0deg, 0deg, 0deg, 0deg)\n`;
const { at, test } = suite({
  lines: true,
  example: 'r6bot',
  chain: true,
  change: (folder) => {
    writeFileSync(join(folder, 'cell.yaml'), 'polyarm: cell/1\nrobots:\n  arm: {model: r6bot.urdf, hardware: mock}\nprogram: job\n');
    writeFileSync(join(folder, 'job.script'), kTo(5));
    writeFileSync(join(folder, 'other.script'), kTo(20));
  },
});
let page;
const button = (name) => page.getByRole('button', { name, exact: true });
const editor = () => page.getByRole('textbox', { name: 'Text of the program' });
const choice = () => page.getByRole('radiogroup', { name: 'Start begins' });
const write = async (text) => {
  await editor().click();
  await page.keyboard.press('Control+A');
  await page.keyboard.insertText(text.trimEnd());
};
const saved = (name) => readFileSync(join(at.cell.folder, name), 'utf8').trimEnd();
/** Presses Start, and `file` takes the first joint there. */
const startsTo = async (file, degrees) => {
  const there = () => Math.abs((at.watcher.value('arm/joint_1/position') * 180) / Math.PI - degrees) < 0.01;
  const arrived = () => {
    const it = at.watcher.events.status?.program;
    return it?.ended && it.file.endsWith(file) && there();
  };
  await button('Start').click();
  await until(arrived, 60, `${file} at ${degrees} degrees`);
};

test('begins a program that stands ready as it was saved since', async () => {
  page = await at.open();
  await page.getByRole('button', { name: /^In control/ }).waitFor();
  await until(() => at.watcher.events.status?.program?.ended, 60, 'the end of what runs from the start');
  await go(page, 'Cell');
  await button('Reset the scene').click();
  await page.getByRole('dialog').getByRole('button', { name: 'Reset the scene' }).click();
  await page.getByRole('region', { name: 'Messages' }).getByText('The scene is as at the start').first().waitFor();
  await until(() => at.watcher.events.status?.program?.state === 'ready', 30, 'a program that has not begun');
  await go(page, 'Program');
  await page.getByRole('radiogroup', { name: 'Shown as' }).getByText('Text').click();
  await write(kTo(10));
  await button('Save').click();
  await until(() => saved('job.script') === kTo(10).trimEnd(), 20, 'the file');
  await go(page, 'Run');
  await button('Start').waitFor();
  assert.equal(await choice().count(), 0, 'there is one program');
  await startsTo('job.script', 10);
});

test('says that changes are not saved, takes the file as it is, and saves it when asked', async () => {
  await go(page, 'Program');
  await write(kTo(-15));
  await go(page, 'Run');
  await page.getByRole('status').getByText('job.script has changes that are not saved. Start uses the last saved text.').waitFor();
  await picture(page, 'start-unsaved');
  await startsTo('job.script', 10);
  await button('Save job.script').click();
  await until(() => saved('job.script') === kTo(-15).trimEnd(), 20, 'the file');
  await button('Save job.script').waitFor({ state: 'detached' });
  await page.getByRole('list', { name: 'Program text' }).getByText('joints(-15deg').waitFor();
  await startsTo('job.script', -15);
});

test('lets a person choose the program that is open on the Program page', async () => {
  await go(page, 'Program');
  await page.getByRole('button', { name: /^Program .*open another$/ }).click();
  await page.getByRole('dialog').getByRole('button', { name: /^other\.script/ }).click();
  await editor().getByText('joints(20deg').waitFor();
  await go(page, 'Run');
  await page.getByText('other.script is open on the Program page. Start begins:').waitFor();
  assert.equal(await choice().getByRole('radio', { name: 'job.script' }).isChecked(), true, 'nothing is chosen by itself');
  await startsTo('job.script', -15);
  await choice().getByText('other.script').click();
  await page.getByRole('list', { name: 'Program text' }).getByText('joints(20deg').waitFor();
  await picture(page, 'start-choice');
  await startsTo('other.script', 20);
  await choice().waitFor({ state: 'detached' });
  await page.getByRole('heading', { name: 'other.script' }).waitFor();
});

test('still knows after the page was loaded anew', async () => {
  await go(page, 'Program');
  await page.getByRole('button', { name: /^Program .*open another$/ }).click();
  await page.getByRole('dialog').getByRole('button', { name: /^job\.script/ }).click();
  await editor().getByText('joints(-15deg').waitFor();
  await go(page, 'Run');
  await choice().waitFor();
  await page.reload();
  await choice().getByRole('radio', { name: 'other.script' }).waitFor();
  assert.equal(await choice().getByRole('radio', { name: 'other.script' }).isChecked(), true, 'what the cell has');
  assert.deepEqual(page.problems, []);
});
