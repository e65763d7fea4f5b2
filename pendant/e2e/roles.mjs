// Users with roles: the log-in, and what a page says that may not do everything.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { dirname, join } from 'node:path';
import { go, picture, state } from './browser.mjs';
import { polyarm, Watcher } from './cell.mjs';
import { suite } from './suite.mjs';

const kPassword = 'right password';
const withUsers = (folder) => {
  const home = dirname(folder);
  const env = { ...process.env, XDG_RUNTIME_DIR: home, XDG_DATA_HOME: join(home, 'data'), XDG_CONFIG_HOME: join(home, 'config') };
  for (const [name, role] of [['ben', 'watch'], ['anna', 'operate']])
    execFileSync(polyarm, ['users', 'add', name, '--role', role], { env, input: `${kPassword}\n` });
};
const { at, test } = suite({ lines: true, example: 'r6bot', change: withUsers });
let page;
const main = () => page.getByRole('main');
const take = () => page.getByRole('button', { name: 'Take control' });
const logIn = async (name, password) => {
  const form = page.getByRole('form', { name: 'Log in' });
  await form.getByLabel('Name').fill(name);
  await form.getByLabel('Password').fill(password);
  await form.getByRole('button', { name: 'Log in' }).click();
};
/** The page as it opens without a link. */
const opened = () => at.open(at.cell.link.replace(/\?.*/, ''));

test('a cell with users asks for a name and a password, and does not say that its link is lost', async () => {
  page = await opened();
  await state(page).getByText('Log in').waitFor();
  assert.equal(await page.getByText('Reconnecting…').count(), 0);
  await picture(page, 'log-in');
  await logIn('ben', 'wrong');
  await page.getByRole('alert').getByText('The name or the password is wrong.').waitFor();
});

test('who may only watch is told so, and is not offered control', async () => {
  await logIn('ben', kPassword);
  await page.getByRole('button', { name: /^Watching/ }).waitFor();
  for (const name of ['Run', 'Move', 'Program', 'Points', 'Signals', 'Cell']) {
    await go(page, name);
    await main().getByText('You may watch, pause and stop').first().waitFor();
    assert.equal(await take().count(), 0, name);
  }
  await picture(page, 'role-watch');
  assert.equal(await page.getByText(/is refused/).count(), 0, 'nothing was asked for that the role does not allow');
});

test('who may operate has control, and is told which pages need more', async () => {
  page = await opened();
  await logIn('anna', kPassword);
  await page.getByRole('button', { name: /^In control/ }).waitFor();
  for (const [name, role] of [['Program', 'program'], ['Points', 'program'], ['Cell', 'administer']]) {
    await go(page, name);
    await main().getByText(`You may operate. Changes on this page need the role ${role}`).waitFor();
  }
  await picture(page, 'role-operate');
  for (const name of ['Choose another robot', 'Reset the scene', 'Add a mesh']) assert.ok(await main().getByRole('button', { name, exact: true }).isDisabled(), name);
  await go(page, 'Points');
  assert.ok(await main().getByRole('button', { name: 'Teach', exact: true }).isDisabled());
  await go(page, 'Health');
  await main().getByRole('radiogroup').first().getByText('Hardware').click();
  assert.ok(await main().getByRole('button', { name: 'Deactivate' }).first().isDisabled());
  await go(page, 'Move');
  await main().getByRole('button', { name: /plus$/ }).first().waitFor();
  assert.equal(await main().getByText(/^You may/).count(), 0);
  assert.deepEqual(page.problems, []);
});

test('a page with a link waits for a cell that is away, and asks for no password', async () => {
  page = await at.open();
  const connected = page.getByRole('button', { name: /^(In control|Watching|No control)/ });
  await connected.waitFor();
  at.watcher.end();
  await at.cell.kill();
  await page.getByRole('alert').getByText('Reconnecting…').waitFor();
  assert.equal(await page.getByRole('form', { name: 'Log in' }).count(), 0);
  await at.cell.start();
  at.watcher = await new Watcher(at.cell).start();
  await connected.waitFor();
});
