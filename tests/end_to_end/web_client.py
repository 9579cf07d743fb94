"""A WebSocket client (RFC 6455) and plain HTTP with the standard library, limited to what the tests need."""

import base64
import hashlib
import json
import os
import socket
import struct
import time


class Refused(Exception):
    def __init__(self, status):
        super().__init__("HTTP status %d" % status)
        self.status = status


def http(port, path, host=None, method="GET", headers=(), body=b""):
    """Status, headers in lower case and body."""
    with socket.create_connection(("127.0.0.1", port), timeout=10) as end:
        request = ["%s %s HTTP/1.1" % (method, path), "Host: " + (host or "127.0.0.1:%d" % port), "Connection: close", *headers]
        end.sendall(("\r\n".join(request) + "\r\n\r\n").encode() + body)
        answer = b""
        while data := end.recv(65536):
            answer += data
    head, _, body = answer.partition(b"\r\n\r\n")
    lines = head.decode().split("\r\n")
    return int(lines[0].split()[1]), dict(line.lower().split(": ", 1) for line in lines[1:]), body


class Page:
    """A page's WebSocket."""

    def __init__(self, port, token=None, origin=None, host=None, receive_buffer=None):
        self.end = socket.socket()
        if receive_buffer:
            self.end.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        self.end.settimeout(20)
        self.end.connect(("127.0.0.1", port))
        key = base64.b64encode(os.urandom(16)).decode()
        request = ["GET /live%s HTTP/1.1" % ("?token=" + token if token else ""), "Host: " + (host or "127.0.0.1:%d" % port), "Upgrade: websocket",
                   "Connection: Upgrade", "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: " + key]
        if origin:
            request.append("Origin: " + origin)
        self.end.sendall(("\r\n".join(request) + "\r\n\r\n").encode())
        self.rest = b""
        while b"\r\n\r\n" not in self.rest:
            data = self.end.recv(4096)
            if not data:
                raise ConnectionError("closed before an answer")
            self.rest += data
        head, _, self.rest = self.rest.partition(b"\r\n\r\n")
        status = int(head.split()[1])
        if status != 101:
            self.end.close()
            raise Refused(status)
        accept = base64.b64encode(hashlib.sha1((key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11").encode()).digest())
        assert accept in head

    def close(self):
        self.end.close()

    def frame(self, opcode, payload):
        mask = os.urandom(4)
        size = len(payload)
        head = bytes([0x80 | opcode]) + (bytes([0x80 | size]) if size < 126 else bytes([0x80 | 126]) + struct.pack(">H", size) if size < 65536
                                         else bytes([0x80 | 127]) + struct.pack(">Q", size))
        self.end.sendall(head + mask + bytes(b ^ mask[i % 4] for i, b in enumerate(payload)))

    def send(self, **message):
        self.frame(1, json.dumps(message).encode())

    def send_text(self, text):
        self.frame(1, text.encode())

    def take(self, count):
        while len(self.rest) < count:
            data = self.end.recv(65536)
            if not data:
                raise ConnectionError("closed")
            self.rest += data
        taken, self.rest = self.rest[:count], self.rest[count:]
        return taken

    def receive(self):
        """The next message; pings are answered on the way."""
        while True:
            first, second = self.take(2)
            size = second & 127
            if size == 126:
                size = struct.unpack(">H", self.take(2))[0]
            elif size == 127:
                size = struct.unpack(">Q", self.take(8))[0]
            payload = self.take(size)
            opcode = first & 15
            if opcode == 9:
                self.frame(10, payload)
            elif opcode == 8:
                raise ConnectionError("closed by the server")
            elif opcode == 1:
                assert first & 128, "the server's messages come whole"
                return json.loads(payload)

    def until(self, wanted, seconds=20, what=""):
        """The first message that `wanted` takes."""
        end = time.monotonic() + seconds
        last = None
        while time.monotonic() < end:
            message = self.receive()
            if wanted(message):
                return message
            last = message
        raise AssertionError("%s did not come within %g s; the last message: %s" % (what or "the message", seconds, json.dumps(last)[:2000]))

    def event(self, name, seconds=20):
        return self.until(lambda m: m["type"] == "event" and m["name"] == name, seconds, "event " + name)

    def state(self, wanted=lambda state: True, seconds=20, what="state"):
        return self.until(lambda m: m["type"] == "state" and wanted(m), seconds, what)
