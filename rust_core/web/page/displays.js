// The displays of the config: whether they are shown, how fresh they are, and how they fare.

import { Views, duration, make, makeStatuses, makeSwitch, rate, setAttribute, setText } from './elements.js';
import { setParameters } from './node.js';

// A display's row.
export function makeDisplay() {
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
      setParameters(shown.server, { [shown.name]: on }, source);
    });
    let shown;
    const update = ([, next]) => {
      shown = next;
      setText(label, shown.isOnly ? '' : camera);
      setAttribute(box, 'aria-label', `Show ${shown.display} in ${camera}`);
      set(shown.on);
    };
    return { node: make('label', { class: 'switch' }, box, label), update };
  });
  const node = make('tr', {}, cells.shown, make('th', { scope: 'row' }, name, kind), cells.topic, cells.rate, cells.age,
    make('td', {}, statuses.node));

  const update = (display, { cameras }) => {
    setText(name, display.path);
    setText(kind, display.class);
    setText(cells.topic, display.topic ?? '');
    setText(cells.rate, display.rate_hz === null ? '' : rate(display.rate_hz));
    setText(cells.age, display.age_ms === null ? '' : duration(display.age_ms));
    // What is fine takes one line.
    const isFine = display.level === 'ok';
    const texts = display.statuses.map((status) => `${status.name}: ${status.text}`);
    setAttribute(node, 'data-level', display.level);
    setAttribute(statuses.node, 'title', isFine ? texts.join('\n') : '');
    statuses.show(isFine ? [{ level: 'ok', name: '', text: 'OK' }] : display.statuses, display.advice);
    switches.show(cameras.filter(({ name }) => display.switches[name]).map(({ name, parameters }) => {
      const isOnly = cameras.length === 1;
      return [name, { ...display.switches[name], server: parameters, display: display.path, isOnly }];
    }));
  };
  return { node, update };
}

// How many displays there are, and how many have something wrong.
export function summaryOf(list) {
  const count = (level) => list.filter((display) => display.level === level).length;
  const wrong = [['error', 'errors'], ['warn', 'warnings']].filter(([level]) => count(level) > 0);
  return [`${list.length} in all`, ...wrong.map(([level, words]) => `${count(level)} with ${words}`)].join(', ');
}
