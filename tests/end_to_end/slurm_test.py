"""sweep --slurm on a cluster of one node: Debian's slurmctld, slurmd and munged, started here with files, ports and a key of their own, and stopped at the
end. As root, which the daemons demand."""

import ctypes
import os
import shutil
import signal
import socket
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

from rig import Rig, figure

PATIENCE_S = 120
CONFIGURATION = """
ClusterName=thimble
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ctld_port}
SlurmdPort={slurmd_port}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1,batch_sched_delay=1
MpiDefault=none
MailProg=/bin/true
ReturnToService=2
KillWait=2
SlurmdParameters=config_overrides
NodeName=node NodeHostname={host} NodeAddr=127.0.0.1 CPUs=4 State=UNKNOWN
PartitionName=all Nodes=node Default=YES MaxTime=INFINITE State=UP OverSubscribe=NO
"""


def free_ports(count):
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports


def end_with_me():
    """A daemon does not outlive a test that is killed: PR_SET_PDEATHSIG."""
    ctypes.CDLL(None).prctl(1, signal.SIGTERM)


class Cluster:
    def __init__(self, case):
        # A socket's path is short, and what munged reads is in folders of root's alone.
        self.folder = Path(tempfile.mkdtemp(prefix="slurm-"))
        self.case, self.daemons = case, []
        case.addClassCleanup(self.stop)
        for name in ("state", "spool"):
            (self.folder / name).mkdir(mode=0o700)
        key = self.folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)
        self.folder.chmod(0o755)  # munged demands that all can reach its socket
        ctld_port, slurmd_port = free_ports(2)
        self.configuration = self.folder / "slurm.conf"
        self.configuration.write_text(CONFIGURATION.format(host=socket.gethostname().split(".")[0], folder=self.folder,
                                                           ctld_port=ctld_port, slurmd_port=slurmd_port))
        self.environment = dict(os.environ, SLURM_CONF=str(self.configuration))
        self.start("/usr/sbin/munged", "--foreground", "--force", "--key-file", key, "--socket", self.folder / "munge.socket",
                   "--log-file", self.folder / "munged.log", "--pid-file", self.folder / "munged.pid", "--seed-file", self.folder / "munged.seed")
        self.wait(lambda: (self.folder / "munge.socket").exists(), "munged")
        self.start("/usr/sbin/slurmctld", "-D", "-i", "-f", self.configuration)
        self.start("/usr/sbin/slurmd", "-D", "-N", "node", "-f", self.configuration)
        self.wait(lambda: "idle" in self.ask("sinfo", "--noheader", "--format=%T"), "the node")

    def start(self, program, *arguments):
        log = open(self.folder / (Path(program).name + ".out"), "w")
        self.daemons.append(subprocess.Popen([program, *map(str, arguments)], stdout=log, stderr=log, stdin=subprocess.DEVNULL,
                                             env=self.environment, start_new_session=True, preexec_fn=end_with_me))
        log.close()

    def ask(self, *command):
        return subprocess.run(command, capture_output=True, text=True, env=self.environment, timeout=60).stdout

    def wait(self, condition, what):
        end = time.monotonic() + PATIENCE_S
        while not condition():
            if time.monotonic() > end or any(daemon.poll() is not None for daemon in self.daemons):
                raise AssertionError(what + " did not start:\n" + "".join(
                    "%s:\n%s\n" % (log.name, log.read_text()[-3000:]) for log in self.folder.glob("*.out")))
            time.sleep(0.1)

    def stop(self):
        if len(self.daemons) > 1:
            self.ask("scancel", "--user=root")
        for daemon in reversed(self.daemons):
            daemon.terminate()
            try:
                daemon.wait(timeout=20)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
        shutil.rmtree(self.folder, ignore_errors=True)


@unittest.skipUnless(os.getuid() == 0, "needs root")
class Slurm(Rig):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.cluster = Cluster(cls)

    def setUp(self):
        super().setUp()
        self.environment["SLURM_CONF"] = str(self.cluster.configuration)
        self.folder = self.runtime

    def plan(self, runs):
        self.plane_scene(offset_m=-0.005)
        (self.folder / "press.csv").write_text("time_s,x_m,y_m,z_m\n0,0,0,0\n0.1,0,0,-0.007\n0.4,0,0,-0.007\n")
        plan = self.folder / "a plan's.json"  # names that a shell would take apart
        plan.write_text("""{"thimble_sweep": 1, "name": "presses", "scene": "floor.scene.json", "path": "press.csv", "steady_s": 0.2,
            "vary": [{"what": "/objects/0/material/stiffness_N_m", "values": [500, 2000]},
                     {"what": "seed", "from": 1, "to": %d, "count": %d}]}""" % (runs // 2, runs // 2))
        whole = self.folder / "whole.csv"
        self.ok("sweep", plan, "--output", whole)
        return plan, whole

    def queue(self):
        return self.cluster.ask("squeue", "--noheader", "--array", "--format=%A %K %T").splitlines()

    def rows(self, out):
        return sum(file.read_bytes().count(b"\n") - 2 for file in out.parent.glob(out.name + ".runs.*"))

    def wait_for(self, condition, process):
        end = time.monotonic() + PATIENCE_S
        while not condition():
            self.assertIsNone(process.poll(), "it ended")
            self.assertLess(time.monotonic(), end)
            time.sleep(0.05)

    def test_the_same_bytes_as_here(self):
        plan, whole = self.plan(40)
        out = self.folder / "it's out.csv"
        begin = time.monotonic()
        for tasks, jobs in ((1, 1), (5, 1), (2, 2)):
            self.ok("sweep", plan, "--output", out, "--slurm", tasks, "--jobs", jobs)
            self.assertEqual(out.read_bytes(), whole.read_bytes())
            self.assertEqual([file.name for file in self.folder.glob("it's*")], [out.name], "nothing is left")
            out.unlink()
            self.assertEqual(self.queue(), [])
        figure("three job arrays in %.0f s" % (time.monotonic() - begin))
        self.ok("sweep", plan, "--output", whole, "--slurm", 3)  # all is there: no job

    def test_cancelled_and_killed_it_goes_on(self):
        plan, whole = self.plan(400)
        out = self.folder / "out.csv"
        with self.start("sweep", plan, "--output", out, "--slurm", 2) as process:
            self.wait_for(lambda: self.rows(out) > 10, process)
            process.send_signal(signal.SIGINT)
            _, err = process.communicate(timeout=PATIENCE_S)
            self.assertEqual(process.returncode, 1, err)
            self.assertIn("thimble: interrupted: ", err)
        end = time.monotonic() + PATIENCE_S
        while self.queue():
            self.assertLess(time.monotonic(), end, "the job was not cancelled")
            time.sleep(0.1)
        # A task that is killed.
        kept = self.rows(out)
        with self.start("sweep", plan, "--output", out, "--slurm", 2) as process:
            self.wait_for(lambda: self.rows(out) > kept + 10, process)
            self.cluster.ask("scancel", self.array_job() + "_1")
            _, err = process.communicate(timeout=PATIENCE_S)
            self.assertEqual(process.returncode, 1, err)
            self.assertIn("thimble: slurm-incomplete: ", err)
        missing = 400 - self.rows(out)
        self.assertGreater(missing, 0)
        figure("cancelled with %d of 400 runs, a task killed with %d missing" % (kept, missing))
        self.assertEqual(self.ok_json("sweep", plan, "--output", out)["run_now"], missing)
        self.assertEqual(out.read_bytes(), whole.read_bytes())

    def array_job(self):
        return self.cluster.ask("squeue", "--noheader", "--array", "--format=%F").split()[0]

    def test_what_slurm_refuses(self):
        plan, _ = self.plan(4)
        self.environment["SBATCH_PARTITION"] = "nowhere"
        error = self.fails(1, "slurm-refused", "sweep", plan, "--output", self.folder / "out.csv", "--slurm", 2)
        self.assertIn("partition", error["cause"])


if __name__ == "__main__":
    unittest.main()
