"""The reference builds of board/linux/reference: overlay, table of pins and configuration of each agree, and thimble-board takes the configuration."""

import json
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

from rig import BIN

BUILDS = Path(__file__).parents[2] / "board/linux/reference"

# Of the AM3358: pad -> offset of its register from 0x44e10800, and the mode of what is used (technical reference manual, table 9-10; data sheet,
# table 4-1). Header pins of the BeagleBone Black by its system reference manual, section 7.
PADS = {
    "P9_42": ("eQEP0A_in", 0x1A0, 1), "P9_27": ("eQEP0B_in", 0x1A4, 1),
    "P8_35": ("eQEP1A_in", 0x0D0, 2), "P8_33": ("eQEP1B_in", 0x0D4, 2),
    "P8_12": ("eQEP2A_in", 0x030, 4), "P8_11": ("eQEP2B_in", 0x034, 4),
    "P9_22": ("SPI0_SCLK", 0x150, 0), "P9_21": ("SPI0_D0", 0x154, 0), "P9_18": ("SPI0_D1", 0x158, 0), "P9_17": ("SPI0_CS0", 0x15C, 0),
    "P9_26": ("DCAN1_TX", 0x180, 2), "P9_24": ("DCAN1_RX", 0x184, 2),
    "P9_12": ("gpio1_28", 0x078, 7), "P9_15": ("gpio1_16", 0x040, 7), "P9_23": ("gpio1_17", 0x044, 7),
    "P9_14": ("gpio1_18", 0x048, 7), "P9_16": ("gpio1_19", 0x04C, 7), "P8_26": ("gpio1_29", 0x07C, 7),
}  # fmt: skip
# Of the Raspberry Pi's header.
PI_PINS = {"11": 17, "15": 22, "19": 10, "21": 9, "22": 25, "23": 11, "24": 8}
INPUT, PULL_UP, NO_PULL = 0x20, 0x10, 0x08


def rows(readme):
    """The rows of the table of pins, without its head."""
    table = re.search(r"## Pins\n\n(.*?)\n\n", readme, re.S)[1]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()[2:]]


def code(cell):
    return re.findall(r"`([^`]+)`", cell)


def lines_of(config):
    """Every line of a configuration: its name and its key."""
    found = {config[key]["line"]: key for key in ("e_stop", "dead_man", "heartbeat") if key in config}
    for arm in config["arms"]:
        found.update({arm[key]["line"]: key for key in ("enable", "drive_fault", "index") if key in arm})
    return found


class Build(unittest.TestCase):
    name = ""

    def setUp(self):
        if not self.name:
            self.skipTest("the base of the others")
        folder = BUILDS / self.name
        self.config = json.loads((folder / "board.json").read_text())
        self.rows = rows((folder / "README.md").read_text())
        self.source = (folder / "thimble.dts").read_text()
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.blob = Path(temporary.name) / "thimble.dtbo"
        made = subprocess.run(["dtc", "-@", "-I", "dts", "-O", "dtb", "-o", self.blob, folder / "thimble.dts"],
                              capture_output=True, text=True, check=False)
        self.assertEqual((made.returncode, made.stderr), (0, ""))

    def get(self, node, name, kind="x"):
        words = subprocess.run(["fdtget", "-t", kind, self.blob, node, name], capture_output=True, text=True, check=True).stdout
        return words.rstrip("\n").split(" ") if kind == "s" else [int(word, 16) for word in words.split()]

    def fragment(self, label):
        """The path of what the overlay adds to this label."""
        fixups = self.get("/__fixups__", label, "s")
        paths = [one.split(":")[0] for one in fixups if one.endswith(":target:0")]
        self.assertEqual(len(paths), 1, label)
        return paths[0] + "/__overlay__"

    def test_the_board_takes_the_configuration(self):
        for argument in "/dev/watchdog", "/dev/none":
            ended = subprocess.run([BIN / "thimble-board", "--config", BUILDS / self.name / "board.json", "--uses", argument],
                                   capture_output=True, text=True, check=False)
            self.assertEqual(ended.returncode, 0 if argument == "/dev/watchdog" else 3, ended.stderr)


class BeagleBone(Build):
    name = "beaglebone"

    def pins(self):
        """Offset -> settings and mode, of every pad that the overlay sets."""
        overlay = self.fragment("am33xx_pinmux")
        pins = {}
        for group in "eqep", "spi", "can", "line":
            cells = self.get(f"{overlay}/thimble-{group}-pins", "pinctrl-single,pins")
            self.assertEqual(len(cells) % 3, 0)
            for offset, settings, mode in zip(cells[::3], cells[1::3], cells[2::3]):
                self.assertNotIn(offset, pins)
                pins[offset] = (settings, mode)
        return pins

    def test_pads_are_those_of_the_table(self):
        pins = self.pins()
        seen = set()
        for pin, pad, *_ in self.rows:
            if pin not in PADS:
                self.assertRegex(pad, "GND|3.3 V")
                continue
            name, offset, mode = PADS[pin]
            self.assertEqual(pad, name, pin)
            self.assertEqual(pins[offset][1], mode, pin)
            output = re.search(r"SPI0_(SCLK|D1|CS0)|_TX", pad) or pin in ("P9_12", "P9_15")
            if pad != "SPI0_SCLK":  # its input is needed: the controller reads the clock back
                self.assertEqual(bool(pins[offset][0] & INPUT), not output, pin)
            seen.add(offset)
        self.assertEqual(set(pins) - seen, {0x164})  # the second pad of P9_42
        self.assertEqual(pins[0x164], (INPUT | NO_PULL, 7))

    def test_names_of_lines(self):
        names = self.get(self.fragment("gpio1"), "gpio-line-names", "s")
        self.assertEqual(len(names), 32)
        wanted = lines_of(self.config)
        self.assertEqual({name for name in names if name}, set(wanted))
        for pin, pad, _, line in self.rows:
            if pad.startswith("gpio1_"):
                self.assertEqual(names[int(pad.removeprefix("gpio1_"))], code(line)[0], pin)
        self.assertEqual({code(row[3])[0] for row in self.rows if row[1].startswith("gpio1_")}, set(wanted))

    def test_pulls_make_an_open_wire_an_open_contact(self):
        pins = self.pins()
        for pin, _, _, line in self.rows:
            for key in "e_stop", "dead_man":
                if code(line) == [self.config[key]["line"]]:
                    up = self.config[key]["closed"] == "low"
                    self.assertEqual(pins[PADS[pin][1]][0], INPUT | (PULL_UP if up else 0), pin)

    def test_devices(self):
        # The eQEP units of the AM335x are at these addresses: their names in sysfs.
        addresses = {"eqep0": "48300180", "eqep1": "48302180", "eqep2": "48304180"}
        joints = self.config["arms"][0]["encoders"]["joints"]
        for unit, (label, address) in enumerate(addresses.items()):
            self.assertEqual(self.get(self.fragment(label), "status", "s"), ["okay"])
            self.assertEqual(self.get(self.fragment(f"epwmss{unit}"), "status", "s"), ["okay"])
            self.assertEqual(joints[unit], {"counter": f"{address}.counter", "count": 0})
            for channel in "AB":
                row = next(row for row in self.rows if row[1] == f"eQEP{unit}{channel}_in")
                self.assertEqual(code(row[3]), [f"{address}.counter"])
                self.assertEqual(row[2], f"encoder {unit + 1} {channel}")
        converter = self.fragment("spi0") + "/converter@0"
        dac = self.config["arms"][0]["dac"]
        self.assertEqual(dac["spi"], f"/dev/spidev0.{self.get(converter, 'reg')[0]}")
        self.assertEqual(self.get(converter, "spi-max-frequency"), [dac["speed_Hz"]])
        self.assertEqual(self.get(self.fragment("dcan1"), "status", "s"), ["okay"])
        self.assertEqual({code(row[3])[0] for row in self.rows if row[1].startswith("DCAN1")}, {self.config["links"][0]["can"]})

    def test_the_amplifiers_take_the_peak_current(self):
        peak_A = 5.51  # of the Premium's motors
        for channel in self.config["arms"][0]["dac"]["channels"]:
            self.assertLess(channel["volts_per_ampere"] * peak_A, 10)


class RaspberryPi(Build):
    name = "raspberry-pi"

    def test_pins_are_those_of_the_table(self):
        named = {}
        for pin, signal, line in self.rows:
            number = re.match(r"GPIO(\d+)", signal)
            if not number:
                self.assertRegex(signal, "GND|3.3 V|5 V")
                continue
            self.assertEqual(PI_PINS[pin], int(number[1]), pin)
            if code(line)[0].startswith("GPIO"):
                self.assertEqual(code(line)[0], number[0])
                named[number[0]] = pin
        self.assertEqual(set(named), set(lines_of(self.config)))

    def test_overlay(self):
        pins = self.fragment("gpio") + "/thimble-pins"
        numbers, pulls = self.get(pins, "brcm,pins"), self.get(pins, "brcm,pull")
        self.assertEqual(self.get(pins, "brcm,function"), [0] * len(numbers))
        pull = dict(zip(numbers, pulls))
        for key in "e_stop", "dead_man":
            line = self.config[key]
            self.assertEqual(pull[int(line["line"].removeprefix("GPIO"))], 2 if line["closed"] == "low" else 1, key)
        chip = self.fragment("spi0") + "/can@0"
        self.assertEqual(self.get(chip, "compatible", "s"), ["microchip,mcp2518fd"])
        interrupt = self.get(chip, "interrupts")[0]
        self.assertEqual(pull[interrupt], 2)
        self.assertIn(interrupt, PI_PINS.values())
        self.assertEqual(self.get(self.fragment("spidev0"), "status", "s"), ["disabled"])

    def test_drives(self):
        drives = self.config["arms"][0]["drives"]
        self.assertEqual([drive["id"] for drive in drives], [1, 2, 3])
        readme = (BUILDS / self.name / "README.md").read_text()
        for drive in drives:
            self.assertIn(f"conf set servo.default_timeout_s {drive['watchdog_ms'] / 1000:g}\n", readme)
            self.assertIn(f"conf set servo.pid_position.kd {drive['kd_N_m_s_turn']:g}\n", readme)
            for item in drive["configuration"]:
                self.assertIn(f"conf set {item['name']} {item['value']:g}\n", readme)
            self.assertIn(drive["can"], {code(row[2])[0] for row in self.rows if code(row[2])})


if __name__ == "__main__":
    unittest.main()
