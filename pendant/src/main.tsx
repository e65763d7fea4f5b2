import { render } from 'preact';
import './style/tokens.css';
import './style/base.css';
import './style/controls.css';
import './style/shell.css';
import { App } from './shell/App';
import { startKeys } from './shell/keys';
import { connect } from './state/cell';
import { startTheme } from './state/settings';

startTheme();
startKeys();
connect();
render(<App />, document.getElementById('app')!);
