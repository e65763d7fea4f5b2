// How the memory of the page grows while a cell moves: node dev/heap.mjs 'ADDRESS WITH TOKEN' MINUTES. The cell's program should move
// and set tags without end. Each minute it opens plots, the 3D view and the pages with lists, collects garbage, and prints a line:
// JavaScript heap, memory of the renderer's process (with ArrayBuffers and canvases), DOM nodes, event listeners.
import { readFileSync } from 'node:fs';
import { chromium } from 'playwright-core';

const [address, minutes = '60'] = process.argv.slice(2);
/** Seconds on each page in a minute. */
const kPages = [['plots', 18], ['run', 14], ['move', 8], ['program', 6], ['signals', 6], ['health', 8]];
const browser = await chromium.launch({ executablePath: '/usr/bin/chromium', args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'] });
const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
await page.goto(address);
await page.getByRole('contentinfo').waitFor();
const cdp = await page.context().newCDPSession(page);
await cdp.send('Performance.enable');
const whole = await browser.newBrowserCDPSession();

async function residentOfRenderer() {
  const { processInfo } = await whole.send('SystemInfo.getProcessInfo');
  const sizes = processInfo.filter((each) => each.type === 'renderer').map(({ id }) => Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${id}/status`, 'utf8'))?.[1] ?? 0));
  return Math.max(...sizes);
}

const taken = [];
console.log('minute  heap [kB]  renderer [kB]  nodes  listeners');
for (let i = 1; i <= Number(minutes); ++i) {
  for (const [name, seconds] of kPages) {
    await page.evaluate((hash) => (location.hash = hash), `#/${name}`);
    await page.waitForTimeout(1000 * seconds);
  }
  for (let k = 0; k < 2; ++k) await cdp.send('HeapProfiler.collectGarbage');
  const all = Object.fromEntries((await cdp.send('Performance.getMetrics')).metrics.map((each) => [each.name, each.value]));
  taken.push(all.JSHeapUsedSize / 1024);
  const row = [i, taken.at(-1).toFixed(0), await residentOfRenderer(), all.Nodes, all.JSEventListeners];
  console.log(row.map((each, k) => String(each).padStart([6, 10, 14, 6, 10][k])).join(' '));
}

/** Least squares over what is left after the first third, in which lists fill up to their bounds. */
const rest = taken.slice(Math.floor(taken.length / 3));
const [mx, my] = [(rest.length - 1) / 2, rest.reduce((sum, each) => sum + each, 0) / rest.length];
const slope = rest.reduce((sum, each, i) => sum + (i - mx) * (each - my), 0) / rest.reduce((sum, _, i) => sum + (i - mx) ** 2, 0);
console.log(`growth over the last ${rest.length} min: ${slope.toFixed(1)} kB a minute; ${Math.min(...rest).toFixed(0)} to ${Math.max(...rest).toFixed(0)} kB`);
await browser.close();
