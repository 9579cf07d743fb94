"""Uploads over a link that drops, repeats, reorders, truncates and delays frames, and images that were corrupted on disk. In every case
the old scene runs until the new one is complete."""

import json
import random
import time
import unittest

from rig import Rig, LinkFaults, figure


class UploadsWithLinkFaults(Rig):
    def setUp(self):
        super().setUp()
        self.device = self.sim("--no-pty", "--tcp", 0)
        uploaded = self.ok_json("upload", self.plane_scene(), "--device", self.device.tcp)
        self.before = ("floor", uploaded["bytes"], uploaded["crc"])
        self.assertEqual(self.running(self.device.tcp), self.before)

    def upload_through(self, faults, seed):
        proxy = self.proxy(self.device.port, faults, seed)
        image = self.image(self.ball_scene(30))
        process = self.start("upload", image, "--device", proxy.uri, "--json")
        # While it runs, looks from beside. They share the bus and the services with the upload, which is trouble of its own.
        for _ in range(3):
            time.sleep(0.4)
            name, *rest = self.running(self.device.tcp)
            self.assertIn(name, ("floor", "ball"))
            if name == "floor":
                self.assertEqual((name, *rest), self.before)
        out, err = process.communicate(timeout=100)
        return process.returncode, out, err, proxy, image.stat().st_size - 8

    def one_kind(self, name, faults):
        code, out, err, proxy, size = self.upload_through(faults, seed=11)
        self.assertEqual(code, 0, err)
        result = json.loads(out)
        self.assertEqual(self.running(self.device.tcp), ("ball", size, result["crc"]))
        self.assertGreater(proxy.counts[name], 0)
        figure("%s: %d of %d frames, %d blocks repeated, %.1f s for %d bytes" %
               (name, proxy.counts[name], proxy.counts["frames"], result["retried_blocks"], result["seconds"], size))

    def test_dropped(self):
        self.one_kind("dropped", LinkFaults(drop=0.01))

    def test_repeated(self):
        self.one_kind("repeated", LinkFaults(repeat=0.01))

    def test_reordered(self):
        self.one_kind("reordered", LinkFaults(reorder=0.01))

    def test_truncated(self):
        self.one_kind("truncated", LinkFaults(truncate=0.01))

    def test_stalled(self):
        self.one_kind("stalled", LinkFaults(stall=0.003))

    def test_all_at_once(self):
        self.one_kind("dropped", LinkFaults(drop=0.004, repeat=0.004, reorder=0.004, truncate=0.004, stall=0.001))

    def test_a_link_that_dies_costs_nothing(self):
        """Too bad to carry anything: the upload ends in time with exit code 6, and goes on later where it was."""
        fair = self.proxy(self.device.port, LinkFaults(), 3)
        image = self.image(self.ball_scene(60))
        size = image.stat().st_size - 8
        fair.faults = LinkFaults(delay_s=0.001)
        process = self.start("upload", image, "--device", fair.uri, "--timeout", "0.5")
        for line in process.stderr:
            if int(line.split()[0]) >= 20:
                break
        fair.faults = LinkFaults(drop=1.0)
        _, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 6, err)
        self.assertIn("remedy: ", err)
        self.assertEqual(self.running(self.device.tcp), self.before)
        result = self.ok_json("upload", image, "--device", self.device.tcp)
        self.assertGreater(result["resumed_from"], 0)
        self.assertEqual(self.running(self.device.tcp), ("ball", size, result["crc"]))
        figure("link died; resumed at %d of %d bytes" % (result["resumed_from"], size))


class BadImages(Rig):
    def setUp(self):
        super().setUp()
        self.device = self.sim("--no-pty", "--tcp", 0)
        uploaded = self.ok_json("upload", self.plane_scene(), "--device", self.device.tcp)
        self.before = ("floor", uploaded["bytes"], uploaded["crc"])
        self.good = self.image(self.ball_scene(12)).read_bytes()

    def write(self, data):
        file = self.folder / "bad.thim"
        file.write_bytes(data)
        return file

    def test_every_flipped_bit_is_refused(self):
        draw = random.Random(5)
        places = [0, 4, 8 * (len(self.good) - 9) + 7] + [draw.randrange(8 * (len(self.good) - 8)) for _ in range(12)]
        for place in places:
            data = bytearray(self.good)
            data[place // 8] ^= 1 << place % 8
            result = self.run_thimble("upload", self.write(data), "--device", self.device.tcp)
            self.assertEqual(result.code, 8, result.err)
            self.assertIn("wrong-crc", result.err)
        self.assertEqual(self.running(self.device.tcp), self.before)
        figure("%d of %d flipped bits refused by the board" % (len(places), len(places)))

    def test_images_that_lie_about_their_crc_are_refused_by_the_check(self):
        """Flipped bits in an image without its trailer, so that the CRC fits: the scene check decides. What it takes, it runs."""
        plain = self.good[:-8]
        draw = random.Random(6)
        refused = 0
        places = [32, 39, 0, 1] + [draw.randrange(8 * len(plain)) for _ in range(12)]
        for place in places:
            data = bytearray(plain)
            data[place // 8] ^= 1 << place % 8
            result = self.run_thimble("upload", self.write(data), "--device", self.device.tcp)
            if 4 <= place // 8 < 8:  # the mark: not even sent
                self.assertEqual(result.code, 10, result.err)
                continue
            self.assertIn(result.code, (0, 1), result.err)
            if result.code == 1:
                refused += 1
                self.assertIn("refused", result.err)
        self.assertGreaterEqual(refused, 2, "the root's offset at least")
        self.ok("info", "--device", self.device.tcp)
        figure("%d of %d images with a changed bit and a fitting CRC refused" % (refused, len(places)))

    def test_truncated_images_are_refused(self):
        draw = random.Random(7)
        lengths = [1, 4, 40, len(self.good) // 2, len(self.good) - 40] + [draw.randrange(1, len(self.good) - 40) for _ in range(5)]
        for length in lengths:
            result = self.run_thimble("upload", self.write(self.good[:length]), "--device", self.device.tcp)
            self.assertEqual(result.code, 10 if length < 8 else 1, "%d bytes: %s" % (length, result.err))
            self.assertIn("is no scene image" if length < 8 else "refused", result.err)
        self.assertEqual(self.running(self.device.tcp), self.before)
        figure("%d truncated images refused" % len(lengths))

    def test_a_fresh_device_stays_without_a_scene(self):
        fresh = self.sim("--no-pty", "--tcp", 0)
        self.assertEqual(self.run_thimble("upload", self.write(self.good[:100]), "--device", fresh.tcp).code, 1)
        self.assertEqual(self.running(fresh.tcp), ("", 0, 0))


if __name__ == "__main__":
    unittest.main()
