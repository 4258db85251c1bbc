// The operator's page of camera_stream: what the projectors show, and what an operator can do about it.
//
// One WebSocket brings images, masks, the state and the log; what the operator does is a POST, so that a blackout never waits
// behind images. The page shows the node's state only: a button changes when the node says so, on all pages at once. Texts of
// the node become text nodes, never markup.
'use strict';

// --- elements ---------------------------------------------------------------------------------------------------------

const byId = (id) => document.getElementById(id);

// An element with attributes, listeners (`onclick`) and children, which are elements or text.
function make(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === 'function') {
      node.addEventListener(name.slice(2), value);
    } else {
      node.setAttribute(name, value);
    }
  }
  node.append(...children);
  return node;
}

// Sets a text where it changed, so that a selection and a screen reader's place stay.
function setText(node, text) {
  if (node.textContent !== text) {
    node.textContent = text;
  }
}

function setAttribute(node, name, value) {
  if (value === null) {
    node.removeAttribute(name);
  } else if (node.getAttribute(name) !== value) {
    node.setAttribute(name, value);
  }
}

// The children of an element, one view `{node, update(item)}` for each item. Views of known keys stay, and with them the focus.
class Views {
  constructor(parent, keyOf, create) {
    Object.assign(this, { parent, keyOf, create, views: new Map() });
  }

  show(items) {
    const views = new Map();
    items.forEach((item, index) => {
      const key = this.keyOf(item, index);
      const view = this.views.get(key) ?? this.create(item);
      views.set(key, view);
      if (this.parent.children[index] !== view.node) {
        this.parent.insertBefore(view.node, this.parent.children[index] ?? null);
      }
      view.update(item);
    });
    while (this.parent.children.length > items.length) {
      this.parent.lastElementChild.remove();
    }
    this.views = views;
  }
}

let lastId = 0;
const newId = () => `id-${++lastId}`;

// --- numbers ----------------------------------------------------------------------------------------------------------

const NONE = '–';

// A number with a unit, or a dash.
const withUnit = (value, unit, digits = 1) => (value === null || value === undefined ? NONE : `${value.toFixed(digits)} ${unit}`);

const rate = (hz) => withUnit(hz, 'Hz');

// Milliseconds in the unit in which they are read at a glance.
function duration(ms) {
  if (ms === null || ms === undefined || ms < 999.5) {
    return withUnit(ms, 'ms', ms < 9.95 ? 1 : 0);
  }
  return ms < 99_950 ? withUnit(ms / 1000, 's') : withUnit(ms / 60_000, 'min', 0);
}

// Without the digits that single precision adds.
const plain = (number) => String(Number(number.toPrecision(7)));

// --- what the operator does -------------------------------------------------------------------------------------------

const TOKEN = 'token';
const POST_TIMEOUT_MS = 5000;
const ANSWER_MS = 6000;
// A second press within this time is the same one: whoever presses twice in a hurry wants black, not light.
const RELEASE_AFTER_MS = 700;

let token = localStorage.getItem(TOKEN) ?? '';
// The node's last state, and null while there is no connection.
let state = null;
let blackSince = 0;
let answerTimer = 0;

// Shows the node's answer for a while, or what failed until the next command.
function report(answer, failure) {
  clearTimeout(answerTimer);
  setText(byId('answer'), answer);
  setText(byId('failure'), failure);
  answerTimer = setTimeout(() => setText(byId('answer'), ''), ANSWER_MS);
}

// Posts a command and reports the answer; `source` is busy until it came.
async function post(command, body, source = null) {
  source?.setAttribute('aria-busy', 'true');
  report('', '');
  try {
    const response = await fetch(`/api/${command}`, {
      method: 'POST',
      headers: { 'Authorization': `Bearer ${token}`, 'Content-Type': 'application/json' },
      body: JSON.stringify(body),
      signal: AbortSignal.timeout(POST_TIMEOUT_MS),
    });
    const answer = await response.json().catch(() => ({}));
    if (response.status === 401) {
      askForToken();
    } else if (!response.ok) {
      report('', answer.message ?? `${command} failed: HTTP ${response.status}`);
    } else {
      report(answer.message ?? '', '');
    }
  } catch (error) {
    const why = error.name === 'TimeoutError' ? `no answer within ${POST_TIMEOUT_MS / 1000} s` : 'the node cannot be reached';
    report('', `${command} failed: ${why}; see whether camera_stream runs`);
  } finally {
    source?.removeAttribute('aria-busy');
  }
}

// Black, or the release of all blackouts. Without a connection it is always black.
function pressBlack() {
  const isBlack = state?.blackout.on ?? false;
  if (!isBlack || performance.now() - blackSince > RELEASE_AFTER_MS) {
    post('blackout', { on: !isBlack, camera: null }, byId('black'));
  }
}

const setParameters = (server, values, source) => post('parameters', { server, values }, source);

// A switch that changes when the node's state does.
function makeSwitch(attributes, onSwitch) {
  const box = make('input', { type: 'checkbox', role: 'switch', ...attributes });
  let isOn = false;
  box.addEventListener('click', (event) => {
    event.preventDefault();
    onSwitch(!isOn, box);
  });
  const set = (on) => {
    isOn = on;
    box.checked = on;
  };
  return { box, set };
}

byId('black').addEventListener('click', pressBlack);
byId('pause').addEventListener('click', (event) => post('pause', { on: !state?.paused.on }, event.currentTarget));
byId('test-picture').addEventListener('click', (event) => post('test_picture', {}, event.currentTarget));

document.addEventListener('keydown', (event) => {
  const isTyping = event.target.closest?.('input:not([type="checkbox"]):not([type="radio"]), select, textarea');
  const isPlain = !event.repeat && !event.ctrlKey && !event.altKey && !event.metaKey;
  if (event.key.toLowerCase() === 'b' && isPlain && !isTyping) {
    event.preventDefault();
    pressBlack();
  }
});

// --- the light: one word for what the projectors show -----------------------------------------------------------------

// The word, the reason and the kind of a state.
function lightOf({ blackout, paused, test_picture: picture, cameras }) {
  const by = (who) => (who ? `set by ${who}` : '');
  const dark = cameras.filter((camera) => camera.dark !== null);
  const reasons = [...new Set(dark.map((camera) => camera.dark))].join('; ');
  if (blackout.on) {
    return ['black', 'Black', by(blackout.by)];
  }
  if (cameras.length === 0) {
    return ['dark', 'No camera', 'the config has no camera'];
  }
  if (dark.length === cameras.length) {
    return cameras.every((camera) => camera.blackout) ? ['black', 'Black', reasons] : ['dark', 'Dark', reasons];
  }
  const some = dark.map((camera) => `${camera.name} is dark: ${camera.dark}`).join('; ');
  if (picture !== null) {
    return ['test', 'Test picture', [picture, some].filter(Boolean).join('; ')];
  }
  if (paused.on) {
    return ['paused', 'Paused', [by(paused.by), some].filter(Boolean).join('; ')];
  }
  return some ? ['dark', `${dark.length} of ${cameras.length} dark`, some] : ['lit', 'Lit', ''];
}

const LIGHTS = { lit: '#ffe082', dark: '#ffc857', black: '#000', paused: '#4ea1e0', test: '#9575cd', lost: '#e53935' };
// A disc for each light. Browsers may load one later than it is set, so that all of them stay.
const ICONS = Object.fromEntries(Object.entries(LIGHTS).map(([light, color]) => {
  const disc = `<circle cx="16" cy="16" r="13" fill="${color}" stroke="#fff" stroke-width="3"/>`;
  const svg = `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32">${disc}</svg>`;
  return [light, URL.createObjectURL(new Blob([svg], { type: 'image/svg+xml' }))];
}));
// There before the page has loaded: browsers ask for /favicon.ico otherwise.
const icon = document.head.appendChild(make('link', { rel: 'icon', href: ICONS.lost }));
let shownLight = '';

// Shows the light in the rail and, when its word changes, in the tab and to screen readers.
function showLight([kind, word, why]) {
  setText(byId('light-word'), word);
  setText(byId('light-why'), why);
  setAttribute(byId('light'), 'data-light', kind);
  setAttribute(document.body, 'data-lost', kind === 'lost' ? '' : null);
  if (kind + word !== shownLight) {
    shownLight = kind + word;
    setText(byId('announcement'), word);
    document.title = [word, state?.node ?? 'camera_stream'].join(' – ');
    icon.href = ICONS[kind];
  }
}

// --- cameras ----------------------------------------------------------------------------------------------------------

const PLOT_SECS = 60;
// Hatching wider than this costs time and shows no more.
const MOST_MASK_PX = 640;

// A value now, and a plot of its last minute from 0 to its largest.
function makePlot(name, format) {
  const SVG = 'http://www.w3.org/2000/svg';
  const svg = document.createElementNS(SVG, 'svg');
  const path = svg.appendChild(document.createElementNS(SVG, 'path'));
  for (const [key, value] of Object.entries({ class: 'plot', role: 'img', viewBox: '0 0 60 20', preserveAspectRatio: 'none' })) {
    svg.setAttribute(key, value);
  }
  const now = make('span');
  const range = make('small');
  const node = make('div', {}, make('dt', {}, name), make('dd', {}, now, svg, range));
  let points = [];
  const add = (value) => {
    const time = performance.now() / 1000;
    points.push({ time, value });
    points = points.filter((point) => point.time > time - PLOT_SECS);
    const values = points.map((point) => point.value).filter((each) => each !== null);
    const most = Math.max(...values, Number.MIN_VALUE);
    let step = 'M';
    const draw = (point) => {
      if (point.value === null) {
        step = 'M';
        return '';
      }
      const place = `${step}${(PLOT_SECS + point.time - time).toFixed(2)} ${(19 - (18 * point.value) / most).toFixed(2)}`;
      step = 'L';
      return place;
    };
    path.setAttribute('d', points.map(draw).join(''));
    setText(now, format(value));
    setText(range, values.length ? `up to ${format(most)}` : '');
    setAttribute(svg, 'aria-label', `${name} in the last minute: ${range.textContent || 'none'}`);
  };
  return { node, add };
}

// A camera's image with hatching where masks and keep-out frames forbid light.
function makeScreen(name) {
  const image = make('canvas', { role: 'img', 'aria-label': `Image of ${name}`, width: 16, height: 10 });
  const hatching = make('canvas', { 'aria-hidden': 'true', width: 16, height: 10 });
  const caption = make('p', { class: 'caption' }, 'no image yet');
  const masked = make('p', { class: 'masked' });
  const node = make('div', { class: 'screen' }, image, hatching, caption, masked);
  const decode = (head, bytes) => createImageBitmap(new Blob([bytes], { type: `image/${head.format}` }));
  let hasImage = false;

  async function showImage(head, bytes) {
    const bitmap = await decode(head, bytes);
    hasImage = true;
    if (image.width !== bitmap.width || image.height !== bitmap.height) {
      image.width = bitmap.width;
      image.height = bitmap.height;
    }
    image.getContext('2d', { alpha: false }).drawImage(bitmap, 0, 0);
    bitmap.close();
  }

  async function showMask(head, bytes) {
    const bitmap = await decode(head, bytes);
    const scale = Math.min(1, MOST_MASK_PX / bitmap.width);
    hatching.width = Math.max(1, Math.round(bitmap.width * scale));
    hatching.height = Math.max(1, Math.round(bitmap.height * scale));
    const context = hatching.getContext('2d', { willReadFrequently: true });
    context.drawImage(bitmap, 0, 0, hatching.width, hatching.height);
    bitmap.close();
    // Grey becomes opacity, which the hatching then fills.
    const mask = context.getImageData(0, 0, hatching.width, hatching.height);
    let isMasked = false;
    for (let at = 0; at < mask.data.length; at += 4) {
      mask.data[at + 3] = mask.data[at];
      isMasked ||= mask.data[at] > 0;
    }
    context.putImageData(mask, 0, 0);
    context.globalCompositeOperation = 'source-in';
    context.fillStyle = context.createPattern(hatch(), 'repeat');
    context.fillRect(0, 0, hatching.width, hatching.height);
    setText(masked, isMasked ? 'hatched: no light' : '');
  }

  const update = (camera) => setText(caption, camera.dark ?? (hasImage ? '' : 'no image yet'));
  return { node, update, image: showImage, mask: showMask };
}

// A tile of diagonal lines on a tint.
function hatch() {
  const tile = make('canvas', { width: 10, height: 10 });
  const context = tile.getContext('2d');
  context.fillStyle = '#ff525233';
  context.fillRect(0, 0, 10, 10);
  context.strokeStyle = '#ff8a80';
  context.lineWidth = 2;
  for (const start of [-10, 0, 10]) {
    context.moveTo(start - 1, 11);
    context.lineTo(start + 11, -1);
  }
  context.stroke();
  return tile;
}

const LEVELS = { error: 'Error', warn: 'Warning', advice: 'What to do', ok: 'OK' };

// The lines of rviz's statuses: what is wrong, what to do about it, and then what is fine.
function makeStatuses() {
  const node = make('ul', { class: 'statuses' });
  const views = new Views(node, (_, index) => index, () => {
    const level = make('span', { class: 'level' });
    const text = make('span');
    const line = make('li', {}, level, text);
    const update = (status) => {
      setAttribute(line, 'data-level', status.level);
      setText(level, status.level === 'ok' ? '' : `${LEVELS[status.level]}: `);
      setText(text, status.name ? `${status.name}: ${status.text}` : status.text);
    };
    return { node: line, update };
  });
  const show = (statuses, advice = null) => {
    const all = advice ? [...statuses, { level: 'advice', name: '', text: advice }] : statuses;
    views.show(Object.keys(LEVELS).flatMap((level) => all.filter((status) => status.level === level)));
  };
  return { node, show };
}

function makeCamera({ name }) {
  const title = newId();
  const about = make('span');
  const black = make('button', { type: 'button', onclick: () => post('blackout', { on: !isBlack, camera: name }, black) });
  const screen = makeScreen(name);
  const plots = { rate_hz: makePlot('Rate', rate), latency_ms: makePlot('Latency', duration), age_ms: makePlot('Age', duration) };
  const figures = make('dl', { class: 'figures' }, ...Object.values(plots).map((plot) => plot.node));
  const statuses = makeStatuses();
  const nudge = makeNudge(name);
  const header = make('header', {}, make('h2', { id: title }, name), about, black);
  const node = make('article', { class: 'camera', 'aria-labelledby': title }, header, screen.node, figures, statuses.node, nudge.node);
  let isBlack = false;

  const update = (camera) => {
    isBlack = camera.blackout;
    const size = camera.size && `${camera.size.join(' × ')} ${camera.encoding}`;
    setText(about, [camera.topic, camera.frame && `frame ${camera.frame}`, size].filter(Boolean).join(', '));
    setText(black, isBlack ? `Release ${name}` : `Black ${name} only`);
    setAttribute(black, 'aria-pressed', String(isBlack));
    black.hidden = state.cameras.length < 2 && !isBlack;
    screen.update(camera);
    for (const [key, plot] of Object.entries(plots)) {
      plot.add(camera[key] ?? null);
    }
    statuses.show(camera.statuses.filter((status) => status.level !== 'ok'));
    nudge.update(camera.nudge);
  };
  return { node, update, image: screen.image, mask: screen.mask };
}

const cameras = new Views(byId('cameras'), (camera) => camera.name, makeCamera);

// --- nudging ----------------------------------------------------------------------------------------------------------

const DEGREE = Math.PI / 180;
// For each button its place in three columns, its words, and its move in steps; null leaves a place empty.
const MOVES = [
  [null, ['Up', { down_m: -1 }], null],
  [['Left', { right_m: -1 }], null, ['Right', { right_m: 1 }]],
  [['Nearer', { forward_m: 1 }], ['Down', { down_m: 1 }], ['Farther', { forward_m: -1 }]],
];
const TURNS = [
  [['Roll left', { roll_rad: -1 }], ['Tilt up', { pitch_rad: 1 }], ['Roll right', { roll_rad: 1 }]],
  [['Turn left', { yaw_rad: -1 }], null, ['Turn right', { yaw_rad: 1 }]],
  [null, ['Tilt down', { pitch_rad: -1 }], null],
];
const ARROWS = { ArrowUp: 'Up', ArrowDown: 'Down', ArrowLeft: 'Left', ArrowRight: 'Right' };
const SUM = { x: 'mm', y: 'mm', z: 'mm', roll: '°', pitch: '°', yaw: '°' };

// A choice of two steps, and a button for each direction.
function makePad(legend, steps, rows, onMove) {
  const group = newId();
  let step = steps[0][1];
  const choices = steps.map(([label, value], index) => {
    const choice = make('input', { type: 'radio', name: group, onchange: () => { step = value; } });
    choice.checked = index === 0;
    return make('label', {}, choice, label);
  });
  const buttons = new Map();
  const places = rows.flat().map((place) => {
    if (!place) {
      return make('span');
    }
    const [label, move] = place;
    const onclick = () => onMove(Object.fromEntries(Object.entries(move).map(([axis, steps]) => [axis, steps * step])), button);
    const button = make('button', { type: 'button', onclick }, label);
    buttons.set(label, button);
    return button;
  });
  const pad = make('div', { class: 'pad' }, ...places);
  pad.addEventListener('keydown', (event) => {
    const button = buttons.get(ARROWS[event.key]);
    if (button && !event.repeat) {
      event.preventDefault();
      button.click();
    }
  });
  return make('fieldset', {}, make('legend', {}, legend), make('div', { class: 'steps' }, ...choices), pad);
}

// The pad that moves the projector's frame, hidden where no projector can be nudged.
function makeNudge(camera) {
  const move = (steps, button) => post('nudge', { camera, ...steps }, button);
  const title = make('summary');
  const problem = make('p', { class: 'problem' });
  const moves = makePad('Move', [['1 mm', 0.001], ['10 mm', 0.01]], MOVES, move);
  const turns = makePad('Turn', [['0.1°', 0.1 * DEGREE], ['1°', DEGREE]], TURNS, move);
  const values = Object.fromEntries(Object.keys(SUM).map((axis) => [axis, make('dd')]));
  const sum = make('dl', { class: 'sum' }, ...Object.entries(values).map(([axis, value]) => make('div', {}, make('dt', {}, axis), value)));
  const save = make('button', { type: 'button', onclick: () => post('save', { camera }, save) }, 'Save to the file');
  const revert = make('button', { type: 'button', onclick: () => post('revert', { camera }, revert) }, 'Revert');
  const note = make('p', {}, 'Moves where TF has the projector, along the axes of its image: what it draws moves the other way.');
  const node = make('details', { class: 'nudge' }, title, problem, note,
    make('div', { class: 'pads' }, moves, turns), sum, make('div', { class: 'buttons' }, save, revert));

  const update = (nudge) => {
    node.hidden = nudge === null;
    if (nudge === null) {
      return;
    }
    const isMoved = Object.keys(SUM).some((axis) => nudge[axis] !== 0);
    setText(title, `Nudge ${nudge.node}${isMoved ? ': moved, not saved' : ''}`);
    setText(problem, nudge.problem ?? '');
    for (const [axis, unit] of Object.entries(SUM)) {
      const value = unit === 'mm' ? `${(nudge[axis] * 1000).toFixed(1)} mm` : `${(nudge[axis] / DEGREE).toFixed(2)}°`;
      setText(values[axis], value);
    }
    moves.disabled = turns.disabled = nudge.problem !== null;
    save.disabled = revert.disabled = nudge.problem !== null || !isMoved;
  };
  return { node, update };
}

// --- displays ---------------------------------------------------------------------------------------------------------

function makeDisplay() {
  const name = make('span');
  const kind = make('small');
  const cells = {
    shown: make('td', { class: 'shown' }),
    topic: make('td', { class: 'topic' }),
    rate: make('td', { class: 'number' }),
    age: make('td', { class: 'number' }),
  };
  const statuses = makeStatuses();
  const switches = new Views(cells.shown, ([camera]) => camera, ([camera]) => {
    const label = make('span');
    const { box, set } = makeSwitch({}, (on, source) => {
      const server = state?.cameras.find((each) => each.name === camera)?.parameters;
      setParameters(server, { [parameter]: on }, source);
    });
    let parameter;
    const update = ([, { name: parameterName, on, display }]) => {
      parameter = parameterName;
      setText(label, state.cameras.length > 1 ? camera : '');
      setAttribute(box, 'aria-label', `Show ${display} in ${camera}`);
      set(on);
    };
    return { node: make('label', { class: 'switch' }, box, label), update };
  });
  const node = make('tr', {}, cells.shown, make('th', { scope: 'row' }, name, kind), cells.topic, cells.rate, cells.age,
    make('td', {}, statuses.node));

  const update = (display) => {
    setText(name, display.path);
    setText(kind, display.class);
    setText(cells.topic, display.topic ?? '');
    setText(cells.rate, display.rate_hz === null ? '' : rate(display.rate_hz));
    setText(cells.age, display.age_ms === null ? '' : duration(display.age_ms));
    statuses.show(display.statuses, display.advice);
    switches.show(Object.entries(display.switches).map(([camera, each]) => [camera, { ...each, display: display.path }]));
  };
  return { node, update };
}

const displays = new Views(byId('displays-rows'), (display, index) => `${index} ${display.path}`, makeDisplay);

function summaryOf(list) {
  const count = (level) => list.filter((display) => display.level === level).length;
  const wrong = [['error', 'errors'], ['warn', 'warnings']].filter(([level]) => count(level) > 0);
  return [`${list.length} in all`, ...wrong.map(([level, words]) => `${count(level)} with ${words}`)].join(', ');
}

// --- settings: dynamic_reconfigure ------------------------------------------------------------------------------------

// The element and the setter of a parameter; `onChange` gets a value of its type.
function makeField(parameter, id, onChange) {
  if (parameter.type === 'bool') {
    return makeSwitch({ id }, onChange);
  }
  const isNumber = parameter.type === 'int' || parameter.type === 'double';
  const read = () => (isNumber ? Number(box.value) : box.value);
  let box;
  if (parameter.choices?.length) {
    const option = ({ name, value, description }) => make('option', { value, title: description ?? '' }, name);
    box = make('select', { id }, ...parameter.choices.map(option));
  } else if (isNumber) {
    box = make('input', { id, type: 'number', step: parameter.type === 'int' ? 1 : 'any' });
    for (const end of ['min', 'max']) {
      if (Number.isFinite(parameter[end]) && Math.abs(parameter[end]) < 1e9) {
        box.setAttribute(end, parameter[end]);
      }
    }
  } else {
    box = make('input', { id, type: 'text' });
  }
  // What is being typed stays until it is sent.
  let isEdited = false;
  box.addEventListener('input', () => { isEdited = true; });
  box.addEventListener('change', async () => {
    if (box.value !== '' || !isNumber) {
      await onChange(read(), box);
    }
    isEdited = false;
  });
  const set = (value) => {
    const text = isNumber && !parameter.choices?.length ? plain(value) : String(value);
    if (!isEdited && box.value !== text) {
      box.value = text;
    }
  };
  return { box, set };
}

function makeParameter(server, parameter) {
  const id = newId();
  const { box, set } = makeField(parameter, id, (value, source) => setParameters(server, { [parameter.name]: value }, source));
  const number = (value) => (typeof value === 'number' ? plain(value) : String(value));
  const isRange = box.min !== undefined && box.min !== '' && box.max !== '';
  const limits = [isRange && `${number(parameter.min)} to ${number(parameter.max)}`, `default ${number(parameter.default)}`];
  const about = make('small', { id: newId() }, `${parameter.description} (${limits.filter(Boolean).join('; ')})`);
  setAttribute(box, 'aria-describedby', about.id);
  const node = make('div', { class: 'parameter' }, make('label', { for: id }, parameter.name), box, about);
  return { node, update: (now) => set(now.value) };
}

function makeServer({ name }) {
  const summary = make('summary');
  const list = make('div', { class: 'parameters' });
  // A parameter with other limits is another one.
  const key = ({ value, ...description }) => JSON.stringify(description);
  const views = new Views(list, key, (parameter) => makeParameter(name, parameter));
  const update = (server) => {
    setText(summary, server.camera ? `${server.camera} (${name})` : name);
    views.show(server.parameters);
  };
  return { node: make('details', {}, summary, list), update };
}

const servers = new Views(byId('settings'), (server) => server.name, makeServer);

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

let socket = null;
let retryMs = FIRST_RETRY_MS;
let timer = 0;
let silence = 0;
let watched = null;

function send(message) {
  if (socket?.readyState === WebSocket.OPEN) {
    socket.send(JSON.stringify(message));
  }
}

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
  if (next.blackout.on && !state?.blackout.on) {
    blackSince = performance.now();
  }
  state = next;
  retryMs = FIRST_RETRY_MS;
  byId('token-form').hidden = true;
  byId('node').hidden = false;
  showLight(lightOf(state));
  setText(byId('black-word'), state.blackout.on ? 'Release' : 'Black');
  setAttribute(byId('black'), 'data-on', state.blackout.on ? '' : null);
  setText(byId('pause'), state.paused.on ? 'Go on' : 'Pause');
  setAttribute(byId('pause'), 'aria-pressed', String(state.paused.on));
  setText(byId('test-picture'), state.test_picture === null ? 'Test picture' : 'Next test picture');
  setAttribute(byId('test-picture'), 'aria-pressed', String(state.test_picture !== null));
  cameras.show(state.cameras);
  setText(byId('displays-summary'), summaryOf(state.displays));
  displays.show(state.displays);
  servers.show(state.reconfigure);
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

function receive(data) {
  clearTimeout(silence);
  silence = setTimeout(() => lose(), SILENCE_MS);
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
  clearTimeout(silence);
  socket?.close();
  if (!token) {
    askForToken();
    return;
  }
  const address = `${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/api/stream`;
  const opened = new WebSocket(address, ['rcs', `token.${token}`]);
  opened.binaryType = 'arraybuffer';
  socket = opened;
  watched = null;
  opened.onopen = () => byId('log').replaceChildren();
  opened.onmessage = (event) => { if (opened === socket) receive(event.data); };
  opened.onclose = () => { if (opened === socket) lose(); };
}

// Says that the connection is gone, and tries again, ever more slowly.
async function lose() {
  clearTimeout(silence);
  const wasConnected = state !== null;
  state = null;
  const lost = socket;
  socket = null;
  lost?.close();
  setText(byId('black-word'), 'Black');
  setAttribute(byId('black'), 'data-on', null);
  showLight(['lost', wasConnected || byId('node').hidden === false ? 'Connection lost' : 'No connection',
    'What you see here is old, and the projectors may be lit. The page connects again by itself.']);
  clearTimeout(timer);
  timer = setTimeout(connect, retryMs);
  retryMs = Math.min(2 * retryMs, LAST_RETRY_MS);
  if (!wasConnected && await isTokenWrong() && !state) {
    askForToken();
  }
}

// A WebSocket doesn't tell why it failed, a POST without a command does.
async function isTokenWrong() {
  const request = { method: 'POST', headers: { 'Authorization': `Bearer ${token}`, 'Content-Type': 'application/json' }, body: '{}' };
  return fetch('/api/parameters', request).then((response) => response.status === 401, () => false);
}

function askForToken() {
  clearTimeout(timer);
  showLight(['lost', 'No access', token ? 'The token is not that of this node.' : 'The page has no token yet.']);
  byId('node').hidden = true;
  byId('token-form').hidden = false;
}

// Takes a token, from the address or typed in, and connects with it. It doesn't stay in the address, which people share.
function takeToken(given) {
  token = given.trim();
  localStorage.setItem(TOKEN, token);
  history.replaceState(null, '', location.pathname);
  retryMs = FIRST_RETRY_MS;
  connect();
}

function readAddress() {
  const given = new URLSearchParams(location.hash.slice(1)).get(TOKEN);
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
