#pragma once
/// The files of the page of a site. It is in English or Spanish, as the browser prefers; cells in trouble
/// come first. What cells say is shown as text, never as markup.

namespace polyarm::fleet {

inline constexpr const char* kPage = R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>Polyarm</title>
<style>
:root { color-scheme: light dark; --bad: light-dark(#b3261e, #ff8a80); --good: light-dark(#1b7f3b, #7bd88f);
  --wait: light-dark(#8a5a00, #f2c14e); --soft: light-dark(#5c5f66, #a6abb5); --line: #8884; --strip: light-dark(#f1f2f4, #24272c); }
body { font: 14px/1.35 system-ui, sans-serif; margin: 1.25rem; }
h1 { font-size: 1.5rem; margin: 0; }
#sum { margin: .25rem 0 1rem; color: var(--soft); } #sum.old { color: var(--bad); font-weight: 600; }
table { border-collapse: collapse; width: 100%; }
th { color: var(--soft); font-weight: 500; position: sticky; top: 0; background: Canvas; }
th, td { text-align: left; padding: .45rem .5rem; border-bottom: 1px solid var(--line); vertical-align: top; }
td { overflow-wrap: anywhere; } td.cell, td.state { overflow-wrap: normal; }
.number { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; }
td.cell { font-weight: 600; } td.cell a { color: inherit; text-decoration-color: var(--line); }
.state { font-weight: 600; white-space: nowrap; } .state::before { content: '● '; }
.running { color: var(--good); } .held, .stopping, .backing { color: var(--wait); } .fault, .silent { color: var(--bad); }
.silent ~ td.number { color: var(--soft); } td.version { color: var(--soft); }
td.words { min-width: 13rem; } td.program { min-width: 11.5rem; }
@media (max-width: 85rem) { .version { display: none; } }
@media (max-width: 62rem) { .version, .availability, .performance, .quality { display: none; } td.words, td.program { min-width: 8rem; } }
@media (max-width: 40rem) {
  body { margin: .75rem; } thead { display: none; } table, tbody { display: block; }
  tr { display: grid; grid-template-columns: 1fr auto; gap: .1rem .75rem; padding: .6rem 0; border-bottom: 1px solid var(--line); }
  td { border: 0; padding: 0; } td.program, td.words { grid-column: 1 / -1; color: var(--soft); } td.words { order: 3; color: inherit; }
  td.program { order: 2; } td.passes, td.oee { order: 4; font-size: .85em; } td.passes { text-align: left; } td:empty { display: none; }
  td[data-label]::before { content: attr(data-label) ' '; color: var(--soft); }
}
</style></head><body>
<h1 id="name"></h1><p id="sum" role="status"></p>
<table><thead><tr id="head"></tr></thead><tbody id="cells"></tbody></table>
<script src="/site.js"></script></body></html>
)";

inline constexpr const char* kScript = R"(const kWords = {
  en: { cell: 'Cell', state: 'State', words: 'Message', program: 'Program', passes: 'Cycles', availability: 'Availability',
    performance: 'Performance', quality: 'Quality', oee: 'OEE', version: 'Version', answers: '{n} of {all} cells answer',
    old: 'polyarm fleet does not answer. These values are old.', age: 'last values {s} s old', running: 'running', held: 'held',
    fault: 'fault', stopping: 'stopping', backing: 'backing off', silent: 'no answer' },
  es: { cell: 'Celda', state: 'Estado', words: 'Mensaje', program: 'Programa', passes: 'Ciclos', availability: 'Disponibilidad',
    performance: 'Rendimiento', quality: 'Calidad', oee: 'OEE', version: 'Versión', answers: '{n} de {all} celdas responden',
    old: 'polyarm fleet no responde. Estos valores son antiguos.', age: 'últimos valores de hace {s} s', running: 'en marcha',
    held: 'detenida', fault: 'fallo', stopping: 'parando', backing: 'retrocediendo', silent: 'sin respuesta' },
};
const language = (navigator.language ?? 'en').startsWith('es') ? 'es' : 'en';
const words = new Map(Object.entries(kWords[language]));
const t = (key, values = {}) => (words.get(key) ?? key).replace(/\{(\w+)\}/g, (_, name) => values[name]);
const columns = ['cell', 'state', 'words', 'program', 'passes', 'availability', 'performance', 'quality', 'oee', 'version'];
const numbers = ['passes', 'availability', 'performance', 'quality', 'oee'];
const urgency = ['fault', 'silent', 'stopping', 'held', 'backing'];
const grouped = new Intl.NumberFormat(language);
const oneDigit = new Intl.NumberFormat(language, { minimumFractionDigits: 1, maximumFractionDigits: 1 });
const percent = (share) => (share === null ? '–' : `${oneDigit.format(100 * share)} %`);
// A cell may send anything.
const plain = (value) => (['string', 'number'].includes(typeof value) ? String(value) : '');
const stateOf = (cell) => (cell.answers ? plain(cell.summary?.state) : 'silent');
function sorted(cells) {
  const place = (cell) => { const at = urgency.indexOf(stateOf(cell)); return at < 0 ? urgency.length : at; };
  return [...cells].sort((a, b) => place(a) - place(b));
}
function link(cell) {
  const a = document.createElement('a');
  a.href = /^https?:\/\//.test(cell.address) ? cell.address : '#';
  a.rel = 'noreferrer noopener';
  a.target = '_blank';
  a.textContent = cell.name;
  return a;
}
const rows = new Map();
function newRow(cell) {
  const tr = document.createElement('tr');
  for (const key of columns) tr.insertCell().append(key === 'cell' ? link(cell) : '');
  rows.set(cell.name, tr);
  return tr;
}
/** The row of a cell with its present values. It stays the same element, so that it can be clicked at any time. */
function row(cell) {
  const summary = cell.summary ?? {}, state = stateOf(cell), program = cell.answers ? summary.program : null;
  const old = cell.answers || !cell.summary ? '' : ` (${t('age', { s: grouped.format(Math.round(cell.age_s)) })})`;
  const text = { state: t(state), words: cell.words + old, version: plain(summary.version),
    program: program ? `${plain(program.name)}: ${plain(program.state)}` : '',
    passes: Number.isFinite(summary.passes) ? grouped.format(summary.passes) : '' };
  const tr = rows.get(cell.name) ?? newRow(cell);
  for (const [at, key] of columns.entries()) {
    const td = tr.cells[at];
    td.className = `${key} ${numbers.includes(key) ? 'number' : ''} ${key === 'state' ? state.replace(/[^a-z]/g, '') : ''}`;
    if (key === 'passes' || key === 'oee') td.dataset.label = t(key);
    if (key !== 'cell') td.textContent = key in text ? text[key] ?? '' : cell.summary ? percent(cell.oee[key]) : '';
  }
  return tr;
}
function summaryOf(cells) {
  const counts = urgency.map((state) => [state, cells.filter((each) => stateOf(each) === state).length]).filter(([, n]) => n > 0);
  const answers = cells.filter((each) => each.answers).length;
  return [t('answers', { n: answers, all: cells.length }), ...counts.map(([state, n]) => `${n} × ${t(state)}`)].join(' · ');
}
async function look() {
  const sum = document.getElementById('sum');
  try {
    const site = await (await fetch('/api/site', { cache: 'no-store' })).json();
    document.getElementById('name').textContent = site.name;
    document.title = site.name;
    sum.textContent = summaryOf(site.cells);
    sum.className = '';
    const body = document.getElementById('cells'), shown = sorted(site.cells).map(row);
    if (shown.length !== body.rows.length || shown.some((tr, at) => tr !== body.rows[at])) body.replaceChildren(...shown);
  } catch {
    sum.textContent = t('old');
    sum.className = 'old';
  }
  setTimeout(look, 1000);
}
document.documentElement.lang = language;
document.getElementById('head').replaceChildren(...columns.map((key) => {
  const th = document.createElement('th');
  th.className = `${key} ${numbers.includes(key) ? 'number' : ''}`;
  th.classList.remove('state');
  th.textContent = t(key);
  return th;
}));
look();
)";

}  // namespace polyarm::fleet
