"""The page in a headless Chromium, found by what an operator reads: words, labels, names of displays."""

import contextlib
import shutil

from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from golden.scenes.processes import wait_until

# A guard against hangs, not a figure.
PATIENCE_SECS = 120.0
DESKTOP, PHONE = (1280, 900), (390, 844)
PRESSABLE = 'button, input, select, summary'


class Page:
    """An open page, of a browser of its own, which remembers no token."""

    def __init__(self, address, size=DESKTOP):
        options = webdriver.ChromeOptions()
        # Root has no sandbox, a container a small /dev/shm.
        for argument in ('--headless=new', '--no-sandbox', '--disable-dev-shm-usage', '--hide-scrollbars'):
            options.add_argument(argument)
        width, height = size
        if size == PHONE:
            metrics = {'width': width, 'height': height, 'pixelRatio': 1}
            options.add_experimental_option('mobileEmulation', {'deviceMetrics': metrics})
        options.set_capability('goog:loggingPrefs', {'browser': 'ALL'})
        self.driver = webdriver.Chrome(service=Service(shutil.which('chromedriver')), options=options)
        # The size of the page, not of the window around it.
        self.driver.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', {
            'width': width, 'height': height, 'deviceScaleFactor': 1, 'mobile': size == PHONE})
        self.driver.get(address)

    def text(self, selector):
        """The text of an element; empty where it is not shown."""
        return self.run(f'return document.querySelector({selector!r})?.innerText ?? ""').strip()

    def light(self):
        """The word for what the projectors show."""
        return self.text('#light-word')

    def run(self, script, *arguments):
        """Runs JavaScript in the page."""
        return self.driver.execute_script(script, *arguments)

    def element(self, selector):
        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def elements(self, selector):
        return self.driver.find_elements(By.CSS_SELECTOR, selector)

    def press(self, name):
        """Presses the button or switch that a screen reader calls so, as soon as it can be pressed."""
        # The browser is asked for the names of those alone that have the words.
        with_words = """
            const words = (node) => [node.textContent, node.ariaLabel, ...[...node.labels ?? []].map((each) => each.textContent)];
            return [...document.querySelectorAll(arguments[0])]
                .filter((node) => node.checkVisibility() && !node.matches(":disabled") && words(node).join(" ").includes(arguments[1]))"""

        def find():
            return [each for each in self.run(with_words, PRESSABLE, name) if each.accessible_name == name]
        found = wait_until(find, PATIENCE_SECS, f'nothing that can be pressed is called {name!r}')
        # On the phone, the middle of the screen is never below what is fixed at its ends.
        self.run('arguments[0].scrollIntoView({ block: "center" })', found[0])
        found[0].click()

    def is_on(self, name):
        """Whether the switch that a screen reader calls so is on."""
        def find():
            return [each for each in self.elements('[role="switch"]') if each.accessible_name == name]
        return wait_until(find, PATIENCE_SECS, f'no switch is called {name!r}')[0].is_selected()

    def set_field(self, selector, value, event='input'):
        """Sets a field as dragging a slider or choosing from a list does."""
        self.run('arguments[0].value = arguments[1]; arguments[0].dispatchEvent(new Event(arguments[2]))',
                 self.element(selector), value, event)

    def covered(self):
        """What has the focus below something fixed or outside of the window, one after the other, as HTML."""
        script = """
            const edge = (selector, side) => document.querySelector(selector).getBoundingClientRect()[side];
            const [top, bottom] = [edge('#light', 'bottom'), edge('#black', 'top')];
            const found = [...document.querySelectorAll('main button, main input, main select, main summary')];
            return found.filter((node) => node.checkVisibility() && !node.matches(':disabled')).filter((node) => {
                node.focus();
                const place = node.getBoundingClientRect();
                return place.top < top || place.bottom > bottom;
            }).map((node) => node.outerHTML);"""
        return self.run(script)

    def type_key(self, key, selector='body'):
        self.element(selector).send_keys(key)

    @staticmethod
    def retype(field, text):
        """Types over what a field has. In one that is empty for a moment, the page shows the node's value again."""
        field.send_keys(Keys.CONTROL, 'a', Keys.NULL, text)

    @contextlib.contextmanager
    def holding_enter(self):
        """Holds Enter down; what it gives is called for each repetition by the system."""
        def send(kind, **how):
            event = dict({'type': kind, 'key': 'Enter', 'code': 'Enter', 'windowsVirtualKeyCode': 13}, **how)
            self.driver.execute_cdp_cmd('Input.dispatchKeyEvent', event)
        send('keyDown', text='\r')
        yield lambda: send('keyDown', text='\r', autoRepeat=True)
        send('keyUp')

    def open_details(self):
        """Opens everything that can be unfolded."""
        self.run('document.querySelectorAll("details").forEach((each) => { each.open = true; })')

    def row(self, display):
        """The text of a display's row."""
        script = '''return [...document.querySelectorAll("#displays-rows tr")]
            .find((row) => row.querySelector("th span").textContent === arguments[0])?.innerText ?? ""'''
        return self.run(script, display)

    def unnamed(self):
        """What can be pressed or filled in without a name for a screen reader, as HTML."""
        return [each.get_attribute('outerHTML') for each in self.elements(PRESSABLE)
                if each.is_displayed() and not each.accessible_name]

    def number(self):
        """How often the node was blacked out and released, as the page knows; none before it does."""
        return self.driver.execute_async_script('import("/node.js").then((node) => arguments[0](node.state?.number ?? null))')

    def wait_for_answer(self):
        wait_until(lambda: not self.elements('[aria-busy]'), PATIENCE_SECS, 'the node does not answer')

    def focused(self):
        """The id of the element that has the focus."""
        return self.run('return document.activeElement.id')

    def tab(self):
        webdriver.ActionChains(self.driver).send_keys(Keys.TAB).perform()

    def reload(self):
        """Opens the page anew, as for a first visit but for the token."""
        self.run('localStorage.removeItem("shortcuts")')
        self.driver.refresh()

    def errors(self):
        """Lines of the browser's console since the last call."""
        return [f'{entry["level"]}: {entry["message"]}' for entry in self.driver.get_log('browser')]

    def save(self, file):
        self.run('scrollTo(0, 0)')
        self.driver.save_screenshot(str(file))

    def close(self):
        self.driver.quit()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
