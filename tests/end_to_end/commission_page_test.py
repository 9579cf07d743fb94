"""thimble commission --page: a simulated arm is commissioned by the WebSocket of its page."""

import json
import math
import os
import shutil
import subprocess
import unittest
from pathlib import Path

from rig import BIN, Rig
from web_client import Page, http

ARMS = Path(__file__).parents[2] / "arms"
UNDER_SANITIZERS = "THIMBLE_UNDER_SANITIZERS" in os.environ


class Session:
    """A running commissioning with a page, of a simulated arm without a device; its terminal has no input unless told."""

    def __init__(self, rig, arm, *arguments, device=None, stdin=subprocess.DEVNULL):
        self.arm = Path(shutil.copy(ARMS / (arm + ".arm.json"), rig.runtime))
        where = ["--device", device] if device else ["--simulate"]
        self.process = subprocess.Popen([BIN / "thimble", "commission", self.arm, "--page", "--no-browser", *where, *map(str, arguments)], stdin=stdin, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=rig.environment)
        rig.addCleanup(self.kill)
        line = self.process.stderr.readline()
        assert line.startswith("page: http://127.0.0.1:"), line + self.process.stderr.read()
        self.url = line.split()[1]
        self.port = int(self.url.split("/")[2].rsplit(":", 1)[1])
        self.token = self.url.partition("?token=")[2]

    def kill(self):
        if self.process.poll() is None:
            self.process.kill()
            self.process.communicate()

    def end(self, seconds=60):
        out, err = self.process.communicate(timeout=seconds)
        return self.process.returncode, out, err


class CommissionPage(Rig):
    def open(self, session, token=None):
        page = Page(session.port, token)
        self.addCleanup(page.close)
        return page

    def prompt(self, page, wanted=lambda prompt: True):
        return page.state(lambda state: "prompt" in state["commission"] and wanted(state["commission"]["prompt"]), what="prompt")

    def answer_all(self, page, decline=lambda commission: False):
        """Until it is over: all states with a new prompt, and the last one."""
        answered, seen = set(), []
        while True:
            state = page.state(lambda s: "over" in s["commission"] or s["commission"].get("prompt", {}).get("number", 0) not in answered | {0},
                               seconds=60)
            seen.append(state)
            if "over" in state["commission"]:
                return seen
            prompt = state["commission"]["prompt"]
            answered.add(prompt["number"])
            page.send(type="answer", prompt=prompt["number"], answer="decline" if decline(state["commission"]) else "done")

    @unittest.skipIf(UNDER_SANITIZERS, "all steps take a minute and more there")
    def test_all_steps_by_the_page_alone(self):
        session = Session(self, "paddle", "--fault", "motor-sign@paddle")
        page = self.open(session, session.token)
        hello = page.receive()
        self.assertTrue(hello["simulated"] and hello["may_control"])
        self.assertEqual([step["name"] for step in hello["commission"]["steps"]][::5], ["lines", "motors", "walls"])
        self.assertEqual(http(session.port, "/")[0], 200)

        # The motor's sign is no fault of the file; it is repaired.
        seen = self.answer_all(page, lambda commission: commission["prompt"].get("decline") == "No")
        last = seen[-1]["commission"]
        code, out, err = session.end()
        self.assertEqual(code, 0, err)
        self.assertIn("paddle: all steps passed, 0 corrections", out)
        self.assertTrue(last["over"]["passed"])
        self.assertIn("paddle.commissioned.arm.json", last["over"]["text"])
        self.assertEqual({step["state"] for step in last["steps"]}, {"passed"})
        found = [state["commission"]["steps"][5] for state in seen if state["commission"]["steps"][5]["state"] == "found"]
        self.assertEqual(found[0]["findings"][0]["name"], "motor-sign")
        self.assertIn("xchange the wires of the motor", found[0]["findings"][0]["text"])

        repair = [state["commission"] for state in seen if state["commission"].get("prompt", {}).get("text", "").startswith("Repair it")]
        self.assertEqual([commission["axis"]["name"] for commission in repair], ["paddle"])

        # The paddle turns about y: its tip, 7 cm above, goes along +x, and first that way.
        turn = next(state["commission"] for state in seen if "turn" in state["commission"])
        self.assertEqual((turn["axis"]["name"], turn["axis"]["slides"], turn["turn"]), ("paddle", False, 1))
        self.assertEqual((turn["axis"]["direction"], turn["way"]), ([0, 1, 0], [1, 0, 0]))
        back = [state["commission"]["way"] for state in seen if state["commission"].get("turn") == -1]
        self.assertEqual(back[0], [-1, 0, 0])
        self.assertFalse(seen[0]["commission"]["is_live"])
        # Later it follows: before a push the arm is where it was to be brought, but for what the hands miss by (5 mrad, 0.35 mm).
        brought = [(before["commission"]["goal_m"][-1][-1], state["arms"][0]["tip_m"]) for before, state in zip(seen, seen[1:])
                   if state["commission"].get("prompt", {}).get("text", "").startswith("Push") and "goal_m" in before["commission"]]
        self.assertGreater(len(brought), 5)
        for goal_m, tip_m in brought:
            self.assertLess(math.dist(goal_m, tip_m), 1e-3)
        self.assertEqual({state["commission"]["is_live"] for state in seen[-20:]}, {True})

    def test_without_the_token_a_page_may_look_and_stop(self):
        session = Session(self, "paddle")
        stranger = self.open(session)
        guess = self.open(session, "0" * len(session.token))
        owner = self.open(session, session.token)
        first = self.prompt(stranger)["commission"]["prompt"]
        self.assertEqual(first["text"], "Press the e-stop.")
        for page in stranger, guess:
            page.send(type="answer", prompt=first["number"], answer="done")
            page.event("read-only")
        self.assertEqual(self.prompt(owner)["commission"]["prompt"], first)
        # What is not offered, what is no prompt, and what belongs to `thimble view`.
        owner.send(type="answer", prompt=first["number"], answer="decline")
        owner.event("not-offered")
        owner.send(type="answer", prompt=first["number"] + 1, answer="done")
        owner.event("too-late")
        owner.send(type="command", verb="arm")
        owner.event("not-here")
        owner.send(type="answer", prompt=first["number"], answer="done")
        second = self.prompt(owner, lambda prompt: prompt["number"] != first["number"])["commission"]["prompt"]
        another = self.open(session, session.token)
        another.send(type="answer", prompt=first["number"], answer="done")
        another.event("too-late")
        # As `thimble view` has it: anybody may stop.
        self.assertEqual(self.prompt(another)["commission"]["prompt"], second)
        stranger.send(type="command", verb="stop")
        over = owner.state(lambda state: "over" in state["commission"])["commission"]["over"]
        self.assertFalse(over["passed"])
        self.assertIn("stopped in step 0", over["text"])
        code, out, err = session.end()
        self.assertEqual((code, out), (1, ""))
        self.assertIn("thimble: interrupted: stopped in step 0; ", err)

    def test_terminal_and_page_answer_the_same_prompts(self):
        session = Session(self, "paddle", stdin=subprocess.PIPE)
        page = self.open(session, session.token)
        first = self.prompt(page)["commission"]["prompt"]["number"]
        session.process.stdin.write("\n")
        session.process.stdin.flush()
        second = self.prompt(page, lambda prompt: prompt["number"] != first)["commission"]["prompt"]["number"]
        page.send(type="answer", prompt=second, answer="done")
        self.prompt(page, lambda prompt: prompt["number"] > second)
        page.close()  # the terminal goes on without it
        session.process.stdin.write("\nq\n")
        code, out, err = session.end()
        self.assertEqual((code, out), (1, ""))
        self.assertIn("done, by the page", err)
        self.assertIn("stopped in step 1", err)

    def test_stop_on_the_page_switches_the_motors_of_a_device_off(self):
        sim = self.sim("--tcp", 0)
        session = Session(self, "premium-1.5", device=sim.tcp)
        page = self.open(session, session.token)
        self.prompt(page, lambda prompt: prompt["text"] == "Press the e-stop.")
        self.wait_for_mode(sim.tcp, "armed")
        page.send(type="command", verb="stop")
        page.state(lambda state: "over" in state["commission"])
        self.assertEqual(session.end()[0], 1)
        self.assertEqual(self.ok_json("info", "--device", sim.tcp)["state"]["mode"], "ready")

    def test_a_port_in_use_and_options_that_do_not_go_together(self):
        session = Session(self, "paddle")
        arm = shutil.copy(ARMS / "wooden.arm.json", self.runtime)
        used = self.run_thimble("commission", arm, "--simulate", "--page", "--no-browser", "--port", session.port)
        self.assertEqual((used.code, used.out), (1, ""))
        self.assertIn("thimble: port-in-use: cannot listen on 127.0.0.1 port %d" % session.port, used.err)
        self.assertIn("choose another with --port", used.err)
        self.assertFalse((self.runtime / "wooden.commission.json").exists())
        for words in (["--port", "0"], ["--page", "--accept-corrections"]):
            self.fails(2, "usage", "commission", arm, "--simulate", *words)
        result = self.run_thimble("commission", arm, "--simulate", "--page", "--json")
        self.assertEqual((result.code, result.out, json.loads(result.err)["error"]["name"]), (2, "", "usage"))


if __name__ == "__main__":
    unittest.main()
