"""Rows of a run for pandas and HDF5: what the fields are called in a table, and their units."""

_XYZ = {"tip_m": "tip_{}_m", "proxy_m": "proxy_{}_m", "force_N": "force_{}_N", "position_m": "{}_m", "velocity_m_s": "v{}_m_s",
        "spin_rad_s": "w{}_rad_s"}
_UNITS = (("_rad_s", "rad/s"), ("_m_s", "m/s"), ("_rad", "rad"), ("_J", "J"), ("_N", "N"), ("_m", "m"), ("_s", "s"))
_IN_OBJECT = ("depth_m", "x_m", "y_m", "q_m", "q_rad")


def of_numpy(value):
    """numpy's numbers and arrays as Python's; TypeError for all else, and for a longdouble, which stays one."""
    if hasattr(value, "tolist") and type(plain := value.tolist()) is not type(value):
        return plain
    raise TypeError(f"{value!r} is no number or array of numpy that Python has too")


def columns_of(field):
    """The columns of a field in the files of `thimble simulate --log`: "ball.position_m" is ball.x_m, ball.y_m, ball.z_m."""
    of, dot, quantity = field.rpartition(".")
    if quantity == "rotation":
        return [of + dot + component for component in ("qw", "qx", "qy", "qz")]
    if quantity in _XYZ:
        return [of + dot + _XYZ[quantity].format(axis) for axis in "xyz"]
    return [field]


def unit_of(field):
    return next((unit for ending, unit in _UNITS if field.endswith(ending)), "1")


def frame_of(field):
    """The frame of a vector or rotation, and of a coordinate; "": it has none."""
    quantity = field.rpartition(".")[2]
    if quantity in _XYZ or quantity == "rotation":
        return "world"
    return "object" if quantity in _IN_OBJECT else ""


def needs(module, package):
    """An optional module, or an ImportError that names the Debian package."""
    import importlib

    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise ImportError(f"this needs {module}: apt-get install {package}") from error


def to_pandas(rows):
    """A pandas.DataFrame of rows of simulate(), Sim.run() or Recording.rows: one column for each number, with the names of
    docs/cli.md#simulate. Needs pandas (Debian: python3-pandas)."""
    pandas = needs("pandas", "python3-pandas")
    table = {}
    for field in rows.dtype.names:
        columns = columns_of(field)
        for number, column in enumerate(columns):
            table[column] = rows[field] if rows[field].ndim == 1 else rows[field][:, number]
    return pandas.DataFrame(table)
