// A base that drives: where the view and Foxglove's frames have it.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import WebSocket from 'ws';
import { picture } from './browser.mjs';
import { until } from './cell.mjs';
import { suite } from './suite.mjs';

/** The example's robot on the mock, which knows no place but that of the wheels. */
const onTheMock = (folder) => {
  writeFileSync(join(folder, 'cell.yaml'), readFileSync(join(folder, 'square.yaml'), 'utf8').replace('hardware: declared', 'hardware: mock'));
  writeFileSync(join(folder, 'square.script'), 'drive 300mm, speed 0.2m/s\nturn 90deg\ndrive 200mm\n');
};
const { at, test } = suite({ example: 'jetbot', change: onTheMock });
let page;

test('the view follows a base by its odometry', async () => {
  page = await at.open();
  await page.getByRole('button', { name: /^In control/ }).waitFor();
  const view = page.getByRole('region', { name: 'Robot view' });
  await view.getByRole('button', { name: 'Views' }).click();
  await view.getByRole('button', { name: 'Top' }).click();
  const base = (axis) => at.watcher.value(`jetbot/base/position.${axis}`);
  const first = await view.screenshot();
  await picture(page, 'driving-1');
  await until(() => at.watcher.events.status?.program?.ended, 90, 'the end of the program');
  assert.ok(Math.abs(base('x') - 0.3) < 0.01 && Math.abs(base('y') - 0.2) < 0.01, `${base('x')}, ${base('y')}`);
  await until(async () => !first.equals(await view.screenshot()), 30, 'another picture');
  const { p } = await until(() => at.watcher.events.status.bases.jetbot, 30, 'the base in the status');
  assert.ok(Math.hypot(p[0] - base('x'), p[1] - base('y')) < 0.005, `status: ${p}`);
  await view.getByRole('button', { name: /everything/i }).click();
  await picture(page, 'driving-2');
});

test('Foxglove’s frames lead to the same place', async () => {
  const socket = new WebSocket(`ws://127.0.0.1:${at.cell.port}/?token=${at.cell.token}`, ['foxglove.sdk.v1']);
  socket.binaryType = 'nodebuffer';
  let found;
  socket.on('message', (data, binary) => {
    if (!binary) {
      const message = JSON.parse(data);
      const tf = message.op === 'advertise' && message.channels.find((each) => each.topic === '/tf');
      if (tf) socket.send(JSON.stringify({ op: 'subscribe', subscriptions: [{ id: 0, channelId: tf.id }] }));
      return;
    }
    const text = data.toString('latin1');
    if (text.includes('odom') && text.includes('base_footprint')) found = text;
  });
  await until(() => found, 60, 'the base among the frames');
  socket.close();
  assert.deepEqual(page.problems, []);
});
