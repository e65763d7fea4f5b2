// Users who log in at the page: the form, a wrong password, and the end of a log-in whose page stays open.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { dirname, join } from 'node:path';
import { picture, screen } from './browser.mjs';
import { polyarm, until } from './cell.mjs';
import { suite } from './suite.mjs';

const addAnna = (folder) => {
  const env = { ...process.env, XDG_DATA_HOME: join(dirname(folder), 'data') };
  const added = spawnSync(polyarm, ['users', 'add', 'anna', '--role', 'operate'], { env, input: 'right password\n' });
  assert.equal(added.status, 0, String(added.stderr));
};
const { at, test } = suite({ lines: true, options: ['--log-in-hours', '0.004'], change: addAnna, chain: true });
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

test('the form keeps what is typed while the page tries to connect', async () => {
  // The time of a first connection does not end, so that every attempt falls into it.
  const first = () => {
    const real = window.setTimeout;
    window.setTimeout = (what, delay, ...rest) => real(what, delay === 1500 ? 3_600_000 : delay, ...rest);
  };
  page = await screen(at.chrome.browser, new URL('/', at.cell.link).href, { before: first });
  let attempts = 0;
  page.on('websocket', () => (attempts += 1));
  await form().waitFor();
  await form().getByLabel('Name').fill('anna');
  const seen = attempts;
  await until(() => attempts >= seen + 2, 60, 'two more attempts');
  assert.equal(await form().getByLabel('Name').inputValue(), 'anna');
  await page.context().close();
  page = at.page;
});

test('a log-in ends although its page stays open, and the page says why', async () => {
  await enter('right password');
  await form().waitFor({ state: 'detached' });
  await form().getByText(/^Your log-in has ended\. A log-in lasts .* h at most\.$/).waitFor({ timeout: 120_000 });
  await picture(page, 'log-in-ended');
  await enter('right password');
  await form().waitFor({ state: 'detached' });
});
