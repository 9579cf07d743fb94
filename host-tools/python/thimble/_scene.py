"""Scenes as dicts: compiled, and built by functions that know the keys of docs/scene-format.md."""

import collections.abc
import difflib
import inspect
import json
import math
import os

from . import _thimble
from ._arrays import of_numpy
from ._error import Error

_SCHEMA = json.loads(_thimble.scene_schema())["$defs"]
_NAME = "scene"  # of a dict, in messages


class SceneText:
    """A scene as the text of its file, where the paths in it begin, and its name in messages."""

    def __init__(self, scene, folder=None):
        self.is_dict = isinstance(scene, collections.abc.Mapping)
        if self.is_dict:
            self._no_numbers = []
            self.text = json.dumps(_plain(scene, "", self._no_numbers))
            self.name, self.folder = _NAME, os.fspath(folder or os.curdir)
        else:
            self.text = _thimble.read_text(os.fspath(scene))
            self.name, self.folder = os.fspath(scene), os.path.dirname(os.fspath(scene)) or os.curdir

    def image(self):
        try:
            image = _thimble.compile_text(self.text, self.name, self.folder)
        except Error as error:
            raise _without_lines(error) if self.is_dict else error from None
        if self.is_dict and self._no_numbers:  # where the format has a text
            raise Error("bad-value", f"{_NAME}: {self._no_numbers[0]} is no finite number", "give a text or a finite number", 10)
        return image

    def with_material(self, object, values):
        """The same with other numbers in the material of an object; all or none of them."""
        scene = json.loads(_thimble.plain_json(self.text))
        names = [each["name"] for each in scene["objects"]]
        if object not in names:
            raise KeyError(f"there is no object '{object}'" + _meant(object, names))
        numbers = [key for key, value in _SCHEMA["material"]["properties"].items() if value.get("type") == "number"]
        changed = SceneText.__new__(SceneText)
        changed.__dict__.update(self.__dict__)
        for key, value in values.items():
            _refuse_unknown("a material", key, numbers)
            if not math.isfinite(value):
                raise ValueError(f"{key} is {value}: give a finite number")
            changed.text = _thimble.with_material(changed.text, names.index(object), key, float(value))
        return changed


def _plain(value, place, no_numbers):
    """What JSON can hold: numpy's numbers and arrays as Python's, and as a word what is no finite number, so that the compiler says where it is. The
    places of these come into no_numbers, as JSON pointers; place: that of value."""
    if isinstance(value, collections.abc.Mapping):
        return {key: _plain(each, f"{place}/{key}", no_numbers) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(each, f"{place}/{i}", no_numbers) for i, each in enumerate(value)]
    if isinstance(value, float) and not math.isfinite(value):
        no_numbers.append(place)
        return str(value)
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if value is None or isinstance(value, (str, int, float)):
        return value
    try:
        return _plain(of_numpy(value), place, no_numbers)
    except TypeError:
        raise TypeError(f"{place} is {value!r}, which has no place in a scene") from None


def _without_lines(error):
    """A dict has no lines."""
    def plain(text):
        return text.replace(f"{_NAME}:1: ", f"{_NAME}: ")

    issues = [{**issue, "cause": plain(issue["cause"]), "line": 0} for issue in error.issues]
    return Error(error.name, plain(error.cause), error.remedy, error.exit_code, issues)


def taken(scene, folder=None):
    """A dict, a scene file (*.json), an image file or an image as (image, the CRC that an image file announces, the SceneText if it has one)."""
    if isinstance(scene, (bytes, bytearray, memoryview)):
        return bytes(scene), None, None
    if isinstance(scene, collections.abc.Mapping):
        text = SceneText(scene, folder)
        return text.image(), None, text
    image, crc = _thimble.load(os.fspath(scene))
    return image, crc, SceneText(scene) if os.fspath(scene).endswith(".json") else None


def compile(scene, *, folder=None):
    """Compiles a scene, a dict or the path of a scene file; returns its image as bytes, the same bytes as `thimble compile` without the trailer.
    folder: where the paths in a dict begin; default: the current one. Raises Error with all that is wrong in Error.issues."""
    return taken(scene, folder)[0]


def _meant(word, known):
    close = difflib.get_close_matches(word, known, 1)
    return f": did you mean '{close[0]}'?" if close else f"; there are {', '.join(known)}"


def _refuse_unknown(what, key, known):
    if key not in known:
        raise TypeError(f"{what} has no '{key}'" + _meant(key, list(known)))


def _explained(key, value, required):
    """A line of help for a key of the format."""
    limits = value.get("items", {}) if value.get("type") == "array" else value
    kinds = [each["$ref"].rpartition("/")[2] + "()" for each in (value, value.get("items", {}), *value.get("oneOf", [])) if "$ref" in each]
    parts = [value.get("description", "")]
    if kinds:
        parts.append(("A list of " if value.get("type") == "array" else "A ") + " or ".join(kinds).replace("pose()", "pose").replace("solid()", "shape") + ".")
    if "enum" in value:
        parts.append("One of " + ", ".join(value["enum"]) + ".")
    if value.get("type") == "array" and value.get("maxItems") == value.get("minItems"):
        parts.append(f"{value['minItems']} numbers.")
    if "minimum" in limits and "maximum" in limits:
        parts.append(f"From {limits['minimum']:g} to {limits['maximum']:g}.")
    parts.append("Required." if required else f"Default: {value['default']}." if "default" in value else "")
    return f"    {key}: " + " ".join(part for part in parts if part)


def _function(name, text, required, optional, make):
    """A function of these keys alone. required, optional: {key: its schema}."""
    keys = {**required, **optional}

    def build(*arguments, **values):
        for key in values:
            _refuse_unknown(name + "()", key, keys)
        bound = signature.bind(*arguments, **values)
        return make({key: value for key, value in bound.arguments.items() if value is not None})

    positional = [key for key in ("name",) if key in required]
    parameters = [inspect.Parameter(key, inspect.Parameter.POSITIONAL_OR_KEYWORD) for key in positional]
    parameters += [inspect.Parameter(key, inspect.Parameter.KEYWORD_ONLY) for key in required if key not in positional]
    parameters += [inspect.Parameter(key, inspect.Parameter.KEYWORD_ONLY, default=None) for key in optional]
    signature = inspect.Signature(parameters)
    build.__signature__ = signature
    build.__name__ = build.__qualname__ = name
    build.__module__ = "thimble"
    build.__doc__ = text + "\n\n" + "\n".join(_explained(key, value, key in required) for key, value in keys.items())
    return build


def _split(kind):
    properties = _SCHEMA[kind]["properties"]
    required = _SCHEMA[kind].get("required", [])
    return {key: properties[key] for key in required}, {key: value for key, value in properties.items() if key not in required}


_POSE = _SCHEMA["pose"]["properties"]


def _part(kind):
    """A function for a part of a scene: its dict."""
    text = _SCHEMA[kind].get("description", "")
    return _function(kind, f"The part '{kind}' of a scene, as a dict. {text}".strip(), *_split(kind), lambda values: values)


def _object(shape):
    """A function for an object with this shape: the dict of the object."""
    required, optional = _split(shape)
    of_object = _SCHEMA["object"]["properties"]

    def make(values):
        made = {"name": values.pop("name"), "shape": {shape: {}}}
        pose = {key: values.pop(key) for key in _POSE if key in values}
        for key in ("material", "body"):
            if key in values:
                made[key] = values.pop(key)
        made["shape"][shape] = values
        return {**made, "pose": pose} if pose else made

    material = {} if shape == "force_field" else {"material": of_object["material"]}
    text = _SCHEMA[shape].get("description", "")
    return _function(shape, f"An object with the shape '{shape}', as a dict. {text}".strip(),
                     {"name": of_object["name"], **material, **required},
                     {**optional, **_POSE, "body": {"description": "A body(): the object moves when it is pushed."}}, make)


def scene(name, *objects, materials=None, **values):
    """A scene with these objects, as a dict for compile(), simulate(), Sim and Device.upload().

    materials: {name: material()}, for objects to name. Other keys: description, gravity_m_s2 (three numbers, m/s2), tip_radius_m (m)."""
    known = [key for key in _SCHEMA["scene"]["properties"] if key not in ("$schema", "thimble_scene", "objects")]
    for key in values:
        _refuse_unknown("scene()", key, known)
    made = {"thimble_scene": 1, "name": name, **values, "objects": list(objects)}
    return {**made, "materials": dict(materials)} if materials else made


_SHAPES = list(_SCHEMA["shape"]["properties"])
_PARTS = [kind for kind in _SCHEMA if kind not in ("scene", "object", "shape", "solid", "pose", *_SHAPES)]
BUILDERS = {**{shape: _object(shape) for shape in _SHAPES}, **{kind: _part(kind) for kind in _PARTS}}
