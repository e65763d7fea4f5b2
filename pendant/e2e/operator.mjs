// What an operator reads and presses: words that are true while the robot moves, a way out of a contact, and a Start that begins what is shown.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { go, picture, state } from './browser.mjs';
import { until } from './cell.mjs';
import { suite } from './suite.mjs';

const kHit = 'load PAPpoints\nmoveto PrePlace\nmoveto Above\nmovel Deep, speed 100mm/s\n';
const programs = (folder) => {
  const file = join(folder, 'cell.yaml');
  writeFileSync(file, readFileSync(file, 'utf8').replace(/^program:.*$/m, 'program: moves.script').replace(/^plc:.*\n/m, ''));
  writeFileSync(join(folder, 'moves.script'), 'load PAPpoints\nwhile true\n  movel Pass1, speed 40mm/s\n  movel Pass2, speed 40mm/s\nend\n');
  writeFileSync(join(folder, 'hit.script'), kHit);
  const points = join(folder, 'PAPpoints.points');
  const point = (name, z) => `\nName: ${name}\nPoint: 0.45, -0.25, ${z}, 3.141592653589793, 0.0, 0.0\n`;
  writeFileSync(points, readFileSync(points, 'utf8') + point('Deep', -0.05) + point('Above', 0.1));
};
const { at, test, endProgram } = suite({ lines: true, change: programs, chain: true });
const { cell } = at;
let page;
const main = () => page.getByRole('main');
const button = (name, on = page) => on.getByRole('button', { name, exact: true });
const status = () => at.watcher.events.status;

test('while the robot moves, the program runs and does not wait', async () => {
  page = await at.open();
  await button(/^In control/).waitFor();
  await until(() => at.watcher.speed() > 0.02 && status().program?.state === 'waiting', 60, 'a move that the program waits for');
  await state(page).getByText('Program runs', { exact: true }).waitFor({ timeout: 5000 });
  await main().getByText('running', { exact: true }).waitFor({ timeout: 5000 });
});

test('a Start that cannot be pressed says why', async () => {
  await button('Pause').click();
  await state(page).getByText('Held').waitFor();
  await button('End program').click();
  await page.getByRole('dialog').getByRole('button', { name: 'End program' }).click();
  await until(() => status().program?.ended, 30, 'the end');
  assert.ok(await button('Start').isDisabled());
  await main().getByText('Press Resume first: the cell is held.').waitFor();
  await button('Resume', at.bar()).click();
  await until(() => status().state === 'running', 30, 'running');
});

test('Start begins what is shown: a file that was changed since is refused, and shown anew', async () => {
  await main().getByText('movel Pass2, speed 40mm/s').waitFor();
  writeFileSync(join(cell.folder, 'moves.script'), 'load PAPpoints\nlog "another"\n');
  await button('Start').click();
  await page.getByRole('region', { name: 'Messages' }).getByText(/changed since it was shown/).waitFor();
  assert.ok(status().program.ended, 'nothing has begun');
  await main().getByText('log "another"').waitFor();
  await button('Start').click();
  await until(() => status().program?.state === 'finished', 30, 'the end of the other');
});

test('the dry run says that something is touched', async () => {
  await go(page, 'Program');
  await page.getByRole('button', { name: /^Program .*open another$/ }).click();
  await page.getByRole('dialog').getByRole('button', { name: /^hit\.script/ }).click();
  await button('Dry run').click();
  await main().getByText('Dry run: something is touched').waitFor();
  assert.equal(await main().getByText(/some moves are impossible/).count(), 0);
});

test('after a contact only what can be done now can be pressed', async () => {
  await button('Start').click();
  await state(page).getByText('Stopped after contact').waitFor();
  const strip = page.getByRole('alert', { name: 'Stopped after contact' });
  const resume = button('Resume', at.bar());
  await until(() => status().contacts.touching && status().standing, 30, 'standing in contact');
  await until(() => resume.isDisabled(), 10, 'no Resume while it touches');
  await main().getByText('held', { exact: true }).waitFor();
  assert.ok(await button('Step').isDisabled(), 'a step would go on');
  await picture(page, 'touching');
  await button('Cancel motion', strip).click();
  await strip.getByText('The motion is canceled.').waitFor();
  assert.equal(await button('Cancel motion').count(), 0, 'neither in the strip nor in the bar');
  await button('Jog away', strip).click();
  await page.getByRole('radiogroup', { name: 'Move in' }).getByText('Base').click();
  const up = button('Z plus');
  await until(async () => {
    await up.hover();
    await page.mouse.down();
    await page.waitForTimeout(700);
    await page.mouse.up();
    return !status().contacts.touching;
  }, 30, 'away');
  await until(() => resume.isEnabled(), 10, 'Resume');
  await resume.click();
  await until(() => status().state === 'running', 30, 'running');
  await endProgram().catch(() => undefined);
  assert.deepEqual(page.problems, []);
});
