"""The DBC file as read by another tool (canmatrix, Debian's python3-canmatrix), and CAN logs decoded by `thimble decode`."""

import json
import os
import subprocess
import unittest

from rig import BIN, Rig

with open(os.devnull, "w") as nowhere:  # it names the formats that it lacks
    out, err = os.dup(1), os.dup(2)
    os.dup2(nowhere.fileno(), 1), os.dup2(nowhere.fileno(), 2)
    import canmatrix.formats
    os.dup2(out, 1), os.dup2(err, 2)

COUNT = 200


def meant_frames():
    lines = subprocess.run([BIN / "meant_frames", str(COUNT)], capture_output=True, text=True, check=True).stdout
    return [json.loads(line) for line in lines.splitlines()]


class Dbc(Rig):
    def matrix(self, *arguments):
        file = self.folder / "thimble.dbc"
        self.ok("dbc", "--output", file, *arguments)
        self.assertEqual(self.ok("dbc", *arguments).out, file.read_text())
        return canmatrix.formats.loadp_flat(str(file))

    def test_canmatrix_reads_what_the_firmware_meant(self):
        matrix = self.matrix()
        seen = set()
        for frame in meant_frames():
            if frame["fd"]:
                continue
            message = matrix.frame_by_id(canmatrix.ArbitrationId(frame["id"], extended=False))
            seen.add(message.name)
            data = bytes.fromhex(frame["data"])
            self.assertEqual(message.size, len(data))
            decoded = message.decode(data)
            self.assertEqual(set(decoded) - {"kind"}, {meant["signal"] for meant in frame["meant"]}, frame["message"])
            for meant in frame["meant"]:
                value, step = meant["value"], meant["step"]
                self.assertAlmostEqual(float(decoded[meant["signal"]].phys_value), value, delta=0.501 * step + 1e-6 * abs(value),
                                       msg=f"{message.name}.{meant['signal']}")
        services = {name + host for name in ("Request", "Response") for host in ["", *("_%X" % address for address in range(0xF2, 0xFE))]}
        self.assertEqual(seen | services | {"HostGrant"}, {message.name for message in matrix.frames})

    def test_names_of_values_and_comments(self):
        matrix = self.matrix()
        status = matrix.frame_by_name("Status")
        self.assertEqual(status.signal_by_name("mode").values[3], "armed")
        self.assertEqual(status.signal_by_name("fault").values[1], "e_stop")
        self.assertEqual(matrix.frame_by_name("Heartbeat").signal_by_name("state").values[0x7F], "not_armed")
        homed = status.signal_by_name("flags_homed")
        self.assertEqual((homed.size, homed.start_bit), (1, 16))
        self.assertEqual(status.signal_by_name("limiters_thermal").size, 1)
        self.assertEqual(status.signal_by_name("worst_tick_s").unit, "s")
        self.assertTrue(all(message.comment for message in matrix.frames))
        order = matrix.frame_by_name("Order")
        self.assertEqual((order.transmitters, order.signal_by_name("force_z_N").receivers), (["Host"], ["Controller"]))
        arm = matrix.frame_by_name("Arm")
        self.assertEqual((arm.transmitters, arm.size), (["Controller"], 8))
        self.assertEqual(arm.signal_by_name("kind").values[2], "god_object")
        self.assertEqual(arm.signal_by_name("kind").multiplex, "Multiplexor")
        self.assertEqual(arm.signal_by_name("pose_limiters_thermal").size, 1)
        request = matrix.frame_by_name("Request")
        self.assertTrue(request.arbitration_id.extended)
        self.assertEqual(request.arbitration_id.id, 0x18DA01F1)
        for host in range(0xF2, 0xFE):  # the addresses that are granted
            self.assertEqual(matrix.frame_by_name("Request_%X" % host).arbitration_id.id, 0x18DA0100 | host)
            self.assertEqual(matrix.frame_by_name("Response_%X" % host).arbitration_id.id, 0x18DA0001 | host << 8)
        grant = matrix.frame_by_name("HostGrant")
        self.assertEqual(grant.arbitration_id.id, 0x1D000001)
        said = grant.decode(bytes.fromhex("0605040302 01 F2 04"))
        self.assertEqual({name: int(signal.raw_value) for name, signal in said.items()},
                         {"key": 0x010203040506, "address": 0xF2, "places": 4})

    def test_another_node(self):
        self.assertEqual(self.matrix("--node", "5").frame_by_name("Arm").arbitration_id.id, 0x185)
        self.assertEqual(self.run_thimble("dbc", "--node", "128").code, 2)
        self.assertEqual(self.run_thimble("dbc", "--output", "/nowhere/x.dbc").code, 5 if os.getuid() else 1)


class Decode(Rig):
    def log(self, *lines):
        file = self.folder / "frames.log"
        file.write_text("\n".join(lines) + "\n")
        return file

    def decode(self, *lines):
        return [json.loads(line) for line in self.ok("decode", "--json", self.log(*lines)).out.splitlines()]

    def test_real_time_frames(self):
        frames = meant_frames()
        said = self.decode(*("(%d.5) can0 %03X%s%s" % (i, frame["id"], "##1" if frame["fd"] else "#", frame["data"]) for i, frame in enumerate(frames)))
        self.assertEqual(len(said), len(frames))
        for i, (line, frame) in enumerate(zip(said, frames)):
            self.assertEqual((line["time_s"], line["interface"], line["message"]), (i + 0.5, "can0", frame["message"]))
            for meant in (meant for meant in frame["meant"] if "json" in meant):
                shown = line
                for key in meant["json"]:
                    shown = shown[key]
                if isinstance(meant["shown"], float):
                    self.assertAlmostEqual(shown, meant["shown"], delta=0.501 * meant["step"] + 1e-6 * abs(meant["shown"]))
                else:
                    self.assertEqual(shown, meant["shown"], f"{frame['message']} {meant['json']}")

    def test_services(self):
        said = self.decode("(1.0) can0 18DA01F1#0322F1A0CCCCCCCC",
                           "(1.1) can0 18DAF101#100A62F1A0020001",
                           "(1.2) can0 18DA01F1#300000CCCCCCCCCC",
                           "(1.3) can0 18DAF101#2100080101CCCCCC",
                           "(1.4) can0 18DAF101#037F3122CCCCCCCC",
                           "(1.5) can0 20000040#0000000000000000")
        self.assertEqual([line["message"] for line in said], ["Request", "Response", "Response", "ErrorFrame"])
        self.assertEqual((said[0]["service"], said[0]["pdu"]), ("read_data", "22F1A0"))
        self.assertEqual(said[1]["record"], "LinkInfo")
        self.assertEqual(said[1]["fields"], {"protocol": 2, "image": 1, "frame_bytes": 8, "node": 1, "arms": 1})
        self.assertEqual((said[2]["service"], said[2]["refused"]), ("routine", "conditions_not_correct"))

    def test_addresses_of_hosts(self):
        """A claim, its grant, and requests and answers of the host that has the address."""
        said = self.decode("(1.0) can0 1CABCD01#0102030405060100", "(1.1) can0 1D000001#010203040506F304",
                           "(1.2) can0 18DA01F3#0322F1A0CCCCCCCC", "(1.3) can0 18DAF301#037F2231CCCCCCCC",
                           "(1.4) can0 1C000001#0102030405060200", "(1.5) can0 18DA01F0#0322F1A0CCCCCCCC")
        self.assertEqual([line["message"] for line in said], ["HostClaim", "HostGrant", "Request", "Response", "HostRelease"])
        self.assertEqual([line["key"] for line in said if "key" in line], [0x060504030201] * 3)
        self.assertEqual([line["host"] for line in said if "host" in line], [0xF3] * 3)

    def test_what_is_no_record_and_stops_without_data(self):
        said = self.decode("(1.0) can0 18DAF101#0662F195302E31CC", "(1.1) can0 001#", "(1.2) can0 001#R", "(1.3) can0 18DAF101#027F31CCCCCCCCCC")
        self.assertEqual([line["message"] for line in said], ["Response", "EmergencyStop", "EmergencyStop", "Response"])
        self.assertEqual((said[0]["service"], said[0]["pdu"]), ("read_data", "62F195302E31"))
        self.assertNotIn("record", said[0])

    def test_lost_frames_and_strangers_are_counted(self):
        result = self.ok("decode", self.log("(1.0) can0 18DAF101#101462F1A0010001", "(1.1) can0 18DAF101#2200080101CCCCCC", "(1.2) can0 7FF#00"))
        self.assertEqual(result.out, "")
        self.assertIn("1 PDUs are not whole, 1 frames are not Thimble's", result.err)

    def test_a_broken_log(self):
        result = self.fails(10, "bad-log", "decode", self.log("(1.0) can0 7FF#00", "(1.1) can0 oops"))
        self.assertIn("frames.log:2:", result["cause"])
        self.fails(10, "cannot-read", "decode", self.folder / "none.log")


if __name__ == "__main__":
    unittest.main()
