"""Other users of the same machine: nothing that they prepare or connect to reaches this user's files and devices. Needs root, for a second
user."""

import fcntl
import os
import signal
import subprocess
import time
import unittest

from rig import BIN, Rig, figure

OTHER = 65534
PYTHON = "/usr/bin/python3"  # one that the other user may run


@unittest.skipUnless(os.geteuid() == 0, "needs root, to start processes of another user")
class OtherUsers(Rig):
    def setUp(self):
        super().setUp()
        self.runtime.chmod(0o1777)  # as /tmp, where the folder is without XDG_RUNTIME_DIR
        self.announced = self.runtime / "thimble"

    def as_other(self, code, *arguments):
        """Runs Python as the other user, until its first line is there."""
        process = subprocess.Popen([PYTHON, "-c", code, *map(str, arguments)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                                   user=OTHER, group=OTHER, extra_groups=[], cwd="/")
        self.addCleanup(process.wait)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.stdin.close)  # it ends then
        return process.stdout.readline().strip()

    def sim_fails(self, text):
        result = subprocess.run([BIN / "thimble-sim", "--name", "arm-1"], capture_output=True, text=True, env=self.environment, timeout=20)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn(text, result.stderr)
        self.assertIn("remove it, or set XDG_RUNTIME_DIR to a folder of yours", result.stderr)

    def announce(self, *uris):
        """An announcement of this user's own, which a running process has locked."""
        self.announced.mkdir(mode=0o700)
        file = open(self.announced / "arm-1.sim", "w")
        self.addCleanup(file.close)
        file.write("arm=premium-1.5\n" + "".join("uri=%s\n" % uri for uri in uris))
        file.flush()
        fcntl.flock(file, fcntl.LOCK_EX)

    def test_a_prepared_folder_overwrites_no_file(self):
        precious = self.folder / "precious"
        precious.write_text("mine")
        self.folder.chmod(0o755)
        self.as_other("import os, sys; os.umask(0); os.mkdir(sys.argv[1], 0o777); os.symlink(sys.argv[2], sys.argv[1] + '/arm-1.sim'); print()",
                      self.announced, precious)
        self.sim_fails("belongs to the user %d, not to you" % OTHER)
        self.assertEqual(precious.read_text(), "mine")

    def test_a_link_for_a_folder_is_not_followed(self):
        elsewhere = self.folder / "elsewhere"
        elsewhere.mkdir(mode=0o700)
        self.announced.symlink_to(elsewhere)
        self.sim_fails("is a symbolic link")
        self.assertEqual(list(elsewhere.iterdir()), [])

    def test_a_folder_that_others_may_write_is_refused(self):
        self.announced.mkdir()
        self.announced.chmod(0o777)
        self.sim_fails("is open to other users")

    def test_links_in_the_own_folder_are_not_followed(self):
        precious = self.folder / "precious"
        precious.write_text("mine")
        self.announced.mkdir(mode=0o700)
        (self.announced / "arm-1.sim").symlink_to(precious)
        os.mkfifo(self.announced / "pipe.sim")
        self.assertEqual(self.ok_json("list")["devices"], [])
        sim = self.sim()
        self.assertEqual(precious.read_text(), "mine")
        self.assertEqual([device["name"] for device in self.ok_json("list")["devices"]], ["arm-1"])
        self.assertEqual(sim.stop(), 0)
        self.assertFalse(self.announced.exists())

    def test_a_decoy_is_no_device(self):
        self.as_other("""if True:
            import fcntl, os, sys
            os.umask(0)
            os.mkdir(sys.argv[1], 0o755)
            file = open(sys.argv[1] + '/arm-1.sim', 'w')
            file.write('arm=premium-1.5\\nuri=tcp:127.0.0.1:1\\n')
            file.flush()
            fcntl.flock(file, fcntl.LOCK_EX)
            print(flush=True)
            sys.stdin.read()""", self.announced)
        said = self.fails(5, "runtime-folder", "info")
        self.assertIn("belongs to the user %d" % OTHER, said["cause"])
        self.fails(5, "runtime-folder", "info", "--device", "arm-1")
        listed = self.run_thimble("list")
        self.assertEqual((listed.code, listed.out), (0, ""))
        self.assertIn("belongs to the user %d" % OTHER, listed.err)
        self.assertEqual(self.ok_json("list")["devices"], [])
        self.fails(3, "no-device", "info", "--device", "tcp:127.0.0.1:1")  # an address needs no folder

    def test_addresses_of_another_user_are_not_listed(self):
        pty = self.as_other("import os, sys; pair = os.openpty(); print(os.ttyname(pair[1]), flush=True); sys.stdin.read()")
        port = self.as_other("import socket, sys; s = socket.create_server(('127.0.0.1', 0)); print(s.getsockname()[1], flush=True); sys.stdin.read()")
        self.assertEqual(os.stat(pty).st_uid, OTHER)
        self.announce("slcan:" + pty, "tcp:127.0.0.1:" + port)
        self.assertEqual(self.ok_json("list")["devices"], [])
        self.fails(3, "no-device", "info")

    def test_a_tcp_device_is_for_its_own_user(self):
        connect = """if True:
            import socket, sys
            host = socket.create_connection(('127.0.0.1', int(sys.argv[1])))
            host.settimeout(5)
            heard = b''
            try:
                host.sendall(b'\\rC\\rS8\\rO\\rT18DA01F180322F1A0CCCCCCCC\\r')
                while b'T18DAF1018' not in heard:
                    data = host.recv(4096)
                    if not data:
                        break
                    heard += data
            except OSError:
                pass
            print(len(heard), flush=True)"""
        stop = "import socket, sys; socket.create_connection(('127.0.0.1', int(sys.argv[1]))).sendall(b't0010\\r'); print(flush=True)"
        own = self.sim("--no-pty", "--tcp", 0)
        self.assertEqual(self.as_other(connect, own.port), "0")
        # And of a process that has ended when the device looks.
        for _ in range(5):
            self.as_other(stop, own.port)
        self.ok("info", "--device", own.tcp)
        # A stop is anybody's: of a program that has ended already, whose user nobody can tell, it is taken; nothing else is.
        faults = self.ok_json("fault", "list", "--device", own.tcp)["faults"]
        self.assertLessEqual({fault["name"] for fault in faults}, {"host_stop"})
        own.process.send_signal(signal.SIGTERM)
        said = own.process.communicate(timeout=20)[1]
        self.assertIn("a connection to %s was refused: it is of the user %d, and only the user 0 may connect (--open: everyone)"
                      % (own.tcp, OTHER), said)
        shared = self.sim("--no-pty", "--tcp", 0, "--open")
        heard = int(self.as_other(connect, shared.port))
        figure("the other user heard 0 bytes of a device of ours, and %d of one with --open" % heard)
        self.assertGreater(heard, 20)
        self.ok("info", "--device", shared.tcp)

    def test_connections_that_another_user_has_left_displace_nobody(self):
        """Nobody can tell whose they were, and what was sent there is still to be read."""
        flood = """if True:
            import socket, sys, threading
            def flood():
                while True:
                    host = socket.socket()
                    try:
                        host.connect(('127.0.0.1', int(sys.argv[1])))
                        host.setblocking(False)
                        host.send(3000000 * b'x')
                    except OSError:
                        pass
                    host.close()
            threading.Thread(target=flood, daemon=True).start()
            print(flush=True)
            sys.stdin.read()"""
        own = self.sim("--no-pty", "--tcp", 0)
        monitor = self.start("monitor", "--seconds", "6", "--device", own.tcp)
        time.sleep(0.5)
        for _ in range(1 if "THIMBLE_UNDER_SANITIZERS" in os.environ else 4):  # there the simulator reads a tenth as fast
            self.as_other(flood, own.port)
        took = []
        for _ in range(5):
            time.sleep(0.5)
            began = time.monotonic()
            self.ok("stop", "--device", own.tcp)
            took.append(time.monotonic() - began)
        figure("5 stops beside connections of another user: %.2f s at most" % max(took))
        said = monitor.communicate(timeout=30)[1]
        self.assertEqual(monitor.returncode, 0, said)


if __name__ == "__main__":
    unittest.main()
