// What an operator sees in every state: Stop in its corner, what is not current left blank, presses that count, and both sides of a question.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { go, picture, screen, state, stopKey } from './browser.mjs';
import { until, Watcher } from './cell.mjs';
import { suite } from './suite.mjs';

/** A program that moves and waits without end. */
const endless = (folder) => {
  const file = join(folder, 'cell.yaml');
  writeFileSync(file, readFileSync(file, 'utf8').replace(/^program:.*$/m, 'program: endless.script').replace(/^plc:.*\n/m, ''));
  writeFileSync(join(folder, 'endless.script'), 'load PAPpoints\nwhile true\n  moveto PrePick, speed 4%\n  wait time 3\n  moveto PrePlace, speed 4%\n  wait time 3\nend\n');
};
// Its moves are slow, so that Pause finds one under way on a busy machine, too.
const { at, test: run, atRest, endProgram } = suite({ lines: true, change: endless });
const { cell } = at;
let page;
/** Each case can be run alone. */
const test = (name, body) =>
  run(name, async (t) => {
    if (!page) {
      page = await at.open();
      await button(/^In control/).waitFor();
    }
    await body(t);
  });
const main = (on = page) => on.getByRole('main');
const button = (name, on = page) => on.getByRole('button', { name, exact: true });
const kPages = ['Run', 'Move', 'Program', 'Points', 'Signals', 'Plots', 'Health', 'Cell'];
const open = async (on, name) => {
  await on.evaluate((hash) => (location.hash = hash), `#/${name.toLowerCase()}`);
  await main(on).getByText('Loading…').waitFor({ state: 'detached' });
};
/** The program runs, begun anew where a case before has ended it. */
const runs = async () => {
  if (at.watcher.events.status?.program?.ended === false) return;
  await open(page, 'Run');
  await main().getByRole('button', { name: 'Start', exact: true }).click();
  await until(() => at.watcher.events.status?.program?.ended === false, 30, 'the program');
};
/** Pairs of parts of the bar with less than 3 px between them. */
const overlaps = () =>
  page.evaluate(() => {
    const parts = [...document.querySelectorAll('.robot-bar .state, .robot-bar .modes, .robot-bar .override, .robot-bar .go .button, .robot-bar .stop-button')];
    const boxes = parts.map((part) => ({ name: part.className, ...part.getBoundingClientRect().toJSON() })).filter((box) => box.width > 0);
    return boxes.flatMap((a, i) =>
      boxes.slice(i + 1).filter((b) => a.left < b.right + 3 && b.left < a.right + 3 && a.top < b.bottom + 3 && b.top < a.bottom + 3).map((b) => `${a.name} and ${b.name}`),
    );
  });
const corner = async (on) => Object.values(await stopKey(on).boundingBox()).map(Math.round).join();

test('Stop stays in one corner at one size, on every page and in every state', async () => {
  const held = async () => (await stopKey(page).click(), state(page).getByText('Held').waitFor());
  for (const [width, height] of [[1440, 900], [1024, 768], [390, 844]]) {
    await page.setViewportSize({ width, height });
    const places = new Set();
    for (const name of kPages) {
      await open(page, name);
      places.add(await corner(page));
    }
    await held();
    places.add(await corner(page));
    for (const name of ['Run', 'Move']) {
      await open(page, name);
      places.add(await corner(page));
    }
    await picture(page, `held-${width}`);
    assert.equal(places.size, 1, [...places].join(' | '));
    const box = await stopKey(page).boundingBox();
    assert.ok(width - box.x - box.width < 24 && height - box.y - box.height < 90, 'at the right, at the bottom');
    await button('Resume', at.bar()).click();
    await until(() => at.watcher.events.status?.state === 'running', 30, 'running');
  }
  await page.setViewportSize({ width: 1280, height: 800 });
});

test('there is one Pause, which becomes Resume; what is held can be canceled in words', async () => {
  await open(page, 'Run');
  await runs();
  await until(() => at.watcher.speed() > 0.05, 90, 'motion');
  assert.equal(await button('Pause').count(), 1);
  await button('Pause').click();
  await state(page).getByText('Held').waitFor();
  assert.equal(await button('Pause').count(), 0);
  assert.equal(await button('Resume').count(), 1);
  await until(async () => (await at.bar().getByText('Cancel motion', { exact: true }).count()) === 1, 30, 'Cancel motion');
  for (const width of [1440, 1024, 390, 1280]) {
    await page.setViewportSize({ width, height: 800 });
    assert.deepEqual(await overlaps(), [], `${width} px wide`);
  }
  await button('Resume').click();
  await until(() => at.watcher.events.status?.state === 'running', 30, 'running');
});

test('a step of a program that waits says that it is pausing, until it is', async () => {
  const task = () => at.watcher.events.status?.program;
  await open(page, 'Run');
  await runs();
  await until(() => task()?.state === 'waiting' && !task().ended && at.watcher.speed() < 0.002, 90, 'a wait');
  await atRest();
  await main().getByRole('button', { name: 'Step' }).click();
  await state(page).getByText('Pausing…').waitFor();
  await until(() => task()?.paused, 60, 'the pause');
  await state(page).getByText('Program paused').waitFor();
  await button('Resume', at.bar()).click();
  await until(() => !task()?.paused, 30, 'going on');
  await endProgram();
});

test('parts that an outfeed has taken away count as done', async () => {
  const parts = main().getByText('Parts', { exact: true }).locator('..');
  const taken = () => (at.watcher.events.parts?.parts ?? []).filter((each) => each.taken);
  assert.ok(Array.isArray(taken()));
  await parts.getByText(/^\d of 3/).waitFor();
});

test('each press of a step counts, however fast they come', async () => {
  await open(page, 'Move');
  await page.getByRole('radiogroup', { name: 'Move in' }).getByText('Base').click();
  await page.getByLabel('Step').selectOption({ label: '10 mm · 5°' });
  await page.getByRole('slider', { name: 'Jog speed' }).fill('10');
  await atRest();
  const z = at.watcher.value('arm/tcp/z');
  for (let i = 0; i < 5; ++i) await button('Z plus').click();
  await main().getByText(/^\d steps to go$/).waitFor();
  await until(() => Math.abs(at.watcher.value('arm/tcp/z') - (z + 0.05)) < 5e-4, 60, 'five steps of 10 mm');
  await page.getByLabel('Step').selectOption({ label: 'While held' });
});

test('each press of an arrow key changes the speed by one, and a stop drops steps that wait', async () => {
  const slider = at.bar().getByRole('slider', { name: 'Speed' });
  await slider.focus();
  await page.keyboard.press('End');
  await until(() => at.watcher.events.status?.override === 100, 30, '100 %');
  for (let i = 0; i < 7; ++i) await page.keyboard.press('ArrowLeft');
  await until(() => at.watcher.events.status?.override === 93, 30, '93 %');
  assert.equal(await slider.inputValue(), '93');
  await page.keyboard.press('End');
  await until(() => at.watcher.events.status?.override === 100, 30, '100 %');
  await page.getByLabel('Step').selectOption({ label: '10 mm · 5°' });
  await page.getByRole('slider', { name: 'Jog speed' }).fill('2');
  const z = at.watcher.value('arm/tcp/z');
  const waiting = async () => Number(/^\d+/.exec((await main().getByText(/steps to go$/).allInnerTexts())[0] ?? '0')[0]);
  let pressed = 0;
  await until(async () => (await button('Z minus').click(), ++pressed, (await waiting()) >= 3), 60, 'steps that wait');
  await page.keyboard.press('Escape');
  await stopKey(page).click();
  await atRest();
  await main().getByText(/steps to go$/).waitFor({ state: 'detached' });
  assert.ok(z - at.watcher.value('arm/tcp/z') < 0.01 * pressed - 0.005, 'not all of them were gone');
  await button('Resume', at.bar()).click();
  await until(() => at.watcher.events.status?.state === 'running', 30, 'running');
  await page.getByLabel('Step').selectOption({ label: 'While held' });
});

test('a forced value is told on every page', async () => {
  await open(page, 'Signals');
  await page.getByRole('button', { name: 'Open PartHeld', exact: true }).click();
  const dialog = page.getByRole('dialog', { name: 'PartHeld' });
  await dialog.getByRole('button', { name: /^(Force|Simulate)$/ }).click();
  await dialog.getByRole('button', { name: 'Close' }).click();
  for (const name of kPages) {
    await open(page, name);
    await page.getByRole('link', { name: /^Forced values: PartHeld/ }).waitFor();
  }
  await picture(page, 'forced');
  await open(page, 'Signals');
  await page.getByRole('button', { name: 'Open PartHeld', exact: true }).click();
  await dialog.getByRole('button', { name: /^Release/ }).click();
  await dialog.getByRole('button', { name: 'Close' }).click();
  await page.getByRole('link', { name: /^Forced values/ }).waitFor({ state: 'detached' });
});

test('a file that is not checked is not called right', async () => {
  await open(page, 'Program');
  await page.getByRole('button', { name: /^Program .*open another$/ }).click();
  const files = page.getByRole('dialog', { name: 'Programs' });
  await files.getByText('All files').click();
  await files.getByRole('button', { name: /^cell\.yaml/ }).click();
  await main().getByText(/^Not checked here/).waitFor();
  assert.equal(await main().getByText('No problems found').count(), 0);
  await page.getByRole('button', { name: /^Program .*open another$/ }).click();
  await files.getByRole('button', { name: /^PAPscript\.script/ }).click();
  await main().getByText('No problems found').waitFor();
});

test('who is asked for control and who asks both see it', async () => {
  await open(page, 'Move');
  const other = await screen(at.chrome.browser, cell.link);
  try {
    await open(other, 'Move');
    await main(other).getByRole('status').getByText('You only watch. Take control first.').waitFor();
    assert.equal(await main(other).getByText('Free to move').count(), 0, 'who only watches is not free to move');
    await button('Take control', main(other)).click();
    await main(other).getByText(/^Asked .+ for control: \d+ s$/).waitFor();
    await page.getByRole('dialog', { name: /asks for control$/ }).waitFor();
    await picture(other, 'asked');
    await page.getByRole('dialog').getByRole('button', { name: 'Keep control' }).click({ timeout: 8000 }).catch(() => undefined);
  } finally {
    await other.context().close();
  }
  if (await button('Take control', main()).isVisible()) await button('Take control', main()).click();
  await button(/^In control/).waitFor();
});

test('an alarm is told once, in one strip; a page that comes later is not told of what is over', async () => {
  const strip = page.getByRole('alert', { name: 'Alarm' });
  const program = 'load PAPpoints\nwait 10ms\nraise "the gripper is empty"\n';
  writeFileSync(join(cell.folder, 'fails.script'), program);
  await open(page, 'Program');
  await page.getByRole('button', { name: /^Program .*open another$/ }).click();
  await page.getByRole('dialog').getByRole('button', { name: /^fails\.script/ }).click();
  await main().getByRole('button', { name: 'Start' }).click();
  await strip.waitFor();
  assert.equal(await page.getByRole('region', { name: 'Messages' }).getByText(/gripper is empty/).count(), 0, 'no toast beside it');
  await picture(page, 'alarm');
  await button('Mark as seen', strip).click();
  await strip.waitFor({ state: 'detached' });
  await page.reload();
  await button(/^In control/).waitFor();
  await page.waitForTimeout(1000);
  assert.equal(await strip.count(), 0);
  assert.equal(await page.getByRole('region', { name: 'Messages' }).getByText(/gripper is empty/).count(), 0);
});

/** A page whose cell tells contacts as a cell does in which something touches; everything else is the real one's. */
async function touched(first) {
  let now = first;
  let last = null;
  let wire = null;
  const send = () => last && wire.send(JSON.stringify({ ...last, ...now }));
  const other = await at.chrome.browser.newContext({ viewport: { width: 1280, height: 800 }, locale: 'en-GB', colorScheme: 'dark' }).then((each) => each.newPage());
  await other.routeWebSocket(/\/ws$/, (socket) => {
    wire = socket;
    const server = socket.connectToServer();
    server.onMessage((data) => {
      if (typeof data !== 'string' || !data.includes('"event":"status"')) return socket.send(data);
      last = JSON.parse(data);
      send();
    });
  });
  await other.goto(cell.link);
  return { other, tell: (next) => ((now = next), send()) };
}

test('a contact is told with its pair and depth, and leads back step by step', async () => {
  const told = {
    state: 'held', cause: 'something was touched', cause_code: 'contact', motion_left: true,
    contacts: { checked: true, stop: 1, touching: true, unchecked: [], list: [{ a: 'arm/wrist_3_link', b: 'tray', robot: 'arm', at_s: 1, depth: 0.0021, position: [0.3, -0.15, 0.14], now: true, doing: 'jog', where: '', text: '' }] },
    can: { resume: { code: 'in-contact', what: 'still touching' }, back: { code: 'nothing-to-step-back', what: 'nothing' }, discard: null },
  };
  const { other, tell } = await touched(told);
  try {
    await state(other).getByText('Stopped after contact').waitFor();
    const strip = other.getByRole('alert', { name: 'Stopped after contact' });
    await strip.getByText('arm/wrist_3_link and tray, 2.1 mm deep').waitFor();
    assert.equal(await button('Resume', strip).count(), 0, 'not while it touches');
    assert.equal(await button('Step back', strip).count(), 0, 'there is nothing to step back');
    await button('Cancel motion', strip).waitFor();
    await button('Jog away', strip).click();
    await other.getByRole('region', { name: 'Robot view' }).waitFor();
    await picture(other, 'contact');
    tell({ ...told, contacts: { ...told.contacts, touching: false, list: told.contacts.list.map((each) => ({ ...each, now: false })) }, can: {} });
    await button('Resume', strip).waitFor();
    await button('Step back', strip).waitFor();
    await strip.getByText('Cancel the motion first: Resume repeats it, into the same contact.').waitFor();
    tell({ contacts: { checked: false, stop: null, touching: false, unchecked: [], list: [] } });
    await strip.waitFor({ state: 'detached' });
    await other.getByText(/^Contacts are not detected in this cell/).waitFor();
    tell({ contacts: { checked: true, stop: 1, touching: false, unchecked: ['arm/link_3: its collision is a mesh'], list: [] } });
    await other.getByText('Contacts are not detected for 1: arm/link_3: its collision is a mesh').waitFor();
  } finally {
    await other.context().close();
  }
  await button(/^(In control|No control|Watching)/).waitFor();
  if (await button('Take control', main()).isVisible()) await button('Take control', main()).click();
});

test('without a connection Stop is dead, and nothing that is old is shown', async () => {
  await open(page, 'Health');
  await main().getByText('1000 Hz').first().waitFor();
  await open(page, 'Signals');
  await main().locator('tbody td').first().waitFor();
  await open(page, 'Move');
  const shown = main().getByRole('region', { name: /^(TCP position|Joints)$/ });
  await until(async () => /\d/.test((await shown.innerText()).replace(/[^\d]/g, '')), 30, 'values');
  const before = await stopKey(page).boundingBox();
  at.watcher.end();
  await cell.kill();
  await page.getByRole('alert').getByText('Reconnecting…').waitFor();
  const dead = page.getByRole('button', { name: /^Stop .*not connected/ });
  assert.deepEqual(await dead.boundingBox(), before);
  assert.match(await dead.evaluate((each) => getComputedStyle(each).backgroundImage), /repeating-linear-gradient/);
  await until(async () => !/\d/.test((await shown.innerText()).replace(/R?[XYZ]|wrist \d/g, '')), 30, 'blank values');
  await picture(page, 'offline');
  await open(page, 'Signals');
  const values = await main().locator('tbody td:nth-child(2)').allInnerTexts();
  assert.ok(values.length > 0);
  assert.deepEqual(values.filter((each) => each.trim() !== '–'), [], 'values of tags');
  await open(page, 'Health');
  await main().getByText('Not connected').waitFor();
  assert.doesNotMatch(await main().getByRole('region', { name: 'Health' }).innerText(), /\d/);
  await open(page, 'Run');
  await picture(page, 'offline-run');
  await cell.start();
  at.watcher = await new Watcher(cell).start();
  await button(/^In control/).waitFor();
  assert.deepEqual(await stopKey(page).boundingBox(), before);
  await until(async () => /\d/.test(await page.getByText('Cycles').locator('..').innerText()), 30, 'values again');
  assert.deepEqual(page.problems, []);
});
