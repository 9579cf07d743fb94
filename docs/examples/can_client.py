#!/usr/bin/env python3
"""A client of other people's parts, written from docs/link.md: python-can for the real-time frames, the kernel's ISO-TP for the
services, canmatrix for the meaning of the frames. It uploads a scene, homes, arms, prints what the tip feels, and disarms.

    thimble dbc --output thimble.dbc
    thimble compile scenes/walls/walls.scene.json --output walls.thim
    python3 docs/examples/can_client.py can0 walls.thim thimble.dbc [SECONDS]
"""

import secrets
import socket
import struct
import sys
import time
import zlib

import can
import canmatrix.formats

NODE = 1
PROTOCOL = 3  # docs/link.md, the first lines: frames and services may differ in another
GRANT = 0x1D000000 | NODE
EXTENDED = socket.CAN_EFF_FLAG


def bus_for(interface, identifier, extended):
    """A bus on which only frames with this identifier are heard."""
    heard = {"can_id": identifier, "can_mask": 0x1FFFFFFF if extended else 0x7FF, "extended": extended}
    return can.Bus(interface="socketcan", channel=interface, can_filters=[heard])


class Services:
    """Requests to the controller over ISO-TP, from an address of this host's own."""

    def __init__(self, interface):
        self.bus, self.key = bus_for(interface, GRANT, True), secrets.token_bytes(6)
        host = self.claim()
        self.socket = socket.socket(socket.AF_CAN, socket.SOCK_DGRAM, socket.CAN_ISOTP)
        self.socket.settimeout(5)
        self.socket.bind((interface, 0x18DA0000 | host << 8 | NODE | EXTENDED, 0x18DA0000 | NODE << 8 | host | EXTENDED))

    def claim(self, action=1):
        """The address that the controller grants; claims are repeated, because either frame may be lost."""
        for _ in range(100):
            salt = secrets.randbits(16)
            self.bus.send(can.Message(arbitration_id=0x1C000000 | salt << 8 | NODE, is_extended_id=True, data=self.key + bytes([action, 0])))
            until = time.monotonic() + 0.05
            while action == 1 and time.monotonic() < until:
                grant = self.bus.recv(0.05)
                if grant and bytes(grant.data[:6]) == self.key and grant.data[6]:
                    return grant.data[6]
            if action != 1:
                return None
        sys.exit("no address was granted: is there a controller, and are fewer than four hosts connected?")

    def ask(self, *request):
        """The positive answer; "not yet" (78) and "busy" (21) are waited for."""
        pdu = b"".join(part if isinstance(part, bytes) else bytes.fromhex(part) for part in request)
        self.socket.send(pdu)
        while True:
            answer = self.socket.recv(4095)
            if answer[0] == pdu[0] + 0x40:
                return answer
            if answer[:2] == bytes([0x7F, pdu[0]]) and answer[2] == 0x21:
                time.sleep(0.05)
                self.socket.send(pdu)
            elif answer[:2] == bytes([0x7F, pdu[0]]) and answer[2] != 0x78:
                why = "" if pdu[0] == 0x22 else self.ask("22 F1AA")[3:].decode()
                sys.exit(f"{pdu[:4].hex()} was refused: {answer[2]:02X} {why}")

    def upload(self, file):
        """The image of a .thim file: prepare, begin, blocks, end, run."""
        image = open(file, "rb").read()
        if image[-8:-4] == b"CRC1":
            image = image[:-8]
        self.ask("10 02")
        has = struct.unpack(">I", self.ask("31 01 02 05", struct.pack(">II", len(image), zlib.crc32(image)))[4:8])[0]
        most = struct.unpack(">H", self.ask("34 00 44", struct.pack(">II", has, len(image) - has))[2:4])[0]
        number = 0
        for at in range(has, len(image), most - 2):
            number = (number + 1) % 256
            self.ask("36", bytes([number]), image[at:at + most - 2])
        self.ask("37")
        self.ask("31 01 02 04")

    def wait_for(self, mode):
        """Until DeviceState says this mode; its numbers are in the table Mode."""
        until = time.monotonic() + 10
        while self.ask("22 F1A1")[3] != mode:
            if time.monotonic() > until:
                sys.exit(f"mode {mode} did not come")


def watch(interface, services, matrix, seconds):
    """What the tip of arm 0 felt last. A host that says nothing for 5 s loses its place."""
    arm = matrix.frame_by_name("Arm")
    kinds = {name: number for number, name in arm.signal_by_name("kind").values.items()}
    until, alive, newest = time.monotonic() + seconds, 0.0, None
    with bus_for(interface, arm.arbitration_id.id, False) as bus:
        while time.monotonic() < until:
            if time.monotonic() > alive + 1:
                services.ask("3E 00")
                alive = time.monotonic()
            frame = bus.recv(0.1)
            if frame and frame.data[0] & 0x3F == kinds["force"]:  # 4 bits kind, 2 bits arm: all is decoded of the last one only
                newest = frame
    if newest is None:
        sys.exit("no force came")
    return {name: signal.phys_value for name, signal in arm.decode(bytes(newest.data)).items()}


def main(interface, scene, dbc, seconds=2.0):
    matrix = canmatrix.formats.loadp_flat(dbc)
    services = Services(interface)
    version = struct.unpack("<H", services.ask("22 F1A0")[3:5])[0]
    if version != PROTOCOL:
        sys.exit(f"the controller speaks protocol {version}, this client {PROTOCOL}: update the older one")
    services.upload(scene)
    services.ask("10 03")
    services.ask("31 01 02 03")  # home
    services.wait_for(2)
    services.ask("3E 00")  # arming needs a live link
    services.ask("31 01 02 01")  # arm
    try:
        services.wait_for(3)
        force = watch(interface, services, matrix, float(seconds))
    finally:
        services.ask("31 01 02 02")  # disarm
    services.wait_for(2)
    print("arm 0: force {force_x_N} {force_y_N} {force_z_N} N, contacts {force_contacts}".format(**force))
    services.claim(action=2)  # the place is free for another host
    services.bus.shutdown()
    print("disarmed")


if __name__ == "__main__":
    main(*sys.argv[1:])
