// Users who log in at the page: the form, a wrong password, and the end of a log-in whose page stays open.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { dirname, join } from 'node:path';
import { picture } from './browser.mjs';
import { polyarm } from './cell.mjs';
import { suite } from './suite.mjs';

const addAnna = (folder) => {
  const env = { ...process.env, XDG_DATA_HOME: join(dirname(folder), 'data') };
  const added = spawnSync(polyarm, ['users', 'add', 'anna', '--role', 'operate'], { env, input: 'right password\n' });
  assert.equal(added.status, 0, String(added.stderr));
};
const { at, test } = suite({ options: ['--log-in-hours', '0.004'], change: addAnna, chain: true });
let page;
const form = () => page.getByRole('form', { name: 'Log in' });
const enter = async (password) => {
  await form().getByLabel('Name').fill('anna');
  await form().getByLabel('Password').fill(password);
  await form().getByRole('button', { name: 'Log in' }).click();
};

test('a page without a link asks for name and password', async () => {
  page = await at.open(new URL('/', at.cell.link).href);
  await form().waitFor();
  await enter('wrong password');
  await form().getByText('The name or the password is wrong.').waitFor();
  await picture(page, 'log-in');
});

test('a log-in ends although its page stays open, and the page says why', async () => {
  await enter('right password');
  await form().waitFor({ state: 'detached' });
  await form().getByText(/^Your log-in has ended\. A log-in lasts .* h at most\.$/).waitFor({ timeout: 120_000 });
  await picture(page, 'log-in-ended');
  await enter('right password');
  await form().waitFor({ state: 'detached' });
});
