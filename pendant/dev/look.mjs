// Pictures of pages, to be looked at: node dev/look.mjs ADDRESS FOLDER [PAGE…]
import { mkdirSync } from 'node:fs';
import { chromium } from 'playwright-core';

const [address, folder, ...wanted] = process.argv.slice(2);
const pages = wanted.length ? wanted : ['run', 'move', 'program', 'points', 'signals', 'plots', 'health', 'cell'];
const sizes = { desk: [1440, 900], tablet: [1024, 768], phone: [390, 844] };
mkdirSync(folder, { recursive: true });
const browser = await chromium.launch({
  executablePath: '/usr/bin/chromium',
  args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic', '--no-first-run',
    '--disable-background-networking', '--disable-component-update', '--disable-sync'],
});
for (const scheme of ['dark', 'light'])
  for (const [name, [width, height]] of Object.entries(sizes)) {
    if (process.env.ONLY && !process.env.ONLY.includes(`${name}-${scheme}`)) continue;
    const context = await browser.newContext({ viewport: { width, height }, colorScheme: scheme, locale: process.env.LANGUAGE_TAG ?? 'en-GB' });
    const page = await context.newPage();
    page.on('console', (m) => ['error', 'warning'].includes(m.type()) && console.log(name, m.text()));
    page.on('pageerror', (e) => console.log(name, e.message));
    await page.goto(address);
    for (const each of pages) {
      await page.evaluate((hash) => (location.hash = hash), `#/${each}`);
      await page.waitForTimeout(1500);
      await page.screenshot({ path: `${folder}/${each}-${name}-${scheme}.png` });
    }
    await context.close();
  }
await browser.close();
