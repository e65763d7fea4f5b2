import { render } from 'preact';
import './style/tokens.css';
import './style/base.css';
import './style/controls.css';
import './style/shell.css';
import { App } from './shell/App';
import { startDrops } from './shell/drops';
import { startKeys } from './shell/keys';
import { pageId } from './shell/route';
import { connect } from './state/cell';
import { startTheme } from './state/settings';

startTheme();
startKeys();
startDrops();
connect();
// The 3D picture is a large chunk: it is loaded in parallel with the page that shows it.
if (['run', 'move'].includes(pageId.peek())) import('./view3d/picture').catch(() => undefined);
render(<App />, document.getElementById('app')!);
