// Builds the documentation as a site: node help/build.mjs OUT
// Each Markdown page of docs/ becomes OUT/NAME.html, with navigation from docs/README.md and a search that works without a
// network, also from a folder on the disk. The pendant serves the site as /help/.
import { copyFileSync, mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { basename, dirname, join, normalize, relative } from 'node:path';
import { fileURLToPath } from 'node:url';
import hljs from 'highlight.js/lib/core';
import bash from 'highlight.js/lib/languages/bash';
import cpp from 'highlight.js/lib/languages/cpp';
import json from 'highlight.js/lib/languages/json';
import python from 'highlight.js/lib/languages/python';
import xml from 'highlight.js/lib/languages/xml';
import yaml from 'highlight.js/lib/languages/yaml';
import MarkdownIt from 'markdown-it';
import MiniSearch from 'minisearch';
import { searchOptions } from './search-options.mjs';

const here = dirname(fileURLToPath(import.meta.url));
const root = join(here, '../..');

for (const [name, language] of Object.entries({ bash, cpp, json, python, xml, yaml })) hljs.registerLanguage(name, language);
const languages = { sh: 'bash', bash: 'bash', cpp: 'cpp', 'c++': 'cpp', json: 'json', python: 'python', xml: 'xml', yaml: 'yaml' };

/** Source file (relative to the root) → page of the site. */
function findPages() {
  const out = new Map();
  const add = (folder, place) => {
    for (const file of readdirSync(join(root, folder)).sort())
      if (file.endsWith('.md')) out.set(join(folder, file), join(place, file === 'README.md' ? 'index.html' : file.replace(/\.md$/, '.html')));
  };
  add('docs', '');
  add('docs/decisions', 'decisions');
  add('bench/journal', 'journal');
  out.set('ARCHITECTURE.md', 'architecture.html');
  out.set('examples/README.md', 'examples.html');
  return out;
}

/** The anchor of a heading, as GitHub makes it. */
export function anchorOf(text) {
  return text.toLowerCase().replace(/[^\p{L}\p{N}_\- ]/gu, '').replaceAll(' ', '-');
}

/** What a reader sees of inline Markdown. */
function plainText(token) {
  return (token.children ?? []).map((child) => (child.type === 'text' || child.type === 'code_inline' ? child.content : child.type === 'softbreak' ? ' ' : '')).join('');
}

/** A link of a page, as the site has it; '' where the site has no such page. */
function linkOf(href, file, pages) {
  if (/^[a-z]+:/.test(href) || href.startsWith('#')) return href;
  const [path, anchor] = href.split('#');
  const target = normalize(join(dirname(file), path));
  const folder = join(target, 'README.md');
  const page = pages.get(target) ?? pages.get(folder) ?? (target === 'docs/decisions' ? 'decisions/index.html' : undefined);
  if (page) return relative(dirname(pages.get(file)), page) + (anchor ? `#${anchor}` : '');
  return '';
}

function markdownFor(file, pages, images) {
  const md = new MarkdownIt({
    html: true,
    highlight: (text, info) => {
      const language = languages[info.split(' ')[0]];
      return language ? hljs.highlight(text, { language }).value : '';
    },
  });
  // "sh run exit=1": what follows the language is for the test of the page.
  md.core.ruler.push('fences', (state) => {
    for (const token of state.tokens) if (token.type === 'fence') token.info = token.info.split(' ')[0];
  });
  md.core.ruler.push('headings', (state) => {
    const seen = new Map();
    state.tokens.forEach((token, i) => {
      if (token.type !== 'heading_open') return;
      const base = anchorOf(plainText(state.tokens[i + 1]));
      const count = seen.get(base) ?? 0;
      seen.set(base, count + 1);
      token.attrSet('id', count ? `${base}-${count}` : base);
    });
  });
  md.core.ruler.push('links', (state) => {
    const walk = (tokens) => {
      let dropped = 0;
      for (const token of tokens) {
        if (token.children) walk(token.children);
        if (token.type === 'link_open') {
          const href = linkOf(token.attrGet('href'), file, pages);
          token.attrSet('href', href);
          if (/^https?:/.test(href)) token.attrSet('rel', 'noreferrer'), token.attrSet('target', '_blank');
          if (!href) (token.type = 'text'), (token.content = ''), dropped++;
        } else if (token.type === 'link_close' && dropped > 0) {
          (token.type = 'text'), (token.content = ''), dropped--;
        } else if (token.type === 'image') {
          const source = normalize(join(dirname(file), token.attrGet('src')));
          images.add(source);
          token.attrSet('src', relative(dirname(pages.get(file)), join('pictures', basename(source))));
          token.attrSet('loading', 'lazy');
        }
      }
    };
    walk(state.tokens);
  });
  md.renderer.rules.table_open = () => '<div class="table"><table>\n';
  md.renderer.rules.table_close = () => '</table></div>\n';
  return md;
}

/** The parts of a page between headings, for the search. */
function sectionsOf(tokens) {
  const out = [];
  let section = { anchor: '', title: '', text: [] };
  for (let i = 0; i < tokens.length; ++i) {
    const token = tokens[i];
    if (token.type === 'heading_open') {
      if (section.title || section.text.length) out.push(section);
      section = { anchor: token.attrGet('id'), level: token.tag, title: plainText(tokens[i + 1]), text: [] };
      ++i;
    } else if (token.type === 'inline') section.text.push(plainText(token));
    else if (token.type === 'fence') section.text.push(token.content);
  }
  out.push(section);
  return out;
}

/** Groups and pages in the order of docs/README.md. */
function navigationOf(tokens) {
  const groups = [];
  for (let i = 0; i < tokens.length; ++i) {
    if (tokens[i].type === 'heading_open' && tokens[i].tag === 'h2') groups.push({ title: plainText(tokens[i + 1]), pages: [] });
    if (tokens[i].type !== 'inline' || !groups.length || tokens[i - 1]?.type !== 'td_open') continue;
    const children = tokens[i].children;
    children.forEach((child, k) => {
      const href = child.type === 'link_open' && child.attrGet('href');
      if (href && /^[^:#]+\.html$/.test(href)) groups.at(-1).pages.push({ href, title: children[k + 1].content });
    });
  }
  return groups.filter((group) => group.pages.length);
}

const escape = (text) => text.replace(/[&<>"]/g, (c) => ({ '&': '&amp;', '<': '&lt;', '>': '&gt;', '"': '&quot;' })[c]);

function shell({ page, title, body, groups, sections }) {
  const up = relative(dirname(page), '.') || '.';
  const place = (href) => `${up}/${href}`;
  const nav = groups
    .map((group) => {
      const open = group.pages.some((each) => each.href === page) ? ' open' : '';
      const links = group.pages.map(({ href, title }) => `<li><a href="${place(href)}"${href === page ? ' aria-current="page"' : ''}>${escape(title)}</a></li>`);
      return `<details${open || (page === 'index.html' ? ' open' : '')}><summary>${escape(group.title)}</summary><ul>${links.join('')}</ul></details>`;
    })
    .join('\n');
  const contents = sections.filter((each) => each.level === 'h2').map((each) => `<li><a href="#${each.anchor}">${escape(each.title)}</a></li>`);
  return `<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<link rel="icon" href="data:,">
<title>${escape(title)} · Polyarm</title>
<link rel="stylesheet" href="${place('help.css')}">
<script defer src="${place('minisearch.js')}"></script>
<script defer src="${place('search-index.js')}"></script>
<script defer src="${place('help.js')}" data-root="${up}"></script>
</head>
<body>
<a class="skip" href="#content">To the text</a>
<header><a class="home" href="${place('index.html')}">Polyarm</a>
<div class="search" role="search"><input type="search" placeholder="Search ( / )" aria-label="Search the documentation" autocomplete="off" spellcheck="false">
<ol class="found" hidden></ol></div></header>
<nav class="pages" aria-label="Pages"><details class="all"><summary>Pages</summary>
${nav}
</details></nav>
<main id="content" tabindex="-1">
${body}
</main>
${contents.length > 1 ? `<aside aria-label="On this page"><h2>On this page</h2><ul>${contents.join('')}</ul></aside>` : ''}
</body>
</html>
`;
}

function listOfFolder(title, folder, pages) {
  const links = [...pages].filter(([, page]) => dirname(page) === folder && basename(page) !== 'index.html').map(([file, page]) => `- [${headingOf(file)}](${basename(page)})`);
  return `# ${title}\n\n${links.join('\n')}\n`;
}

function headingOf(file) {
  return readFileSync(join(root, file), 'utf8').match(/^# (.*)$/m)?.[1] ?? basename(file);
}

export function buildHelp(out) {
  rmSync(out, { recursive: true, force: true });
  const pages = findPages();
  const images = new Set();
  const documents = [];
  const parse = (file) => {
    const md = markdownFor(file, pages, images);
    return { md, tokens: md.parse(readFileSync(join(root, file), 'utf8'), {}) };
  };
  const groups = navigationOf(parse('docs/README.md').tokens);
  const write = (page, text) => {
    mkdirSync(dirname(join(out, page)), { recursive: true });
    writeFileSync(join(out, page), text);
  };
  const add = (page, md, tokens) => {
    const sections = sectionsOf(tokens);
    const title = sections.find((each) => each.level === 'h1')?.title ?? basename(page);
    for (const [n, section] of sections.entries())
      documents.push({ id: `${page}#${n}`, href: section.anchor && section.level !== 'h1' ? `${page}#${section.anchor}` : page, page: title, title: section.title, text: section.text.join(' ') });
    write(page, shell({ page, title, body: md.renderer.render(tokens, md.options, {}), groups, sections }));
  };
  for (const [file, page] of pages) {
    const { md, tokens } = parse(file);
    add(page, md, tokens);
  }
  const decisions = markdownFor('docs/decisions/0001.md', new Map([['docs/decisions/0001.md', 'decisions/index.html']]), images);
  const plain = new MarkdownIt();
  add('decisions/index.html', decisions, plain.parse(listOfFolder('Decisions', 'decisions', pages), {}));
  for (const image of images) {
    mkdirSync(join(out, 'pictures'), { recursive: true });
    copyFileSync(join(root, image), join(out, 'pictures', basename(image)));
  }
  const index = new MiniSearch(searchOptions);
  index.addAll(documents);
  write('search-index.js', `window.polyarmIndex = ${JSON.stringify(index)};\nwindow.polyarmSearchOptions = ${JSON.stringify(searchOptions)};\n`);
  copyFileSync(createRequire(import.meta.url).resolve('minisearch').replace(/dist[\\/].*$/, 'dist/umd/index.js'), join(out, 'minisearch.js'));
  for (const file of ['help.css', 'help.js']) copyFileSync(join(here, file), join(out, file));
  return { pages: pages.size, documents: documents.length };
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const out = process.argv[2];
  if (!out) {
    console.error('usage: node help/build.mjs OUT   (the folder is made anew)');
    process.exit(2);
  }
  const { pages, documents } = buildHelp(out);
  console.log(`${pages} pages with ${documents} sections in ${out}`);
}
