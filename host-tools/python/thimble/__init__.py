"""Thimble for Python: devices on the link, the simulated arm, scenes and recordings.

    import thimble
    felt = thimble.simulate("scenes/walls/walls.scene.json", "scenes/walls/stroke.csv")
    felt["force_N"][:, 2].max()

    with thimble.connect() as device:          # or an address, or a name of thimble.discover()
        device.upload("scenes/asteroid/asteroid.scene.json")
        device.home()
        device.arm()
        rows = device.telemetry(seconds=2.0)   # time_s, arm, contacts, tip_m, force_N
        device.disarm()

    wall = thimble.box("wall", size_m=[0.1, 0.1, 0.02], material=thimble.material(stiffness_N_m=600))
    sim = thimble.Sim(thimble.scene("bench", wall), start_m=[0, 0, 0.02])
    sim.step([0, 0, 0.009], ticks=100)["force_N"]

    thimble.Recording("felt.rec").to_pandas()  # of `thimble record`

Lengths in metres, forces in newtons, world frame (x to the right, y away from the user, z up). A force is what the device exerts on the hand.
Failures raise thimble.Error, with the name, cause, remedy and exit code of the command `thimble`.
"""

from ._arm import Arm
from ._arrays import to_pandas
from ._device import Device, Tip, connect, discover
from ._error import Error
from ._recording import Recording
from ._scene import BUILDERS, compile, scene
from ._sim import Sim, simulate

globals().update(BUILDERS)  # box(), sphere(), material() ...: a function for each shape and part of a scene

__all__ = ["Arm", "Device", "Error", "Recording", "Sim", "Tip", "compile", "connect", "discover", "scene", "simulate", "to_pandas", *BUILDERS]

del BUILDERS
