"""`thimble publish` against Debian's mosquitto, heard by an independent client (paho): the stream, the retained state, the last will, and a broker
that is restarted in the middle."""

import json
import os
import signal
import socket
import subprocess
import threading
import time
import unittest
from pathlib import Path

import paho.mqtt.client as mqtt

from rig import Rig, figure


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


class Broker:
    def __init__(self, rig, port, extra=""):
        self.port = port
        config = rig.folder / f"mosquitto-{port}.conf"
        config.write_text(f"listener {port} 127.0.0.1\n" + (extra or "allow_anonymous true\n"))
        self.process = subprocess.Popen(["/usr/sbin/mosquitto", "-c", config], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        rig.addCleanup(self.stop)
        end = time.monotonic() + 20
        while True:
            try:
                socket.create_connection(("127.0.0.1", port)).close()
                return
            except OSError:
                if time.monotonic() > end:
                    raise
                time.sleep(0.05)

    def stop(self):
        self.process.terminate()
        self.process.wait(timeout=20)


class Ear:
    """Hears everything, across restarts of the broker."""

    def __init__(self, rig, port):
        self.heard, self.changed = [], threading.Condition()
        self.client = mqtt.Client()
        self.client.on_connect = lambda client, *_: client.subscribe("#", qos=1)
        self.client.on_message = self.take
        self.client.reconnect_delay_set(1, 1)
        self.client.connect("127.0.0.1", port)
        self.client.loop_start()
        rig.addCleanup(self.client.loop_stop)
        rig.addCleanup(self.client.disconnect)

    def take(self, _client, _data, message):
        with self.changed:
            self.heard.append((message.topic, json.loads(message.payload), message.retain))
            self.changed.notify_all()

    def wait_for(self, is_wanted, seconds=30):
        with self.changed:
            if not self.changed.wait_for(lambda: any(is_wanted(*each) for each in self.heard), seconds):
                raise AssertionError("not heard; the last: %s" % self.heard[-3:])
            return next(each for each in self.heard if is_wanted(*each))

    def forget(self):
        with self.changed:
            self.heard.clear()


class Publish(Rig):
    def setUp(self):
        super().setUp()
        leaks = Path(__file__).parents[2] / "cmake/sanitizers.leaks"
        self.environment["LSAN_OPTIONS"] = f"suppressions={leaks}:print_suppressions=0"

    def test_a_stream_with_a_broker_that_is_restarted(self):
        port = free_port()
        broker, sim = Broker(self, port), self.sim("--tcp", 0)
        ear = Ear(self, port)
        publisher = self.start("publish", "--broker", f"127.0.0.1:{port}", "--topic", "lab/left", "--device", sim.tcp, "--json")
        self.addCleanup(publisher.communicate)
        self.addCleanup(publisher.kill)
        _, state, _ = ear.wait_for(lambda topic, *_: topic == "lab/left/state")
        self.assertEqual((state["state"], state["board"], state["mode"], state["arm"]), ("online", "sim", "disarmed", "premium-1.5"))
        ear.wait_for(lambda topic, message, _: topic == "lab/left" and message["message"] == "Force")
        self.assertEqual(Ear(self, port).wait_for(lambda topic, *_: topic == "lab/left/state")[2], 1, "who comes later is told, too")

        lines = [json.loads(line) for line in self.ok("monitor", "--json", "--seconds", 2, "--device", sim.tcp).out.splitlines()]
        for kind in ("Pose", "Force", "Status"):
            line = next(each for each in lines if each["message"] == kind)
            _, told, _ = ear.wait_for(lambda topic, message, _: topic == "lab/left" and message["message"] == kind)
            self.assertEqual(set(told), set(line) | {"utc_s"})
            self.assertLess(abs(told["utc_s"] - time.time()), 60)

        self.ok("home", "--device", sim.tcp)
        ear.wait_for(lambda topic, message, _: topic == "lab/left/state" and message["mode"] == "ready")
        broker.stop()
        time.sleep(1)
        broker = Broker(self, port)
        ear.forget()
        _, state, _ = ear.wait_for(lambda topic, *_: topic == "lab/left/state")
        self.assertEqual((state["state"], state["mode"]), ("online", "ready"))
        ear.wait_for(lambda topic, message, _: topic == "lab/left" and message["message"] == "Force")
        ear.forget()
        publisher.send_signal(signal.SIGINT)
        out, said = publisher.communicate(timeout=30)
        self.assertEqual(publisher.returncode, 0, said)
        told = json.loads(out)
        self.assertEqual((told["topic"], told["connections"]), ("lab/left", 2))
        self.assertGreater(told["dropped"], 0)
        ear.wait_for(lambda topic, message, _: topic == "lab/left/state" and message["state"] == "offline")
        figure("%d messages published, %d dropped while the broker was away" % (told["published"], told["dropped"]))

    def test_a_broker_that_hangs_or_is_cut_off_does_not_hold_it_at_the_end(self):
        for hangs in (True, False):
            port = free_port()
            broker, sim = Broker(self, port), self.sim("--tcp", 0)
            ear = Ear(self, port)
            publisher = self.start("publish", "--broker", f"127.0.0.1:{port}", "--topic", "lab/left", "--device", sim.tcp)
            self.addCleanup(publisher.communicate)
            self.addCleanup(publisher.kill)
            ear.wait_for(lambda topic, message, _: topic == "lab/left" and message["message"] == "Force")
            if hangs:
                self.addCleanup(broker.process.send_signal, signal.SIGCONT)
                broker.process.send_signal(signal.SIGSTOP)
            else:  # its machine drops what comes: a listener whose queue is full
                broker.stop()
                full = socket.create_server(("127.0.0.1", port), backlog=0)
                self.addCleanup(full.close)
                for _ in range(4):
                    waits = socket.socket()
                    waits.setblocking(False)
                    waits.connect_ex(("127.0.0.1", port))
                    self.addCleanup(waits.close)
            time.sleep(3)
            began = time.monotonic()
            publisher.send_signal(signal.SIGINT)
            _, said = publisher.communicate(timeout=30)
            self.assertEqual(publisher.returncode, 0, said)
            self.assertLess(time.monotonic() - began, 8)

    def test_the_last_will(self):
        port = free_port()
        Broker(self, port)
        sim, ear = self.sim("--tcp", 0), Ear(self, port)
        publisher = self.start("publish", "--broker", f"127.0.0.1:{port}", "--device", sim.tcp)
        topic, state, _ = ear.wait_for(lambda topic, message, _: topic.endswith("/state") and message["state"] == "online")
        self.assertEqual(topic, f"thimble/{state['serial_number']}/state")
        publisher.kill()
        publisher.communicate()
        ear.wait_for(lambda topic, message, _: topic.endswith("/state") and message["state"] == "offline")

    def test_user_and_password(self):
        passwords, secret, wrong = (self.folder / name for name in ("passwords", "secret", "wrong"))
        subprocess.run(["mosquitto_passwd", "-b", "-c", passwords, "lab", "open sesame"], check=True)
        secret.write_text("open sesame\n")
        wrong.write_text("sesame\n")
        passwords.chmod(0o644)
        port = free_port()
        Broker(self, port, f"allow_anonymous false\npassword_file {passwords}\nuser {os.environ.get('USER', 'root')}\n")
        sim = self.sim("--tcp", 0)
        to = ("publish", "--broker", f"127.0.0.1:{port}", "--device", sim.tcp, "--seconds", "1")
        self.ok(*to, "--user", "lab", "--password-file", secret)
        self.fails(5, "broker-refused", *to, "--user", "lab", "--password-file", wrong)
        self.fails(5, "broker-refused", *to)

    def test_what_is_refused(self):
        port = free_port()
        sim = self.sim("--tcp", 0)
        self.fails(6, "no-broker", "publish", "--broker", f"127.0.0.1:{port}", "--device", sim.tcp)
        self.fails(2, "bad-broker", "publish", "--broker", "127.0.0.1:many", "--device", sim.tcp)
        self.fails(6, "no-broker", "publish", "--broker", f"[::1]:{port}", "--device", sim.tcp)
        for broker in ("[::1]1883", "[::1]:", "[::1]:many", "[::1", "[]", "[]:1883", ":1883", "", "a]b:1"):
            self.fails(2, "bad-broker", "publish", "--broker", broker, "--device", sim.tcp)
        self.fails(2, "bad-topic", "publish", "--broker", f"127.0.0.1:{port}", "--topic", "lab/#", "--device", sim.tcp)
        self.fails(2, "usage", "publish", "--device", sim.tcp)


if __name__ == "__main__":
    unittest.main()
