// Limits that take hold of what a controller commands, and what the page says of them.
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { go, picture } from './browser.mjs';
import { suite } from './suite.mjs';

/** Positions go through as they come: nothing but the last limiter keeps them within what joints may. */
const forwarded = (folder) => {
  writeFileSync(join(folder, 'cell.yaml'), 'polyarm: cell/1\nrobots:\n  arm: {model: universal_robots/ur3, hardware: mock}\ncontrollers: controllers.yaml\n');
  writeFileSync(join(folder, 'controllers.yaml'), [
    'controller_manager:', '  ros__parameters:', '    update_rate: 250', '    forward:', '      type: forward_command_controller/ForwardCommandController',
    'forward:', '  ros__parameters:', '    joints: [elbow_joint, wrist_3_joint]', '    interface_name: position', ''].join('\n'));
};
const { at, test } = suite({ lines: true, example: null, change: forwarded });
let page;
const limits = () => page.getByRole('main').getByRole('region', { name: /^arm\/elbow_joint\/position, / });

test('says that no limit took hold while none did', async () => {
  page = await at.open();
  await page.getByRole('button', { name: /^In control/ }).waitFor();
  await go(page, 'Health');
  await page.getByRole('main').getByText('No command had to be changed.').waitFor();
});

test('lists what took hold: when, how often, asked and given, who commands, why and what to do', async () => {
  await at.watcher.request('session.take', { force: true });
  const send = (data) => at.watcher.request('send', { to: 'forward/commands', message: JSON.stringify({ data }) });
  await send([1.2, 0]);
  const velocity = limits().and(page.getByRole('region', { name: 'arm/elbow_joint/position, Velocity' }));
  await velocity.getByText('Begin where the joint is', { exact: false }).waitFor();
  await velocity.getByText('forward', { exact: true }).waitFor();
  await velocity.getByText(/^68\.7\d+ °$/).waitFor();
  await velocity.getByText(/^00:\d\d:\d\d\.\d \(\d.* ago\)$/).waitFor();
  const times = async () => Number(await velocity.getByRole('definition').first().innerText());
  assert.ok((await times()) > 10, 'every cycle of the way counts');
  // What lies outside of the range is refused where it comes in, and comes to no clamp.
  await assert.rejects(() => send([10, 0]), (refused) => refused.code === 'beyond-limits' || /limits are/.test(refused.message));
  await velocity.scrollIntoViewIfNeeded();
  await picture(page, 'clamps');
  await page.getByRole('button', { name: 'Settings', exact: true }).click();
  await page.getByRole('dialog').getByRole('combobox', { name: 'Language' }).selectOption('es');
  await page.getByRole('dialog').getByRole('button', { name: 'Cerrar', exact: true }).click();
  await page.getByRole('region', { name: 'arm/elbow_joint/position, Velocidad' }).waitFor();
  assert.deepEqual(page.problems, []);
});
