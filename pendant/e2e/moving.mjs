// Moving by hand to a place and in a frame of one's own: what is shown beforehand, and that the robot does just that.
import assert from 'node:assert/strict';
import { appendFileSync } from 'node:fs';
import { join } from 'node:path';
import { go, picture, stopKey } from './browser.mjs';
import { until } from './cell.mjs';
import { suite, waitAboveThePart } from './suite.mjs';

/** Frames turned by odd angles, one within the other. */
const kTray = [0.3, -0.4, 0.5];
const withFrames = (folder) => {
  waitAboveThePart(folder);
  appendFileSync(join(folder, 'PAPpoints.points'), `\nName: Tray\nPoint: 0.3, -0.2, 0.1, ${kTray.join(', ')}\nName: Slot\nValue: pose(0.1, 0.05, 0, 0, 0, 0.7, frame = "Tray")\n`);
};
const { at, test, arrive, atRest, endProgram, hold, holdKey } = suite({ lines: true, change: withFrames });
let page;
const button = (name, on = page) => on.getByRole('button', { name, exact: true });
const tcp = () => ['x', 'y', 'z'].map((axis) => at.watcher.value(`arm/tcp/${axis}`));
const minus = (a, b) => a.map((v, i) => v - b[i]);
const norm = (a) => Math.hypot(...a);
const dot = (a, b) => a.reduce((sum, v, i) => sum + v * b[i], 0);
const still = async () => {
  const from = at.watcher.time;
  await until(() => at.watcher.time > from + 0.4, 60, 'a moment');
};

// --- frames

/** Columns are the axes: turned about x, then y, then z. */
function axesOf([r, p, y]) {
  const [a, b, c, d, e, f] = [Math.cos(r), Math.sin(r), Math.cos(p), Math.sin(p), Math.cos(y), Math.sin(y)];
  return [[e * c, f * c, -d], [e * d * b - f * a, f * d * b + e * a, c * b], [e * d * a + f * b, f * d * a - e * b, c * a]];
}
function axesOfQuaternion([x, y, z, w]) {
  return [
    [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
    [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
    [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
  ];
}
const rotation = () => ['qx', 'qy', 'qz', 'qw'].map((name) => at.watcher.value(`arm/tcp/${name}`));
/** How far off an axis a way leads, and how long it is along it. */
const along = (way, axis) => ({ by: dot(way, axis), off: norm(minus(way, axis.map((v) => v * dot(way, axis)))) });

test('opens, and its program is ended', async () => {
  page = await at.open(at.cell.link, { before: () => {
    const pad = { id: 'made up', index: 0, connected: true, mapping: 'standard', axes: [0, 0, 0, 0], buttons: Array.from({ length: 17 }, () => ({ pressed: false, touched: false, value: 0 })) };
    globalThis.madeUpPad = pad;
    navigator.getGamepads = () => [pad, null, null, null];
  } });
  await page.getByRole('button', { name: /^In control/ }).waitFor();
  await endProgram();
  await go(page, 'Move');
  await page.getByRole('slider', { name: 'Jog speed' }).fill('10');
});

test('moves along the axes of frames that are turned by odd angles, held and by steps', async () => {
  await page.getByRole('radiogroup', { name: 'Move in' }).getByText('Frame', { exact: true }).click();
  const tray = axesOf(kTray);
  const slot = axesOf([0, 0, 0.7]).map((axis) => [0, 1, 2].map((k) => axis.reduce((sum, v, i) => sum + v * tray[i][k], 0)));
  for (const [name, axes, keys] of [['Tray', tray, ['Z plus', 'X minus', 'Y plus']], ['Slot', slot, ['Z minus', 'X plus', 'Y minus']]]) {
    await page.getByRole('combobox', { name: 'Frame' }).selectOption(name);
    for (const label of keys) {
      const [axis, sign] = ['XYZ'.indexOf(label[0]), label.endsWith('plus') ? 1 : -1];
      const before = tcp();
      await holdKey(button(label), () => norm(minus(tcp(), before)) > 0.02, 'the TCP moving');
      await page.mouse.up();
      await atRest();
      const way = along(minus(tcp(), before), axes[axis]);
      assert.ok(way.by * sign > 0.02 && way.off < 5e-4, `${name} ${label}: ${way.by} along, ${way.off} off`);
    }
    await page.getByLabel('Step').selectOption({ label: '10 mm · 5°' });
    const before = tcp();
    await button('Z minus').click();
    await until(() => norm(minus(tcp(), before)) > 0.0098, 60, 'the step');
    await atRest();
    const way = along(minus(tcp(), before), axes[2]);
    assert.ok(Math.abs(way.by + 0.01) < 2e-4 && way.off < 2e-4, `${name}, a step: ${way.by} along, ${way.off} off`);
    await page.getByLabel('Step').selectOption({ label: 'While held' });
  }
  await picture(page, 'in-a-frame');
});

test('turns by the angle that the step says, about the axis of the frame', async () => {
  await page.getByLabel('Step').selectOption({ label: '50 mm · 5°' });
  const before = rotation();
  await button('RZ plus').click();
  const turned = () => 2 * Math.acos(Math.min(1, Math.abs(dot(before, rotation()))));
  await until(() => turned() > 0.086, 60, 'the turn');
  await atRest();
  assert.ok(Math.abs((turned() * 180) / Math.PI - 5) < 0.1, `${(turned() * 180) / Math.PI}°`);
  await page.getByLabel('Step').selectOption({ label: 'While held' });
});

test('moves in the tool’s own axes by keyboard, and in the frame by gamepad', async () => {
  await button('Keyboard').click();
  await page.getByRole('button', { name: 'Keyboard', pressed: true }).waitFor();
  await page.keyboard.press('m');  // from one's own frame on to the joints
  await page.getByRole('radiogroup', { name: 'Move in' }).getByRole('radio', { name: 'Joints', checked: true }).waitFor({ state: 'attached' });
  await page.keyboard.press('m');
  await page.keyboard.press('m');
  await page.getByRole('radiogroup', { name: 'Move in' }).getByRole('radio', { name: 'Tool', checked: true }).waitFor({ state: 'attached' });
  const axes = axesOfQuaternion(rotation());
  let before = tcp();
  await hold({ down: () => page.keyboard.down('d'), up: () => page.keyboard.up('d') }, () => norm(minus(tcp(), before)) > 0.01, 'the TCP going back in z');
  await page.keyboard.up('d');
  await atRest();
  let way = along(minus(tcp(), before), axes[2]);
  assert.ok(way.by < -0.01 && way.off < 5e-4, `${way.by} along, ${way.off} off`);
  await button('Keyboard').click();
  await page.getByRole('radiogroup', { name: 'Move in' }).getByText('Frame', { exact: true }).click();
  await page.getByRole('combobox', { name: 'Frame' }).selectOption('Tray');
  await button('Gamepad').click();
  before = tcp();
  const pad = (pressed) => () => page.evaluate((on) => ((madeUpPad.buttons[5] = { pressed: on, touched: on, value: Number(on) }), (madeUpPad.axes = [0, Number(on), 0, 0])), pressed);
  await hold({ down: pad(true), up: pad(false) }, () => norm(minus(tcp(), before)) > 0.01, 'the TCP going back in x');
  await pad(false)();
  await atRest();
  way = along(minus(tcp(), before), axesOf(kTray)[0]);
  assert.ok(way.by < -0.01 && way.off < 5e-4, `${way.by} along, ${way.off} off`);
  await button('Gamepad').click();
});

test('offers a frame to move in as soon as it is taught', async () => {
  await go(page, 'Points');
  await page.getByRole('textbox', { name: 'Name' }).first().fill('Corner');
  await button('Teach').click();
  await page.getByRole('group', { name: 'Points' }).getByRole('button', { name: /^Corner / }).waitFor();
  await go(page, 'Move');
  await page.getByRole('combobox', { name: 'Frame' }).selectOption('Corner');
});

// --- to a place

test('goes to a point by the joints as long as the key is held: let go, blurred and pressed again', async () => {
  await button('Go to…').click();
  const dialog = page.getByRole('dialog', { name: 'Go to' });
  const key = dialog.getByRole('button', { name: /^(Hold to move there|Moving)/ });
  const told = dialog.getByRole('status');
  await dialog.getByRole('combobox', { name: 'Point' }).selectOption('PrePlace');
  await told.getByText(/shows the path .*\(about \d/).waitFor();
  await picture(page, 'go-to');
  for (const release of [() => page.mouse.up(), () => page.evaluate(() => dispatchEvent(new Event('blur')))]) {
    const before = tcp();
    await holdKey(key, () => norm(minus(tcp(), before)) > 0.01, 'the TCP moving');
    await release();
    await atRest();
    const rest = tcp();
    await still();
    assert.ok(norm(minus(tcp(), rest)) < 1e-3, 'it stays');
    await page.mouse.up();
    await told.getByText(/shows the path .*\(about \d/).waitFor();
  }
  await arrive();
  const { values } = await at.watcher.request('points');
  const place = values.find((each) => each.name === 'PrePlace').world.p;
  assert.ok(norm(minus(tcp(), place)) < 1e-3, `${tcp()} is not ${place}`);
});

test('goes in a straight line, and says before it moves why one cannot be', async () => {
  const dialog = page.getByRole('dialog', { name: 'Go to' });
  const key = dialog.getByRole('button', { name: /^(Hold to move there|Moving)/ });
  const told = dialog.getByRole('status');
  const field = (name) => dialog.getByRole('textbox', { name, exact: true });
  await dialog.getByText('TCP in base').click();
  await button('As it is now', dialog).click();
  await dialog.getByText('Straight line').click();
  const before = tcp();
  // Behind the base: by the joints it gets there, on a line it would have to go through itself.
  await field('X').fill('-300');
  await field('Y').fill('0');
  await told.getByText(/^the path (leaves the robot's reach|meets a singularity)/).waitFor();
  assert.ok(await key.isDisabled());
  await picture(page, 'go-to-impossible');
  assert.ok(norm(minus(tcp(), before)) < 1e-3, 'nothing has moved');
  await dialog.getByText('By joints').click();
  await told.getByText(/shows the path .*\(about \d/).waitFor();
  await dialog.getByText('Straight line').click();
  const to = [before[0] + 0.03, before[1] + 0.06, before[2] + 0.04];
  for (const [i, name] of ['X', 'Y', 'Z'].entries()) await field(name).fill(String(1000 * to[i]));
  await told.getByText(/shows the path .*\(about \d/).waitFor();
  const from = at.watcher.time;
  await arrive();
  assert.ok(norm(minus(tcp(), to)) < 1e-3);
  const axis = minus(to, before).map((v) => v / norm(minus(to, before)));
  const frames = at.watcher.frames.filter((each) => each.time > from);
  const off = frames.map((each) => along(minus(['x', 'y', 'z'].map((k) => at.watcher.value(`arm/tcp/${k}`, each)), before), axis).off);
  assert.ok(frames.length > 10 && Math.max(...off) < 1e-3, `${Math.max(...off)} m off the line`);
  await button('Close', dialog).click();
  await stopKey(page).waitFor();
  assert.deepEqual(page.problems, []);
});
