// Keyboard shortcuts, which can be switched off (WCAG 2.1.4).

import { byId } from './elements.js';

const KEPT = 'shortcuts';
const TYPING = 'input:not([type="checkbox"]):not([type="radio"]):not([type="range"]), textarea';
const PRESSED_BY_SPACE = 'button, input, select, textarea, summary, a[href]';

const box = byId('shortcuts');
const hints = [...document.querySelectorAll('[aria-keyshortcuts]')].map((node) => [node, node.getAttribute('aria-keyshortcuts')]);

function apply() {
  document.body.toggleAttribute('data-no-shortcuts', !box.checked);
  for (const [node, keys] of hints) {
    if (box.checked) {
      node.setAttribute('aria-keyshortcuts', keys);
    } else {
      node.removeAttribute('aria-keyshortcuts');
    }
  }
}

box.checked = localStorage.getItem(KEPT) !== 'off';
box.addEventListener('change', () => {
  localStorage.setItem(KEPT, box.checked ? 'on' : 'off');
  apply();
});
apply();

// Calls `press(key, event)` for each shortcut: with a letter or digit in lower case, or a space where that presses nothing else.
// It returns true for a key that it knows.
export function watchShortcuts(press) {
  document.addEventListener('keydown', (event) => {
    if (event.repeat) {
      // A button that has the focus would be pressed again and again.
      if (event.key === 'Enter') {
        event.preventDefault();
      }
      return;
    }
    const isOther = event.ctrlKey || event.altKey || event.metaKey || !box.checked || event.target.closest?.(TYPING);
    const isPressed = event.key === ' ' && event.target.closest?.(PRESSED_BY_SPACE);
    if (!isOther && !isPressed && press(event.key.toLowerCase(), event)) {
      event.preventDefault();
    }
  });
}
