// A program whose link was never connected waits for it, and the page says so.
import assert from 'node:assert/strict';
import { appendFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { picture, state } from './browser.mjs';
import { suite } from './suite.mjs';

const { at, test } = suite({
  lines: true,
  example: 'r6bot',
  change: (folder) => {
    writeFileSync(join(folder, 'cell.yaml'), 'polyarm: cell/1\nrobots:\n  arm: {model: r6bot.urdf, hardware: mock}\nprogram: job\n');
    appendFileSync(join(folder, 'cell.yaml'), 'signals: signals.yaml\n');
    writeFileSync(join(folder, 'job.script'), 'while true\n  wait 1s\nend\n');
    // Nothing listens at port 1.
    writeFileSync(join(folder, 'signals.yaml'), 'polyarm: signals/1\nlinks:\n  plc: {modbus: client, port: 1, tags: {Go: {coil: 0, direction: in}}}\n');
  },
});

test('a program that has not begun because of a link does not run', async () => {
  const page = await at.open();
  await state(page).getByText('Program waits').waitFor();
  await page.getByRole('main').getByText('waits for the link plc').waitFor();
  await picture(page, 'awaiting');
  assert.deepEqual(page.problems, []);
});
