/** Log-in with name and password, where the cell has users. The password is sent once and not kept. */
import { computed, effect, signal } from '@preact/signals';
import { useEffect, useState } from 'preact/hooks';
import { t } from '../i18n';
import { link } from '../state/cell';
import { Button, Field } from '../ui/controls';
import { Icon } from '../ui/Icon';

/** What the cell says about log-ins: whether it has users, whether this page may connect, and who is logged in here. */
const known = signal<{ users: boolean; enters?: boolean; name?: string; ended?: string; hours?: number }>({ users: false });

async function look(): Promise<void> {
  try {
    const answer = await fetch('/api/login', { cache: 'no-store' });
    if (answer.ok) known.value = (await answer.json()) as typeof known.value;
  } catch {
    // The cell does not answer: the banner says so.
  }
}

effect(() => {
  if (link.value !== 'open') void look();
});

/** True if the cell has users, and this page has neither a log-in nor a link: it cannot connect until then. */
export const mustLogIn = computed(() => link.value !== 'open' && known.value.users && !known.value.enters);

function basic(name: string, password: string): string {
  let bytes = '';
  for (const byte of new TextEncoder().encode(`${name}:${password}`)) bytes += String.fromCharCode(byte);
  return `Basic ${btoa(bytes)}`;
}

function refusal(answer: Response): string {
  if (answer.status === 429) return t('login.wait', { seconds: answer.headers.get('Retry-After') ?? '60' });
  return t(answer.status === 403 ? 'login.wrong' : 'login.failed');
}

/** Why this page's log-in has ended; empty if it had none. */
function ending(): string {
  const { ended, hours } = known.value;
  if (ended === 'time') return t('login.endedTime', { hours: String(Math.round((hours ?? 0) * 100) / 100) });
  if (ended === 'idle') return t('login.endedIdle');
  return ended ? t('login.endedChanged') : '';
}

export function LogIn() {
  const [name, setName] = useState('');
  const [password, setPassword] = useState('');
  const [why, setWhy] = useState('');
  const [busy, setBusy] = useState(false);
  const submit = async (event: Event) => {
    event.preventDefault();
    setBusy(true);
    try {
      const answer = await fetch('/api/login', { method: 'POST', headers: { Authorization: basic(name, password) } });
      if (answer.ok) return location.reload();
      setWhy(refusal(answer));
    } catch {
      setWhy(t('login.failed'));
    }
    setPassword('');
    setBusy(false);
  };
  return (
    <form class="log-in stack" aria-label={t('login.title')} onSubmit={(event) => void submit(event)}>
      <h2>
        <Icon name="lock" /> {t('login.title')}
      </h2>
      <p class="note">{ending() || t('login.why')}</p>
      <Field label={t('login.name')} login={{ name: 'name', type: 'text', autocomplete: 'username' }} value={name} onInput={setName} />
      <Field label={t('login.password')} login={{ name: 'password', type: 'password', autocomplete: 'current-password' }} value={password} onInput={setPassword} />
      {why && (
        <p class="problem-text" role="alert">
          {why}
        </p>
      )}
      <button type="submit" class="button primary" disabled={busy || !name || !password}>
        {t('login.enter')}
      </button>
    </form>
  );
}

/** Who is logged in, and the way out. Shown only after a log-in. */
export function LoggedIn() {
  useEffect(() => void look(), []);
  const name = known.value.name;
  if (!name) return null;
  const leave = () => void fetch('/api/logout', { method: 'POST' }).then(() => location.reload(), () => undefined);
  return (
    <section aria-label={t('login.title')}>
      <p>{t('login.as', { name })}</p>
      <Button label={t('login.leave')} onClick={leave} />
    </section>
  );
}
