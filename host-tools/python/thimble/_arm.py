"""Arms and their kinematics."""

import os

from . import _thimble


class Arm:
    """The numbers of an arm and its kinematics. arm: an arm file ("arms/falcon.arm.json"), an arm image (*.tarm), or the name of a simulated arm
    ("premium-1.5"). World frame, with the tip at the origin when all axes are at home and the base as without a mounting. Angles of axes in rad, of a
    prismatic axis in m."""

    def __init__(self, arm):
        self._arm = _thimble.Arm(os.fspath(arm))

    def __repr__(self):
        return f"<thimble.Arm {self.name}, {len(self.axes)} axes>"

    @property
    def name(self):
        """The name of the arm, as its file or image has it."""
        return self._arm.name

    @property
    def commissioned(self):
        """Whether its file has passed `thimble commission`, and nothing in it was changed since; False for a simulated arm by its name."""
        return self._arm.commissioned

    @property
    def axes(self):
        """A dict for each axis: name, prismatic, driven, lower, upper and home (rad; m if prismatic), per_count (rad or m, signed)."""
        return self._arm.axes

    @property
    def limits(self):
        """What the arm can do, a dict: max_force_N, max_joint_speed_rad_s, tip_stiffness_N_m, supply_V, and largest_walls: the walls that the arm holds still, a list of (rate_Hz,
        damping_N_s_m, stiffness_N_m); [] if none is known."""
        return self._arm.limits

    @property
    def home(self):
        """The axes at home, a list (rad; m of a prismatic axis)."""
        return [axis["home"] for axis in self._arm.axes]

    def tip_m(self, axes):
        """Where the tip is, 3 numbers in m, with these axes (rad; m of a prismatic axis): where the force acts (of a wrist without motors its gimbal).
        ValueError where the links do not meet."""
        return self._arm.tip_m(axes)

    def jacobian(self, axes):
        """d tip_m / d axes, 3 x axes: jacobian @ speeds is the velocity of the tip, jacobian.T @ force_N are the torques of the axes."""
        return self._arm.jacobian(axes)

    def rotation(self, axes):
        """The orientation of the last link of a chain or a wrist, 3 x 3: rotation @ v is a vector of the link in the world. With the last point of links()
        it is the pose of an arm with six degrees of freedom; the unit matrix for an arm that has neither. axes: rad, m."""
        return self._arm.rotation(axes)

    def links(self, axes):
        """The links as lines from joint to joint, from the base on: a list of arrays n x 3 of points in m, one for each leg or chain, with these axes
        (rad, m)."""
        return self._arm.links(axes)
