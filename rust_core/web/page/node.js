// Commands to the node, and the token that they need.

import { byId, setText } from './elements.js';

const TOKEN = 'token';
const POST_TIMEOUT_MS = 5000;
const ANSWER_MS = 6000;

let token = localStorage.getItem(TOKEN) ?? '';
let answerTimer = 0;

export const currentToken = () => token;

// Keeps a token for later visits, too.
export function setToken(given) {
  token = given.trim();
  localStorage.setItem(TOKEN, token);
}

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

// Posts a command and reports the answer; `source` is busy until it came.
export async function post(command, body, source = null) {
  source?.setAttribute('aria-busy', 'true');
  report('', '');
  try {
    const response = await request(command, body);
    const answer = await response.json().catch(() => ({}));
    if (response.ok) {
      report(answer.message ?? '', '');
    } else {
      report('', answer.message ?? `${command} failed: HTTP ${response.status}`);
    }
  } catch (error) {
    const why = error.name === 'TimeoutError' ? `no answer within ${POST_TIMEOUT_MS / 1000} s` : 'the node cannot be reached';
    report('', `${command} failed: ${why}; see whether camera_stream runs`);
  } finally {
    source?.removeAttribute('aria-busy');
  }
}

// Sets values of a dynamic_reconfigure server.
export const setParameters = (server, values, source) => post('parameters', { server, values }, source);

// A WebSocket doesn't tell why it failed, a POST without a command does.
export async function isTokenWrong() {
  return request('parameters', {}).then((response) => response.status === 401, () => false);
}
