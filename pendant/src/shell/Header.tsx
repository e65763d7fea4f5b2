import { useEffect, useState } from 'preact/hooks';
import { t } from '../i18n';
import { pages } from '../pages';
import { cell, forced, robot, status, unseenAlarms } from '../state/cell';
import { open } from '../ui/ask';
import { Button } from '../ui/controls';
import { Dialog } from '../ui/Dialog';
import { Icon } from '../ui/Icon';
import { Alarms } from './Alarms';
import { ControlButton } from './Control';
import { Menu } from './Menu';
import { pageId } from './route';

export function Header() {
  return (
    <header class="top">
      <div class="brand">
        <img src="/icon.svg" alt="" width={32} height={32} />
        <div>
          <small class="brand-cell">{(!noCell() && cell.value?.name) || 'Polyarm'}</small>
          <strong title={title()}>{title()}</strong>
        </div>
      </div>
      <Navigation />
      <div class="top-right">
        <ForceBadge />
        <ControlButton />
        <AlarmsButton />
        <HelpLink />
        <Button
          label={t('menu.label')}
          icon="settings"
          bare
          tone="quiet"
          onClick={() => open((close) => <Menu onClose={close} />)}
        />
      </div>
    </header>
  );
}

/** While there is no cell, the header does not show the previous one. */
const noCell = () => status.value?.state === 'no cell';

/** The model of the robot; if there are several, also its name in the cell. */
function title(): string {
  const it = robot.value;
  if (!it || noCell()) return '';
  const what = it.title || it.id;
  return (cell.value?.robots.length ?? 0) > 1 ? `${it.name}: ${what}` : what;
}

function ForceBadge() {
  const names = forced.value;
  if (names.length === 0) return null;
  return (
    <a class="force-badge" href="#/signals" aria-label={t('forces.why', { names: names.join(', ') })} title={t('forces.why', { names: names.join(', ') })}>
      <Icon name="lock" size={18} />
      <span class="count">{t('forces.count', { count: names.length })}</span>
      <span class="few">{names.length}</span>
    </a>
  );
}

function AlarmsButton() {
  const count = unseenAlarms.value;
  return (
    <Button
      label={count ? t('alarms.count', { count }) : t('alarms.label')}
      icon="alarm"
      bare
      tone={count ? 'danger' : 'quiet'}
      badge={count}
      onClick={() => open((close) => <Alarms onClose={close} />)}
    />
  );
}

/** Opens the documentation of the open page in a new tab. */
function HelpLink() {
  const page = pages.find((each) => each.id === pageId.value) ?? pages[0]!;
  return (
    <a class="button quiet bare help-link" href={`/help/${page.help}`} target="polyarm-help" aria-label={t('help.label')} title={t('help.label')}>
      <Icon name="help" size={22} />
    </a>
  );
}

const kOnPhone = 4;
const phone = matchMedia('(max-width: 719px)');

function Navigation() {
  const [narrow, setNarrow] = useState(phone.matches);
  useEffect(() => {
    const changed = () => setNarrow(phone.matches);
    phone.addEventListener('change', changed);
    return () => phone.removeEventListener('change', changed);
  }, []);
  const shown = narrow ? pages.slice(0, kOnPhone) : pages;
  const rest = narrow ? pages.slice(kOnPhone) : [];
  const inRest = rest.find((page) => page.id === pageId.value);
  return (
    <nav class="pages" aria-label={t('nav.label')}>
      {shown.map((page) => (
        <PageLink key={page.id} page={page} />
      ))}
      {rest.length > 0 && (
        <button
          type="button"
          class={`page-link ${inRest ? 'here' : ''}`}
          aria-haspopup="dialog"
          onClick={() => open((close) => <MorePages onClose={close} pages={rest} />)}
        >
          <Icon name={inRest ? inRest.icon : 'more'} />
          <span>{t(inRest ? inRest.label : 'nav.more')}</span>
        </button>
      )}
    </nav>
  );
}

function PageLink({ page, onClick }: { page: (typeof pages)[number]; onClick?: () => void }) {
  const here = page.id === pageId.value;
  return (
    <a class={`page-link ${here ? 'here' : ''}`} href={`#/${page.id}`} aria-current={here ? 'page' : undefined} onClick={onClick}>
      <Icon name={page.icon} />
      <span>{t(page.label)}</span>
    </a>
  );
}

function MorePages(props: { pages: typeof pages; onClose: () => void }) {
  return (
    <Dialog title={t('nav.label')} onClose={props.onClose} side>
      <nav class="more-pages" aria-label={t('nav.more')}>
        {props.pages.map((page) => (
          <PageLink key={page.id} page={page} onClick={props.onClose} />
        ))}
      </nav>
    </Dialog>
  );
}
