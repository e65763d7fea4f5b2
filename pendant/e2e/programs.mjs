// Programs while they are made and tried: breakpoints by a click, tasks with their variables, earlier texts, the dry run.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { go, picture, state } from './browser.mjs';
import { until } from './cell.mjs';
import { suite } from './suite.mjs';

const kJob = `load work
# to and fro, and a second task that counts
task mover
  while Go
    movej joints(0deg, -90deg, 0deg, 0deg, 0deg, 0deg), speed 50%
    let third = 1 / 3
    movej joints(20deg, -90deg, 0deg, 0deg, 0deg, 0deg), speed 50%
  end
end
task counter
  while Go
    set Count = Count + 1
    wait 500ms
  end
end
`;
const kReach = `movej joints(0deg, -90deg, 0deg, 0deg, 0deg, 0deg)
movej joints(30deg, -90deg, 0deg, 0deg, 0deg, 0deg)
movel pose(3000mm, 0mm, 500mm, 180deg, 0deg, 0deg)
`;
const { at, test, atRest } = suite({
  example: 'r6bot',
  change: (folder) => {
    writeFileSync(join(folder, 'cell.yaml'), 'polyarm: cell/1\nrobots:\n  arm: {model: r6bot.urdf, hardware: mock}\nprogram: job\n');
    writeFileSync(join(folder, 'work.data'), 'Name: Count\nNum: 0\nName: Go\nBool: True\n');
    writeFileSync(join(folder, 'job.script'), kJob);
    writeFileSync(join(folder, 'reach.script'), kReach);
    writeFileSync(join(folder, 'includes.script'), 'include "lib.script"\nopen_it()\n');
    writeFileSync(join(folder, 'lib.script'), 'func open_it()\n  set Coount = 1\nend\n');
  },
});
let page;
const button = (name) => page.getByRole('button', { name, exact: true });
const side = () => page.getByRole('complementary', { name: 'Run and watch' });
const editor = () => page.getByRole('textbox', { name: 'Text of the program' });
const below = (name) => page.getByRole('radiogroup', { name: 'Below' }).getByText(name, { exact: true }).click();
const said = (text) => page.getByRole('region', { name: 'Messages' }).getByText(text).first().waitFor();
const now = () => at.watcher.events.status.program;
const pausedAt = (line) => until(() => now().paused && now().where.line === line, 90, `a pause at line ${line}`);
/** Presses the number of the line with this text, once it stays where it is. */
const pressNumber = async (text) => {
  let before = null;
  const whole = await until(async () => {
    const now = JSON.stringify(await editor().getByText(text).boundingBox());
    const stays = now === before;
    before = now;
    if (!stays) await page.waitForTimeout(250);
    return stays && (await editor().boundingBox());
  }, 30, 'a page that stands still');
  const words = JSON.parse(before);
  await page.mouse.click(whole.x - 40, words.y + words.height / 2);
};
const openFile = async (name) => {
  await button(/^Program .*open another$/).click();
  await page.getByRole('dialog').getByRole('button', { name: new RegExp(`^${name}`) }).click();
};

test('pauses at a line whose number is pressed, and again at the next start', async () => {
  page = await at.open();
  await page.getByRole('button', { name: /^In control/ }).waitFor();
  await go(page, 'Program');
  await page.getByRole('radiogroup', { name: 'Shown as' }).getByText('Text').click();
  const top = async () => (await editor().boundingBox()).y;
  await page.getByText(/The program runs the text/).waitFor();
  const running = await top();
  await pressNumber('let third');
  await pausedAt(6);
  await side().getByText('job.script, line 6').waitFor();
  await button('Run from line 1').waitFor();
  await editor().getByText('let third').click();
  await page.getByRole('button', { name: 'Breakpoint at line 6', pressed: true }).waitFor();
  await picture(page, 'breakpoint');
  await at.bar().getByRole('button', { name: 'Resume' }).click();
  await until(() => !now().paused, 60, 'going on');
  await pausedAt(6);
  await button('End program').click();
  await page.getByRole('dialog').getByRole('button', { name: 'End program' }).click();
  await until(() => now().ended, 30, 'the end of the program');
  await page.getByText(/The program runs the text/).waitFor({ state: 'detached' });
  assert.equal(await top(), running, 'a notice that comes and goes moves no line');
  await atRest();
  await button('Start').click();
  await pausedAt(6);
});

test('Start waits until the robot that was ended in its motion stands, and says so', async () => {
  await at.bar().getByRole('button', { name: 'Resume' }).click();
  await until(() => !now().paused && at.watcher.events.status.standing === false, 60, 'motion');
  await button('End program').click();
  await page.getByRole('dialog').getByRole('button', { name: 'End program' }).click();
  await button('Start').click();
  await pausedAt(6);
  assert.equal(await page.getByRole('region', { name: 'Messages' }).getByRole('alert').count(), 0, 'nothing was refused');
});

test('shows the tasks with their variables, the one that is paused as the program’s line, and steps it', async () => {
  await below('Variables');
  const mover = side().getByRole('region', { name: 'Task mover' });
  await button('Step').click();
  await pausedAt(7);
  await mover.getByRole('row', { name: 'third 0.333333' }).waitFor();
  await side().getByRole('region', { name: 'Task counter' }).getByText('Waiting').waitFor();
  const names = await side().getByRole('heading').allTextContents();
  assert.equal(names.at(-1), 'main', `what has ended comes last: ${names}`);
  await picture(page, 'tasks');
});

test('moves a breakpoint with its line while lines are written above, and what runs keeps its own', async () => {
  const mark = (line, pressed) => page.getByRole('button', { name: `Breakpoint at line ${line}`, pressed });
  const told = async () => (await at.watcher.request('program')).breakpoints.map((each) => each.line);
  await editor().click();
  await page.keyboard.press('Control+Home');
  await page.keyboard.type('# one more');
  await page.keyboard.press('Enter');
  await editor().getByText('let third').click();
  await mark(7, true).waitFor();
  await page.getByText('Draft, stored on the cell').waitFor();
  await until(async () => String(await told()) === '7', 30, 'the cell knowing it at line 7');
  await picture(page, 'breakpoint-moved');
  const shownAs = (name) => page.getByRole('radiogroup', { name: 'Shown as' }).getByText(name).click();
  await shownAs('Steps');
  const steps = page.getByRole('list', { name: 'Steps' });
  await steps.getByRole('button', { name: /^7\s*New value third.*Breakpoint$/ }).waitFor();
  assert.equal(await steps.getByRole('img', { name: 'Breakpoint' }).count(), 1);
  await picture(page, 'breakpoint-steps');
  await steps.getByRole('button', { name: /^7\s*New value/ }).click();
  await button('Move up').click();
  await steps.getByRole('button', { name: /^6\s*New value third.*Breakpoint$/ }).waitFor();
  await button('Undo').click();
  await steps.getByRole('button', { name: /^7\s*New value third.*Breakpoint$/ }).waitFor();
  await shownAs('Text');
  await at.bar().getByRole('button', { name: 'Resume' }).click();
  await pausedAt(6);
  await page.reload();
  await page.getByRole('button', { name: /^In control/ }).waitFor();
  await editor().getByText('let third').click();
  await mark(7, true).waitFor();
  assert.deepEqual(await told(), [7]);
  // The draft goes, and with it the line above.
  await button('Discard draft').click();
  await page.getByRole('dialog').getByRole('button', { name: 'Discard draft' }).click();
  await editor().getByText('let third').click();
  await mark(6, true).waitFor();
  await until(async () => String(await told()) === '6', 30, 'the cell knowing it at line 6');
});

test('keeps breakpoints of a program that is not begun for its start, over a new scene, and takes them off', async () => {
  await button('End program').click();
  await page.getByRole('dialog').getByRole('button', { name: 'End program' }).click();
  await until(() => now().ended, 60, 'the end');
  await openFile('reach.script');
  await pressNumber('30deg');
  await editor().getByText('30deg').click();
  const mark = (pressed) => page.getByRole('button', { name: 'Breakpoint at line 2', pressed });
  await mark(true).waitFor();
  await go(page, 'Cell');
  await button('Reset the scene').click();
  await page.getByRole('dialog').getByRole('button', { name: 'Reset the scene' }).click();
  await said('The scene is as at the start');
  await go(page, 'Program');
  await editor().getByText('30deg').click();
  await mark(true).waitFor();
  await side().getByText('No program has been started.').waitFor();
  assert.equal(await page.getByText(/^This program is running/).count(), 0, 'nothing runs');
  await button('Start').click();
  await pausedAt(2);
  await mark(true).click();
  await mark(false).waitFor();
  await button('End program').click();
  await page.getByRole('dialog').getByRole('button', { name: 'End program' }).click();
  await button('Start').waitFor();
  await assert.rejects(at.watcher.request('program.break', { at: ['reach.script:1'] }), /has control/, 'who watches sets no breakpoints');
});

test('lists what a dry run finds by line, and shows it in 3D', async () => {
  await below('Problems');
  await button('Dry run').click();
  await side().getByText('Dry run: some moves are impossible').waitFor();
  await side().getByRole('button', { name: /^Line 3 · Error/ }).click();
  await button('Breakpoint at line 3').waitFor();
  await button('Show it in 3D').click();
  await side().getByRole('region', { name: 'Robot view' }).getByRole('button', { name: 'Views' }).waitFor();
  await picture(page, 'dry');
});

test('lists errors of included files with their file, and opens it', async () => {
  await below('Problems');
  await openFile('includes.script');
  const error = side().getByRole('button', { name: /^lib\.script, line 2 · Error/ });
  await error.waitFor();
  assert.ok(await side().getByRole('button', { name: 'Start', exact: true }).isDisabled());
  await error.click();
  await button(/^Program lib\.script/).waitFor();
  await side().getByRole('button', { name: /^Line 2 · Error/ }).waitFor();
  await openFile('reach.script');
  await below('3D view');
});

test('keeps every text that was saved, shows it beside that of now, and puts it back', async () => {
  for (const text of ['# first\n', '# second\n']) {
    await editor().click();
    await page.keyboard.press('Control+Home');
    await page.keyboard.insertText(text);
    await button('Save').click();
    const file = () => readFileSync(join(at.cell.folder, 'reach.script'), 'utf8');
    await until(() => file().startsWith(text), 20, 'the file with what was typed');
    assert.equal(file().split(text).length, 2, file());
  }
  await button('Versions').click();
  const dialog = page.getByRole('dialog', { name: 'Versions of reach.script' });
  const versions = dialog.getByRole('list').getByRole('button', { name: /^until / });
  await versions.nth(1).click();
  const differences = page.getByRole('group', { name: /· Now$/ });
  await until(async () => (await differences.getByText('# first').count()) === 1, 60, 'the oldest text, which has it on one side alone');
  await picture(page, 'versions');
  await dialog.getByRole('button', { name: 'Take this version' }).click();
  await dialog.waitFor({ state: 'detached' });
  await editor().getByText('# first').waitFor({ state: 'detached' });
  await button('Save').click();
  await page.getByText('Saved', { exact: true }).waitFor();
  assert.equal(readFileSync(join(at.cell.folder, 'reach.script'), 'utf8'), kReach);
  await state(page).getByText('Ready', { exact: true }).waitFor();
  assert.deepEqual(page.problems, []);
});

test('says by name who has changed a signal', async () => {
  await go(page, 'Signals');
  const row = page.getByRole('row', { name: /^Go / });
  await row.getByRole('button', { name: /^Turn Go o(n|ff)$/ }).click();
  await row.getByText(/^Browser \d+, .* ago$/).waitFor();
  await picture(page, 'changed-by');
});
