// What a hand does beside keys: a gamepad, the handle at the TCP, groups of points; what the view shows of a program's way; the
// figures of the loop; what is said before a real robot is connected.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import WebSocket from 'ws';
import { go, picture, state } from './browser.mjs';
import { until } from './cell.mjs';
import { suite } from './suite.mjs';

const { at, test, atRest, endProgram, holdKey } = suite();
const { cell } = at;
let page;
const main = () => page.getByRole('main');
const button = (name) => page.getByRole('button', { name, exact: true });
const said = (text) => page.getByRole('region', { name: 'Messages' }).getByText(text).first().waitFor();
const points = () => readFileSync(join(cell.folder, 'PAPpoints.points'), 'utf8');

test('shows the way of the move under way, and where it ends', async () => {
  page = await at.open(cell.link, { before: () => {
    // A pad that is nowhere but here: the page asks for it as for any other.
    const pad = { id: 'made up', index: 0, connected: true, mapping: 'standard', axes: [0, 0, 0, 0], buttons: Array.from({ length: 17 }, () => ({ pressed: false, touched: false, value: 0 })) };
    globalThis.madeUpPad = pad;
    navigator.getGamepads = () => [pad, null, null, null];
  } });
  await page.getByRole('button', { name: /^In control/ }).waitFor();
  const plan = () => at.watcher.events.plan?.plans?.arm;
  await until(() => plan()?.path?.length > 20, 60, 'a way');
  const { path, target } = plan();
  assert.equal(Object.keys(target.joints).length, 6);
  assert.ok(path.every((each) => each.length === 3 && each.every(Number.isFinite)));
  // The robot comes to where the way ends.
  const end = path.at(-1);
  const away = () => Math.hypot(...['x', 'y', 'z'].map((axis, i) => at.watcher.value(`arm/tcp/${axis}`) - end[i]));
  await until(() => away() < 0.002, 60, 'the end of the way');
  await picture(page, 'plan');
});

test('moves by a gamepad as long as its button is held', async () => {
  await endProgram();
  await go(page, 'Move');
  await page.getByRole('radiogroup', { name: 'Move in' }).getByText('Base').click();
  await button('Gamepad').click();
  const z = at.watcher.value('arm/tcp/z');
  const held = (index, value) => page.evaluate(([i, v]) => (madeUpPad.buttons[i] = { pressed: v > 0, touched: v > 0, value: v }), [index, value]);
  await held(7, 1);
  const from = at.watcher.time;
  await until(() => at.watcher.time > from + 0.5, 60, 'half a second');
  assert.ok(Math.abs(at.watcher.value('arm/tcp/z') - z) < 1e-3, 'nothing moves while the button that allows it is up');
  await held(5, 1);
  await until(() => at.watcher.value('arm/tcp/z') > z + 0.01, 60, 'the TCP going up');
  await held(5, 0);
  await atRest();
  await held(7, 0);
  const rest = at.watcher.value('arm/tcp/z');
  const later = at.watcher.time;
  await until(() => at.watcher.time > later + 0.4, 60, 'a moment');
  assert.ok(Math.abs(at.watcher.value('arm/tcp/z') - rest) < 1e-3, 'it stays');
  await button('Gamepad').click();
});

/** Where the arrow along z is drawn in an element's picture, by its colour: its tip, px. */
async function blueArrow(view) {
  const bytes = [...(await view.screenshot())];
  return page.evaluate(async (png) => {
    const image = await createImageBitmap(new Blob([new Uint8Array(png)], { type: 'image/png' }));
    const pen = new OffscreenCanvas(image.width, image.height).getContext('2d');
    pen.drawImage(image, 0, 0);
    const { data } = pen.getImageData(0, 0, image.width, image.height);
    let best = null;
    let count = 0;
    for (let i = 0; i < data.length; i += 4)
      if (data[i] < 60 && data[i + 1] < 60 && data[i + 2] > 200) {
        ++count;
        best ??= { x: (i / 4) % image.width, y: Math.floor(i / 4 / image.width) + 4 };
      }
    return count > 20 ? best : null;
  }, bytes);
}

test('follows the handle at the TCP while it is dragged, and rests when it is let go', async () => {
  await button('Drag TCP').click();
  const view = page.getByRole('region', { name: 'Robot view' });
  const arrow = await until(() => blueArrow(view), 60, 'the handle in the picture');
  await picture(page, 'handle');
  const before = ['x', 'y', 'z'].map((axis) => at.watcher.value(`arm/tcp/${axis}`));
  const moved = () => Math.hypot(...['x', 'y', 'z'].map((axis, i) => at.watcher.value(`arm/tcp/${axis}`) - before[i]));
  const box = await view.boundingBox();
  const [x, y] = [box.x + arrow.x, box.y + arrow.y];
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let i = 1; i <= 10; ++i) await page.mouse.move(x, y - 3 * i);
  await until(() => moved() > 0.01, 60, 'the TCP following');
  await page.mouse.up();
  await atRest();
  const rest = moved();
  const later = at.watcher.time;
  await until(() => at.watcher.time > later + 0.4, 60, 'a moment');
  assert.ok(Math.abs(moved() - rest) < 1e-3, 'it stays');
  await button('Drag TCP').click();
});

test('says what holds a motion back as long as its key is held, and not on another page', async () => {
  await page.getByRole('radiogroup', { name: 'Move in' }).getByText('Base').click();
  const words = main().getByText(/^Held back by (a singularity|a joint limit|the workspace)/);
  await holdKey(button('X plus'), () => words.isVisible(), 'what holds it back');
  await page.mouse.up();
  await atRest();
  await words.waitFor({ state: 'detached' });
  await go(page, 'Points');
  await page.getByRole('group', { name: 'Points' }).getByRole('button', { name: /^PrePick / }).click();
  const told = main().getByRole('status').filter({ hasText: 'The view shows the path' });
  await told.getByText(/\(about \d+\.\d s\)/).waitFor();
  assert.match(await told.innerText(), /\(about \d+\.\d s\)$/);
  await page.getByRole('group', { name: 'Points' }).getByRole('checkbox', { name: 'Choose PrePick', exact: true }).uncheck();
});

test('puts points into a group, which the file keeps, and folds and filters it', async () => {
  await go(page, 'Points');
  const list = page.getByRole('group', { name: 'Points' });
  for (const name of ['Pick', 'PrePick']) await list.getByRole('checkbox', { name: `Choose ${name}`, exact: true }).check();
  await button('Group').click();
  const dialog = page.getByRole('dialog', { name: 'Group' });
  await dialog.getByRole('textbox', { name: 'Group' }).fill('feeder side');
  await dialog.getByRole('button', { name: 'Apply' }).click();
  await said('Pick, PrePick: in group feeder side');
  assert.equal(points().match(/^Group: feeder side$/gm).length, 2);
  const group = list.getByRole('region', { name: 'feeder side' });
  await group.getByRole('button', { name: /^Pick / }).waitFor();
  await group.getByRole('button', { name: /feeder side/ }).click();
  await group.getByRole('button', { name: /^Pick / }).waitFor({ state: 'detached' });
  await page.reload();
  await page.getByRole('button', { name: /^In control/ }).waitFor();
  await group.getByRole('button', { name: /feeder side/, expanded: false }).click();
  await group.getByRole('button', { name: /^Pick / }).waitFor();
  await page.getByRole('combobox', { name: 'Group' }).selectOption('feeder side');
  await list.getByRole('button', { name: /^Place / }).waitFor({ state: 'detached' });
  await picture(page, 'groups');
  await page.getByRole('combobox', { name: 'Group' }).selectOption('all groups');
});

test('says what somebody writes into the points file beside the page, and takes it over', async () => {
  const file = join(cell.folder, 'PAPpoints.points');
  const before = points();
  writeFileSync(file, `${before.replace(/^(Name: PrePick\n)Group: .*\n/m, '$1Group: by hand\n')}Name: Own\nGroup: by hand\nPoint: 0.25, 0.1, 0.3, 3.14159, 0, 0\n`);
  const banner = main().getByText('PAPpoints.points: changed outside of this page').locator('..');
  await banner.getByText('Changed: PrePick. New: Own.').waitFor();
  await picture(page, 'outside');
  await button('Take over').click();
  await said('PAPpoints.points: taken over');
  const group = page.getByRole('group', { name: 'Points' }).getByRole('region', { name: 'by hand' });
  for (const name of ['Own', 'PrePick']) await group.getByRole('button', { name: new RegExp(`^${name} `) }).waitFor();
  await banner.waitFor({ state: 'detached' });
  writeFileSync(file, before);
  await button('Take over').click();
  await group.waitFor({ state: 'detached' });
});

test('shifts points together, and takes it back', async () => {
  const before = points();
  await page.getByRole('checkbox', { name: 'Choose all of feeder side' }).check();
  await button('Shift').click();
  const dialog = page.getByRole('dialog', { name: /^Shift / });
  await dialog.getByRole('textbox', { name: 'Z', exact: true }).fill('12,5');
  await dialog.getByRole('button', { name: 'Shift' }).click();
  await said(/shifted$/);
  await page.getByRole('button', { name: /^Pick X 300.0 Y 150.0 Z 52.5 mm/ }).waitFor();
  await button('Undo the last change').click();
  await page.getByRole('button', { name: /^Pick X 300.0 Y 150.0 Z 40.0 mm/ }).waitFor();
  assert.equal(points(), before);
});

test('shows how the cycles of the loop lie, and what the cell is made of', async () => {
  await go(page, 'Health');
  for (const what of ['Work in a cycle', 'Wake-up', 'Period']) {
    const bars = page.getByRole('img', { name: new RegExp(`^${what}: `) });
    await bars.waitFor();
    assert.ok((await bars.locator('i').count()) > 3, `${what} has bars`);
  }
  await picture(page, 'health');
  const health = await at.watcher.request('health');
  for (const what of ['cost', 'wake_up', 'period']) {
    const sum = health[what].buckets.reduce((all, each) => all + each.count, 0);
    assert.ok(sum > 1000 && sum <= health.cycles + 1, `${what}: ${sum} of ${health.cycles}`);
  }
});

test('says why a program that is started ends at once, and begins anew from the scene', async () => {
  await endProgram();
  const set = async (name) => {
    await page.getByRole('button', { name: `Open ${name}`, exact: true }).click();
    const dialog = page.getByRole('dialog', { name });
    await dialog.getByText('Off', { exact: true }).last().click();
    await dialog.getByRole('button', { name: 'Set once' }).click();
    await dialog.getByRole('button', { name: 'Close' }).click();
  };
  await go(page, 'Signals');
  await set('Repeat');
  await go(page, 'Run');
  const start = () => main().getByRole('button', { name: 'Start', exact: true }).click();
  const why = main().getByText('It ended without a cycle: “while Repeat” (line 4) did not hold');
  await start();
  await why.waitFor();
  await picture(page, 'no-pass');
  await go(page, 'Program');
  await why.waitFor();
  await button('Reset the scene').click();
  await page.getByRole('dialog').getByRole('button', { name: 'Reset the scene' }).click();
  await said('The scene is as at the start');
  await why.waitFor({ state: 'detached' });
  await go(page, 'Run');
  await start();
  await until(() => at.watcher.events.status?.program?.ended === false && at.watcher.speed() > 0.05, 90, 'the program moving the robot');
  await endProgram();
});

test('switches the device off and on, and says what is missing meanwhile', async () => {
  const tab = (name) => main().getByRole('radiogroup').first().getByText(name).click();
  const yes = () => page.getByRole('dialog').getByRole('button', { name: 'Do it' }).click();
  await go(page, 'Health');
  await tab('Hardware');
  await button('Deactivate').click();
  await yes();
  await state(page).getByText('Not ready').waitFor();
  await state(page).getByText(/^mujoco, joint_trajectory_controller: not active/).waitFor();
  await picture(page, 'not-ready');
  await main().getByRole('button', { name: 'Activate' }).click();
  await yes();
  // The device is there again, and nothing commands it yet.
  await state(page).getByText(/joint_trajectory_controller: not active/).waitFor();
  await tab('Controllers');
  await button('Switch controllers').click();
  const dialog = page.getByRole('dialog', { name: 'Switch controllers' });
  for (const name of ['joint_trajectory_controller', 'io']) await dialog.getByText(name, { exact: true }).click();
  await dialog.getByText(/^Will start: .*joint_trajectory_controller/).waitFor();
  await yes();
  await until(async () => (await main().getByText('Active', { exact: true }).count()) === 3, 60, 'three active controllers');
  await state(page).getByText('Ready', { exact: true }).waitFor();
  await go(page, 'Run');
  await button('Start').click();
  await until(() => at.watcher.speed() > 0.05, 90, 'the program moving the robot again');
  await endProgram();
});

test('serves Foxglove’s protocol on the same port, beside the page', async () => {
  const socket = new WebSocket(`ws://127.0.0.1:${cell.port}/?token=${cell.token}`, ['foxglove.sdk.v1']);
  const channels = new Map();
  const counts = {};
  socket.binaryType = 'nodebuffer';
  socket.on('message', (data, binary) => {
    if (binary) {
      if (data[0] === 1) counts[data.readUInt32LE(1)] = (counts[data.readUInt32LE(1)] ?? 0) + 1;
      return;
    }
    const message = JSON.parse(data);
    if (message.op === 'advertise') for (const each of message.channels) channels.set(each.topic, each);
  });
  await until(() => channels.has('/joint_states') && channels.has('/tf'), 60, 'the channels');
  const wanted = ['/joint_states', '/tf', '/robot_description'];
  socket.send(JSON.stringify({ op: 'subscribe', subscriptions: wanted.map((topic, id) => ({ id, channelId: channels.get(topic).id })) }));
  await until(() => wanted.every((_, id) => counts[id] > 0) && counts[0] > 30, 60, 'messages of all three');
  assert.ok(at.watcher.frames.length > 0 && (await page.getByRole('button', { name: /^In control/ }).isVisible()));
  socket.close();
});

test('says what it would connect before it touches anything, and why it cannot', async () => {
  await go(page, 'Cell');
  await page.getByRole('radiogroup', { name: 'Simulate or connect' }).getByText('Real robot').click();
  const dialog = page.getByRole('dialog', { name: 'Connect to the real robot?' });
  await dialog.getByText(/^the cell names no real hardware: 'arm' is/).waitFor();
  assert.ok(await dialog.getByRole('button', { name: 'Connect' }).isDisabled());
  await picture(page, 'connect');
  await dialog.getByRole('button', { name: 'Cancel' }).click();
  await state(page).getByText('Ready', { exact: true }).waitFor();
  assert.deepEqual(page.problems, []);
});

test('names the device of a driver that the cell names, where that is not plugged in', async () => {
  const file = join(cell.folder, 'cell.yaml');
  writeFileSync(file, readFileSync(file, 'utf8').replace(/hardware: \w+/, 'hardware: feetech, parameters: {port: /dev/ttyNone7}'));
  await button('Reset the scene').click();
  await page.getByRole('dialog').getByRole('button', { name: 'Reset the scene' }).click();
  await said('The scene is as at the start');
  await page.getByRole('radiogroup', { name: 'Simulate or connect' }).getByText('Real robot').click();
  const dialog = page.getByRole('dialog', { name: 'Connect to the real robot?' });
  await dialog.getByText('/dev/ttyNone7', { exact: true }).waitFor();
  await dialog.getByRole('alert').getByText(/^'\/dev\/ttyNone7' does not exist/).waitFor();
  await picture(page, 'connect-device');
});
