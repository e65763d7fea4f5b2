// What is near: the distance while a key is held, why the motion is held back, names and hiding of obstacles, a point cloud.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { go, picture } from './browser.mjs';
import { suite, waitAboveThePart } from './suite.mjs';

/** A scanned wall at the side of the robot. */
const withWall = (folder) => {
  waitAboveThePart(folder);
  const points = [];
  for (let y = -30; y <= 30; ++y) for (let z = 0; z <= 40; ++z) points.push(`${(y / 50).toFixed(3)} ${(0.005 * Math.sin(y + z)).toFixed(4)} ${(z / 50).toFixed(3)}`);
  const head = `VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH ${points.length}\nHEIGHT 1\nPOINTS ${points.length}\nDATA ascii\n`;
  writeFileSync(join(folder, 'wall.pcd'), `${head}${points.join('\n')}\n`);
  const file = join(folder, 'scene.yaml');
  const scene = readFileSync(file, 'utf8');
  writeFileSync(file, scene.replace('bins:', '  wall: {cloud: {file: wall.pcd, radius: 15mm}, at: [0.1, 0.45, 0]}\nbins:'));
};
const { at, test, endProgram, holdKey, atRest } = suite({ change: withWall, chain: true });
let page;
const button = (name) => page.getByRole('button', { name, exact: true });

test('a jog says how far before what it is held', async () => {
  page = await at.open();
  await page.getByRole('button', { name: /^In control/ }).waitFor();
  await endProgram();
  await go(page, 'Move');
  await page.getByRole('radiogroup', { name: 'Move in' }).getByText('Base').click();
  await page.getByRole('slider', { name: 'Jog speed' }).fill('30');
  const words = page.getByText(/^Held \d+ mm before wall: (arm\/|part )/);  // the robot, or what it holds
  await holdKey(button('Y plus'), () => words.first().isVisible(), 'the wall holding the motion back');
  await picture(page, 'near-desk-dark');
  await page.emulateMedia({ colorScheme: 'light' });
  await picture(page, 'near-desk-light');
  await page.mouse.up();
  await atRest();
});

test('obstacles show their names and can be hidden', async () => {
  await page.emulateMedia({ colorScheme: 'dark' });
  await page.getByRole('button', { name: 'What is shown' }).click();
  await button('Names of obstacles').click();
  await picture(page, 'near-names');
  await button('Obstacles').click();
  await picture(page, 'near-hidden');
  await button('Obstacles').click();
  for (const [size, [width, height]] of Object.entries({ tablet: [1024, 600], phone: [390, 844] })) {
    await page.setViewportSize({ width, height });
    for (const colorScheme of ['dark', 'light']) {
      await page.emulateMedia({ colorScheme });
      await picture(page, `near-${size}-${colorScheme}`);
    }
  }
  assert.deepEqual(page.problems, []);
});
