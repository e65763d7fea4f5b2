import { type ComponentType, Component, type ComponentChildren } from 'preact';
import { effect } from '@preact/signals';
import { useEffect, useState } from 'preact/hooks';
import { language, t } from '../i18n';
import { type Page, pages } from '../pages';
import { connected } from '../state/cell';
import { ShownDialog } from '../ui/ask';
import { Button, Empty, Loading } from '../ui/controls';
import { Toasts } from '../ui/Toasts';
import { AlarmStrip } from './AlarmStrip';
import { ControlQuestion } from './Control';
import { Header } from './Header';
import { ProgramQuestion } from './ProgramQuestion';
import { LinkBanner } from './LinkBanner';
import { Bodies } from './Bodies';
import { RobotBar } from './RobotBar';
import { pageId } from './route';

effect(() => {
  document.documentElement.lang = language.value;
  document.documentElement.dataset.link = connected.value ? 'on' : 'off';
});

export function App() {
  const page = pages.find((each) => each.id === pageId.value) ?? pages[0]!;
  return (
    <>
      <a class="skip" href="#page" onClick={(e) => (e.preventDefault(), document.getElementById('page')?.focus())}>
        {t('app.skip')}
      </a>
      <Header />
      <AlarmStrip />
      <main id="page" tabIndex={-1} aria-label={t(page.label)}>
        <LinkBanner />
        <Bodies />
        <ProgramQuestion />
        <Shown key={page.id} page={page} />
      </main>
      <RobotBar />
      <ShownDialog />
      <ControlQuestion />
      <Toasts />
    </>
  );
}

const loaded = new Map<string, ComponentType>();

function Shown({ page }: { page: Page }) {
  const [Body, setBody] = useState<ComponentType | null>(() => loaded.get(page.id) ?? null);
  const [failed, setFailed] = useState(false);
  const load = () => {
    setFailed(false);
    page.load().then(
      (module) => {
        loaded.set(page.id, module.default);
        setBody(() => module.default);
      },
      () => setFailed(true),
    );
  };
  useEffect(() => {
    if (!Body) load();
  }, []);
  useEffect(() => {
    if (failed && connected.value) load();
  }, [connected.value]);
  if (failed) return <Broken again={load} />;
  if (!Body) return <Loading />;
  return (
    <Guard>
      <Body />
    </Guard>
  );
}

function Broken({ again }: { again: () => void }) {
  return (
    <Empty icon="alarm" text={t('page.failed')}>
      <Button label={t('page.again')} onClick={again} />
    </Empty>
  );
}

/** Catches the errors of a page, so that Stop and the bars stay usable. */
class Guard extends Component<{ children: ComponentChildren }, { failed: boolean }> {
  override state = { failed: false };
  override componentDidCatch(error: unknown): void {
    console.error(error);
    this.setState({ failed: true });
  }
  override render() {
    if (this.state.failed) return <Broken again={() => this.setState({ failed: false })} />;
    return this.props.children;
  }
}
