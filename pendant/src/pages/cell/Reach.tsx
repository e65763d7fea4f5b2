/**
 * Shows what a cell wants to access outside its folder, before it is opened. Hosts and secrets are allowed
 * here; native code and files only at a terminal.
 */
import { useEffect, useState } from 'preact/hooks';
import { type Key, t } from '../../i18n';
import { plain, problemWords, type Told } from '../../i18n/told';
import { complain, mayAdminister, request } from '../../state/cell';
import { RequestError } from '../../wire/connection';
import type { CellReachAnswer, WantedThing } from '../../wire/requests';
import { Button, Loading } from '../../ui/controls';
import { Dialog } from '../../ui/Dialog';
import { Icon } from '../../ui/Icon';

type Wanted = WantedThing;
type Reach = CellReachAnswer;

const kPatienceMs = 20_000;
const ask = (folder: string, allow?: string[]) => request('cell.reach', allow ? { folder, allow } : { folder }, kPatienceMs);

/** True if the user may allow it on this page. */
const open = (each: Wanted) => !each.allowed && (each.kind === 'host' || each.kind === 'secret');
/**
 * Devices are not counted, because they are used only with the real robot, which has a question of its own.
 */
const refused = (each: Wanted) => !each.allowed && each.kind !== 'device';

export async function wantsMore(folder: string): Promise<boolean> {
  return ask(folder).then(
    ({ wants }) => wants.some(refused),
    () => false,
  );
}

interface Props {
  folder: string;
  name: string;
  /** Undefined if the cell is not to be opened and the dialog only asks about access. */
  onOpen?: () => void;
  onClose: () => void;
}

export function ReachDialog({ folder, name, onOpen, onClose }: Props) {
  const [reach, setReach] = useState<Reach | null>(null);
  const [wrong, setWrong] = useState<Told | null>(null);
  useEffect(() => {
    ask(folder).then(setReach, (error: Error) => {
      setWrong(problemWords(error instanceof RequestError ? error.problem : { code: '', what: error.message }));
      setReach({ wants: [], unread: null });
    });
  }, [folder]);
  const asked = (reach?.wants ?? []).filter(open);
  const goOn = () => (onClose(), onOpen?.());
  const allow = () =>
    ask(
      folder,
      asked.map((each) => `${each.kind}:${each.what}`),
    ).then(goOn, complain);
  const may = mayAdminister.value && reach !== null;
  return (
    <Dialog
      title={t(onOpen ? 'cell.openQ' : 'reach.title', { name })}
      onClose={onClose}
      actions={
        <>
          <Button label={t(onOpen ? 'dialog.cancel' : 'reach.no')} onClick={onClose} />
          {onOpen && <Button label={t(asked.length ? 'reach.openOnly' : 'cell.open')} tone={asked.length ? 'plain' : 'primary'} disabled={!may} onClick={goOn} />}
          {asked.length > 0 && <Button label={t(onOpen ? 'reach.openAllow' : 'reach.yes')} tone="primary" disabled={!may} onClick={() => void allow()} />}
        </>
      }
    >
      {onOpen && <p>{t('cell.openText')}</p>}
      {wrong && <p class="problem-text">{wrong.text}</p>}
      {reach === null ? <Loading /> : !wrong && <Wants {...reach} />}
    </Dialog>
  );
}

function Wants({ wants, unread }: Reach) {
  const more = unread && (
    <p class="problem-text">
      {t('reach.unread')} {plain(unread)}
    </p>
  );
  if (wants.length === 0) return more || <p class="note">{t('reach.nothing')}</p>;
  return (
    <>
      <p>{t('reach.wants')}</p>
      <ul class="cell-reach" aria-label={t('reach.list')}>
        {wants.map((each) => (
          <li key={`${each.kind} ${each.what}`}>
            <Icon name={each.allowed ? 'check' : 'lock'} size={20} />
            <span>
              <strong>
                {t(`reach.${each.kind}` as Key)}: {each.what}
              </strong>
              <small>{each.why}</small>
              <small>{t(each.kind === 'device' ? 'reach.isReal' : each.allowed ? 'reach.isAllowed' : (`reach.do.${each.kind}` as Key))}</small>
              {refused(each) && !open(each) && <code>{each.kind === 'plugin' ? `polyarm plugins approve ${each.what}` : `polyarm run … --allow ${each.what}`}</code>}
            </span>
          </li>
        ))}
      </ul>
      {more}
      {wants.some(open) && <p class="note">{t('reach.trust')}</p>}
    </>
  );
}
