// Meshes that are dropped on the page become fixtures and parts of the scene.
import assert from 'node:assert/strict';
import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { go, picture } from './browser.mjs';
import { until } from './cell.mjs';
import { suite } from './suite.mjs';

/** A pyramid of 40 mm x 40 mm x 30 mm, in millimetres. */
const kPyramid = (() => {
  const corners = [[0, 0, 0], [40, 0, 0], [40, 40, 0], [0, 40, 0], [20, 20, 30]];
  const faces = [[0, 2, 1], [0, 3, 2], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
  const facet = (face) => `facet normal 0 0 0\nouter loop\n${face.map((i) => `vertex ${corners[i].join(' ')}\n`).join('')}endloop\nendfacet\n`;
  return `solid pyramid\n${faces.map(facet).join('')}endsolid pyramid\n`;
})();

const { at, test } = suite({
  example: null,
  chain: true,
  change: (folder) => writeFileSync(join(folder, 'cell.yaml'), 'polyarm: cell/1\nrobots:\n  arm: {model: universal_robots/ur3e, hardware: mock}\n'),
});
let page;
const dialog = () => page.getByRole('dialog', { name: 'Place the mesh in the scene' });
const scene = () => readFileSync(join(at.cell.folder, 'scene.yaml'), 'utf8');

test('a mesh that is chosen is placed with its unit', async () => {
  page = await at.open();
  await page.getByRole('button', { name: /^In control/ }).waitFor();
  await go(page, 'Cell');
  await page.getByRole('button', { name: 'Add a mesh' }).waitFor();
  await page.locator('input[type=file]').setInputFiles({ name: 'my pyramid.stl', mimeType: 'model/stl', buffer: Buffer.from(kPyramid) });
  await dialog().getByText('0.040 × 0.040 × 0.030 m, 6 triangles').waitFor();
  assert.equal(await dialog().getByLabel('Unit of the file').inputValue(), 'mm', 'what its size suggests');
  await dialog().getByLabel('Unit of the file').selectOption('cm');
  await dialog().getByText('0.400 × 0.400 × 0.300 m, 6 triangles').waitFor();
  await picture(page, 'adding');
  await dialog().getByRole('button', { name: 'Add and start again' }).click();
  await page.getByText('my_pyramid is in the scene').first().waitFor();
  assert.match(scene(), /fixtures:\n {2}my_pyramid: \{mesh: \{file: "meshes\/my pyramid.stl", unit: cm\}, at: \[0.5, 0, 0\]\}/);
  assert.match(readFileSync(join(at.cell.folder, 'cell.yaml'), 'utf8'), /^scene: scene.yaml$/m);
});

test('a mesh that is dropped on any page can be a part, on a phone, too', async () => {
  await go(page, 'Run');
  await page.setViewportSize({ width: 390, height: 844 });
  const data = await page.evaluateHandle((text) => {
    const out = new DataTransfer();
    out.items.add(new File([text], 'part.stl'));
    return out;
  }, kPyramid);
  await page.getByRole('main').dispatchEvent('drop', { dataTransfer: data });
  const box = await dialog().boundingBox();
  assert.ok(box.x >= 0 && box.x + box.width <= 390, `the dialog is from ${box.x} to ${box.x + box.width} px`);
  await dialog().getByText('Part: can be picked up').click();
  await dialog().getByLabel('Mass').fill('0.25');
  await dialog().getByLabel('y', { exact: true }).fill('0.3');
  await dialog().getByRole('button', { name: 'Add and start again' }).click();
  await page.getByText('part is in the scene').first().waitFor();
  await page.setViewportSize({ width: 1280, height: 800 });
  await go(page, 'Cell');
  assert.match(scene(), /parts:\n {2}part: \{mesh: \{file: "meshes\/part.stl", unit: mm\}, at: \[0.5, 0.3, 0\], mass: 0.25kg\}/);
});

test('what is no mesh is refused in words, and nothing is written', async () => {
  const before = scene();
  const input = page.locator('input[type=file]');
  await page.getByRole('button', { name: 'Add a mesh' }).waitFor();
  await input.setInputFiles({ name: 'notes.txt', mimeType: 'text/plain', buffer: Buffer.from('x') });
  await page.getByText(/None of these files is a mesh/).first().waitFor();
  await input.setInputFiles({ name: 'broken.stl', mimeType: 'model/stl', buffer: Buffer.from('nothing') });
  await page.getByText(/broken\.stl/).first().waitFor();
  await until(() => !existsSync(join(at.cell.folder, 'meshes', 'broken.stl')), 10, 'no file');
  assert.equal(scene(), before);
});
