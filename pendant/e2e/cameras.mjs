// A camera on the hand from sightings of a marker, whose pose a program writes as a camera would.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { go, picture } from './browser.mjs';
import { polyarm, until } from './cell.mjs';
import { suite } from './suite.mjs';

const kRobot = 'universal_robots/ur5e';
/** Joint values, degrees: the hand points down, and leans about two axes. */
const kPoses = [
  [0, -90, 100, -100, -90, 0],
  [10, -85, 95, -80, -90, 20],
  [-10, -95, 105, -120, -70, -20],
  [5, -90, 95, -100, -110, 40],
  [-5, -85, 100, -110, -80, -40],
];
const kCamera = { p: [0.03, 0.05, 0.06], q: [0, 0, Math.SQRT1_2, Math.SQRT1_2] };
const kMarker = { p: [0.5, 0.1, 0], q: [0, 0, 0, 1] };

const times = ([x, y, z, w], [X, Y, Z, W]) => [w * X + x * W + y * Z - z * Y, w * Y - x * Z + y * W + z * X, w * Z + x * Y - y * X + z * W, w * W - x * X - y * Y - z * Z];
const undo = ([x, y, z, w]) => [-x, -y, -z, w];
const turn = (q, p) => times(times(q, [...p, 0]), undo(q)).slice(0, 3);
const after = (a, b) => ({ p: turn(a.q, b.p).map((v, i) => v + a.p[i]), q: times(a.q, b.q) });
const inverse = (a) => ({ p: turn(undo(a.q), a.p).map((v) => -v), q: undo(a.q) });
/** What the camera sees at these joint values. */
const seen = (degrees) => {
  const joints = degrees.map((each) => String((each * Math.PI) / 180));
  const { xyz, quaternion } = JSON.parse(execFileSync(polyarm, ['fk', kRobot, '--json', '--joints', ...joints], { encoding: 'utf8' }));
  return after(inverse(after({ p: xyz, q: quaternion }, kCamera)), kMarker);
};

const { at, test } = suite({
  example: 'r6bot',
  change: (folder) => {
    writeFileSync(join(folder, 'cell.yaml'), `polyarm: cell/1\nrobots:\n  arm: {model: ${kRobot}, hardware: mock}\nprogram: job\n`);
    writeFileSync(join(folder, 'work.data'), 'Name: PointFile\nText: places\n');
    writeFileSync(join(folder, 'places.points'), 'Pose: Quaternion\nName: Seen\nPoint: 0, 0, 0.4, 0, 0, 0, 1\n');
    writeFileSync(join(folder, 'job.script'), 'load work\n');
  },
  chain: true,
});
let page;
const button = (name, on = page) => on.getByRole('button', { name, exact: true });

test('a camera is taught from sightings at several poses', async () => {
  page = await at.open();
  await page.getByRole('button', { name: /^In control/ }).waitFor();
  for (const [k, pose] of kPoses.entries()) {
    const { p, q } = seen(pose);
    writeFileSync(join(at.cell.folder, 'job.script'), `load work\nmovej joints(${pose.map((each) => `${each}deg`).join(', ')})\nset Seen = quat(${[...q.map((v) => v.toFixed(9)), ...p.map((v) => `${v.toFixed(9)}m`)].join(', ')})\n`);
    await go(page, 'Program');
    await button('Start').click();
    const here = async () => (await at.watcher.request('points.sighting', { marker: 'Seen' })).marker.p;
    const seesIt = async () => (await here()).every((v, i) => Math.abs(v - p[i]) < 1e-6);
    await until(() => seesIt().catch((error) => error.code !== 'moving' && Promise.reject(error)), 90, 'the marker of this pose');
    await until(() => at.watcher.events.status?.program?.ended, 90, 'the end of the program');
    await go(page, 'Points');
    await button('Teach a camera').click();
    const wizard = page.getByRole('dialog', { name: 'Teach a camera' });
    await button(`Take sighting ${k + 1}`, wizard).click();
    await button(`Take sighting ${k + 2}`, wizard).waitFor();
    if (k + 1 < kPoses.length) await button('Close', wizard).first().click();
  }
  const wizard = page.getByRole('dialog', { name: 'Teach a camera' });
  const result = wizard.getByRole('region', { name: 'Result' });
  await result.getByText(/X 30\.0 {2}Y 50\.0 {2}Z 60\.0 mm/).waitFor();
  await result.getByText(/^Uncertainty/).waitFor();
  await picture(page, 'camera');
  await wizard.getByRole('textbox', { name: 'Name of the camera' }).fill('Eye');
  await button('Save camera', wizard).click();
  await page.getByRole('region', { name: 'Messages' }).getByText(/Eye/).first().waitFor();
  await until(() => /Name: Eye/.test(readFileSync(join(at.cell.folder, 'places.points'), 'utf8')), 30, 'the camera in its file');
  assert.match(readFileSync(join(at.cell.folder, 'places.points'), 'utf8'), /arm\/flange/);
});

test('the camera is taken back', async () => {
  await button('Undo the last change').click();
  await until(() => !/Name: Eye/.test(readFileSync(join(at.cell.folder, 'places.points'), 'utf8')), 30, 'the file without the camera');
  assert.deepEqual(page.problems, []);
});
