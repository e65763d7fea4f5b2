// Debian's Chromium, and the ways in which a person uses the page: by roles and labels only.
import { existsSync, mkdirSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';

const out = fileURLToPath(new URL('./out', import.meta.url));
const executablePath = process.env.CHROMIUM ?? ['/usr/bin/chromium', '/usr/bin/chromium-browser'].find(existsSync);

/** `lines`: without WebGL. The page draws the robot as lines then, which costs the processor nothing; in 3D it costs most of a core. */
export async function launch({ lines = false } = {}) {
  const folder = mkdtempSync(join(tmpdir(), 'polyarm-browser-'));
  const server = await chromium.launchServer({
    executablePath,
    headless: true,
    host: '127.0.0.1',  // a machine need not know the name localhost
    args: ['--no-sandbox', '--headless=new', '--disable-quic', ...(lines ? ['--disable-3d-apis'] : ['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader']),
      '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync', `--disk-cache-dir=${folder}`],
  });
  const browser = await chromium.connect(server.wsEndpoint()).catch(async (error) => {
    await server.kill().catch(() => undefined);  // else it keeps the cases from ending
    throw error;
  });
  return {
    browser,
    /** Kills all of its processes at once, as when its machine loses power. */
    kill: () => process.kill(-server.process().pid, 'SIGKILL'),
    end: async () => {
      await server.kill().catch(() => undefined);
      rmSync(folder, { recursive: true, force: true });
    },
  };
}

/** A page on a screen of its own (cookies and settings are its own, too). */
export async function screen(browser, link, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, locale: 'en-GB', colorScheme: 'dark', ...options });
  if (options.before) await context.addInitScript(options.before);
  const page = await context.newPage();
  page.setDefaultTimeout(90_000);  // a busy machine is no fault of the page
  page.problems = [];
  page.on('pageerror', (error) => page.problems.push(error.message));
  page.on('console', (message) => {
    if (message.type() === 'error' && !/ERR_CONNECTION_(REFUSED|RESET)|ERR_SOCKET_NOT_CONNECTED|ERR_INTERNET_DISCONNECTED|WebSocket connection/.test(message.text())) page.problems.push(message.text());
  });
  page.on('request', (request) => {
    const { hostname } = new URL(request.url());
    if (!['localhost', '127.0.0.1', ''].includes(hostname)) page.problems.push(`it asked ${hostname}`);
  });
  await page.goto(link);
  return page;
}

export const go = (page, name) => page.getByRole('navigation', { name: 'Pages' }).getByRole('link', { name }).click();
export const state = (page) => page.getByRole('contentinfo', { name: 'Robot' }).getByRole('status', { name: 'State' });
export const stopKey = (page) => page.getByRole('button', { name: /^Stop .*software stop, not an emergency stop$/ });

export async function picture(page, name) {
  mkdirSync(out, { recursive: true });
  await page.screenshot({ path: join(out, `${name}.png`) }).catch(() => undefined);
}
