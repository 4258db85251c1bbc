// The operator's page of camera_stream: what the projectors show, and what an operator can do about it.
//
// One WebSocket brings images, masks, the state and the log; what the operator does is a POST, so that it never waits behind
// images. Black takes both roads. The page shows the node's state only: a button changes when the node says so, on all pages at once.

import { makeCamera } from './camera.js';
import { makeDisplay, summaryOf } from './displays.js';
import { LEVELS, Views, byId, make, setText } from './elements.js';
import { lightOf, showLight } from './light.js';
import {
  answerTo, black, currentToken, isTokenWrong, post, release, report, send, setSocket, setState, setToken, socket, state,
} from './node.js';
import { makeServer } from './settings.js';
import { watchShortcuts } from './shortcuts.js';
import { mark, nextCue, pressCue, showBrightness, showCues } from './show.js';

const cameras = new Views(byId('cameras'), (camera) => camera.name, makeCamera);
const displays = new Views(byId('displays-rows'), (display, index) => `${index} ${display.path}`, makeDisplay);
const servers = new Views(byId('settings'), (server) => server.name, makeServer);

// --- black, release, pause, test pictures -----------------------------------------------------------------------------

byId('black').addEventListener('click', () => black(byId('black')));
byId('release').addEventListener('click', (event) => release(event, byId('release')));
byId('pause').addEventListener('click', (event) => {
  const on = !state?.paused.on;
  post('pause', { on, ...answerTo(event) }, event.currentTarget, on ? 'Pause' : 'Resume');
});
byId('test-picture').addEventListener('change', (event) => {
  const picture = event.currentTarget;
  post('test_picture', { name: picture.value || null, ...answerTo(event) }, picture, 'Test picture');
  // It shows what is shown, not what is wanted.
  picture.value = state?.test_picture ?? '';
});

function showPictures({ test_picture: shown, test_pictures: names }) {
  const box = byId('test-picture');
  if (box.options.length !== names.length + 1) {
    const option = (name) => make('option', { value: name }, `Test: ${name}`);
    box.replaceChildren(make('option', { value: '' }, 'Scene'), ...names.map(option));
  }
  if (box.value !== (shown ?? '')) {
    box.value = shown ?? '';
  }
  box.toggleAttribute('data-on', shown !== null);
}

watchShortcuts((key, event) => {
  if (key === 'b') {
    black(byId('black'));
  } else if (key === 'l' && event.shiftKey && !byId('release').disabled) {
    release(event, byId('release'));
  } else if (key === ' ' && state?.cues.names.length) {
    nextCue();
  } else if (key === 'm') {
    mark();
  } else {
    return pressCue(key);
  }
  return true;
});

// --- log --------------------------------------------------------------------------------------------------------------

const MOST_LINES = 200;

function showLog(lines) {
  const log = byId('log');
  const isAtEnd = log.scrollTop + log.clientHeight > log.scrollHeight - 8;
  for (const { time, level, text } of lines) {
    const clock = make('time', {}, new Date(time * 1000).toLocaleTimeString('en-GB'));
    const word = level === 'info' ? '' : `${LEVELS[level] ?? level}: `;
    log.append(make('li', { 'data-level': level }, clock, ' ', make('span', { class: 'level' }, word), text));
  }
  while (log.children.length > MOST_LINES) {
    log.firstElementChild.remove();
  }
  if (isAtEnd) {
    log.scrollTop = log.scrollHeight;
  }
}

// --- the connection ---------------------------------------------------------------------------------------------------

const FIRST_RETRY_MS = 500;
const LAST_RETRY_MS = 5000;
// The node sends its state every second.
const SILENCE_MS = 4000;

let retryMs = FIRST_RETRY_MS;
let timer = 0;
let silence = 0;
let watched = null;

// Asks for the images of all cameras, of none while nobody sees the page.
function watch() {
  const wanted = document.hidden || !state ? [] : state.cameras.map((camera) => camera.name);
  if (watched !== wanted.join('\n')) {
    watched = wanted.join('\n');
    send({ type: 'watch', cameras: wanted });
    send({ type: 'ready' });
  }
}

function showState(next) {
  setState(next);
  retryMs = FIRST_RETRY_MS;
  byId('token-form').hidden = true;
  byId('node').hidden = false;
  showLight(lightOf(state));
  byId('release').disabled = !state.blackout.on && !state.cameras.some((camera) => camera.black);
  setText(byId('pause'), state.paused.on ? 'Resume' : 'Pause');
  byId('pause').toggleAttribute('data-on', state.paused.on);
  showPictures(state);
  showBrightness(state.brightness);
  showCues(state.cues);
  cameras.show(state.cameras, state);
  setText(byId('displays-summary'), summaryOf(state.displays));
  displays.show(state.displays, state);
  servers.show(state.reconfigure, state);
  setText(byId('about'), `${state.node}, ${state.config}, version ${state.version}`);
  watch();
}

// An image or a mask: the length of the head, the head, the file.
async function showBinary(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  try {
    await cameras.views.get(head.camera)?.[head.type]?.(head, new Uint8Array(buffer, 4 + length));
  } catch {
    report('', `${head.type} of ${head.camera} cannot be decoded`);
  }
  if (head.type === 'image') {
    send({ type: 'ready' });
  }
}

function expectMessage() {
  clearTimeout(silence);
  silence = setTimeout(lose, SILENCE_MS);
}

function receive(data) {
  expectMessage();
  if (data instanceof ArrayBuffer) {
    showBinary(data);
    return;
  }
  const message = JSON.parse(data);
  if (message.type === 'state') {
    showState(message);
  } else if (message.type === 'log') {
    showLog(message.lines);
  }
}

function connect() {
  clearTimeout(timer);
  socket?.close();
  if (!currentToken()) {
    askForToken();
    return;
  }
  const address = `${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/api/stream`;
  const opened = new WebSocket(address, ['rcs', `token.${currentToken()}`]);
  opened.binaryType = 'arraybuffer';
  setSocket(opened);
  watched = null;
  expectMessage();
  opened.onopen = () => {
    byId('log').replaceChildren();
    cameras.views.forEach((view) => view.clear());
  };
  opened.onmessage = (event) => { if (opened === socket) receive(event.data); };
  opened.onclose = () => { if (opened === socket) lose(); };
}

// Says that the connection is gone, and tries again, ever more slowly.
async function lose() {
  clearTimeout(silence);
  const wasConnected = state !== null;
  setState(null);
  const lost = socket;
  setSocket(null);
  lost?.close();
  byId('release').disabled = true;
  showLight(['lost', byId('node').hidden ? 'No connection' : 'Connection lost',
    'What you see here is old, and the projectors may be lit. The page connects again by itself.']);
  clearTimeout(timer);
  timer = setTimeout(connect, retryMs);
  retryMs = Math.min(2 * retryMs, LAST_RETRY_MS);
  if (!wasConnected && await isTokenWrong() && !state) {
    askForToken();
  }
}

function askForToken() {
  clearTimeout(timer);
  clearTimeout(silence);
  showLight(['lost', 'No access', currentToken() ? 'The token is not that of this node.' : 'The page has no token yet.']);
  byId('node').hidden = true;
  byId('token-form').hidden = false;
}

// Takes a token, from the address or typed in, and connects with it. It doesn't stay in the address, which people share.
function takeToken(given) {
  setToken(given);
  history.replaceState(null, '', location.pathname);
  retryMs = FIRST_RETRY_MS;
  connect();
}

function readAddress() {
  const given = new URLSearchParams(location.hash.slice(1)).get('token');
  if (given) {
    takeToken(given);
  }
  return Boolean(given);
}

byId('token-form').addEventListener('submit', (event) => {
  event.preventDefault();
  takeToken(byId('token').value);
});
window.addEventListener('hashchange', readAddress);
window.addEventListener('online', () => { if (!state) connect(); });
document.addEventListener('visibilitychange', watch);

if (!readAddress()) {
  connect();
}
