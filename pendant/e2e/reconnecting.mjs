// What a restart of the server leaves: questions and alarms of the process before are gone, and control is where it was.
import assert from 'node:assert/strict';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { go, picture, screen, state, stopKey } from './browser.mjs';
import { until, Watcher } from './cell.mjs';
import { suite } from './suite.mjs';

const kMoves = 'load PAPpoints\nwhile true\n  movel Pass1, speed 40mm/s\n  movel Pass2, speed 40mm/s\nend\n';
const programs = (folder) => {
  const file = join(folder, 'cell.yaml');
  writeFileSync(file, readFileSync(file, 'utf8').replace(/^program:.*$/m, 'program: moves.script').replace(/^plc:.*\n/m, ''));
  writeFileSync(join(folder, 'moves.script'), kMoves);
  writeFileSync(join(folder, 'fails.script'), 'load PAPpoints\nwait 10ms\nraise "the gripper is empty"\n');
  const broken = join(folder, '../broken');
  mkdirSync(broken);
  writeFileSync(join(broken, 'cell.yaml'), 'polyarm: cell/1\nrobots:\n  arm: {model: universal_robots/ur3, hardware: mock}\nprogram: nowhere.script\n');
};
const { at, test } = suite({ lines: true, change: programs, chain: true });
const { cell } = at;
let page;
const button = (name, on = page) => on.getByRole('button', { name, exact: true });
const main = (on = page) => on.getByRole('main');
const messages = (on = page) => on.getByRole('region', { name: 'Messages' });
const status = () => at.watcher.events.status;
const inControl = (on) => on.getByRole('button', { name: /^In control/ });
const watching = (on) => on.getByRole('button', { name: /^(Watching|No control)/ });
const moving = () => until(() => at.watcher.speed() > 0.01, 60, 'motion');
const kill = async () => {
  at.watcher.end();
  await cell.kill();
};
const restart = async () => {
  await cell.start();
  at.watcher = await new Watcher(cell).start();
};
const held = async () => {
  await moving();
  await button('Pause', at.bar()).click();
  await state(page).getByText('Held').waitFor();
  await until(() => status().standing, 30, 'standing');
};

test('a question about a motion closes when the server is gone, and does not come back with it', async () => {
  page = await at.open();
  await inControl(page).waitFor();
  await held();
  await button('Cancel motion', at.bar()).click();
  const question = page.getByRole('dialog', { name: 'Cancel motion?' });
  await question.waitFor();
  await kill();
  await question.waitFor({ state: 'detached' });
  await restart();
  await inControl(page).waitFor();
  await moving();
  assert.equal(await page.getByRole('dialog').count(), 0);
  assert.equal(await messages().getByText('Motion canceled').count(), 0, 'nobody has said yes');
});

test('after a restart control goes back to the page that had it, however early the other comes', async () => {
  const other = await screen(at.chrome.browser, cell.link);
  try {
    await watching(other).waitFor();
    for (let i = 0; i < 3; ++i) {
      await kill();
      await page.getByRole('alert').getByText('Reconnecting…').waitFor();
      await other.getByRole('alert').getByText('Reconnecting…').waitFor();
      // The page that only watched is the first to be connected again.
      await page.context().setOffline(true);
      await restart();
      await other.evaluate(() => dispatchEvent(new Event('online')));
      await watching(other).waitFor();
      await page.context().setOffline(false);
      await page.evaluate(() => dispatchEvent(new Event('online')));
      await inControl(page).waitFor();
      assert.ok(await watching(other).isVisible(), 'who watched watches');
    }
    assert.deepEqual(other.problems, []);
  } finally {
    await other.context().close();
  }
});

test('while it reconnects, keys that cannot be pressed say why; a page that could not be loaded is loaded then', async () => {
  await go(page, 'Program');
  await main().locator('.program-buttons').waitFor();
  await go(page, 'Run');
  await kill();
  await page.getByRole('alert').getByText('Reconnecting…').waitFor();
  assert.ok(await button('Start').isDisabled());
  await main().locator('.run-keys').getByText('Not connected').waitFor();
  assert.equal(await main().getByText('No program is loaded').count(), 0, 'nobody knows');
  await go(page, 'Program');
  await main().locator('.program-buttons').getByText('Not connected').waitFor();
  await go(page, 'Plots');
  await main().getByText('This page could not be loaded').waitFor();
  await restart();
  await inControl(page).waitFor();
  await main().getByText('This page could not be loaded').waitFor({ state: 'detached' });
  await go(page, 'Program');
  await main().getByText('Not connected').first().waitFor({ state: 'detached' });
});

test('a canceled motion is no error: a neutral word of the key, no alarm', async () => {
  await go(page, 'Run');
  await held();
  await button('Cancel motion', at.bar()).click();
  await button('Cancel motion', page.getByRole('dialog')).click();
  await messages().getByRole('status').getByText('Motion canceled').waitFor();
  await button('Resume', at.bar()).click();
  await until(() => status().program?.ended, 30, 'the end of the program');
  await main().getByText('canceled', { exact: true }).waitFor();
  await main().getByText(/^Why it ended: The motion to Pass\d was canceled$/).waitFor();
  await picture(page, 'canceled');
  assert.equal(await page.getByRole('alert', { name: 'Alarm' }).count(), 0, 'no strip');
  assert.equal(await messages().getByRole('alert').count(), 0, 'no error');
  await button('Start').click();
  await until(() => status().program?.ended === false, 30, 'the program');
});

test('an alarm of the process before is gone after a restart; one of a process that still runs stays', async () => {
  const strip = page.getByRole('alert', { name: 'Alarm' });
  await button('End program').click();
  await button('End program', page.getByRole('dialog')).click();
  await until(() => status().program?.ended && status().standing, 30, 'the end');
  await at.watcher.request('session.take', { force: true });
  await at.watcher.request('program.from', { program: 'fails.script', confirmed: true });
  await strip.getByText(/gripper is empty/).waitFor();
  await page.context().setOffline(true);
  await page.evaluate(() => dispatchEvent(new Event('offline')));
  await page.context().setOffline(false);
  await strip.getByText(/gripper is empty/).waitFor();
  await at.watcher.request('session.release');
  await kill();
  await page.getByRole('alert').getByText('Reconnecting…').waitFor();
  await restart();
  await state(page).getByText(/^(Program|Moving|Ready)/).waitFor();
  await strip.waitFor({ state: 'detached' });
  await page.getByRole('button', { name: 'Alarms', exact: true }).click();
  const list = page.getByRole('dialog', { name: 'Alarms' });
  await list.getByText('No alarms').waitFor();
  await button('Close', list).click();
});

test('without a cell Stop is hatched, says that there is nothing to stop, and pressing it is no failure', async () => {
  await at.watcher.request('session.take', { force: true });
  await at.watcher.request('program.stop').catch(() => undefined);
  await at.watcher.request('cell.open', { folder: join(cell.folder, '../broken') });
  await state(page).getByText('No cell runs').waitFor();
  const dead = page.getByRole('button', { name: /^Stop .*no cell: there is nothing to stop$/ });
  await dead.waitFor();
  assert.equal(await dead.getAttribute('aria-disabled'), 'true');
  assert.match(await dead.evaluate((each) => getComputedStyle(each).backgroundImage), /repeating-linear-gradient/);
  await dead.click({ force: true });
  await messages().getByText('no cell: there is nothing to stop').waitFor();
  assert.equal(await messages().getByRole('alert').count(), 0, 'no error');
  assert.equal(await stopKey(page).count(), 0);
  await picture(page, 'no-cell');
  assert.deepEqual(page.problems, []);
});
