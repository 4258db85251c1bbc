// Elements of the page that several of its parts use, and how numbers are written. Texts of the node become text nodes, never
// markup.

export const byId = (id) => document.getElementById(id);

// An element with attributes, listeners (`onclick`) and children, which are elements or text.
export function make(tag, attributes = {}, ...children) {
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
export function setText(node, text) {
  if (node.textContent !== text) {
    node.textContent = text;
  }
}

export function setAttribute(node, name, value) {
  if (node.getAttribute(name) !== value) {
    node.setAttribute(name, value);
  }
}

// The children of an element, one view `{node, update(item, context)}` for each item. Views of known keys stay, and with them
// the focus.
export class Views {
  constructor(parent, keyOf, create) {
    Object.assign(this, { parent, keyOf, create, views: new Map() });
  }

  // `context` is what the views need beside their items.
  show(items, context) {
    const views = new Map();
    items.forEach((item, index) => {
      const key = this.keyOf(item, index);
      const view = this.views.get(key) ?? this.create(item);
      views.set(key, view);
      if (this.parent.children[index] !== view.node) {
        this.parent.insertBefore(view.node, this.parent.children[index] ?? null);
      }
      view.update(item, context);
    });
    while (this.parent.children.length > items.length) {
      this.parent.lastElementChild.remove();
    }
    this.views = views;
  }
}

let lastId = 0;
export const newId = () => `id-${++lastId}`;

// A switch that changes when the node's state does.
export function makeSwitch(attributes, onSwitch) {
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

export const LEVELS = { error: 'Error', warn: 'Warning', advice: 'What to do', ok: 'OK' };

// The lines of rviz's statuses: what is wrong, what to do about it, and then what is fine.
export function makeStatuses() {
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

const NONE = '–';

// A number with a unit, or a dash.
const withUnit = (value, unit, digits = 1) => (value === null || value === undefined ? NONE : `${value.toFixed(digits)} ${unit}`);

export const rate = (hz) => withUnit(hz, 'Hz');

// Milliseconds in the unit in which they are read at a glance.
export function duration(ms) {
  if (ms === null || ms === undefined || ms < 999.5) {
    return withUnit(ms, 'ms', ms < 9.95 ? 1 : 0);
  }
  return ms < 99_950 ? withUnit(ms / 1000, 's') : withUnit(ms / 60_000, 'min', 0);
}

// Without the digits that single precision adds.
export const plain = (number) => String(Number(number.toPrecision(7)));
