"""Devices on the link."""

from . import _thimble
from ._scene import taken
from ._whole import whole


def discover():
    """The devices found: a list of {"name", "kind", "arm", "uris"}."""
    return _thimble.discover()


def connect(device="", *, node=1, timeout_s=2.0, key=""):
    """A Device by its address (can:can0, slcan:/dev/ttyACM0, tcp:127.0.0.1:29536) or its name in discover(); without one the only device found.
    node: its number on the bus. timeout_s: how long to wait for an answer, in all attempts. key: the file with the key of a device that has one;
    default: that of `thimble`."""
    return Device(device, node, timeout_s, key)


class _Parameters:
    """device.parameters["max_force"]: read and written on the device; iterating gives the names. Units and limits: docs/parameters.md."""

    def __init__(self, connection):
        self._connection = connection

    def __getitem__(self, name):
        return self._connection.read_parameter(name)

    def __setitem__(self, name, value):
        self._connection.write_parameter(name, value)

    def __iter__(self):
        return iter(self._connection.parameters())

    def __len__(self):
        return len(self._connection.parameters())


class Tip:
    """A fingertip in one tick, world frame: tip_m (3 numbers, metres), force_N (3 numbers, newtons: the force that the device exerts on the hand, after
    all limits), limiters (the bits that acted), sequence (counts readings, modulo 256), heard_s (when it arrived, by this machine's monotonic
    clock) and age_s (since then)."""

    __slots__ = ("tip_m", "force_N", "limiters", "sequence", "heard_s")

    def __init__(self, tip_m, force_N, limiters, sequence, heard_s):
        self.tip_m, self.force_N, self.limiters, self.sequence, self.heard_s = tip_m, force_N, limiters, sequence, heard_s

    @property
    def age_s(self):
        """Seconds since the reading arrived."""
        return _thimble.now_s() - self.heard_s


class Device:
    """A device on the link: connect() makes it, with the same device, node, timeout_s (seconds) and key. One thread at a time; `with` closes it. Closing
    does not disarm: the scene runs on the controller. parameters["max_force"] reads and writes a parameter (docs/parameters.md has names, units and
    limits). Metres, newtons, world frame. What the device refuses raises Error "refused" with the reason."""

    def __init__(self, device="", node=1, timeout_s=2.0, key=""):
        self._connection = _thimble.Connection(device, node, timeout_s, key)
        self._text = None  # of the scene that this program has sent, if it was no image
        self.parameters = _Parameters(self._connection)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """Closes the link. The device goes on as it is."""
        self._connection.close()

    @property
    def info(self):
        """The device at this moment, a dict: arm, board, firmware, serial_number, scene (names); mode, key, commander, stopped_by, fault (None: none);
        inside, a list of (arm, name of a solid that its tip began inside of); arms; tick, tick_rate_Hz, worst_tick_s, overruns, work_units, most_work,
        put_off, contact_ticks, peak_force_N (counters, docs/link.md)."""
        return self._connection.info()

    def upload(self, scene):
        """Sends a scene, and runs it: a dict, the path of a scene file (*.json) or of an image, or an image (bytes). Returns {"bytes", "crc",
        "resumed_from", "rate_bytes_s"}."""
        image, crc, text = taken(scene)
        done = self._connection.upload(image, crc)
        self._text = text
        return done

    def set_material(self, object, **values):
        """Changes numbers of the material of an object, by its name, while the scene runs: set_material("wall", stiffness_N_m=400). Contacts stay; a
        force falls at once, and rises as far as the hand presses on. Keys and units: docs/scene-format.md#materials. The scene has to be one that
        this Device has uploaded from a dict or a scene file: it is compiled with the change and sent, and the file stays as it is."""
        if self._text is None:
            raise ValueError("upload the scene first, as a dict or a scene file")
        changed = self._text.with_material(object, values)
        done = self._connection.upload(changed.image(), None)
        self._text = changed
        return done

    def home(self):
        """Finds the arm's position, and waits until it has (at most 30 s). Ctrl-C ends it, and the arm is disarmed."""
        self._connection.home()

    def arm(self):
        """Forces on. The arm has to be homed."""
        self._connection.arm()

    def disarm(self):
        """Forces off: ramped down, then the motors are off."""
        self._connection.disarm()

    def stop(self):
        """The e-stop frame, repeated until the device confirms it: every device on the bus brakes and switches its motors off."""
        self._connection.stop()

    def telemetry(self, seconds):
        """The telemetry of the given time in seconds: a structured array, a row (n rows) for each force that came: time_s (this machine's clock, from
        the call on), arm, contacts (0 to 3), tip_m and force_N (n x 3)."""
        return self._connection.telemetry(seconds)

    def take_over(self, readings_per_s=1000.0):
        """From now on this program gives the forces instead of the scene (docs/host-rendering.md); arms. The device must be homed and at rest.
        readings_per_s: how many tips the device sends each second."""
        self._connection.take_over(readings_per_s)

    def next_tip(self, timeout_s=0.1, arm=0):
        """The newest Tip of an arm (0 or 1) that has not been returned yet; None if no reading came within timeout_s seconds."""
        reading = self._connection.next_tip(timeout_s, arm)
        return None if reading is None else Tip(*reading)

    def order_force(self, force_N, arm=0):
        """Sets the force on the hand of an arm (0 or 1): force_N, 3 numbers in newtons, world frame. It acts for at most 20 ms; then the tip is damped
        until the next one."""
        self._connection.order_force(force_N, arm)

    def render(self, force, seconds, arm=0):
        """Calls order_force(force(tip)) for every Tip of an arm (0 or 1), for so many seconds. force: a function of a Tip, which returns 3 numbers in
        newtons. Returns the number of forces sent."""
        orders, end_s = 0, _thimble.now_s() + seconds
        while (left_s := end_s - _thimble.now_s()) > 0:
            tip = self.next_tip(min(left_s, 0.1), arm)
            if tip is not None:
                self.order_force(force(tip), arm)
                orders += 1
        return orders

    def hand_back(self):
        """Disarms; from then on the scene gives the forces again."""
        self._connection.hand_back()

    @property
    def orders(self):
        """Counts since the start of the device, a dict: taken (forces applied), old and wrong (skipped), expired."""
        return self._connection.orders()

    @property
    def faults(self):
        """The names of the faults since the last clear, a list (docs/faults.md)."""
        return self._connection.faults()

    def audit(self):
        """The audit record, the oldest entry first: a list of {"event", "host", "text", "utc_s", "start", "uptime_s", "detail", "value", "left_out",
        "number"}, as AuditRecord of docs/link.md. text is how the host calls itself, which proves nothing; utc_s is 0 where the time was not known."""
        return self._connection.audit()

    def clear_faults(self):
        """Clears the faults, so that the arm can be armed again. A cause that is still there makes a new fault."""
        self._connection.clear_faults()

    def inject(self, fault, *, arm=0, joint=None, value=0.0, force_N=(0.0, 0.0, 0.0), for_s=None):
        """Breaks the hardware of a simulated device from now on: a fault by its name in docs/safety.md, of one joint of an arm or of all (None), with
        its value in the unit of that table, for_s seconds or for good (None). force_N: of "hand-pushes", 3 numbers, world frame. A real device
        raises Error "not-simulated"."""
        self._connection.inject(fault, arm, joint, value, force_N, for_s)

    def event(self, code):
        """Marks a tick with an event code (0 to 65535), and returns the number of that tick (its low 32 bits): the pulse at the board's event line
        begins in it, and a recording has it (docs/experiment.md#events-and-ticks). Events that follow each other at once have a tick each. A frame that is
        lost on the way marks no second tick."""
        return self._connection.mark("event", whole("code", code, 65535))

    def set_trial(self, trial):
        """From the next tick on the force fields of this trial act (0 to 255), without a ramp. Returns the number of that tick, which is marked as by
        event(). parameters["trial"] = trial does the same."""
        return self._connection.mark("trial", whole("trial", trial, 255))

    def keep_alive(self):
        """Tells the device that this program is alive; needed if the parameter host_supervision is set."""
        self._connection.keep_alive()
