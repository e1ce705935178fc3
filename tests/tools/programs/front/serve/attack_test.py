# SPDX-License-Identifier: Apache-2.0
"""drape_serve and its enemies: what is not its own page, file or picture is refused, and what it
has taken survives whatever ends it."""
import concurrent.futures
import json
import os
import pathlib
import signal
import socket
import struct
import subprocess
import tempfile
import time
import unittest
import zlib

import desk

desk.require_server()
SECRET = b'not for the page'


def png(width, height, filler=b''):
    def chunk(kind, data):
        return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))
    return (b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', struct.pack('>IIBBBBB', width, height, 8, 2, 0, 0, 0))
            + chunk(b'IDAT', zlib.compress(filler)) + chunk(b'IEND', b''))


class Attack(unittest.TestCase):
    """All cases attack one desk, which serves its user at the end."""

    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.path = pathlib.Path(cls.scratch.name)
        (cls.path / 'secret.txt').write_bytes(SECRET)
        cls.photo = cls.path / 'photo.jpg'
        cls.coefficient = desk.paint(cls.photo, 800)
        config = cls.path / 'fit.json'
        config.write_text(json.dumps(desk.SMALL_FIT))
        cls.options = (f'--fit_config={config}',)
        cls.desk = desk.Desk(cls.path / 'desk', *cls.options)
        cls.first = cls.desk.post('upload?name=photo.jpg', body=cls.photo.read_bytes())['id']
        cls.desk.wait(cls.first, 'done')

    @classmethod
    def tearDownClass(cls):
        item = cls.desk.items()[cls.first]
        code = cls.desk.stop()
        cls.scratch.cleanup()
        assert item['state'] == 'done' and code == 130, (item, code)

    def expect(self, statuses, method, path, *arguments, **more):
        status, headers, content = self.desk.ask(method, path, *arguments, **more)
        self.assertIn(status, statuses, (method, path, content[:200]))
        self.assertNotIn(SECRET, content)
        self.assertNotIn(b'\n', content)  # an error is one line
        return headers, content

    def test_another_host_or_origin(self):
        port = self.desk.port
        for host in ('evil.example', f'evil.example:{port}', '127.0.0.1', f'127.0.0.1:{port + 1}',
                     f'127.0.0.1:{port}.evil.example', f'evil@127.0.0.1:{port}', ''):
            self.expect([403], 'GET', 'state', headers={'Host': host})
        for origin in ('http://evil.example', 'null', f'https://127.0.0.1:{port}',
                       f'http://localhost:{port}', 'http://127.0.0.1', 'file://'):
            self.expect([403], 'POST', 'run', '{}', headers={'Origin': origin})
        answer = self.desk.send(f'GET {self.desk.root} HTTP/1.1\r\nHost: {self.desk.host}\r\n'
                                'Host: evil.example\r\n\r\n'.encode())
        self.assertIn(b' 403 ', answer.splitlines()[0])
        headers, _ = self.expect([200], 'GET', 'state', headers={'Origin': f'http://{self.desk.host}'})
        self.assertIsNone(headers['Access-Control-Allow-Origin'])
        listening = [line.split()[1] for line in
                     pathlib.Path('/proc/net/tcp').read_text().splitlines() if ' 0A ' in line]
        self.assertIn(f'0100007F:{port:04X}', listening)  # the loopback interface
        self.assertNotIn(f'00000000:{port:04X}', listening)

    def test_no_token_and_wrong_ones(self):
        token = self.desk.root.strip('/')
        self.assertEqual(len(token), 48)
        for root in ('/', '', '//', f'/{token[:-1]}/', f'/{token[:-1]}x/', f'/{token.upper()}/', '/*/',
                     f'/{"0" * 48}/', f'/x/../{token}/', '/desk.js', '/favicon.ico'):
            for method in ('GET', 'POST'):
                if root != self.desk.root:
                    self.expect([400, 403], method, '', '' if method == 'POST' else None, root=root)
        self.expect([403], 'GET', '', root='/', headers={'Cookie': f'token={token}',
                                                         'Authorization': f'Bearer {token}'})
        for method in ('PUT', 'DELETE', 'PATCH', 'OPTIONS', 'HEAD'):
            self.assertEqual(self.desk.ask(method, 'state')[0], 405)

    def test_paths_out_of_the_folder(self):
        folder = self.path / 'desk' / self.first
        (folder / 'link.txt').symlink_to(self.path / 'secret.txt')
        (folder / 'up').symlink_to(self.path)
        for name in ('../../secret.txt', '..%2f..%2fsecret.txt', '%2e%2e/%2e%2e/secret.txt', 'link.txt',
                     'up/secret.txt', 'picture.jpg/../../../secret.txt', '/etc/passwd', '%2fetc/passwd',
                     'picture.jpg%00.html', '%00', '..\\..\\secret.txt', '.', '..', '', './picture.jpg',
                     'photo', 'photo/', '~/secret.txt', f'{self.path}/secret.txt', 'x' * 4000,
                     'photo//overlay.png', '%c0%ae%c0%ae/secret.txt'):
            self.expect([400, 404], 'GET', f'file/{self.first}/{name}')
        for item in ('..', '.', '%2e%2e', '0', '9999', '00001', '-1', '0001%00', 'desk', '', '*'):
            self.expect([400, 404], 'GET', f'file/{item}/secret.txt')
            for verb in ('change', 'cancel', 'retry', 'remove'):
                self.expect([400, 404], 'POST', f'{verb}/{item}', '{}')
        self.expect([400, 403, 404], 'GET', '../secret.txt')
        self.assertEqual(self.desk.ask('GET', f'file/{self.first}/picture.jpg')[2],
                         self.photo.read_bytes())

    def test_nothing_is_compressed(self):
        for path in ('', 'state', f'file/{self.first}/photo/summary.json'):
            status, headers, content = self.desk.ask('GET', path,
                                                     headers={'Accept-Encoding': 'gzip, br'})
            self.assertEqual((status, headers['Content-Encoding']), (200, None), path)
            self.assertEqual(headers['Content-Length'], str(len(content)))

    def test_names_are_text_and_no_path(self):
        before = set(self.path.rglob('*'))
        for name in ('../../evil.jpg', '/etc/evil.jpg', 'a%00b.jpg', 'a%0d%0aSet-Cookie:%20x=1.jpg',
                     '%3Cscript%3Ealert(1)%3C/script%3E.png', '%ff%fe.jpg', 'x' * 5000, '=1+1.csv', ''):
            _, content = self.expect([200], 'POST', f'upload?name={name}', self.photo.read_bytes())
            found = self.desk.items()[json.loads(content)['id']]
            self.assertLessEqual(len(found['name'].encode()), 100)
            self.assertTrue(found['name'].isprintable() or not found['name'])
            self.assertEqual(found['file'], 'picture.jpg')
            self.desk.post(f'cancel/{found["id"]}', {})
        for new in set(self.path.rglob('*')) - before:
            self.assertTrue(new.is_relative_to(self.path / 'desk'), new)
        headers, _ = self.expect([404], 'GET', 'file/0001/a%0d%0aX-Evil:%201')
        self.assertIsNone(headers['X-Evil'])

    def test_other_kinds_and_broken_uploads(self):
        before = len(self.desk.items())
        whole = self.photo.read_bytes()
        for content in (b'', b'x', b'\xff\xd8', b'GIF89a' + bytes(99), b'<svg xmlns="x"/>' + bytes(99),
                        b'%PDF-1.7' + bytes(99), b'\x7fELF' + bytes(99), b'#!/bin/sh\nid\n',
                        b'RIFF\0\0\0\0WEBPVP8 ', bytes(12) + whole, b'MZ' + whole):
            self.expect([415], 'POST', 'upload?name=a.jpg', content)
        self.expect([413], 'POST', 'upload?name=big.jpg', whole + bytes(65 << 20))
        self.expect([400, 413, 415], 'POST', 'upload?name=a.jpg', zlib.compress(bytes(1 << 20)),
                    headers={'Content-Encoding': 'deflate'})
        chunked = ('Transfer-Encoding: chunked\r\n\r\n' + 'FFFFF\r\n').encode() + whole[:8]
        head = (f'POST {self.desk.root}upload?name=a HTTP/1.1\r\nHost: {self.desk.host}\r\n').encode()
        for rest in (b'Content-Length: 99999\r\n\r\n' + whole[:999], chunked,
                     b'Content-Length: -1\r\n\r\n' + whole[:99], b'Content-Length: 9e9\r\n\r\nxx'):
            with socket.create_connection(('127.0.0.1', self.desk.port)) as closed:
                closed.sendall(head + rest)
        form = 'multipart/form-data; boundary=x'
        self.expect([400], 'POST', 'upload?name=a.jpg', b'--x--', headers={'Content-Type': form})
        self.expect([400, 416], 'GET', 'state', headers={'Range': 'bytes=' + '0-0,' * 900})
        time.sleep(0.5)
        self.assertEqual(len(self.desk.items()), before)
        self.assertFalse(list((self.path / 'desk').glob('.drapefit_*/upload')))
        # What begins as a picture is taken, and refused by the program that reads it.
        for content in (whole[:3000], png(60000, 60000, bytes(999)), png(2, 2, bytes(14)),
                        b'\xff\xd8\xff' + bytes(99999)):
            item = self.desk.post('upload?name=broken', body=content)['id']
            found = self.desk.wait(item, 'failed', 'done')
            self.assertEqual(found['state'], 'failed')
            self.assertTrue(found['error'].startswith('drape_photo: error: '), found['error'])

    def test_words_that_are_no_request(self):
        before = self.desk.items()[self.first]['fields']
        for path, bodies in {
                f'change/{self.first}': ['', '[]', '1', '{"fabric": 1}', '{"x": "1"}', '{"mass": null}',
                                         '{"fabric": "a\\nb"}', '{"fabric": "--out=/"}',
                                         '{"fabric": "../x"}', '{"fabric": "=1+1"}', '{"fabric": "a#b"}',
                                         '{"cloth_points": "1;2"}', '{"fabric": "%s"}' % ('x' * 999),
                                         '{"__proto__": "x"}', '{"fabric": "\\u0000"}', '[' * 60000],
                'run': ['', '{}', '[]', '{"kind": "fit"}', '{"kind": "fit", "pictures": []}',
                        '{"kind": "fit", "pictures": ["../0001"]}', '{"kind": "fit", "pictures": 1}',
                        '{"kind": "fit", "pictures": [["0001"]]}', '{"kind": "sh", "pictures": ["0001"]}',
                        '{"kind": "export", "of": "0001", "fit": "fit"}', '{"kind": ["fit"]}',
                        '{"kind": "export", "of": "0001", "fit": "../../x"}'],
                'nothing': ['{}'], 'upload/../run': ['{}']}.items():
            for body in bodies:
                self.expect([400, 404, 415], 'POST', path, body.encode())
        self.expect([413], 'POST', 'run', b' ' * (1 << 17))
        texts = (b'\0' * 99, b'GET\r\n\r\n', b'GET / HTTP/9\r\n\r\n', b'A' * 20000,
                 b'GET / HTTP/1.1\r\n' + b'X: y\r\n' * 9999 + b'\r\n',
                 b'\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03')
        with concurrent.futures.ThreadPoolExecutor(len(texts)) as pool:  # some wait for more
            for answer in pool.map(lambda text: self.desk.send(text, 1), texts):
                self.assertNotIn(b' 200 ', answer[:20])
        self.assertEqual(self.desk.items()[self.first]['fields'], before)

    def test_fifty_at_once_and_slow_clients(self):
        slow = [socket.create_connection(('127.0.0.1', self.desk.port)) for _ in range(20)]
        self.addCleanup(lambda: [each.close() for each in slow])
        for k, each in enumerate(slow):
            each.sendall(b'GET /' if k % 2 else f'POST {self.desk.root}upload HTTP/1.1\r\n'.encode())
        whole = self.photo.read_bytes()
        with concurrent.futures.ThreadPoolExecutor(50) as pool:
            made = list(pool.map(lambda k: self.desk.post(f'upload?name={k}.jpg', body=whole)['id'],
                                 range(50)))
        self.assertEqual(len(set(made)), 50)
        for item in made[1:]:
            self.desk.post(f'cancel/{item}', {})
        self.assertIn(self.desk.wait(made[0], 'done', 'cancelled')['state'], ('done', 'cancelled'))
        self.assertEqual(sorted(item for item in made if item in self.desk.items()), sorted(made))
        begin = time.time()
        self.desk.ask('GET', 'state')
        self.assertLess(time.time() - begin, 2)

    def test_points_change_the_measurement(self):
        item = self.desk.post('upload?name=p.jpg', body=self.photo.read_bytes())['id']
        found = self.desk.wait(item, 'done')
        self.assertAlmostEqual(100 * found['result']['dc'], self.coefficient, delta=1.5)
        self.assertIn('bending length', found['result']['bending_length'])
        for points in ('400,300', '400,300,20,20'):
            self.desk.post(f'change/{item}', {'ground_points': points, 'mass': '180'})
            found = self.desk.wait(item, 'failed', 'done')
        self.assertIn('--ground_points=400,300,20,20', found['command'])
        self.desk.post(f'change/{item}', {'ground_points': '', 'diameter': '0.24'})
        self.assertIn('--specimen=0.24', self.desk.wait(item, 'failed')['command'])

    def run_fit(self):
        self.desk.post(f'change/{self.first}', {'fabric': 'wool', 'mass': '270'})
        return self.desk.post('run', {'kind': 'fit', 'pictures': [self.first]})['id']

    def children(self):
        children = subprocess.run(['ps', '-eo', 'pid=,args='], capture_output=True, text=True).stdout
        return [line for line in children.splitlines() if f'{self.path}/desk/' in line]

    def wait_for_program(self, name):
        while not any(name in line for line in self.children()):
            time.sleep(0.05)

    def wait_for_no_program(self, part, limit=3):
        """Returns what still runs at the end."""
        end = time.time() + limit
        while (lines := [line for line in self.children() if part in line]) and time.time() < end:
            time.sleep(0.05)
        return lines

    def test_cancel_ends_the_programs(self):
        slow = socket.create_connection(('127.0.0.1', self.desk.port))
        self.addCleanup(slow.close)
        slow.sendall(b'GET /')
        item = self.run_fit()
        self.wait_for_program('drape_fit')
        for line in self.children():
            if 'drape_serve' not in line:  # no connection is open in a program
                files = pathlib.Path(f'/proc/{line.split()[0]}/fd').iterdir()
                self.assertFalse([file for file in map(os.readlink, files) if 'socket' in file])
        self.desk.post(f'cancel/{item}', {})
        begin = time.time()
        while self.children() and time.time() < begin + 5:
            time.sleep(0.05)
        self.assertLess(time.time() - begin, 2.5)
        self.assertEqual(self.desk.items()[item]['state'], 'cancelled')
        self.assertFalse((self.path / 'desk' / item / 'result/report.html').exists())
        self.desk.post(f'retry/{item}', {})
        while not self.children():
            time.sleep(0.05)
        self.desk.post(f'cancel/{item}', {})
        self.desk.post(f'retry/{item}', {})  # while its program ends
        self.assertEqual(self.desk.wait(item, 'done', 'failed')['result']['fits'], ['fit'])

    def wait_until_gone(self, folder):
        end = time.time() + 10
        while folder.exists():
            self.assertLess(time.time(), end, folder)
            time.sleep(0.05)

    def test_removal_is_of_whole_items_alone(self):
        item = self.desk.post('upload?name=r.jpg', body=self.photo.read_bytes())['id']
        folder = self.path / 'desk' / item
        self.expect([403], 'POST', f'remove/{item}', '', root='/')
        self.expect([403], 'POST', f'remove/{item}', '', headers={'Origin': 'http://evil.example'})
        self.expect([404], 'GET', f'remove/{item}')
        for path in ('remove', 'remove/', f'remove/{item}/', f'remove/{item}/photo', f'remove/../{item}',
                     'remove/*', 'remove/../../secret.txt', f'remove/{item}%00', 'remove/..%2fdesk'):
            self.expect([400, 403, 404], 'POST', path, '')
        self.assertTrue(folder.exists())
        (folder / 'up').symlink_to(self.path)
        # A fit keeps its photograph, a measurement ends, and a fit stays while an export needs it.
        self.desk.post(f'change/{item}', {'fabric': 'wool', 'mass': '270'})
        job = self.desk.post('run', {'kind': 'fit', 'pictures': [item]})['id']
        self.desk.wait(job, 'running')
        self.desk.post(f'remove/{item}', {})
        self.wait_until_gone(folder)
        outlines = None
        while (found := self.desk.items()[job])['state'] == 'running':
            outlines = found['outlines'] or outlines
            time.sleep(0.02)
        self.assertEqual(found['state'], 'done', found)
        self.assertEqual([each['name'] for each in outlines], [item])
        self.assertEqual([len(outlines[0][key]) for key in ('image_px', 'fit_px')], [360, 360])
        export = self.desk.post('run', {'kind': 'export', 'of': job, 'fit': 'fit'})['id']
        for state in ('running', 'cancelled'):
            self.desk.wait(export, state)
            self.expect([400], 'POST', f'remove/{job}', '')
            self.desk.post(f'cancel/{export}', {})
        again = self.run_fit()
        while not (lines := [line for line in self.children() if f'/desk/{again}' in line]):
            time.sleep(0.02)
        os.kill(int(lines[0].split()[0]), signal.SIGSTOP)  # it does not end when told to
        for each in (export, job, again):
            self.desk.post(f'remove/{each}', {})
            self.expect([404], 'POST', f'remove/{each}', '')
            self.assertNotIn(each, self.desk.items())
            if each != again:
                self.wait_until_gone(self.path / 'desk' / each)
        self.assertFalse([each for each in (self.path / 'desk').glob('.drapefit_*') if any(each.iterdir())])
        self.assertEqual((self.path / 'secret.txt').read_bytes(), SECRET)
        self.assertTrue((self.path / 'desk' / self.first).exists())
        removed = json.loads(self.desk.ask('GET', 'state?since=0')[2])['removed']
        self.assertLessEqual({item, export, job, again}, set(removed))
        self.assertGreater(self.desk.post('upload?name=n.jpg', body=self.photo.read_bytes())['id'], again)
        self.assertTrue((self.path / 'desk' / again).exists())
        self.desk.stop(signal.SIGKILL)
        self.desk.start()
        self.wait_until_gone(self.path / 'desk' / again)
        self.assertFalse(self.wait_for_no_program(f'/desk/{again}'))

    def test_killed_and_stopped_desks_continue(self):
        for number in (signal.SIGKILL, signal.SIGTERM):
            item = self.run_fit()
            self.wait_for_program('drape_fit')
            os.makedirs(self.path / 'desk/0500', exist_ok=True)  # is no item
            self.desk.stop(number)
            self.assertFalse(self.wait_for_no_program('/desk/'))
            earlier = self.desk.root
            self.desk.start()
            self.assertNotEqual(self.desk.root, earlier)
            self.expect([403], 'GET', 'state', root=earlier)
            self.assertEqual(self.desk.wait(item, 'done', 'failed')['state'], 'done')
            self.assertNotIn('0500', self.desk.items())
        # A folder has one desk, and a port one server.
        for option in (f'--out={self.path}/desk', f'--port={self.desk.port}'):
            out = f'--out={self.path}/other'
            other = subprocess.run([desk.BIN / 'drape_serve', out, option], capture_output=True,
                                   text=True, timeout=20)
            self.assertEqual((other.returncode, other.stderr.count('\n')), (2, 1), other.stderr)


if __name__ == '__main__':
    unittest.main()
