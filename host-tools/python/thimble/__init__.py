"""Thimble for Python: devices on the link, and the simulated arm.

    import thimble
    felt = thimble.simulate("scenes/walls/walls.scene.json", "scenes/walls/stroke.csv")
    felt["force_N"][:, 2].max()

    with thimble.connect() as device:          # or an address, or a name of thimble.discover()
        device.upload("scenes/asteroid/asteroid.scene.json")
        device.home()
        device.arm()
        rows = device.telemetry(seconds=2.0)   # time_s, arm, contacts, tip_m, force_N
        device.disarm()

Lengths in metres, forces in newtons, world frame (x to the right, y away from the user, z up). A force is what the device exerts on the hand.
Failures raise thimble.Error, with the name, cause, remedy and exit code of the command `thimble`.
"""

import os

from . import _thimble

__all__ = ["Arm", "Error", "Device", "Tip", "connect", "discover", "compile", "simulate"]


class Error(Exception):
    """What went wrong (name, cause) and what to do (remedy); exit_code as in docs/cli.md."""

    def __init__(self, name, cause, remedy, exit_code):
        super().__init__(f"{name}: {cause} ({remedy})")
        self.name, self.cause, self.remedy, self.exit_code = name, cause, remedy, exit_code


_thimble.set_error_class(Error)


def discover():
    """The devices found: a list of {"name", "kind", "arm", "uris"}."""
    return _thimble.discover()


def compile(scene):
    """Compiles a scene file; returns the image as bytes."""
    return _thimble.compile(scene)


def simulate(scene, path, *, rate_Hz=4000.0, arm="premium-1.5", ideal=False, seed=1):
    """Runs a scene on the simulated arm, faster than real time. Returns a structured array, one row per tick and arm: time_s, arm, contacts, tip_m,
    proxy_m (the god object) and force_N; then the columns of the scene as in `thimble simulate --log`: bounds (sweep_bound ...), moving objects
    ("ball.position_m", "ball.rotation" as w, x, y, z, "ball.velocity_m_s", "ball.spin_rad_s"), control elements ("knob.q_rad", "knob.on") and
    tissues ("skin.depth_m" ...). path: a CSV file, or an array of rows time_s, x_m, y_m, z_m[, arm]. ideal: the tip follows the path
    exactly, and the force does not act. arm: a simulated arm by its name, the path of an arm file or an arm image, or an Arm. The same arguments give the same bytes."""
    return _thimble.simulate(scene, path, rate_Hz, arm._arm if isinstance(arm, Arm) else os.fspath(arm), ideal, seed)


class Arm:
    """The numbers of an arm and its kinematics: Arm("arms/falcon.arm.json"), an arm image (*.tarm), or the name of a simulated arm
    ("premium-1.5"). World frame, with the tip at
    the origin when all axes are at home and the base as without a mounting. Angles of axes in rad, of a prismatic axis in m."""

    def __init__(self, arm):
        self._arm = _thimble.Arm(os.fspath(arm))

    def __repr__(self):
        return f"<thimble.Arm {self.name}, {len(self.axes)} axes>"

    @property
    def name(self):
        return self._arm.name

    @property
    def commissioned(self):
        """Whether its file has passed `thimble commission`, and nothing in it was changed since; False for a simulated arm by its name."""
        return self._arm.commissioned

    @property
    def axes(self):
        """A dictionary each: name, prismatic, driven, lower, upper, home, per_count (signed)."""
        return self._arm.axes

    @property
    def limits(self):
        """max_force_N, max_joint_speed_rad_s, tip_stiffness_N_m, supply_V, and largest_walls: the walls that the arm holds still, a list of (rate_Hz,
        damping_N_s_m, stiffness_N_m); [] if none is known."""
        return self._arm.limits

    @property
    def home(self):
        """The axes at home."""
        return [axis["home"] for axis in self._arm.axes]

    def tip_m(self, axes):
        """Where the tip is, at which the force acts (of a wrist without motors its gimbal). ValueError where the links do not meet."""
        return self._arm.tip_m(axes)

    def jacobian(self, axes):
        """d tip_m / d axes, 3 x axes: jacobian @ speeds is the velocity of the tip, jacobian.T @ force_N are the torques of the axes."""
        return self._arm.jacobian(axes)

    def rotation(self, axes):
        """The orientation of the last link of a chain or a wrist, 3 x 3: rotation @ v is a vector of the link in the world. With the last point of links()
        it is the pose of an arm with six degrees of freedom; the unit matrix for an arm that has neither."""
        return self._arm.rotation(axes)

    def links(self, axes):
        """The links as lines from joint to joint, from the base on: a list of arrays of points, one for each leg or chain."""
        return self._arm.links(axes)


def connect(device="", *, node=1, timeout_s=2.0, key=""):
    """A Device by its address (can:can0, slcan:/dev/ttyACM0, tcp:127.0.0.1:29536) or name; without one the only device found. key: the file with
    the key of a device that has one; default: that of `thimble`."""
    return Device(device, node, timeout_s, key)


class _Parameters:
    """device.parameters["max_force"]: read and written on the device; iterating gives the names."""

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
    """A fingertip in one tick: tip_m and force_N (arrays of three; the force that the device exerts, after all limits), limiters (the bits that
    acted), sequence (counts readings, modulo 256), and age_s (since it arrived)."""

    __slots__ = ("tip_m", "force_N", "limiters", "sequence", "heard_s")

    def __init__(self, tip_m, force_N, limiters, sequence, heard_s):
        self.tip_m, self.force_N, self.limiters, self.sequence, self.heard_s = tip_m, force_N, limiters, sequence, heard_s

    @property
    def age_s(self):
        return _thimble.now_s() - self.heard_s


class Device:
    """A device on the link. One thread at a time; `with` closes it. Closing does not disarm: the scene runs on the controller."""

    def __init__(self, device="", node=1, timeout_s=2.0, key=""):
        self._connection = _thimble.Connection(device, node, timeout_s, key)
        self.parameters = _Parameters(self._connection)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self._connection.close()

    @property
    def info(self):
        """Versions, scene, mode, fault and counters at this moment."""
        return self._connection.info()

    def upload(self, scene):
        """Sends a scene file (*.json) or an image, and runs it."""
        return self._connection.upload(scene)

    def home(self):
        self._connection.home()

    def arm(self):
        self._connection.arm()

    def disarm(self):
        self._connection.disarm()

    def stop(self):
        """The e-stop frame, repeated until the device confirms it: every device on the bus brakes and switches its motors off."""
        self._connection.stop()

    def telemetry(self, seconds):
        """The telemetry of the given time: a structured array of time_s (this machine's clock, from the call on), arm, contacts, tip_m and force_N."""
        return self._connection.telemetry(seconds)

    def take_over(self, readings_per_s=1000.0):
        """From now on this program gives the forces instead of the scene (docs/host-rendering.md); arms. The device must be homed and at rest."""
        self._connection.take_over(readings_per_s)

    def next_tip(self, timeout_s=0.1, arm=0):
        """The newest Tip that has not been returned yet; None if no reading came within timeout_s."""
        reading = self._connection.next_tip(timeout_s, arm)
        return None if reading is None else Tip(*reading)

    def order_force(self, force_N, arm=0):
        """Sets the force on the hand, world frame. It acts for at most 20 ms; then the tip is damped until the next one."""
        self._connection.order_force(force_N, arm)

    def render(self, force, seconds, arm=0):
        """Calls order_force(force(tip)) for every Tip, for the given time. Returns the number of forces sent."""
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
        """Counts since the start of the device: forces applied, skipped as old or wrong, and expired."""
        return self._connection.orders()

    @property
    def faults(self):
        """Names of the faults since the last clear."""
        return self._connection.faults()

    def audit(self):
        """The audit record, the oldest entry first: a list of {"event", "host", "text", "utc_s", "start", "uptime_s", "detail", "value", "left_out",
        "number"}, as AuditRecord of docs/link.md. text is how the host calls itself, which proves nothing; utc_s is 0 where the time was not known."""
        return self._connection.audit()

    def clear_faults(self):
        self._connection.clear_faults()

    def inject(self, fault, *, arm=0, joint=None, value=0.0, force_N=(0.0, 0.0, 0.0), for_s=None):
        """Breaks the hardware of a simulated device from now on: a fault by its name in docs/safety.md, of one joint of an arm or of all (None), with
        its value in the unit of that table, for so many seconds or for good (None). force_N: of "hand-pushes", world frame. A real device
        raises Error "not-simulated"."""
        self._connection.inject(fault, arm, joint, value, force_N, for_s)

    def keep_alive(self):
        """Tells the device that this program is alive; needed if the parameter host_supervision is set."""
        self._connection.keep_alive()
