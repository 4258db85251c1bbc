// How bright the projectors show it, and cues: named sets of visible displays with a brightness.

import { Views, byId, make, setAttribute, setText } from './elements.js';
import { post, setParameters, state } from './node.js';

const percent = (share) => `${Math.round(100 * share)} %`;

// A field of the node's own settings. Of the values while it is dragged or typed in, the last one is sent when the answer to the
// one before has come; until then the field shows what is wanted.
function makeField(box, name, event, { toNode, toField }) {
  let wanted = null;
  let isSending = false;
  box.addEventListener('input', () => { wanted = box.value; });
  box.addEventListener(event, async () => {
    if (box.value === '') {
      wanted = null;
    }
    if (isSending) {
      return;
    }
    isSending = true;
    while (wanted !== null) {
      const value = Number(wanted);
      wanted = null;
      await setParameters(state?.node, { [name]: toNode(value) }, box);
    }
    isSending = false;
  });
  return (value) => {
    if (wanted === null && !isSending && box.value !== toField(value)) {
      box.value = toField(value);
    }
  };
}

const setShare = makeField(byId('brightness'), 'brightness', 'input',
  { toNode: (value) => value / 100, toField: (share) => String(Math.round(100 * share)) });
const setFade = makeField(byId('fade'), 'fade_seconds', 'change', { toNode: (value) => value, toField: String });

export function showBrightness({ share, fade_seconds: fade }) {
  setShare(share);
  setFade(fade);
  setText(byId('brightness-value'), percent(share));
  byId('brightness').setAttribute('aria-valuetext', percent(share));
}

// What a brightness below the full one is for the light; empty for the full one.
export const brightnessNote = ({ share }) => (share < 1 ? `brightness ${percent(share)}` : '');

// --- cues -------------------------------------------------------------------------------------------------------------

// Keys 1 to 9.
const MOST_KEYS = 9;

const showCue = (name, source) => post('cue', { name }, source);

// Shows the cue after the current one.
export const nextCue = () => showCue(null, byId('next-cue'));

// Shows the cue of a key; false if it is none.
export function pressCue(key) {
  const name = /^[1-9]$/.test(key) ? state?.cues.names[Number(key) - 1] : undefined;
  if (name !== undefined) {
    showCue(name, byId('cues'));
  }
  return name !== undefined;
}

function makeCue([name, index]) {
  const key = index < MOST_KEYS ? String(index + 1) : null;
  const show = (event) => {
    showCue(name, button);
    // After a click the space bar is for the next cue, not for this one again.
    if (event.detail > 0) {
      button.blur();
    }
  };
  const hint = key ? [make('kbd', { 'aria-hidden': 'true' }, key)] : [];
  const button = make('button', { type: 'button', onclick: show }, name, ...hint);
  const update = (_, current) => {
    button.toggleAttribute('data-on', current === name);
    setAttribute(button, 'aria-pressed', String(current === name));
  };
  return { node: button, update };
}

function makeRemoval(name) {
  const button = make('button', { type: 'button', onclick: () => post('remove_cue', { name }, button) }, `Remove ${name}`);
  return { node: button, update: () => {} };
}

const cues = new Views(byId('cues'), ([name, index]) => `${index} ${name}`, makeCue);
const removals = new Views(byId('remove-cues'), (name) => name, makeRemoval);

export function showCues({ names, current, problem }) {
  cues.show(names.map((name, index) => [name, index]), current);
  removals.show(names);
  byId('next-cue').hidden = names.length === 0;
  setText(byId('cues-problem'), problem ?? '');
}

byId('next-cue').addEventListener('click', (event) => {
  nextCue();
  if (event.detail > 0) {
    byId('next-cue').blur();
  }
});
byId('save-cue').addEventListener('submit', async (event) => {
  event.preventDefault();
  await post('save_cue', { name: byId('cue-name').value }, event.submitter ?? byId('save-cue'));
});

// --- marks ------------------------------------------------------------------------------------------------------------

// Writes a line with what is shown into the node's file.
export const mark = () => post('mark', {}, byId('mark'), 'Mark');

function download(text) {
  const address = URL.createObjectURL(new Blob([text], { type: 'text/csv' }));
  make('a', { href: address, download: `${state?.config.replace(/\.rviz$/, '') ?? 'camera_stream'}.marks.csv` }).click();
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}

byId('mark').addEventListener('click', mark);
byId('marks').addEventListener('click', () => post('marks', {}, byId('marks'), 'Download', undefined, download));
