"""Everything that an operator can do on the page, and what comes of it."""

import os
import shutil
import tempfile
import time
import unittest

import numpy

from .browser import PHONE, Page
from .stage import OPTICAL_FRAME, ROOT, TEST_NODE, LiveScene, moved, pose_of_frame, turned

# Below this, a difference is rounding: of numbers in a file, of quaternions.
SAME_M = 1e-6
# Time in which nothing may happen.
QUIET_SECS = 1.0
CLUSTERS = 'Show clusters in CameraPub'
REVERT = '.nudge .buttons button:last-child'
BLACK_PICTURES = ROOT / 'test_output/operator_page'
WRITES_DOCS = bool(os.environ.get('RCS_WRITE_DOCS'))
PICTURES = ROOT / ('docs/images' if WRITES_DOCS else 'test_output/operator_page')


class OperatorPage(unittest.TestCase):
    """One node, one page on a laptop; each test begins with both as they are at the start."""
    scene: LiveScene
    page: Page

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix='operator_page_')
        cls.addClassCleanup(folder.cleanup)
        cls.scene = LiveScene(folder.name)
        cls.addClassCleanup(cls.scene.end)
        cls.page = Page(cls.scene.address)
        cls.addClassCleanup(cls.page.close)

    def setUp(self):
        # Parts of the lines that the browser itself reports of what fails.
        self.expected_errors = set()
        self.page.reload()
        self.wait(lambda: self.page.number() is not None, 'the page knows no state')
        self.reset()
        self.wait_for_light('Lit')
        self.wait(self.scene.images.is_lit, 'no image is lit')

    def reset(self):
        """Undoes what a test that failed may have left."""
        if self.scene.setting('fade_seconds') != 0:
            self.set_fade(0)
        if self.scene.setting('brightness') != 1:
            self.set_brightness(100)
        if not self.page.is_on(CLUSTERS):
            self.switch_clusters(True)
        if self.page.text('#pause') == 'Resume':
            self.resume()
        if self.page.element('#release').is_enabled():
            self.grant(lambda: self.page.press('Release'))
            self.wait(lambda: not self.page.element('#release').is_enabled(), 'nothing is released')
        if self.page.element('#test-picture').get_attribute('value'):
            self.choose_picture('')
        if self.page.element(REVERT).is_enabled():
            self.page.open_details()
            self.page.press('Revert')
            self.wait(lambda: not self.page.element(REVERT).is_enabled(), 'the nudge stays')

    def tearDown(self):
        self.check_errors(self.page)

    def check_errors(self, page):
        self.assertEqual([], [line for line in page.errors() if not any(part in line for part in self.expected_errors)])

    def expect_errors(self, *parts):
        """The browser may report lines with one of these parts until the test ends."""
        self.expected_errors.update(parts)

    def wait(self, condition, what):
        return self.scene.wait_for(condition, what)

    def wait_for_light(self, word, page=None):
        page = page or self.page
        self.wait(lambda: page.light() == word, f'the page does not say {word}, but {page.light()}')

    def wait_for_answer(self):
        self.page.wait_for_answer()
        self.assertEqual('', self.page.text('#failure'))

    # --- what may light: a press that answers the state of before, or arrives late, is void, and is repeated ---

    def grant(self, press, page=None):
        """Presses until the node has granted it."""
        page = page or self.page

        def is_granted():
            press()
            page.wait_for_answer()
            is_void = page.text('#failure') != ''
            if is_void:
                self.expect_errors('409')
            return not is_void
        self.wait(is_granted, 'it is not granted')

    def release(self, name='Release', page=None):
        page = page or self.page
        self.grant(lambda: page.press(name), page)
        self.wait(self.scene.images.is_lit, 'the image stays black')
        self.wait_for_light('Lit', page)

    def resume(self):
        self.grant(lambda: self.page.press('Resume'))
        self.wait(lambda: self.page.text('#pause') == 'Pause', 'it stays paused')

    def choose_picture(self, name):
        """Chooses a test picture; '' is the scene."""
        self.grant(lambda: self.page.set_field('#test-picture', name, 'change'))
        shown = ('Test picture', name) if name else ('Lit', '')
        self.wait(lambda: (self.page.light(), self.page.text('#light-why')) == shown, f'{name or "the scene"} is not shown')

    def black(self):
        """Presses Black, and waits until both roads have brought it: a release between the two is void."""
        before = self.page.number()
        self.page.press('Black')
        self.wait(lambda: self.page.number() >= before + 2, 'one of the two roads brings nothing')
        self.wait_for_light('Black')
        self.wait(self.scene.images.is_black, 'the image is not black')

    # --- what the projector shows ---

    def test_black_and_its_release(self):
        self.assertFalse(self.page.element('#release').is_enabled(), 'there is nothing to release')
        self.black()
        self.assertIn('the page at 127.0.0.1', self.page.text('#light-why'))
        self.black()
        self.assertEqual('Black', self.page.light(), 'Black is no toggle')
        self.release()

    def focus(self, selector):
        self.page.run('document.querySelector(arguments[0]).focus()', selector)

    def test_enter_held_on_black_stays_black(self):
        self.focus('#black')
        with self.page.holding_enter() as repeat:
            self.wait_for_light('Black')
            for _ in range(100):
                repeat()
                self.assertEqual('Black', self.page.light())
        self.assertTrue(self.scene.images.is_black())
        self.release()

    def test_enter_held_on_release_releases_once(self):
        self.black()
        self.focus('#release')
        with self.page.holding_enter() as repeat:
            self.wait_for_light('Lit')
            before = self.page.number()
            self.page.run('document.querySelector("#black").click()')
            self.wait(lambda: self.page.number() >= before + 2, 'one of the two roads brings nothing')
            self.focus('#release')
            for _ in range(100):
                repeat()
                self.assertEqual('Black', self.page.light())
        self.release()

    def test_enter_held_on_pause_pauses_once(self):
        self.focus('#pause')
        with self.page.holding_enter() as repeat:
            self.wait_for_light('Paused')
            for _ in range(100):
                repeat()
                self.assertEqual('Paused', self.page.light())
        self.resume()

    def test_a_release_that_is_late_is_void(self):
        self.expect_errors('409')
        self.black()
        self.page.run('window.own = fetch; window.fetch = async (...all) => { await new Promise((go) => setTimeout(go, 2500)); '
                      'return own(...all); };')
        self.page.press('Release')
        failed = 'Release failed: it is older than 2 s'
        self.wait(lambda: self.page.text('#failure').startswith(failed), 'the page does not say that the release failed')
        self.wait(lambda: self.page.text('#failure') == '', 'the page does not forget it')
        self.assertTrue(self.scene.images.is_black(), 'it has lit the projector')
        self.page.run('window.fetch = own')
        self.release()

    def test_black_arrives_by_the_socket_alone(self):
        self.page.run('window.own = fetch; window.fetch = () => Promise.reject(new TypeError())')
        self.page.press('Black')
        self.wait(self.scene.images.is_black, 'the image is not black')
        self.wait_for_light('Black')
        self.wait(lambda: self.page.text('#failure') == '', 'the page says that it failed')
        self.page.press('Release')
        self.wait(lambda: self.page.text('#failure').startswith('Release failed: the node'), 'there is no failure')
        self.page.run('window.fetch = own')
        self.release()

    def test_a_camera_has_a_release_of_its_own(self):
        self.page.run('import("/node.js").then((node) => node.black(document.querySelector("#black"), "CameraPub"))')
        self.wait(self.scene.images.is_black, 'the image is not black')
        self.release('Release CameraPub')
        shown = [each.accessible_name for each in self.page.elements('.camera header button') if each.is_displayed()]
        self.assertEqual(['Snapshot'], shown)
        self.page.open_details()
        self.assertNotIn('blackout', self.page.text('#settings'))

    def test_key_b_is_black_but_not_while_typing(self):
        self.page.open_details()
        self.page.type_key('b', '.parameter input[type="number"]')
        time.sleep(QUIET_SECS)
        self.assertEqual('Lit', self.page.light())
        self.page.type_key('b')
        self.page.type_key('b')
        self.wait(self.scene.images.is_black, 'the image is not black')
        time.sleep(QUIET_SECS)
        self.page.type_key('b')
        time.sleep(QUIET_SECS)
        self.assertEqual('Black', self.page.light(), 'key B is no toggle')
        self.page.type_key('l')
        time.sleep(QUIET_SECS)
        self.assertEqual('Black', self.page.light(), 'it needs Shift')
        self.grant(lambda: self.page.type_key('L'))
        self.wait(self.scene.images.is_lit, 'the image stays black')

    def test_all_pages_show_the_blackout_of_a_script(self):
        from std_srvs.srv import SetBool
        with Page(self.scene.address) as second:
            self.wait_for_light('Lit', second)
            self.assertTrue(self.scene.call('/camera_stream/blackout', SetBool, True).success)
            for page in (self.page, second):
                self.wait_for_light('Black', page)
                self.assertIn(TEST_NODE, page.text('#light-why'))
            self.release(page=second)
            self.wait_for_light('Lit')
            self.check_errors(second)

    def test_pause_keeps_the_image(self):
        self.page.press('Pause')
        self.wait_for_light('Paused')
        before = self.scene.images.newest
        self.switch_clusters(False)
        time.sleep(QUIET_SECS)
        self.assertTrue(numpy.array_equal(before, self.scene.images.newest), 'the image changed while paused')
        self.resume()
        self.wait(lambda: not numpy.array_equal(before, self.scene.images.newest), 'the image stays after the pause')
        self.switch_clusters(True)

    def test_a_test_picture_is_chosen_and_the_scene_again(self):
        scene = self.scene.images.newest
        names = self.page.run('return [...document.querySelectorAll("#test-picture option")].map((each) => each.value)')
        self.assertGreater(len(names), 4)
        for name in names[1:]:
            self.choose_picture(name)
            self.wait(lambda: not numpy.array_equal(scene, self.scene.images.newest), 'the image stays')
        self.choose_picture('')

    # --- brightness, cues, what is kept ---

    def brightest(self):
        return int(self.scene.images.newest.max())

    def set_brightness(self, percent):
        self.page.set_field('#brightness', percent)
        self.wait(lambda: self.scene.setting('brightness') == percent / 100, f'the brightness is not {percent} %')

    def set_fade(self, secs):
        self.page.retype(self.page.element('#fade'), f'{secs}\n')
        self.wait(lambda: self.scene.setting('fade_seconds') == secs, 'the fade is not set')

    def test_the_brightness_fades(self):
        full = self.brightest()
        self.set_brightness(50)
        self.wait(lambda: self.brightest() <= full / 2 + 1, 'the image is not darker')
        self.wait(lambda: 'brightness 50 %' in self.page.text('#light-why'), 'the page does not say so')
        self.set_fade(2)
        self.set_brightness(0)
        self.wait_for_light('Dark')
        self.wait(self.scene.images.is_black, 'the image is not black')
        self.set_brightness(100)
        self.wait(lambda: self.brightest() == full, 'the image stays dark')
        self.set_fade(0)

    def save_cue(self, name):
        self.page.retype(self.page.element('#cue-name'), f'{name}\n')
        self.wait_for_cue(name)

    def wait_for_cue(self, name):
        shown = 'return document.querySelector("#cues [data-on]")?.firstChild.textContent ?? ""'
        self.wait(lambda: self.page.run(shown) == name, f'{name!r} is not the cue')
        self.wait(lambda: self.scene.cues.names[-1:] == [name], f'{name!r} is not on the topic')

    def test_cues_by_buttons_keys_and_a_script(self):
        file = self.scene.config.with_suffix('.cues.yaml')
        self.addCleanup(file.unlink, missing_ok=True)
        self.expect_errors('409')
        self.page.open_details()
        self.save_cue('Everything')
        self.switch_clusters(False)
        self.wait_for_cue('')
        self.set_brightness(40)
        self.save_cue('Dim')
        self.page.press('Everything')
        self.wait_for_cue('Everything')
        self.wait(lambda: self.page.is_on(CLUSTERS) and self.scene.setting('brightness') == 1, 'the cue is not as it was saved')
        self.page.type_key('2', '#cue-name')
        self.page.type_key(' ', '#cue-name')
        time.sleep(QUIET_SECS)
        self.assertEqual('Everything', self.scene.cues.names[-1], 'a key in a field is no shortcut')
        self.page.element('#cue-name').clear()
        self.page.type_key('2')
        self.wait_for_cue('Dim')
        self.assertEqual(0.4, self.scene.setting('brightness'))
        self.page.type_key(' ')
        self.wait_for_cue('Everything')
        self.scene.cues.ask('Dim')
        self.wait_for_cue('Dim')
        self.page.press('Everything')
        self.wait_for_cue('Everything')
        whole = file.read_text()
        file.write_text(whole.replace('clusters', 'nobody'))
        self.page.press('Everything')
        self.wait(lambda: "no display 'nobody'" in self.page.text('#failure'), 'the unknown display is no error')
        file.write_text('{' + whole)
        self.wait(lambda: 'cues.yaml' in self.page.text('#cues-problem'), 'the damage is not shown')
        file.write_text(whole)
        self.wait(lambda: self.page.text('#cues-problem') == '', 'the damage is still shown')
        for name in ('Everything', 'Dim'):
            self.page.press(f'Remove {name}')
        self.wait(lambda: self.page.text('#cues') == '', 'the cues are not removed')

    def test_shortcuts_can_be_switched_off(self):
        self.page.press('Keyboard shortcuts')
        self.page.type_key('b')
        time.sleep(QUIET_SECS)
        self.assertEqual('Lit', self.page.light())
        self.page.driver.refresh()
        self.wait_for_light('Lit')
        self.assertFalse(self.page.is_on('Keyboard shortcuts'), 'it is forgotten')
        self.page.press('Keyboard shortcuts')
        self.page.type_key('b')
        self.wait_for_light('Black')
        self.release()

    def test_marks_are_a_file_and_a_download(self):
        file = self.scene.config.with_suffix('.marks.csv')
        self.addCleanup(file.unlink, missing_ok=True)
        self.page.press('Mark')
        self.wait(lambda: file.exists() and len(file.read_text().splitlines()) == 2, 'no line is written')
        self.page.type_key('m')
        self.wait(lambda: len(file.read_text().splitlines()) == 3, 'the key writes no line')
        self.page.run('const own = URL.createObjectURL; URL.createObjectURL = (blob) => {'
                      'blob.text().then((text) => { window.saved = text; }); return own(blob); };')
        self.page.press('Download marks')
        self.assertEqual(file.read_text(), self.wait(lambda: self.page.run('return window.saved'), 'nothing is downloaded'))
        self.assertIn(',1.000,CameraPub: ', file.read_text())

    def test_a_snapshot_is_the_image(self):
        from PIL import Image
        folder = self.scene.config.with_suffix('.snapshots')
        self.page.press('Snapshot')
        [file] = self.wait(lambda: folder.exists() and list(folder.glob('CameraPub-*.png')), 'no image is saved')
        self.assertEqual(self.scene.images.newest.shape, numpy.asarray(Image.open(file)).shape)

    def test_a_folder_that_cannot_be_written_is_an_error(self):
        self.expect_errors('409')
        folder, marks = self.scene.config.with_suffix('.snapshots'), self.scene.config.with_suffix('.marks.csv')
        shutil.rmtree(folder, ignore_errors=True)
        folder.write_text('')
        self.addCleanup(folder.unlink)
        marks.mkdir()
        self.addCleanup(marks.rmdir)
        for button in ('Mark', 'Snapshot'):
            self.page.press(button)
            self.wait(lambda: 'cannot write' in self.page.text('#failure'), f'{button}: the failure is not shown')

    def test_the_first_image_takes_its_caption_away(self):
        caption = '''const screen = document.querySelector(".screen");
            return screen && screen.querySelector("canvas").width > 16 ? [screen.querySelector(".caption").textContent] : null;'''
        self.page.reload()
        self.assertEqual([''], self.wait(lambda: self.page.run(caption), 'there is no image'))

    def test_the_image_is_live_and_masks_are_hatched(self):
        self.wait(lambda: self.page.text('.masked') == 'hatched: no light', 'the mask is not shown')
        hatched = '''const canvas = document.querySelectorAll(".screen canvas")[1];
            const at = (x, y) => canvas.getContext("2d").getImageData(x * canvas.width, y * canvas.height, 1, 1).data[3] > 0;
            return [at(0.9, 0.05), at(0.5, 0.5)];'''
        self.assertEqual([True, False], self.page.run(hatched))
        self.wait(lambda: self.page.text('.caption') == '', 'there is no image')
        lit = '''const canvas = document.querySelector(".screen canvas");
            const copy = Object.assign(document.createElement("canvas"), { width: canvas.width, height: canvas.height });
            const context = copy.getContext("2d");
            context.drawImage(canvas, 0, 0);
            return context.getImageData(0, 0, copy.width, copy.height).data.some((value, at) => at % 4 < 3 && value > 64);'''
        self.assertTrue(self.wait(lambda: self.page.run(lit), 'the image on the page is black'))

    # --- displays and settings ---

    def switch_clusters(self, is_on):
        self.page.press(CLUSTERS)
        self.wait(lambda: self.page.is_on(CLUSTERS) == is_on, 'the display is not switched')

    def test_a_display_is_switched(self):
        before = self.scene.images.newest
        self.switch_clusters(False)
        self.assertFalse(self.scene.parameter('show_clusters'))
        self.wait(lambda: numpy.any(before != self.scene.images.newest), 'the image stays')
        self.switch_clusters(True)
        self.assertTrue(self.scene.parameter('show_clusters'))

    def test_displays_say_what_is_wrong_and_what_to_do(self):
        row = self.wait(lambda: self.page.row('markers'), 'there is no display of that name')
        self.assertIn('Warning: ', row)
        self.assertIn('What to do: start the publisher', row)
        self.wait(lambda: 'Hz' in self.page.row('clusters'), 'the rate is missing')
        self.assertNotIn('What to do', self.page.row('clusters'))
        self.assertTrue(self.page.row('clusters').rstrip().endswith('OK'), 'what is fine takes one line')

    def test_settings_are_those_of_dynamic_reconfigure(self):
        self.page.open_details()
        by_name = {each.accessible_name: each for each in self.page.elements('.parameter input')}
        before = self.scene.parameter('frame_rate')
        for name, value in (('Frame rate [Hz]', 12.5), ('frame_rate', before)):
            field = by_name[name]
            self.page.retype(field, f'{value}\n')
            self.wait(lambda: self.scene.parameter('frame_rate') == value, f'the parameter is not {value}')
            self.wait(lambda: float(field.get_attribute('value')) == value, f'the page does not show {value}')

    def test_the_log_has_what_was_done(self):
        self.page.press('Pause')
        self.wait_for_light('Paused')
        self.wait(lambda: 'the page at 127.0.0.1' in self.page.text('#log'), 'the log does not name the page')
        self.resume()

    # --- nudging ---

    def projector(self):
        self.wait(lambda: self.scene.transforms.projector() is not None, 'the projector has no pose')
        return self.scene.transforms.projector().copy()

    def press_nudge(self, name, expected, what):
        self.page.press(name)
        self.wait(lambda: numpy.allclose(self.scene.transforms.projector(), expected, atol=SAME_M), what)
        self.wait_for_answer()
        self.wait(lambda: self.page.element(REVERT).is_enabled() == (name != 'Revert'), 'the page does not show it')

    def test_a_nudge_is_in_tf_and_reverted(self):
        before = self.projector()
        self.page.open_details()
        self.press_nudge('Right', before @ moved(x=-0.001), 'the frame is not 1 mm to the left')
        self.page.press('10 mm')
        self.press_nudge('Down', before @ moved(x=-0.001, y=-0.01), 'the frame is not 10 mm up')
        self.wait(lambda: '10.0 mm' in self.page.text('.sum'), 'the sum is not shown')
        self.press_nudge('Revert', before, 'not reverted')

    def test_each_button_of_the_pad_moves_the_light_its_way(self):
        before = self.projector()
        tenth = numpy.radians(0.1)
        # The light goes the other way than the frame.
        moves = {'Left': moved(x=0.001), 'Right': moved(x=-0.001), 'Up': moved(y=0.001), 'Down': moved(y=-0.001),
                 'Larger': moved(z=0.001), 'Smaller': moved(z=-0.001),
                 'Tilt up': turned('x', -tenth), 'Tilt down': turned('x', tenth),
                 'Turn right': turned('y', -tenth), 'Turn left': turned('y', tenth),
                 'Roll right': turned('z', -tenth), 'Roll left': turned('z', tenth)}
        self.page.open_details()
        for name, move in moves.items():
            with self.subTest(name):
                self.press_nudge(name, before @ move, f'{name} does something else')
                self.press_nudge('Revert', before, 'not reverted')

    def test_a_nudge_is_saved(self):
        import yaml
        before, text = self.projector(), self.scene.projector_file.read_text()
        self.page.open_details()
        self.press_nudge('Right', before @ moved(x=-0.001), 'the frame is not 1 mm to the left')
        self.press_nudge('Roll left', before @ moved(x=-0.001) @ turned('z', numpy.radians(0.1)), 'not turned')
        self.page.press('Save to the file')
        self.wait(lambda: '0.0 mm' in self.page.text('.sum') and '1.0 mm' not in self.page.text('.sum'), 'the values are not 0')
        saved = self.scene.projector_file.read_text()
        frames = {frame['child']: pose_of_frame(frame) for frame in yaml.safe_load(saved)['frames']}
        published = self.scene.transforms.projector()
        self.assertTrue(numpy.allclose(frames['proj_link'] @ frames[OPTICAL_FRAME], published, atol=SAME_M))
        self.assertFalse(numpy.allclose(before, published, atol=SAME_M))
        comments = [line for line in text.splitlines() if line.lstrip().startswith('#')]
        self.assertEqual(comments, [line for line in saved.splitlines() if line.lstrip().startswith('#')])

    # --- access and connection ---

    def test_a_wrong_token_is_refused(self):
        address, token = self.scene.address.split('#token=')
        with Page(address + '#token=wrong') as page:
            self.wait_for_light('No access', page)
            self.assertEqual('', page.text('#cameras'))
            page.press('Black')
            page.type_key(token + '\n', '#token')
            self.wait_for_light('Lit', page)
            self.assertNotIn('token', page.driver.current_url)
        self.assertTrue(self.scene.images.is_lit())

    def test_the_page_comes_back_after_the_node(self):
        self.expect_errors('ERR_CONNECTION', 'WebSocket connection')
        self.scene.end_camera_stream()
        self.wait_for_light('Connection lost')
        self.page.press('Black')
        failed = 'Black failed: the node cannot be reached'
        self.wait(lambda: self.page.text('#failure').startswith(failed), 'the failure is not shown')
        self.scene.start_camera_stream()
        self.wait_for_light('Lit')
        self.wait(lambda: self.page.text('#failure') == '', 'the failure is not forgotten')
        self.wait(lambda: self.page.text('.masked'), 'there are no images')

    # --- who uses it, and on what ---

    def test_keyboard_and_screen_reader(self):
        self.page.tab()
        self.assertEqual('black', self.page.focused())
        self.page.open_details()
        self.assertEqual([], self.page.unnamed())

    def test_screenshots_on_laptop_and_phone(self):
        for folder in (PICTURES, BLACK_PICTURES):
            folder.mkdir(parents=True, exist_ok=True)
        cues = self.scene.config.with_suffix('.cues.yaml')
        rest = 'brightness: 1.0, cameras: {CameraPub: [clusters, desired object, nav path, markers]}'
        lines = [f'- {{name: {name}, {rest}}}' for name in ('Baseline', 'Reach', 'Rest')]
        cues.write_text('\n'.join(['cues:', *lines]))
        self.addCleanup(cues.unlink)
        for name, size in (('desktop', None), ('phone', PHONE)):
            with Page(self.scene.address, *([size] if size else [])) as page:
                self.wait_for_light('Lit', page)
                self.wait(lambda: page.text('.masked') and page.text('#cues'), 'there are no images or no cues')
                if WRITES_DOCS:
                    # So that the plots have something to show.
                    time.sleep(5)
                self.assertFalse(page.run('return document.documentElement.scrollWidth > innerWidth'), 'wider than the screen')
                page.save(PICTURES / f'operator_page_{name}.png')
                page.open_details()
                self.assertEqual([], page.covered() if size else [])
                page.press('Black')
                self.wait_for_light('Black', page)
                self.assertFalse(page.run('return document.documentElement.scrollWidth > innerWidth'), 'wider than the screen')
                page.save(BLACK_PICTURES / f'black_{name}.png')
                self.release(page=page)
                self.check_errors(page)


if __name__ == '__main__':
    unittest.main()
