// The search of the documentation, and the theme that the pendant was left in.
'use strict';
(() => {
  const root = document.currentScript?.dataset.root ?? '.';
  const input = document.querySelector('.search input');
  const list = document.querySelector('.found');
  const kMost = 12, kBefore = 40, kShown = 140;
  let index = null;

  try {
    const theme = JSON.parse(localStorage.getItem('polyarm.theme') ?? 'null');
    if (theme === 'dark' || theme === 'light') document.documentElement.dataset.theme = theme;
  } catch {
    // no storage here, as on a disk
  }
  if (matchMedia('(min-width: 900px)').matches) document.querySelector('nav .all').open = true;

  function found(words) {
    index ??= MiniSearch.loadJS(window.polyarmIndex, window.polyarmSearchOptions);
    // Why something was decided or measured is read less often than how it is done.
    const boostDocument = (id) => (/^(decisions|journal)\//.test(id) ? 0.3 : 1);
    return index.search(words, { boostDocument }).slice(0, kMost);
  }

  function excerpt({ text, terms }) {
    const lower = text.toLowerCase();
    const first = Math.min(...terms.map((term) => lower.indexOf(term)).filter((at) => at >= 0), text.length);
    const from = first === text.length ? 0 : Math.max(0, first - kBefore);
    return (from ? '…' : '') + text.slice(from, from + kShown) + (from + kShown < text.length ? '…' : '');
  }

  function show() {
    const words = input.value.trim();
    list.hidden = !words;
    list.replaceChildren();
    if (!words) return;
    const results = found(words);
    for (const result of results) {
      const link = document.createElement('a');
      link.href = `${root}/${result.href}`;
      const title = document.createElement('strong');
      title.textContent = result.title === result.page ? result.page : `${result.page} › ${result.title}`;
      const text = document.createElement('span');
      text.textContent = excerpt(result);
      link.append(title, text);
      const item = document.createElement('li');
      item.append(link);
      list.append(item);
    }
    if (!results.length) list.append(Object.assign(document.createElement('li'), { textContent: 'Nothing found.' }));
  }

  input.addEventListener('input', show);
  input.addEventListener('focus', show);
  document.addEventListener('keydown', (event) => {
    if (event.key === '/' && document.activeElement !== input) {
      event.preventDefault();
      input.focus();
    }
    if (event.key === 'Escape') (list.hidden = true), input.blur();
    if (event.key === 'Enter' && document.activeElement === input) list.querySelector('a')?.click();
    if ((event.key === 'ArrowDown' || event.key === 'ArrowUp') && !list.hidden) {
      const links = [...list.querySelectorAll('a')];
      const at = links.indexOf(document.activeElement) + (event.key === 'ArrowDown' ? 1 : -1);
      (links[at] ?? input).focus();
      event.preventDefault();
    }
  });
  document.addEventListener('click', (event) => {
    if (!event.target.closest('.search')) list.hidden = true;
    if (event.target.closest('.found a')) list.hidden = true;
  });
})();
