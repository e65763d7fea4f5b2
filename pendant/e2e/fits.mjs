// What a key or a line says fits in it: in every state, in both languages, on a small screen, a large one and a phone.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { picture, screen } from './browser.mjs';
import { until, Watcher } from './cell.mjs';
import { suite } from './suite.mjs';

const kQuestion = 'Put a part into the tray, look that the gripper is open, then press Confirm';
const programs = (folder) => {
  const file = join(folder, 'cell.yaml');
  writeFileSync(file, readFileSync(file, 'utf8').replace(/^program:.*$/m, 'program: moves.script').replace(/^plc:.*\n/m, ''));
  const point = (name, z) => `\nName: ${name}\nPoint: 0.45, -0.25, ${z}, 3.141592653589793, 0.0, 0.0\n`;
  const points = join(folder, 'PAPpoints.points');
  writeFileSync(points, readFileSync(points, 'utf8') + point('Deep', -0.05) + point('Above', 0.1));
  const script = (name, lines) => writeFileSync(join(folder, `${name}.script`), `load PAPpoints\n${lines}\n`);
  script('moves', 'while true\n  movel Pass1, speed 40mm/s, accel 200mm/s2, blend 10mm\n  movel Pass2, speed 40mm/s\nend');
  script('hit', 'moveto PrePlace\nmoveto Above\nmovel Deep, speed 100mm/s');
  script('asks', `moveto Pass1\nwait user "${kQuestion}"`);
  script('waits', 'moveto Pass1\nwait time 600');
  script('fails', 'moveto Pass1\nraise "the gripper is empty"');
};
const { at, test } = suite({ change: programs });
const status = () => at.watcher.events.status;
const kSizes = { small: [1280, 800], large: [1920, 1080], phone: [390, 844] };
const kPages = ['run', 'move', 'program', 'points', 'signals', 'plots', 'health', 'cell'];

/** Texts that are cut: wider or higher than what shows them, without the three dots that say so. In the page. */
function clipped() {
  const out = [];
  const shown = (each) => {
    const box = each.getBoundingClientRect();
    return box.width > 1 && box.height > 1 && getComputedStyle(each).visibility !== 'hidden' && !each.closest('canvas, .cm-editor, .skip');
  };
  const name = (each) => `${each.tagName.toLowerCase()}.${[...each.classList].join('.')} “${each.innerText.trim().replace(/\s+/g, ' ').slice(0, 60)}”`;
  const says = (each) => [...each.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim() !== '');
  for (const each of document.querySelectorAll('body *')) {
    if (!(each instanceof HTMLElement) || !shown(each)) continue;
    const style = getComputedStyle(each);
    const key = each.matches('button, a.button, .chip, .segmented label, [role="tab"], .page-link, .control-button');
    const cuts = !['visible', 'auto', 'scroll'].includes(style.overflowX);
    const dots = style.textOverflow === 'ellipsis' || style.webkitLineClamp !== 'none';
    const wide = each.scrollWidth > each.clientWidth + 1, high = each.scrollHeight > each.clientHeight + 2;
    if (key && !each.matches('.bare') && style.display !== 'inline' && (wide || high)) out.push(`key ${name(each)} ${each.scrollWidth}>${each.clientWidth} or ${each.scrollHeight}>${each.clientHeight}`);
    else if (says(each) && cuts && wide && !dots && each.clientWidth > 1) out.push(`text ${name(each)} ${each.scrollWidth}>${each.clientWidth}`);
    // A word that is longer than its key leaves it at both sides, which scrollWidth does not count.
    if (key && !each.matches('.bare') && style.display !== 'inline') {
      const outer = each.getBoundingClientRect();
      for (const node of each.querySelectorAll('span, strong, small')) {
        if (!says(node) || !shown(node) || getComputedStyle(node).textOverflow === 'ellipsis' || node.matches('.badge')) continue;
        const range = document.createRange();
        range.selectNodeContents(node);
        const inner = range.getBoundingClientRect();
        if (inner.left < outer.left - 0.5 || inner.right > outer.right + 0.5 || inner.top < outer.top - 1 || inner.bottom > outer.bottom + 1)
          out.push(`word of ${name(each)} ${Math.round(inner.width)}x${Math.round(inner.height)} in ${Math.round(outer.width)}x${Math.round(outer.height)}`);
      }
    }
    // A picked key that the screen cuts.
    const box = each.getBoundingClientRect();
    if (key && box.width > 0 && (box.right > innerWidth + 1 || box.left < -1) && !each.closest('.segmented, .scrolls, [class*="scroll"], table')) out.push(`off the screen: ${name(each)}`);
  }
  return [...new Set(out)];
}

const open = async (language) => {
  const page = await screen(at.chrome.browser, at.cell.link, {
    locale: language === 'es' ? 'es-ES' : 'en-GB',
    // The picture in 3D costs seconds on a busy machine, and shows no text.
    before: () => {
      const get = HTMLCanvasElement.prototype.getContext;
      HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
        return kind.startsWith('webgl') ? null : get.call(this, kind, ...rest);
      };
    },
  });
  await page.locator('.control-button').waitFor();
  return page;
};

/** Of every page that is asked for, in each size. */
async function look(page, language, name, pages) {
  const found = [];
  for (const [size, [width, height]] of Object.entries(kSizes)) {
    await page.setViewportSize({ width, height });
    for (const each of pages) {
      await page.evaluate((hash) => (location.hash = hash), `#/${each}`);
      await page.locator('main .spinner').waitFor({ state: 'detached' });
      await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
      const cut = await page.evaluate(clipped);
      if (cut.length) await picture(page, `cut-${name}-${language}-${size}-${each}`);
      found.push(...cut.map((text) => `${name} ${language} ${size} ${each}: ${text}`));
    }
  }
  return found;
}

/** Who watches cannot answer, and the box looks so. */
async function answersNot(page) {
  const answer = page.locator('.question input');
  await answer.waitFor();
  assert.ok(await answer.isDisabled());
  assert.ok(Number(await answer.locator('..').evaluate((each) => getComputedStyle(each).opacity)) < 0.8, 'the box is pale');
}

/** The watcher does `enter` with control, and gives it back; both languages look on with control, and without. */
const act = async (what) => {
  await until(() => at.watcher.request('session.take', { force: true }).then((answer) => answer.you_hold), 20, 'control');
  await what((request, args) => at.watcher.request(request, args));
};
/** Begins a program; asks again while the robot comes to rest. */
const begin = (file) => (ask) =>
  until(() => ask('program.from', { program: file, confirmed: true }).then(() => true, (error) => {
    if (error.code !== 'moving') throw error;
    return false;
  }), 30, `the start of ${file}`);
const end = async (ask) => {
  for (const request of ['control.recover', 'control.discard', 'control.resume', 'program.stop']) await ask(request).catch(() => 0);
  await until(() => status().state === 'running' && status().program?.ended && status().standing, 30, 'rest');
};
const kKeys = ['run', 'move', 'program'];
const kStates = {
  ended: { enter: end, pages: kPages },
  runs: { enter: async (ask) => (await begin('moves.script')(ask), until(() => at.watcher.speed() > 0.01, 60, 'motion')), pages: kKeys },
  held: { enter: async (ask) => (await ask('control.hold'), until(() => status().state === 'held' && status().standing, 30, 'held')), pages: [...kKeys, 'points'] },
  canceled: { enter: (ask) => ask('control.discard'), pages: kKeys },
  asks: { enter: async (ask) => (await end(ask), await begin('asks.script')(ask), until(() => status().program.line === 3 || status().program.where?.line === 3, 60, 'the question')), pages: kKeys },
  paused: { enter: async (ask) => (await end(ask), await begin('waits.script')(ask), until(() => status().program.where.line === 3 && status().standing, 60, 'the wait'), ask('program.pause', { at_once: true })), pages: kKeys },
  fails: { enter: async (ask) => (await end(ask), await begin('fails.script')(ask), until(() => status().program.state === 'failed', 60, 'the failure')), pages: kKeys },
  contact: { enter: async (ask) => (await begin('hit.script')(ask), until(() => status().state === 'held' && status().contacts.touching && status().standing, 60, 'contact')), pages: kKeys },
};

for (const [name, { enter, pages }] of Object.entries(kStates))
  test(`${name}: what keys and lines say fits, for who has control and for who watches`, async () => {
    await act(enter);
    const found = [];
    for (const language of ['en', 'es']) {
      const page = await open(language);
      try {
        if (name === 'asks') await answersNot(page);
        found.push(...(await look(page, language, `${name} watching`, ['run'])));
        await at.watcher.request('session.release').catch(() => undefined);
        await page.evaluate(() => (location.hash = '#/move'));
        const take = page.getByRole('main').getByRole('button', { name: /^(Take control|Tomar el control)$/ });
        await until(async () => (await page.locator('.control-button.yours').count()) > 0 || (await take.click({ timeout: 500 }).catch(() => 0), false), 60, 'control');
        found.push(...(await look(page, language, name, pages)));
      } finally {
        await page.context().close();
      }
      await act(async () => undefined);
    }
    assert.deepEqual(found, []);
  }, 900_000);

test('without a connection everything fits, too', async () => {
  const found = [];
  for (const language of ['en', 'es']) {
    const page = await open(language);
    try {
      for (const each of kKeys) {
        await page.evaluate((hash) => (location.hash = hash), `#/${each}`);
        await page.locator('main .spinner').waitFor({ state: 'detached' });
      }
      at.watcher.end();
      await at.cell.kill();
      await page.locator('.stop-button.dead').waitFor();
      found.push(...(await look(page, language, 'offline', kKeys)));
    } finally {
      await page.context().close();
      await at.cell.start();
      at.watcher = await new Watcher(at.cell).start();
    }
  }
  assert.deepEqual(found, []);
});
