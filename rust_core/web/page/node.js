// Commands to the node, the state that they answer, and the token that they need.

import { byId, setText } from './elements.js';

const TOKEN = 'token';
const POST_TIMEOUT_MS = 5000;
const ANSWER_MS = 6000;
// So that it can be read before the next state wipes it away.
const FAILURE_MS = 3000;

// The node's last state, and null while there is no connection.
export let state = null;
let stateCame = 0;
// Its WebSocket.
export let socket = null;
let token = localStorage.getItem(TOKEN) ?? '';
let answerTimer = 0;
let forgetFailureAt = Infinity;

export const currentToken = () => token;

// Keeps a token for later visits, too.
export function setToken(given) {
  token = given.trim();
  localStorage.setItem(TOKEN, token);
}

export function setSocket(opened) {
  socket = opened;
}

// Sends a message over the WebSocket, if it is open.
export function send(message) {
  if (socket?.readyState === WebSocket.OPEN) {
    socket.send(JSON.stringify(message));
  }
}

// Keeps the newest state.
export function setState(next) {
  state = next;
  stateCame = performance.now();
  if (next && stateCame > forgetFailureAt) {
    setText(byId('failure'), '');
  }
}

// What a command that may light carries: the number of the state that it answers, and the node's clock at the press. The later
// that state came, the older the command looks.
export const answerTo = (event) => state && { number: state.number, sent_ms: state.clock_ms + event.timeStamp - stateCame };

// Posts a command; the response is the caller's to judge.
function request(command, body) {
  return fetch(`/api/${command}`, {
    method: 'POST',
    headers: { 'Authorization': `Bearer ${token}`, 'Content-Type': 'application/json' },
    body: JSON.stringify(body),
    signal: AbortSignal.timeout(POST_TIMEOUT_MS),
  });
}

// Shows the node's answer for a while, or what failed until the next command.
export function report(answer, failure) {
  clearTimeout(answerTimer);
  setText(byId('answer'), answer);
  setText(byId('failure'), failure);
  answerTimer = setTimeout(() => setText(byId('answer'), ''), ANSWER_MS);
}

// Posts a command and reports the answer; `source` is busy until it came. A failure of `what` is forgotten with the next state,
// and not reported if `isDone`. `show` takes the answer.
export async function post(command, body, source, what = null, isDone = () => false, show = (text) => report(text, '')) {
  source.setAttribute('aria-busy', 'true');
  report('', '');
  const fail = (why) => {
    forgetFailureAt = what ? performance.now() + FAILURE_MS : Infinity;
    report('', isDone() ? '' : `${what ?? command} failed: ${why}`);
  };
  try {
    const response = await request(command, body);
    const answer = await response.json().catch(() => ({}));
    if (response.ok) {
      show(answer.message ?? '');
    } else {
      fail(answer.message ?? `HTTP ${response.status}`);
    }
  } catch (error) {
    const why = error.name === 'TimeoutError' ? `no answer within ${POST_TIMEOUT_MS / 1000} s` : 'the node cannot be reached';
    fail(`${why}; see whether camera_stream runs`);
  } finally {
    source.removeAttribute('aria-busy');
  }
}

// Blacks out all cameras or one, by two roads: a POST, and the WebSocket, which is open already. Never lights anything.
export function black(source, camera = null) {
  const before = state?.number;
  const isBlack = () => (camera ? state.cameras.some((each) => each.name === camera && each.blackout) : state.blackout.on);
  send({ type: 'black', camera });
  post('blackout', { on: true, camera }, source, 'Black', () => state && state.number !== before && isBlack());
}

// Releases all blackouts, or a camera's own.
export function release(event, source, camera = null) {
  post('blackout', { on: false, camera, ...answerTo(event) }, source, 'Release');
}

// Sets values of a dynamic_reconfigure server.
export const setParameters = (server, values, source) => post('parameters', { server, values }, source);

// A WebSocket doesn't tell why it failed, a POST without a command does.
export async function isTokenWrong() {
  return request('parameters', {}).then((response) => response.status === 401, () => false);
}
