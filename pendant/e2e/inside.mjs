// A simulated robot that starts inside an obstacle is thrown out of it: the fault names the obstacle.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { picture } from './browser.mjs';
import { until } from './cell.mjs';
import { suite } from './suite.mjs';

const { at, test } = suite({
  lines: true,
  change: (folder) => {
    const file = join(folder, 'scene.yaml');
    writeFileSync(file, readFileSync(file, 'utf8').replace('bins:', '  post: {box: [0.06, 0.06, 0.6], at: [0.28, -0.02, 0.3]}\nbins:'));
  },
});

test('a joint that jumps because the robot is inside something is said to, with what it is inside', async () => {
  const page = await at.open();
  await until(() => at.watcher.events.status?.state === 'fault', 60, 'the fault');
  const strip = page.getByRole('alert', { name: 'Alarm' });
  await strip.getByText(/^A measured joint position jumped/).waitFor();
  await strip.getByText(/is inside fixture post where it starts, .* deep · Press Recover/).waitFor();
  await picture(page, 'inside');
  assert.deepEqual(page.problems, []);
});
