/** Shows the name of the cell and its system, and resets the cell. */
import { useState } from 'preact/hooks';
import { number, t } from '../../i18n';
import { findingWords } from '../../i18n/told';
import { attempt, cell, complain, mayAdminister, mayProgram, request, robotName, status } from '../../state/cell';
import { loadPoints, pointsKnown } from '../../state/points';
import { Button, Card, Empty, Loading } from '../../ui/controls';
import { Icon } from '../../ui/Icon';
import type { Finding } from '../../wire/requests';
import type { RobotInfo } from '../../wire/types';
import { openWizard } from '../points/teaching';
import { AddMesh } from './AddMesh';
import { Mode } from './Mode';
import { askReset, restarting } from './restart';

/** Shown if the cell could not be built: opens another cell, or the same one again. */
function NoCell({ onProjects }: { onProjects: () => void }) {
  return (
    <Card title={t('cell.noneOpen')}>
      <Empty icon="cell" text={t('cell.noneOpenText')} />
      <div class="row">
        <Button label={t('cell.toProjects')} icon="folder" tone="primary" onClick={onProjects} />
        <Button label={t('cell.tryAgain')} icon="repeat" disabled={!mayAdminister.value} onClick={() => void attempt('cell.restart')} />
      </div>
    </Card>
  );
}

export function Overview({ onRobots, onProjects }: { onRobots: () => void; onProjects: () => void }) {
  const now = cell.value;
  if (status.value?.state === 'no cell' && restarting.value === '') return <NoCell onProjects={onProjects} />;
  if (!now) return <Loading />;
  return (
    <div class="cell-grid">
      <Card title={now.name}>
        <dl class="cell-facts">
          <div>
            <dt>{t('cell.folder')}</dt>
            <dd>{now.folder}</dd>
          </div>
          <div>
            <dt>{t('health.rate')}</dt>
            <dd>{number(now.rate_hz, 0)} Hz</dd>
          </div>
          <div>
            <dt>{t('cell.clients')}</dt>
            <dd>{status.value?.clients ?? '–'}</dd>
          </div>
        </dl>
        <div class="row">
          <Button
            label={t('cell.reset')}
            icon="undo"
            disabled={!mayAdminister.value || restarting.value !== ''}
            onClick={askReset}
          />
          <AddMesh />
          <Check />
        </div>
      </Card>
      <Mode />
      {now.robots.map((robot) => (
        <Robot key={robot.name} robot={robot} onRobots={onRobots} />
      ))}
      {restarting.value && <Working />}
    </div>
  );
}

export function Working() {
  return (
    <div class="cell-working" role="status">
      <span class="spinner" aria-hidden="true" />
      {restarting.value}
    </div>
  );
}

function Check() {
  const [found, setFound] = useState<Finding[] | null>(null);
  const [busy, setBusy] = useState(false);
  const go = () => {
    setBusy(true);
    request('cell.check', {}, 60_000)
      .then((answer) => setFound(answer.problems), complain)
      .finally(() => setBusy(false));
  };
  return (
    <>
      <Button label={t(busy ? 'program.checking' : 'cell.check')} icon="check" disabled={busy} onClick={go} />
      {found && (
        <div class="cell-found" role="status">
          {found.length === 0 && (
            <p class="cell-good">
              <Icon name="check" size={20} /> {t('cell.checkGood')}
            </p>
          )}
          <ul>
            {found.map((each, i) => {
              const { text, detail, advice } = findingWords(each);
              return (
                <li key={i} class={each.severity}>
                  <small>
                    {each.file}
                    {each.line ? `:${each.line}` : ''}
                  </small>
                  <strong>{text}</strong>
                  {detail && <span>{detail}</span>}
                  {advice && <span>{advice}</span>}
                </li>
              );
            })}
          </ul>
        </div>
      )}
    </>
  );
}

function Robot({ robot, onRobots }: { robot: RobotInfo; onRobots: () => void }) {
  return (
    <Card title={robot.name}>
      <div class="cell-robot">
        <Picture id={robot.id} title={robot.title} />
        <div>
          <h3>{robot.title || robot.id}</h3>
          <p class="note">{t('cell.axesOf', { axes: robot.joints.length })}</p>
          <Button label={t('cell.another')} icon="repeat" disabled={!mayAdminister.value || restarting.value !== ''} onClick={onRobots} />
        </div>
      </div>
      <Calibration name={robot.name} />
    </Card>
  );
}

/** The wizards that change what cell.yaml says of a robot. */
function Calibration({ name }: { name: string }) {
  const start = (kind: 'payload' | 'joints') => {
    robotName.value = name;
    if (!pointsKnown.value) void loadPoints();
    void openWizard(kind);
  };
  const off = !mayProgram.value || restarting.value !== '';
  return (
    <div class="row">
      <Button label={t('calibrate.payload')} icon="cube" disabled={off} onClick={() => start('payload')} />
      <Button label={t('calibrate.joints')} icon="settings" disabled={off} onClick={() => start('joints')} />
    </div>
  );
}

export function Picture({ id, title }: { id: string; title: string }) {
  const [bad, setBad] = useState(false);
  if (bad || !/^[\w.-]+\/[\w.-]+$/.test(id))
    return (
      <span class="cell-picture none">
        <Icon name="cube" size={40} />
      </span>
    );
  return <img class="cell-picture" src={`/api/catalogue/${id}.svg`} alt={title} loading="lazy" decoding="async" onError={() => setBad(true)} />;
}
