// How the memory of the page grows while much happens: node dev/heap.mjs 'ADDRESS WITH TOKEN' MINUTES. Let a program run that
// moves and sets tags without end. Told every half minute after a collection: kB of the heap, and what three holds on the graphics card.
import { chromium } from 'playwright-core';

const [address, minutes = '5'] = process.argv.slice(2);
const browser = await chromium.launch({ executablePath: '/usr/bin/chromium', args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'] });
const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
await page.goto(address);
await page.getByRole('contentinfo').waitFor();
const cdp = await page.context().newCDPSession(page);
await cdp.send('Performance.enable');
const pages = ['plots', 'run', 'signals', 'health', 'run'];
const taken = [];
for (let i = 0; i <= 2 * Number(minutes); ++i) {
  await page.evaluate((hash) => (location.hash = hash), `#/${pages[i % pages.length]}`);
  await page.waitForTimeout(24_000);
  await page.evaluate(() => (location.hash = '#/run'));
  await page.waitForTimeout(6_000);
  for (let k = 0; k < 2; ++k) await cdp.send('HeapProfiler.collectGarbage');
  const all = Object.fromEntries((await cdp.send('Performance.getMetrics')).metrics.map((each) => [each.name, each.value]));
  taken.push(all.JSHeapUsedSize / 1024);
  console.log(`${((i + 1) / 2).toFixed(1)} min: ${taken[i].toFixed(0)} kB, ${all.Nodes} nodes, ${all.JSEventListeners} listeners`);
}
const from = Math.floor(taken.length / 3);
console.log(`growth: ${((taken[taken.length - 1] - taken[from]) / ((taken.length - 1 - from) / 2)).toFixed(1)} kB a minute`);
await browser.close();
