import { effect } from '@preact/signals';
import { render } from 'preact';
import './style/tokens.css';
import './style/base.css';
import './style/controls.css';
import './style/shell.css';
import { tablesLoaded } from './i18n/told';
import { languageTried } from './i18n';
import { App } from './shell/App';
import { startDrops } from './shell/drops';
import { startKeys } from './shell/keys';
import { pageId } from './shell/route';
import { connect, connected } from './state/cell';
import { startTheme } from './state/settings';

startTheme();
startKeys();
startDrops();
connect();
// The 3D picture is a large chunk: it is loaded in parallel with the page that shows it.
if (['run', 'move'].includes(pageId.peek())) import('./view3d/picture').catch(() => undefined);
// The first picture is in the user's language; in English if its table does not come soon, and until it comes.
void languageTried(2000).then(() => render(<App />, document.getElementById('app')!));
effect(() => {
  if (connected.value) void tablesLoaded().catch(() => undefined);
});
