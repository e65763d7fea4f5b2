/** Points: the taught positions of the robot, frames and tools, and the cell's other data. */
import { useEffect, useState } from 'preact/hooks';
import { t } from '../../i18n';
import { WatchOnly } from '../../shell/Control';
import { complain, mayProgram, request } from '../../state/cell';
import { followPoints, groupNames, loadPoints } from '../../state/points';
import { toast } from '../../state/toasts';
import { open } from '../../ui/ask';
import { Button, Search, Segmented, Select } from '../../ui/controls';
import { RobotView } from '../../view3d/RobotView';
import { chosen, query, showGroup, shownGroup, shownKind } from './choice';
import { CameraWizard } from './CameraWizard';
import { Detail } from './Detail';
import { FrameWizard } from './FrameWizard';
import { List } from './List';
import { Outside } from './Outside';
import './points.css';
import { Teach } from './Teach';
import { ToolWizard } from './ToolWizard';

const roomy = matchMedia('(min-width: 900px)');

export default function Page() {
  const [wide, setWide] = useState(roomy.matches);
  useEffect(() => {
    const change = () => setWide(roomy.matches);
    roomy.addEventListener('change', change);
    const end = followPoints();
    return () => {
      roomy.removeEventListener('change', change);
      end();
      chosen.value = [];
    };
  }, []);
  return (
    <div class={`points-page ${chosen.value.length ? 'has-choice' : ''}`}>
      <WatchOnly needs="program" />
      <div class="points-left">
        <Teach />
        <Bar />
        <Outside />
        <List />
      </div>
      <div class="points-right">
        {wide && (
          <div class="points-picture">
            <RobotView />
          </div>
        )}
        <Detail />
      </div>
    </div>
  );
}

async function undo(): Promise<void> {
  try {
    const answer = await request('points.undo');
    toast({ kind: 'ok', text: t('points.undone', { what: answer.what }) });
    await loadPoints();
  } catch (error) {
    complain(error);
  }
}

function Bar() {
  return (
    <div class="points-bar">
      <Search class="points-search" label={t('points.search')} value={query.value} onInput={(text) => (query.value = text)} />
      <Segmented
        label={t('points.shown')}
        value={shownKind.value}
        options={[
          { id: 'points', name: t('nav.points') },
          { id: 'data', name: t('points.data') },
        ]}
        onChange={(id) => {
          shownKind.value = id;
          chosen.value = [];
        }}
      />
      {groupNames.value.length > 0 && <GroupFilter />}
      <div class="points-wizards">
        <Button label={t('points.frame')} icon="cube" disabled={!mayProgram.value} onClick={() => open((close) => <FrameWizard onClose={close} />)} />
        <Button label={t('points.tool')} icon="target" disabled={!mayProgram.value} onClick={() => open((close) => <ToolWizard onClose={close} />)} />
        <Button label={t('points.camera')} icon="eye" disabled={!mayProgram.value} onClick={() => open((close) => <CameraWizard onClose={close} />)} />
        <Button label={t('points.undo')} icon="undo" bare disabled={!mayProgram.value} onClick={() => void undo()} />
      </div>
    </div>
  );
}

/** The ids of the options are `=` plus the group name, or empty for all groups. */
function GroupFilter() {
  const now = shownGroup.value;
  return (
    <div class="points-filter">
      <Select
        label={t('points.group')}
        value={now === null ? '' : `=${now}`}
        options={[
          { id: '', name: t('points.allGroups') },
          ...groupNames.value.map((name) => ({ id: `=${name}`, name })),
          { id: '=', name: t('points.noGroup') },
        ]}
        onChange={(id) => showGroup(id === '' ? null : id.slice(1))}
      />
    </div>
  );
}
