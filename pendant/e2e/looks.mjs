// Every page on every screen: nothing serious for axe, nothing wider than the screen, targets for fingers, Stop in reach.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { picture, screen, stopKey } from './browser.mjs';
import { until } from './cell.mjs';
import { suite } from './suite.mjs';

const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const { at, test } = suite();
const kPages = {
  en: ['Run', 'Move', 'Program', 'Points', 'Signals', 'Plots', 'Health', 'Cell'],
  es: ['Ejecutar', 'Mover', 'Programa', 'Puntos', 'Señales', 'Gráficas', 'Diagnóstico', 'Celda'],
};
const kScreens = { desk: [1280, 800], tablet: [1024, 600], phone: [390, 844] };

/** What axe finds, by all its rules or by some. */
async function serious(on, where, rules) {
  const { violations } = await on.evaluate((only) => globalThis.axe.run({ resultTypes: ['violations'], ...(only && { runOnly: only }) }), rules);
  return violations
    .filter((each) => ['serious', 'critical'].includes(each.impact))
    .map((each) => `${where}: ${each.id}: ${each.nodes.map((node) => node.target.join(' ')).join(', ')}`);
}

/** What a finger would miss: 44 px, but for a line of a list or of a segment, which is at least 42 px high. */
const small = (on) =>
  on.evaluate(() =>
    [...document.querySelectorAll('button, a[href], select, input, label.toggle, .segmented label')]
      .filter((each) => !(each.matches('input') && each.closest('label, .field, .slider, [class$=search]')))
      .map((each) => [each.getAttribute('aria-label') ?? each.textContent, each.getBoundingClientRect()])
      .filter(([, box]) => box.width > 0 && box.bottom > 0 && (box.width < 43.5 || box.height < 41.5))
      .map(([label, box]) => `${label} ${Math.round(box.width)}×${Math.round(box.height)}`),
  );

/** Words that stand over their neighbours: they are wider than what they stand in. */
const squeezed = (on) =>
  on.evaluate(() =>
    [...document.querySelectorAll('.segmented label, button > span:not(.badge), .page-link span')]
      .filter((each) => each.clientWidth > 0 && each.scrollWidth > each.clientWidth + 1 && getComputedStyle(each).display !== 'inline')
      .map((each) => each.textContent),
  );

/** Keys and words that are cut off at a side: by the screen, or by what they stand in where that cannot be scrolled to them. */
const cut = (on) =>
  on.evaluate(() => {
    const out = [];
    const told = (each) => each.getAttribute('aria-label') ?? each.textContent;
    for (const each of document.querySelectorAll('.segmented, .move-panel > *, .signals-table button')) {
      const box = each.getBoundingClientRect();
      const around = each.parentElement.closest('.move-panel, .signals-body, main').getBoundingClientRect();
      if (box.width > 0 && (box.left < around.left - 1 || box.right > around.right + 1)) out.push(`${told(each)} stands out`);
    }
    for (const each of document.querySelectorAll('main button')) {
      const box = each.getBoundingClientRect();
      for (let around = each.parentElement; around && box.width > 0; around = around.parentElement) {
        if (/auto|scroll/.test(getComputedStyle(around).overflowX) && around.scrollWidth > around.clientWidth && !around.matches('main, .page, [class$=-page]')) break;
        if (around.matches('main') && (box.right > innerWidth + 1 || box.left < -1)) out.push(`${told(each)} is beyond the screen`);
      }
    }
    for (const each of document.querySelectorAll('.page-link span')) {
      const box = each.getBoundingClientRect();
      const around = each.parentElement.getBoundingClientRect();
      if (box.width > 0 && (box.left < around.left || box.right > around.right)) out.push(`${told(each)} is wider than its key`);
    }
    const [words, modes, first] = ['.state strong', '.modes', '.modes .chip'].map((each) => document.querySelector(each)?.getBoundingClientRect());
    if (first && first.left < words.right - 1 && first.bottom > words.top && first.top < words.bottom) out.push('the state and the modes overlap');
    if (first && first.left < modes.left - 1) out.push('the modes are wider than their place');
    const stop = document.querySelector('.stop-button');
    const within = stop.getBoundingClientRect();
    for (const each of stop.querySelectorAll('strong, small')) {
      const box = each.getBoundingClientRect();
      if (box.top < within.top || box.bottom > within.bottom) out.push(`${each.textContent} is higher than its key`);
    }
    return out;
  });

for (const [language, locale] of [['en', 'en-GB'], ['es', 'es-ES']])
  for (const [size, [width, height]] of Object.entries(kScreens)) {
    // Colors and the parts of a page are the same in every language; the room that words take is not.
    const judged = language === 'en' || size === 'desk';
    const schemes = language === 'en' ? ['dark', 'light'] : ['dark'];
    test(`looks well in ${locale} on a ${size}, ${schemes.join(' and ')}`, async () => {
      const page = await screen(at.chrome.browser, at.cell.link, { locale, viewport: { width, height } });
      await page.waitForFunction((lang) => document.documentElement.lang === lang, language);
      await page.evaluate(axe);
      const found = [];
      for (const colorScheme of schemes) {
        await page.emulateMedia({ colorScheme });
        for (const [i, name] of kPages[language].entries()) {
          const where = `${name}, ${size}, ${colorScheme}`;
          await page.keyboard.press(`Alt+${i + 1}`);
          await page.getByRole('main', { name, exact: true }).waitFor();
          await page.getByRole('main').getByText(/^(Loading…|Cargando…)$/).first().waitFor({ state: 'detached' });
          if (judged) found.push(...(await serious(page, where, colorScheme === 'dark' ? undefined : ['color-contrast'])));
          if (colorScheme === 'light') continue;
          const wide = await page.evaluate(() => document.documentElement.scrollWidth);
          if (wide > width) found.push(`${where}: ${wide} px wide`);
          const stop = await page.getByRole('button', { name: language === 'en' ? /^Stop / : /^Parar / }).boundingBox();
          if (stop.y + stop.height > height || stop.x + stop.width > width || stop.height < 44) found.push(`${where}: Stop is out of reach`);
          found.push(...(await small(page)).map((each) => `${where}: small: ${each}`));
          found.push(...(await cut(page)).map((each) => `${where}: cut off: ${each}`));
          found.push(...(await squeezed(page)).map((each) => `${where}: squeezed: ${each}`));
        }
        await page.getByRole('button', { name: language === 'en' ? 'Settings' : 'Ajustes' }).click();
        if (judged) found.push(...(await serious(page, `Settings, ${size}, ${colorScheme}`)));
        await page.getByRole('dialog').getByRole('button', { name: /^(Close|Cerrar)$/ }).click();
      }
      if (found.length) await picture(page, `looks-${language}-${size}`);
      await page.context().close();
      assert.deepEqual([...found, ...page.problems], []);
    });
  }

test('the menus of the view lie over the tools of the page', async () => {
  const page = await screen(at.chrome.browser, at.cell.link, { locale: 'es-ES' });
  await page.keyboard.press('Alt+2');
  for (const menu of ['Qué se muestra', 'Vistas']) {
    await page.getByRole('main').getByRole('button', { name: menu, exact: true }).click();
    const keys = page.getByRole('group', { name: menu }).getByRole('button');
    await keys.first().waitFor();
    const hidden = await keys.evaluateAll((all) =>
      all
        .filter((each) => {
          const box = each.getBoundingClientRect();
          return [0.05, 0.5, 0.95].some((share) => !each.contains(document.elementFromPoint(box.left + share * box.width, box.top + box.height / 2)));
        })
        .map((each) => each.textContent),
    );
    assert.deepEqual(hidden, [], menu);
  }
  await page.context().close();
});

test('Stop is named for what it is', async () => {
  const page = await at.open();
  await stopKey(page).waitFor();
  const spanish = await screen(at.chrome.browser, at.cell.link, { locale: 'es-ES' });
  await spanish.getByRole('button', { name: /^Parar .*parada por software, no de emergencia$/ }).waitFor();
  await spanish.context().close();
});

test('is in use after less than 400 kB, compressed', async (t) => {
  // On a screen that has none of it yet: the page with its picture, the shapes of the robot, and a program's text besides.
  const context = await at.chrome.browser.newContext({ viewport: { width: 1280, height: 800 }, locale: 'en-GB' });
  const page = await context.newPage();
  const got = [];
  const isShape = (each) => each.url.includes('/api/mesh/');
  page.on('requestfinished', async (request) => got.push({ url: request.url(), bytes: (await request.sizes()).responseBodySize }));
  const kilobytes = (of) => of.reduce((sum, each) => sum + each.bytes, 0) / 1000;
  await page.goto(at.cell.link);
  await page.getByRole('region', { name: 'Robot view' }).getByRole('button', { name: 'Views' }).waitFor();
  await until(() => got.filter(isShape).length >= 2, 60, 'the shapes of the robot and of its gripper');
  await page.waitForLoadState('networkidle');
  const first = kilobytes(got.filter((each) => !isShape(each)));
  const shapes = kilobytes(got.filter(isShape));
  await page.keyboard.press('Alt+3');
  await page.getByRole('radiogroup', { name: 'Shown as' }).getByText('Text').click();
  await page.getByRole('textbox', { name: 'Text of the program' }).waitFor();
  await page.waitForLoadState('networkidle');
  const editor = kilobytes(got);
  t.diagnostic(`fetched, compressed: ${first.toFixed(0)} kB for the page, ${shapes.toFixed(0)} kB for the robot and its gripper, ${editor.toFixed(0)} kB in all with the editor of programs`);
  assert.ok(first > 100 && first < 400, `${first} kB`);
  assert.ok(shapes > 10 && shapes < 300, `${shapes} kB of shapes`);
  await context.close();
});

test('the gripper has a look of its own', async () => {
  const headers = { Authorization: `Bearer ${at.cell.token}` };
  const get = (path) => fetch(`http://127.0.0.1:${at.cell.port}${path}`, { headers });
  const { tool } = await (await get('/api/model/arm')).json();
  assert.deepEqual(tool.visuals.map((each) => [each.shape, each.node]), [['mesh', 'body']]);
  const bytes = Buffer.from(await (await get(tool.visuals[0].mesh)).arrayBuffer());
  assert.equal(bytes.toString('latin1', 0, 4), 'glTF');
});

test('without a connection the words on Stop have room, in both languages', async () => {
  const pages = [];
  for (const [size, [width, height]] of Object.entries(kScreens))
    for (const locale of ['en-GB', 'es-ES']) pages.push([`${size}, ${locale}`, await screen(at.chrome.browser, at.cell.link, { locale, viewport: { width, height } })]);
  at.watcher.end();
  await at.cell.kill();
  const found = [];
  for (const [where, page] of pages) {
    await page.getByRole('alert').getByText(/^(Reconnecting…|Reconectando…)$/).waitFor();
    await page.getByRole('button', { name: /not connected|sin conexión/ }).first().waitFor();
    found.push(...(await cut(page)).map((each) => `${where}: ${each}`));
    await page.context().close();
  }
  assert.deepEqual(found, []);
});
