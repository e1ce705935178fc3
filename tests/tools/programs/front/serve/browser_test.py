# SPDX-License-Identifier: Apache-2.0
"""The desk in a headless Chromium: from a photograph to a certificate, by mouse and by keyboard
alone, on a desktop and on a telephone, and as axe-core wants it."""
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import desk

desk.require_server()
if not desk.Browser.find():
    desk.skip('neither chromium-headless-shell nor chromium is installed: no page is opened')
SHOTS = os.environ.get('DRAPE_SHOTS')  # a folder for pictures of the page
DONE = "document.querySelectorAll('#list li span').length == {0} && " \
    "[...document.querySelectorAll('#list li span')].every((each) => each.textContent.includes('%'))"


def install_axe():
    """The script of axe-core, or None where npm cannot install it."""
    done = subprocess.run([desk.ROOT / 'tests/tools/programs/results/report/install_npm.sh'],
                          capture_output=True, text=True, check=False)
    script = pathlib.Path(done.stdout.strip()) / 'axe-core/axe.min.js'
    return script.read_text() if done.returncode == 0 and script.exists() else None


class DeskInABrowser(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.path = pathlib.Path(cls.scratch.name)
        cls.coefficient = desk.paint(cls.path / 'wool.jpg', 800)
        cls.folder = cls.path / 'more'
        cls.folder.mkdir()
        desk.paint(cls.folder / 'shirt.jpg', 800, fabric='synthetic_shirt', seed=4)
        (cls.folder / 'samples.csv').write_text('file;fabric;specimen;face;mass;warp\n'
                                              'shirt.jpg;"fine shirt";2;down;120;up\n')
        config = cls.path / 'fit.json'
        config.write_text(json.dumps(desk.SMALL_FIT))
        cls.axe = install_axe()
        cls.desk = desk.Desk(cls.path / 'desk', f'--fit_config={config}')
        cls.browser = desk.Browser()

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()
        cls.desk.stop()
        cls.scratch.cleanup()
        if not cls.axe:
            desk.skip('npm cannot install axe-core: contrast and labels are not checked')

    def text(self, selector):
        return self.browser.evaluate(f"document.querySelector({selector!r})?.textContent ?? ''")

    def focus(self, selector, most=80):
        """Presses Tab until an element has the focus, as a user without a mouse does."""
        for _ in range(most):
            self.browser.key('Tab')
            if self.browser.evaluate(f"document.activeElement.matches({selector!r})"):
                return
        self.fail(f'Tab does not reach {selector}')

    def check_report(self, name):
        """The same of a page of results on its own, with all its parts unfolded and as printed."""
        address = self.browser.evaluate('document.querySelector(".card a").href')
        self.browser.open(address)
        self.browser.evaluate('for (const each of document.querySelectorAll("details")) each.open = true')
        self.check_page(name, [(width, dark, media) for dark in (False, True) for width, media in (
            (1280, ''), (390, ''), (794, 'print'))])
        self.browser.open(self.desk.address)

    def check_page(self, name, views=((1280, True, ''), (390, False, ''))):
        """Nothing is cut off, and axe-core finds no fault, dark and light, wide and narrow."""
        for width, dark, media in views:
            self.browser.size(width, 1000, dark, media)
            self.browser.evaluate('new Promise((drawn) => requestAnimationFrame(() => '
                                  'requestAnimationFrame(() => drawn(0))))')
            if SHOTS:
                kind = media or ('dark' if dark else 'light')
                self.browser.screenshot(f'{SHOTS}/{name}_{width}_{kind}.png')
            self.assertLessEqual(self.browser.evaluate(
                'document.documentElement.scrollWidth - document.documentElement.clientWidth'), 0)
            if self.axe:
                if self.browser.evaluate('typeof axe') == 'undefined':
                    self.browser.evaluate(self.axe + ';0')
                self.assertEqual([], self.browser.evaluate('''
                    axe.run(document, {iframes: false, resultTypes: ["violations"], runOnly:
                      ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice"]}).then((found) =>
                      found.violations.flatMap((each) => each.nodes.map((node) =>
                        `${each.id}: ${node.target}`)))'''), f'{name} at {width}, dark: {dark}, {media}')
        self.browser.size(1280)

    def test_1_keyboard_from_photograph_to_certificate(self):
        browser = self.browser
        browser.open(self.desk.address)
        self.focus('#files')  # its dialogue is the system's
        browser.give_files('#files', [self.path / 'wool.jpg'])
        browser.until(DONE.format(1))
        self.assertIn('Drape coefficient', self.text('#result'))
        for name, value in (('fabric', 'wool'), ('mass', '270'), ('specimen', '1')):
            self.focus(f'[name={name}]')
            browser.write(value)
        self.focus('[name=face]')
        browser.key('ArrowDown')  # up
        self.focus('[name=customer]')
        browser.write('Mill & <Sons>')
        self.focus('#also')
        browser.until('document.querySelector("#list button").textContent.includes("face up")')
        # The warp by arrow keys, and a point of the ground at the cross.
        browser.evaluate('document.querySelector("#picture svg").focus(); 0')
        for _ in range(30):
            browser.key('ArrowDown')
        browser.evaluate('document.querySelector("[value=ground_points]").click(); 0')
        browser.key('Enter')
        browser.until('document.querySelectorAll("#picture .ground_points").length == 1')
        self.focus('#picture [aria-label=warp]')
        browser.key('ArrowRight')
        browser.until('document.querySelector("#command").textContent.includes("--warp=91")')
        browser.until('document.querySelector("#command").textContent.includes("--ground_points=")')
        browser.until(DONE.format(1))
        self.assertAlmostEqual(float(self.text('#result').split()[2]), self.coefficient, delta=1.0)
        browser.evaluate('document.querySelector("#list button").focus(); 0')
        self.focus('#fit')
        self.assertEqual(self.text('#fit'), 'Fit 1 photograph')
        browser.key('Enter')
        browser.until('document.querySelector(".card progress:not([hidden])")')
        self.assertIn('/samples.csv', self.text('#command'))
        browser.until('document.querySelector(".card svg[role=img] path.fitted")')
        browser.until('document.querySelector(".card iframe")')
        self.assertFalse(browser.evaluate('document.querySelector(".card figure")'))
        self.focus('.card a')
        page = self.desk.ask('GET', browser.evaluate(
            'document.querySelector(".card a").getAttribute("href")'))[2].decode()
        for part in ('<h3>Drape of wool</h3>', 'Mill &amp; &lt;Sons&gt;', 'face up', '5 cm'):
            self.assertTrue(part in page, part)
        self.check_page('fit')
        self.check_report('certificate')

    def test_2_mouse_and_two_fabrics(self):
        browser = self.browser
        browser.open(self.desk.address)
        browser.until(DONE.format(1))
        browser.give_files('#folder', [self.folder])
        browser.until(DONE.format(2))
        browser.until('document.querySelector("#picture [aria-label=specimen] circle")')
        self.assertIn('warp 90°', self.text('#picture'))
        # The specimen's handle is dragged, and back.
        before = self.text('#result')
        for wider, words in ((1.2, '--specimen=0.36'), (1 / 1.2, '--specimen=0.3')):
            x, y, cx = browser.evaluate('''(() => {
                const box = (node) => node.getBoundingClientRect();
                const dot = box(document.querySelector("#picture [aria-label=specimen] circle"));
                const ring = box(document.querySelector("#picture circle.ring"));
                scrollBy(0, dot.top - 300);
                return [dot.x + dot.width / 2, 300 + dot.height / 2, ring.x + ring.width / 2];
            })()''')
            browser.mouse('mousePressed', x, y)
            browser.mouse('mouseMoved', cx + (x - cx) * wider, y)
            browser.mouse('mouseReleased', cx + (x - cx) * wider, y)
            browser.until(f'document.querySelector("#command").textContent.includes("{words}")')
            browser.until('!document.querySelector("#result").textContent.includes("The measurement")')
            if wider > 1:
                browser.until('/^Not measured: wrong size/.test('
                              'document.querySelector("#result").textContent)')
        browser.until(DONE.format(2))
        self.assertEqual(self.text('#result')[:24], before[:24])
        # A fabric with a slash is refused in one line; the earlier one stays.
        self.assertTrue('fine shirt, specimen 2, face down' in self.text('#list'))
        browser.evaluate("""(() => {
            const input = document.querySelector("[name=fabric]");
            input.value = "../x";
            input.dispatchEvent(new Event("change", {bubbles: true}));
        })()""")
        browser.until('document.querySelector("#status.bad")?.textContent.includes("\'fabric\'")')
        browser.evaluate('document.querySelector("[name=fabric]").value = "shirt"; 0')
        browser.evaluate('document.querySelector("[name=fabric]").dispatchEvent('
                         'new Event("change", {bubbles: true})); 0')
        browser.until('document.querySelector("#list").textContent.includes(": shirt, specimen 2")')
        browser.evaluate('document.querySelectorAll("#list [type=checkbox]:not(:checked)")'
                         '.forEach((tick) => tick.click()); 0')
        browser.until('document.querySelector("#fit").textContent.startsWith("Compare")')
        browser.evaluate('document.querySelector("#fit").click(); 0')
        browser.until('document.querySelectorAll(".card").length == 2')
        other = json.loads(self.desk.ask('GET', 'state?since=0')[2])  # another browser
        self.assertEqual(len(other['items']), 4)
        # The page would take processors from the fits.
        browser.open('about:blank')
        self.desk.wait(max(self.desk.items()), 'done')
        browser.open(self.desk.address)
        browser.until('document.querySelector(".card iframe") && '
                      'document.querySelectorAll(".card iframe").length == 2')
        card = browser.evaluate('document.querySelector(".card a").getAttribute("href")')
        self.assertTrue(b'>Comparison<' in self.desk.ask('GET', card)[2])
        self.check_page('two')
        self.check_report('comparison')
        browser.until('document.querySelectorAll(".card").length == 2')
        # The comparison and its photographs go by the keyboard, at the second press alone.
        browser.evaluate('document.querySelector("#h_jobs").focus(); 0')
        gone = '#jobs .card:first-child .tools button:last-child'
        self.focus(gone)
        browser.key('Enter')
        self.assertIn('for good', self.text(gone))
        browser.key('Tab')
        self.assertEqual(self.text(gone), 'Remove')
        self.focus(gone)
        browser.key('Enter')
        browser.key('Enter')
        browser.until('document.querySelectorAll(".card").length == 1')
        self.focus('#tick')
        browser.key('Enter')
        self.focus('#remove')
        browser.key('Space')
        self.assertEqual(self.text('#remove'), 'Delete 2 photographs for good')
        browser.key('Space')
        browser.until('document.querySelectorAll("#list li").length == 0')
        self.assertEqual(browser.evaluate('document.activeElement.id'), 'h_photographs')
        self.assertTrue(browser.evaluate('document.querySelector("#editor").hidden'))
        self.assertEqual(len(self.desk.items()), 1)
        texts = [json.dumps(each) for each in browser.log]
        self.assertEqual([], [text for text in texts if 'WebGL' not in text and ' 400 ' not in text])


if __name__ == '__main__':
    unittest.main()
