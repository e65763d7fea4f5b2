// From the link to a robot that does a taught job, by what is visible only: choosing a robot, teaching, writing, running; drafts
// and conflicts. Each test begins where the one before has left the cell.
import assert from 'node:assert/strict';
import { go, launch, state } from './browser.mjs';
import { until, Watcher } from './cell.mjs';
import { suite } from './suite.mjs';

const { at, test, endProgram } = suite({ lines: true, chain: true });
const { cell } = at;
let page, began;

const main = (on) => on.getByRole('main');
const button = (name, on = page) => on.getByRole('button', { name, exact: true });
const shown = (group, name, on = page) => on.getByRole('radiogroup', { name: group }).getByText(name, { exact: true }).click();
const said = (text, on = page) => on.getByRole('region', { name: 'Messages' }).getByText(text).first().waitFor();

test('a robot is chosen from the catalogue', async () => {
  began = Date.now();
  page = await at.open();
  await button(/^In control/).waitFor();
  await endProgram();
  await go(page, 'Cell');
  await shown('Shown', 'Choose robot');
  await page.getByRole('searchbox', { name: 'Search robots' }).fill('ur5e');
  await main(page).getByRole('button', { name: /UR5e/ }).first().click();
  await button('Use this robot').click();
  await said(/The cell has .*UR5e now/);
  await page.getByRole('banner').getByText(/UR5e/).waitFor();
  // What has just been chosen moves nothing before it is started.
  await state(page).getByText('Ready', { exact: true }).waitFor();
});

const kPoints = {
  Over: 'pose(300mm, 150mm, 140mm, 180deg, 0deg, 0deg)',
  Grasp: 'pose(300mm, 150mm, 40mm, 180deg, 0deg, 0deg)',
  Above: 'pose(300mm, -150mm, 140mm, 180deg, 0deg, 0deg)',
  Put: 'pose(300mm, -150mm, 45mm, 180deg, 0deg, 0deg)',
};

test('points are taught', async () => {
  await go(page, 'Points');
  for (const [name, numbers] of Object.entries(kPoints)) {
    await page.getByRole('region', { name: 'Teach a point' }).getByRole('textbox', { name: 'Name' }).fill(name);
    await button('Teach').click();
    await said(`${name} is taught`);
    await button('Edit values').click();
    const dialog = page.getByRole('dialog', { name: `Edit values of ${name}` });
    await dialog.getByRole('textbox', { name: 'Value' }).fill(numbers);
    await dialog.getByRole('button', { name: 'Apply' }).click();
    await said(`${name} is changed`);
  }
  await page.getByRole('searchbox', { name: 'Search points' }).fill('grasp');
  await main(page).getByRole('button', { name: /^Grasp.*X 300.0 Y 150.0 Z 40.0 mm/ }).waitFor();
});

const kProgram = `load cycledata
movej Over
while Repeat
  movej Over, blend 20mm
  movel Grasp
  set ActivateGripper = true
  wait GripperActive
  movel Over, blend 20mm
  movej Above, blend 20mm
  movel Put
  set DeactivateGripper = true
  wait GripperInactive
  movel Above
end
`;

test('a program is written, checked and saved', async () => {
  await go(page, 'Program');
  await button(/^Program .*open another$/).click();
  await button('New program').click();
  await page.getByRole('dialog').getByRole('textbox', { name: 'Name' }).fill('job');
  await button('Create').click();
  await shown('Shown as', 'Text');
  const editor = page.getByRole('textbox', { name: 'Text of the program' });
  await editor.click();
  await page.keyboard.insertText(kProgram.replace('movel Grasp', 'movel Grsp'));
  await page.getByText('1 error', { exact: true }).waitFor();
  await page.getByRole('complementary', { name: 'Run and watch' }).getByText(/Grsp/).first().waitFor();
  await page.keyboard.press('Control+A');
  await page.keyboard.insertText(kProgram);
  await page.getByText('No errors', { exact: true }).waitFor();
  await button('Save').click();
  await said('job.script is saved');
});

test('it is shown as steps, and one is changed by a form', async () => {
  await shown('Shown as', 'Steps');
  const steps = page.getByRole('list', { name: 'Steps' });
  await steps.getByRole('button', { name: /Straight line to Put/ }).click();
  await button('Edit').click();
  await page.getByRole('dialog').getByRole('combobox', { name: 'Speed' }).selectOption('250mm/s');
  await button('Apply').click();
  await steps.getByRole('button', { name: /Straight line to Put\s*speed 250mm\/s/ }).waitFor();
  await button('Undo').click();
  await steps.getByText('speed 250mm/s').waitFor({ state: 'detached' });
});

test('it runs, and parts arrive', async (t) => {
  await button('Start').click();
  await state(page).getByText(/^Program/).waitFor();
  await page.getByRole('list', { name: 'Steps' }).getByText('The program is here').first().waitFor();
  const seen = new Set();
  const placed = () => {
    for (const part of at.watcher.events.parts?.parts ?? [])
      if (Math.hypot(part.p[0] - 0.3, part.p[1] + 0.15) < 0.03 && part.p[2] < 0.06) seen.add(part.name);
    return seen.size >= 2;
  };
  await until(() => placed(), 120, 'two parts in the tray');
  t.diagnostic(`from the link to the second part in the tray: ${((Date.now() - began) / 1000).toFixed(1)} s of page time`);
  assert.ok(Date.now() - began < 300_000, 'it took more than 5 minutes');
  await button('End program').click();
  await page.getByRole('dialog').getByRole('button', { name: 'End program' }).click();
  await button('Start').waitFor();
});

test('a draft survives a killed browser and a killed cell', async () => {
  await shown('Shown as', 'Text');
  const editor = page.getByRole('textbox', { name: 'Text of the program' });
  await editor.click();
  await page.keyboard.press('Control+Home');
  await page.keyboard.insertText('# not saved yet\n');
  await page.getByText('Draft, stored on the cell').waitFor();
  at.chrome.kill();
  at.watcher.end();
  await cell.kill();
  await cell.start();
  at.watcher = await new Watcher(cell).start();
  at.chrome = await launch({ lines: true });
  page = await at.open();
  await button(/^In control/).waitFor();
  await go(page, 'Program');
  await button(/^Program .*open another$/).click();
  await page.getByText('All files', { exact: true }).click();
  await page.getByRole('dialog').getByRole('button', { name: /^job\.script/ }).click();
  await page.getByText(/^Draft .*not saved yet$/).waitFor();
  await shown('Shown as', 'Text');
  await page.getByRole('textbox', { name: 'Text of the program' }).getByText('# not saved yet').waitFor();
});

test('saving over what another has saved shows both, and lets choose', async () => {
  // Another client writes the same file.
  const before = await at.watcher.request('files.read', { name: 'job.script' });
  await button(/^In control/).click();
  await button('Give control back').click();
  await at.watcher.request('session.take');
  await at.watcher.request('files.write', { name: 'job.script', text: `${before.text}# theirs\n`, base: before.hash });
  await at.watcher.request('session.release');
  await button('Take control').first().click();
  await button(/^In control/).waitFor();
  await button('Save').click();
  await page.getByRole('alert').getByText('job.script has changed meanwhile').waitFor();
  await button('Show both').click();
  const dialog = page.getByRole('dialog', { name: 'job.script has changed meanwhile' });
  await dialog.getByRole('button', { name: /^The present file: # theirs/ }).click();
  await dialog.getByRole('button', { name: 'Save the mixture' }).click();
  await said('job.script is saved');
  const now = await at.watcher.request('files.read', { name: 'job.script' });
  assert.ok(now.text.startsWith('# not saved yet\n') && now.text.includes('# theirs'), now.text);
});

test('nothing went wrong on the page meanwhile', async () => {
  assert.deepEqual(page.problems, []);
});
