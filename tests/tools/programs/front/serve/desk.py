# SPDX-License-Identifier: Apache-2.0
"""What the tests of drape_serve share: a painted photograph, a desk that runs, and a browser."""
import base64
import http.client
import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import urllib.parse

ROOT = pathlib.Path(__file__).resolve().parents[5]
BIN = pathlib.Path(os.environ.get('DRAPE_BIN_DIR', ROOT / 'build/release/bin'))
sys.path.insert(0, str(ROOT / 'tests/bench/pictures'))


def skip(reason):
    print(f'{pathlib.Path(sys.argv[0]).name}: Skipped\n{reason}')
    sys.exit(77)


def require_server():
    if not (BIN / 'drape_serve').exists():
        skip('drape_serve is not built: it needs the packages of tools/setup/packages/photo.txt')


def paint(path, width=1200, fabric='synthetic_wool', seed=3):
    """A telephone's photograph of a simulated drape; returns its drape coefficient [%]."""
    import numpy as np
    import drapes
    import kinds
    import pictures
    import render
    import scenes
    rng = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder)
        drapes.run_simulation(BIN, out, fabric, 1.0, 0.30, rng)
        drape = drapes.read_drape(out / 'drape.obj', fabric, 0.30)
    camera = render.Camera.phone(width, width * 3 // 4, 26, (0.03, -0.02, 1.0),
                                 np.radians([3.0, -2.0]))
    scene = scenes.Scene(camera, scenes.plain_ground((0.85, 0.84, 0.8)), scenes.lit_cloth(
        scenes.plain_cloth((0.2, 0.25, 0.55))), scenes.opaque_disc((0.9, 0.9, 0.88)),
                         render.Light(1.5, 0.5, 0.9, 0.03), ground_z=-0.25, fine=2)
    light, share, _ = render.render(scene, drape, rng)
    pictures.save(kinds.Picture('', None, None, 'phone', focal_35mm=26),
                  render.develop(scene, light, share, rng), path)
    return drape.coefficient


# The fit of fit_bayes.json with a small mesh, few initial guesses and few samples.
SMALL_FIT = {'initial_stretch': [1], 'initial_bend': [0.5, 1, 2], 'initial_lifts': [0.8, 1],
             'model': 'bayes', 'mesh': 'disc:100', 'num_parameters': '2', 'posterior_samples': 4,
             'posterior_rank': 2, 'candidates_per_round': [3, 2, 1], 'iterations': [4, 4, 6],
             'elbo_samples': 25, 'min_relative_stiffness': 0.1}


class Desk:
    """drape_serve on a folder."""

    def __init__(self, folder, *options):
        self.folder, self.options = pathlib.Path(folder), options
        self.start()

    def start(self):
        self.process = subprocess.Popen([BIN / 'drape_serve', f'--out={self.folder}', *self.options],
                                        stdout=subprocess.PIPE, text=True)
        self.address = self.process.stdout.readline().strip()
        parts = urllib.parse.urlsplit(self.address)
        self.host, self.port, self.root = parts.netloc, parts.port, parts.path

    def stop(self, number=signal.SIGTERM):
        self.process.send_signal(number)
        code = self.process.wait(10)
        self.process.stdout.close()
        return code

    def ask(self, method, path, body=None, headers=None, root=None):
        """The status, the headers and the content of an answer."""
        connection = http.client.HTTPConnection('127.0.0.1', self.port, timeout=60)
        connection.request(method, (self.root if root is None else root) + path, body,
                           {'Host': self.host, **(headers or {})})
        answer = connection.getresponse()
        content = answer.read()
        connection.close()
        return answer.status, answer.headers, content

    def send(self, text, wait=5):
        """The answer to bytes as they are."""
        with socket.create_connection(('127.0.0.1', self.port), timeout=wait) as connection:
            try:
                connection.sendall(text)
                answer = b''
                while piece := connection.recv(65536):
                    answer += piece
            except (TimeoutError, ConnectionError):
                pass
        return answer

    def post(self, path, value=None, body=None):
        status, _, content = self.ask('POST', path, json.dumps(value) if body is None else body)
        answer = json.loads(content)
        if status != 200:
            raise ValueError(f'{status}: {answer["error"]}')
        return answer

    def items(self):
        return {item['id']: item
                for item in json.loads(self.ask('GET', 'state?since=0')[2])['items']}

    def wait(self, item, *states, limit=120):
        end = time.time() + limit
        while time.time() < end:
            found = self.items()[item]
            if found['state'] in states:
                return found
            time.sleep(0.05)
        raise TimeoutError(f'{item} is {found}')


class Browser:
    """A headless Chromium, driven by its developer tools over two pipes."""

    @staticmethod
    def find():
        return shutil.which('chromium-headless-shell') or shutil.which('chromium')

    def __init__(self):
        self.folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        read_here, write_there = os.pipe()
        read_there, write_here = os.pipe()

        def take_pipes():  # the browser reads 3 and writes 4
            first, second = os.dup(read_there), os.dup(write_there)
            os.dup2(first, 3)
            os.dup2(second, 4)

        self.process = subprocess.Popen(
            [self.find(), '--headless', '--no-sandbox', '--remote-debugging-pipe', '--disable-gpu',
             f'--user-data-dir={self.folder.name}', 'about:blank'], preexec_fn=take_pipes,
            close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(read_there)
        os.close(write_there)
        self.reader, self.writer = os.fdopen(read_here, 'rb'), os.fdopen(write_here, 'wb')
        self.number, self.session, self.left, self.log = 0, None, b'', []
        target = self.call('Target.createTarget', url='about:blank')['targetId']
        self.session = self.call('Target.attachToTarget', targetId=target, flatten=True)['sessionId']
        for domain in ('Page', 'Runtime', 'DOM', 'Log'):
            self.call(f'{domain}.enable')

    def close(self):
        self.process.kill()
        self.process.wait()
        self.reader.close()
        self.writer.close()
        self.folder.cleanup()

    def call(self, method, **parameters):
        self.number += 1
        message = {'id': self.number, 'method': method, 'params': parameters}
        if self.session:
            message['sessionId'] = self.session
        self.writer.write(json.dumps(message).encode() + b'\0')
        self.writer.flush()
        while True:
            while b'\0' not in self.left:
                piece = os.read(self.reader.fileno(), 1 << 20)
                if not piece:
                    raise RuntimeError('the browser has ended')
                self.left += piece
            text, self.left = self.left.split(b'\0', 1)
            answer = json.loads(text)
            if answer.get('method') in ('Runtime.exceptionThrown', 'Log.entryAdded'):
                self.log.append(answer['params'])
            if answer.get('id') == self.number:
                if 'error' in answer:
                    raise RuntimeError(f'{method}: {answer["error"]}')
                return answer['result']

    def evaluate(self, script):
        result = self.call('Runtime.evaluate', expression=script, awaitPromise=True,
                           returnByValue=True)
        if 'exceptionDetails' in result:
            raise RuntimeError(result['exceptionDetails'])
        return result['result'].get('value')

    def open(self, address, width=1280, height=1000, dark=False):
        self.size(width, height, dark)
        self.call('Page.navigate', url=address)
        self.until("document.readyState === 'complete'")

    def size(self, width, height=1000, dark=False, media=''):
        self.call('Emulation.setDeviceMetricsOverride', width=width, height=height,
                  deviceScaleFactor=1, mobile=False)
        self.call('Emulation.setEmulatedMedia', media=media, features=[
            {'name': 'prefers-color-scheme', 'value': 'dark' if dark else 'light'}])

    def until(self, condition, limit=120):
        """Waits; returns how long [s]."""
        begin = time.time()
        while not self.evaluate(f'Boolean({condition})'):
            if time.time() > begin + limit:
                raise TimeoutError(condition)
            time.sleep(0.03)
        return time.time() - begin

    def give_files(self, selector, files):
        document = self.call('DOM.getDocument')['root']['nodeId']
        node = self.call('DOM.querySelector', nodeId=document, selector=selector)['nodeId']
        self.call('DOM.setFileInputFiles', nodeId=node, files=[str(file) for file in files])

    def key(self, name, text='', shift=False):
        code = {'Tab': 9, 'Enter': 13, 'Space': 32, 'ArrowUp': 38, 'ArrowDown': 40, 'ArrowLeft': 37,
                'ArrowRight': 39}.get(name, 0)
        text = {'Enter': '\r', 'Space': ' '}.get(name, text)
        event = {'key': ' ' if name == 'Space' else name, 'code': name, 'windowsVirtualKeyCode': code,
                 'modifiers': 8 if shift else 0}
        self.call('Input.dispatchKeyEvent', type='keyDown', **event, **({'text': text} if text else {}))
        self.call('Input.dispatchKeyEvent', type='keyUp', **event)

    def write(self, text):
        self.call('Input.insertText', text=text)

    def mouse(self, kind, x, y):
        self.call('Input.dispatchMouseEvent', type=kind, x=x, y=y, button='left', clickCount=1,
                  buttons=0 if kind == 'mouseReleased' else 1)

    def screenshot(self, path, whole=True):
        data = self.call('Page.captureScreenshot', captureBeyondViewport=whole)['data']
        pathlib.Path(path).write_bytes(base64.b64decode(data))
