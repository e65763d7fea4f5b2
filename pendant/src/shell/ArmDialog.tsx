/**
 * Compares the measured joint positions with the expected ones. The drives switch on only after the user has
 * confirmed.
 */
import { useState } from 'preact/hooks';
import { t } from '../i18n';
import { attempt, cell, complain, mayMove, request, status, ways } from '../state/cell';
import { Button, Loading } from '../ui/controls';
import { Dialog } from '../ui/Dialog';
import { jointText, jointTitle } from '../ui/format';
import type { ExpectedJoint } from '../wire/requests';

export function ArmDialog({ onClose }: { onClose: () => void }) {
  const [joints, setJoints] = useState<ExpectedJoint[] | null>(null);
  const [asked, setAsked] = useState(false);
  if (!asked) {
    setAsked(true);
    request('control.arm').then((answer) => setJoints(answer.joints ?? []), complain);
  }
  const robots = cell.value?.robots ?? [];
  const jointOf = (name: string) => robots.flatMap((robot) => robot.joints.map((joint) => ({ robot: robot.name, joint }))).find(({ joint }) => joint.interface === name);
  const waits = ways.value.going && status.value?.state === 'running' && !status.value.program!.paused ? status.value.program!.file : '';
  const unit = (name: string) => jointOf(name)?.joint.unit ?? 'rad';
  /** The joint's name as on the Move page, with the robot if there are several. */
  const title = (name: string) => {
    const found = jointOf(name);
    return found ? [robots.length > 1 && found.robot, jointTitle(found.joint.name)].filter(Boolean).join(': ') : name;
  };
  return (
    <Dialog
      title={t('cell.arm')}
      onClose={onClose}
      actions={
        <>
          <Button label={t('dialog.cancel')} onClick={onClose} />
          <Button label={t('cell.armDo')} tone="warn" disabled={!joints || !mayMove.value} onClick={() => (onClose(), void attempt('control.arm', { confirmed: true }))} />
        </>
      }
    >
      <p>{t('cell.armText')}</p>
      {waits && <p class="problem-text">{t('cell.armRuns', { name: waits.split('/').pop()! })}</p>}
      {!joints ? (
        <Loading />
      ) : (
        <table class="plain">
          <thead>
            <tr>
              <th scope="col">{t('cell.joint')}</th>
              <th scope="col" class="right">
                {t('cell.measured')}
              </th>
              <th scope="col" class="right">
                {t('cell.expected')}
              </th>
            </tr>
          </thead>
          <tbody>
            {joints.map((each) => (
              <tr key={each.joint}>
                <th scope="row">{title(each.joint)}</th>
                <td class="right">{jointText(each.measured ?? NaN, unit(each.joint))}</td>
                <td class="right">{jointText(each.expected ?? NaN, unit(each.joint))}</td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
    </Dialog>
  );
}
