// The pictures of docs/pendant.md and README.md, of a copy of examples/pick_and_place that has just been started (its points are
// put into groups): node dev/pictures.mjs 'ADDRESS WITH TOKEN'
import { writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';

const docs = fileURLToPath(new URL('../../docs/', import.meta.url));
const browser = await chromium.launch({ executablePath: '/usr/bin/chromium', args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'] });
const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, colorScheme: 'dark', locale: 'en-GB' });
const page = await context.newPage();
page.setDefaultTimeout(150_000);  // a busy machine
const blank = await context.newPage();
await page.bringToFront();

async function picture(name) {
  await page.waitForTimeout(800);
  const png = (await page.screenshot({ timeout: 150_000 })).toString('base64');
  const webp = await blank.evaluate(async (data) => {
    const image = new Image();
    image.src = `data:image/png;base64,${data}`;
    await image.decode();
    const canvas = Object.assign(document.createElement('canvas'), { width: image.width, height: image.height });
    canvas.getContext('2d').drawImage(image, 0, 0);
    return canvas.toDataURL('image/webp', 0.82);
  }, png);
  writeFileSync(`${docs}${name}.webp`, Buffer.from(webp.split(',')[1], 'base64'));
}

await page.goto(process.argv[2]);
await page.getByRole('button', { name: /^In control/ }).waitFor();
await page.getByText(/moveto PrePlace/).first().waitFor({ timeout: 150_000 });
await picture('pendant_run');
await page.getByRole('button', { name: 'End program' }).click();
await page.getByRole('dialog').getByRole('button', { name: 'End program' }).click();
await page.getByRole('button', { name: 'Start' }).waitFor();
await page.getByRole('link', { name: 'Move' }).click();
await page.getByText('Base', { exact: true }).click();
await page.getByRole('button', { name: 'Drag TCP' }).click();
await picture('pendant_move');
await page.getByRole('button', { name: 'Drag TCP' }).click();
await page.getByRole('button', { name: 'Go to…' }).click();
await page.getByText('Joint values').click();
await page.getByLabel('shoulder pan').fill('45');
await picture('pendant_goto');
await page.getByRole('dialog').getByRole('button', { name: 'Close' }).click();
await page.getByRole('link', { name: 'Points' }).click();
for (const [group, names] of [['feeder', ['Pick', 'PrePick']], ['tray', ['Place', 'PrePlace']]]) {
  for (const name of names) await page.getByRole('checkbox', { name: `Choose ${name}`, exact: true }).check();
  await page.getByRole('button', { name: 'Group', exact: true }).click();
  await page.getByRole('dialog').getByRole('textbox', { name: 'Group' }).fill(group);
  await page.getByRole('dialog').getByRole('button', { name: 'Apply' }).click();
  await page.getByRole('region', { name: group }).waitFor();
  for (const name of names) await page.getByRole('checkbox', { name: `Choose ${name}`, exact: true }).uncheck();
}
await page.getByRole('region', { name: 'Messages' }).getByRole('listitem').first().waitFor({ state: 'detached', timeout: 15_000 }).catch(() => undefined);
await page.getByRole('button', { name: /^PrePlace / }).click();
await page.getByText(/^The way there/).waitFor({ timeout: 5000 }).catch(() => undefined);
await picture('pendant_points');
await page.getByRole('link', { name: 'Program' }).click();
await page.getByText('Text', { exact: true }).click();
await page.getByRole('button', { name: 'Dry run' }).click();
await page.getByText(/^Dry run: /).first().waitFor({ timeout: 150_000 });
await page.waitForTimeout(1500);
await picture('pendant_program');
await browser.close();
