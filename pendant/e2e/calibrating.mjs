// The payload is weighed and the joints are calibrated on the page; the cell file keeps the results, and a new start uses them.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync, renameSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { go, picture } from './browser.mjs';
import { polyarm, until } from './cell.mjs';
import { suite } from './suite.mjs';

/** Joint states in degrees, in which the hand points in many directions. */
const kPoses = [
  [0, -90, 90, -90, -90, 0],
  [20, -80, 80, -90, 0, 0],
  [40, -100, 100, -90, 0, 90],
  [-30, -70, 60, 10, -90, 40],
  [-50, -110, 110, -150, -60, -80],
  [10, -60, 70, -40, 60, 120],
  [60, -90, 40, -20, -120, -40],
  [-20, -120, 120, -60, 30, 60],
  [30, -75, 95, -160, -30, -120],
  [-60, -95, 75, -70, 100, 20],
  [50, -65, 45, -110, -80, 150],
  [0, -105, 85, 20, -40, -20],
];
const rad = (degrees) => (degrees * Math.PI) / 180;
/** The errors of the real arm's joints, rad. */
const kErrors = [0, 0.01, -0.015, 0.008, 0, 0];
const kNames = ['shoulder_pan', 'shoulder_lift', 'elbow', 'wrist_1', 'wrist_2', 'wrist_3'];

const turns = kPoses.map((pose) => `  movej joints(${pose.map((each) => `${each}deg`).join(', ')})\n  set k = k + 1\n  wait Turn >= k\n`).join('');
const { at, test, atRest } = suite({
  lines: true,
  example: 'r6bot',
  change: (folder) => {
    const files = {
      'cell.yaml': `polyarm: cell/1
robots:
  arm: {model: universal_robots/ur5e, hardware: mujoco, tool: suction_cup, force_sensor: true}
scene: scene.yaml
signals: signals.yaml
program: job.script
`,
      // What the program waits for, and what a measuring device writes.
      'signals.yaml': 'polyarm: signals/1\ntags:\n  Suck: {command: arm/tool/vacuum}\nlive: [steps]\n',
      'steps.data': steps(0, null),
      'scene.yaml': `polyarm: scene/1
fixtures:
  stand: {box: [200mm, 200mm, 200mm], at: [500mm, 0, 100mm]}
parts:
  block: {box: [80mm, 80mm, 40mm], at: [500mm, 0, 220mm], mass: 600g}
`,
      'job.script': `load steps
let k = 0
let top = pose(500mm, 0mm, 240mm, 180deg, 0deg, 0deg)
moveto offset(top, z = 60mm)
movel top, speed 20mm/s, touch
set Suck = true
wait 500ms
movel offset(top, z = 250mm)
while true
${turns}end
`,
    };
    for (const [name, text] of Object.entries(files)) writeFileSync(join(folder, name), text);
  },
  chain: true,
});

function steps(turn, seen) {
  const [p, rpy] = seen ?? [[0.4, 0.1, 0.3], [0, 0, 0]];
  return `Name: Turn\nNum: ${turn}\nPose: RPY\nName: Seen\nPoint: ${[...p, ...rpy].join(', ')}\n`;
}
let turn = 0;
/** Writes the live file at once, as another program does. */
const write = (seen = null) => {
  const file = join(at.cell.folder, 'steps.data');
  writeFileSync(`${file}.new`, steps(turn, seen));
  renameSync(`${file}.new`, file);
};
let page;
const button = (name, on = page) => on.getByRole('button', { name, exact: true });
const said = (text) => page.getByRole('region', { name: 'Messages' }).getByText(text).first().waitFor();
const cellFile = () => readFileSync(join(at.cell.folder, 'cell.yaml'), 'utf8');
const pose = () => turn % kPoses.length;
const here = () => kPoses[pose()].every((degrees, i) => Math.abs(at.watcher.value(`arm/${kNames[i]}_joint/position`) - rad(degrees)) < 0.003);
const arrived = async () => {
  await until(() => at.watcher.events.status?.program?.state === 'waiting' && here(), 120, `pose ${pose() + 1}`);
  await atRest();
};
const next = async () => {
  ++turn;
  write();
  await arrived();
};
/** What a device sees of the flange of the real arm. */
const measure = () => {
  const q = kPoses[pose()].map((degrees, i) => rad(degrees) + kErrors[i]);
  const { xyz, rpy } = JSON.parse(execFileSync(polyarm, ['fk', 'universal_robots/ur5e', '--json', '--joints', ...q.map(String)], { encoding: 'utf8' }));
  return [xyz, rpy];
};
const startAgain = async (wizard) => {
  turn = 0;
  write();
  await button('Start the cell again', wizard).click();
  await wizard.getByText(/does not use the change/).waitFor({ state: 'detached' });
  await button('Close', wizard).first().click();
  await go(page, 'Run');
  if (at.watcher.events.status?.program?.state !== 'waiting') await button('Start').click({ timeout: 10_000 }).catch(() => undefined);
  await arrived();
};
const wizardOf = async (name) => {
  await go(page, 'Cell');
  await button(name).click();
  return page.getByRole('dialog', { name });
};

test('a payload is not found from one direction, and the reason is shown', async () => {
  page = await at.open();
  await button(/^In control/).waitFor();
  await arrived();
  const wizard = await wizardOf('Weigh the payload');
  for (const n of [1, 2, 3]) {
    await button(`Take pose ${n}`, wizard).click();
    await button(`Leave out pose ${n}`, wizard).waitFor();
  }
  await wizard.getByRole('alert').getByText(/hardly changes its direction/).waitFor();
  assert.ok(await button('Save payload', wizard).isDisabled());
  await picture(page, 'payload-refused');
  for (const n of [3, 2]) await button(`Leave out pose ${n}`, wizard).click();
});

test('the payload is weighed in six poses and stored', async () => {
  const wizard = page.getByRole('dialog', { name: 'Weigh the payload' });
  for (const n of [2, 3, 4, 5, 6]) {
    await next();
    await button(`Take pose ${n}`, wizard).click();
    await button(`Leave out pose ${n}`, wizard).waitFor();
  }
  const found = await wizard.getByRole('region', { name: 'Result' }).getByText(/^Mass/).innerText();
  const mass = Number(/Mass ([\d.]+) kg/.exec(found)[1]);
  assert.ok(Math.abs(mass - 0.6) < 0.02, found);
  await picture(page, 'payload-found');
  await button('Save payload', wizard).click();
  await said(/is saved in cell.yaml/);
  assert.match(cellFile(), /payload: \{mass: 0\.(59|60)\dkg/);
  await picture(page, 'payload-saved');
});

test('the cell that starts again knows the payload, and new poses confirm it', async () => {
  await startAgain(page.getByRole('dialog', { name: 'Weigh the payload' }));
  const wizard = await wizardOf('Weigh the payload');
  for (const n of [1, 2]) {
    if (n > 1) await next();
    await button(`Take pose ${n}`, wizard).click();
    await button(`Leave out pose ${n}`, wizard).waitFor();
  }
  const left = await wizard.getByRole('region', { name: 'Result' }).getByText(/^Left over/).innerText();
  assert.ok(Number(/Left over: ([\d.]+) N/.exec(left)[1]) < 0.5, left);
  await wizard.getByText(/^The cell has a payload of 0\.(59|6)/).waitFor();
  await picture(page, 'payload-checked');
  await button('Close', wizard).first().click();
});

test('the joints are calibrated from what a device sees, checked, and taken back', async () => {
  const before = cellFile();
  let wizard = await wizardOf('Calibrate the joints');
  await wizard.getByRole('combobox', { name: /^Pose of the target/ }).selectOption('Seen');
  await wizard.getByRole('switch', { name: 'It measures in the base of the robot' }).check();
  await wizard.getByRole('switch', { name: 'The target is the flange itself' }).check();
  for (let n = 1; n <= 10; ++n) {
    if (n > 1) await next();
    const seen = measure();
    write(seen);
    await until(async () => Math.hypot(...(await at.watcher.request('points')).values.find((each) => each.name === 'Seen').pose.p.map((v, i) => v - seen[0][i])) < 1e-6, 30, 'the device');
    await button(`Take pose ${n}`, wizard).click();
    await button(`Leave out pose ${n}`, wizard).waitFor();
  }
  const row = wizard.getByRole('row', { name: /^elbow/ });
  assert.match(await row.innerText(), /−0\.8[56]\d °/, 'the error of the elbow');
  await picture(page, 'joints-found');
  await button('Save calibration', wizard).click();
  await said(/The calibration of arm is saved/);
  assert.match(cellFile(), /calibration: arm_calibration\.yaml/);
  await button('Undo the last calibration', wizard).click();
  await said(/The calibration of arm is as before/);
  assert.equal(cellFile(), before);
  assert.deepEqual(page.problems, []);
});
