"""dissect_test.py LOG: what Wireshark makes of a recorded session (candump -L, from tests/hardware/vm/guest/session.sh): ISO-TP and UDS, every frame
of the services dissected, none malformed, and just the requests that were sent, each with its answer."""

import collections
import subprocess
import sys
import unittest

HOSTS = range(0xF1, 0xFE)  # each command has claimed an address of its own
REQUESTS = [0x18DA0100 | host for host in HOSTS]
ANSWERS = [0x18DA0001 | host << 8 for host in HOSTS]
NEGATIVE, PENDING = 0x3F, 0x78  # tshark shows a negative answer as one of service 0x3F
MIN_REQUESTS = 40
SERVICES = {0x10, 0x22, 0x2E, 0x31, 0x34, 0x36, 0x37, 0x3E}  # of an upload, home, arm, param, info and disarm
CLEAR_FAULTS = 0x14  # a board's e-stop is pressed too, and its fault not cleared before it is released: conditions not correct
NOT_NOW = 0x22


def tshark(log, wanted, *fields):
    """Rows of fields of the frames that match the filter."""
    command = ["tshark", "-r", log, "-o", "iso15765.can.extended_ids:" + ",".join(map(str, REQUESTS + ANSWERS)),
               "-d", "iso15765.subdissector,uds", "-Y", wanted, "-T", "fields"]
    for field in fields:
        command += ["-e", field]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    return [line.split("\t") for line in run.stdout.splitlines()]


def frames(log):
    """(id, bytes) of the frames of the services."""
    with open(log) as lines:
        for line in lines:
            name, data = line.split()[2].split("#")
            if name.startswith("18DA"):  # without the claims of addresses
                yield int(name, 16), bytes.fromhex(data)


class Dissect(unittest.TestCase):
    log = None

    def requests_sent(self):
        """By our own reading: the first byte of each single and first frame."""
        services = collections.Counter()
        for identifier, data in frames(self.log):
            if identifier in REQUESTS and data[0] >> 4 in (0, 1):
                services[data[1 + (data[0] >> 4)]] += 1
        return services

    def test_every_frame_of_the_services_is_iso_tp(self):
        sent = sum(1 for _ in frames(self.log))
        self.assertGreater(sent, 2000)
        self.assertEqual(len(tshark(self.log, "iso15765", "frame.number")), sent)
        print("    figure: %d frames of the services" % sent, flush=True)

    def test_none_is_malformed(self):
        self.assertEqual(tshark(self.log, "_ws.malformed || _ws.expert", "frame.number", "_ws.expert.message"), [])

    def test_the_requests_are_those_that_were_sent(self):
        rows = tshark(self.log, "uds", "uds.sid", "uds.reply", "uds.err.sid", "uds.err.code")
        shown = collections.Counter(int(sid, 0) for sid, reply, _, _ in rows if int(reply, 0) == 0)
        self.assertEqual(shown, self.requests_sent())
        self.assertLessEqual(SERVICES, set(shown))
        self.assertGreaterEqual(sum(shown.values()), MIN_REQUESTS)
        answers, asked_again, open_requests, pending = collections.Counter(), collections.Counter(), set(), 0
        for sid, reply, refused, code in rows:
            service = int(sid, 0)
            if int(reply, 0) == 0:
                asked_again[service] += service in open_requests  # a loaded machine: the host has waited for its 2 s
                open_requests.add(service)
                continue
            if service == NEGATIVE:
                if int(code, 0) == PENDING:
                    pending += 1
                    continue
                self.assertEqual((int(refused, 0), int(code, 0)), (CLEAR_FAULTS, NOT_NOW))
                service = CLEAR_FAULTS
            answers[service] += 1
            open_requests.discard(service)
        self.assertLessEqual(answers, shown)
        self.assertLessEqual(shown - asked_again, answers, "each request has its answer, or was repeated")
        print("    figure: %d UDS requests with their answers, %d times 'not yet'" % (sum(shown.values()), pending), flush=True)


if __name__ == "__main__":
    Dissect.log = sys.argv.pop(1)
    unittest.main()
