"""Recordings of a device's ticks, as arrays."""

import functools
import io
import json
import os

import numpy

from . import _thimble
from ._arrays import frame_of, needs, to_pandas, unit_of
from ._error import Error


class Recording:
    """A recording of `thimble record` (docs/recording.md). path: its file, which is read and checked as a whole; the forces are computed by a replay
    when they are first asked for.

    about: a dict: tool, firmware, board, serial, arms (their models), scene (its name), scene_crc, rate_Hz, began_utc_s, end (why it ended), missing
    and dropped (ticks), events_missing, cut_bytes (of a file that was cut off)."""

    def __init__(self, path):
        self._path = os.fspath(path)
        self._recording = _thimble.Recording(self._path)
        self.about = json.loads(self._recording.about())

    def __repr__(self):
        return f"<thimble.Recording of '{self.about['scene']}', {len(self.ticks)} ticks at {self.about['rate_Hz']:.0f} Hz>"

    @property
    def scene(self):
        """The image of the scene, as bytes: for simulate() and Device.upload()."""
        return self._recording.scene()

    @property
    def parameters(self):
        """The device's parameters at the start, by name (docs/parameters.md has their units)."""
        return self._recording.parameters()

    @functools.cached_property
    def ticks(self):
        """The numbers of the recorded ticks, n. Where one is not its predecessor plus 1, ticks are missing."""
        return self._recording.ticks()

    @functools.cached_property
    def counts(self):
        """The low 16 bits of the encoders' counters in each tick: n x arms x 3."""
        return self._recording.counts()

    @property
    def checks(self):
        """What the device sent every 16 ticks and with each command: a structured array of tick, crc (CRC-32 of all forces so far), mode and command
        (their numbers in docs/link.md)."""
        return self._recording.checks()

    @property
    def events(self):
        """The events and the switches of the trial, one row each: a structured array of tick, time_s (since the beginning, as in rows), code (what was
        written) and kind (0: event, 1: trial). thimble.to_pandas() makes a table of it."""
        return self._recording.events()

    @property
    def frames(self):
        """The other frames that the device sent: a structured array of time_s (since the beginning, by the host's clock), id, size and data (8
        bytes), as docs/link.md explains them."""
        return self._recording.frames()

    @functools.cached_property
    def _replayed(self):
        rows, verdict = self._recording.replay()
        return rows, json.loads(verdict)

    @property
    def rows(self):
        """A row for each replayed tick and arm, with the fields of simulate(): time_s counts from the beginning of the recording, tip_m is where the
        encoders say. World frame. The replay ends where a tick is missing."""
        return self._replayed[0]

    @property
    def verdict(self):
        """What the replay found: a dict with exact (every force is the device's, to the bit), ticks, checks (that agreed), first_tick, exact_to,
        not_replayed, contact_ticks, peak_force_N; and differs_at or gap_at where there is such a tick."""
        return self._replayed[1]

    def to_pandas(self):
        """rows as a pandas.DataFrame, with the columns of `thimble replay --log`. Needs pandas (Debian: python3-pandas)."""
        return to_pandas(self.rows)

    def to_csv(self, path):
        """Writes rows to a CSV file at path, as `thimble replay --log` does: the same bytes."""
        self._recording.write_csv(self._apart(path))

    def to_hdf5(self, path):
        """Writes everything to an HDF5 file at path (docs/python.md describes it). Needs h5py (Debian: python3-h5py)."""
        h5py = needs("h5py", "python3-h5py")
        path = self._apart(path)
        rows = self.rows  # what cannot be replayed leaves no file
        whole_file = io.BytesIO()  # on a full disk the file at path stays as it was
        with h5py.File(whole_file, "w") as file:
            for key, value in self.about.items():
                file.attrs[key] = value
            for key, value in self.verdict.items():
                file.attrs["replay_" + key] = value
            for key, value in self.parameters.items():
                file.require_group("parameters").attrs[key] = value
            _put(file, "scene_image", numpy.frombuffer(self.scene, numpy.uint8), "1")
            _put(file, "ticks", self.ticks, "1")
            _put(file, "counts", self.counts, "count")
            events = self.events
            for field in events.dtype.names:
                _put(file, f"events/{field}", events[field], unit_of(field))
            for arm in range(len(self.about["arms"])):
                of_arm = rows[rows["arm"] == arm]
                for field in rows.dtype.names:
                    if field != "arm":
                        place = f"objects/{field.replace('.', '/')}" if "." in field else field
                        _put(file, f"arm{arm}/{place}", of_arm[field], unit_of(field), frame_of(field))
        _thimble.write_file(path, whole_file.getvalue())

    def _apart(self, path):
        path = os.fspath(path)
        if os.path.exists(path) and os.path.exists(self._path) and os.path.samefile(path, self._path):
            raise Error("same-file", f"{path} is the file that is read", "give the output another name", 2)
        return path


def _put(file, place, values, unit, frame=""):
    many = len(values) > 0
    made = file.create_dataset(place, data=values, compression="gzip" if many else None, shuffle=True if many else None)
    made.attrs["unit"] = unit
    if frame:
        made.attrs["frame"] = frame
