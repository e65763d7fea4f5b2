/**
 * Switches between simulation and the real robot. It first shows what would be connected; then a person arms
 * the robot.
 */
import { useState } from 'preact/hooks';
import { t } from '../../i18n';
import { problemWords } from '../../i18n/told';
import { able } from '../../state/abilities';
import { complain, mayAdminister, mayMove, request, status } from '../../state/cell';
import { ArmDialog } from '../../shell/ArmDialog';
import { ask, open } from '../../ui/ask';
import { Button, Card, Loading, Segmented } from '../../ui/controls';
import { Dialog } from '../../ui/Dialog';
import { Icon } from '../../ui/Icon';
import type { CellConnectAnswer } from '../../wire/requests';
import { restart, restarting } from './restart';

export function Mode() {
  const now = status.value;
  const real = now ? !now.simulated : false;
  const to = (next: boolean) => {
    if (next) return open((close) => <ConnectDialog onClose={close} />);
    ask({ title: t('cell.toSimQ'), text: t('cell.toSimText'), action: t('cell.toSim'), onYes: () => void connect(false) });
  };
  return (
    <Card title={t('cell.mode')}>
      <Segmented
        label={t('cell.mode')}
        value={real ? 'real' : 'simulated'}
        disabled={!mayAdminister.value || restarting.value !== '' || !able('cell.connect')}
        options={[
          { id: 'simulated', name: t('mode.simulated'), icon: 'cube' },
          { id: 'real', name: t('mode.real'), icon: 'link' },
        ]}
        onChange={(id) => to(id === 'real')}
      />
      <p class="note">
        {t(real ? 'cell.realNote' : 'cell.simNote')}
        {!able('cell.connect') && !real && ` ${t('cell.realHow')}`}
      </p>
      {real && now && !now.armed && (
        <Button label={t('cell.arm')} icon="lock" tone="warn" big disabled={!mayMove.value} onClick={() => open((close) => <ArmDialog onClose={close} />)} />
      )}
    </Card>
  );
}

async function connect(real: boolean): Promise<void> {
  await restart(t('cell.starting'), t(real ? 'cell.connected' : 'cell.started'), 'cell.connect', { real }, () => (status.peek()?.simulated === real ? t('cell.notConnected') : ''));
}

/** Shows what would be connected. Nothing is connected before the user agrees. */
function ConnectDialog({ onClose }: { onClose: () => void }) {
  const [found, setFound] = useState<CellConnectAnswer | null>(null);
  const [asked, setAsked] = useState(false);
  if (!asked) {
    setAsked(true);
    request('cell.connect').then(setFound, (error) => (complain(error), onClose()));
  }
  const go = () => {
    onClose();
    void connect(true);
  };
  return (
    <Dialog
      title={t('cell.toRealQ')}
      onClose={onClose}
      actions={
        <>
          <Button label={t('dialog.cancel')} onClick={onClose} />
          <Button label={t('cell.toReal')} icon="link" tone="warn" disabled={!found?.possible || !mayAdminister.value} onClick={go} />
        </>
      }
    >
      {!found ? <Loading /> : <WhatIsThere found={found} />}
    </Dialog>
  );
}

function WhatIsThere({ found }: { found: CellConnectAnswer }) {
  const why = problemWords(found.problem ?? { code: 'refused', what: '' });
  return (
    <>
      {found.hardware.length > 0 && (
        <ul class="cell-hardware" aria-label={t('cell.connects')}>
          {found.hardware.map((each) => (
            <li key={each.component}>
              <strong>{each.component}</strong>
              <span>
                {each.driver}
                {each.drives && `: ${each.drives}`}
              </span>
              {each.devices.map((device) => (
                <span key={device.parameter} class={device.there ? 'good' : 'bad'}>
                  <Icon name={device.there ? 'check' : 'close'} size={18} /> <code>{device.path}</code> {t(device.there ? 'cell.isThere' : 'cell.notThere')}
                </span>
              ))}
            </li>
          ))}
        </ul>
      )}
      {found.possible ? (
        <p>{t('cell.toRealText')}</p>
      ) : (
        <div class="banner" role="alert">
          <Icon name="alarm" />
          <div>
            <strong>{why.text}</strong>
            <p>{[why.detail, why.advice].filter(Boolean).join(' · ')}</p>
          </div>
        </div>
      )}
    </>
  );
}
